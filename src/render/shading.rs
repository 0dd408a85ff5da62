//! Lighting and averaging in numbers, shared by the backends.
//!
//! High-quality shading (Schütz and Wimmer 2019): a pixel shows the mean colour of all fragments that lie
//! no more than [`AVERAGED_DEPTH`] times as far as its front, in the same sense.
//!
//! Eye-dome lighting (Boucheny 2009): a pixel is darkened by how far it lies behind its neighbours.
//! Twin of `edl_shade` in `shaders/light.wgsl`.
//!
//! For a pixel at depth `z`, over its eight neighbours at depth `zₙ` (`point_size` pixels away, so
//! that they show other points; those outside of the picture and background do not count):
//!
//! ```text
//! response = Σ max(0, log2 z − log2 zₙ) = log2 Π max(1, z / zₙ)
//! shade    = exp2(−EDL_GAIN · strength · response)
//! channel  = ⌊channel · shade + ½⌋
//! ```
//!
//! Logarithms make the effect independent of the distance and of the file's unit. The product needs
//! one of them per pixel, the sum nine. Without perspective a step looks as high wherever it is: `z / zₙ` becomes
//! `1 + (z − zₙ) / z₆₀`, where `z₆₀` is the depth at which a perspective picture of 60° is as high. At the target
//! both projections light alike.

/// Scale of [`Shading::edl_strength`](super::Shading::edl_strength), chosen so that the default
/// strength outlines a statue and the ridges of a drone survey and leaves level ground its colours; a
/// quarter of it was hardly seen on either.
pub const EDL_GAIN: f32 = 20.0;

/// The neighbours that a pixel is compared with, as steps in x and y, in the order of the product.
pub fn edl_neighbours(point_size: u32) -> [[isize; 2]; 8] {
    let r = point_size.max(1) as isize;
    [[-r, -r], [0, -r], [r, -r], [-r, 0], [r, 0], [-r, r], [0, r], [r, r]]
}

/// No product exceeds this, so that none becomes infinite; the pixel is black long before.
const EDL_LIMIT: f32 = 1e30;

/// The product for one more neighbour, than which the pixel is so many times as far.
pub fn edl_product(product: f32, times_as_far: f32) -> f32 {
    (product * times_as_far.max(1.0)).min(EDL_LIMIT)
}

/// What the colour of a pixel with this product is multiplied by; 1 for strength 0.
pub fn edl_shade(product: f32, strength: f32) -> f32 {
    (-EDL_GAIN * strength * product.log2()).exp2()
}

/// Fragments up to this many times the front depth are averaged. `shaders/average.wgsl` has the same number.
pub const AVERAGED_DEPTH: f32 = 1.01;

/// About so many fragments of a pixel enter its sums, later ones are left out: 255 times as many, and those
/// of a million threads that looked before, fit into 32 bits. The mean of 15 million differs from that of
/// all by less than a colour level can show, unless the order of the points was chosen to.
pub const MOST_FRAGMENTS: u64 = 15 << 20;

/// The mean colour of the front point and the fragments in the sums (red, green, blue, number), rounded
/// to the nearest. Twin of `color_average` in `shaders/resolve_average.wgsl`.
pub fn average(front: [u8; 3], sums: [u64; 4]) -> [u8; 3] {
    let count = sums[3] + 1;
    [0, 1, 2].map(|channel| ((sums[channel] + u64::from(front[channel]) + count / 2) / count) as u8)
}
