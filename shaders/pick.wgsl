// The point that a pick takes: that of the nearest pixel that shows one, by distance, then depth, then place in
// the picture. Twin: src/render/cpu/pick.rs. Everything is compared as integers, so both say the same.
@group(0) @binding(0) var<storage, read> words: array<vec2<u32>>;

// Question and answer. In a storage buffer: lavapipe 22.3 would compile the kernel anew for each value of a uniform
// that a loop hangs on.
struct Pick {
    // Of the picture.
    width: u32,
    height: u32,
    // The pixel asked for, and how far from it, in pixels.
    x: u32,
    y: u32,
    reach: u32,
    // From here on the answer: the pixel in the order of the words, and its word.
    pixel: u32,
    slot: u32,
    depth: u32,
    record: u32,
    position_x: i32,
    position_y: i32,
    position_z: i32,
}
@group(0) @binding(1) var<storage, read_write> pick: Pick;

@group(1) @binding(3) var<storage, read> records: array<u32>;

const THREADS: u32 = 256u;
const NONE: u32 = 0xffffffffu;

struct Candidate {
    // Square of the distance.
    distance: u32,
    depth: u32,
    pixel: u32,
}
var<workgroup> best: array<Candidate, THREADS>;

fn is_nearer(a: Candidate, b: Candidate) -> bool {
    if a.distance != b.distance {
        return a.distance < b.distance;
    }
    if a.depth != b.depth {
        return a.depth < b.depth;
    }
    return a.pixel < b.pixel;
}

// One workgroup.
@compute @workgroup_size(THREADS)
fn pick_nearest(@builtin(local_invocation_index) thread: u32) {
    let reach = i32(pick.reach);
    let side = 2u * pick.reach + 1u;
    var own = Candidate(NONE, NONE, NONE);
    for (var i = thread; i < side * side; i += THREADS) {
        let step = vec2<i32>(i32(i % side) - reach, i32(i / side) - reach);
        let at = vec2<i32>(i32(pick.x), i32(pick.y)) + step;
        let distance = step.x * step.x + step.y * step.y;
        let is_inside = all(at >= vec2<i32>(0)) && at.x < i32(pick.width) && at.y < i32(pick.height);
        if is_inside && distance <= reach * reach {
            let pixel = u32(at.y) * pick.width + u32(at.x);
            let word = words[pixel];
            let candidate = Candidate(u32(distance), word.y, pixel);
            if word.x != NONE && is_nearer(candidate, own) {
                own = candidate;
            }
        }
    }
    best[thread] = own;
    workgroupBarrier();
    if thread != 0u {
        return;
    }
    for (var i = 1u; i < THREADS; i += 1u) {
        if is_nearer(best[i], own) {
            own = best[i];
        }
    }
    pick.pixel = own.pixel;
    pick.depth = own.depth;
    pick.slot = NONE;
    if own.pixel != NONE {
        pick.slot = words[own.pixel].x;
    }
}

// Once for each page, which must be bound.
@compute @workgroup_size(1)
fn pick_point() {
    let local = pick.slot - page.first;
    if pick.slot == NONE || local >= page.len {
        return;
    }
    let position = load_position(local);
    pick.record = records[local];
    pick.position_x = position.x;
    pick.position_y = position.y;
    pick.position_z = position.z;
}
