//! Small pictures that a page can hold inline.

use std::{fmt::Write, io};

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

    /// As a PNG.
    ///
    /// # Errors
    /// If writing fails, or the picture has no pixels.
    pub fn write_png(&self, out: &mut dyn io::Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.rgb.as_flattened())?;
        Ok(writer.finish()?)
    }

    /// As a PNG in a data URI.
    fn data_uri(&self) -> Option<String> {
        let mut bytes = Vec::new();
        self.write_png(&mut bytes).ok()?;
        Some(format!("data:image/png;base64,{}", base64(&bytes)))
    }

    /// About so wide: each pixel several times, or every so many pixels one, so that none is mixed with another.
    fn resized(&self, width: u32) -> Image {
        let [w, h] = self.size;
        let (times, step) = if w < width { (width / w.max(1), 1) } else { (1, w.div_ceil(width).max(1)) };
        let size = [w.div_ceil(step) * times, h.div_ceil(step) * times];
        let at = |x: u32, y: u32| self.rgb[((y / times * step) * w + x / times * step) as usize];
        let rgb = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| at(x, y))).collect();
        Image { size, rgb }
    }

    /// Puts a picture into this one; what does not fit is left out.
    fn paste(&mut self, other: &Image, [left, top]: [u32; 2]) {
        for (pixel, &color) in (0..).zip(&other.rgb) {
            let [x, y] = [pixel % other.size[0], pixel / other.size[0]];
            self.set([i64::from(left + x), i64::from(top + y)], color);
        }
    }
}

/// Width of a picture on a sheet, pixels, and the space between two.
const SHEET_CELL: u32 = 240;
const SHEET_GAP: u32 = 6;

/// A row for each strip: the method that fails, this program's, and the truth. `None` without strips.
pub fn sheet(strips: &[&Strip]) -> Option<Image> {
    let row = |strip: &&Strip| -> Vec<Image> {
        let images = &strip.images;
        // Further ones are other methods that fail, or hold.
        let shown = [0, images.len().saturating_sub(2), images.len().saturating_sub(1)];
        shown.iter().filter_map(|&n| images.get(n)).map(|(_, image)| image.resized(SHEET_CELL)).collect()
    };
    let rows: Vec<Vec<Image>> = strips.iter().map(row).collect();
    let heights = rows.iter().map(|row| row.iter().map(|image| image.size[1]).max().unwrap_or(0));
    let height: u32 = heights.clone().map(|height| height + SHEET_GAP).sum();
    if rows.is_empty() {
        return None;
    }
    let size = [3 * SHEET_CELL + 2 * SHEET_GAP, height - SHEET_GAP];
    let mut sheet = Image { size, rgb: vec![[255; 3]; (size[0] * size[1]) as usize] };
    let mut top = 0;
    for (row, height) in rows.iter().zip(heights) {
        for (image, column) in row.iter().zip(0..) {
            sheet.paste(image, [column * (SHEET_CELL + SHEET_GAP), top]);
        }
        top += height + SHEET_GAP;
    }
    Some(sheet)
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
    fn a_sheet_has_what_fails_what_holds_and_the_truth() {
        let image = |size: [u32; 2], grey: u8| Image { size, rgb: vec![[grey; 3]; (size[0] * size[1]) as usize] };
        let small = |grey| image([100, 50], grey);
        let strips = [
            Strip::new("", vec![("", small(1)), ("", small(2)), ("", small(3)), ("", small(4))]),
            Strip::new("", vec![("", image([480, 100], 5)), ("", image([480, 100], 6)), ("", image([480, 100], 7))]),
        ];
        let sheet = sheet(&strips.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!(sheet.size, [732, 100 + 6 + 50], "twice as large, and half as large");
        let at = |x: u32, y: u32| sheet.rgb[(y * 732 + x) as usize][0];
        assert_eq!([at(0, 0), at(199, 99), at(200, 0), at(0, 100)], [1, 1, 255, 255]);
        assert_eq!([at(246, 0), at(492, 0)], [3, 4], "the last but one holds");
        assert_eq!([at(0, 106), at(246, 106), at(731, 155)], [5, 6, 7]);
        assert_eq!(super::sheet(&[]), None);
        let mut png = Vec::new();
        sheet.write_png(&mut png).unwrap();
        assert!(png.starts_with(b"\x89PNG"));
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
