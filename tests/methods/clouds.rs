//! Clouds to draw, views of them, and the device to draw on.

use firstlight::{
    methods::{Cloud, Gpu},
    render::{Camera, View},
    scene::Grid,
};

pub const GRID: Grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };

/// The GPU at hand. Without one the test is skipped, loudly, or fails if FIRSTLIGHT_REQUIRE_GPU is set.
pub fn gpu() -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_GPU").is_none(), "a GPU is required: {error}");
            skipped(&error.to_string());
            None
        }
    }
}

/// Says so past the test harness, which shows only what failing tests print.
pub fn skipped(why: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "SKIPPED on a GPU: {why}");
}

/// A non-negative number that depends on `k` and `stream` in no visible way.
pub fn noise(k: usize, stream: u32) -> i32 {
    let mut x = (k as u32).wrapping_mul(0x9E37_79B9) ^ stream.wrapping_mul(0x85EB_CA6B);
    x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
    x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
    ((x ^ (x >> 15)) >> 1) as i32
}

/// A colour of its own for each point, the highest byte not zero.
pub fn color(k: usize) -> u32 {
    noise(k, 9) as u32 | 0x7700_0000
}

/// Points in a cube of 20 m around the origin, in no order; every tenth is there twice.
pub fn cube(points: usize) -> Cloud {
    let place = |k: usize| [0, 1, 2].map(|a| noise(k, a) % 20_000 - 10_000);
    let positions = (0..points).map(|k| place(if k % 10 == 9 { k - 1 - k % 7 } else { k })).collect();
    Cloud { positions, colors: (0..points).map(color).collect() }
}

/// Level ground of 20 m in scan lines, as a scanner would send it: neighbours fall into one pixel.
pub fn lines(points: usize) -> Cloud {
    let side = (points as f64).sqrt().ceil() as usize;
    let at = |i: usize| (i * 20_000 / side.max(1)) as i32 - 10_000;
    let place = |k: usize| [at(k % side), at(k / side), noise(k, 2) % 300];
    Cloud { positions: (0..points).map(place).collect(), colors: (0..points).map(color).collect() }
}

/// `points` points straight behind each other, 1 mm apart, the farthest first.
pub fn stacked(points: usize) -> Cloud {
    let positions = (0..points).map(|k| [0, points as i32 - k as i32, 0]).collect();
    Cloud { positions, colors: (0..points).map(color).collect() }
}

/// From the south and above; the whole of [`cube`] is in the picture.
pub fn overview(size: [u32; 2]) -> View {
    let camera = Camera { eye: [3.001_5, -25.0, 11.0], ..Default::default() };
    camera.view(&GRID, size, 1).unwrap()
}

/// From the middle of [`cube`]: half of it is behind the eye.
pub fn inside(size: [u32; 2]) -> View {
    let camera =
        Camera { eye: [0.0; 3], target: [1.0, 2.0, 0.1], up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() };
    camera.view(&GRID, size, 1).unwrap()
}

/// Along y, so that [`stacked`] falls into one pixel.
pub fn along_y(size: [u32; 2], distance: f64) -> View {
    let camera = Camera {
        eye: [0.000_3, -distance, 0.000_3],
        target: [0.000_3, 1000.0, 0.000_3],
        up: [0.0, 0.0, 1.0],
        fov_y_deg: 60.0,
        ..Default::default()
    };
    camera.view(&GRID, size, 1).unwrap()
}
