// Sums of a pixel, HQS: red, green, blue and fragments in 32 bits each.
@group(0) @binding(2) var<storage, read_write> sums: array<atomic<u32>>;

// `MOST_FRAGMENTS` in src/render/shading.rs: further ones are left out before 255 times as many would
// overflow; there is room for the million threads that may have looked at the same time.
const MOST_FRAGMENTS: u32 = 15u << 20u;

fn add_fragment(pixel: u32, color: vec3<u32>) {
    if atomicLoad(&sums[4u * pixel + 3u]) >= MOST_FRAGMENTS {
        return;
    }
    atomicAdd(&sums[4u * pixel], color.x);
    atomicAdd(&sums[4u * pixel + 1u], color.y);
    atomicAdd(&sums[4u * pixel + 2u], color.z);
    atomicAdd(&sums[4u * pixel + 3u], 1u);
}

fn sums_of(pixel: u32) -> vec4<u32> {
    let at = 4u * pixel;
    return vec4<u32>(atomicLoad(&sums[at]), atomicLoad(&sums[at + 1u]), atomicLoad(&sums[at + 2u]), atomicLoad(&sums[at + 3u]));
}
