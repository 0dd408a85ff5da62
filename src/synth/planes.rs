//! The `planes` scene: twelve horizontal squares, stacked.
//!
//! Counted from the bottom (0), plane `p` is a square of side `4·(12 − p)` · 1,000 grid steps, centred
//! on the origin, and lies `2^p − 1` grid steps above plane 0: the gaps are 1, 2, 4, … 1,024
//! steps. With the default scale of 1 mm that is 48 m down to 4 m, and gaps of 1 mm up to 1.024 m. From above
//! every plane shows its rim, in its own colour ([`PLANE_COLORS`]), and hides what is below.
//! Point `i` lies on plane `i mod 12`, where the two-dimensional golden-ratio sequence puts it, so that any run of
//! points covers all planes evenly.

use super::{SynthPoint, noise::mix};

/// Number of planes.
pub const PLANES: u64 = 12;

/// Colour of each plane from the bottom, 16 bits per channel.
pub const PLANE_COLORS: [[u16; 3]; PLANES as usize] = [
    [0xe6e6, 0x1919, 0x4b4b],
    [0x3c3c, 0xb4b4, 0x4b4b],
    [0xffff, 0xe1e1, 0x1919],
    [0x4343, 0x6363, 0xd8d8],
    [0xf5f5, 0x8282, 0x3131],
    [0x9191, 0x1e1e, 0xb4b4],
    [0x4646, 0xf0f0, 0xf0f0],
    [0xf0f0, 0x3232, 0xe6e6],
    [0xbcbc, 0xf6f6, 0x0c0c],
    [0x0808, 0x8080, 0x8080],
    [0x9a9a, 0x6363, 0x2424],
    [0xfafa, 0xfafa, 0xfafa],
];

/// Height of a plane over plane 0, in grid steps.
pub const fn plane_height(plane: u64) -> i32 {
    (1 << plane) - 1
}

/// Side of a plane's square, in grid steps.
pub const fn plane_side(plane: u64) -> i32 {
    4_000 * (PLANES - plane) as i32
}

/// A box that holds every point, in grid steps.
pub(super) const BOUNDS: [[i32; 3]; 2] =
    [[-plane_side(0) / 2, -plane_side(0) / 2, 0], [plane_side(0) / 2, plane_side(0) / 2, plane_height(PLANES - 1)]];

/// Point `i`: grid steps from the scene's origin, and the rest of the point.
#[inline]
pub(super) fn point(seed: u64, i: u64) -> ([i32; 3], SynthPoint) {
    let (plane, number) = (i % PLANES, i / PLANES);
    // 2^64 divided by the plastic number and by its square; the seed and the plane shift the start.
    let start = mix(seed ^ plane);
    let x = number.wrapping_mul(0xc13f_a9a9_02a6_328f).wrapping_add(start);
    let y = number.wrapping_mul(0x91e1_0da5_c79e_7b1d).wrapping_add(mix(start));
    let side = plane_side(plane);
    let place = |fraction: u64| (((fraction >> 32) * side as u64) >> 32) as i32 - side / 2;
    let at = [place(x), place(y), plane_height(plane)];
    let rgb = PLANE_COLORS[plane as usize];
    let point = SynthPoint {
        rgb,
        nir: rgb[0],
        intensity: 5_000 * (plane as u16 + 1),
        return_number: 1,
        number_of_returns: 1,
        classification: 2,
        gps_time: i as f64 * 1e-6,
        point_source: plane as u16 + 1,
        ..SynthPoint::default()
    };
    (at, point)
}
