// Draws every point of the bound page with `plot`, of plot_*.wgsl. `Launch` in src/methods/launch.rs puts THREADS,
// POINTS and IS_SPREAD in front, and repeats each line with $n for every point of a thread: all are
// loaded before the first is drawn, so that a thread waits for memory once. Neighbouring threads load
// neighbouring points.
//
// A block is what a workgroup draws. Spread out, blocks come from PLACES places of the page in turn. In the
// order of a file, all threads that run at a time would look at the same few pixels, find them empty, and
// queue for them.
const BLOCK: u32 = THREADS * POINTS;

fn block_of(line: u32) -> u32 {
    if !IS_SPREAD {
        return line;
    }
    let blocks = (page.len + BLOCK - 1u) / BLOCK;
    let columns = (blocks + PLACES - 1u) / PLACES;
    if line >= PLACES * columns {
        return blocks;
    }
    return (line % PLACES) * columns + line / PLACES;
}

fn draw_point(local: u32, position: vec3<i32>) {
    if local >= page.len {
        return;
    }
    let point = project(position);
    if point.is_inside {
        plot(u32(point.corner.y) * view.width + u32(point.corner.x), point.depth, page.first + local);
    }
}

@compute @workgroup_size(THREADS)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = block_of(group.y * groups.x + group.x) * BLOCK + thread;
    if first >= page.len {
        return;
    }
    let last = page.len - 1u;
    let position_$n = load_position(min(first + $nu * THREADS, last));
    draw_point(first + $nu * THREADS, position_$n);
}
