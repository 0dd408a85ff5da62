//! The coordinate reference system that a file names: WKT text, or the EPSG codes of its GeoTIFF keys.

use std::fs::File;

use serde::Serialize;

use super::{
    bytes::{text, u16_at},
    vlr::Vlr,
    wkt,
};

/// WKT and GeoTIFF keys are read up to this many bytes.
const MAX_BYTES: usize = 1 << 20;

const USER_ID: &str = "LASF_Projection";
const WKT: u16 = 2112;
const GEO_KEYS: u16 = 34735;

/// The code that means "defined by the user".
const USER_DEFINED: u16 = 32767;

/// What a file says of its coordinate system; a file may say it twice.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Crs {
    pub wkt: Option<String>,
    /// EPSG codes from GeoTIFF keys; 32767 means "defined by the user".
    pub projected_epsg: Option<u16>,
    pub geographic_epsg: Option<u16>,
    pub vertical_epsg: Option<u16>,
    /// EPSG code of the unit of projected coordinates.
    pub linear_unit_epsg: Option<u16>,
}

impl Crs {
    /// Reads the first WKT and the first GeoTIFF key directory among the records.
    pub fn read<'a>(file: &File, vlrs: impl Iterator<Item = &'a Vlr>) -> std::io::Result<Crs> {
        let mut crs = Crs::default();
        let mut keys_seen = false;
        for vlr in vlrs {
            if crs.wkt.is_none() && vlr.is(USER_ID, WKT) {
                crs.wkt = Some(text(&vlr.data(file, MAX_BYTES)?)).filter(|wkt| !wkt.is_empty());
            } else if !keys_seen && vlr.is(USER_ID, GEO_KEYS) {
                keys_seen = true;
                crs.take_keys(&vlr.data(file, MAX_BYTES)?);
            }
        }
        Ok(crs)
    }

    /// A directory is four numbers, the last of which counts the keys, then four numbers per key.
    fn take_keys(&mut self, bytes: &[u8]) {
        let mut entries = bytes.chunks_exact(8);
        let Some(head) = entries.next() else { return };
        for entry in entries.take(u16_at(head, 6).into()) {
            // A key with a location keeps its value elsewhere, and is no code.
            if u16_at(entry, 2) != 0 {
                continue;
            }
            let value = Some(u16_at(entry, 6));
            match u16_at(entry, 0) {
                2048 => self.geographic_epsg = value,
                3072 => self.projected_epsg = value,
                4096 => self.vertical_epsg = value,
                3076 => self.linear_unit_epsg = value,
                _ => {}
            }
        }
    }

    /// Length of the coordinates' unit, metres, if the file says so: by its WKT, or by the unit among its GeoTIFF keys.
    pub fn metres_per_unit(&self) -> Option<f64> {
        let by_key = match self.linear_unit_epsg {
            Some(9001) => Some(1.0),
            Some(9002) => Some(0.3048),
            Some(9003) => Some(1200.0 / 3937.0),
            _ => None,
        };
        self.wkt.as_deref().and_then(wkt::metres_per_unit).or(by_key).or_else(|| self.is_utm().then_some(1.0))
    }

    /// True of the EPSG codes of UTM zones on WGS 84, ETRS89 and NAD83: files that name these alone say no unit.
    fn is_utm(&self) -> bool {
        let code = self.horizontal().and_then(|horizontal| horizontal.epsg);
        code.is_some_and(|code| matches!(code, 32_601..=32_660 | 32_701..=32_760 | 25_828..=25_838 | 26_901..=26_923))
    }

    /// True if the coordinates are longitudes and latitudes: differences of them are no lengths.
    pub fn is_geographic(&self) -> bool {
        match self.wkt.as_deref() {
            Some(wkt) => wkt::is_geographic(wkt),
            None => self.projected_epsg.is_none() && self.geographic_epsg.is_some(),
        }
    }

    /// In few words, for a list of files: names and EPSG codes, as far as they are known.
    pub fn short(&self) -> Option<String> {
        let known = |code: u16| (code != USER_DEFINED && code != 0).then_some(u32::from(code));
        let words = |part: Option<wkt::WktPart>, code: Option<u16>| {
            let part = part.unwrap_or_default();
            let name = Some(part.name).filter(|name| !matches!(&*name.to_lowercase(), "" | "unnamed" | "unknown"));
            match (name, part.epsg.or(code.and_then(known))) {
                (Some(name), Some(code)) => Some(format!("{name} (EPSG:{code})")),
                (Some(name), None) => Some(name),
                (None, code) => code.map(|code| format!("EPSG:{code}")),
            }
        };
        let wkt = self.wkt.as_deref();
        // Of a projected system defined by the user, the geographic code says too little.
        let code = if self.projected_epsg.is_some() { self.projected_epsg } else { self.geographic_epsg };
        let by_user = || (code == Some(USER_DEFINED)).then(|| "defined by the user".into());
        let horizontal = words(wkt.and_then(wkt::horizontal), code).or_else(by_user);
        let vertical = words(wkt.and_then(wkt::vertical), self.vertical_epsg);
        match (horizontal, vertical) {
            (Some(horizontal), Some(vertical)) => Some(format!("{horizontal} + {vertical}")),
            (horizontal, vertical) => horizontal.or(vertical).or_else(|| wkt.map(|_| "without a name".into())),
        }
    }

    fn horizontal(&self) -> Option<Identity> {
        let projected = self.projected_epsg.filter(|&c| c != USER_DEFINED);
        // Of a projected system defined by the user, the geographic code says too little.
        let code = if self.projected_epsg.is_some() { projected } else { self.geographic_epsg };
        Identity::new(code, self.wkt.as_deref().and_then(wkt::horizontal))
    }

    fn vertical(&self) -> Option<Identity> {
        Identity::new(self.vertical_epsg, self.wkt.as_deref().and_then(wkt::vertical))
    }

    /// One line: the name in the WKT, or the codes.
    pub fn summary(&self) -> Option<String> {
        let codes = [
            ("projected", self.projected_epsg),
            ("geographic", self.geographic_epsg),
            ("vertical", self.vertical_epsg),
        ];
        let mut parts: Vec<String> =
            codes.iter().filter_map(|(name, code)| code.map(|c| format!("{name} EPSG:{c}"))).collect();
        if let Some(wkt) = &self.wkt {
            let name = wkt.split('"').nth(1).unwrap_or("without a name");
            parts.insert(0, format!("WKT «{name}»"));
        }
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// What tells one coordinate system from another.
#[derive(Debug, PartialEq)]
struct Identity {
    epsg: Option<u32>,
    /// Letters and digits of the WKT's name: writers differ in the rest.
    name: Option<String>,
}

impl Identity {
    /// `None` if neither code nor name is known.
    fn new(code: Option<u16>, part: Option<wkt::WktPart>) -> Option<Identity> {
        let code = code.filter(|&c| c != USER_DEFINED && c != 0).map(u32::from);
        let part = part.unwrap_or_default();
        let name: String = part.name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
        // What names nothing.
        let name = Some(name).filter(|n| !matches!(n.as_str(), "" | "unnamed" | "unknown"));
        let identity = Identity { epsg: part.epsg.or(code), name };
        (identity.epsg.is_some() || identity.name.is_some()).then_some(identity)
    }

    /// Whether two systems are the same; `None` if nothing tells.
    fn is(&self, other: &Identity) -> Option<bool> {
        match (self.epsg.zip(other.epsg), self.name.as_ref().zip(other.name.as_ref())) {
            (Some((a, b)), _) => Some(a == b),
            (None, Some((a, b))) => Some(a == b),
            (None, None) => None,
        }
    }
}

/// What is to be said of several files' coordinate systems: nothing if they agree, else one line that
/// names the first two that do not.
pub fn disagreement(files: &[(String, Crs)]) -> Option<String> {
    let (name, first) = files.iter().find(|(_, crs)| crs.horizontal().is_some()).or(files.first())?;
    let pair = |a: &Crs, b: &Crs| match (a.horizontal(), b.horizontal()) {
        (Some(a), Some(b)) => a.is(&b),
        (None, None) => Some(true),
        _ => None,
    };
    let heights = |a: &Crs, b: &Crs| a.vertical().zip(b.vertical()).and_then(|(a, b)| a.is(&b));
    let words = |crs: &Crs| crs.summary().unwrap_or_else(|| "no coordinate system".into());
    let told = |what: &str, other: &(String, Crs), so: &str| {
        format!("{what}: {name} says {}, {} says {}; {so}", words(first), other.0, words(&other.1))
    };
    let unlike = |judge: &dyn Fn(&Crs, &Crs) -> Option<bool>| files.iter().find(|f| judge(first, &f.1) == Some(false));
    if let Some(other) = unlike(&pair) {
        return Some(told("the files have different coordinate systems", other, "nothing is reprojected"));
    }
    if let Some(other) = unlike(&heights) {
        return Some(told("the files have different height systems", other, "nothing is reprojected"));
    }
    let other = files.iter().find(|f| pair(first, &f.1).is_none())?;
    Some(told("the files may have different coordinate systems", other, "taken as the same"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_give_codes_and_survive_a_short_directory() {
        let numbers: [u16; 16] = [1, 1, 0, 9, 1024, 0, 1, 1, 3072, 0, 1, 25832, 4096, 0, 1, 5941];
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let mut crs = Crs::default();
        crs.take_keys(&bytes);
        assert_eq!((crs.projected_epsg, crs.vertical_epsg, crs.geographic_epsg), (Some(25832), Some(5941), None));
        assert_eq!(crs.summary().unwrap(), "projected EPSG:25832, vertical EPSG:5941");
        Crs::default().take_keys(&bytes[..5]);
    }

    #[test]
    fn few_words_name_the_system() {
        let compound = format!(r#"COMPD_CS["both",{UTM_32},VERT_CS["DHHN2016 height",AUTHORITY["EPSG","7837"]]]"#);
        let unnamed = r#"GEOCCS["unnamed",DATUM["WGS_1984"],UNIT["metre",1]]"#;
        for (crs, short) in [
            (Crs::default(), None),
            (codes(25832, Some(5941)), Some("EPSG:25832 + EPSG:5941")),
            (codes(USER_DEFINED, None), Some("defined by the user")),
            (wkt(UTM_32), Some("ETRS89 / UTM zone 32N (EPSG:25832)")),
            (wkt(&compound), Some("ETRS89 / UTM zone 32N (EPSG:25832) + DHHN2016 height (EPSG:7837)")),
            (wkt(unnamed), Some("without a name")),
            (Crs { projected_epsg: Some(2994), ..wkt(r#"PROJCS["Oregon"]"#) }, Some("Oregon (EPSG:2994)")),
        ] {
            assert_eq!(crs.short().as_deref(), short, "{crs:?}");
        }
    }

    #[test]
    fn units_and_degrees() {
        let degrees = wkt(r#"GEOGCS["WGS 84",UNIT["degree",0.0174]]"#);
        assert!(degrees.is_geographic() && degrees.metres_per_unit().is_none());
        assert!(Crs { geographic_epsg: Some(4326), ..Default::default() }.is_geographic());
        let with_datum = Crs { geographic_epsg: Some(4258), ..codes(25832, None) };
        assert!(!with_datum.is_geographic() && with_datum.metres_per_unit() == Some(1.0));
        assert_eq!(codes(2994, None).metres_per_unit(), None, "a foot, but nobody says so");
        let earth_centred = wkt(r#"GEOCCS["unnamed",DATUM["WGS_1984"],UNIT["metre",1]]"#);
        assert!(!earth_centred.is_geographic() && earth_centred.metres_per_unit() == Some(1.0));
    }

    fn wkt(text: &str) -> Crs {
        Crs { wkt: Some(text.into()), ..Default::default() }
    }

    fn codes(projected: u16, vertical: Option<u16>) -> Crs {
        Crs { projected_epsg: Some(projected), vertical_epsg: vertical, ..Default::default() }
    }

    fn said(all: &[Crs]) -> String {
        let files: Vec<_> = (1..).zip(all).map(|(i, crs)| (format!("{i}.las"), crs.clone())).collect();
        disagreement(&files).unwrap_or_default()
    }

    const UTM_32: &str = r#"PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89"],AUTHORITY["EPSG","25832"]]"#;

    #[test]
    fn the_same_system_in_other_words_is_no_disagreement() {
        let same = [
            codes(25832, None),
            wkt(UTM_32),
            wkt(r#"PROJCRS["ETRS89_UTM_zone_32N",ID["EPSG",25832]]"#),
            codes(25832, Some(5941)),
            Crs { geographic_epsg: Some(4258), ..codes(25832, None) },
        ];
        assert_eq!(said(&same), "");
        assert_eq!(said(&[wkt(r#"PROJCS["A_b"]"#), wkt(r#"PROJCS["A / B"]"#)]), "");
        assert_eq!(said(&[Crs::default(), Crs::default()]), "");
        assert_eq!(said(&[]), "");
    }

    #[test]
    fn different_systems_are_named() {
        assert_eq!(
            said(&[wkt(UTM_32), codes(25832, None), codes(25833, None)]),
            "the files have different coordinate systems: 1.las says WKT «ETRS89 / UTM zone 32N», \
             3.las says projected EPSG:25833; nothing is reprojected"
        );
        assert!(said(&[wkt(r#"PROJCS["A"]"#), wkt(r#"PROJCS["B"]"#)]).starts_with("the files have different coord"));
        let heights = said(&[codes(25832, Some(5941)), codes(25832, None), codes(25832, Some(7837))]);
        assert!(heights.starts_with("the files have different height systems: 1.las says projected"), "{heights}");
        assert!(heights.contains("3.las says"), "{heights}");
    }

    #[test]
    fn what_cannot_be_compared_gets_a_softer_word() {
        let soft = "the files may have different coordinate systems: ";
        assert_eq!(
            said(&[Crs::default(), codes(25832, None)]),
            format!("{soft}2.las says projected EPSG:25832, 1.las says no coordinate system; taken as the same")
        );
        assert!(said(&[codes(25832, None), wkt(r#"PROJCS["A"]"#)]).starts_with(soft));
        assert!(said(&[codes(25832, None), codes(USER_DEFINED, None)]).starts_with(soft));
    }
}
