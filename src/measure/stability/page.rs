//! The report as one page, and its summary as Markdown.

use super::{
    experiment::{Bound, Claim, Role},
    report::{Entry, StabilityReport, TITLE},
};
use crate::measure::html::{self, Table, escape};

const STYLE: &str = "<style>.strip { display: flex; flex-wrap: wrap; gap: 1em; margin-bottom: 1em; } \
.strip img { image-rendering: pixelated; max-width: 100%; height: auto; } .strip figcaption { font-weight: 400; } \
.charts { grid-template-columns: repeat(auto-fill, minmax(min(100%, 34em), 1fr)); } \
th, td { max-width: 30em; text-align: left; vertical-align: top; }</style>\n";

/// The page.
pub fn page(report: &StabilityReport) -> String {
    let machine = &report.machine;
    let facts = [
        format!("device: {}", report.device),
        format!("machine: {}, {} cores, {}", machine.processor, machine.cores, machine.system),
        format!("firstlight {}{}", report.version, if report.complete { "" } else { "; not all experiments have run" }),
    ];
    let facts: String = facts.iter().map(|fact| format!("<li>{}</li>", escape(fact))).collect();
    let mut body = format!("{STYLE}<ul>{facts}</ul>\n<pre>{}</pre>\n<p>{ABOUT}</p>\n", escape(&report.command));
    body.push_str(&summary(report).html());
    report.experiments.iter().for_each(|entry| body.push_str(&section(entry)));
    html::page(TITLE, &body)
}

const ABOUT: &str = "Each experiment shows a method failing by a number, and this program's choice holding where it fails. \
If either stops being true, the command ends with exit code 4.";

/// The summary, as Markdown.
pub fn markdown(report: &StabilityReport) -> String {
    summary(report).markdown()
}

/// A row per experiment: of the claims of each side the one nearest to its bound, or across it.
fn summary(report: &StabilityReport) -> Table {
    let columns = ["experiment", "fails", "", "holds", "", "verdict"];
    let mut table = Table::new("What fails, what holds", &columns);
    for entry in &report.experiments {
        let mut row = vec![entry.name.to_owned()];
        for role in [Role::Fails, Role::Holds] {
            let told =
                entry.claims.iter().filter(|claim| claim.role == role).min_by(|a, b| margin(a).total_cmp(&margin(b)));
            row.push(told.map_or_else(String::new, |claim| claim.method.clone()));
            row.push(told.map_or_else(String::new, |claim| format!("{}: {}", claim.quantity, number(claim.value))));
        }
        row.push(verdict(entry).into());
        table.rows.push(row);
    }
    table
}

/// How far a claim is from being untrue: below 0 it is; those that are not counted last.
fn margin(claim: &Claim) -> f64 {
    let margin = match claim.bound {
        Bound::AtLeast(bound) => (claim.value - bound) / bound.abs().max(1e-9),
        Bound::AtMost(bound) => (bound - claim.value) / bound.abs().max(1e-9),
    };
    if claim.is_true.is_some() { margin } else { f64::MAX }
}

fn verdict(entry: &Entry) -> &'static str {
    match (entry.verdict(Role::Fails), entry.verdict(Role::Holds)) {
        (_, Some(false)) => "OURS DOES NOT HOLD",
        (Some(false), _) => "NO LONGER FAILS",
        (Some(true), Some(true)) => "as expected",
        (None, Some(true)) => "holds; failure not shown on this device",
        (_, None) => "not shown on this device",
    }
}

fn section(entry: &Entry) -> String {
    let mut out = format!("<h2 id=\"{0}\">{0}</h2>\n<p>{1}</p>\n", escape(entry.name), escape(entry.what));
    let facts = [("Fails", entry.fails), ("Must hold", entry.holds), ("From", entry.source)];
    let facts: String = facts.iter().map(|(name, text)| format!("<li>{name}: {}</li>", escape(text))).collect();
    out.push_str(&format!("<ul>{facts}</ul>\n"));
    let columns = ["method", "measured", "bound, and why", "value", "is so"];
    let mut table = Table::new(&format!("{} ({:.1} s)", verdict(entry), entry.secs), &columns);
    for claim in &entry.claims {
        let (sign, bound) = match claim.bound {
            Bound::AtLeast(bound) => ("≥", bound),
            Bound::AtMost(bound) => ("≤", bound),
        };
        let is_so = match (claim.is_true, &claim.not_counted) {
            (Some(true), _) => "yes".into(),
            (Some(false), _) => "NO".into(),
            (None, why) => format!("not counted: {}", why.as_deref().unwrap_or("not shown here")),
        };
        table.rows.push(vec![
            format!("{}: {}", claim.role.name(), claim.method),
            claim.quantity.clone(),
            format!("{sign} {}: {}", number(bound), claim.reason),
            number(claim.value),
            is_so,
        ]);
    }
    out.push_str(&table.html());
    entry.notes.iter().for_each(|note| out.push_str(&format!("<p>{}</p>\n", escape(note))));
    entry.outcome.pictures.iter().for_each(|strip| out.push_str(&strip.html()));
    if !entry.outcome.charts.is_empty() {
        let figures: String = entry.outcome.charts.iter().map(|chart| chart.figure()).collect();
        out.push_str(&format!("<div class=\"charts\">\n{figures}</div>\n"));
    }
    out
}

/// A number that is easy to read: whole, or with about three digits that count.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    match value {
        v if v.is_nan() => "not a number".into(),
        v if v.is_infinite() => (if v > 0.0 { "∞" } else { "−∞" }).into(),
        0.0 => "0".into(),
        v if v.fract() == 0.0 && size < 1e7 => format!("{v}"),
        v if !(1e-3..1e7).contains(&size) => format!("{v:.1e}"),
        v if size >= 100.0 => format!("{v:.0}"),
        v if size >= 10.0 => format!("{v:.1}"),
        v if size >= 1.0 => format!("{v:.2}"),
        v => format!("{v:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let values = [0.0, 7.0, 0.12345, 12.345, 1234.5, 1e9, 2e-7, f64::INFINITY];
        assert_eq!(values.map(number), ["0", "7", "0.1235", "12.3", "1234", "1.0e9", "2.0e-7", "∞"]);
    }

    #[test]
    fn the_worst_claim_is_told() {
        let close = Claim::fails("a", "q", 1.1, 1.0, "");
        let broken = Claim::fails("b", "q", 0.5, 1.0, "");
        let silent = Claim::fails("c", "q", 0.0, 1.0, "").not_counted("software");
        assert!(margin(&broken) < margin(&close) && margin(&close) < margin(&silent));
    }
}
