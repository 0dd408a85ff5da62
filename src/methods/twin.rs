//! What each method's picture is, in plain Rust: from the papers' definitions, not from the kernels.

use super::{
    Cloud, Depth40, Drawn, Method, NO_POINT, depth40,
    plan::{Rule, Sums},
};
use crate::render::View;

/// A point that falls into a pixel.
#[derive(Debug, Clone, Copy)]
struct Fragment {
    point: u32,
    depth: f32,
    color: [u8; 3],
}

/// All fragments of a picture, pixel by pixel, in the cloud's order.
struct Fragments {
    of_pixel: Vec<Vec<Fragment>>,
}

impl Fragments {
    fn of(cloud: &Cloud, view: &View, size: [u32; 2]) -> Fragments {
        let view = view_of(view, size);
        let mut of_pixel = vec![Vec::new(); size[0] as usize * size[1] as usize];
        for ((&position, &color), point) in cloud.positions.iter().zip(&cloud.colors).zip(0..) {
            let Some(projected) = view.project(position) else { continue };
            let [x, y] = projected.corner;
            let [red, green, blue, _] = color.to_le_bytes();
            let fragment = Fragment { point, depth: projected.depth, color: [red, green, blue] };
            of_pixel[y as usize * size[0] as usize + x as usize].push(fragment);
        }
        Fragments { of_pixel }
    }
}

/// The view with points of one pixel.
fn view_of(view: &View, size: [u32; 2]) -> View {
    View { point_size: 1, width: size[0], height: size[1], ..*view }
}

fn opaque([red, green, blue]: [u8; 3]) -> [u8; 4] {
    [red, green, blue, 255]
}

/// The picture that `method` draws of a cloud. Where a method's result depends on the order of threads
/// (`just-set`, `racy`), the picture of threads one after the other; [`is_possible`] says what else is
/// allowed.
pub fn draw(method: &Method, cloud: &Cloud, view: &View, size: [u32; 2]) -> Drawn {
    let fragments = Fragments::of(cloud, view, size);
    let view = view_of(view, size);
    let shown = fragments.of_pixel.iter().map(|pixel| show(method.plan.rule, pixel, cloud, &view));
    let mut drawn = Drawn { size, point: Vec::new(), depth: Vec::new(), rgba: Vec::new(), give_ups: 0 };
    for (point, depth, rgba) in shown {
        drawn.point.push(point);
        drawn.depth.push(depth);
        drawn.rgba.push(rgba);
    }
    drawn
}

/// Point, depth and colour of a pixel with these fragments.
fn show(rule: Rule, fragments: &[Fragment], cloud: &Cloud, view: &View) -> (u32, f32, [u8; 4]) {
    let Some(front) = front(rule, fragments, cloud, view) else { return (NO_POINT, f32::INFINITY, [0; 4]) };
    match rule {
        Rule::Depth40 { is_ranged } => {
            let nm = Depth40::of(view).nanometres(view, cloud.positions[front.point as usize]);
            (front.point, depth40::depth(depth40::code(nm, is_ranged), is_ranged), opaque(front.color))
        }
        Rule::Average(sums) => (front.point, front.depth, average(sums, front.depth, fragments)),
        _ => (front.point, front.depth, opaque(front.color)),
    }
}

/// The fragment that is shown, or whose depth rules an average. Of equal ones the first.
fn front(rule: Rule, fragments: &[Fragment], cloud: &Cloud, view: &View) -> Option<Fragment> {
    // `min_by_key` takes the first of equal ones.
    let nearest = |key: &dyn Fn(&Fragment) -> u64| fragments.iter().copied().min_by_key(key);
    match rule {
        Rule::Any => fragments.last().copied(),
        Rule::Nearest | Rule::AnyTorn | Rule::Average(_) => nearest(&|f| f.depth.to_bits().into()),
        Rule::NearestNormalized => nearest(&|f| normalized(f.depth, view).to_bits().into()),
        Rule::Depth40 { is_ranged } => {
            let of = Depth40::of(view);
            nearest(&|f| {
                let nm = of.nanometres(view, cloud.positions[f.point as usize]);
                let [red, green, blue] = f.color.map(u64::from);
                depth40::code(nm, is_ranged) << 24 | blue << 16 | green << 8 | red
            })
        }
    }
}

/// A depth as a depth buffer with an infinite far plane has it; the near plane is at 2⁻²⁶ of the
/// largest depth that the view's scale promises.
fn normalized(depth: f32, view: &View) -> f32 {
    let near = 2f32.powi(-26) / view.row_w[3];
    (1.0 - near / depth).max(0.0)
}

/// The mean colour of all fragments within 1 % behind the front, rounded to the nearest.
fn average(sums: Sums, front: f32, fragments: &[Fragment]) -> [u8; 4] {
    let blended = fragments.iter().filter(|f| f.depth <= front * 1.01);
    let [mut red, mut green, mut blue, mut count] = [0u64; 4];
    for fragment in blended {
        let [r, g, b] = fragment.color.map(u64::from);
        (red, green, blue, count) = (red + r, green + g, blue + b, count + 1);
    }
    if sums == Sums::Bits18 {
        // All four in one number, which forgets what does not fit: a sum that overflows adds to the one
        // above it.
        let word = (u128::from(red) << 46) + (u128::from(green) << 28) + (u128::from(blue) << 10) + u128::from(count);
        let bits = |from: u32, count: u32| (word >> from) as u64 & ((1 << count) - 1);
        (red, green, blue, count) = (bits(46, 18), bits(28, 18), bits(10, 18), bits(0, 10));
    }
    if count == 0 {
        return [0, 0, 0, 255];
    }
    opaque([red, green, blue].map(|sum| ((sum + count / 2) / count).min(255) as u8))
}

/// Whether `method` may have drawn this: of a deterministic method one picture alone. `just-set` may show
/// any point of each pixel, `racy` with the depth of any other; the busy loop may miss as many pixels
/// as points gave up, and shows points that are there.
///
/// # Errors
/// The first pixel that no order of threads explains.
pub fn is_possible(method: &Method, cloud: &Cloud, view: &View, drawn: &Drawn) -> Result<(), String> {
    impossible(method, cloud, view, drawn).into_iter().next().map_or(Ok(()), Err)
}

/// All pixels that no order of threads explains, a sentence each; see [`is_possible`].
pub fn impossible(method: &Method, cloud: &Cloud, view: &View, drawn: &Drawn) -> Vec<String> {
    let fragments = Fragments::of(cloud, view, drawn.size);
    let expected = draw(method, cloud, view, drawn.size);
    let is_unordered = matches!(method.plan.rule, Rule::Any | Rule::AnyTorn);
    let mut excuses = drawn.give_ups;
    let mut wrong = Vec::new();
    for (index, pixel) in fragments.of_pixel.iter().enumerate() {
        let [x, y] = [index % drawn.size[0] as usize, index / drawn.size[0] as usize];
        let found = (drawn.point[index], drawn.depth[index], drawn.rgba[index]);
        let right = (expected.point[index], expected.depth[index], expected.rgba[index]);
        if found.0 == right.0 && same_depth(found.1, right.1) && found.2 == right.2 {
            continue;
        }
        let may_differ = is_unordered || excuses > 0;
        excuses = excuses.saturating_sub(1);
        if let Some(why) =
            (!may_differ).then(|| format!("expected {right:?}")).or_else(|| unexplained(method, pixel, found))
        {
            wrong.push(format!("{}: pixel {x}, {y} of {} fragments shows {found:?}: {why}", method.name, pixel.len()));
        }
    }
    wrong
}

/// True for depths that differ by rounding alone: devices that fuse multiplication and addition (an H200
/// does) end a few units in the last place away.
fn same_depth(a: f32, b: f32) -> bool {
    a.to_bits().abs_diff(b.to_bits()) <= 4
}

/// Why no order of threads shows this in a pixel of these fragments.
fn unexplained(method: &Method, pixel: &[Fragment], (point, depth, rgba): (u32, f32, [u8; 4])) -> Option<String> {
    if point == NO_POINT && method.plan.has_sums {
        // All points of the pixel gave up.
        return None;
    }
    let Some(shown) = pixel.iter().find(|f| f.point == point) else {
        return Some("the point is not there".into());
    };
    let is_its_depth = |f: &Fragment| same_depth(f.depth, depth);
    let is_torn = method.plan.rule == Rule::AnyTorn && pixel.iter().any(is_its_depth);
    if !is_its_depth(shown) && !is_torn {
        return Some(format!("the point is at {}", shown.depth));
    }
    (rgba != opaque(shown.color)).then(|| format!("the point is {:?}", shown.color))
}
