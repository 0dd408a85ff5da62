//! The blocks: each order from each viewpoint, all methods in turn.

use clap::ValueEnum;

use super::{
    Accuracy, RasterError,
    accuracy::brute_force,
    checks::checks,
    curves,
    input::{Input, Scan},
    orders::{Order, gather},
    report::{Block, Ceilings, Device, MethodEntry, RasterReport, Row, Sample, TITLE},
    views::Viewpoint,
};
use crate::{
    measure::{machine::Machine, report_dir::ReportDirError},
    methods::{self, Cloud, Encoding, Gpu, Method, Runner, by_name},
    render::{Camera, View},
};

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// Method × order × viewpoint
    Tables,
    /// Cost against the number of points, in the overview
    Points,
    /// Cost against the points per pixel: stacked planes, then their base shrunk to a pixel
    Fragments,
}

/// What to measure.
#[derive(Clone)]
pub struct BenchRaster {
    pub input: Input,
    pub methods: Vec<&'static Method>,
    pub orders: Vec<Order>,
    pub views: Vec<Viewpoint>,
    /// One more viewpoint, in the coordinates of the file.
    pub camera: Option<Camera>,
    pub parts: Vec<Part>,
    pub size: [u32; 2],
    pub encoding: Encoding,
    /// Frames of a sample run, at least 1.
    pub frames: u32,
    /// Rounds, at least 1.
    pub repeat: u32,
    pub seed: u64,
    /// The command line, for the report.
    pub command: String,
}

/// Who follows a measurement.
pub trait Watcher {
    /// `done` of `total` steps; `what` comes next.
    fn step(&mut self, done: usize, total: usize, what: &str);
    /// Keeps what there is so far.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save(&mut self, report: &RasterReport) -> Result<(), ReportDirError>;
}

/// What the device is called.
fn describe(gpu: &Gpu) -> Device {
    let info = &gpu.info;
    Device {
        adapter: info.name.clone(),
        api: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
        is_software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

/// Measures everything asked for and keeps the report as it grows.
///
/// # Errors
/// If nothing can be read, the device cannot hold or draw the cloud, or the report cannot be kept.
pub fn bench_raster(settings: &BenchRaster, gpu: &Gpu, watcher: &mut dyn Watcher) -> Result<RasterReport, RasterError> {
    watcher.step(0, 1, "the points");
    let scan = settings.input.load()?;
    let shots = shots(settings, &scan)?;
    let mut report = empty(settings, gpu, &scan);
    let orders = if settings.parts.contains(&Part::Tables) { &settings.orders[..] } else { &[] };
    let curve_steps = curves::plan(settings, report.points, report.device.is_software);
    let total = orders.len() * shots.len() + curve_steps.len();
    let mut done = 0;
    for &order in orders {
        watcher.step(done, total, &format!("{} order", order.name()));
        let cloud = arrange(order, &scan.cloud, settings.seed);
        let mut runner = Runner::new(gpu, &cloud, settings.encoding, settings.size)?;
        let methods = supported(settings, &runner, &mut report);
        for shot in &shots {
            watcher.step(done, total, &format!("{} order, {}", order.name(), shot.name));
            ceilings(&mut runner, &mut report)?;
            let block = block(settings, &mut runner, &methods, &cloud, order, shot)?;
            report.wall_clock = block.rows.iter().any(Row::has_wall_clock);
            report.blocks.push(block);
            done += 1;
            keep(&mut report, watcher)?;
        }
    }
    for step in curve_steps {
        watcher.step(done, total, &step.to_string());
        curves::measure(&step, settings, gpu, &scan, &mut report)?;
        done += 1;
        keep(&mut report, watcher)?;
    }
    report.complete = true;
    report.machine.finish();
    keep(&mut report, watcher)?;
    watcher.step(done, total, "done");
    Ok(report)
}

fn keep(report: &mut RasterReport, watcher: &mut dyn Watcher) -> Result<(), RasterError> {
    report.ceilings.summarize();
    report.checks = checks(report);
    Ok(watcher.save(report)?)
}

/// A viewpoint's name, its camera, and the camera's numbers.
struct Shot {
    name: String,
    camera: Camera,
    view: View,
}

fn shots(settings: &BenchRaster, scan: &Scan) -> Result<Vec<Shot>, RasterError> {
    let camera_of = |view: &Viewpoint| view.camera(&scan.cloud.positions, &scan.grid, settings.size);
    let named = settings.views.iter().map(|view| (view.name(), camera_of(view)));
    let own = settings.camera.map(|camera| ("camera", camera));
    let shot = |(name, camera): (&str, Camera)| {
        Ok(Shot { name: name.into(), camera, view: camera.view(&scan.grid, settings.size, 1)? })
    };
    named.chain(own).map(shot).collect()
}

fn empty(settings: &BenchRaster, gpu: &Gpu, scan: &Scan) -> RasterReport {
    RasterReport {
        report: TITLE,
        program: concat!("firstlight ", env!("CARGO_PKG_VERSION")).into(),
        command: settings.command.clone(),
        complete: false,
        machine: Machine::find(),
        device: describe(gpu),
        input: scan.name.clone(),
        points: scan.cloud.positions.len() as u64,
        size_px: settings.size,
        encoding: match settings.encoding {
            Encoding::Wide => "wide",
            Encoding::Packed => "packed",
        },
        bytes_per_point: 0,
        frames: settings.frames,
        repeat: settings.repeat,
        seed: settings.seed,
        wall_clock: false,
        methods: Vec::new(),
        ceilings: Ceilings::default(),
        blocks: Vec::new(),
        curves: Vec::new(),
        checks: Vec::new(),
        problems: scan.problems.clone(),
    }
}

fn arrange(order: Order, cloud: &Cloud, seed: u64) -> Cloud {
    let points = order.points(&cloud.positions, seed);
    Cloud { positions: gather(&cloud.positions, &points), colors: gather(&cloud.colors, &points) }
}

/// The methods that this device can run; what the others lack goes into the report.
pub(super) fn supported(settings: &BenchRaster, runner: &Runner, report: &mut RasterReport) -> Vec<&'static Method> {
    let missing = |method: &Method| runner.supports(method).err();
    report.methods = settings.methods.iter().map(|method| MethodEntry::new(method, missing(method))).collect();
    report.bytes_per_point = runner.bytes_per_point();
    settings.methods.iter().copied().filter(|method| missing(method).is_none()).collect()
}

fn ceilings(runner: &mut Runner, report: &mut RasterReport) -> Result<(), RasterError> {
    // The first is not counted.
    let found = methods::ceilings(runner, &methods::Copies::new(&runner.gpu)?, 3)?;
    report.ceilings.copy_samples.extend(found.copy.iter().skip(1));
    report.ceilings.read_samples.extend(found.read.iter().skip(1));
    Ok(())
}

/// All methods on a cloud in one order, from one viewpoint.
fn block(
    settings: &BenchRaster,
    runner: &mut Runner,
    methods: &[&'static Method],
    cloud: &Cloud,
    order: Order,
    shot: &Shot,
) -> Result<Block, RasterError> {
    let view = &shot.view;
    let (processor, fragments) = brute_force(cloud, view);
    // Where the device has no 64-bit atomics, the processor's picture is what all are compared with.
    let right = match by_name("atomic-min").filter(|method| runner.supports(method).is_ok()) {
        Some(method) => runner.draw(method, view)?,
        None => processor.clone(),
    };
    let differs = Accuracy::of(&right, &processor, false);
    let mut rows = Vec::new();
    for method in methods {
        let drawn = runner.draw(method, view)?;
        rows.push(Row::new(method.name, Accuracy::of(&drawn, &right, method.blends)));
        // Not counted.
        runner.time(method, view, 1)?;
    }
    for round in 1..=settings.repeat {
        for i in in_turn(methods.len(), round) {
            let times = runner.time(methods[i], view, settings.frames)?;
            rows[i].samples.extend(times.iter().map(|time| Sample::new(round, time)));
        }
    }
    let (points, bytes_per_point) = (runner.points(), runner.bytes_per_point());
    rows.iter_mut().for_each(|row| row.summarize(points, bytes_per_point));
    Ok(Block {
        order,
        view: shot.name.clone(),
        camera: shot.camera,
        fragments,
        covered_pixels: processor.depth.iter().filter(|depth| depth.is_finite()).count() as u64,
        reference_differs: differs.wrong_pixels.unwrap_or(0),
        rows,
    })
}

/// 0 to `len − 1`, every second round backwards: nobody always follows the same neighbour.
pub(super) fn in_turn(len: usize, round: u32) -> Vec<usize> {
    let forwards = 0..len;
    if round.is_multiple_of(2) { forwards.rev().collect() } else { forwards.collect() }
}
