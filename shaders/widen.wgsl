// The positions of a page in the wide encoding, once a point lies outside of the box that the packed one was made
// for. Twin: `Packing::unpack` in src/store/packing.rs.
@group(0) @binding(0) var<storage, read_write> wide: array<u32>;
// Slots of the page that hold points, in x.
@group(0) @binding(1) var<uniform> stored: vec4<u32>;

@compute @workgroup_size(256)
fn widen(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = line_index(group, groups, local);
    if slot < stored.x {
        let position = bitcast<vec3<u32>>(load_position(slot));
        wide[3u * slot] = position.x;
        wide[3u * slot + 1u] = position.y;
        wide[3u * slot + 2u] = position.z;
    }
}
