//! `firstlight render`.

use std::{
    fs,
    io::{self, IsTerminal},
    path::{Path, PathBuf},
    time::Instant,
};

use clap::{Args, ValueEnum};

use super::{
    CliError, ExitStatus,
    look::LookArgs,
    say,
    values::{self, EncodingChoice},
};
use crate::{
    headless::{self, BackendChoice, Destination, HeadlessError, Outputs, ProgressStyle, Report, Settings, Stop},
    render::{Camera, INSERTION_POINTS, Look, RasterChoice},
    source,
};

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// LAS and LAZ files, and folders of them
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// The picture to write (`-`: standard output)
    #[arg(short, long, value_name = "OUT.png", required_unless_present_any = ["ids", "depth", "json"])]
    output: Option<PathBuf>,
    /// Width and height of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1600x900", value_parser = values::parse_size)]
    size: [u32; 2],
    /// Where to look from: {"eye":[x,y,z],"target":[x,y,z],"up":[0,0,1],"fov_y_deg":60}, with
    /// "projection":"orthographic" for parallel lines, or a file that holds it; eye and target in the file's own
    /// coordinates; by default all that --clip and --slab leave of the scene,
    /// from the south and above; a section from across
    #[arg(long, value_name = "JSON|CAM.json")]
    camera: Option<PathBuf>,
    /// How the GPU turns points into pixels: a method's name, or NAME:64 (:128, :256) with its workgroup
    /// size; auto measures which is the fastest
    #[arg(long, value_name = "auto|NAME", default_value = "auto", value_parser = values::parse_method)]
    method: RasterChoice,
    /// Where to draw; auto takes a GPU if there is one
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArg,
    /// Random points that each frame tries (1M, 250k, …); by default 4M, or 1M with --stop frames=N and
    /// points=N
    #[arg(long, value_name = "N", value_parser = values::parse_points)]
    fill: Option<u32>,
    /// Fixes the order of the points in the store, and with it every frame
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// When to stop: converged (all points loaded and drawn), frames=N, or points=N (the first N points,
    /// all of them drawn)
    #[arg(long, value_name = "WHEN", default_value = "converged", value_parser = values::parse_stop)]
    stop: Stop,
    /// Load everything and draw all points at once, not progressively: the picture to compare with
    #[arg(long)]
    brute_force: bool,
    /// Write which record each pixel shows: int64, −1 for background, counted through all files in order
    #[arg(long, value_name = "OUT.npy")]
    ids: Option<PathBuf>,
    /// Write the distance of each pixel along the viewing direction: float32, +inf for background
    #[arg(long, value_name = "OUT.npy")]
    depth: Option<PathBuf>,
    /// Write what was read, drawn and measured (`-`: standard output)
    #[arg(long, value_name = "REPORT.json")]
    json: Option<PathBuf>,
    /// Decoder threads; by default one per core, less one
    #[arg(long, value_name = "N", value_parser = values::parse_threads)]
    threads: Option<usize>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
    /// Points that enter the store at a time; fixes their slots together with the seed
    #[arg(long, value_name = "N", default_value_t = INSERTION_POINTS, value_parser = values::parse_insertion, hide = true)]
    insertion_points: u32,
    /// How the store holds positions; no pixel depends on it
    #[arg(long, value_enum, default_value_t, hide = true)]
    encoding: EncodingChoice,
    #[command(flatten)]
    look: LookArgs,
}

/// [`BackendChoice`] on the command line.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum BackendArg {
    #[default]
    Auto,
    Gpu,
    Cpu,
}

pub fn run(args: RenderArgs, started: Instant) -> Result<ExitStatus, CliError> {
    let quiet = args.quiet;
    let settings = args.validate(started)?;
    let report = headless::render(&settings).map_err(with_help)?;
    Ok(tell(&report, quiet))
}

/// Says what a run gave, and which exit status that is.
pub fn tell(report: &Report, quiet: bool) -> ExitStatus {
    let status = tell_notes(report, quiet);
    if !quiet {
        say(&summary(report));
    }
    status
}

/// Says what a run left out, decided or ran into, and which exit status that is.
pub fn tell_notes(report: &Report, quiet: bool) -> ExitStatus {
    for file in &report.files {
        if let Some(error) = &file.error {
            // Not silenced by --quiet: points are missing.
            say(&format!("firstlight: {}", with_path(&file.path, error)));
        }
        for warning in file.warnings.iter().filter(|_| !quiet) {
            say(&format!("firstlight: {}", with_path(&file.path, warning)));
        }
    }
    for note in report.notes.iter().filter(|_| !quiet) {
        say(&format!("firstlight: {note}"));
    }
    if report.is_partial() { ExitStatus::Partial } else { ExitStatus::Ok }
}

/// Messages of the reader name the file, or not.
fn with_path(path: &Path, message: &str) -> String {
    let path = path.display().to_string();
    if message.contains(&path) { message.into() } else { format!("{path}: {message}") }
}

fn summary(report: &Report) -> String {
    let outputs = &report.outputs;
    let written = [&outputs.picture, &outputs.ids, &outputs.depth, &outputs.report];
    let name =
        |path: &PathBuf| if path == Path::new("-") { "standard output".into() } else { path.display().to_string() };
    let names: Vec<String> = written.into_iter().flatten().map(name).collect();
    let [width, height] = report.size_px;
    let missing = match report.points_missing {
        Some(missing) if missing > 0 => format!(" ({} missing)", headless::grouped(missing)),
        _ => String::new(),
    };
    let shown = match report.points_shown {
        Some(shown) if shown < report.points_stored => format!(", {} of them shown", headless::grouped(shown)),
        _ => String::new(),
    };
    format!(
        "wrote {}: {width}x{height} pixels, {} points{missing}{shown}, {} frame{}, {:.2} s, {} on {}",
        names.join(", "),
        headless::grouped(report.points_stored),
        report.frames,
        if report.frames == 1 { "" } else { "s" },
        report.seconds.to_picture.unwrap_or_default(),
        report.method,
        report.adapter,
    )
}

pub fn with_help(error: HeadlessError) -> CliError {
    use crate::render::RenderError;
    match error {
        HeadlessError::Render(error @ RenderError::NoAdapter(_)) => CliError::NoDevice {
            error,
            help: "leave out --method and --backend, or say --backend cpu, to draw on the processor",
        },
        HeadlessError::Render(error @ RenderError::Unsupported { .. }) => {
            CliError::NoDevice { error, help: "--method auto takes one that works" }
        }
        other => other.into(),
    }
}

/// What `--backend` and `--method` say together.
pub fn backend_choice(backend: BackendArg, method: RasterChoice) -> Result<BackendChoice, CliError> {
    match (backend, method) {
        (BackendArg::Cpu, RasterChoice::Auto) => Ok(BackendChoice::Cpu),
        (BackendArg::Cpu, _) => {
            Err(CliError::Usage("--method chooses among the GPU's methods; leave it out with --backend cpu".into()))
        }
        (BackendArg::Gpu, _) => Ok(BackendChoice::Gpu),
        (BackendArg::Auto, _) => Ok(BackendChoice::Auto),
    }
}

impl RenderArgs {
    /// What is shown of which inputs.
    #[cfg(test)]
    pub fn view(&self) -> ((Look, Option<Camera>, [u32; 2]), Vec<PathBuf>) {
        let camera = self.camera.as_deref().map(|path| read_camera(path).expect("a camera"));
        ((self.look.look(Look::default().point_size), camera, self.size), self.inputs.clone())
    }

    fn validate(self, started: Instant) -> Result<Settings, CliError> {
        let usage = |message: &str| Err(CliError::Usage(message.into()));
        if self.brute_force && matches!(self.stop, Stop::Frames(_)) {
            return usage("--brute-force draws one frame of all points; --stop frames=N does not go with it");
        }
        let backend = backend_choice(self.backend, self.method)?;
        let camera = self.camera.as_deref().map(read_camera).transpose()?;
        Ok(Settings {
            outputs: self.outputs()?,
            size: self.size,
            camera,
            backend,
            method: self.method,
            encoding: self.encoding.encoding(),
            fill: self.fill,
            look: self.look.look(Look::default().point_size),
            seed: self.seed,
            insertion_points: self.insertion_points,
            stop: self.stop,
            brute_force: self.brute_force,
            threads: self.threads,
            progress: progress_style(self.quiet),
            started,
            inputs: self.inputs,
        })
    }

    fn outputs(&self) -> Result<Outputs, CliError> {
        self.output.as_deref().map_or(Ok(()), check_picture_name)?;
        let named = [("-o", &self.output), ("--ids", &self.ids), ("--depth", &self.depth), ("--json", &self.json)];
        let mut checked: Vec<(&str, Destination)> = Vec::new();
        // Also the files of folders: a picture must not replace a scan.
        let (files, _) = source::list_files(&self.inputs);
        let inputs: Vec<PathBuf> = files.iter().filter_map(|path| fs::canonicalize(path).ok()).collect();
        let [output, ids, depth, json] = named.map(|(flag, path)| -> Result<_, CliError> {
            let Some(path) = path else { return Ok(None) };
            let destination = Destination::check(path).map_err(HeadlessError::from)?;
            if let Destination::File { place, .. } = &destination
                && inputs.contains(place)
            {
                return Err(CliError::Usage(format!("{flag} {}: that is one of the inputs", path.display())));
            }
            if let Some((other, _)) = checked.iter().find(|(_, taken)| is_same_place(taken, &destination)) {
                return Err(CliError::Usage(format!("{other} and {flag} both write to {}", path.display())));
            }
            checked.push((flag, destination.clone()));
            Ok(Some(destination))
        });
        Ok(Outputs { picture: output?, ids: ids?, depth: depth?, report: json? })
    }
}

/// Extensions of pictures that are no PNG, for which a name says something that the file would not be.
const OTHER_PICTURES: [&str; 12] =
    ["jpg", "jpeg", "jxl", "avif", "webp", "gif", "bmp", "tif", "tiff", "exr", "svg", "pdf"];

fn check_picture_name(path: &Path) -> Result<(), CliError> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    if OTHER_PICTURES.iter().any(|other| extension.eq_ignore_ascii_case(other)) {
        return Err(CliError::Usage(format!(
            "-o {}: pictures are written as PNG; name it {}",
            path.display(),
            path.with_extension("png").display()
        )));
    }
    Ok(())
}

/// True if one output would overwrite the other. Devices such as `/dev/null` take any number.
fn is_same_place(a: &Destination, b: &Destination) -> bool {
    match (a, b) {
        (Destination::File { place: a, .. }, Destination::File { place: b, .. }) => a == b,
        (Destination::Stdout, Destination::Stdout) => true,
        _ => false,
    }
}

/// The camera of `--camera`: JSON, or a file that holds it.
pub fn read_camera(path: &Path) -> Result<Camera, CliError> {
    let text = match path.to_str().filter(|text| text.trim_start().starts_with('{')) {
        Some(json) => json.to_owned(),
        None => fs::read_to_string(path)
            .map_err(|error| CliError::Usage(format!("--camera {}: {error}", path.display())))?,
    };
    serde_json::from_str(&text).map_err(|error| {
        CliError::Usage(format!(
            r#"--camera {}: expected {{"eye":[x,y,z],"target":[x,y,z],"up":[0,0,1],"fov_y_deg":60}}: {error}"#,
            path.display()
        ))
    })
}

pub fn progress_style(quiet: bool) -> ProgressStyle {
    if quiet {
        ProgressStyle::Silent
    } else if io::stderr().is_terminal() {
        ProgressStyle::Bar
    } else {
        ProgressStyle::Lines
    }
}
