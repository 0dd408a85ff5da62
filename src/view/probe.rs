//! How far away is what the cursor is on? A few pixels' words come back from the GPU without waiting
//! for it: the answer is there a frame later.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use glam::{DVec2, DVec3};

use super::navigation::Navigation;

/// The nearest point within this many pixels counts as hit: between points one sees through.
const REACH: u32 = 4;
const SIDE: u32 = 2 * REACH + 1;
const ROW_BYTES: u64 = SIDE as u64 * 8;

/// Asks one thing at a time.
pub struct Probe {
    device: wgpu::Device,
    queue: wgpu::Queue,
    readback: wgpu::Buffer,
    asked: Option<Asked>,
}

struct Asked {
    navigation: Navigation,
    cursor: DVec2,
    /// Pixel of the first word, and how many columns and rows there are.
    corner: [u32; 2],
    extent: [u32; 2],
    mapped: Receiver<bool>,
}

impl Probe {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Probe {
        let readback = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("probe"),
            size: ROW_BYTES * u64::from(SIDE),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Probe { device: device.clone(), queue: queue.clone(), readback, asked: None }
    }

    /// Asks what is at the cursor in a picture's words; does nothing while an answer is on its way.
    pub fn ask(&mut self, words: &wgpu::Buffer, size: [u32; 2], cursor: DVec2, navigation: &Navigation) {
        let inside = |a: usize| cursor[a] >= 0.0 && cursor[a] < f64::from(size[a]);
        if self.asked.is_some() || !inside(0) || !inside(1) {
            return;
        }
        let corner: [u32; 2] = std::array::from_fn(|a| (cursor[a] as u32).saturating_sub(REACH));
        let extent: [u32; 2] = std::array::from_fn(|a| (cursor[a] as u32 + REACH + 1).min(size[a]) - corner[a]);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for row in 0..extent[1] {
            let from = u64::from(corner[1] + row) * u64::from(size[0]) + u64::from(corner[0]);
            let to = u64::from(row) * ROW_BYTES;
            encoder.copy_buffer_to_buffer(words, from * 8, &self.readback, to, u64::from(extent[0]) * 8);
        }
        self.queue.submit([encoder.finish()]);
        let (done, mapped) = channel();
        self.readback.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // Nobody listens once the window is closed.
            let _ = done.send(result.is_ok());
        });
        self.asked = Some(Asked { navigation: navigation.clone(), cursor, corner, extent, mapped });
    }

    /// The answer, once it is there: the point of the scene, or none where the background shows.
    pub fn answer(&mut self) -> Option<Option<DVec3>> {
        self.asked.as_ref()?;
        // A lost device is reported by the next frame.
        let _ = self.device.poll(wgpu::PollType::Poll);
        let asked = self.asked.take_if(|asked| asked.mapped.try_recv() != Err(TryRecvError::Empty))?;
        let Ok(range) = self.readback.slice(..).get_mapped_range() else { return Some(None) };
        let words: Vec<[u32; 2]> = bytemuck::cast_slice(&range).to_vec();
        drop(range);
        self.readback.unmap();
        Some(asked.nearest(&words).map(|depth| asked.navigation.grab(asked.cursor, Some(depth.into()))))
    }
}

impl Asked {
    /// Depth of the point closest to the cursor.
    fn nearest(&self, words: &[[u32; 2]]) -> Option<f32> {
        let pixels = (0..self.extent[1]).flat_map(|y| (0..self.extent[0]).map(move |x| [x, y]));
        let shown = pixels.filter_map(|[x, y]| {
            let [slot, depth] = *words.get((y * SIDE + x) as usize)?;
            let pixel = DVec2::new(f64::from(self.corner[0] + x) + 0.5, f64::from(self.corner[1] + y) + 0.5);
            (slot != u32::MAX).then(|| (pixel.distance_squared(self.cursor), f32::from_bits(depth)))
        });
        shown.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, depth)| depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, Grid};

    #[test]
    fn the_point_closest_to_the_cursor_counts() {
        let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
        let navigation = Navigation::new(grid, &Bounds { min: [0.0; 3], max: [10.0; 3] }, [640, 480]);
        let (_, mapped) = channel();
        let asked = Asked { navigation, cursor: DVec2::new(2.5, 1.5), corner: [0, 0], extent: [7, 6], mapped };
        let mut words = vec![[u32::MAX; 2]; (SIDE * SIDE) as usize];
        assert_eq!(asked.nearest(&words), None);
        words[(5 * SIDE) as usize] = [0, 7.0_f32.to_bits()];
        words[(2 * SIDE + 3) as usize] = [9, 5.0_f32.to_bits()];
        // Left over from a question before, outside of the picture.
        words[(SIDE + 8) as usize] = [9, 1.0_f32.to_bits()];
        assert_eq!(asked.nearest(&words), Some(5.0));
    }
}
