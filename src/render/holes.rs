//! Hole filling: a background pixel among the points of a surface takes the colour of the nearest of those around.
//! Twin of `shaders/holes.wgsl`.
//!
//! After Rosenthal and Linsen ("Image-space point cloud rendering", Computer Graphics International 2008, section 4):
//! a background pixel is looked at through eight masks, each of [`MASK`] neighbouring directions. Where one of them
//! sees background alone, the pixel lies outside of a silhouette and stays as it is; else it takes the colour of the
//! seen point that is nearest to the eye. Theirs are masks of 3×3 pixels, applied again and again for larger holes;
//! here a direction is looked along for [`REACH`] pixels at once, so that a hole is as small after a hundred frames.
//!
//! Only the picture changes: a filled pixel shows no record, has no depth, and is not reprojected. Background that
//! shows between the points of a near surface where a far one lies behind them is not background, and stays as well.
//! What that gets right and wrong is measured by `firstlight stability holes`.

/// Pixels that a direction is looked along: holes twice as wide are filled, larger ones from their rims on.
pub const REACH: usize = 2;

/// So many of eight directions in a row that see no point: the pixel is outside.
pub const MASK: u32 = 3;

/// The eight directions, in turn.
const DIRECTIONS: [[isize; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];

/// Which pixel a background pixel takes its colour from, if it is in a hole. `depth` is that of a pixel's point,
/// +∞ or not a number for background. With a `mask` of 9, every pixel with a point in reach is taken for a hole.
pub fn source(size: [usize; 2], pixel: usize, reach: usize, mask: u32, depth: impl Fn(usize) -> f32) -> Option<usize> {
    let [width, height] = size;
    let (x, y) = (pixel % width, pixel / width);
    let (mut nearest, mut found) = (f32::MAX, None);
    let mut hits = [false; 8];
    for (hit, [dx, dy]) in hits.iter_mut().zip(DIRECTIONS) {
        let along = (1..=reach as isize).map_while(|n| {
            let (x, y) = (x.checked_add_signed(n * dx)?, y.checked_add_signed(n * dy)?);
            (x < width && y < height).then(|| y * width + x)
        });
        let seen = along.map(|at| (at, depth(at))).find(|(_, depth)| depth.is_finite());
        if let Some((at, depth)) = seen {
            *hit = true;
            if depth < nearest {
                (nearest, found) = (depth, Some(at));
            }
        }
    }
    // Of all directions around, those in a row without a point.
    let empty = (0..8).map(|start| (start..start + 8).take_while(|k| !hits[k % 8]).count() as u32);
    found.filter(|_| empty.max().is_some_and(|empty| empty < mask))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture in letters: a dot for background, else a depth. Which pixels are filled, from where.
    fn filled(rows: &[&str]) -> Vec<(usize, usize)> {
        let letters: Vec<char> = rows.iter().flat_map(|row| row.chars()).collect();
        let depth = |at: usize| letters[at].to_digit(10).map_or(f32::INFINITY, |depth| depth as f32);
        let size = [rows[0].len(), rows.len()];
        let background = (0..letters.len()).filter(|&at| letters[at] == '.');
        background.filter_map(|at| source(size, at, REACH, MASK, depth).map(|from| (at, from))).collect()
    }

    #[test]
    fn holes_are_filled_from_the_nearest_point_around() {
        assert_eq!(filled(&["555", "5.4", "555"]), [(4, 5)]);
        // Of equal ones the first, from the right around.
        assert_eq!(filled(&["555", "5.5", "555"]), [(4, 5)]);
        // Two and three pixels wide.
        assert_eq!(filled(&["55555", "55..5", "55..5", "55555"]).len(), 4);
        assert_eq!(
            filled(&["55555", "5...5", "5...5", "5...5", "55555"]).len(),
            5,
            "corners see three empty directions"
        );
        // Half of the points are missing.
        assert_eq!(filled(&["5.5.5", ".5.5.", "5.5.5", ".5.5.", "5.5.5"]).len(), 12 - 8);
    }

    #[test]
    fn background_stays() {
        assert_eq!(filled(&["...", "...", "..."]), []);
        // Beside an edge, straight, at a corner, and at the end of a line.
        assert_eq!(filled(&["....", "....", "5555", "5555"]), []);
        assert_eq!(filled(&["55....", "55....", "55....", "555555", "555555"]), []);
        assert_eq!(filled(&[".....", "..5..", "..5..", "..5.."]), []);
        // Larger holes than the reach: a ring, in the middle; its rim is within reach of three sides only.
        let ring = ["5555555", "5.....5", "5.....5", "5.....5", "5.....5", "5.....5", "5555555"];
        assert!(!filled(&ring).iter().any(|&(at, _)| at == 24));
    }
}
