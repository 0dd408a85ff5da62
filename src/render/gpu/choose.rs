//! Which rasterizer: what the user asked for if the device can, else the faster one, measured.

use std::time::{Duration, Instant};

use super::{GpuBackend, HardwareRaster};
use crate::{
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

/// Points that the measurement draws: enough that points outweigh the passes around them, few enough
/// that it is over in some 20 ms on a software rasterizer.
const PROBE_POINTS: u32 = 100_000;
const PROBE_SIZE: [u32; 2] = [640, 360];

pub fn raster(
    adapter: &wgpu::Adapter,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    choice: RasterChoice,
) -> Result<Raster, RenderError> {
    let int64 = wgpu::Features::SHADER_INT64 | wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX;
    let compute = if device.features().contains(int64) { Raster::Compute } else { Raster::Compute32 };
    match (choice, HardwareRaster::missing(adapter)) {
        (RasterChoice::Compute, _) | (RasterChoice::Auto, Some(_)) => Ok(compute),
        (RasterChoice::Compute32, _) => Ok(Raster::Compute32),
        (RasterChoice::Hardware, None) => Ok(Raster::Hardware),
        (RasterChoice::Hardware, Some(missing)) => Err(RenderError::Unsupported {
            adapter: adapter.get_info().name,
            raster: Raster::Hardware,
            missing: missing.to_owned(),
        }),
        (RasterChoice::Auto, None) => {
            let secs = |raster| probe(adapter, device, queue, raster);
            let (by_compute, by_hardware) = (secs(compute)?, secs(Raster::Hardware)?);
            log::info!("{PROBE_POINTS} points: {compute} {by_compute:?}, hardware {by_hardware:?}");
            Ok(if by_hardware < by_compute { Raster::Hardware } else { compute })
        }
    }
}

/// Time to draw points spread over the picture, the best of three frames.
fn probe(
    adapter: &wgpu::Adapter,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    raster: Raster,
) -> Result<Duration, RenderError> {
    let mut backend = GpuBackend::with_raster(&adapter.get_info(), device.clone(), queue.clone(), raster);
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
        reproject: false,
        fresh: false,
        fill: [0..PROBE_POINTS, 0..0],
        shading: Shading::default(),
        files: vec![],
    };
    let mut best = Duration::MAX;
    for _ in 0..3 {
        let start = Instant::now();
        backend.draw(&plan)?;
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| RenderError::DeviceLost(e.to_string()))?;
        best = best.min(start.elapsed());
    }
    Ok(best)
}
