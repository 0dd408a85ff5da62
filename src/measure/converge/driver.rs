//! One method at work: [`Progressive`] with the switches of a [`Variant`].

use crate::{
    headless::make_backend,
    render::{
        Backend, Camera, CameraError, FillBudget, FrameReport, FrameRequest, Picture, Progressive, Shading,
        StoreOptions,
    },
    scene::Grid,
};

use super::{
    ConvergeError,
    input::Recording,
    settings::{Measure, Setting, Variant},
};

/// Draws frames of one setting.
pub struct Driver {
    pub progressive: Progressive<Box<dyn Backend>>,
    variant: Variant,
    grid: Grid,
    size: [u32; 2],
    point_size: u32,
    shading: Shading,
}

impl Driver {
    /// A device of its own, with the scene opened. `insertion_points` enter the store at a time.
    ///
    /// # Errors
    /// If no device does what is asked.
    pub fn new(
        measure: &Measure,
        setting: &Setting,
        recording: &Recording,
        insertion_points: u32,
        shading: Shading,
    ) -> Result<Driver, ConvergeError> {
        let (mut backend, _, _) = make_backend(measure.backend, setting.method, measure.threads)?;
        backend.set_encoding(setting.encoding);
        backend.set_relocation(setting.variant != Variant::NoMovedTo);
        let order = setting.variant.slot_order();
        let options = StoreOptions { seed: measure.seed, insertion_points, order, ..Default::default() };
        let mut progressive = Progressive::new(backend, options);
        progressive.set_reprojection(setting.variant.reprojection());
        progressive.open(recording.facts.clone());
        Ok(Driver {
            progressive,
            variant: setting.variant,
            grid: recording.facts.grid,
            size: measure.size,
            point_size: setting.point_size,
            shading,
        })
    }

    fn request(&self, camera: &Camera, fill: FillBudget) -> Result<FrameRequest, CameraError> {
        let view = camera.view(&self.grid, self.size, self.point_size)?;
        Ok(FrameRequest { view, fill, shading: self.shading })
    }

    pub fn is_brute_force(&self) -> bool {
        self.variant == Variant::BruteForce
    }

    /// Draws the next frame.
    pub fn frame(&mut self, camera: &Camera, fill: FillBudget) -> Result<FrameReport, ConvergeError> {
        let request = self.request(camera, fill)?;
        Ok(match self.variant {
            Variant::BruteForce => self.progressive.brute_force(&request)?,
            _ => self.progressive.frame(&request)?,
        })
    }

    /// The picture of all points received so far; the frames know nothing of it.
    pub fn truth(&mut self, camera: &Camera) -> Result<Picture, ConvergeError> {
        let request = self.request(camera, FillBudget::Fixed(0))?;
        Ok(self.progressive.truth(&FrameRequest { shading: unlit(), ..request })?)
    }
}

/// How pictures are shaded that are compared: by the points' own colours. Eye-dome lighting is a function of depths,
/// whose error is stated by itself, and devices round its powers differently.
pub fn unlit() -> Shading {
    Shading { edl_strength: 0.0, ..Default::default() }
}
