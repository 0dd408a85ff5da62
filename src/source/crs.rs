//! The coordinate reference system that a file names: WKT text, or the EPSG codes of its GeoTIFF keys.

use std::fs::File;

use serde::Serialize;

use super::{
    bytes::{text, u16_at},
    vlr::Vlr,
};

/// WKT and GeoTIFF keys are read up to this many bytes.
const MAX_BYTES: usize = 1 << 20;

const USER_ID: &str = "LASF_Projection";
const WKT: u16 = 2112;
const GEO_KEYS: u16 = 34735;

/// What a file says of its coordinate system; a file may say it twice.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Crs {
    pub wkt: Option<String>,
    /// EPSG codes from GeoTIFF keys; 32767 means "defined by the user".
    pub projected_epsg: Option<u16>,
    pub geographic_epsg: Option<u16>,
    pub vertical_epsg: Option<u16>,
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
                _ => {}
            }
        }
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
}
