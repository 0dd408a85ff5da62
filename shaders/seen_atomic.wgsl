// What a pixel's depth was when last looked at, by the rules of WebGPU; for words of two 32-bit halves.
fn depth_seen(pixel: u32) -> u32 {
    return atomicLoad(&words[2u * pixel + 1u]);
}
