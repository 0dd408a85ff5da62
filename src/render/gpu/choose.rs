//! Which rasterizer: what the user asked for if the device can, else the faster one, measured.

use std::time::Instant;

use super::{GpuBackend, HardwareRaster};
use crate::{
    gpu::shaders,
    render::{Backend, Camera, FramePlan, Raster, RenderError, Shading},
    scene::{Bounds, Grid, PointBatch},
    store::Insertion,
};

/// Which rasterizer to use.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RasterChoice {
    /// The faster one, measured at start.
    #[default]
    Auto,
    /// Compute shaders; with 64-bit atomics where the device has them.
    Compute,
    /// Compute shaders with 32-bit atomics only.
    Compute32,
    /// Point-list draws.
    Hardware,
}

/// Points that the measurement draws: enough for a timestamp (30 µs at a billion points per second),
/// few enough that a software rasterizer, at some million points per second, does not delay the window.
const PROBE_POINTS: u32 = 30_000;
const PROBE_SIZE: [u32; 2] = [640, 360];

/// A backend with the rasterizer that `choice` asks for.
pub fn backend(
    adapter: &wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    choice: RasterChoice,
) -> Result<GpuBackend, RenderError> {
    let info = adapter.get_info();
    let compute = if device.features().contains(shaders::INT64_MIN_MAX) { Raster::Compute } else { Raster::Compute32 };
    let missing = HardwareRaster::missing(adapter);
    let raster = match (choice, missing) {
        (RasterChoice::Hardware, Some(missing)) => {
            let missing = missing.to_owned();
            return Err(RenderError::Unsupported { adapter: info.name, raster: Raster::Hardware, missing });
        }
        (RasterChoice::Hardware, None) => Raster::Hardware,
        (RasterChoice::Compute32, _) => Raster::Compute32,
        (RasterChoice::Compute | RasterChoice::Auto, _) => compute,
    };
    let mut backend = GpuBackend::with_raster(&info, device, queue, raster);
    if choice == RasterChoice::Auto && missing.is_none() {
        let compute_secs = probe(&mut backend)?;
        let computing = backend.set_raster(Raster::Hardware);
        let hardware_secs = probe(&mut backend)?;
        // Never one by the device's clock and one by the host's.
        let (by_compute, by_hardware) = match (compute_secs, hardware_secs) {
            ((_, Some(by_compute)), (_, Some(by_hardware))) => (by_compute, by_hardware),
            ((by_compute, _), (by_hardware, _)) => (by_compute, by_hardware),
        };
        log::info!("{PROBE_POINTS} points: {compute} {by_compute} s, hardware {by_hardware} s");
        if by_compute <= by_hardware {
            backend.put_back(compute, computing);
        }
        backend.reset(0);
    }
    Ok(backend)
}

/// Seconds to draw points spread over the picture, by the host's clock and, where there is one, by the
/// device's: the second of two frames, since drivers finish compiling in the first.
fn probe(backend: &mut GpuBackend) -> Result<(f64, Option<f64>), RenderError> {
    backend.reset(PROBE_POINTS.into());
    let insertion = Insertion::new(0, PROBE_POINTS, 0, 0);
    let side = 1000;
    let points = PointBatch {
        positions: (0..PROBE_POINTS)
            .map(|i| [0, 7, 13].map(|shift| (i.wrapping_mul(0x9E37_79B1).rotate_left(shift) % side).cast_signed()))
            .collect(),
        colors: vec![[0; 4]; PROBE_POINTS as usize],
        records: (0..PROBE_POINTS).collect(),
        ..Default::default()
    };
    backend.insert(&insertion, &points)?;
    let grid = Grid { scale: [1.0; 3], origin: [0.0; 3] };
    let bounds = Bounds { min: [0.0; 3], max: [f64::from(side); 3] };
    let camera = Camera::fit(&bounds, &grid, f64::from(PROBE_SIZE[0]) / f64::from(PROBE_SIZE[1]));
    let view = camera.view(&grid, PROBE_SIZE, 1).expect("a camera that fits a cube is valid");
    let plan = FramePlan {
        view,
        keeps_depths: false,
        averaging: None,
        reproject: false,
        fresh: false,
        fill: [0..PROBE_POINTS, 0..0],
        shading: Shading::default(),
        files: vec![],
    };
    let mut secs = (f64::INFINITY, None);
    for _ in 0..2 {
        let start = Instant::now();
        backend.draw(&plan)?;
        backend.wait()?;
        let wall_secs = start.elapsed().as_secs_f64();
        secs = (wall_secs, backend.pass_times().map(|times| times.fill).filter(|&secs| secs > 0.0));
    }
    Ok(secs)
}
