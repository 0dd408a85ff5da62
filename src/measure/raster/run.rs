//! A whole measurement: points, orders, encodings, viewpoints, curves.

use std::time::Instant;

use clap::ValueEnum;

use super::{
    RasterError,
    block::block,
    checks::checks,
    curves,
    input::{Input, Scan},
    orders::{Order, Orders},
    processor::Processor,
    report::{Ceilings, Device, HostTime, MethodEntry, RasterReport, Row, TITLE},
    views::Viewpoint,
};
use crate::{
    measure::{machine::Machine, report_dir::ReportDirError},
    methods::{self, Arranged, Cloud, Copies, Encoding, Gpu, Method, MethodError, Packing, Runner},
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
    /// At least one. Curves have the first.
    pub encodings: Vec<Encoding>,
    /// The most frames of a method in a round, at least 1.
    pub frames: u32,
    /// Rounds, at least 1.
    pub repeat: u32,
    /// A method whose first frame is longer draws no other, and one that takes ten times as long is left in the
    /// middle of it.
    pub max_frame_secs: f64,
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
    let start = Instant::now();
    let scan = settings.input.load()?;
    let shots = shots(settings, &scan)?;
    let mut report = empty(settings, gpu, &scan);
    took(&mut report, "the points", start);
    let methods = supported(settings, gpu, &mut report);
    let asked = if settings.parts.contains(&Part::Tables) { &settings.orders[..] } else { &[] };
    let encodings = encodings(settings, &scan, &mut report)?;
    let curve_steps = curves::plan(settings, report.points, report.device.is_software);
    let total = asked.len() * shots.len() * encodings.len() + curve_steps.len();
    let mut done = 0;
    let orders = Orders::new(&scan.cloud.positions);
    // One for each viewpoint, when it is first needed.
    let mut processors: Vec<Option<Processor>> = shots.iter().map(|_| None).collect();
    let copies = if asked.is_empty() { None } else { Some(Copies::new(gpu)?) };
    // One for each encoding: its pipelines are made once. Only one holds the cloud at a time.
    let mut runners: Vec<Option<Runner>> = encodings.iter().map(|_| None).collect();
    for &order in asked {
        watcher.step(done, total, &format!("{} order", order.name()));
        let start = Instant::now();
        let points = orders.points(order, settings.seed);
        took(&mut report, &format!("{} order", order.name()), start);
        let arranged = Arranged { cloud: &scan.cloud, order: points.as_deref() };
        for (&encoding, runner) in encodings.iter().zip(&mut runners) {
            let name = format!("{} order, {}", order.name(), encoding.name());
            let start = Instant::now();
            let runner = match runner {
                Some(runner) => runner,
                new => new.insert(Runner::new(gpu, &Cloud::default(), encoding, settings.size)?),
            };
            runner.load(arranged)?;
            took(&mut report, &format!("upload of {name}"), start);
            for (shot, processor) in shots.iter().zip(&mut processors) {
                watcher.step(done, total, &format!("{name}, {}", shot.name));
                if processor.is_none() {
                    let start = Instant::now();
                    *processor = Some(Processor::of(&scan.cloud, &shot.view));
                    took(&mut report, &format!("the processor's {}", shot.name), start);
                }
                let start = Instant::now();
                if let (Some(processor), Some(copies)) = (processor.as_ref(), &copies) {
                    ceilings(runner, copies, &mut report)?;
                    let block = block(settings, runner, &methods, arranged, order, shot, processor)?;
                    report.wall_clock |= block.rows.iter().any(Row::has_wall_clock);
                    report.blocks.push(block);
                }
                took(&mut report, &format!("block of {name}, {}", shot.name), start);
                done += 1;
                keep(&mut report, watcher)?;
            }
            runner.unload()?;
        }
    }
    // The curves need their memory.
    drop((orders, runners, copies));
    for step in curve_steps {
        watcher.step(done, total, &step.to_string());
        curves::measure(&step, settings, encodings[0], gpu, &scan, &methods, &mut report)?;
        done += 1;
        keep(&mut report, watcher)?;
    }
    report.complete = true;
    report.machine.finish();
    keep(&mut report, watcher)?;
    watcher.step(done, total, "done");
    Ok(report)
}

fn took(report: &mut RasterReport, what: &str, start: Instant) {
    report.host.push(HostTime { what: what.into(), secs: start.elapsed().as_secs_f64() });
}

/// The encodings that the cloud fits; never none.
fn encodings(settings: &BenchRaster, scan: &Scan, report: &mut RasterReport) -> Result<Vec<Encoding>, RasterError> {
    let mut fitting = Vec::new();
    for &encoding in &settings.encodings {
        match Packing::of(Arranged::from(&scan.cloud).extent()) {
            Err(error) if encoding == Encoding::Packed => report.problems.push(error.to_string()),
            _ => fitting.push(encoding),
        }
    }
    if fitting.is_empty() {
        // Packed alone: then the reason is an error.
        Packing::of(Arranged::from(&scan.cloud).extent()).map_err(MethodError::from)?;
        fitting.push(Encoding::Wide);
    }
    report.encodings = fitting.clone();
    Ok(fitting)
}

fn keep(report: &mut RasterReport, watcher: &mut dyn Watcher) -> Result<(), RasterError> {
    report.ceilings.summarize();
    report.checks = checks(report);
    Ok(watcher.save(report)?)
}

/// A viewpoint's name, its camera, and the camera's numbers.
pub(super) struct Shot {
    pub name: String,
    pub camera: Camera,
    pub view: View,
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
        encodings: settings.encodings.clone(),
        frames: settings.frames,
        repeat: settings.repeat,
        max_frame_secs: settings.max_frame_secs,
        seed: settings.seed,
        wall_clock: false,
        methods: Vec::new(),
        host: Vec::new(),
        ceilings: Ceilings::default(),
        blocks: Vec::new(),
        curves: Vec::new(),
        checks: Vec::new(),
        problems: scan.problems.clone(),
    }
}

/// The methods that this device can run; what the others lack goes into the report.
fn supported(settings: &BenchRaster, gpu: &Gpu, report: &mut RasterReport) -> Vec<&'static Method> {
    let missing = |method: &Method| gpu.supports(method).err();
    report.methods = settings.methods.iter().map(|method| MethodEntry::new(method, missing(method))).collect();
    settings.methods.iter().copied().filter(|method| missing(method).is_none()).collect()
}

fn ceilings(runner: &mut Runner, copies: &Copies, report: &mut RasterReport) -> Result<(), RasterError> {
    // The first is not counted.
    let found = methods::ceilings(runner, copies, 3)?;
    report.ceilings.add(runner.encoding(), &found.copy[1..], &found.copy_kernel[1..], &found.read[1..]);
    Ok(())
}

/// 0 to `len − 1`, every second round backwards: nobody always follows the same neighbour.
pub(super) fn in_turn(len: usize, round: u32) -> Vec<usize> {
    let forwards = 0..len;
    if round.is_multiple_of(2) { forwards.rev().collect() } else { forwards.collect() }
}
