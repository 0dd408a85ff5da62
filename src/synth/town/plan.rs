//! The town's layout, made once per seed: terrain and river, street grid, blocks, buildings, trees.
//!
//! Plan coordinates (u, v) are metres from the town's centre along its streets, which run at 22.6° to the
//! axes of the map (the angle of the 5-12-13 triangle: a rotation without trigonometry).

use super::super::noise::{hash, mix, range, smoothstep, unit, value_noise};

/// Cosine and sine of the angle between map and streets.
pub(super) const TURN: (f64, f64) = (12.0 / 13.0, 5.0 / 13.0);
/// The plan covers `[-REACH, REACH)` in u and v: a map square of 2,048 m, turned, and some more.
pub(super) const REACH: f64 = 1400.0;
/// Height of the river's surface, in metres.
pub(super) const WATER_LEVEL: f64 = 190.0;
/// Spacing of the terrain's lattice, in metres.
const GROUND_STEP: f64 = 8.0;
const GROUND_SIDE: usize = (2.0 * REACH / GROUND_STEP) as usize + 2;
/// Side of the square that one tree has to itself, in metres.
const TREE_STEP: f64 = 8.0;
const TREE_SIDE: usize = (2.0 * REACH / TREE_STEP) as usize;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BlockKind {
    Towers,
    /// Houses wall to wall around a courtyard.
    Perimeter,
    Slabs,
    Houses,
    Halls,
    Church,
    Plaza,
    Park,
    Field,
    Forest,
}

impl BlockKind {
    pub fn is_rural(self) -> bool {
        matches!(self, BlockKind::Field | BlockKind::Forest)
    }
}

/// What lies between four streets. Lots form a grid of `lots` over the inner rectangle.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub kind: BlockKind,
    pub low: [f64; 2],
    pub high: [f64; 2],
    pub lots: [u32; 2],
    lots_per_metre: [f64; 2],
    first_building: u32,
    /// Height of the tallest building, in metres; zero without any.
    pub top: f64,
    pub tint: u8,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Roof {
    Flat,
    /// Ridge along u or v.
    GableU,
    GableV,
    Pyramid,
}

/// One per lot; an empty lot has a box turned inside out.
#[derive(Debug, Clone)]
pub(super) struct Building {
    pub low: [f64; 2],
    pub high: [f64; 2],
    /// Absolute height of the eaves, and what the ridge stands above them, in metres.
    pub eaves: f64,
    pub rise: f64,
    pub roof: Roof,
    pub tint: u8,
}

impl Building {
    const NONE: Building =
        Building { low: [1.0; 2], high: [-1.0; 2], eaves: 0.0, rise: 0.0, roof: Roof::Flat, tint: 0 };

    #[inline]
    pub fn contains(&self, p: [f64; 2]) -> bool {
        p[0] >= self.low[0] && p[0] < self.high[0] && p[1] >= self.low[1] && p[1] < self.high[1]
    }
}

/// A tree; `height` zero means none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tree {
    pub at: [f32; 2],
    pub radius: f32,
    pub height: f32,
    pub tint: u8,
    pub conifer: bool,
}

/// The streets across one axis: where they run and how wide they are.
pub(super) struct Streets {
    /// Street number (the block's lower side) of each metre from `-REACH`.
    street_of_metre: Vec<u8>,
    /// Centre line of each street.
    pub at: Vec<f64>,
    /// Half its width with sidewalks.
    pub half: Vec<f64>,
}

impl Streets {
    fn new(seed: u64, low: f64, high: f64) -> Streets {
        let mut streets = Streets { street_of_metre: Vec::new(), at: Vec::new(), half: Vec::new() };
        let mut at = -REACH;
        while at < REACH + high {
            let number = streets.at.len();
            streets.at.push(at);
            streets.half.push(if number % 4 == 1 { 10.0 } else { 7.0 });
            at += range(hash(seed, number as i64, 0), 0, low, high) as i64 as f64;
        }
        let mut street = 0;
        for metre in 0..(2.0 * REACH) as i64 {
            while streets.at[street + 1] <= metre as f64 - REACH {
                street += 1;
            }
            streets.street_of_metre.push(street as u8);
        }
        streets
    }

    /// Number of the last street at or below `x`.
    #[inline]
    pub fn below(&self, x: f64) -> usize {
        usize::from(self.street_of_metre[((x + REACH) as usize).min(self.street_of_metre.len() - 1)])
    }

    pub fn is_main(&self, street: usize) -> bool {
        self.half[street] > 8.0
    }
}

pub(super) struct Plan {
    pub seed: u64,
    /// Terrain without and with the river's bed, in metres.
    ground: Vec<[f32; 2]>,
    pub columns: Streets,
    pub rows: Streets,
    blocks: Vec<Block>,
    buildings: Vec<Building>,
    trees: Vec<Tree>,
}

impl Plan {
    pub fn new(seed: u64) -> Plan {
        let seed = mix(seed ^ 0x70_77_6e);
        let mut plan = Plan {
            seed,
            ground: lay_ground(seed),
            columns: Streets::new(seed ^ 1, 78.0, 124.0),
            rows: Streets::new(seed ^ 2, 62.0, 92.0),
            blocks: Vec::new(),
            buildings: Vec::new(),
            trees: Vec::new(),
        };
        plan.lay_blocks();
        plan.plant_trees();
        plan
    }

    /// Height of the terrain in metres: as if there were no river, and with its bed.
    #[inline]
    pub fn ground(&self, p: [f64; 2]) -> [f64; 2] {
        let x = (p[0] + REACH) * (1.0 / GROUND_STEP);
        let y = (p[1] + REACH) * (1.0 / GROUND_STEP);
        let (i, j) = ((x as usize).min(GROUND_SIDE - 2), (y as usize).min(GROUND_SIDE - 2));
        let (s, t) = (x - i as f64, y - j as f64);
        let row = &self.ground[j * GROUND_SIDE + i..][..2];
        let next = &self.ground[(j + 1) * GROUND_SIDE + i..][..2];
        std::array::from_fn(|k| {
            let low = f64::from(row[0][k]) * (1.0 - s) + f64::from(row[1][k]) * s;
            let high = f64::from(next[0][k]) * (1.0 - s) + f64::from(next[1][k]) * s;
            low * (1.0 - t) + high * t
        })
    }

    #[inline]
    pub fn block(&self, column: usize, row: usize) -> &Block {
        &self.blocks[row * self.columns.at.len() + column]
    }

    /// The building of this block that stands at `p`.
    #[inline]
    pub fn building(&self, block: &Block, p: [f64; 2]) -> Option<&Building> {
        if block.top == 0.0 || p[0] < block.low[0] || p[1] < block.low[1] {
            return None;
        }
        let lot = [0, 1].map(|k| ((p[k] - block.low[k]) * block.lots_per_metre[k]) as u32);
        if lot[0] >= block.lots[0] || lot[1] >= block.lots[1] {
            return None;
        }
        let building = &self.buildings[(block.first_building + lot[1] * block.lots[0] + lot[0]) as usize];
        building.contains(p).then_some(building)
    }

    /// Lot of a point inside of the block, and where in the lot it is, in metres from its low corner.
    #[inline]
    pub fn lot(&self, block: &Block, p: [f64; 2]) -> ([u32; 2], [f64; 2], [f64; 2]) {
        let lot = [0, 1].map(|k| ((p[k] - block.low[k]) * block.lots_per_metre[k]) as u32);
        let size = [0, 1].map(|k| (block.high[k] - block.low[k]) / f64::from(block.lots[k]));
        (lot, [0, 1].map(|k| p[k] - block.low[k] - f64::from(lot[k]) * size[k]), size)
    }

    /// The tree whose square `p` is in; its crown may not reach `p`.
    #[inline]
    pub fn tree(&self, p: [f64; 2]) -> &Tree {
        let [i, j] = p.map(|x| (((x + REACH) * (1.0 / TREE_STEP)) as usize).min(TREE_SIDE - 1));
        &self.trees[j * TREE_SIDE + i]
    }

    fn lay_blocks(&mut self) {
        let center = [self.columns.below(0.0), self.rows.below(0.0)];
        for row in 0..self.rows.at.len() {
            for column in 0..self.columns.at.len() {
                let block = self.lay_block(column, row, [column, row] == center);
                self.blocks.push(block);
            }
        }
    }

    fn lay_block(&mut self, column: usize, row: usize, is_center: bool) -> Block {
        let h = hash(self.seed ^ 3, column as i64, row as i64);
        let side = |streets: &Streets, n: usize| {
            let next = (n + 1).min(streets.at.len() - 1);
            let end = if next == n { streets.at[n] + 60.0 } else { streets.at[next] };
            (streets.at[n] + streets.half[n], end - streets.half[next])
        };
        let ((u0, u1), (v0, v1)) = (side(&self.columns, column), side(&self.rows, row));
        let middle = [0.5 * (u0 + u1), 0.5 * (v0 + v1)];
        // Zones are rings with frayed borders.
        let out = (middle[0] * middle[0] + middle[1] * middle[1]).sqrt() + range(h, 0, -110.0, 110.0);
        let pick = unit(h, 1);
        let kind = match out {
            _ if is_center => BlockKind::Church,
            o if o < 260.0 => choose(
                pick,
                &[(0.32, BlockKind::Towers), (0.80, BlockKind::Perimeter), (0.88, BlockKind::Plaza)],
                BlockKind::Park,
            ),
            o if o < 560.0 => choose(
                pick,
                &[
                    (0.22, BlockKind::Perimeter),
                    (0.42, BlockKind::Slabs),
                    (0.84, BlockKind::Houses),
                    (0.92, BlockKind::Halls),
                ],
                BlockKind::Park,
            ),
            o if o < 900.0 => choose(
                pick,
                &[(0.72, BlockKind::Houses), (0.80, BlockKind::Slabs), (0.88, BlockKind::Halls)],
                BlockKind::Park,
            ),
            _ => choose(pick, &[(0.62, BlockKind::Field), (0.70, BlockKind::Houses)], BlockKind::Forest),
        };
        let size = [u1 - u0, v1 - v0];
        let lots = match kind {
            BlockKind::Towers => [2, 1 + (h >> 62) as u32 % 2],
            BlockKind::Perimeter => [4, 3],
            BlockKind::Slabs => [1, 2],
            BlockKind::Houses => [((size[0] / 21.0) as u32).max(1), 2],
            BlockKind::Church => [2, 1],
            _ => [1, 1],
        };
        let mut block = Block {
            kind,
            low: [u0, v0],
            high: [u1, v1],
            lots,
            lots_per_metre: [0, 1].map(|k| f64::from(lots[k]) / size[k]),
            first_building: self.buildings.len() as u32,
            top: 0.0,
            tint: (h >> 56) as u8,
        };
        for j in 0..lots[1] {
            for i in 0..lots[0] {
                let building = self.build(&block, [i, j], mix(h ^ u64::from(j * 16 + i + 1)));
                if building.high[0] > building.low[0] {
                    let foot = self.ground([0, 1].map(|k| 0.5 * (building.low[k] + building.high[k])))[0];
                    block.top = block.top.max(building.eaves + 0.5 * building.rise - foot);
                }
                self.buildings.push(building);
            }
        }
        block
    }

    /// The building on one lot.
    fn build(&self, block: &Block, lot: [u32; 2], h: u64) -> Building {
        let size = [0, 1].map(|k| (block.high[k] - block.low[k]) / f64::from(block.lots[k]));
        let corner = [0, 1].map(|k| block.low[k] + f64::from(lot[k]) * size[k]);
        let long_u = if size[0] > size[1] { Roof::GableU } else { Roof::GableV };
        // Margin to the lot's border, height of the eaves, rise of the roof, its shape.
        let (margin, eaves, rise, roof) = match block.kind {
            BlockKind::Towers => ([range(h, 0, 3.0, 9.0), 4.0], range(h, 1, 14.0, 46.0), 0.0, Roof::Flat),
            BlockKind::Perimeter => {
                let is_court = lot[0] > 0 && lot[0] + 1 < block.lots[0] && lot[1] == 1;
                if is_court {
                    return Building::NONE;
                }
                let eaves = 3.1 * f64::from(3 + (h >> 20) as u8 % 3);
                let along = if lot[1] == 1 { Roof::GableV } else { Roof::GableU };
                let roof = if unit(h, 2) < 0.3 { Roof::Flat } else { along };
                ([0.0; 2], eaves, if roof == Roof::Flat { 0.0 } else { 5.0 }, roof)
            }
            BlockKind::Slabs => {
                ([6.0, range(h, 0, 8.0, 10.5)], 3.0 * f64::from(4 + (h >> 20) as u8 % 5), 0.0, Roof::Flat)
            }
            BlockKind::Houses => {
                if unit(h, 3) < 0.06 {
                    return Building::NONE;
                }
                let width = range(h, 0, 8.5, 13.0).min(size[0] - 4.0);
                let depth = range(h, 1, 9.0, 13.5).min(size[1] - 6.0);
                let roof = if (h >> 40) & 1 == 0 { Roof::GableU } else { Roof::GableV };
                let roof = if (h >> 41) & 7 == 0 { Roof::Pyramid } else { roof };
                let margin = [0.5 * (size[0] - width), 0.5 * (size[1] - depth)];
                (margin, range(h, 2, 3.2, 6.6), range(h, 3, 2.6, 4.8), roof)
            }
            BlockKind::Halls => ([9.0, 8.0], range(h, 0, 7.0, 11.0), if h & 1 == 0 { 0.0 } else { 2.2 }, long_u),
            BlockKind::Church if lot[0] == 0 => {
                ([0.5 * (size[0] - 8.5), 0.5 * (size[1] - 8.5)], 30.0, 26.0, Roof::Pyramid)
            }
            BlockKind::Church => ([2.0, 0.5 * (size[1] - 17.0)], 13.0, 9.5, Roof::GableU),
            _ => return Building::NONE,
        };
        // The church's nave begins at its tower.
        let reach_back = if block.kind == BlockKind::Church && lot[0] == 1 { 0.5 * (size[0] - 8.5) + 2.0 } else { 0.0 };
        let low = [corner[0] + margin[0] - reach_back, corner[1] + margin[1]];
        let high = [0, 1].map(|k| corner[k] + size[k] - margin[k]);
        let low = if reach_back > 0.0 { [corner[0], low[1]] } else { low };
        if high[0] - low[0] < 5.0 || high[1] - low[1] < 5.0 {
            return Building::NONE;
        }
        let corners = [[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]];
        let is_by_river = corners.iter().any(|&c| self.ground(c)[0] - self.ground(c)[1] > 0.6);
        if is_by_river {
            return Building::NONE;
        }
        let foot = corners.iter().map(|&c| self.ground(c)[0]).sum::<f64>() / 4.0;
        let roof = if rise == 0.0 { Roof::Flat } else { roof };
        Building { low, high, eaves: foot + eaves, rise, roof, tint: (h >> 48) as u8 }
    }

    fn plant_trees(&mut self) {
        self.trees = vec![Tree::default(); TREE_SIDE * TREE_SIDE];
        for j in 0..TREE_SIDE {
            for i in 0..TREE_SIDE {
                let h = hash(self.seed ^ 4, i as i64, j as i64);
                if let Some(tree) = self.plant_tree([i, j], h) {
                    self.trees[j * TREE_SIDE + i] = tree;
                }
            }
        }
    }

    fn plant_tree(&self, cell: [usize; 2], h: u64) -> Option<Tree> {
        let middle = cell.map(|c| (c as f64 + 0.5) * TREE_STEP - REACH);
        let block = self.block(self.columns.below(middle[0]), self.rows.below(middle[1]));
        let (chance, tall) = match block.kind {
            BlockKind::Forest => (0.96, 1.5),
            BlockKind::Park => (0.55, 1.3),
            BlockKind::Houses => (0.42, 0.8),
            BlockKind::Slabs => (0.5, 1.1),
            BlockKind::Perimeter | BlockKind::Church => (0.6, 1.0),
            BlockKind::Plaza => (0.12, 0.7),
            BlockKind::Towers | BlockKind::Halls => (0.3, 0.9),
            BlockKind::Field => (0.006, 1.2),
        };
        if unit(h, 0) >= chance {
            return None;
        }
        let g = mix(h);
        let radius = range(g, 0, 1.7, 3.9);
        // The crown stays within the tree's own square, so that a beam asks one square only.
        let slack = 0.5 * TREE_STEP - radius;
        let at = [middle[0] + range(g, 1, -slack, slack), middle[1] + range(g, 2, -slack, slack)];
        let is_inside = (0..2).all(|k| at[k] > block.low[k] + 1.0 && at[k] < block.high[k] - 1.0);
        let is_dry = self.ground(at)[1] > WATER_LEVEL + 0.6;
        let is_free = (block.first_building..).take((block.lots[0] * block.lots[1]) as usize).all(|b| {
            let b = &self.buildings[b as usize];
            b.high[0] < b.low[0] || (0..2).any(|k| at[k] + radius < b.low[k] || at[k] - radius > b.high[k])
        });
        let height = (3.0 + 2.6 * radius * tall) * range(g, 3, 0.8, 1.2);
        (is_inside && is_dry && is_free).then_some(Tree {
            at: at.map(|x| x as f32),
            radius: radius as f32,
            height: height as f32,
            tint: (h >> 40) as u8,
            conifer: (h >> 33) & 7 < if block.kind == BlockKind::Forest { 3 } else { 1 },
        })
    }
}

fn choose(pick: f64, table: &[(f64, BlockKind)], otherwise: BlockKind) -> BlockKind {
    table.iter().find(|(limit, _)| pick < *limit).map_or(otherwise, |&(_, kind)| kind)
}

/// Rolling terrain of three octaves, and a river that winds along u through it.
fn lay_ground(seed: u64) -> Vec<[f32; 2]> {
    let mut ground = Vec::with_capacity(GROUND_SIDE * GROUND_SIDE);
    for j in 0..GROUND_SIDE {
        for i in 0..GROUND_SIDE {
            let (u, v) = (i as f64 * GROUND_STEP - REACH, j as f64 * GROUND_STEP - REACH);
            let hills = 44.0 * value_noise(seed ^ 5, u / 620.0, v / 620.0)
                + 9.0 * value_noise(seed ^ 6, u / 210.0, v / 210.0)
                + 1.2 * value_noise(seed ^ 7, u / 60.0, v / 60.0);
            // The town's centre is flatter than the land around it.
            let out = (u * u + v * v).sqrt();
            let base = 196.0 + hills * (0.35 + 0.65 * smoothstep(200.0, 1100.0, out));
            let line = -130.0 + 240.0 * (value_noise(seed ^ 8, u / 430.0, 0.5) - 0.5);
            let away = (v - line).abs();
            let flat = 194.5 + (base - 194.5) * smoothstep(30.0, 260.0, away);
            let bed = 187.0 + (flat - 187.0) * smoothstep(8.0, 34.0, away);
            ground.push([flat as f32, bed as f32]);
        }
    }
    ground
}
