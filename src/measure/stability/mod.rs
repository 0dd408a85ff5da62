//! `firstlight stability`: where methods fail, one experiment per known failure.
//!
//! Each experiment names its source, shows the failing method *failing* by a number, and shows this program's own
//! choice holding where the other fails. If either stops being true the run says so: a check that cannot fail
//! shows nothing. So every experiment can also be run with its remedy switched off, and with the right method in the
//! place of the failing one ([`Swap`]); the tests hold that both are noticed.
//!
//! This program's side runs the code of the viewer (projection, store, shuffle, progressive frames, rasterizers);
//! the failing side is written out here, small, as its source describes it, where no other room has it.
//!
//! ```text
//! table       EXPERIMENTS, and why a run ends early
//! experiment  what an experiment is given, claims, and hands back
//! run         all of them in turn
//! report      all samples: JSON; csv: a line per sample; page: tables, charts, pictures
//! picture     small pictures as PNG, one by one in data URIs, and all on a sheet
//! scenes      points to try methods on, and how they enter a store
//! pinhole     a projection in f64, and one of f32 positions
//! uniformity  chi-square and spectral tests of orders of points
//!
//! positions   coordinates far from the origin; an origin that follows the camera
//! depth       two planes a millimetre apart
//! shuffles    orders that are called random
//! fill        clustered orders; a pan that starves the fill
//! loading     slots that move while a list names them
//! averages    more fragments in a pixel than a counter counts
//! contention  all points in one pixel; a depth test that threads break
//! slots       slots that are taken for empty pixels
//! point_size  points of 1 to 8 pixels, in motion and at rest
//! ties        equal depths
//! degenerate  clouds without extent, poses without numbers
//! exposure    colours of 8 and of 16 bits
//! holes       what hole filling gets right and wrong
//! ```

mod averages;
mod contention;
mod csv;
mod degenerate;
mod depth;
mod experiment;
mod exposure;
mod fill;
mod holes;
mod loading;
mod page;
mod picture;
mod pinhole;
mod point_size;
mod positions;
mod report;
mod run;
mod scenes;
mod shuffles;
mod slots;
mod table;
mod ties;
pub mod uniformity;

pub use csv::write_csv;
pub use experiment::{Bound, Claim, Experiment, Outcome, Role, Setup, Size, Swap};
pub use page::{markdown, page};
pub use picture::Image;
pub use report::{Entry, StabilityReport, TITLE};
pub use run::{Watcher, stability};
pub use table::{EXPERIMENTS, StabilityError, by_name};
