//! Colours, intensities and classes of the town's materials.

use super::super::noise::unit;

/// What a beam met, before it gets a colour of its own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paint {
    /// Red, green, blue, near infrared, 0 to 255 each.
    rgbn: [u8; 4],
    /// Reflectance in the laser's band, 0 to 255.
    reflectance: u8,
    /// ASPRS class.
    pub class: u8,
}

const fn paint(rgb: [u8; 3], nir: u8, reflectance: u8, class: u8) -> Paint {
    Paint { rgbn: [rgb[0], rgb[1], rgb[2], nir], reflectance, class }
}

pub(super) const GROUND: u8 = 2;
const UNCLASSIFIED: u8 = 1;
const LOW_VEGETATION: u8 = 3;
const HIGH_VEGETATION: u8 = 5;
const BUILDING: u8 = 6;
const WATER_CLASS: u8 = 9;
/// Known to point formats 6 and above only; the record writer turns it to ground in older ones.
pub(in super::super) const BRIDGE_DECK: u8 = 17;

pub(super) const ASPHALT: Paint = paint([84, 85, 90], 70, 40, GROUND);
pub(super) const MARKING: Paint = paint([214, 212, 204], 190, 220, GROUND);
pub(super) const SIDEWALK: Paint = paint([152, 148, 141], 140, 110, GROUND);
pub(super) const BRIDGE: Paint = paint([126, 122, 116], 110, 100, BRIDGE_DECK);
pub(super) const PLAZA: Paint = paint([176, 160, 138], 150, 125, GROUND);
pub(super) const GRAVEL: Paint = paint([171, 158, 132], 150, 120, GROUND);
pub(super) const LAWN: Paint = paint([104, 138, 66], 205, 150, GROUND);
pub(super) const MEADOW: Paint = paint([128, 150, 78], 210, 155, GROUND);
pub(super) const FOREST_FLOOR: Paint = paint([88, 80, 54], 120, 90, GROUND);
pub(super) const BANK: Paint = paint([131, 126, 92], 140, 95, GROUND);
pub(super) const WATER: Paint = paint([52, 82, 92], 15, 12, WATER_CLASS);
pub(super) const HEDGE: Paint = paint([62, 98, 44], 215, 140, LOW_VEGETATION);
pub(super) const UNDERGROWTH: Paint = paint([86, 108, 52], 200, 130, LOW_VEGETATION);
pub(super) const BRANCHES: Paint = paint([84, 92, 50], 190, 120, 4);
pub(super) const WINDOW: Paint = paint([58, 68, 82], 40, 30, BUILDING);
pub(super) const MACHINE: Paint = paint([172, 176, 178], 160, 150, BUILDING);

const CROPS: [Paint; 5] = [
    paint([196, 174, 102], 170, 140, GROUND),
    paint([122, 148, 62], 215, 150, GROUND),
    paint([134, 108, 78], 100, 80, GROUND),
    paint([160, 166, 84], 200, 150, GROUND),
    paint([208, 190, 74], 205, 160, GROUND),
];
const CANOPIES: [Paint; 6] = [
    paint([72, 108, 44], 225, 150, HIGH_VEGETATION),
    paint([88, 122, 52], 230, 155, HIGH_VEGETATION),
    paint([58, 94, 44], 220, 145, HIGH_VEGETATION),
    paint([108, 130, 58], 228, 150, HIGH_VEGETATION),
    paint([136, 128, 58], 215, 150, HIGH_VEGETATION),
    paint([44, 78, 48], 200, 130, HIGH_VEGETATION),
];
const TILES: [Paint; 6] = [
    paint([170, 88, 62], 140, 115, BUILDING),
    paint([151, 76, 56], 130, 105, BUILDING),
    paint([186, 104, 72], 150, 120, BUILDING),
    paint([128, 84, 68], 120, 95, BUILDING),
    paint([104, 98, 98], 90, 70, BUILDING),
    paint([142, 66, 54], 120, 95, BUILDING),
];
const FLAT_ROOFS: [Paint; 5] = [
    paint([164, 162, 158], 150, 130, BUILDING),
    paint([134, 132, 132], 120, 100, BUILDING),
    paint([190, 186, 178], 170, 160, BUILDING),
    paint([112, 118, 122], 100, 85, BUILDING),
    paint([146, 138, 122], 130, 110, BUILDING),
];
const WALLS: [Paint; 6] = [
    paint([218, 206, 182], 190, 170, BUILDING),
    paint([202, 178, 142], 180, 155, BUILDING),
    paint([190, 188, 184], 170, 160, BUILDING),
    paint([226, 220, 206], 200, 185, BUILDING),
    paint([178, 128, 104], 150, 125, BUILDING),
    paint([208, 192, 132], 180, 150, BUILDING),
];
const CARS: [Paint; 6] = [
    paint([206, 208, 210], 200, 200, UNCLASSIFIED),
    paint([46, 48, 54], 40, 35, UNCLASSIFIED),
    paint([162, 34, 34], 90, 90, UNCLASSIFIED),
    paint([42, 74, 138], 60, 60, UNCLASSIFIED),
    paint([126, 130, 134], 120, 120, UNCLASSIFIED),
    paint([230, 230, 226], 220, 220, UNCLASSIFIED),
];

/// Picks by a random number: a crop, a crown, …
pub(super) fn crop(n: u8) -> Paint {
    CROPS[usize::from(n) % CROPS.len()]
}
pub(super) fn canopy(n: u8) -> Paint {
    CANOPIES[usize::from(n) % CANOPIES.len()]
}
/// The dark green of conifers.
pub(super) fn needles() -> Paint {
    CANOPIES[5]
}
pub(super) fn tiles(n: u8) -> Paint {
    TILES[usize::from(n) % TILES.len()]
}
pub(super) fn flat_roof(n: u8) -> Paint {
    FLAT_ROOFS[usize::from(n) % FLAT_ROOFS.len()]
}
pub(super) fn wall(n: u8) -> Paint {
    WALLS[usize::from(n) % WALLS.len()]
}
pub(super) fn car(n: u8) -> Paint {
    CARS[usize::from(n) % CARS.len()]
}

impl Paint {
    /// 16-bit red, green, blue, near infrared under a light of `shade` (1 is full), with ±6 % of noise.
    #[inline]
    pub fn color(self, shade: f64, hash: u64) -> [u16; 4] {
        let light = shade * (0.94 + 0.12 * unit(hash, 2)) * 257.0;
        // A little of the noise differs between channels, so that all 16 bits say something.
        let grain = (hash >> 52) as u32 & 0xff;
        self.rgbn.map(|c| ((f64::from(c) * light) as u32 + (grain & (u32::from(c) | 15))).min(65_535) as u16)
    }

    /// 16-bit intensity, with ±20 % of speckle and the loss of a beam split over `returns` returns.
    #[inline]
    pub fn intensity(self, returns: u8, hash: u64) -> u16 {
        (f64::from(self.reflectance) * 200.0 * (0.8 + 0.4 * unit(hash, 3)) / f64::from(returns)) as u16
    }
}
