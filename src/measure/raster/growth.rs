//! One chart of several reports: what a frame costs as the cloud grows.
//!
//! Reports are read as JSON, not as the types that wrote them: those of another version can be drawn too, as far as
//! they have the same fields.

use serde_json::Value;

use super::{
    orders::Order,
    plot::{Axis, Curve, Plot, Scale},
    report::TITLE,
};
use crate::methods::METHODS;

/// Which rows of the reports are drawn.
#[derive(Debug, Clone)]
pub struct Growth {
    /// Names of methods; all that the reports have if empty.
    pub methods: Vec<&'static str>,
    pub order: Order,
    /// Name of a viewpoint.
    pub view: String,
    /// "wide" or "packed".
    pub encoding: &'static str,
}

impl Growth {
    /// The chart as an SVG file of its own.
    ///
    /// # Errors
    /// A sentence, if a report is none of this command's, or no report has what is to be drawn.
    pub fn svg(&self, reports: &[Value]) -> Result<String, String> {
        if let Some(other) = reports.iter().find(|report| report["report"] != TITLE) {
            return Err(format!("expected a report of \"{TITLE}\", found one of {}", other["report"]));
        }
        for (what, field) in [("devices", "device"), ("sizes of the picture", "size_px")] {
            if reports.iter().any(|report| report[field] != reports[0][field]) {
                return Err(format!("these reports are of different {what}: one chart shows one"));
            }
        }
        let curves: Vec<Curve> = METHODS
            .iter()
            .filter(|method| self.methods.is_empty() || self.methods.contains(&method.name))
            .map(|method| Curve { name: mark(method.name), points: self.places(reports, method.name) })
            .filter(|curve| !curve.points.is_empty())
            .collect();
        if curves.is_empty() {
            return Err(format!("no report has frame times of {}", self.what()));
        }
        let mut devices: Vec<&str> = reports.iter().filter_map(|report| report["device"]["adapter"].as_str()).collect();
        devices.dedup();
        let size = &reports[0]["size_px"];
        let plot = Plot {
            title: format!("{}, {}x{} pixels: {}", devices.join(", "), size[0], size[1], self.what()),
            x: Axis { name: "points".into(), scale: Scale::Log },
            y: Axis { name: "frame, ms".into(), scale: Scale::Log },
            curves,
            behind: Vec::new(),
        };
        Ok(plot.file())
    }

    fn what(&self) -> String {
        format!("{} order, {}, {}", self.order.name(), self.encoding, self.view)
    }

    /// Points and milliseconds, from the fewest points on. A later report replaces an earlier one's figure.
    fn places(&self, reports: &[Value], method: &str) -> Vec<(f64, f64)> {
        let mut places: Vec<(f64, f64)> = Vec::new();
        let found = reports.iter().filter_map(|report| {
            let is_wanted = |block: &&Value| {
                block["order"] == self.order.name() && block["view"] == *self.view && block["encoding"] == self.encoding
            };
            let block = report["blocks"].as_array()?.iter().find(is_wanted)?;
            let row = block["rows"].as_array()?.iter().find(|row| row["method"] == method)?;
            Some((report["points"].as_f64()?, row["frame_secs"]["median"].as_f64()? * 1e3))
        });
        for place in found {
            places.retain(|known| known.0 != place.0);
            places.push(place);
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places
    }
}

/// Methods that are wrong on purpose are marked wherever their speed is shown.
fn mark(name: &str) -> String {
    let is_wrong = METHODS.iter().any(|method| method.name == name && method.wrong_on_purpose.is_some());
    if is_wrong { format!("{name} (wrong)") } else { name.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn report(points: u64, ms: f64) -> Value {
        let row = |method: &str, ms: f64| json!({"method": method, "frame_secs": {"median": ms * 1e-3}});
        let rows =
            vec![row("early-z", ms), row("just-set", ms / 2.0), json!({"method": "busy-loop", "frame_secs": null})];
        json!({
            "report": TITLE, "points": points, "size_px": [1920, 1080], "device": {"adapter": "a <GPU>"},
            "blocks": [{"order": "shuffled", "view": "far", "encoding": "wide", "rows": rows}],
        })
    }

    fn growth() -> Growth {
        Growth { methods: vec![], order: Order::Shuffled, view: "far".into(), encoding: "wide" }
    }

    #[test]
    fn a_line_goes_through_all_reports() {
        let reports = [report(100_000_000, 2.0), report(10_000_000, 0.3), report(100_000_000, 1.0)];
        assert_eq!(growth().places(&reports, "early-z"), [(1e7, 0.3), (1e8, 1.0)]);
        let svg = growth().svg(&reports).unwrap();
        assert!(svg.contains("early-z") && svg.contains("just-set (wrong)") && !svg.contains("busy-loop"));
        assert!(svg.contains("a &lt;GPU&gt;, 1920x1080 pixels") && svg.matches("<circle").count() == 4);
        assert!(svg.contains("prefers-color-scheme: dark") && svg.starts_with("<svg"));
        let one = Growth { methods: vec!["early-z"], ..growth() }.svg(&reports).unwrap();
        assert!(one.contains("early-z") && !one.contains("just-set"));
    }

    #[test]
    fn what_is_not_there_cannot_be_drawn() {
        let reports = [report(10, 1.0)];
        assert!(Growth { view: "closeup".into(), ..growth() }.svg(&reports).is_err());
        assert!(Growth { order: Order::Morton, ..growth() }.svg(&reports).is_err());
        assert!(Growth { encoding: "packed", ..growth() }.svg(&reports).is_err());
        assert!(growth().svg(&[]).is_err());
        let mut other = report(20, 1.0);
        other["size_px"] = json!([1, 1]);
        assert!(growth().svg(&[report(10, 1.0), other]).unwrap_err().contains("sizes of the picture"));
        assert!(growth().svg(&[json!({"report": "another"})]).unwrap_err().contains("another"));
    }
}
