//! A display of the test's own, and pictures of it.

use std::{
    io::{BufRead as _, BufReader},
    path::PathBuf,
    process::{Child, Command, Stdio},
};

use firstlight::render::{GpuBackend, Raster, Shading};

/// As large as the window, which then fills it.
const SIZE: (usize, usize) = (1280, 800);
/// Pixels at the lower edge that the overlay's lines take.
const BAR: usize = 60;

/// A running Xvfb; ends with the value.
pub struct Display {
    server: Child,
    pub name: String,
}

impl Display {
    /// `None`, loudly, if this machine lacks something; where FIRSTLIGHT_REQUIRE_DISPLAY is set, that is
    /// a failure.
    pub fn start() -> Option<Display> {
        match Display::try_start() {
            Ok(display) => Some(display),
            Err(why) => {
                assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_DISPLAY").is_none(), "the window must be tested: {why}");
                eprintln!("SKIPPED: {why}; the window was not tested");
                None
            }
        }
    }

    fn try_start() -> Result<Display, String> {
        for (tool, package) in [("xdotool", "xdotool"), ("import", "imagemagick"), ("Xvfb", "xvfb")] {
            // None of them can do anything without a display, but they can say so.
            let mut ask = Command::new(tool);
            ask.arg("-help").env_remove("DISPLAY").stdout(Stdio::null()).stderr(Stdio::null());
            ask.status().map_err(|error| format!("{tool} (package {package}): {error}"))?;
        }
        GpuBackend::headless(Raster::TwoPass32.into()).map_err(|error| error.to_string())?;
        let screen = format!("{}x{}x24", SIZE.0, SIZE.1);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("Xvfb: {error}"))?;
        let mut number = String::new();
        // Xvfb writes the number when it is ready.
        let read = BufReader::new(server.stdout.take().expect("stdout")).read_line(&mut number);
        let display = Display { server, name: format!(":{}", number.trim()) };
        match read {
            Ok(1..) => Ok(display),
            _ => Err("Xvfb found no display number".into()),
        }
    }

    pub fn shot(&self) -> Shot {
        let output = Command::new("import")
            .args(["-window", "root", "-depth", "8", "PNG24:-"])
            .env("DISPLAY", &self.name)
            .output()
            .expect("import");
        assert!(output.status.success(), "import: {}", String::from_utf8_lossy(&output.stderr));
        let mut reader = png::Decoder::new(std::io::Cursor::new(&output.stdout)).read_info().expect("PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("size")];
        let info = reader.next_frame(&mut bytes).expect("PNG");
        assert_eq!((info.color_type, info.width as usize, info.height as usize), (png::ColorType::Rgb, SIZE.0, SIZE.1));
        Shot { pixels: bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect(), png: output.stdout }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// What is on the display, row by row.
pub struct Shot {
    pixels: Vec<[u8; 3]>,
    png: Vec<u8>,
}

impl Shot {
    /// Without the overlay's lines.
    fn scene(&self) -> &[[u8; 3]] {
        &self.pixels[..SIZE.0 * (SIZE.1 - BAR)]
    }

    /// Pixels that show something. Before the window is there, the display is black.
    pub fn points(&self) -> usize {
        let background = Shading::default().background;
        let is_black = self.pixels.iter().all(|p| *p == [0; 3]);
        if is_black { 0 } else { self.count(|p| *p != background) }
    }

    pub fn count(&self, which: impl Fn(&[u8; 3]) -> bool) -> usize {
        self.scene().iter().filter(|p| which(p)).count()
    }

    /// The colour of one pixel.
    pub fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * SIZE.0 + x]
    }

    /// Pixels that are not the same.
    pub fn difference(&self, other: &Shot) -> usize {
        self.scene().iter().zip(other.scene()).filter(|(a, b)| a != b).count()
    }

    /// For people to look at.
    pub fn save(&self, name: &str) {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("window-{name}.png"));
        std::fs::write(path, &self.png).expect("screenshot");
    }
}
