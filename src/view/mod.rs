//! TODO
use std::path::PathBuf;

use crate::render::RasterChoice;

pub struct Options {
    pub inputs: Vec<PathBuf>,
    pub raster: RasterChoice,
    pub point_size: u32,
    pub seed: u64,
    pub fill: Option<u32>,
    pub threads: Option<usize>,
}

#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    #[error("no GPU adapter for a window{0}")]
    NoAdapter(String),
}

pub fn has_display() -> bool {
    false
}

pub fn run(_options: Options) -> Result<(), ViewError> {
    Err(ViewError::NoAdapter(String::new()))
}
