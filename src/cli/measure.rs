//! `firstlight measure`.

use std::{
    env, fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use clap::{Args, ValueEnum};

use super::{
    CliError, ExitStatus,
    bench_ingest::{command_line, once},
    render::{BackendArg, backend_choice, read_camera},
    say,
    steps::Steps,
    values::{self, EncodingChoice},
};
use crate::{
    measure::{
        ReportDir, ReportDirError,
        converge::{
            self, Clock, ConvergeReport, Decoded, Fill, MOST_LOAD, Measure, Motion, TITLE, VIEWER_POINT_SIZE, Variant,
            Watcher, markdown, page, write_csv,
        },
        raster::Input,
    },
    render::{Camera, RasterChoice},
    synth::SynthOptions,
};

/// Shown after the options.
pub const HELP: &str = "\
A run has phases: loading, still, and each motion with a rest behind it, until the picture has converged. After every
frame the picture is compared with that of all points received so far and with that of all points of the file, both
drawn by brute force on the same device. The settings (every --fill at every --point-size, --method, --encoding and --fields) are run in turn,
then the baselines at the first of them: what this program's method is judged against.

--clock real times a run first, without comparisons, in frames at most sixty times a second; then its frames are drawn
again, by their log, and compared. --clock virtual lets as many points arrive and be tried in every frame: the report
is the same on every machine but for the adapter's name (and, on GPUs that round depths otherwise, the last digits of
the depth errors). The whole scan is held in memory, 24 bytes per point (twice
with the baseline `unshuffled`, and once more where --fields names `positions` beside others), besides the store. Settings
are judged by their times from --repeat 3 on.

Without colours (--fields positions) pictures are coloured by elevation, and compared with truths of the same colours: their
SSIM and PSNR are not those of the others. The processor's own backend always holds positions in 12 bytes.

CAMS.json is a list of cameras: [{\"eye\":[x,y,z],\"target\":[x,y,z],\"up\":[0,0,1],\"fov_y_deg\":60}, …].

REPORT_DIR gets measure.json (every sample), measure.csv (a line per frame) and index.html (tables and charts);
the headlines are printed as Markdown too. The report is written after every run, so that Ctrl-C keeps what is done.

Exit codes:
  0  done
  1  internal error
  2  the command line or a camera file is wrong
  3  no input can be read: missing, or not LAS/LAZ
  4  the report is written, but points are missing, or one of its checks failed
  5  the report cannot be written
  6  no device does what was asked (--backend, --method, --size)";

/// Fill of the virtual clock where none is given.
const VIRTUAL_FILL: u32 = 100_000;
/// Frames of a motion: virtual ones, and sixtieths of a second.
const FRAMES: [u32; 2] = [24, 120];

#[derive(Debug, Args)]
pub struct MeasureArgs {
    /// LAS and LAZ files, and folders of them, all as one scene
    #[arg(value_name = "IN", required_unless_present = "synth")]
    inputs: Vec<PathBuf>,
    /// Folder for the report: new, empty, or an older report of this command
    #[arg(short, long, value_name = "REPORT_DIR")]
    output: PathBuf,
    /// A synthetic scan straight from memory: town:1M, planes:1M
    #[arg(long, value_name = "SCENE:N", conflicts_with = "inputs", value_parser = values::parse_synth)]
    synth: Option<SynthOptions>,
    /// Width and height of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::parse_size)]
    size: [u32; 2],
    /// Where to look from while loading; by default the whole scene
    #[arg(long, value_name = "CAM.json")]
    camera: Option<PathBuf>,
    /// Move the camera through these instead of --motion; without --camera, loading is seen from the first
    #[arg(long, value_name = "CAMS.json", conflicts_with = "motion")]
    path: Option<PathBuf>,
    /// How the camera moves
    #[arg(long, value_enum, value_name = "MOTION,…", value_delimiter = ',', default_value = "orbit,walk,jump")]
    motion: Vec<MotionArg>,
    /// Random points that each frame tries (250k, 1M, …), or auto: as many as fit into 16 ms. By default auto, or
    /// 100k with --clock virtual
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = parse_fill)]
    fill: Vec<Fill>,
    /// Widths of a point, pixels, 1 to 8
    #[arg(long, value_name = "PX,…", value_delimiter = ',', default_values_t = [VIEWER_POINT_SIZE], value_parser = clap::value_parser!(u32).range(1..=8))]
    point_size: Vec<u32>,
    /// How the GPU turns points into pixels: methods' names, or NAME:64 (:128, :256) with their workgroup
    /// size; auto measures which is the fastest
    #[arg(long, value_name = "auto|NAME,…", value_delimiter = ',', default_value = "auto", value_parser = values::parse_method)]
    method: Vec<RasterChoice>,
    /// How the store on a GPU holds positions; no pixel depends on it, times may
    #[arg(long, value_enum, value_name = "auto|ENCODING,…", value_delimiter = ',', default_value = "auto")]
    encoding: Vec<EncodingChoice>,
    /// What is decoded of the points of files while they load, besides positions; layered LAZ (formats 6 and up) spares
    /// the rest
    #[arg(long, value_enum, value_name = "FIELDS,…", value_delimiter = ',', default_value = "colors")]
    fields: Vec<Decoded>,
    /// Where to draw; auto takes a GPU if there is one
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArg,
    /// What drives the frames
    #[arg(long, value_enum, default_value = "real")]
    clock: Clock,
    /// What to compare with; by default everything
    #[arg(long, value_enum, value_name = "NAME,…", value_delimiter = ',')]
    baselines: Vec<Variant>,
    /// Leave the baselines out
    #[arg(long, conflicts_with = "baselines")]
    no_baselines: bool,
    /// Frames that each motion takes: sixtieths of a second, by default 120; virtual ones, by default 24
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Points that arrive in every virtual frame; by default a thirty-second part of all, at most 393,216
    #[arg(long, value_name = "N", value_parser = parse_load)]
    load: Option<u32>,
    /// Rounds: how often each setting is run
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Fixes the order of the points in the store
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Decoder threads; by default one per core, less one
    #[arg(long, value_name = "N", value_parser = values::parse_threads)]
    threads: Option<usize>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// [`Motion`] on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MotionArg {
    /// 30 degrees round the scene
    Orbit,
    /// Ahead, by a quarter of the distance to the target
    Walk,
    /// At once to a nearer view from another side
    Jump,
    /// The camera stands still
    None,
}

fn parse_fill(text: &str) -> Result<Fill, String> {
    if text == "auto" {
        return Ok(Fill::Auto);
    }
    values::parse_points(text).map(Fill::Points).map_err(|error| format!("{error}; or `auto`"))
}

fn parse_load(text: &str) -> Result<u32, String> {
    let points = values::parse_points(text)?;
    let wrong = || format!("expected at most {MOST_LOAD}, what every device can insert in a frame; found `{text}`");
    (points <= MOST_LOAD).then_some(points).ok_or_else(wrong)
}

fn read_path(path: &Path) -> Result<Motion, CliError> {
    let usage = |problem: String| CliError::Usage(format!("--path {}: {problem}", path.display()));
    let text = fs::read_to_string(path).map_err(|error| usage(error.to_string()))?;
    let cameras: Vec<Camera> = serde_json::from_str(&text).map_err(|error| {
        usage(format!(r#"expected [{{"eye":[x,y,z],"target":[x,y,z],"up":[0,0,1],"fov_y_deg":60}}, …]: {error}"#))
    })?;
    if cameras.is_empty() { Err(usage("expected at least one camera".into())) } else { Ok(Motion::Path(cameras)) }
}

pub fn run(args: MeasureArgs) -> Result<ExitStatus, CliError> {
    let quiet = args.quiet;
    let output = args.output.clone();
    let settings = args.validate()?;
    let folder = ReportDir::prepare(&output, "measure.json", TITLE)?;
    let mut follow = Follow { folder, steps: Steps::new(quiet, "{bar:30} {pos}/{len} runs, {elapsed}: {msg}") };
    let report = converge::measure(&settings, &mut follow);
    follow.steps.finish();
    let report = report?;
    if !quiet {
        // If nobody reads the tables, the report is written all the same.
        let _ = write!(io::stdout(), "{}", markdown(&report));
        say(&format!("wrote {}", follow.folder.path().join("index.html").display()));
    }
    Ok(tell(&report))
}

/// Says, past --quiet, what makes the figures worth less.
fn tell(report: &ConvergeReport) -> ExitStatus {
    let failed = || report.checks.iter().filter(|check| check.holds == Some(false));
    report.problems.iter().for_each(|problem| say(&format!("firstlight: {problem}")));
    failed().for_each(|check| say(&format!("firstlight: CHECK FAILED: {}: {}", check.what, check.found)));
    let all_is_well = report.problems.is_empty() && failed().next().is_none();
    if all_is_well { ExitStatus::Ok } else { ExitStatus::Partial }
}

impl MeasureArgs {
    fn validate(self) -> Result<Measure, CliError> {
        // Every choice must go with the backend.
        let backends: Result<Vec<_>, _> =
            self.method.iter().map(|&method| backend_choice(self.backend, method)).collect();
        let backend = backends?.first().copied().unwrap_or_default();
        let is_virtual = self.clock == Clock::Virtual;
        let fills = match (self.fill.is_empty(), is_virtual) {
            (true, true) => vec![Fill::Points(VIRTUAL_FILL)],
            (true, false) => vec![Fill::Auto],
            (false, _) => once(self.fill),
        };
        if is_virtual && fills.contains(&Fill::Auto) {
            return Err(CliError::Usage(
                "--fill auto follows the time that frames take, and --clock virtual has none; give --fill N".into(),
            ));
        }
        if self.synth.is_some() && self.fields != [Decoded::Colors] {
            return Err(CliError::Usage(
                "--fields says what is decoded of files; a --synth scan is made as it is".into(),
            ));
        }
        if self.load.is_some() && !is_virtual {
            return Err(CliError::Usage(
                "--load is for --clock virtual; in real time, points come as they are read".into(),
            ));
        }
        let motion = |motion| match motion {
            MotionArg::Orbit => Some(Motion::Orbit),
            MotionArg::Walk => Some(Motion::Walk),
            MotionArg::Jump => Some(Motion::Jump),
            MotionArg::None => None,
        };
        let motions = match &self.path {
            Some(path) => vec![read_path(path)?],
            None => once(self.motion).into_iter().filter_map(motion).collect(),
        };
        let baselines = match (self.no_baselines, self.baselines.is_empty()) {
            (true, _) => Vec::new(),
            (false, true) => Variant::value_variants().to_vec(),
            (false, false) => once(self.baselines),
        };
        Ok(Measure {
            input: self.synth.map_or(Input::Files(self.inputs), Input::Synth),
            size: self.size,
            camera: self.camera.as_deref().map(read_camera).transpose()?,
            motions,
            backend,
            methods: once(self.method),
            encodings: once(self.encoding).into_iter().map(EncodingChoice::encoding).collect(),
            decoded: once(self.fields),
            fills,
            point_sizes: once(self.point_size),
            baselines,
            clock: self.clock,
            frames: self.frames.unwrap_or(FRAMES[usize::from(!is_virtual)]),
            load: self.load,
            repeat: self.repeat,
            seed: self.seed,
            threads: self.threads,
            command: command_line(env::args_os()),
        })
    }
}

struct Follow {
    folder: ReportDir,
    steps: Steps,
}

impl Watcher for Follow {
    fn step(&mut self, done: usize, total: usize, what: &str) {
        self.steps.step(done, total, what);
    }

    fn save(&mut self, report: &ConvergeReport) -> Result<(), ReportDirError> {
        let folder = &self.folder;
        folder.write("measure.csv", |out| write_csv(out, report))?;
        folder.write("index.html", |out| out.write_all(page(report).as_bytes()))?;
        // Last: it is what says that the folder holds a report.
        Ok(folder.write("measure.json", |out| Ok(serde_json::to_writer_pretty(out, report)?))?)
    }
}
