//! Figures that others published, to stand beside one's own.
//!
//! Frame times, milliseconds, of Schütz, Kerbl and Wimmer 2021, "Rendering Point Clouds with Compute Shaders and
//! Vertex Order Optimization" (Computer Graphics Forum 40(4), doi:10.1111/cgf.14345): the averages "frame" in the
//! authors' own files `doc/benchmarks/data/models_{3090,2070,1060}.json` of github.com/m-schuetz/compute_rasterizer
//! at commit 7e4eb39, from which a script beside them makes the paper's table of orders. Retz has 145 million
//! points; it does not fit the 6 GB of a GTX 1060, for which the largest model there is Lifeboat.

use super::orders::Order;

/// One device and one model.
pub struct Published {
    pub device: &'static str,
    pub model: &'static str,
    /// In millions, where the paper's abstract or captions say so.
    pub million_points: Option<f64>,
    /// Per order, per column of the table.
    pub frame_ms: [(Order, [f64; 10]); 4],
}

/// What the columns measured, by the names of this program's methods. "guenther" of the files is a busy loop,
/// "HQS1x,protected" the HQS1R of the paper.
pub const METHODS: [&str; 10] =
    ["points", "atomic-min", "reduce", "early-z", "reduce-early-z", "dedup", "just-set", "hqs", "hqs1r", "busy-loop"];

/// To be named wherever the figures are shown.
pub const CITATION: &str = "M. Schütz, B. Kerbl, M. Wimmer 2021: Rendering Point Clouds with Compute Shaders and Vertex \
Order Optimization, Computer Graphics Forum 40(4), doi:10.1111/cgf.14345; averages of whole frames from the authors' \
files doc/benchmarks/data/models_*.json, github.com/m-schuetz/compute_rasterizer, commit 7e4eb39";

/// All of it.
pub const PUBLISHED: [Published; 3] = [
    Published {
        device: "RTX 3090",
        model: "Retz",
        million_points: Some(145.0),
        frame_ms: [
            (Order::Original, [31.98, 5.07, 3.91, 3.81, 3.36, 3.07, 2.93, 8.40, 6.87, 7.66]),
            (Order::Morton, [32.05, 5.01, 3.86, 3.76, 3.35, 3.06, 2.93, 8.36, 6.83, 7.65]),
            (Order::Shuffled, [30.57, 8.58, 8.70, 6.10, 5.35, 5.93, 4.24, 16.23, 13.18, 5.55]),
            (Order::ShuffledMorton, [8.22, 3.75, 3.39, 3.46, 3.31, 3.44, 3.18, 7.08, 6.61, 3.84]),
        ],
    },
    Published {
        device: "RTX 2070",
        model: "Retz",
        million_points: Some(145.0),
        frame_ms: [
            (Order::Original, [42.10, 9.73, 7.50, 7.93, 7.00, 6.33, 5.89, 15.75, 13.50, 13.83]),
            (Order::Morton, [42.80, 9.71, 7.48, 7.91, 6.92, 6.31, 5.90, 15.89, 13.50, 13.79]),
            (Order::Shuffled, [45.63, 37.55, 38.73, 18.30, 18.74, 17.90, 16.53, 51.23, 44.32, 16.15]),
            (Order::ShuffledMorton, [16.16, 9.20, 8.14, 7.70, 7.65, 7.60, 7.29, 15.81, 15.43, 9.25]),
        ],
    },
    Published {
        device: "GTX 1060",
        model: "Lifeboat",
        million_points: None,
        frame_ms: [
            (Order::Original, [24.17, 7.76, 7.14, 6.13, 6.09, 9.84, 5.61, 12.48, 11.95, 9.29]),
            (Order::Morton, [34.05, 8.60, 6.92, 6.97, 6.42, 6.62, 5.11, 13.50, 12.47, 13.05]),
            (Order::Shuffled, [84.06, 62.45, 63.04, 32.07, 31.01, 35.68, 26.00, 67.58, 68.03, 30.14]),
            (Order::ShuffledMorton, [23.66, 9.21, 8.04, 7.11, 7.23, 7.70, 5.85, 14.03, 14.51, 11.03]),
        ],
    },
];
