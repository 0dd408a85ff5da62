//! Small pictures that a page can hold inline.

use std::fmt::Write;

use crate::{measure::html::escape, methods::Drawn, render::Picture};

/// Red, green, blue per pixel, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    pub size: [u32; 2],
    pub rgb: Vec<[u8; 3]>,
}

/// Where no point is.
pub const BACKGROUND: [u8; 3] = [24, 28, 34];

impl Image {
    pub fn new(size: [u32; 2]) -> Image {
        Image { size, rgb: vec![BACKGROUND; size[0] as usize * size[1] as usize] }
    }

    pub fn of(picture: &Picture) -> Image {
        let rgb = picture.rgba.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Image { size: [picture.width, picture.height], rgb }
    }

    pub fn of_drawn(drawn: &Drawn) -> Image {
        let color = |&[r, g, b, a]: &[u8; 4]| if a == 0 { BACKGROUND } else { [r, g, b] };
        Image { size: drawn.size, rgb: drawn.rgba.iter().map(color).collect() }
    }

    /// Colours a pixel, if it is one of the picture's.
    pub fn set(&mut self, [x, y]: [i64; 2], color: [u8; 3]) {
        let [width, height] = self.size.map(i64::from);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            self.rgb[(y * width + x) as usize] = color;
        }
    }

    /// As a PNG in a data URI.
    fn data_uri(&self) -> Option<String> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().ok()?;
        writer.write_image_data(self.rgb.as_flattened()).ok()?;
        writer.finish().ok()?;
        Some(format!("data:image/png;base64,{}", base64(&bytes)))
    }
}

/// Pictures side by side: failing, holding, truth.
#[derive(Debug, Clone)]
pub struct Strip {
    pub title: String,
    /// Each with what it shows.
    pub images: Vec<(String, Image)>,
}

impl Strip {
    pub fn new(title: &str, images: Vec<(&str, Image)>) -> Strip {
        Strip { title: title.into(), images: images.into_iter().map(|(name, image)| (name.into(), image)).collect() }
    }

    /// As HTML; each pixel of a picture stays a square.
    pub fn html(&self) -> String {
        let mut out = format!("<h4>{}</h4>\n<div class=\"strip\">\n", escape(&self.title));
        for (name, image) in &self.images {
            let name = escape(name);
            let uri = image.data_uri().unwrap_or_default();
            // Some 320 pixels of the page wide, in whole multiples.
            let scale = (320 / image.size[0].max(1)).max(1);
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "<figure><img width=\"{}\" height=\"{}\" alt=\"{name}\" src=\"{uri}\"><figcaption>{name}</figcaption></figure>",
                image.size[0] * scale,
                image.size[1] * scale,
            );
        }
        out + "</div>\n"
    }
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let word = (0..3).fold(0_u32, |word, i| word << 8 | u32::from(group.get(i).copied().unwrap_or(0)));
        for digit in 0..4 {
            let is_there = digit <= group.len();
            let value = word >> (18 - 6 * digit) & 63;
            out.push(if is_there { char::from(DIGITS[value as usize]) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, encoded) in cases {
            assert_eq!(base64(plain.as_bytes()), encoded);
        }
        assert_eq!(base64(&[0xff, 0xef, 0xbe]), "/+++");
    }

    #[test]
    fn pixels_outside_are_left_out() {
        let mut image = Image::new([2, 2]);
        for at in [[-1, 0], [2, 0], [0, 2], [0, -1]] {
            image.set(at, [255; 3]);
        }
        assert_eq!(image, Image::new([2, 2]));
        image.set([1, 0], [255; 3]);
        assert_eq!(image.rgb[1], [255; 3]);
        let html = Strip::new("a < b", vec![("x", image)]).html();
        assert!(html.contains("a &lt; b") && html.contains("src=\"data:image/png;base64,iVBORw0KGgo"));
    }
}
