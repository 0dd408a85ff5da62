//! An independent answer to "which record does this pixel show?": the file's integers, read by a few
//! lines that share nothing with the program, projected in f64 by the words of the camera's format.

use std::{fs, path::Path};

use firstlight::synth::Scene;

use crate::bench::{Bench, Outputs, data, ways_to_draw};

const SIZE: [usize; 2] = [800, 600];
/// Pixels that may differ: where f32 and f64 round a point to different sides of a pixel's border.
const MAX_DIFFERING: usize = 50;

/// X, Y, Z in world coordinates of all records of an uncompressed LAS file.
fn read_las(path: &Path) -> Vec<[f64; 3]> {
    let bytes = fs::read(path).unwrap();
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let f64_at = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let record = usize::from(u16::from_le_bytes(bytes[105..107].try_into().unwrap()));
    assert!(bytes[104] < 128, "compressed");
    let count = if bytes[25] >= 4 { u32_at(247) } else { u32_at(107) };
    let positions = bytes[u32_at(96)..].chunks_exact(record).take(count).map(|r| {
        std::array::from_fn(|a| {
            let i = i32::from_le_bytes(r[4 * a..4 * a + 4].try_into().unwrap());
            f64::from(i) * f64_at(131 + 8 * a) + f64_at(155 + 8 * a)
        })
    });
    positions.collect()
}

type Vector = [f64; 3];

fn minus(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// As CAM.json describes it: right-handed perspective, image y down.
struct Camera {
    eye: Vector,
    right: Vector,
    down: Vector,
    forward: Vector,
    focal: f64,
}

impl Camera {
    fn new(eye: Vector, target: Vector, fov_y_deg: f64) -> Camera {
        let forward = unit(minus(target, eye));
        let right = unit(cross(forward, [0.0, 0.0, 1.0]));
        let focal = 1.0 / (0.5 * fov_y_deg.to_radians()).tan();
        Camera { eye, right, down: cross(forward, right), forward, focal }
    }

    /// Pixel number and depth.
    fn project(&self, p: Vector) -> Option<(usize, f64)> {
        let d = minus(p, self.eye);
        let depth = dot(self.forward, d);
        let [width, height] = SIZE.map(|s| s as f64);
        let x = ((dot(self.right, d) * self.focal / depth * (height / width) * 0.5 + 0.5) * width).floor();
        let y = ((dot(self.down, d) * self.focal / depth * 0.5 + 0.5) * height).floor();
        let inside = depth > 0.0 && x >= 0.0 && x < width && y >= 0.0 && y < height;
        inside.then(|| (y as usize * SIZE[0] + x as usize, depth))
    }
}

/// Pixels in which the program shows another record than f64 says, not counting points of the same
/// depth in the same pixel; and pixels that show the right record with a wrong depth.
fn differing(points: &[Vector], camera: &Camera, shown: &Outputs) -> (usize, usize) {
    let projected: Vec<_> = points.iter().map(|&p| camera.project(p)).collect();
    let mut expected: Vec<(f64, i64)> = vec![(f64::INFINITY, -1); SIZE[0] * SIZE[1]];
    for (record, &hit) in projected.iter().enumerate() {
        if let Some((pixel, depth)) = hit
            && depth < expected[pixel].0
        {
            expected[pixel] = (depth, record as i64);
        }
    }
    let (mut count, mut wrong_depths) = (0, 0);
    for (pixel, (&(depth, record), &id)) in expected.iter().zip(&shown.ids).enumerate() {
        let same_depth = |other: f64| (other - depth).abs() < 1e-6 * depth;
        if id == record {
            wrong_depths += usize::from(id >= 0 && !same_depth(f64::from(shown.depth[pixel])));
        } else {
            let hit = usize::try_from(id).ok().and_then(|id| projected[id]);
            count += usize::from(!hit.is_some_and(|(at, other)| at == pixel && same_depth(other)));
        }
    }
    (count, wrong_depths)
}

/// Renders `scan` from a place off the grid and compares.
fn check(bench: &Bench, scan: &Path) {
    let points = read_las(scan);
    let low: Vector = std::array::from_fn(|a| points.iter().map(|p| p[a]).fold(f64::INFINITY, f64::min));
    let high: Vector = std::array::from_fn(|a| points.iter().map(|p| p[a]).fold(f64::NEG_INFINITY, f64::max));
    let extent = minus(high, low);
    let target: Vector = std::array::from_fn(|a| low[a] + [0.47, 0.53, 0.4][a] * extent[a]);
    let reach = extent[0].max(extent[1]);
    // The last digits lie between two steps of the grid.
    let eye = [target[0] - 0.31 * reach + 0.00337, target[1] - 0.62 * reach + 0.00712, target[2] + 0.5 * reach];
    let json = serde_json::json!({ "eye": eye, "target": target, "up": [0, 0, 1], "fov_y_deg": 50 });
    bench.write("cam.json", json.to_string());
    for way in ways_to_draw() {
        let size = format!("{}x{}", SIZE[0], SIZE[1]);
        let shown = bench.render(&format!("{} {way} --camera cam.json --size {size}", scan.display()));
        assert!(shown.covered() > 10_000, "{} pixels show something", shown.covered());
        let (count, wrong_depths) = differing(&points, &Camera::new(eye, target, 50.0), &shown);
        eprintln!("{} {way}: {count} of {} covered pixels differ", scan.display(), shown.covered());
        assert!(count <= MAX_DIFFERING, "{count} pixels differ");
        assert_eq!(wrong_depths, 0);

        // The comparison fails for a camera that is off by a fifth of a pixel.
        let distance = dot(minus(target, eye), minus(target, eye)).sqrt();
        let fifth = 0.2 * distance * 2.0 * 25f64.to_radians().tan() / SIZE[1] as f64;
        let aside = |p: Vector| [p[0] + fifth, p[1], p[2]];
        let (off, _) = differing(&points, &Camera::new(aside(eye), aside(target), 50.0), &shown);
        assert!(off > 20 * MAX_DIFFERING, "a wrong camera goes unnoticed: {off} pixels differ");
    }
}

#[test]
fn pixels_show_the_records_that_f64_says() {
    let bench = Bench::new();
    let scan = bench.scan("town.las", Scene::Town, 200_000);
    check(&bench, &scan);
    if let Some(data) = data() {
        check(&bench, &data.join("scans/pdal-autzen_trim_7.las"));
    }
}
