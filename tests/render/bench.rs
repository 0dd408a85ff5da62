//! What all of these tests need: a folder, scans in it, runs of the program, and readers of its outputs.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::OnceLock,
};

use firstlight::{
    render::{GpuBackend, RasterChoice},
    synth::{self, Scene, SynthOptions},
};
use tempfile::TempDir;

/// How a run ended.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Run {
    /// Panics unless the run ended with `code`.
    #[track_caller]
    pub fn expect(self, code: i32) -> Run {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        self
    }

    /// Messages of the program itself; a GPU driver adds lines of its own.
    pub fn messages(&self) -> Vec<&str> {
        self.stderr.lines().filter(|line| line.starts_with("firstlight: ")).collect()
    }
}

/// A folder of its own for each test.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn new() -> Bench {
        Bench { folder: tempfile::tempdir().unwrap() }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, contents).unwrap();
        path
    }

    /// Names in the folder, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// A scan with steep coordinates (UTM), LAS or LAZ by its name.
    pub fn scan(&self, name: &str, scene: Scene, points: u64) -> PathBuf {
        let path = self.path(name);
        let options = SynthOptions { points, point_format: 3, las_version: (1, 2), ..SynthOptions::new(scene) };
        synth::write(&options, &path, &mut |_| {}).unwrap();
        path
    }

    /// Runs the program in this folder; arguments are split at spaces (no path here has any).
    pub fn run(&self, args: &str) -> Run {
        let output = self.command(args).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        Run { code: output.status.code(), stdout: output.stdout, stderr }
    }

    pub fn command(&self, args: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_firstlight"));
        command.current_dir(self.folder.path()).args(args.split_whitespace()).stdin(Stdio::null());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("RUST_LOG");
        command
    }

    /// `firstlight render` with all outputs, which has to succeed.
    #[track_caller]
    pub fn render(&self, args: &str) -> Outputs {
        let args = format!("render {args} -o out.png --ids ids.npy --depth depth.npy --json report.json --quiet");
        let run = self.run(&args).expect(0);
        assert!(run.messages().is_empty(), "--quiet is quiet: {}", run.stderr);
        Outputs::read(self)
    }
}

/// The outputs of [`Bench::render`].
#[derive(Clone, PartialEq)]
pub struct Outputs {
    pub png: Vec<u8>,
    /// Height and width.
    pub shape: [usize; 2],
    pub ids: Vec<i64>,
    pub depth: Vec<f32>,
    pub report: serde_json::Value,
}

impl Outputs {
    pub fn read(bench: &Bench) -> Outputs {
        let (shape, ids) = read_npy(&bench.path("ids.npy"), "<i8", i64::from_le_bytes);
        let (depth_shape, depth) = read_npy(&bench.path("depth.npy"), "<f4", f32::from_le_bytes);
        assert_eq!(shape, depth_shape);
        let report = serde_json::from_slice(&fs::read(bench.path("report.json")).unwrap()).unwrap();
        Outputs { png: fs::read(bench.path("out.png")).unwrap(), shape, ids, depth, report }
    }

    /// Red, green, blue per pixel.
    pub fn rgb(&self) -> Vec<[u8; 3]> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(&self.png)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        assert_eq!([info.height as usize, info.width as usize], self.shape);
        bytes.as_chunks().0.to_vec()
    }

    pub fn covered(&self) -> usize {
        self.ids.iter().filter(|&&id| id >= 0).count()
    }

    /// Number of pixels that show another record.
    #[track_caller]
    pub fn differing_ids(&self, other: &Outputs) -> usize {
        assert_eq!(self.shape, other.shape);
        self.ids.iter().zip(&other.ids).filter(|(a, b)| a != b).count()
    }
}

fn read_npy<T, const N: usize>(path: &Path, descr: &str, value: fn([u8; N]) -> T) -> ([usize; 2], Vec<T>) {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(end % 64, 0);
    let header = std::str::from_utf8(&bytes[10..end]).unwrap();
    let (before, after) = header.split_once("'shape': (").unwrap();
    assert_eq!(before, format!("{{'descr': '{descr}', 'fortran_order': False, "));
    let numbers: Vec<usize> = after.split_once(')').unwrap().0.split(", ").map(|n| n.parse().unwrap()).collect();
    let shape: [usize; 2] = numbers.try_into().unwrap();
    let (values, rest) = bytes[end..].as_chunks::<N>();
    assert!(rest.is_empty());
    assert_eq!(values.len(), shape[0] * shape[1]);
    (shape, values.iter().map(|&v| value(v)).collect())
}

/// The folder of real scans, if there is one: `FIRSTLIGHT_DATA`, or `../shared/data`.
pub fn data() -> Option<PathBuf> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("FIRSTLIGHT_DATA").map_or(default, PathBuf::from);
    if !folder.is_dir() {
        eprintln!("SKIPPED: no real scans in {} (FIRSTLIGHT_DATA names another folder)", folder.display());
        return None;
    }
    Some(fs::canonicalize(folder).unwrap())
}

/// True if there is a GPU adapter; else a loud line, or a failure where one is required.
pub fn gpu_or_skip() -> bool {
    static GPU: OnceLock<Result<(), String>> = OnceLock::new();
    match GPU.get_or_init(|| GpuBackend::headless(RasterChoice::Auto).map(|_| ()).map_err(|e| e.to_string())) {
        Ok(()) => true,
        Err(error) => {
            assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_GPU").is_none(), "a GPU is required: {error}");
            eprintln!("SKIPPED (no GPU adapter): {error}");
            false
        }
    }
}

/// Ways to draw: the CPU backend, and each of the GPU's rasterizers if there is a GPU.
pub fn ways_to_draw() -> Vec<&'static str> {
    let mut ways = vec!["--backend cpu"];
    if gpu_or_skip() {
        ways.extend(["--method early-z", "--method two-pass-32", "--method reduce-early-z:64", "--method points"]);
    }
    ways
}
