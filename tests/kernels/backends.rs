//! The backends that can run here.

use firstlight::{
    gpu::device,
    render::{Backend, CpuBackend, GpuBackend, Raster, RasterChoice, RenderError},
    store::Encoding,
};

pub const RASTERS: [Raster; 7] = Raster::ON_GPU;

/// A backend on a GPU. Without one the test is skipped, loudly, or fails if FIRSTLIGHT_REQUIRE_GPU is
/// set.
pub fn gpu(choice: impl Into<RasterChoice>) -> Option<GpuBackend> {
    match GpuBackend::headless(choice.into()) {
        Ok(backend) => Some(backend),
        Err(error) => {
            assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_GPU").is_none(), "a GPU is required: {error}");
            skipped(&error.to_string());
            None
        }
    }
}

/// Says so past the test harness, which shows only what failing tests print.
fn skipped(why: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "SKIPPED on a GPU: {why}");
}

/// A backend that chooses for itself, on a device that lacks features which the adapter may have.
pub fn without(features: wgpu::Features) -> Option<GpuBackend> {
    with_choice_without(RasterChoice::Auto, features).map(|backend| backend.expect("something runs everywhere"))
}

/// As [`without`], with this choice.
pub fn with_choice_without(choice: RasterChoice, features: wgpu::Features) -> Option<Result<GpuBackend, RenderError>> {
    let adapter =
        pollster::block_on(device::instance().request_adapter(&wgpu::RequestAdapterOptions::default())).ok()?;
    let mut descriptor = GpuBackend::device_descriptor(&adapter);
    descriptor.required_features.remove(features);
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("fewer features than offered");
    Some(GpuBackend::on_device(&adapter, device, queue, choice))
}

/// Every backend, with the name that failures give it: the processor's, each rasterizer with packed positions, one with
/// small pages, and two with wide positions.
pub fn all() -> Vec<(String, Box<dyn Backend>)> {
    let mut all: Vec<(String, Box<dyn Backend>)> = vec![
        ("cpu, 1 thread".into(), Box::new(CpuBackend::new(Some(1)))),
        ("cpu, 3 threads".into(), Box::new(CpuBackend::new(Some(3)))),
    ];
    for raster in RASTERS {
        let Some(backend) = gpu(raster) else { return all };
        all.push((raster.to_string(), Box::new(backend)));
    }
    // One method: a choice made amid two sessions, at times that depend on the machine's load, would tell them apart.
    let less = wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS | wgpu::Features::TIMESTAMP_QUERY;
    if let Some(Ok(backend)) = with_choice_without(Raster::EarlyZ.into(), less) {
        all.push(("64-bit minimum only, no timestamps".into(), Box::new(backend)));
    }
    if let Some(mut backend) = gpu(Raster::EarlyZ) {
        backend.store_mut().set_page_points(Some(1000));
        all.push(("early-z, pages of 1,000 points".into(), Box::new(backend)));
    }
    for raster in [Raster::EarlyZ, Raster::Points] {
        if let Some(mut backend) = gpu(raster) {
            backend.set_encoding(Some(Encoding::Wide));
            backend.store_mut().set_page_points(Some(9000));
            all.push((format!("{raster}, wide, pages of 9,000 points"), Box::new(backend)));
        }
    }
    all
}

/// What backends of the tests leave to the processor's, their member `cpu`, whatever else they do.
macro_rules! as_the_processor {
    () => {
        fn sums(&self) -> firstlight::render::Sums {
            self.cpu.sums()
        }
        fn reset(&mut self, points: u64, packing: Option<firstlight::store::Packing>) {
            self.cpu.reset(points, packing);
        }
        fn insertions_per_frame(&self) -> usize {
            self.cpu.insertions_per_frame()
        }
        fn resize(&mut self, size: [u32; 2]) -> Result<(), firstlight::render::RenderError> {
            self.cpu.resize(size)
        }
        fn fill_column(
            &mut self,
            column: firstlight::render::ColumnId,
            records: &[u32],
            keys: firstlight::render::Keys<'_>,
        ) -> Result<(), firstlight::render::RenderError> {
            self.cpu.fill_column(column, records, keys)
        }
        fn drop_column(&mut self, column: firstlight::render::ColumnId) {
            self.cpu.drop_column(column);
        }
        fn set_relocation(&mut self, on: bool) {
            self.cpu.set_relocation(on);
        }
        fn pick(&mut self, at: firstlight::render::PickAt) -> Option<firstlight::render::PickTicket> {
            self.cpu.pick(at)
        }
        fn picked(&mut self, ticket: firstlight::render::PickTicket) -> Option<Option<firstlight::render::Pick>> {
            self.cpu.picked(ticket)
        }
        fn wait(&mut self) -> Result<(), firstlight::render::RenderError> {
            self.cpu.wait()
        }
        fn read(&mut self) -> Result<firstlight::render::Picture, firstlight::render::RenderError> {
            self.cpu.read()
        }
    };
}
pub(crate) use as_the_processor;
