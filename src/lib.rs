//! Firstlight: an ingest-while-render viewer for LAS/LAZ point clouds.
//!
//! The modules in the order that a point passes through them; nothing flows back but commands:
//!
//! ```text
//! synth     writes test scans                               (LAS, LAZ)
//! source    decoder threads → PointBatch → bounded channel  (knows files, no GPU)
//! info      what a file says of itself                      (header, VLRs, chunks)
//! inspect   one point: its record in the file, to the last digit; distances between points
//! store     batches → random slots of a growing buffer      (permutation, insertion, pages)
//! render    reproject → fresh → fill → index → resolve      (GPU and CPU backends, one frame plan)
//! methods   every way to rasterize points, to be measured against each other
//! headless  the picture as a PNG, a report as JSON
//! view      the picture in a window
//! measure   frame times while a scene grows; how fast points come to the screen; rasterizers compared;
//!           how wrong the picture is, frame by frame
//! cli       what the user typed → one of these
//! ```
//!
//! `scene` and `device` hold the words that all of them share; `gpu` is what every GPU pass stands on.

pub mod scene;

pub mod device;

pub mod gpu;

pub mod synth;

pub mod source;

pub mod info;

pub mod inspect;

pub mod store;

pub mod render;

pub mod methods;

pub mod headless;

pub mod measure;

pub mod view;

pub mod cli;
