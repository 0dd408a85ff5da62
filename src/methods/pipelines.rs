//! Pipelines, made when a method first needs them.

use std::collections::HashMap;

use super::{
    Encoding, Launch, Packing,
    modules::{self, Kernel},
};
use crate::gpu::kernel;

/// Turns of the busy loop before a point gives up: enough for all threads of a pixel to have their turn,
/// too few to keep a GPU from answering.
const SPINS: u32 = 4096;
/// The same on a processor, where a thread that holds a lock may be off its core for milliseconds: with
/// 4,096 turns, a whole group of 256 was seen to give up on two busy cores.
const SOFTWARE_SPINS: u32 = 1 << 20;

/// All pipelines of one encoding.
pub struct Pipelines {
    encoding: Encoding,
    /// By kernel, and by whether they are for views that are near.
    made: HashMap<(&'static str, bool), wgpu::ComputePipeline>,
    spins: u32,
    packing: Option<Packing>,
    pub launch: Launch,
    /// [`crate::render::View::is_near`] of the cloud's box.
    pub is_near: bool,
}

impl Pipelines {
    /// `packing` is that of the packed encoding.
    pub fn new(packing: Option<Packing>, is_software: bool) -> Pipelines {
        let spins = if is_software { SOFTWARE_SPINS } else { SPINS };
        let encoding = if packing.is_some() { Encoding::Packed } else { Encoding::Wide };
        Pipelines { encoding, made: HashMap::new(), spins, packing, launch: Launch::tuned(encoding), is_near: false }
    }

    /// What a module of points is compiled with.
    pub fn constants(&self) -> Vec<(&'static str, f64)> {
        let names = ["bits_x", "bits_y", "bits_z"];
        self.packing.iter().flat_map(|packing| names.into_iter().zip(packing.bits.map(f64::from))).collect()
    }

    pub fn module(&self, device: &wgpu::Device, kernel: &Kernel) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(kernel.name),
            source: wgpu::ShaderSource::Wgsl(kernel.source(self.encoding, self.launch).into()),
        })
    }

    /// Makes a kernel's pipeline if it is not there yet.
    pub fn make(&mut self, device: &wgpu::Device, kernel: &'static Kernel, groups: &[&wgpu::BindGroupLayout]) {
        if self.get(kernel).is_some() {
            return;
        }
        let mut constants = self.constants();
        constants.push(("IS_NEAR", f64::from(u8::from(self.is_near))));
        if [modules::BUSY_LOOP.name, modules::BUSY_LOOP_N.name].contains(&kernel.name) {
            constants.push(("spins", f64::from(self.spins)));
        }
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.name),
            layout: Some(&kernel::pipeline_layout(device, kernel.name, groups)),
            module: &self.module(device, kernel),
            entry_point: Some(kernel.entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            cache: None,
        });
        self.made.insert((kernel.name, self.is_near), pipeline);
    }

    pub fn get(&self, kernel: &Kernel) -> Option<&wgpu::ComputePipeline> {
        self.made.get(&(kernel.name, self.is_near))
    }

    /// For another cloud in the same encoding; says whether pipelines must be made anew.
    pub fn set_packing(&mut self, packing: Option<Packing>) -> bool {
        let is_other = self.packing.map(|old| old.bits) != packing.map(|new| new.bits);
        self.packing = packing;
        if is_other {
            self.made.clear();
        }
        is_other
    }

    pub fn set_launch(&mut self, launch: Launch) {
        self.launch = launch;
        self.made.clear();
    }

    pub fn set_spins(&mut self, spins: u32) {
        self.spins = spins;
        self.made.clear();
    }
}
