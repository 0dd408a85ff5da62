//! What one laser beam hits: roofs, walls in sight of the scanner, trees, cars, ground, water.
//!
//! A beam is named by the spot where it would meet the ground. A building in between catches it
//! earlier: on its roof, or on the wall that faces the scanner; behind buildings lies a shadow without points,
//! as in a real scan. Beams are taken as vertical within trees.

use super::super::noise::{hash, mix, unit};
use super::paint::{self, Paint};
use super::plan::{Block, BlockKind, Building, Plan, Roof, TURN, Tree, WATER_LEVEL};

/// A beam on its way down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beam {
    /// Where it would meet the ground, in metres from the town's centre (x east, y north).
    pub at: [f64; 2],
    /// Metres sideways per metre of height, and the direction on the map in which the scanner is (a unit vector).
    pub slope: f64,
    pub toward: [f64; 2],
    pub hash: u64,
}

/// Where a beam was reflected, and by what.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub at: [f64; 3],
    pub paint: Paint,
    pub shade: f64,
}

/// What the beam met first.
pub(super) enum Target<'a> {
    Solid(Hit),
    /// A crown: it lets some of the beam through.
    Crown {
        tree: &'a Tree,
        ground: f64,
        away: f64,
    },
}

/// Streets' coordinates of a place on the map.
#[inline]
fn to_plan(at: [f64; 2]) -> [f64; 2] {
    [TURN.0 * at[0] + TURN.1 * at[1], TURN.0 * at[1] - TURN.1 * at[0]]
}

#[inline]
pub(super) fn strike<'a>(plan: &'a Plan, beam: &Beam) -> Target<'a> {
    let p = to_plan(beam.at);
    let column = plan.columns.below(p[0]);
    let row = plan.rows.below(p[1]);
    let block = plan.block(column, row);
    let [bare, carved] = plan.ground(p);

    if block.top > 0.0
        && let Some(hit) = strike_building(plan, block, beam, p, bare)
    {
        return Target::Solid(hit);
    }
    let tree = plan.tree(p);
    if tree.height > 0.0 {
        let (du, dv) = (p[0] - f64::from(tree.at[0]), p[1] - f64::from(tree.at[1]));
        let radius = f64::from(tree.radius);
        let away = (du * du + dv * dv) / (radius * radius);
        // A ragged outline.
        if away < 0.8 + 0.4 * unit(beam.hash, 1) {
            return Target::Crown { tree, ground: carved, away: away.min(1.0) };
        }
    }
    Target::Solid(strike_ground(plan, block, beam, p, [column, row], [bare, carved]))
}

/// Height of a building's roof above `p`, and the light on it.
#[inline]
fn roof_at(b: &Building, p: [f64; 2]) -> (f64, f64) {
    let t = |k: usize| ((p[k] - b.low[k]) / (b.high[k] - b.low[k])).clamp(0.0, 1.0);
    match b.roof {
        Roof::Flat => (b.eaves, 1.0),
        Roof::GableU => {
            let t = t(1);
            (b.eaves + b.rise * (1.0 - (2.0 * t - 1.0).abs()), if t < 0.5 { 1.08 } else { 0.78 })
        }
        Roof::GableV => {
            let t = t(0);
            (b.eaves + b.rise * (1.0 - (2.0 * t - 1.0).abs()), if t < 0.5 { 0.86 } else { 1.02 })
        }
        Roof::Pyramid => {
            let (s, t) = (2.0 * t(0) - 1.0, 2.0 * t(1) - 1.0);
            let shade = match (s.abs() > t.abs(), s < 0.0, t < 0.0) {
                (true, true, _) => 0.86,
                (true, false, _) => 1.02,
                (false, _, true) => 1.08,
                (false, _, false) => 0.78,
            };
            (b.eaves + b.rise * (1.0 - s.abs().max(t.abs())), shade)
        }
    }
}

fn strike_building(plan: &Plan, block: &Block, beam: &Beam, p: [f64; 2], ground: f64) -> Option<Hit> {
    // One metre toward the scanner, in plan coordinates.
    let step = to_plan(beam.toward);
    let moved = |d: f64| [p[0] + step[0] * d, p[1] + step[1] * d];
    if let Some(b) = plan.building(block, p) {
        let exit =
            |k: usize| (if step[k] > 0.0 { b.high[k] - p[k] } else { p[k] - b.low[k] }) / step[k].abs().max(1e-9);
        let (side, out) = if exit(0) < exit(1) { (0, exit(0)) } else { (1, exit(1)) };
        // Up to the roof there: a gable's triangle is wall, too.
        let wall = moved(out);
        if out < beam.slope * (roof_at(b, wall).0 - ground) {
            let z = ground + out / beam.slope;
            // Where the next house stands wall to wall, and higher than this, there is no wall to see.
            let is_hidden = plan.building(block, moved(out + 0.1)).is_some_and(|next| roof_at(next, wall).0 > z);
            return Some(if is_hidden {
                roof_hit(b, beam, p, 0.0)
            } else {
                wall_hit(b, beam, wall, side, out, z, ground)
            });
        }
        let first = roof_at(b, p).0 - ground;
        let shift = beam.slope * first;
        let shift = beam.slope * (roof_at(b, moved(shift)).0 - ground);
        return Some(roof_hit(b, beam, moved(shift), shift));
    }
    // In the shadow of a building nearer to the scanner, the beam ends on that one's roof.
    let b = plan.building(block, moved(beam.slope * block.top))?;
    let shift = beam.slope * (b.eaves + 0.5 * b.rise - ground);
    let spot = moved(shift);
    b.contains(spot).then(|| roof_hit(b, beam, spot, shift))
}

/// The beam's spot, moved some metres toward the scanner.
#[inline]
fn shifted(beam: &Beam, shift: f64) -> [f64; 2] {
    [beam.at[0] + beam.toward[0] * shift, beam.at[1] + beam.toward[1] * shift]
}

/// A point on the roof, `shift` metres from the beam's spot toward the scanner.
fn roof_hit(b: &Building, beam: &Beam, p: [f64; 2], shift: f64) -> Hit {
    let (mut z, shade) = roof_at(b, p);
    let mut paint = if b.roof == Roof::Flat { paint::flat_roof(b.tint) } else { paint::tiles(b.tint) };
    if b.roof == Roof::Flat {
        let edge = (0..2).map(|k| (p[k] - b.low[k]).min(b.high[k] - p[k])).fold(f64::MAX, f64::min);
        if edge < 0.35 {
            z += 0.7;
        } else if edge > 2.0 {
            // Machines and skylights: boxes on some squares of 6 m.
            let cell = [0, 1].map(|k| ((p[k] - b.low[k]) * (1.0 / 6.0)) as i64);
            let h = hash(u64::from(b.tint), cell[0], cell[1]);
            let inside = (0..2).all(|k| {
                let t = p[k] - b.low[k] - cell[k] as f64 * 6.0;
                (1.4..4.2).contains(&t)
            });
            if inside && h & 7 < 2 {
                z += 0.9 + unit(h, 1);
                paint = paint::MACHINE;
            }
        }
    }
    let [x, y] = shifted(beam, shift);
    Hit { at: [x, y, z + 0.03 * unit(beam.hash, 1)], paint, shade }
}

/// A point on the wall across axis `side`.
fn wall_hit(b: &Building, beam: &Beam, p: [f64; 2], side: usize, shift: f64, z: f64, ground: f64) -> Hit {
    let along = p[1 - side] - b.low[1 - side];
    let (storey, bay) = ((z - ground) % 3.0, along % 2.7);
    let is_window = (0.9..2.3).contains(&storey) && (0.7..1.9).contains(&bay);
    let paint = if is_window { paint::WINDOW } else { paint::wall(b.tint.wrapping_mul(31) >> 2) };
    let [x, y] = shifted(beam, shift);
    Hit { at: [x, y, z], paint, shade: if side == 0 { 0.72 } else { 0.9 } }
}

/// Return `number` (from 0) of `count` in a crown.
#[inline]
pub(super) fn crown_hit(tree: &Tree, beam: &Beam, ground: f64, away: f64, number: u8, count: u8) -> Hit {
    let h = mix(beam.hash ^ u64::from(number));
    let height = f64::from(tree.height);
    let top =
        if tree.conifer { height * (1.0 - 0.85 * away.sqrt()) } else { height * (0.45 + 0.55 * (1.0 - away).sqrt()) };
    let at = |z: f64| [beam.at[0], beam.at[1], z];
    if number == 0 {
        let depth = unit(h, 0) * unit(h, 1);
        let paint = if tree.conifer { paint::needles() } else { paint::canopy(tree.tint) };
        // Outer and higher leaves are lighter.
        let shade = (0.72 + 0.4 * top / height - 0.35 * depth) * (0.9 + 0.2 * f64::from(tree.tint) / 255.0);
        return Hit { at: at(ground + top * (1.0 - 0.22 * depth)), paint, shade };
    }
    if number + 1 == count {
        let is_bush = h >> 61 == 0;
        let above = if is_bush { 0.2 + 0.8 * unit(h, 0) } else { 0.05 * unit(h, 0) };
        // Below the lowest branch, so that later returns are lower under the smallest tree, too.
        let z = ground + above.min(0.15 * top);
        let paint = if is_bush { paint::UNDERGROWTH } else { paint::FOREST_FLOOR };
        return Hit { at: at(z), paint, shade: 0.7 };
    }
    // Branches between: later returns are lower.
    let part = (f64::from(count - number) - 0.8 * unit(h, 0)) / f64::from(count);
    Hit { at: at(ground + top * 0.75 * part), paint: paint::BRANCHES, shade: 0.65 }
}

fn strike_ground(
    plan: &Plan,
    block: &Block,
    beam: &Beam,
    p: [f64; 2],
    street: [usize; 2],
    [bare, carved]: [f64; 2],
) -> Hit {
    let grain = 0.03 * unit(beam.hash, 1);
    let hit = |z: f64, paint: Paint| Hit { at: [beam.at[0], beam.at[1], z], paint, shade: 1.0 };

    // Distance to the centre line of the nearest street across each axis, and half its width.
    let nearest = |k: usize| {
        let streets = if k == 0 { &plan.columns } else { &plan.rows };
        let n = street[k];
        let next = (n + 1).min(streets.at.len() - 1);
        let n = if p[k] - streets.at[n] < streets.at[next] - p[k] { n } else { next };
        let half = if block.kind.is_rural() && !streets.is_main(n) { 2.0 } else { streets.half[n] };
        let offset = p[k] - streets.at[n];
        Way { away: offset.abs(), half, number: n, is_upper: offset > 0.0 }
    };
    let ways = [nearest(0), nearest(1)];
    let is_bridge = bare - carved > 0.3 && plan.columns.is_main(ways[0].number) && ways[0].away < ways[0].half;
    if !is_bridge {
        if carved < WATER_LEVEL {
            return hit(WATER_LEVEL + grain, paint::WATER);
        }
        if bare - carved > 0.5 {
            return hit(carved + 3.0 * grain, paint::BANK);
        }
    }
    let z = if is_bridge { bare } else { carved };
    if let Some(hit) = strike_street(beam, p, ways, z, is_bridge) {
        return hit;
    }
    let patch = hash(plan.seed, (p[0] + 4096.0) as i64 / 3, (p[1] + 4096.0) as i64 / 3);
    let shade = 0.93 + 0.14 * unit(patch, 0);
    let yard = |z: f64, paint: Paint| Hit { at: [beam.at[0], beam.at[1], z], paint, shade };
    let inner = (0..2).map(|k| (p[k] - block.low[k]).min(block.high[k] - p[k])).fold(f64::MAX, f64::min);
    match block.kind {
        BlockKind::Towers | BlockKind::Plaza | BlockKind::Church => yard(z + 0.1 + grain, paint::PLAZA),
        BlockKind::Halls => yard(z + grain, paint::ASPHALT),
        BlockKind::Houses => {
            let (lot, at, size) = plan.lot(block, p);
            let is_hedge = at[0] < 0.35 || at[0] > size[0] - 0.35;
            if is_hedge && inner > 3.0 && !(lot[0] + lot[1]).is_multiple_of(3) {
                return yard(z + 1.3 * (1.0 - 0.6 * unit(beam.hash, 1) * unit(beam.hash, 3)), paint::HEDGE);
            }
            let is_drive = (at[0] - 0.5 * size[0]).abs() < 1.6;
            if is_drive { yard(z + grain, paint::GRAVEL) } else { yard(z + 2.0 * grain, paint::LAWN) }
        }
        BlockKind::Park => {
            let (du, dv) = (p[0] - 0.5 * (block.low[0] + block.high[0]), p[1] - 0.5 * (block.low[1] + block.high[1]));
            let ring = (du * du + dv * dv).sqrt() - 20.0;
            let is_path = ring.abs() < 1.5 || (du.abs() < 1.4 || dv.abs() < 1.4) && ring > 0.0;
            if is_path { yard(z + grain, paint::GRAVEL) } else { yard(z + 3.0 * grain, paint::LAWN) }
        }
        BlockKind::Field => {
            let k = usize::from(block.tint & 1);
            let furrow = (p[k] * 0.5 + 4096.0) % 1.0;
            let hit = yard(z + 6.0 * grain + 0.2 * furrow, paint::crop(block.tint >> 1));
            Hit { shade: shade * (0.88 + 0.2 * furrow), ..hit }
        }
        BlockKind::Forest => yard(z + 4.0 * grain, paint::FOREST_FLOOR),
        BlockKind::Perimeter | BlockKind::Slabs => {
            let is_rim = inner < 2.0;
            if is_rim { yard(z + grain, paint::SIDEWALK) } else { yard(z + 2.0 * grain, paint::MEADOW) }
        }
    }
}

/// The nearest street across one axis.
#[derive(Clone, Copy)]
struct Way {
    /// Distance to its centre line, and half its width with sidewalks, in metres.
    away: f64,
    half: f64,
    number: usize,
    is_upper: bool,
}

/// Asphalt with its markings, sidewalks, parked cars; nothing if no street is near.
fn strike_street(beam: &Beam, p: [f64; 2], ways: [Way; 2], z: f64, is_bridge: bool) -> Option<Hit> {
    const SIDEWALK: f64 = 2.4;
    let grain = 0.02 * unit(beam.hash, 1);
    let hit = |z: f64, paint: Paint| Hit { at: [beam.at[0], beam.at[1], z], paint, shade: 1.0 };
    let is_on = |k: usize, rim: f64| ways[k].away < ways[k].half - rim;
    if !is_on(0, 0.0) && !is_on(1, 0.0) {
        return None;
    }
    if ways.iter().any(|w| w.half < 3.0 && w.away < w.half) && !is_on(0, SIDEWALK) && !is_on(1, SIDEWALK) {
        return Some(hit(z + grain, paint::GRAVEL));
    }
    let is_crossing = is_on(0, 0.0) && is_on(1, 0.0);
    if !is_on(0, SIDEWALK) && !is_on(1, SIDEWALK) {
        return Some(hit(z + 0.12 + grain, if is_bridge { paint::BRIDGE } else { paint::SIDEWALK }));
    }
    if is_crossing {
        return Some(hit(z + grain, paint::ASPHALT));
    }
    let k = usize::from(!is_on(0, SIDEWALK));
    let Way { away, half, number, is_upper } = ways[k];
    let along = p[1 - k] + 4096.0;
    // Cars are parked at the curb, 6 m each, but not at crossings.
    let curb = half - SIDEWALK - away;
    if (0.2..2.0).contains(&curb) && ways[1 - k].away > ways[1 - k].half + 4.0 && !is_bridge {
        let side = if is_upper { 2 } else { 0 };
        let h = hash(number as u64 + 17, (along * (1.0 / 6.0)) as i64, side + k as i64);
        let at = along % 6.0;
        if h & 7 < 3 && (0.7..5.1).contains(&at) {
            let body = if (1.8..4.5).contains(&at) { 1.45 } else { 0.85 };
            return Some(hit(z + body + grain, paint::car((h >> 32) as u8)));
        }
    }
    let is_dash = away < 0.1 && along % 6.0 < 3.0;
    Some(hit(z + grain, if is_dash { paint::MARKING } else { paint::ASPHALT }))
}
