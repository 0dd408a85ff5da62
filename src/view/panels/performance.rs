//! Where the time and the memory go: passes of the last frames, decoder threads, channels, GPU memory.

use std::{
    collections::VecDeque,
    fmt::Write as _,
    time::{Duration, Instant},
};

use eframe::egui::{Color32, Grid, Ui};
use egui_plot::{Legend, Line, Plot, PlotPoints};

use super::super::format::{bytes, count, duration, percent};
use crate::{device::PassTimes, source::ThreadTimes};

/// Frames that the plot shows.
const FRAMES: usize = 240;
/// Threads' speeds are averages over at least this long.
const RATE_OVER: Duration = Duration::from_millis(500);

type SecsOf = fn(&PassTimes) -> f64;

/// Passes by name, in the order of a frame.
const PASSES: [(&str, Color32, SecsOf); 9] = [
    ("whole frame", Color32::from_rgb(150, 160, 172), |t| t.undivided),
    ("insert", Color32::from_rgb(106, 182, 255), |t| t.insert),
    ("reproject", Color32::from_rgb(255, 184, 77), |t| t.reproject),
    ("fresh", Color32::from_rgb(160, 220, 110), |t| t.fresh),
    ("fill", Color32::from_rgb(240, 98, 98), |t| t.fill),
    ("index", Color32::from_rgb(186, 140, 255), |t| t.index),
    ("average", Color32::from_rgb(90, 205, 190), |t| t.average),
    ("average fill", Color32::from_rgb(60, 150, 140), |t| t.average_fill),
    ("resolve", Color32::from_rgb(240, 130, 190), |t| t.resolve),
];

/// What is measured while the window runs.
#[derive(Debug, Clone, Default)]
pub struct Performance {
    frames: VecDeque<Frame>,
    pub threads: Vec<Thread>,
    /// What the threads did when their speed was last taken.
    before: Option<(Instant, Vec<ThreadTimes>)>,
    /// Batches that wait between decoders and window, and for how many there is room.
    pub channel: Option<[usize; 2]>,
    /// Points that the window has taken and not yet stored.
    pub points_waiting: u64,
    pub points_stored: u64,
    pub fill_per_frame: u64,
    pub gpu_memory: Option<GpuMemory>,
    pub adapter: String,
    pub method: String,
}

/// One frame that was drawn.
#[derive(Debug, Clone, Copy)]
struct Frame {
    passes: PassTimes,
    /// From the frame before to this one; 0 after a rest.
    window_secs: f64,
}

/// A decoder thread.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Thread {
    pub times: ThreadTimes,
    /// Of the last half second while loading, of all its time afterwards.
    pub points_per_sec: f64,
}

/// Memory of the device, of this program.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GpuMemory {
    /// In buffers and pictures.
    pub used: u64,
    /// Taken from the system.
    pub reserved: u64,
}

impl Performance {
    /// To be called for each frame that was drawn.
    pub fn note_frame(&mut self, passes: PassTimes, window_secs: f64) {
        self.frames.push_back(Frame { passes, window_secs });
        while self.frames.len() > FRAMES {
            self.frames.pop_front();
        }
    }

    /// Takes what the threads did so far; `secs` is how long they have been at it, once they are done.
    pub fn note_threads(&mut self, now: Instant, times: Vec<ThreadTimes>, done_secs: Option<f64>) {
        if let Some(secs) = done_secs {
            let rate = |times: &ThreadTimes| times.points as f64 / secs.max(1e-3);
            self.threads = times.into_iter().map(|t| Thread { points_per_sec: rate(&t), times: t }).collect();
            self.before = None;
            return;
        }
        let elapsed = self.before.as_ref().map(|(at, _)| now.saturating_duration_since(*at));
        if elapsed.is_some_and(|elapsed| elapsed < RATE_OVER) {
            return;
        }
        let secs = elapsed.map_or(f64::INFINITY, |elapsed| elapsed.as_secs_f64());
        let before = self.before.take().map(|(_, before)| before).unwrap_or_default();
        let points_before = |name: &str| before.iter().find(|t| t.name == name).map_or(0, |t| t.points);
        let thread = |times: &ThreadTimes| Thread {
            points_per_sec: times.points.saturating_sub(points_before(&times.name)) as f64 / secs,
            times: times.clone(),
        };
        self.threads = times.iter().map(thread).collect();
        self.before = Some((now, times));
    }

    /// For a new scene.
    pub fn forget_threads(&mut self) {
        self.threads.clear();
        self.before = None;
    }

    /// Seconds of a pass in the frames kept: last, mean, most.
    fn summary(&self, of: impl Fn(&Frame) -> f64) -> Option<[f64; 3]> {
        let last = of(self.frames.back()?);
        let mean = self.frames.iter().map(&of).sum::<f64>() / self.frames.len() as f64;
        Some([last, mean, self.frames.iter().map(of).fold(0.0, f64::max)])
    }

    /// Rows of the table of passes; those that never took time are left out.
    fn passes(&self) -> Vec<(&'static str, [f64; 3])> {
        let mut rows: Vec<_> = PASSES
            .iter()
            .filter_map(|(name, _, of)| Some((*name, self.summary(|frame| of(&frame.passes))?)))
            .filter(|(_, [_, _, most])| *most > 0.0)
            .collect();
        rows.extend(self.summary(|frame| frame.passes.total()).map(|row| ("device in all", row)));
        rows.extend(self.summary(|frame| frame.window_secs).map(|row| ("window frame", row)));
        rows
    }

    /// All of it as text.
    pub fn to_text(&self) -> String {
        let mut text = format!("{} · {}\n", self.adapter, self.method);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\nlast {} frames\tlast\tmean\tmost", self.frames.len());
        for (name, row) in self.passes() {
            let _ = writeln!(text, "{name}\t{}\t{}\t{}", duration(row[0]), duration(row[1]), duration(row[2]));
        }
        let _ = writeln!(text, "\ndecoder thread\tpoints/s\tpoints\tread\tdecode\tconvert\twait");
        for Thread { times: t, points_per_sec } in &self.threads {
            let secs = [t.read_secs, t.decode_secs, t.convert_secs, t.wait_secs].map(duration).join("\t");
            let _ = writeln!(text, "{}\t{}\t{}\t{secs}", t.name, count(*points_per_sec as u64), t.points);
        }
        for (name, value) in self.figures() {
            let _ = writeln!(text, "{name}\t{value}");
        }
        text
    }

    fn figures(&self) -> Vec<(&'static str, String)> {
        let channel = self.channel.map_or("closed".into(), |[waiting, room]| format!("{waiting} of {room} batches"));
        let mut figures = vec![
            ("channel", channel),
            ("waiting for the store", format!("{} points", count(self.points_waiting))),
            ("stored", format!("{} points", count(self.points_stored))),
            ("fill per frame", format!("{} points", count(self.fill_per_frame))),
        ];
        match self.gpu_memory {
            Some(GpuMemory { used, reserved }) => {
                figures.push(("GPU memory used", format!("{} of {} taken", bytes(used), bytes(reserved))));
            }
            None => figures.push(("GPU memory used", "this driver does not tell".into())),
        }
        figures.push(("GPU memory free", "unknown: wgpu does not tell".into()));
        figures
    }
}

/// Shows the section.
pub fn show(ui: &mut Ui, performance: &Performance) {
    super::copy_button(ui, "Copy as text", "All figures below", || performance.to_text());
    plot(ui, performance);
    Grid::new("passes").num_columns(4).striped(true).show(ui, |ui| {
        for heading in ["pass", "last", "mean", "most"] {
            ui.small(heading);
        }
        ui.end_row();
        for (name, row) in performance.passes() {
            ui.label(name);
            for secs in row {
                ui.label(duration(secs));
            }
            ui.end_row();
        }
    });
    ui.separator();
    Grid::new("threads").num_columns(3).striped(true).show(ui, |ui| {
        for heading in ["decoder thread", "points/s", "busy"] {
            ui.small(heading);
        }
        ui.end_row();
        for Thread { times, points_per_sec } in &performance.threads {
            let name = ui.label(&times.name);
            ui.label(count(*points_per_sec as u64));
            let millis = |secs: f64| (secs * 1e3) as u64;
            ui.label(percent(millis(times.busy_secs()), millis(times.busy_secs() + times.wait_secs)));
            ui.end_row();
            name.on_hover_text(format!(
                "read {}, decode {}, convert {}, wait {}",
                duration(times.read_secs),
                duration(times.decode_secs),
                duration(times.convert_secs),
                duration(times.wait_secs)
            ));
        }
    });
    ui.separator();
    Grid::new("figures").num_columns(2).striped(true).show(ui, |ui| {
        for (name, value) in performance.figures() {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        }
    });
}

fn plot(ui: &mut Ui, performance: &Performance) {
    let plot = Plot::new("pass times")
        .height(120.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_axes([false, true])
        .include_x(0.0)
        .include_x(FRAMES as f64)
        .include_y(0.0)
        .include_y(1.0)
        .y_axis_formatter(|mark, _| format!("{} ms", mark.value))
        .legend(Legend::default());
    plot.show(ui, |plot| {
        for (name, color, of) in &PASSES {
            let times = performance.frames.iter().map(|frame| of(&frame.passes) * 1e3);
            if times.clone().any(|ms| ms > 0.0) {
                let points: PlotPoints<'_> = times.enumerate().map(|(i, ms)| [i as f64, ms]).collect();
                plot.line(Line::new(*name, points).color(*color));
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thread(name: &str, points: u64) -> ThreadTimes {
        ThreadTimes { name: name.into(), points, ..Default::default() }
    }

    #[test]
    fn speeds_are_those_of_the_last_half_second() {
        let mut performance = Performance::default();
        let start = Instant::now();
        performance.note_threads(start, vec![thread("a", 100)], None);
        assert_eq!(performance.threads[0].points_per_sec, 0.0, "nothing to compare with");
        performance.note_threads(start + RATE_OVER / 2, vec![thread("a", 999)], None);
        assert_eq!(performance.threads[0].times.points, 100, "too early");
        performance.note_threads(start + RATE_OVER, vec![thread("a", 600), thread("b", 50)], None);
        let rates: Vec<f64> = performance.threads.iter().map(|t| t.points_per_sec).collect();
        assert_eq!(rates, [1_000.0, 100.0]);
        performance.note_threads(start + RATE_OVER, vec![thread("a", 1_000)], Some(4.0));
        assert_eq!(performance.threads[0].points_per_sec, 250.0, "of all its time once it is done");
    }

    #[test]
    fn the_text_has_all_figures() {
        let mut performance =
            Performance { adapter: "llvmpipe".into(), method: "early-z".into(), ..Default::default() };
        for i in 1..=3 {
            let passes = PassTimes { fill: f64::from(i) * 1e-3, ..Default::default() };
            performance.note_frame(passes, 0.016);
        }
        performance.note_threads(Instant::now(), vec![thread("laz-0", 1_234_567)], Some(1.0));
        performance.channel = Some([3, 4]);
        performance.gpu_memory = Some(GpuMemory { used: 3 << 20, reserved: 256 << 20 });
        let text = performance.to_text();
        for part in [
            "llvmpipe · early-z",
            "fill\t3.0 ms\t2.0 ms\t3.0 ms",
            "window frame\t16.0 ms",
            "laz-0\t1.23 M\t1234567",
            "3 of 4 batches",
            "3.00 MiB of 256 MiB taken",
            "GPU memory free\tunknown",
        ] {
            assert!(text.contains(part), "{part} is not in:\n{text}");
        }
        assert!(!text.contains("reproject"), "a pass that took no time is left out");
        for _ in 0..2 * FRAMES {
            performance.note_frame(PassTimes::default(), 0.0);
        }
        assert_eq!(performance.frames.len(), FRAMES);
    }
}
