//! `firstlight bench`.

use std::{
    env, fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use clap::{Args, ValueEnum};

use super::{
    CliError, ExitStatus, bench_ingest::command_line, bench_ingest::once, render::read_camera, say, steps::Steps,
    values,
};
use crate::{
    headless::Destination,
    measure::{
        ReportDir, ReportDirError,
        raster::{
            BenchRaster, Growth, Input, Order, Part, RasterError, RasterReport, TITLE, Viewpoint, Watcher,
            bench_raster, markdown, page, write_csv, write_json,
        },
    },
    methods::{Encoding, Gpu, METHODS, Method, by_name},
    render::Projection,
    synth::{Scene, SynthOptions},
};

/// Shown after the options.
pub const HELP: &str = "\
A block is one order in one encoding, seen from one viewpoint. In a block all methods run in turn, round after round,
every second round backwards; a first run of each is not counted. Every picture is compared with that of atomic-min,
and that one with the processor's, of which it may differ where rounding decides and nowhere else. Between the blocks
ceilings are measured: a kernel that only reads the positions, a kernel that copies, and copies from buffer to
buffer. Methods of a block are compared side by side; blocks follow one another, so on a busy machine differences
between orders or viewpoints may be the machine's.

Slow methods draw fewer frames: all of a row together take about 0.3 s on a GPU. One whose first frame is longer than
--max-frame draws no other, and is left in the middle after ten times as long; the tables say so. The host needs 16
bytes of memory for each point, and 8 to 36 more while it sorts: 28 GB for a billion points of the synthetic town.

--chart OUT.svg measures nothing: it draws several reports, of ever more points, in one chart.

REPORT_DIR gets bench.json (every sample), bench.csv (a line per frame) and index.html (tables and charts); the
tables are printed as Markdown too. The report is written after every block, so that Ctrl-C keeps what is done.

Without --size and --synth, a GPU draws 100 million points at 1920x1080; a software rasterizer such as lavapipe
draws 250,000 at 640x360, in less than two minutes on two cores.

Exit codes:
  0  done
  1  internal error
  2  the command line or the camera file is wrong
  3  no input can be read: missing, or not LAS/LAZ
  4  the report is written, but points are missing, or one of its checks failed: the figures cannot be trusted
  5  the report cannot be written
  6  no device does what was asked (no GPU, --size, --encoding)";

/// Points of the scan made where none is given, on a GPU and on a processor that stands in for one.
const DEFAULT_POINTS: [u64; 2] = [100_000_000, 250_000];
const DEFAULT_SIZE: [[u32; 2]; 2] = [[1920, 1080], [640, 360]];
const DEFAULT_FRAMES: [u32; 2] = [10, 2];
const DEFAULT_MAX_FRAME: [f64; 2] = [1.0, 10.0];

#[derive(Debug, Args)]
pub struct BenchArgs {
    /// LAS and LAZ files, and folders of them, all as one scene
    #[arg(value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// Folder for the report: new, empty, or an older report of this command
    #[arg(short, long, value_name = "REPORT_DIR", required_unless_present_any = ["list", "chart"])]
    output: Option<PathBuf>,
    /// A synthetic scan straight from memory: town:100M, planes:1M
    #[arg(long, value_name = "SCENE:N", conflicts_with = "inputs", value_parser = values::parse_synth)]
    synth: Option<SynthOptions>,
    /// Methods to measure; by default all (--list names them)
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', value_parser = parse_method)]
    methods: Vec<&'static Method>,
    /// Orders in which the points lie in memory
    #[arg(
        long,
        value_enum,
        value_name = "ORDER,…",
        value_delimiter = ',',
        default_value = "original,morton,shuffled,shuffled-morton"
    )]
    orders: Vec<Order>,
    /// Viewpoints; by default all, or none with --camera
    #[arg(long, value_enum, value_name = "VIEW,…", value_delimiter = ',')]
    views: Vec<Viewpoint>,
    /// A viewpoint of your own: {"eye":[x,y,z],"target":[x,y,z],"up":[0,0,1],"fov_y_deg":60}
    #[arg(long, value_name = "CAM.json")]
    camera: Option<PathBuf>,
    /// What to measure
    #[arg(long, value_enum, value_name = "PART,…", value_delimiter = ',', default_value = "tables,points,fragments")]
    parts: Vec<Part>,
    /// Width and height of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = values::parse_size)]
    size: Option<[u32; 2]>,
    /// The most frames that a method draws when it is its turn; by default 10, or 2 on a software rasterizer
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: Option<u32>,
    /// Rounds: how often it is each method's turn
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Seconds: a method whose first frame is longer draws no other; after ten times as long it is left. By default 1,
    /// or 10 on a software rasterizer
    #[arg(long, value_name = "SECS", value_parser = parse_secs)]
    max_frame: Option<f64>,
    /// How positions lie in memory; with both, every method is measured with each
    #[arg(long, value_enum, value_name = "ENCODING,…", value_delimiter = ',', default_value = "wide")]
    encoding: Vec<EncodingArg>,
    /// Fixes the shuffles
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Measure nothing: draw what a frame costs as the cloud grows, from the reports IN (bench.json files or their
    /// folders), for the first of --orders, --views and --encoding
    #[arg(long, value_name = "OUT.svg", conflicts_with_all = ["output", "synth", "camera", "list"], requires = "inputs")]
    chart: Option<PathBuf>,
    /// Say what each method is, where it is from and whether this device can run it, and end
    #[arg(long)]
    list: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// [`Encoding`] on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EncodingArg {
    /// 16 bytes: three 32-bit integers and the colour
    Wide,
    /// 8 bytes, where the scan's box fits 64 bits; colours apart
    Packed,
}

impl From<EncodingArg> for Encoding {
    fn from(arg: EncodingArg) -> Encoding {
        match arg {
            EncodingArg::Wide => Encoding::Wide,
            EncodingArg::Packed => Encoding::Packed,
        }
    }
}

fn parse_secs(text: &str) -> Result<f64, String> {
    let secs = text.parse().ok().filter(|secs: &f64| secs.is_finite() && *secs > 0.0);
    secs.ok_or_else(|| "expected seconds above zero, such as 0.5".into())
}

fn parse_method(name: &str) -> Result<&'static Method, String> {
    by_name(name).ok_or_else(|| {
        let names: Vec<&str> = METHODS.iter().map(|method| method.name).collect();
        format!("expected one of {} (see --list)", names.join(", "))
    })
}

pub fn run(args: BenchArgs) -> Result<ExitStatus, CliError> {
    if let Some(chart) = &args.chart {
        return draw_chart(&args, chart);
    }
    let Some(output) = args.output.as_deref().filter(|_| !args.list) else { return list() };
    let camera = args.camera.as_deref().map(read_camera).transpose()?;
    if camera.is_some_and(|camera| camera.projection != Projection::Perspective) {
        return Err(CliError::Usage(
            "--camera: the methods are measured in perspective; leave out \"projection\"".into(),
        ));
    }
    let folder = ReportDir::prepare(output, "bench.json", TITLE)?;
    let gpu = Gpu::headless().map_err(RasterError::from)?;
    let is_software = gpu.info.device_type == wgpu::DeviceType::Cpu;
    let default = usize::from(is_software);
    let input = match (args.synth, args.inputs.is_empty()) {
        (Some(options), _) => Input::Synth(options),
        (None, true) => {
            Input::Synth(SynthOptions { points: DEFAULT_POINTS[default], ..SynthOptions::new(Scene::Town) })
        }
        (None, false) => Input::Files(args.inputs),
    };
    let views =
        if args.views.is_empty() && camera.is_none() { Viewpoint::value_variants().to_vec() } else { once(args.views) };
    let mut methods: Vec<&'static Method> = METHODS.iter().collect();
    if !args.methods.is_empty() {
        // In the order of the table.
        methods.retain(|method| args.methods.iter().any(|asked| asked.name == method.name));
    }
    let settings = BenchRaster {
        input,
        methods,
        orders: once(args.orders),
        views,
        camera,
        parts: once(args.parts),
        size: args.size.unwrap_or(DEFAULT_SIZE[default]),
        encodings: once(args.encoding).into_iter().map(Encoding::from).collect(),
        frames: args.frames.unwrap_or(DEFAULT_FRAMES[default]),
        repeat: args.repeat,
        max_frame_secs: args.max_frame.unwrap_or(DEFAULT_MAX_FRAME[default]),
        seed: args.seed,
        command: command_line(env::args_os()),
    };
    let mut follow =
        Follow { folder, steps: Steps::new(args.quiet, "{bar:30} {pos}/{len}, {elapsed}, {eta} left: {msg}") };
    let report = bench_raster(&settings, &gpu, &mut follow);
    follow.steps.finish();
    let report = report?;
    if !args.quiet {
        // If nobody reads the tables, the report is written all the same.
        let _ = write!(io::stdout(), "{}", markdown(&report));
        say(&format!("wrote {}", follow.folder.path().join("index.html").display()));
    }
    Ok(tell(&report))
}

/// Says, past --quiet, what makes the figures worth less.
fn tell(report: &RasterReport) -> ExitStatus {
    let failed = || report.checks.iter().filter(|check| check.holds == Some(false));
    report.problems.iter().for_each(|problem| say(&format!("firstlight: {problem}")));
    failed().for_each(|check| say(&format!("firstlight: CHECK FAILED: {}: {}", check.what, check.found)));
    let all_is_well = report.problems.is_empty() && failed().next().is_none();
    if all_is_well { ExitStatus::Ok } else { ExitStatus::Partial }
}

/// One chart of several reports.
fn draw_chart(args: &BenchArgs, chart: &Path) -> Result<ExitStatus, CliError> {
    let usage = |error: String| CliError::Usage(format!("--chart: {error}"));
    let report = |path: &PathBuf| -> Result<serde_json::Value, CliError> {
        let path = if path.is_dir() { path.join("bench.json") } else { path.clone() };
        let text = fs::read(&path).map_err(|error| usage(format!("{}: {error}", path.display())))?;
        serde_json::from_slice(&text).map_err(|error| usage(format!("{}: no report: {error}", path.display())))
    };
    let reports = args.inputs.iter().map(report).collect::<Result<Vec<_>, _>>()?;
    let growth = Growth {
        methods: args.methods.iter().map(|method| method.name).collect(),
        order: args.orders.first().copied().unwrap_or(Order::Original),
        view: args.views.first().map_or("overview", |view| view.name()).into(),
        encoding: args.encoding.first().copied().map_or(Encoding::Wide, Encoding::from).name(),
    };
    let svg = growth.svg(&reports).map_err(usage)?;
    let written = Destination::check(chart).and_then(|file| file.write(|out| out.write_all(svg.as_bytes())));
    written.map_err(ReportDirError::from)?;
    if !args.quiet {
        say(&format!("wrote {}", chart.display()));
    }
    Ok(ExitStatus::Ok)
}

/// The table of methods; without a device, without a word on what it can run.
fn list() -> Result<ExitStatus, CliError> {
    let gpu = Gpu::headless();
    let mut out = io::stdout().lock();
    // A closed pipe is no reason to fail.
    let mut line = |text: &str| drop(writeln!(out, "{text}"));
    for method in METHODS {
        line(&format!("{}\n    {}", method.name, method.what));
        if let Some(why) = method.wrong_on_purpose {
            line(&format!("    wrong on purpose: {why}"));
        }
        line(&format!("    from:  {}\n    needs: {}", method.source, method.needs));
        if let Err(missing) = gpu.as_ref().map_or(Ok(()), |gpu| gpu.supports(method)) {
            line(&format!("    {missing}"));
        }
    }
    match &gpu {
        Ok(gpu) => line(&format!("\nThe device here: {} ({})", gpu.info.name, gpu.info.backend)),
        Err(error) => line(&format!("\nNo device here: {error}")),
    }
    Ok(ExitStatus::Ok)
}

struct Follow {
    folder: ReportDir,
    steps: Steps,
}

impl Watcher for Follow {
    fn step(&mut self, done: usize, total: usize, what: &str) {
        self.steps.step(done, total, what);
    }

    fn save(&mut self, report: &RasterReport) -> Result<(), ReportDirError> {
        let folder = &self.folder;
        folder.write("bench.csv", |out| write_csv(out, report))?;
        folder.write("index.html", |out| out.write_all(page(report).as_bytes()))?;
        // Last: it is what says that the folder holds a report.
        Ok(folder.write("bench.json", |out| write_json(out, report))?)
    }
}
