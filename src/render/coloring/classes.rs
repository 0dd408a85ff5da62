//! Names and colours of the classes of points.

use std::{borrow::Cow, collections::BTreeMap};

use serde::{Deserialize, Serialize};

use super::map::palette;

/// What a class is called and looks like.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Class {
    pub name: Cow<'static, str>,
    /// Red, green, blue.
    pub color: [u8; 3],
}

/// A class for each of the 256 numbers: ASPRS's (LAS 1.4 R15, table 17), but for those that the user changed.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ClassTable {
    changed: BTreeMap<u8, Class>,
}

/// The classes that ASPRS names, from 0 on. The colours are near those that most programs have: brown ground, green
/// vegetation, red buildings, blue water.
const ASPRS: [(&str, [u8; 3]); 23] = [
    ("never classified", [150, 150, 150]),
    ("unclassified", [190, 190, 190]),
    ("ground", [168, 112, 56]),
    ("low vegetation", [160, 216, 88]),
    ("medium vegetation", [80, 176, 64]),
    ("high vegetation", [24, 128, 48]),
    ("building", [232, 64, 48]),
    ("low point (noise)", [255, 0, 200]),
    ("model key-point", [255, 220, 0]),
    ("water", [48, 112, 232]),
    ("rail", [104, 72, 120]),
    ("road surface", [88, 96, 112]),
    ("overlap", [255, 170, 80]),
    ("wire – guard", [255, 240, 130]),
    ("wire – conductor", [240, 200, 40]),
    ("transmission tower", [128, 96, 216]),
    ("wire-structure connector", [200, 150, 255]),
    ("bridge deck", [208, 152, 128]),
    ("high noise", [255, 80, 160]),
    ("overhead structure", [120, 208, 216]),
    ("ignored ground", [120, 88, 64]),
    ("snow", [225, 245, 255]),
    ("temporal exclusion", [104, 136, 104]),
];

impl ClassTable {
    /// The class of a number.
    pub fn get(&self, class: u8) -> Class {
        self.changed.get(&class).cloned().unwrap_or_else(|| usual(class))
    }

    pub fn color(&self, class: u8) -> [u8; 3] {
        self.changed.get(&class).map_or_else(|| usual(class).color, |class| class.color)
    }

    /// Changes a class; one that is as ASPRS has it is no change.
    pub fn set(&mut self, number: u8, class: Class) {
        if class == usual(number) {
            self.changed.remove(&number);
        } else {
            self.changed.insert(number, class);
        }
    }

    pub fn set_color(&mut self, number: u8, color: [u8; 3]) {
        self.set(number, Class { color, ..self.get(number) });
    }

    /// Classes that are not ASPRS's, by number.
    pub fn changed(&self) -> impl Iterator<Item = (u8, &Class)> {
        self.changed.iter().map(|(number, class)| (*number, class))
    }

    /// Back to ASPRS's.
    pub fn reset(&mut self) {
        self.changed.clear();
    }
}

/// As ASPRS has it.
fn usual(class: u8) -> Class {
    match ASPRS.get(usize::from(class)) {
        Some(&(name, color)) => Class { name: name.into(), color },
        None => {
            let kind = if class < 64 { "reserved" } else { "user defined" };
            Class { name: format!("{kind} {class}").into(), color: palette(class.into()) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_changes_are_remembered() {
        let mut table = ClassTable::default();
        assert_eq!(
            (&*table.get(2).name, &*table.get(63).name, &*table.get(64).name),
            ("ground", "reserved 63", "user defined 64")
        );
        table.set_color(6, [255, 0, 0]);
        assert_eq!((table.color(6), &*table.get(6).name), ([255, 0, 0], "building"));
        let json = serde_json::to_string(&table).unwrap();
        assert_eq!(json, r#"{"6":{"name":"building","color":[255,0,0]}}"#);
        assert_eq!(serde_json::from_str::<ClassTable>(&json).unwrap(), table);
        table.set_color(6, ClassTable::default().color(6));
        assert_eq!(table, ClassTable::default());
    }

    #[test]
    fn no_two_named_classes_look_alike() {
        for (a, (_, first)) in ASPRS.iter().enumerate() {
            for (_, second) in &ASPRS[a + 1..] {
                let apart: i32 = (0..3).map(|c| (i32::from(first[c]) - i32::from(second[c])).abs()).sum();
                assert!(apart >= 40, "{first:?} {second:?}");
            }
        }
    }
}
