//! A camera in the numbers that the kernels need, and what they make of a position.

/// `x.floor() as i32` for numbers of moderate size; without SSE4.1 that is a call of a library.
fn floor(x: f32) -> i32 {
    let toward_zero = x as i32;
    toward_zero - i32::from(toward_zero as f32 > x)
}

/// A camera in numbers for the kernels. Layout shared with `shaders/project.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct View {
    /// Clip-space x per grid step, in perspective times depth; the fourth number is 0 in perspective, else the depth
    /// of the position that others are taken from, which is above 0.
    pub row_x: [f32; 4],
    /// Clip-space y (down) per grid step, in perspective times depth. The fourth number in perspective: 0 if points
    /// are `point_size` pixels wide, else the pixels of a point at a depth of 1. Else: the depth at which a perspective
    /// picture of 60° would be as high.
    pub row_y: [f32; 4],
    /// Depth, in the file's unit, per grid step; the fourth number is a power of two that takes every
    /// depth below one (for the depth texture of the hardware rasterizer).
    pub row_w: [f32; 4],
    /// The whole grid position that others are taken from is `eye_high * 65536 + eye_low`: the eye's, or without
    /// perspective the target's.
    pub eye_high: [i32; 3],
    pub width: u32,
    pub eye_low: [i32; 3],
    pub height: u32,
    /// Rest of that position, in grid steps, from 0 to 1.
    pub eye_fraction: [f32; 3],
    /// Width of a point, pixels; the largest where points differ.
    pub point_size: u32,
}

/// Where a point falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Column and row of the upper left pixel of the point's square; may be outside of the picture
    /// by up to `size - 1`.
    pub corner: [i32; 2],
    /// Distance along the viewing direction, in the file's unit.
    pub depth: f32,
    /// Width of the square, pixels.
    pub size: u32,
}

impl View {
    /// Whether both are of pictures of the same width and height.
    pub fn has_size_of(&self, other: &View) -> bool {
        (self.width, self.height) == (other.width, other.height)
    }

    /// Whether every position in this box is less than 2³¹ grid steps from the eye on each axis. Kernels made for
    /// that subtract the eye's position once instead of in halves; no bit of a picture changes.
    pub fn is_near(&self, low: [i32; 3], high: [i32; 3]) -> bool {
        let fits = |a: usize| {
            let eye = (i64::from(self.eye_high[a]) << 16) + i64::from(self.eye_low[a]);
            let differences = [i64::from(low[a]) - eye, i64::from(high[a]) - eye, eye];
            differences.iter().all(|&steps| i32::try_from(steps).is_ok())
        };
        (0..3).all(fits)
    }

    /// Twin of `project` in `shaders/project.wgsl`: `None` behind the eye or outside of the picture.
    pub fn project(&self, position: [i32; 3]) -> Option<Projected> {
        // The upper and lower 16 bits are subtracted as integers, so that no difference overflows,
        // however far the eye is, and the only rounding is that of the sum.
        let d: [f32; 3] = std::array::from_fn(|a| {
            let high = ((position[a] >> 16) - self.eye_high[a]) as f32;
            let low = ((position[a] & 0xffff) - self.eye_low[a]) as f32;
            (high * 65536.0 + low) - self.eye_fraction[a]
        });
        let dot = |row: &[f32; 4]| (row[0] * d[0] + row[1] * d[1]) + row[2] * d[2];
        let depth = dot(&self.row_w) + self.row_x[3];
        // Not a number is no place either.
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let divisor = if self.is_orthographic() { 1.0 } else { depth };
        let size = self.point_size_at(depth);
        let half = 0.5 * (size - 1) as f32;
        let x = (dot(&self.row_x) / divisor * 0.5 + 0.5) * self.width as f32 - half;
        let y = (dot(&self.row_y) / divisor * 0.5 + 0.5) * self.height as f32 - half;
        let edge = -(size as f32) + 1.0;
        if !(x >= edge && x < self.width as f32 && y >= edge && y < self.height as f32) {
            return None;
        }
        Some(Projected { corner: [floor(x), floor(y)], depth, size })
    }

    /// Whether everything looks as large wherever it is.
    pub fn is_orthographic(&self) -> bool {
        self.row_x[3] > 0.0
    }

    /// Whether nearer points are drawn larger.
    pub fn has_sizes(&self) -> bool {
        self.row_y[3] > 0.0 && !self.is_orthographic()
    }

    /// Width of a point at a depth, pixels. Twin of `point_size_at` in `shaders/project.wgsl`.
    pub fn point_size_at(&self, depth: f32) -> u32 {
        if self.has_sizes() {
            (self.row_y[3] / depth + 0.5).clamp(1.0, self.point_size as f32) as u32
        } else {
            self.point_size
        }
    }

    /// How many times as far as `front` something at `depth` counts as: without perspective, as if `front` were where a
    /// picture of 60° is as high. Twin of `times_as_far` in `shaders/project.wgsl`.
    pub fn times_as_far(&self, depth: f32, front: f32) -> f32 {
        if self.is_orthographic() { 1.0 + (depth - front) / self.row_y[3] } else { depth / front }
    }

    /// The depth that counts as `times` as far as `front`. Twin of `far_as` in `shaders/project.wgsl`.
    pub fn far_as(&self, front: f32, times: f32) -> f32 {
        if self.is_orthographic() { front + self.row_y[3] * (times - 1.0) } else { front * times }
    }
}
