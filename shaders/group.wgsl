// Threads of a dispatch numbered in one line. A dispatch has at most 65,535 groups per axis, so that
// large ones have rows of groups (`groups_for` in src/gpu/kernel.rs).
const GROUP: u32 = 256u;

fn line_index(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * GROUP + local;
}
