//! The program in its window, and a hand on its mouse and keys.

use std::{
    fs,
    io::{BufRead as _, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use super::{
    display::{Display, Shot},
    xserver::XServer,
};

pub struct Viewer<'d> {
    display: &'d Display,
    process: Child,
    log: Arc<Mutex<Vec<String>>>,
}

impl<'d> Viewer<'d> {
    /// Without a panel, so that the picture has the window for itself, and without anything remembered.
    pub fn start(display: &'d Display, arguments: &[&str]) -> Viewer<'d> {
        let settings = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window-settings.json");
        fs::write(&settings, r#"{"panel": false}"#).expect("settings");
        Viewer::start_with(display, &settings, arguments)
    }

    /// With a settings file of the test's own.
    pub fn start_with(display: &'d Display, settings: &Path, arguments: &[&str]) -> Viewer<'d> {
        // A new display has the mouse in its middle; off the picture, it shows no coordinates. (Without -noreset a
        // display forgets that with its last client.)
        let moved = Command::new("xdotool").args(["mousemove", "300", "790"]).env("DISPLAY", &display.name).status();
        assert!(moved.expect("xdotool").success());
        let mut process = Command::new(env!("CARGO_BIN_EXE_firstlight"))
            .args(arguments)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .env("FIRSTLIGHT_SETTINGS", settings)
            .env("WINIT_X11_SCALE_FACTOR", "1")
            .env("RUST_LOG", "firstlight=debug")
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("firstlight");
        let log = Arc::<Mutex<Vec<String>>>::default();
        let lines = BufReader::new(process.stderr.take().expect("stderr")).lines();
        let kept = log.clone();
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                kept.lock().unwrap().push(line);
            }
        });
        Viewer { display, process, log }
    }

    pub fn shot(&self) -> Shot {
        self.display.shot()
    }

    /// Once two screenshots in a row are equal: the last frame may still be on its way to the display.
    pub fn shot_at_rest(&self) -> Shot {
        let mut last = self.shot();
        for _ in 0..50 {
            std::thread::sleep(Duration::from_millis(200));
            let shot = self.shot();
            if shot.difference(&last) == 0 {
                return shot;
            }
            last = shot;
        }
        panic!("the picture does not come to rest");
    }

    /// Lines of the log that contain `text`.
    pub fn count(&self, text: &str) -> usize {
        self.log.lock().unwrap().iter().filter(|line| line.contains(text)).count()
    }

    pub fn said(&self, text: &str) -> bool {
        self.count(text) > 0
    }

    pub fn wait_for<T>(&mut self, what: &str, patience: Duration, look: impl Fn(&Self) -> Option<T>) -> T {
        let began = Instant::now();
        while began.elapsed() < patience {
            if let Some(found) = look(self) {
                return found;
            }
            if let Some(status) = self.process.try_wait().expect("wait") {
                panic!("ended ({status}) before {what}: {}", self.log.lock().unwrap().join("\n"));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("no {what} after {patience:?}: {}", self.log.lock().unwrap().join("\n"));
    }

    pub fn wait_for_line(&mut self, text: &str, patience: Duration) {
        self.wait_for(text, patience, |v| v.said(text).then_some(()));
    }

    /// Until the window comes to rest with `text` said before.
    pub fn wait_for_rest_after(&mut self, text: &str, patience: Duration) {
        self.wait_for(text, patience, |v| {
            let log = v.log.lock().unwrap();
            let said = log.iter().rposition(|line| line.contains(text))?;
            log[said..].iter().any(|line| line.contains("at rest")).then_some(())
        });
    }

    /// Until more lines than `before` contain `text`.
    pub fn wait_for_more(&mut self, text: &str, before: usize, patience: Duration) {
        self.wait_for(text, patience, |v| (v.count(text) > before).then_some(()));
    }

    pub fn xdotool(&self, script: &str) {
        let status = Command::new("xdotool")
            .args(script.split(' '))
            .env("DISPLAY", &self.display.name)
            .status()
            .expect("xdotool");
        assert!(status.success(), "xdotool {script}");
        // A hand takes its time as well, and frames see every step.
        std::thread::sleep(Duration::from_millis(60));
    }

    /// Without a window manager nobody else gives the window its focus.
    pub fn focus(&self) {
        self.xdotool("search --onlyvisible --name firstlight windowfocus --sync");
    }

    pub fn key(&self, key: &str) {
        self.focus();
        self.xdotool(&format!("key {key}"));
    }

    /// Processor time of all threads so far.
    pub fn cpu_time(&self) -> Duration {
        let stat = fs::read_to_string(format!("/proc/{}/stat", self.process.id())).expect("stat");
        // The name, in brackets, may hold anything; user and system time are the 12th and 13th after it.
        let fields: Vec<&str> = stat[stat.rfind(')').expect("name") + 1..].split_whitespace().collect();
        let ticks: u64 = fields[11..=12].iter().map(|t| t.parse::<u64>().expect("ticks")).sum();
        Duration::from_millis(ticks * 10)
    }

    /// Closes the window as a window manager does, and waits for the end of the program.
    pub fn close(&mut self, patience: Duration) -> ExitStatus {
        XServer::connect(&self.display.name).close_windows();
        self.wait_for_end(patience)
    }

    pub fn drop_file(&self, file: &Path) {
        XServer::connect(&self.display.name).drop_file(file);
    }

    pub fn terminate(&mut self, patience: Duration) -> ExitStatus {
        let pid = self.process.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &pid]).status().expect("kill").success());
        self.wait_for_end(patience)
    }

    fn wait_for_end(&mut self, patience: Duration) -> ExitStatus {
        let began = Instant::now();
        while began.elapsed() < patience {
            if let Some(status) = self.process.try_wait().expect("wait") {
                return status;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("still running after {patience:?}");
    }
}

impl Drop for Viewer<'_> {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
