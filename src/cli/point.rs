//! `firstlight point`.

use std::{ops::RangeInclusive, path::PathBuf, sync::atomic::AtomicBool};

use clap::Args;

use super::{CliError, ExitStatus, values};
use crate::{
    headless::{Destination, HeadlessError},
    inspect::{self, Field, PointRecord},
    source::{RecordError, RecordFile},
};

#[derive(Debug, Args)]
pub struct PointArgs {
    /// A LAS or LAZ file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Numbers of the records, counted from 0 in the order of the file, as in `render --ids`; 1200..1205 are six
    #[arg(value_name = "RECORD", required = true, value_parser = values::parse_records)]
    records: Vec<RangeInclusive<u64>>,
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

/// What is printed of a point: its fields, and its card.
pub struct Sheet {
    pub fields: Vec<Field>,
    pub card: Vec<(String, String)>,
}

pub fn run(args: PointArgs) -> Result<ExitStatus, CliError> {
    let never = AtomicBool::new(false);
    let file = RecordFile::open(&args.file, &never).map_err(HeadlessError::Input)?;
    let read = |record: u64| {
        let record = PointRecord::read_from(&file, record, &never)?;
        Ok(Some(Sheet { fields: record.fields(), card: record.card() }))
    };
    // Before a file is read to its end.
    if let Some(range) = args.records.iter().find(|range| *range.end() >= file.points()) {
        let (path, record, points) = (file.path().to_owned(), *range.end(), file.points());
        return Err(RecordError::OutOfRange { path, record, points }.into());
    }
    let sheets: Result<Vec<_>, RecordError> = args.records.into_iter().flatten().map(read).collect();
    print(&args.form.text(&sheets?))?;
    Ok(ExitStatus::Ok)
}

impl FormArgs {
    /// The points, each line ended. What is none is null in JSON, and else left out.
    pub fn text(&self, sheets: &[Option<Sheet>]) -> String {
        if self.json {
            let json = |sheet: &Option<Sheet>| sheet.as_ref().map_or("null".into(), |s| inspect::json(&s.fields));
            return match sheets {
                [sheet] => format!("{}\n", json(sheet)),
                _ => format!("[\n{}\n]\n", sheets.iter().map(json).collect::<Vec<_>>().join(",\n")),
            };
        }
        let sheets = sheets.iter().flatten();
        if !self.csv {
            return sheets.map(|sheet| inspect::lines(&sheet.card)).collect::<Vec<_>>().join("\n");
        }
        // Files differ in their fields: a new header begins where they do.
        let (mut text, mut header) = (String::new(), String::new());
        for Sheet { fields, .. } in sheets {
            let own = inspect::csv_header(fields);
            if own != header {
                text += &format!("{own}\n");
                header = own;
            }
            text += &format!("{}\n", inspect::csv_row(fields));
        }
        text
    }
}

/// Prints to standard output. A reader that has seen enough (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), HeadlessError> {
    Ok(Destination::Stdout.write(|out| out.write_all(text.as_bytes()))?)
}
