//! The default camera, also where a header's box is no help.

use glam::DVec3;

use crate::{
    render::{Camera, Clip, Look, SOUTH_AND_ABOVE, clipped},
    scene::{Bounds, Grid, PointBatch, SceneFacts},
};

/// The camera that shows the whole scene in a picture of `size` pixels. `first` is the first batch of
/// points, if there is one; it is asked only where the headers' boxes cannot be right.
pub fn default_camera(facts: &SceneFacts, first: Option<&PointBatch>, size: [u32; 2]) -> Camera {
    default_camera_of(facts, first, size, &Look::default())
}

/// As [`default_camera`], of what a look shows of the scene, with its projection: what its clipping box and slab leave
/// of the scene's box (a filter leaves all of it). A slab is seen from across.
pub fn default_camera_of(facts: &SceneFacts, first: Option<&PointBatch>, size: [u32; 2], look: &Look) -> Camera {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let from = direction(&look.clip);
    let fit = |bounds: &Bounds| Camera::fit_as(bounds, &facts.grid, aspect, from, look.projection);
    let bounds = box_to_fit(facts, first);
    // Where nothing is shown, the whole scene is where to look for it.
    let camera = fit(&clipped(&bounds, &look.clip).unwrap_or(bounds));
    if camera.view(&facts.grid, size, 1).is_ok() {
        return camera;
    }
    // A box of finite but absurd numbers: farther away than the grid reaches.
    let bounds = first.and_then(|batch| box_of(batch, &facts.grid)).unwrap_or(unit_box(&facts.grid));
    fit(&bounds)
}

/// From the scene towards the eye. Along a section its points would be one line.
fn direction(clip: &Clip) -> DVec3 {
    let Some(slab) = clip.slab else { return SOUTH_AND_ABOVE };
    let across = DVec3::from_array(slab.across());
    if across.dot(SOUTH_AND_ABOVE) < 0.0 { -across } else { across }
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

    fn camera_of(clip: Clip) -> Camera {
        default_camera_of(&facts([0.0; 3], [100.0, 50.0, 20.0]), None, [640, 480], &Look { clip, ..Default::default() })
    }

    #[test]
    fn what_is_clipped_fills_the_picture() {
        let bounds = Some("10,20,0,20,30,10".parse().expect("a box"));
        let part = facts([10.0, 20.0, 0.0], [20.0, 30.0, 10.0]);
        assert_eq!(camera_of(Clip { bounds, slab: None }), default_camera(&part, None, [640, 480]));
        let nothing = Clip { bounds: Some("900,0,0,901,1,1".parse().expect("a box")), slab: None };
        assert_eq!(camera_of(nothing), camera_of(Clip::default()));
    }

    #[test]
    fn a_section_is_seen_from_across() {
        for (slab, from) in [
            ("10,0,0,1,0,0,0.5", DVec3::X),
            ("10,0,0,-2,0,0,0.5", DVec3::X),
            ("0,25,0,0,1,0,0.5", -DVec3::Y),
            ("0,0,10,0,0,1,0.5", DVec3::Z),
        ] {
            let camera = camera_of(Clip { bounds: None, slab: Some(slab.parse().expect("a slab")) });
            let [eye, target] = [camera.eye, camera.target].map(DVec3::from_array);
            assert!((eye - target).normalize().distance(from) < 1e-3, "{slab}: {camera:?}");
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
