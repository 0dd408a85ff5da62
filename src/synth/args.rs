//! `firstlight synth` on the command line.

use std::{
    io::{IsTerminal, Write},
    path::PathBuf,
    time::Instant,
};

use super::{Scene, SynthError, SynthOptions, SynthSummary, write};
use crate::cli::parse_count;

/// Write a test scan.
///
/// The same options make the same file, byte for byte, on every machine.
#[derive(Debug, Clone, clap::Args)]
pub struct SynthArgs {
    /// What the scan shows
    #[arg(value_enum)]
    pub scene: Scene,
    /// The file to write; its extension, .las or .laz, decides about compression
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Number of points, exactly; k, M and G stand for thousands, millions, billions (1.5M)
    #[arg(short = 'n', long, value_name = "N", default_value = "1M", value_parser = parse_count)]
    pub points: u64,
    /// Another seed makes another scan
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Point record format, 0-3 or 6-8 [default: 7, or the richest that --las-version has]
    #[arg(long, value_name = "F")]
    pub point_format: Option<u8>,
    /// LAS version, 1.0 to 1.4 [default: 1.4, or 1.2 for point formats 0-3]
    #[arg(long, value_name = "V", value_parser = parse_version)]
    pub las_version: Option<(u8, u8)>,
    /// Grid step in metres
    #[arg(long, value_name = "M", default_value_t = 0.001)]
    pub scale: f64,
    /// Where the scene's centre lies, in metres
    #[arg(long, value_name = "X,Y,Z", default_value = "500000,5000000,0", value_parser = parse_triple, allow_hyphen_values = true)]
    pub origin: [f64; 3],
    /// The header's offset in metres [default: the origin]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub offset: Option<[f64; 3]>,
    /// No progress, no summary
    #[arg(short, long)]
    pub quiet: bool,
}

impl SynthArgs {
    /// What the arguments ask for, with what they leave open filled in.
    pub fn options(&self) -> SynthOptions {
        let (point_format, las_version) = match (self.point_format, self.las_version) {
            (Some(format), Some(version)) => (format, version),
            (Some(format), None) => (format, SynthOptions::default_version(format)),
            (None, Some(version)) => (SynthOptions::default_format(version), version),
            (None, None) => (7, (1, 4)),
        };
        SynthOptions {
            scene: self.scene,
            points: self.points,
            seed: self.seed,
            point_format,
            las_version,
            scale: self.scale,
            origin: self.origin,
            offset: self.offset,
        }
    }
}

/// Runs `firstlight synth`: writes the file, shows progress on a terminal, and one line at the end.
///
/// # Errors
/// As [`write()`].
pub fn run(args: &SynthArgs) -> Result<SynthSummary, SynthError> {
    let bar = if args.quiet || !std::io::stderr().is_terminal() {
        indicatif::ProgressBar::hidden()
    } else {
        let style = indicatif::ProgressStyle::with_template("{bar:30} {human_pos}/{human_len} points, {eta} left");
        let bar = indicatif::ProgressBar::new(args.points);
        style.map_or_else(|_| bar.clone(), |style| bar.clone().with_style(style))
    };
    let start = Instant::now();
    let summary = write(&args.options(), &args.output, &mut |points| bar.set_position(points));
    bar.finish_and_clear();
    let summary = summary?;
    if !args.quiet {
        let seconds = start.elapsed().as_secs_f64();
        let path = args.output.display();
        let (points, bytes) = (summary.points, summary.bytes);
        // If nobody listens, there is nobody to tell.
        let _ = writeln!(std::io::stderr(), "{path}: {points} points, {bytes} bytes, {seconds:.1} s");
    }
    Ok(summary)
}

fn parse_version(text: &str) -> Result<(u8, u8), String> {
    let expected = || format!("expected a LAS version such as 1.4, found {text:?}");
    let (major, minor) = text.split_once('.').ok_or_else(expected)?;
    Ok((major.parse().map_err(|_| expected())?, minor.parse().map_err(|_| expected())?))
}

fn parse_triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|x| x.trim().parse()).collect();
    numbers
        .ok()
        .and_then(|n| <[f64; 3]>::try_from(n).ok())
        .filter(|n| n.iter().all(|x| x.is_finite()))
        .ok_or_else(|| format!("expected three numbers such as 500000,5000000,0, found {text:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_and_triples() {
        assert_eq!(parse_version("1.4"), Ok((1, 4)));
        assert!(parse_version("14").is_err());
        assert_eq!(parse_triple("1,-2, 3.5"), Ok([1.0, -2.0, 3.5]));
        assert!(parse_triple("1,2").is_err());
        assert!(parse_triple("1,2,NaN").is_err());
    }
}
