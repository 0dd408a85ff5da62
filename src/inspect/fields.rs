//! A record as named values, for JSON and CSV: the same names in both.

use std::fmt::Write;

use super::{
    record::{ExtraValue, PointRecord},
    shortest, shortest_f32,
};
use crate::render::ClassTable;

/// A named value. Names: those of LAS, in the snake case of most readers; X, Y and Z are the record's integers, x, y and z
/// the coordinates; `extra:NAME` is a dimension's value and `extra:NAME:raw` what is stored, where these differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub name: String,
    pub value: Value,
}

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number, in the digits that are meant.
    Number(String),
    Text(String),
    Flag(bool),
    /// The file says that there is no data.
    None,
}

impl PointRecord {
    /// Everything, in the order of the record. The format decides which fields there are.
    pub fn fields(&self) -> Vec<Field> {
        let number = |n: &dyn ToString| Value::Number(n.to_string());
        let mut fields = vec![
            Field::new("file", Value::Text(self.path.display().to_string())),
            Field::new("record", number(&self.record)),
            Field::new("format", number(&self.format)),
        ];
        let mut add = |name: &str, value: Value| fields.push(Field::new(name, value));
        for (name, n) in ["X", "Y", "Z"].iter().zip(&self.xyz) {
            add(name, number(n));
        }
        for (name, n) in ["x", "y", "z"].iter().zip(&self.coordinates) {
            add(name, number(n));
        }
        add("intensity", number(&self.intensity));
        add("return_number", number(&self.return_number));
        add("number_of_returns", number(&self.number_of_returns));
        add("synthetic", Value::Flag(self.flags.synthetic));
        add("key_point", Value::Flag(self.flags.key_point));
        add("withheld", Value::Flag(self.flags.withheld));
        if let Some(overlap) = self.flags.overlap {
            add("overlap", Value::Flag(overlap));
        }
        if let Some(channel) = self.flags.scanner_channel {
            add("scanner_channel", number(&channel));
        }
        add("scan_direction", number(&u8::from(self.flags.scan_direction)));
        add("edge_of_flight_line", Value::Flag(self.flags.edge_of_flight_line));
        add("classification", number(&self.classification));
        add("class_name", Value::Text(ClassTable::default().get(self.classification).name.into()));
        add("scan_angle", number(&self.scan_angle));
        add("scan_angle_deg", number(&self.scan_angle_deg));
        add("user_data", number(&self.user_data));
        add("point_source_id", number(&self.point_source));
        if let Some(time) = self.gps_time {
            add("gps_time", Value::float(time.is_finite(), shortest(time)));
            add("gps_moment", self.gps_moment().map_or(Value::None, Value::Text));
        }
        for (name, n) in ["red", "green", "blue"].iter().zip(self.rgb.iter().flatten()) {
            add(name, number(n));
        }
        if let Some(nir) = self.nir {
            add("nir", number(&nir));
        }
        if let Some(wave) = self.wave_packet {
            let floats = [wave.return_point, wave.direction[0], wave.direction[1], wave.direction[2]];
            add("wave_descriptor", number(&wave.descriptor));
            add("wave_offset", number(&wave.offset));
            add("wave_size", number(&wave.size));
            for (name, n) in ["wave_return_point", "wave_dx", "wave_dy", "wave_dz"].iter().zip(floats) {
                add(name, Value::float(n.is_finite(), shortest_f32(n)));
            }
        }
        self.extra.iter().for_each(|extra| add_extra(extra, &mut fields));
        if !self.unexplained.is_empty() {
            fields.push(Field::new("extra_bytes", Value::Text(hex(&self.unexplained))));
        }
        fields
    }

    /// One JSON object. Coordinates and scaled values are numbers in all their digits, whatever a reader makes of them;
    /// numbers that JSON does not have (NaN) are strings.
    pub fn json(&self) -> String {
        json(&self.fields())
    }

    /// The header line of [`PointRecord::csv_row`], without its line end. Records of one file have the same.
    pub fn csv_header(&self) -> String {
        csv_header(&self.fields())
    }

    /// One line, without its end; flags are 0 and 1, what is not there is empty.
    pub fn csv_row(&self) -> String {
        csv_row(&self.fields())
    }
}

/// These values as one JSON object, see [`PointRecord::json`].
pub fn json(fields: &[Field]) -> String {
    let members = fields.iter().map(|field| format!("  {}: {}", quoted(&field.name), field.value.json()));
    format!("{{\n{}\n}}", members.collect::<Vec<_>>().join(",\n"))
}

/// The names of these values as a line of CSV, see [`PointRecord::csv_header`].
pub fn csv_header(fields: &[Field]) -> String {
    fields.iter().map(|field| csv_cell(&field.name)).collect::<Vec<_>>().join(",")
}

/// These values as a line of CSV, see [`PointRecord::csv_row`].
pub fn csv_row(fields: &[Field]) -> String {
    let cell = |field: &Field| match &field.value {
        Value::Number(text) | Value::Text(text) => csv_cell(text),
        Value::Flag(flag) => u8::from(*flag).to_string(),
        Value::None => String::new(),
    };
    fields.iter().map(cell).collect::<Vec<_>>().join(",")
}

fn add_extra(extra: &ExtraValue, fields: &mut Vec<Field>) {
    if extra.elements.is_empty() {
        fields.push(Field::new(&format!("extra:{}", extra.name), Value::Text(hex(&extra.bytes))));
    }
    for (i, element) in extra.elements.iter().enumerate() {
        let name = match extra.elements.len() {
            1 => format!("extra:{}", extra.name),
            _ => format!("extra:{}[{i}]", extra.name),
        };
        let number = |text: &String| Value::float(!text.contains(['N', 'i']), text.clone());
        fields.push(Field::new(&name, element.value.as_ref().map_or(Value::None, number)));
        if element.is_scaled || element.value.is_none() {
            fields.push(Field::new(&format!("{name}:raw"), number(&element.raw)));
        }
    }
}

impl Field {
    pub fn new(name: &str, value: Value) -> Field {
        Field { name: name.into(), value }
    }
}

impl Value {
    /// JSON knows neither NaN nor infinity.
    pub fn float(is_finite: bool, text: String) -> Value {
        if is_finite { Value::Number(text) } else { Value::Text(text) }
    }

    fn json(&self) -> String {
        match self {
            Value::Number(text) => text.clone(),
            Value::Text(text) => quoted(text),
            Value::Flag(flag) => flag.to_string(),
            Value::None => "null".into(),
        }
    }
}

/// A JSON string.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Quoted where it has to be (RFC 4180).
fn csv_cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}
