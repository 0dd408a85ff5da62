//! One line per sample, for spreadsheets and scripts.

use std::io::{self, Write};

use super::{experiment::Bound, report::StabilityReport};

/// Columns. `is_true` is empty where a claim is not counted on this device.
const COLUMNS: &str = "experiment,role,method,quantity,value,bound,is_true,sample_number,sample";

/// Writes all samples.
///
/// # Errors
/// If writing fails.
pub fn write_csv(out: &mut dyn Write, report: &StabilityReport) -> io::Result<()> {
    writeln!(out, "{COLUMNS}")?;
    for entry in &report.experiments {
        for claim in &entry.claims {
            let bound = match claim.bound {
                Bound::AtLeast(bound) => format!(">= {bound}"),
                Bound::AtMost(bound) => format!("<= {bound}"),
            };
            let is_true = claim.is_true.map_or_else(String::new, |t| t.to_string());
            let (method, quantity) = (quoted(&claim.method), quoted(&claim.quantity));
            for (number, sample) in claim.samples.iter().enumerate() {
                let (name, role, value) = (entry.name, claim.role.name(), claim.value);
                writeln!(out, "{name},{role},{method},{quantity},{value},{bound},{is_true},{number},{sample}")?;
            }
        }
    }
    Ok(())
}

/// RFC 4180.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
