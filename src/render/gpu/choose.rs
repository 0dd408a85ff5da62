//! Which rasterizers a device can run, and the one to begin with: what the user asked for, else the
//! default until the candidates are measured.

use super::{GpuBackend, HardwareRaster, compute::modules};
use crate::{
    methods::Needs,
    render::{Candidate, Measured, Raster, RasterChoice, RenderError},
};

/// What the device lacks for a method, in words.
pub fn missing(method: Raster, features: wgpu::Features, draws: Option<&'static str>) -> Option<String> {
    let needed = modules(method).iter().fold(wgpu::Features::empty(), |all, shader| all | shader.needs);
    let needed = needed.difference(features);
    match method {
        Raster::Points => draws.map(str::to_owned),
        Raster::Cpu => Some("kernels of that name".into()),
        _ => (!needed.is_empty()).then(|| Needs { features: needed, draws: false }.to_string()),
    }
}

/// The fastest method on most devices, of those that a device with these features can run: early-z, or
/// without 64-bit atomics two-pass-32.
pub fn default_method(features: wgpu::Features) -> Raster {
    if missing(Raster::EarlyZ, features, None).is_none() { Raster::EarlyZ } else { Raster::TwoPass32 }
}

/// A backend with the rasterizer that `choice` asks for.
pub fn backend(
    adapter: &wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    choice: RasterChoice,
) -> Result<GpuBackend, RenderError> {
    let info = adapter.get_info();
    let draws = HardwareRaster::missing(adapter);
    let lack = |method| missing(method, device.features(), draws);
    let candidate = match choice {
        RasterChoice::Auto => Candidate::new(default_method(device.features())),
        RasterChoice::Fixed(candidate) => match lack(candidate.method) {
            Some(missing) => {
                return Err(RenderError::Unsupported { adapter: info.name, method: candidate.method, missing });
            }
            None => candidate,
        },
    };
    let (mut able, mut unable) = (Vec::new(), Vec::new());
    for candidate in Candidate::all() {
        match lack(candidate.method) {
            None => able.push(candidate),
            Some(missing) => unable.push(left_out(candidate, format!("the device lacks {missing}"))),
        }
    }
    Ok(GpuBackend::with_candidate(&info, device, queue, candidate, choice, (able, unable)))
}

/// A row without a speed.
pub fn left_out(candidate: Candidate, why: String) -> Measured {
    Measured { candidate, speed: None, left_out: Some(why) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{gpu::shaders, methods};

    #[test]
    fn missing_features_are_named_and_lead_to_another_default() {
        let all = shaders::INT64_ATOMICS | wgpu::Features::SUBGROUP;
        let no_loads = all.difference(wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS);
        let no_subgroups = shaders::INT64_ATOMICS;
        let nothing = wgpu::Features::empty();
        for method in Raster::ON_GPU {
            assert_eq!(missing(method, all, None), None, "{method}");
        }
        let lacks = |method, features| missing(method, features, None).unwrap_or_default();
        assert_eq!(lacks(Raster::EarlyZ, no_loads), "");
        assert_eq!(lacks(Raster::EarlyZ, nothing), "64-bit atomic minimum");
        assert_eq!(lacks(Raster::ReduceEarlyZ, no_subgroups), "subgroups");
        assert_eq!(lacks(Raster::Dedup, nothing), "64-bit atomic minimum, subgroups");
        assert_eq!(lacks(Raster::TwoPass32, nothing), "");
        assert_eq!(missing(Raster::Points, all, Some("indirect draws")).as_deref(), Some("indirect draws"));
        let defaults = [all, no_subgroups, no_loads, nothing].map(default_method);
        assert_eq!(defaults, [Raster::EarlyZ, Raster::EarlyZ, Raster::EarlyZ, Raster::TwoPass32]);
    }

    #[test]
    fn methods_are_rows_of_the_table_that_give_every_pixel_its_front_point() {
        for raster in Raster::ON_GPU {
            let method = methods::by_name(raster.name()).expect("a row");
            assert!(method.wrong_on_purpose.is_none() && !method.blends, "{raster}");
            let needs = modules(raster).iter().fold(wgpu::Features::empty(), |all, shader| all | shader.needs);
            assert_eq!(needs, method.needs.features, "{raster}");
        }
    }
}
