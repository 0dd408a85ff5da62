//! `firstlight point`.

use std::{path::PathBuf, sync::atomic::AtomicBool};

use clap::Args;

use super::{CliError, ExitStatus};
use crate::{
    headless::{Destination, HeadlessError},
    inspect::PointRecord,
    source::RecordFile,
};

/// Shown after the options.
pub const EXAMPLES: &str = "\
Examples:
  firstlight point scan.laz 0
  firstlight point scan.laz 1200 1201 1202 --csv > points.csv
  firstlight point scan.laz 1200 --json | jq .gps_time";

#[derive(Debug, Args)]
pub struct PointArgs {
    /// A LAS or LAZ file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Numbers of the records, counted from 0 in the order of the file, as in `render --ids`
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<u64>,
    #[command(flatten)]
    form: FormArgs,
}

/// In which form points are printed.
#[derive(Debug, Clone, Copy, Args)]
pub struct FormArgs {
    /// Print JSON: one object, or a list of several
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print CSV: a line of names, and a line per point
    #[arg(long)]
    csv: bool,
}

pub fn run(args: PointArgs) -> Result<ExitStatus, CliError> {
    let never = AtomicBool::new(false);
    let file = RecordFile::open(&args.file, &never).map_err(HeadlessError::Input)?;
    let records: Result<Vec<PointRecord>, _> =
        args.records.iter().map(|&record| PointRecord::read_from(&file, record, &never)).collect();
    print(&args.form.text(&records?))?;
    Ok(ExitStatus::Ok)
}

impl FormArgs {
    /// The points, each line ended.
    pub fn text(&self, records: &[PointRecord]) -> String {
        if self.json {
            let objects: Vec<String> = records.iter().map(PointRecord::json).collect();
            return match &objects[..] {
                [object] => format!("{object}\n"),
                _ => format!("[\n{}\n]\n", objects.join(",\n")),
            };
        }
        if !self.csv {
            return records.iter().map(PointRecord::text).collect::<Vec<_>>().join("\n");
        }
        // Files differ in their fields: a new header begins where they do.
        let mut text = String::new();
        let mut header = String::new();
        for record in records {
            let own = record.csv_header();
            if own != header {
                text += &format!("{own}\n");
                header = own;
            }
            text += &format!("{}\n", record.csv_row());
        }
        text
    }
}

/// Prints to standard output. A reader that has seen enough (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), HeadlessError> {
    Ok(Destination::Stdout.write(|out| out.write_all(text.as_bytes()))?)
}
