//! The default camera, also where a header's box is no help.

use crate::{
    render::{Camera, Projection, SOUTH_AND_ABOVE},
    scene::{Bounds, Grid, PointBatch, SceneFacts},
};

/// The camera that shows the whole scene in a picture of `size` pixels. `first` is the first batch of
/// points, if there is one; it is asked only where the headers' boxes cannot be right.
pub fn default_camera(facts: &SceneFacts, first: Option<&PointBatch>, size: [u32; 2]) -> Camera {
    default_camera_as(facts, first, size, Projection::Perspective)
}

/// As [`default_camera`], with any projection.
pub fn default_camera_as(
    facts: &SceneFacts,
    first: Option<&PointBatch>,
    size: [u32; 2],
    projection: Projection,
) -> Camera {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let fit = |bounds: &Bounds| Camera::fit_as(bounds, &facts.grid, aspect, SOUTH_AND_ABOVE, projection);
    let bounds = box_to_fit(facts, first);
    let camera = fit(&bounds);
    if camera.view(&facts.grid, size, 1).is_ok() {
        return camera;
    }
    // A box of finite but absurd numbers: farther away than the grid reaches.
    let bounds = first.and_then(|batch| box_of(batch, &facts.grid)).unwrap_or(unit_box(&facts.grid));
    fit(&bounds)
}

/// The headers' box, unless it is turned inside out, not finite, a single spot that the points are
/// not on, or holds none of the first points: then the box of those.
pub fn box_to_fit(facts: &SceneFacts, first: Option<&PointBatch>) -> Bounds {
    let Some((batch, seen)) = first.and_then(|batch| Some((batch, box_of(batch, &facts.grid)?))) else {
        return if facts.bounds.is_sane() { facts.bounds } else { unit_box(&facts.grid) };
    };
    let promised = facts.files.get(batch.file as usize).map_or(facts.bounds, |file| file.bounds);
    if facts.bounds.is_sane() && promised.is_sane() && overlap(&promised, &seen, &facts.grid) {
        facts.bounds
    } else {
        seen
    }
}

/// True if the boxes share a spot, give or take a grid step; a header often rounds its box.
fn overlap(a: &Bounds, b: &Bounds, grid: &Grid) -> bool {
    (0..3).all(|k| a.min[k] <= b.max[k] + grid.scale[k].abs() && b.min[k] <= a.max[k] + grid.scale[k].abs())
}

fn box_of(batch: &PointBatch, grid: &Grid) -> Option<Bounds> {
    let first = *batch.positions.first()?;
    let (mut low, mut high) = (first, first);
    for p in &batch.positions {
        for a in 0..3 {
            low[a] = low[a].min(p[a]);
            high[a] = high[a].max(p[a]);
        }
    }
    Some(Bounds { min: grid.world(low), max: grid.world(high) })
}

/// A box for scenes of which nothing is known.
fn unit_box(grid: &Grid) -> Bounds {
    Bounds { min: grid.origin, max: grid.origin.map(|o| o + 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FileFacts;

    fn facts(min: [f64; 3], max: [f64; 3]) -> SceneFacts {
        let bounds = Bounds { min, max };
        let file = FileFacts {
            path: "a.las".into(),
            first_record: 0,
            points_in_header: 2,
            bounds,
            kind: "LAS 1.2, format 0".into(),
            ..Default::default()
        };
        let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
        SceneFacts { grid, bounds, files: vec![file], warnings: Vec::new() }
    }

    fn batch(positions: &[[i32; 3]]) -> PointBatch {
        PointBatch { positions: positions.to_vec(), ..Default::default() }
    }

    #[test]
    fn a_right_header_is_believed() {
        let facts = facts([0.0; 3], [9.0; 3]);
        assert_eq!(box_to_fit(&facts, Some(&batch(&[[0; 3], [100; 3]]))), facts.bounds);
        assert_eq!(box_to_fit(&facts, None), facts.bounds);
    }

    #[test]
    fn a_wrong_header_gives_way_to_the_first_points() {
        let points = batch(&[[100; 3], [300, 200, 100]]);
        let seen = Bounds { min: [1.0; 3], max: [3.0, 2.0, 1.0] };
        let inside_out = facts([1.0; 3], [-1.0; 3]);
        let not_finite = facts([f64::NAN; 3], [1.0; 3]);
        let spot = facts([0.0; 3], [0.0; 3]);
        let elsewhere = facts([50.0; 3], [60.0; 3]);
        for facts in [inside_out, not_finite, spot, elsewhere] {
            assert_eq!(box_to_fit(&facts, Some(&points)), seen, "{:?}", facts.bounds);
        }
    }

    #[test]
    fn any_header_gives_a_camera_that_works() {
        let absurd = facts([-1e300; 3], [1e300; 3]);
        let nothing = facts([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let points = batch(&[[100; 3]]);
        for facts in [absurd, nothing] {
            for first in [None, Some(&points)] {
                let camera = default_camera(&facts, first, [640, 480]);
                assert!(camera.view(&facts.grid, [640, 480], 1).is_ok(), "{camera:?}");
            }
        }
    }
}
