//! Times how fast a rasterizer fills: the scene's own points, in a buffer of words of its own, so that the
//! picture on screen is left alone.

use std::time::Instant;

use super::{
    Rasterizer,
    sources::{Source, SourceBinder},
    targets::{TargetLayouts, WriteBinds},
};
use crate::{
    gpu::{
        device, kernel,
        timing::{FrameTimer, Work},
    },
    render::{Clock, Passes, RenderError, Speed, View},
    store::gpu::GpuStore,
};

/// Pixels that the concentrated view draws everything to, as the papers' far view does.
const FAR_PIXELS: f32 = 2000.0;

/// The same view with all that it shows drawn together into some two thousand pixels in the middle:
/// what lies outside of the picture, but before the eye, falls into these as well. Depths stay.
pub fn concentrated(view: &View) -> View {
    let pixels = view.width as f32 * view.height as f32;
    let shrink = (FAR_PIXELS / pixels).sqrt().min(1.0);
    let [row_x, row_y] = [view.row_x, view.row_y].map(|[x, y, z, w]| [x * shrink, y * shrink, z * shrink, w]);
    View { row_x, row_y, ..*view }
}

/// A run need not take longer: clocks tell less than a hundredth of it apart.
const RUN_SECS: f64 = 1e-3;
/// Fewer points tell nothing.
pub const MIN_POINTS: u32 = 4096;

/// As many of `points`, which took `secs`, as a run needs.
fn few_enough(points: u32, secs: f64) -> u32 {
    let share = (RUN_SECS / secs).min(1.0);
    ((f64::from(points) * share) as u32).max(MIN_POINTS.min(points))
}

/// What a probe borrows of the backend.
pub struct Scene<'a> {
    pub device: &'a wgpu::Device,
    pub queue: &'a wgpu::Queue,
    pub store: &'a GpuStore,
    pub binder: &'a mut SourceBinder,
}

/// Words to draw to, and a clock.
pub struct Probe {
    view: wgpu::Buffer,
    words: wgpu::Buffer,
    binds_write: WriteBinds,
    timer: FrameTimer,
    /// The view on screen and the concentrated one.
    views: [View; 2],
    /// The first so many slots are drawn: a random sample of the scene.
    pub points: u32,
    /// Timed runs of each view; the fastest counts.
    repeats: u32,
}

impl Probe {
    /// # Errors
    /// The device's message if it has no memory for the words.
    pub fn new(
        scene: &Scene<'_>,
        layouts: &TargetLayouts,
        device_type: wgpu::DeviceType,
        view: &View,
        points: u32,
    ) -> Result<Probe, String> {
        let pixels = u64::from(view.width) * u64::from(view.height);
        let device = scene.device;
        let usage = wgpu::BufferUsages::STORAGE;
        let words = kernel::in_memory(device, || kernel::buffer(device, "probe words", 8 * pixels, usage))?;
        let uniform = kernel::uniform(device, "probe view", size_of::<View>() as u64);
        Ok(Probe {
            binds_write: WriteBinds::new(device, layouts, &uniform, &words),
            view: uniform,
            words,
            timer: FrameTimer::new(device, scene.queue, device_type),
            views: [*view, concentrated(view)],
            points,
            repeats: if device_type == wgpu::DeviceType::Cpu { 2 } else { 4 },
        })
    }

    /// Draws both views to the words, which then hold what a frame's reprojection leaves: the front points.
    /// From there on, every timed run finds what the fill of a large scene finds, where nearly all
    /// points lie behind others; and all candidates find the same.
    pub fn prepare(
        &mut self,
        scene: &mut Scene<'_>,
        rasterizer: &mut Rasterizer,
        clear: &wgpu::ComputePipeline,
    ) -> Result<(), RenderError> {
        let mut encoder = scene.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(clear);
            pass.set_bind_group(0, &self.binds_write.plain, &[]);
            scene.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&self.views[0]));
            kernel::dispatch(&mut pass, self.views[0].width * self.views[0].height);
        }
        scene.queue.submit([encoder.finish()]);
        if !self.aim(scene, rasterizer) {
            return Ok(());
        }
        for view in self.views {
            self.draw(scene, rasterizer, &view)?;
        }
        let view = self.views[0];
        if let Some((secs, _)) = self.draw(scene, rasterizer, &view)? {
            self.points = few_enough(self.points, secs);
        }
        Ok(())
    }

    /// How fast a rasterizer is; none if the clock gave no time, or memory has no room.
    pub fn speed(&mut self, scene: &mut Scene<'_>, rasterizer: &mut Rasterizer) -> Result<Option<Speed>, RenderError> {
        if !self.aim(scene, rasterizer) {
            return Ok(None);
        }
        let mut fastest = [None::<(f64, Clock)>; 2];
        for (fastest, view) in fastest.iter_mut().zip(self.views) {
            // The first one is not timed: drivers finish compiling in it.
            for run in 0..=self.repeats {
                let time = self.draw(scene, rasterizer, &view)?;
                if let (Some((secs, clock)), 1..) = (time, run)
                    && fastest.is_none_or(|(least, _)| secs < least)
                {
                    *fastest = Some((secs, clock));
                }
            }
        }
        let [Some((overview, clock)), Some((far, _))] = fastest else { return Ok(None) };
        let rate = |secs: f64| f64::from(self.points) / secs;
        Ok(Some(Speed { overview_points_per_sec: rate(overview), far_points_per_sec: rate(far), clock }))
    }

    /// False if there is no memory for it.
    fn aim(&self, scene: &Scene<'_>, rasterizer: &mut Rasterizer) -> bool {
        let size = [self.views[0].width, self.views[0].height];
        match rasterizer {
            Rasterizer::Hardware(raster) => raster.resize(scene.device, &self.view, &self.words, size).is_ok(),
            Rasterizer::Compute(_) => true,
        }
    }

    /// One fill, waited for, and the time that it took.
    fn draw(
        &mut self,
        scene: &mut Scene<'_>,
        rasterizer: &Rasterizer,
        view: &View,
    ) -> Result<Option<(f64, Clock)>, RenderError> {
        let Scene { device, queue, store, binder } = scene;
        queue.write_buffer(&self.view, 0, bytemuck::bytes_of(view));
        // An empty list comes first: point lists clear their depths in a frame's first pass.
        let sources = binder.bind(device, queue, store, vec![Source::Fresh, Source::Fill], &[0..self.points, 0..0]);
        let work = Work { fill_points: self.points, insertions: 0, average_points: 0, passes: Passes::Depths };
        let mut encoder = device.create_command_encoder(&Default::default());
        self.timer.begin();
        match rasterizer {
            Rasterizer::Compute(raster) => {
                raster.record(&mut encoder, &mut self.timer, &self.binds_write, store, &sources);
            }
            Rasterizer::Hardware(raster) => {
                let size = [view.width, view.height];
                raster.record(&mut encoder, &mut self.timer, size, store, &sources, view.point_size.pow(2));
            }
        }
        self.timer.end(&mut encoder, work);
        let commands = encoder.finish();
        // From before the submission: on a software rasterizer, whose threads are the processor's, a run
        // of a millisecond may be over before this thread goes on, and seem to take no time.
        let start = Instant::now();
        queue.submit([commands]);
        self.timer.submitted(device, queue, work);
        device::wait(device)?;
        let wall_secs = start.elapsed().as_secs_f64();
        let Some(times) = self.timer.take() else { return Ok(None) };
        let (secs, clock) = if times.undivided > 0.0 { (wall_secs, Clock::Wall) } else { (times.fill, Clock::Device) };
        Ok((secs > 0.0).then_some((secs, clock)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        render::Camera,
        scene::{Bounds, Grid},
    };

    #[test]
    fn slow_devices_draw_fewer_points() {
        assert_eq!(few_enough(1 << 21, 20e-6), 1 << 21);
        assert_eq!(few_enough(2_000_000, 20e-3), 100_000);
        assert_eq!(few_enough(16_384, 1.0), MIN_POINTS);
        assert_eq!(few_enough(1000, 1.0), 1000);
    }

    #[test]
    fn the_concentrated_view_has_all_points_on_few_pixels() {
        let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
        let bounds = Bounds { min: [0.0; 3], max: [100.0, 100.0, 10.0] };
        for size in [[1920, 1080], [64, 48], [10, 10]] {
            let camera = Camera::fit(&bounds, &grid, f64::from(size[0]) / f64::from(size[1]));
            let view = camera.view(&grid, size, 1).unwrap();
            let far = concentrated(&view);
            let all = (0..1000).map(|i: i32| [i * 10, (i * 7919) % 10_000, (i * 31) % 1000]);
            let count = |view: &View| {
                let shown = all.clone().filter_map(|p| view.project(p));
                shown.map(|p| p.corner).collect::<std::collections::HashSet<_>>().len()
            };
            assert!(all.clone().all(|p| far.project(p).is_some()), "{size:?}");
            assert!(count(&far) <= 2000, "{size:?}");
            assert_eq!(
                count(&far) < count(&view),
                size[0] * size[1] > 2000,
                "{size:?}: more than 2,000 pixels are drawn together"
            );
            let depths = |view: &View| all.clone().filter_map(|p| view.project(p)).map(|p| p.depth).collect::<Vec<_>>();
            assert_eq!(depths(&far), depths(&view));
        }
    }
}
