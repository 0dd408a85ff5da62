//! A record for people: a few lines of a name and a text each.

use super::{
    fields::hex,
    record::{ExtraValue, PointRecord, WavePacket},
    shortest, shortest_f32,
};
use crate::{render::ClassTable, scene::ExtraKind};

impl PointRecord {
    /// Lines of a name and a text, for a card.
    pub fn card(&self) -> Vec<(String, String)> {
        let mut rows = Vec::new();
        let mut add = |name: &str, text: String| rows.push((name.to_owned(), text));
        add("File", self.path.display().to_string());
        add("Record", format!("{} (from 0), format {}", self.record, self.format));
        for ((name, coordinate), stored) in ["X", "Y", "Z"].iter().zip(&self.coordinates).zip(self.xyz) {
            add(name, format!("{coordinate} (stored {stored})"));
        }
        add("Intensity", self.intensity.to_string());
        add("Return", format!("{} of {}", self.return_number, self.number_of_returns));
        add("Class", format!("{}, {}", self.classification, ClassTable::default().get(self.classification).name));
        add("Flags", self.flag_words());
        if let Some(channel) = self.flags.scanner_channel {
            add("Scanner channel", channel.to_string());
        }
        let stored = if self.format < 6 { String::new() } else { format!(" (stored {})", self.scan_angle) };
        add("Scan angle", format!("{}°{stored}", self.scan_angle_deg));
        add("User data", self.user_data.to_string());
        add("Point source", self.point_source.to_string());
        if let Some(time) = self.gps_time {
            add("GPS time", format!("{} {}", shortest(time), self.gps_clock.unit()));
        }
        if let Some(moment) = self.gps_moment() {
            add("", moment);
        }
        if let Some([red, green, blue]) = self.rgb {
            add("Red, green, blue", format!("{red}, {green}, {blue}"));
        }
        if let Some(nir) = self.nir {
            add("Near infrared", nir.to_string());
        }
        if let Some(wave) = &self.wave_packet {
            add("Wave packet", wave.words());
        }
        for extra in &self.extra {
            add(&extra.name, extra.words());
        }
        if !self.unexplained.is_empty() {
            add("Extra bytes", hex(&self.unexplained));
        }
        rows
    }

    /// The card as lines of text.
    pub fn text(&self) -> String {
        lines(&self.card())
    }

    fn flag_words(&self) -> String {
        let flags = &self.flags;
        let words = [
            (flags.synthetic, "synthetic"),
            (flags.key_point, "key-point"),
            (flags.withheld, "withheld"),
            (flags.overlap == Some(true), "overlap"),
            (flags.edge_of_flight_line, "edge of flight line"),
            (flags.scan_direction, "scan direction 1"),
        ];
        let set: Vec<&str> = words.iter().filter(|(set, _)| *set).map(|(_, word)| *word).collect();
        if set.is_empty() { "none".into() } else { set.join(", ") }
    }
}

/// Rows as lines of text, the texts one below the other.
pub fn lines(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0) + 2;
    rows.iter().map(|(name, text)| format!("{name:<width$}{text}\n")).collect()
}

impl WavePacket {
    fn words(&self) -> String {
        if self.is_omitted {
            return "left out by the file's writer".into();
        }
        if self.descriptor == 0 {
            return "none".into();
        }
        let [dx, dy, dz] = self.direction.map(shortest_f32);
        format!(
            "descriptor {}, {} bytes from {}, return at {} ps, direction {dx} {dy} {dz} per ps",
            self.descriptor,
            self.size,
            self.offset,
            shortest_f32(self.return_point)
        )
    }
}

impl ExtraValue {
    fn words(&self) -> String {
        if let ExtraKind::Bytes(_) = self.kind {
            return hex(&self.bytes);
        }
        let element = |e: &super::record::ExtraElement| match (&e.value, e.is_scaled) {
            (None, _) => format!("no data (stored {})", e.raw),
            (Some(value), true) => format!("{value} (stored {})", e.raw),
            (Some(value), false) => value.clone(),
        };
        let values = self.elements.iter().map(element).collect::<Vec<_>>().join(", ");
        if self.description.is_empty() { values } else { format!("{values} – {}", self.description) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::source::RecordError;

    /// A file of one record: LAS 1.4, format 6, adjusted standard time, a dimension scaled and one without data.
    fn file(records: &[[u8; 35]]) -> tempfile::NamedTempFile {
        let mut header = vec![0u8; 375];
        let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, b"LASF");
        put(6, &[1]);
        put(24, &[1, 4]);
        put(94, &375u16.to_le_bytes());
        put(96, &(375u32 + 54 + 384).to_le_bytes());
        put(100, &1u32.to_le_bytes());
        put(104, &[6]);
        put(105, &35u16.to_le_bytes());
        for (axis, (scale, offset)) in [(0.01, 500_000.0), (0.001, 0.5), (0.25, -10.0)].iter().enumerate() {
            put(131 + 8 * axis, &f64::to_le_bytes(*scale));
            put(155 + 8 * axis, &f64::to_le_bytes(*offset));
        }
        put(247, &(records.len() as u64).to_le_bytes());
        let mut vlr = vec![0u8; 54 + 384];
        vlr[2..11].copy_from_slice(b"LASF_Spec");
        vlr[18..22].copy_from_slice(&[4, 0, 0x80, 1]);
        let mut dimension = |n: usize, kind: u8, options: u8, name: &[u8], words: &[(usize, [u8; 8])]| {
            let entry = &mut vlr[54 + 192 * n..][..192];
            (entry[2], entry[3]) = (kind, options);
            entry[4..4 + name.len()].copy_from_slice(name);
            words.iter().for_each(|(at, word)| entry[*at..at + 8].copy_from_slice(word));
        };
        dimension(0, 4, 0b1000, b"height", &[(112, 0.01f64.to_le_bytes())]);
        dimension(1, 3, 1, b"odd, \"name\"", &[(40, 7u64.to_le_bytes())]);
        let file = tempfile::NamedTempFile::new().unwrap();
        let records = records.iter().flatten().copied();
        std::fs::write(&file, header.into_iter().chain(vlr).chain(records).collect::<Vec<u8>>()).unwrap();
        file
    }

    fn record() -> [u8; 35] {
        let mut record = [0; 35];
        let mut put = |at: usize, bytes: &[u8]| record[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &12_345i32.to_le_bytes());
        put(4, &(-1i32).to_le_bytes());
        put(8, &3i32.to_le_bytes());
        put(12, &900u16.to_le_bytes());
        put(14, &[2 | 3 << 4, 0b1010_1101, 18, 9]);
        put(18, &(-1_167i16).to_le_bytes());
        put(20, &77u16.to_le_bytes());
        put(22, &245_370_417.058_711f64.to_le_bytes());
        put(30, &(-250i16).to_le_bytes());
        put(32, &7u16.to_le_bytes());
        put(34, &[0xab]);
        record
    }

    #[test]
    fn a_card_has_every_field_in_its_own_digits() {
        let file = file(&[[0; 35], record()]);
        let read = |record| PointRecord::read(file.path(), record, &AtomicBool::new(false));
        let record = read(1).unwrap();
        let card: Vec<String> = record.card().iter().skip(1).map(|(name, text)| format!("{name}: {text}")).collect();
        assert_eq!(
            card,
            [
                "Record: 1 (from 0), format 6",
                "X: 500123.45 (stored 12345)",
                "Y: 0.499 (stored -1)",
                "Z: -9.25 (stored 3)",
                "Intensity: 900",
                "Return: 2 of 3",
                "Class: 18, high noise",
                "Flags: synthetic, withheld, overlap, edge of flight line",
                "Scanner channel: 2",
                "Scan angle: -7.002° (stored -1167)",
                "User data: 9",
                "Point source: 77",
                "GPS time: 245370417.058711 s, adjusted standard GPS time",
                ": 2019-06-24 00:13:19.058711 UTC",
                "height: -2.50 (stored -250)",
                "odd, \"name\": no data (stored 7)",
                "Extra bytes: ab",
            ]
        );
        assert!(record.text().contains("\nScan angle       -7.002°"), "{}", record.text());
        let last = read(2).unwrap_err();
        assert!(matches!(last, RecordError::OutOfRange { points: 2, .. }), "{last}");
        assert!(last.to_string().ends_with("there is no record 2: expected 0 to 1"), "{last}");
    }

    #[test]
    fn json_and_csv_say_the_same() {
        let file = file(&[record()]);
        let record = PointRecord::read(file.path(), 0, &AtomicBool::new(false)).unwrap();
        let json = record.json();
        assert!(json.contains("\n  \"x\": 500123.45,\n"), "{json}");
        let object: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
        let (header, row) = (record.csv_header(), record.csv_row());
        assert!(
            header.ends_with(
                r#"extra:height,extra:height:raw,"extra:odd, ""name""","extra:odd, ""name"":raw",extra_bytes"#
            )
        );
        assert!(row.ends_with("-2.50,-250,,7,ab"), "{row}");
        // Cells of this file's path have no commas, nor have those before the odd name.
        let cells = header.split(',').zip(row.split(','));
        for (name, cell) in cells.take_while(|(name, _)| !name.contains("odd")) {
            let value = match &object[name] {
                serde_json::Value::Null => String::new(),
                serde_json::Value::Bool(flag) => u8::from(*flag).to_string(),
                serde_json::Value::String(text) => text.clone(),
                // 0.10 is read as 0.1.
                number => match (number.as_f64(), cell.parse::<f64>()) {
                    (Some(a), Ok(b)) if a == b => cell.into(),
                    _ => number.to_string(),
                },
            };
            assert_eq!(value, cell, "{name}");
        }
        assert_eq!(object["extra:odd, \"name\""], serde_json::Value::Null);
        assert_eq!((object["X"].as_i64(), object["overlap"].as_bool()), (Some(12_345), Some(true)));
    }
}
