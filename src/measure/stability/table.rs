//! The experiments, one row each.

use super::{
    averages, contention, degenerate, depth, experiment::Experiment, exposure, fill, holes, loading, point_size,
    positions, shuffles, slots, ties,
};
use crate::{
    measure::report_dir::ReportDirError,
    methods::MethodError,
    render::{CameraError, RenderError},
};

/// Why a run ends early.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Methods(#[from] MethodError),
    #[error(transparent)]
    Camera(#[from] CameraError),
    #[error("no method is called {0}")]
    NoMethod(&'static str),
    #[error(transparent)]
    ReportDir(#[from] ReportDirError),
}

const PAPER_2013: &str = "Günther et al. 2013, A GPGPU-based Pipeline for Accelerated Rendering of Point Clouds";
const PAPER_2019: &str = "Schütz and Wimmer 2019, Rendering Point Clouds with Compute Shaders";
const PAPER_2020: &str = "Schütz, Mandlburger, Otepka and Wimmer 2020, Progressive Real-Time Rendering of One Billion \
Points Without Hierarchical Acceleration Structures (Eurographics)";
const PAPER_2021: &str =
    "Schütz, Kerbl and Wimmer 2021, Rendering Point Clouds with Compute Shaders and Vertex Order Optimization";

/// All experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "far-coordinates",
        what: "UTM-sized coordinates, seen close up by a camera that moves slowly",
        source: "viewers that keep f32 positions; Thorne 2005, Using a Floating Origin to Improve Fidelity and Performance \
                 of Large, Distributed Virtual Worlds",
        fails: "absolute f32 positions: points jump by pixels",
        holds: "integer positions: no point is in another pixel than it should",
        run: positions::jitter,
    },
    Experiment {
        name: "moving-origin",
        what: "a flight of 25 km, with an origin that is moved to the camera every 10,000 units",
        source: "floating origins of f32 viewers; the distance is that of a thesis on progressive point rendering, which \
                 reports the stall",
        fails: "a stall, and points in the wrong place, while the pool refills",
        holds: "integer positions need no shift",
        run: positions::origin_shift,
    },
    Experiment {
        name: "close-planes",
        what: "two planes 1 mm apart, seen from 1 m, 1 km and 100 km",
        source: PAPER_2019,
        fails: "hyperbolic depth, of 24 bits and of floats: the plane behind shows",
        holds: "linear float depth up to 1 km, 40-bit depth beyond",
        run: depth::planes_apart,
    },
    Experiment {
        name: "shuffles",
        what: "the beginning of orders that are called random",
        source: "perfect shuffles: a thesis on progressive point rendering; quadratic residues: Schütz, Mandlburger, Otepka and \
                 Wimmer 2020 (Eurographics), after J. Preshing 2012; four rounds: this program's own first design",
        fails: "perfect-shuffle iterations, quadratic residues, four Feistel rounds, shuffling each batch alone",
        holds: "the store's keyed permutation, batch by batch: white spectrum, chi-square of chance",
        run: shuffles::shuffles,
    },
    Experiment {
        name: "unshuffled",
        what: "a buffer in the order of the file, filled part by part",
        source: PAPER_2020,
        fails: "clusters: whole tiles stay empty, and flicker as the camera turns",
        holds: "a shuffled buffer fills all tiles alike",
        run: fill::clusters,
    },
    Experiment {
        name: "moved-slots",
        what: "insertions move points to other slots while the list of visible slots names them",
        source: "Schütz and Wimmer 2018, Progressive Real-Time Rendering of Unprocessed Point Clouds \
                 (distribute_streaming.cs moves points and tells nobody where to; that lists suffer is concluded from the code)",
        fails: "pixels are lost while a file loads",
        holds: "slots that follow `moved_to`: no pixel is lost",
        run: loading::moved_slots,
    },
    Experiment {
        name: "many-fragments",
        what: "more than 1,023 fragments in one pixel",
        source: PAPER_2021,
        fails: "hqs1: a sum of 18-18-18-10 bits wraps, and the colour is wrong",
        holds: "hqs1r: the mean",
        run: averages::many_fragments,
    },
    Experiment {
        name: "one-pixel",
        what: "all points in one pixel, and in one tile of 16×16",
        source: PAPER_2021,
        fails: "atomic-min and busy-loop take many times as long (counted on GPUs only)",
        holds: "the chosen method, with an early test, stays within 1.3 times its usual time (counted on GPUs only)",
        run: contention::one_pixel,
    },
    Experiment {
        name: "racing-threads",
        what: "a depth test that is not thread-safe",
        source: PAPER_2013,
        fails: "racy: points behind others are shown",
        holds: "an atomic minimum: the picture of the definition",
        run: contention::racy,
    },
    Experiment {
        name: "slot-zero",
        what: "the point in slot 0, and those in multiples of 2²⁴",
        source: "Schütz and Wimmer 2018, dynamic_ibo.cs of github.com/m-schuetz/siggraph2018: a pixel whose bytes are 0 is \
                 taken for empty",
        fails: "such points are drawn once and then forgotten",
        holds: "every slot is listed",
        run: slots::every_slot,
    },
    Experiment {
        name: "point-size",
        what: "points of 1, 2, 4 and 8 pixels, in motion and at rest",
        source: "a thesis on progressive point rendering (holes after a step of 1/60 of the way to the target); README, How exact",
        fails: "1 px leaves holes in motion, 8 px lose detail at rest",
        holds: "the window's 2 px: few holes, little lost",
        run: point_size::point_sizes,
    },
    Experiment {
        name: "equal-depths",
        what: "points of equal depth, and points that are there twice",
        source: "viewers that draw with a depth test alone, and lists of visible points in the order of threads (Skye)",
        fails: "a depth test alone: another picture in every run",
        holds: "the lowest of equally deep slots: the same picture in every run, whatever the threads",
        run: ties::equal_depths,
    },
    Experiment {
        name: "degenerate",
        what: "one point, a line, all points equal; camera poses that are not numbers",
        source: "viewers that scale a scene to its box, and look-at matrices without checks",
        fails: "divisions by 0",
        holds: "a picture, the same every time, or an error that says why",
        run: degenerate::degenerate,
    },
    Experiment {
        name: "exposure",
        what: "8-bit colours in 16-bit fields, and dark scans of 16 bits",
        source: "LAS 1.4 R15, point data record format 2: colours are to be normalized to 16 bits, which many writers don't do",
        fails: "a picture that is black, or blown out",
        holds: "the colours that the file means, decided by all points so far",
        run: exposure::exposure,
    },
    Experiment {
        name: "starved-fill",
        what: "a fast pan across a dense scan with a tiny budget, then rest",
        source: PAPER_2020,
        fails: "one budget for both: reprojection starves the fill, and the picture never converges",
        holds: "converged ⌈points / budget⌉ + 1 frames after the camera stops",
        run: fill::starvation,
    },
    Experiment {
        name: "holes",
        what: "a town under a sky, thinned out, its holes filled, against the picture of all points",
        source: "Rosenthal and Linsen 2008, Image-space Point Cloud Rendering",
        fails: "holes show the background; filled without masks, silhouettes grow",
        holds: "small holes are filled, mostly with the right depth and colour, and background hardly ever",
        run: holes::holes,
    },
];

/// The experiment of that name.
pub fn by_name(name: &str) -> Option<&'static Experiment> {
    EXPERIMENTS.iter().find(|experiment| experiment.name == name)
}
