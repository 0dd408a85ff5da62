//! How the kernels that draw points are launched.

use std::fmt;

use super::Encoding;

/// Workgroups and threads of the kernels that draw points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Launch {
    /// Threads of a workgroup: 64, 128 or 256.
    pub threads: u32,
    /// Points that a thread draws: 1 to 16.
    pub points: u32,
    /// Whether workgroups draw from 1,024 places of a page in turn, and not from its start to its end.
    pub is_spread: bool,
}

impl Launch {
    /// As in the literature: a thread a point, from the first to the last.
    pub const PLAIN: Launch = Launch { threads: 256, points: 1, is_spread: false };

    /// The fastest on an H200: of 8 bytes a point, a thread loads eight for as many bytes to be on their way.
    pub const fn tuned(encoding: Encoding) -> Launch {
        let points = match encoding {
            Encoding::Wide => 4,
            Encoding::Packed => 8,
        };
        Launch { threads: 64, points, is_spread: true }
    }

    /// Places of a page that spread workgroups draw from.
    const PLACES: u32 = 1024;

    /// Workgroups for a page of so many points.
    pub(super) fn groups(self, points: u32) -> u32 {
        let blocks = points.div_ceil(self.threads * self.points);
        // With fewer blocks than places, each place has one, and they come in order.
        if self.is_spread && blocks > Launch::PLACES { blocks.next_multiple_of(Launch::PLACES) } else { blocks }
    }

    /// The template `shaders/methods/each.wgsl` for this launch.
    pub(super) fn fill_in(self, template: &str) -> String {
        let Launch { threads, points, is_spread } = self;
        let mut source = format!(
            "const THREADS: u32 = {threads}u;\nconst POINTS: u32 = {points}u;\nconst PLACES: u32 = {}u;\n\
             const IS_SPREAD: bool = {is_spread};\n",
            Launch::PLACES
        );
        for repeated in
            template.split_inclusive('\n').collect::<Vec<_>>().chunk_by(|a, b| is_repeated(a) == is_repeated(b))
        {
            if !is_repeated(repeated[0]) {
                source.extend(repeated.iter().copied());
                continue;
            }
            for line in repeated {
                source.extend((0..points).map(|n| line.replace("$n", &n.to_string())));
            }
        }
        source
    }
}

fn is_repeated(line: &str) -> bool {
    line.contains("$n") && !line.starts_with("//")
}

impl fmt::Display for Launch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spread = if self.is_spread { ", spread" } else { "" };
        write!(f, "{} threads x {} points{spread}", self.threads, self.points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_repeated_for_each_point() {
        let launch = Launch { points: 2, ..Launch::PLAIN };
        let filled = launch.fill_in("// $n stays\nstart\nlet a_$n = $nu;\nuse(a_$n);\nend\n");
        assert!(
            filled.ends_with("// $n stays\nstart\nlet a_0 = 0u;\nlet a_1 = 1u;\nuse(a_0);\nuse(a_1);\nend\n"),
            "{filled}"
        );
    }

    #[test]
    fn groups_hold_all_points() {
        for launch in
            [Launch::PLAIN, Launch::tuned(Encoding::Packed), Launch { threads: 128, points: 16, is_spread: true }]
        {
            let block = launch.threads * launch.points;
            for points in [0, 1, block, block + 1, 1024 * block, 1024 * block + 1, 1 << 30] {
                let groups = launch.groups(points);
                assert!(groups >= points.div_ceil(block), "{launch}: {points}");
                assert!(groups < points.div_ceil(block) + 1024, "{launch}: {points}");
            }
        }
    }
}
