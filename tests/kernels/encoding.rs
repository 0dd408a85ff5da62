//! Positions in 8 bytes and in 12: the same points in the same slots, the same picture, bit for bit; and a point
//! outside of the box that was promised is neither lost nor moved.

use std::sync::Arc;

use firstlight::{
    render::{
        Backend, Camera, Clip, CpuBackend, FillBudget, Filter, FrameRequest, GpuBackend, Picture, Progressive, Raster,
        Shading, StoreOptions,
    },
    scene::PointBatch,
    store::{Encoding, Packing},
};

use crate::{
    backends::{RASTERS, gpu},
    cloud::Cloud,
    convergence::{covered, difference},
};

/// What a load ends with.
struct Loaded {
    encoding: Encoding,
    points: PointBatch,
    /// While loading, one for each frame; then the converged picture, that of all points, and one with averages.
    pictures: Vec<Picture>,
}

fn load(backend: GpuBackend, cloud: &Cloud, encoding: Option<Encoding>, page_points: Option<u32>) -> Loaded {
    load_filtered(backend, cloud, encoding, page_points, &Filter::default())
}

/// Loads with a moving camera, a frame after each piece of 5,000 points, so that a frame has several insertions.
fn load_filtered(
    mut backend: GpuBackend,
    cloud: &Cloud,
    encoding: Option<Encoding>,
    page_points: Option<u32>,
    filter: &Filter,
) -> Loaded {
    backend.set_encoding(encoding);
    backend.store_mut().set_page_points(page_points);
    let options = StoreOptions { seed: 5, insertion_points: 1777, ..Default::default() };
    let mut progressive = Progressive::new(backend, options);
    progressive.open(Arc::new(cloud.facts.clone()));
    progressive.set_filter(filter, &Clip::default());
    let request = |camera: &Camera, high_quality| FrameRequest {
        view: camera.view(&cloud.facts.grid, [120, 90], 2).unwrap(),
        fill: FillBudget::Fixed(3000),
        shading: Shading { high_quality, ..Default::default() },
    };
    let mut pictures = Vec::new();
    for (step, start) in (0..cloud.len()).step_by(5000).enumerate() {
        progressive.offer(cloud.batch(start..cloud.len().min(start + 5000)));
        progressive.frame(&request(&cloud.camera_moved(step % 3), step % 2 == 0)).unwrap();
        pictures.push(progressive.read().unwrap());
    }
    progressive.end_of_input();
    for high_quality in [false, true] {
        let request = request(&cloud.camera_moved(1), high_quality);
        while !(progressive.frame(&request).unwrap().is_converged() && progressive.is_loaded()) {}
        pictures.push(progressive.read().unwrap());
        progressive.brute_force(&request).unwrap();
        let all = progressive.read().unwrap();
        assert_eq!(difference(&pictures[pictures.len() - 1], &all), None, "progressive against all points");
    }
    let store = progressive.backend_mut().store_mut();
    let mut points = store.read_points().unwrap();
    points.positions.truncate(cloud.len());
    points.records.truncate(cloud.len());
    points.colors.truncate(cloud.len());
    Loaded { encoding: store.pages.encoding(), points, pictures }
}

/// Both have the same points in the same slots, and drew the same pictures.
fn assert_same(a: &Loaded, b: &Loaded, case: &str) {
    assert!(a.points.records == b.points.records, "{case}: records");
    assert!(a.points.positions == b.points.positions, "{case}: positions");
    assert!(a.points.colors == b.points.colors, "{case}: attributes");
    assert_eq!(a.pictures.len(), b.pictures.len());
    for (n, (a, b)) in a.pictures.iter().zip(&b.pictures).enumerate() {
        assert_eq!(difference(a, b), None, "{case}: picture {n}");
    }
}

#[test]
fn packed_positions_give_the_picture_of_wide_ones() {
    let cloud = Cloud::town(20_011).in_random_order();
    for raster in RASTERS {
        for page_points in [None, Some(1000)] {
            let [Some(wide), Some(packed)] = [gpu(raster), gpu(raster)] else { return };
            let wide = load(wide, &cloud, Some(Encoding::Wide), page_points);
            let packed = load(packed, &cloud, Some(Encoding::Packed), page_points);
            assert_eq!((wide.encoding, packed.encoding), (Encoding::Wide, Encoding::Packed));
            let case = format!("{raster}, pages of {page_points:?}");
            assert_same(&wide, &packed, &case);
            assert!(covered(&packed.pictures[0]) > 500, "{case}: there is something to compare");
            for (position, &record) in packed.points.positions.iter().zip(&packed.points.records) {
                assert_eq!(*position, cloud.positions()[record as usize], "{case}: record {record}");
            }
        }
    }
}

/// An outlier comes with the first batch, amid a frame's insertions, or last; pages straddle insertions.
#[test]
fn a_point_outside_of_the_promised_box_widens_the_store() {
    for (from, nth) in [(0, 5000), (8123, 3001), (20_010, 1)] {
        let cloud = Cloud::town(20_011).in_random_order().with_outliers(from, nth);
        for raster in [Raster::EarlyZ, Raster::TwoPass32, Raster::Points] {
            for page_points in [None, Some(1000)] {
                let [Some(wide), Some(auto)] = [gpu(raster), gpu(raster)] else { return };
                let wide = load(wide, &cloud, Some(Encoding::Wide), page_points);
                let widened = load(auto, &cloud, Some(Encoding::Packed), page_points);
                let case = format!("{raster}, pages of {page_points:?}, outliers from {from}");
                assert_eq!(widened.encoding, Encoding::Wide, "{case}");
                assert_same(&wide, &widened, &case);
                let records = &widened.points.records;
                let slot = records.iter().position(|&record| record as usize == from).unwrap();
                assert_eq!(widened.points.positions[slot], cloud.positions()[from], "{case}: neither lost nor moved");
            }
        }
    }
}

/// A filter is asked of the points as they lie in memory: also where they change their place in it while it is set.
#[test]
fn a_filter_stays_when_the_store_widens() {
    let cloud = Cloud::town(20_011).in_random_order().with_outliers(8123, 3001);
    let filter = Filter { clauses: vec!["elevation=0.5..6".parse().unwrap()] };
    for raster in [Raster::EarlyZ, Raster::TwoPass32] {
        for page_points in [None, Some(1000)] {
            let [Some(wide), Some(auto), Some(unfiltered)] = [gpu(raster), gpu(raster), gpu(raster)] else { return };
            let wide = load_filtered(wide, &cloud, Some(Encoding::Wide), page_points, &filter);
            let widened = load_filtered(auto, &cloud, Some(Encoding::Packed), page_points, &filter);
            let case = format!("{raster}, pages of {page_points:?}");
            assert_eq!(widened.encoding, Encoding::Wide, "{case}");
            assert_same(&wide, &widened, &case);
            let all = load(unfiltered, &cloud, Some(Encoding::Wide), page_points);
            assert!(covered(&wide.pictures[0]) > 100, "{case}: something is shown");
            assert!(all.pictures.iter().zip(&wide.pictures).all(|(a, b)| difference(a, b).is_some()), "{case}");
        }
    }
}

/// The comparisons above can fail: an encoding that clamps to its box, or wraps, loses the outlier.
#[test]
fn without_widening_an_outlier_would_be_somewhere_else() {
    let cloud = Cloud::town(2000).with_outliers(1234, 1000);
    let packing = cloud.packing().unwrap();
    let outlier = cloud.positions()[1234];
    assert!(!packing.holds(outlier) && !packing.holds_all(cloud.positions()));
    let kept = packing.unpack(packing.pack(outlier));
    assert_ne!(kept, outlier);
    assert!(packing.holds_all(&cloud.positions()[..1234]));
}

/// Scenes of other encodings follow one another in a window; the processor's backend has one for all.
#[test]
fn scenes_of_either_encoding_follow_one_another() {
    let narrow = Cloud::town(6000);
    // 33 bits an axis in millimetres do not fit.
    let far = Cloud::town(6000).with_outliers(0, 3);
    let mut promised = far.clone();
    let all = f64::from(i32::MAX) * 0.001;
    (promised.facts.bounds.min, promised.facts.bounds.max) = ([-all; 3], [all; 3]);
    assert!(promised.packing().is_none());
    let look = |progressive: &mut Progressive<Box<dyn Backend>>, cloud: &Cloud| {
        progressive.open(Arc::new(cloud.facts.clone()));
        progressive.offer(cloud.batch(0..cloud.len()));
        progressive.end_of_input();
        let request = FrameRequest {
            view: narrow.camera().view(&cloud.facts.grid, [120, 90], 1).unwrap(),
            fill: FillBudget::Fixed(3000),
            shading: Shading::default(),
        };
        while !(progressive.frame(&request).unwrap().is_converged() && progressive.is_loaded()) {}
        progressive.read().unwrap()
    };
    for raster in [Raster::TwoPass32, Raster::Points] {
        let Some(backend) = gpu(raster) else { return };
        let mut window: Progressive<Box<dyn Backend>> = Progressive::new(Box::new(backend), StoreOptions::default());
        let mut pictures = Vec::new();
        for cloud in [&narrow, &promised, &far, &narrow, &promised] {
            let picture = look(&mut window, cloud);
            let mut cpu: Progressive<Box<dyn Backend>> =
                Progressive::new(Box::new(CpuBackend::new(None)), StoreOptions::default());
            let expected = look(&mut cpu, cloud);
            let different = picture.records.iter().zip(&expected.records).filter(|(a, b)| a != b).count();
            // Float rounding may decide a pixel where a device fuses multiplication and addition.
            assert!(different * 1000 <= expected.records.len(), "{raster}: {different} pixels unlike the processor's");
            pictures.push(picture);
        }
        assert_eq!(difference(&pictures[0], &pictures[3]), None);
        assert_eq!(difference(&pictures[1], &pictures[4]), None);
        assert_eq!(difference(&pictures[1], &pictures[2]), None, "promised or not");
    }
}

/// Scenes at the edges of what fits: an axis without bits, one of 32, a field that crosses the two words.
#[test]
fn fields_anywhere_in_the_word() {
    let Some(mut backend) = gpu(Raster::TwoPass32) else { return };
    let boxes: [[[i32; 3]; 2]; 6] = [
        [[0; 3], [0; 3]],
        [[i32::MIN, 5, i32::MIN], [i32::MAX, 5, i32::MAX]],
        [[7, i32::MIN, i32::MIN], [7, i32::MAX, i32::MAX]],
        [[-100, -100, -3], [1_000_000, 2_000_000, 4_000_000]],
        [[i32::MAX - 9, i32::MIN, 0], [i32::MAX, i32::MIN + 1, i32::MAX]],
        [[i32::MIN, i32::MIN, 0], [i32::MAX, i32::MAX, 0]],
    ];
    for [low, high] in boxes {
        let packing = Packing::of([low, high]).unwrap();
        let position = |k: usize| -> [i32; 3] {
            std::array::from_fn(|a| {
                let size = u64::from(high[a].abs_diff(low[a])) + 1;
                let within =
                    (k as u64).wrapping_mul([0x9E37_79B9_7F4A_7C15, 0xC2B2_AE3D_27D4_EB4F, 0xD6E8_FEB8_6659_FD93][a]);
                low[a].wrapping_add((within % size) as u32 as i32)
            })
        };
        let mut positions: Vec<[i32; 3]> = (0..998).map(position).collect();
        positions.extend([low, high]);
        let n = positions.len() as u32;
        let batch = PointBatch {
            positions: positions.clone(),
            colors: vec![[0; 4]; n as usize],
            records: (0..n).collect(),
            ..Default::default()
        };
        backend.reset(n.into(), Some(packing));
        let insertion = firstlight::store::Insertion::new(0, n, 3, 0);
        backend.insert(&insertion, &batch).unwrap();
        let store = backend.store_mut();
        // Inserted by the kernels; then by the host's word, and by the kernel that widens, each point as it was.
        store.flush();
        let check = |points: &PointBatch| {
            for (position, &record) in points.positions.iter().zip(&points.records).take(n as usize) {
                assert_eq!(*position, positions[record as usize], "{packing:?}");
            }
        };
        check(&store.read_points().unwrap());
        store.widen(n).unwrap();
        assert_eq!(store.pages.encoding(), Encoding::Wide);
        check(&store.read_points().unwrap());
    }
}
