//! A legend as plates and texts in pixels, in the upper right corner of a picture.

use glam::DVec2;

use super::{
    decor::{Align, Label, Overlay, Plate, Sheet},
    legend::{Legend, LegendClass, LegendKey, Tick},
};

/// Classes that are named at most; the window's panel lists all.
const NAMED: usize = 14;
/// Mean width of a character, as a share of the text's height. Generous: a plate may be too wide, not too narrow.
const CHARACTER: f64 = 0.56;
/// All further lengths are in heights of a text as well. From one row to the next.
const ROW: f64 = 1.4;
/// From the plate's edge to what is on it.
const MARGIN: f64 = 0.6;
/// Height of the bar of colours, where there is room for it.
const BAR: f64 = 10.0;
const GROUND: [u8; 3] = [20, 22, 26];
const MARK: [u8; 3] = [236, 238, 242];

fn width(text: &str) -> f64 {
    CHARACTER * text.chars().count() as f64
}

/// Adds it, unless the picture is too small: at most 60 % of its width and all of its height may be taken.
pub fn lay_out(overlay: &mut Overlay, legend: &Legend, sheet: &Sheet) {
    let text_px = sheet.text_px;
    let [picture_width, picture_height] = sheet.size.map(|px| f64::from(px) / text_px);
    let room = picture_height - sheet.covered_below / text_px - 2.0;
    let head = 2.0 * MARGIN + ROW;
    let mut page = Page { plates: Vec::new(), labels: Vec::new(), widest: width(&legend.title) };
    page.write(0.0, 0.5 * ROW, &legend.title);
    let height = match &legend.key {
        LegendKey::Classes(classes) => head + page.classes(classes, ((room - head) / ROW) as usize),
        LegendKey::Scale { colors, ticks, .. } => head + page.scale(colors, ticks, (room - head - ROW).min(BAR)),
    };
    let size = DVec2::new(page.widest + 2.0 * MARGIN, height);
    if height < head + ROW || height > room || size.x > 0.6 * picture_width {
        return;
    }
    let corner = DVec2::new(picture_width - 1.0 - size.x, 1.0);
    let px = |at: DVec2| (corner + DVec2::splat(MARGIN) + at) * text_px;
    let ground = Plate { min: corner * text_px, max: (corner + size) * text_px, color: GROUND, opacity: 0.7 };
    overlay.plates.push(ground);
    overlay.plates.extend(page.plates.into_iter().map(|p| Plate { min: px(p.min), max: px(p.max), ..p }));
    overlay.labels.extend(page.labels.into_iter().map(|label| Label { at: px(label.at), ..label }));
}

/// What is on the plate, from its corner.
struct Page {
    plates: Vec<Plate>,
    labels: Vec<Label>,
    widest: f64,
}

impl Page {
    /// A text that begins at `x`, with its middle at `y`.
    fn write(&mut self, x: f64, y: f64, text: &str) {
        self.widest = self.widest.max(x + width(text));
        self.labels.push(Label { at: DVec2::new(x, y), align: Align::Left, text: text.to_owned() });
    }

    fn fill(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2], color: [u8; 3]) {
        let [min, max] = [DVec2::new(left, top), DVec2::new(right, bottom)];
        self.plates.push(Plate { min, max, color, opacity: 1.0 });
    }

    /// As many as fit into `rows`. Gives the height they take.
    fn classes(&mut self, classes: &[LegendClass], rows: usize) -> f64 {
        let most = rows.min(NAMED);
        let named = if classes.len() > most { most.saturating_sub(1) } else { classes.len() };
        let middle = |row: usize| ROW * (row as f64 + 1.5);
        for (row, class) in classes[..named].iter().enumerate() {
            self.fill([0.0, middle(row) - 0.45], [0.9, middle(row) + 0.45], class.color);
            self.write(1.4, middle(row), &class.name);
        }
        if named == classes.len() {
            return ROW * named as f64;
        }
        self.write(0.0, middle(named), &format!("and {} more", classes.len() - named));
        ROW * (named + 1) as f64
    }

    /// A bar of colours with the values beside it. Gives the height they take, 0 if that is too little to read.
    fn scale(&mut self, colors: &[[u8; 3]], ticks: &[Tick], height: f64) -> f64 {
        if height < 2.0 {
            return 0.0;
        }
        // The text beside its lower and upper end is as high as a row.
        let at = |share: f64| 1.5 * ROW + height * (1.0 - share);
        let colored = colors.len().max(1) as f64;
        // Each down to the bar's lower end, from above: edges that share a pixel let nothing show between them.
        for (n, &color) in colors.iter().enumerate().rev() {
            self.fill([0.0, at((n + 1) as f64 / colored)], [1.0, at(0.0)], color);
        }
        for tick in ticks {
            self.fill([1.0, at(tick.place) - 0.04], [1.3, at(tick.place) + 0.04], MARK);
            self.write(1.7, at(tick.place), &tick.text);
        }
        height + ROW
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::scale::{Scale, Transfer};

    fn classes(count: u16) -> Legend {
        let class =
            |value| LegendClass { value, name: format!("class {value}"), color: [9, 9, value as u8], points: 1 };
        Legend { title: "classification".into(), key: LegendKey::Classes((0..count).map(class).collect()) }
    }

    fn scale() -> Legend {
        let tick = |place: f64| Tick { place, value: place, text: format!("{place}") };
        let colors = (0..=255).map(|n| [n, 0, 0]).collect();
        let key = LegendKey::Scale {
            colors,
            scale: Scale { low: 0.0, high: 1.0, transfer: Transfer::Linear },
            ticks: [0.0, 0.5, 1.0].map(tick).into(),
        };
        Legend { title: "elevation".into(), key }
    }

    fn laid_out(legend: &Legend, size: [u32; 2], covered_below: f64) -> Overlay {
        let mut overlay = Overlay::default();
        lay_out(&mut overlay, legend, &Sheet { size, text_px: 10.0, covered_below });
        overlay
    }

    /// All of it is on its plate, and that is in the picture, at every size; where there is no room there is nothing.
    #[test]
    fn it_stays_within_the_picture() {
        let mut shown = 0;
        for legend in [classes(1), classes(5), classes(30), scale()] {
            for size in [[40, 30], [200, 60], [120, 400], [200, 100], [320, 200], [1920, 1080]] {
                for covered in [0.0, 48.0] {
                    let overlay = laid_out(&legend, size, covered);
                    let Some(ground) = overlay.plates.first() else {
                        assert!(overlay.labels.is_empty() && (size[0] < 200 || size[1] <= 100), "{size:?}");
                        continue;
                    };
                    shown += 1;
                    let [width, height] = size.map(f64::from);
                    assert!(ground.min.x >= 0.4 * width - 10.0 && ground.max.x < width, "{ground:?} {size:?}");
                    assert!(ground.min.y > 0.0 && ground.max.y <= height - covered, "{ground:?} {size:?}");
                    for plate in &overlay.plates {
                        assert!(plate.min.cmpge(ground.min).all() && plate.max.cmple(ground.max).all(), "{plate:?}");
                    }
                    for label in &overlay.labels {
                        assert!(label.at.y - 5.0 >= ground.min.y && label.at.y + 5.0 <= ground.max.y, "{label:?}");
                    }
                }
            }
        }
        assert!(shown > 20, "{shown}");
    }

    #[test]
    fn classes_without_room_are_counted() {
        let last = |count, size| laid_out(&classes(count), size, 0.0).labels.pop().expect("labels").text;
        assert_eq!(last(14, [640, 480]), "class 13");
        assert_eq!(last(15, [640, 480]), "and 2 more");
        assert_eq!(last(15, [640, 120]), "and 11 more");
    }

    #[test]
    fn values_stand_beside_their_colours() {
        let overlay = laid_out(&scale(), [640, 480], 0.0);
        let of = |red: u8| overlay.plates.iter().find(|plate| plate.color == [red, 0, 0]).expect("a colour");
        let y = |text: &str| overlay.labels.iter().find(|label| label.text == text).expect("a tick").at.y;
        assert!((y("0") - of(0).max.y).abs() < 1e-9 && (y("1") - of(255).min.y).abs() < 1e-9);
        assert!((y("0.5") - of(127).min.y).abs() < 1e-9);
    }
}
