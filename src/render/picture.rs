//! The picture: pixels, text on them, PNG, contact sheets.

use crate::error::{Error, Result};

use super::font;
use super::palette::{BACKGROUND, INK, Rgb};

/// Pixels per dot of the font.
pub(super) const TEXT_SCALE: usize = 2;
/// Pixels between the cells of a sheet and around their captions.
const GAP: usize = 12;

/// An image of 8-bit sRGB colors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel, row by row from the top left: `3 * width * height` bytes.
    pub rgb: Vec<u8>,
    /// Opacity of each pixel, 0 to 255; `None`: all are opaque.
    pub alpha: Option<Vec<u8>>,
}

impl Picture {
    pub(super) fn new(width: usize, height: usize, color: Rgb) -> Self {
        Self { width, height, rgb: bytes_of(color).repeat(width * height), alpha: None }
    }

    /// A picture of one color, or a transparent one.
    pub(super) fn on(width: usize, height: usize, color: Option<Rgb>) -> Self {
        let alpha = if color.is_none() { Some(vec![0; width * height]) } else { None };
        Self { alpha, ..Self::new(width, height, color.unwrap_or([0.0; 3])) }
    }

    /// Red, green, blue and opacity of each pixel, row by row from the top left: `4 * width * height` bytes.
    pub fn rgba(&self) -> Vec<u8> {
        let opacity = |i: usize| self.alpha.as_ref().and_then(|a| a.get(i)).copied().unwrap_or(u8::MAX);
        let pixels = self.rgb.chunks_exact(3).enumerate();
        pixels.flat_map(|(i, c)| [c[0], c[1], c[2], opacity(i)]).collect()
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// [`Error::Failed`] when `rgb` does not hold `3 * width * height` bytes, `alpha` not `width * height`, or a side is 0.
    pub fn png_bytes(&self) -> Result<Vec<u8>> {
        let failed = |e: png::EncodingError| Error::Failed(format!("cannot encode the picture as PNG: {e}"));
        let side = |n: usize| u32::try_from(n).map_err(|_| Error::Failed(format!("{n} pixels are too many for PNG")));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side(self.width)?, side(self.height)?);
        let both = match &self.alpha {
            Some(alpha) if self.rgb.len() != 3 * alpha.len() => {
                return Err(Error::Failed("a picture needs an opacity for each of its pixels".into()));
            }
            Some(alpha) => {
                let pixels = self.rgb.chunks_exact(3).zip(alpha);
                Some(pixels.flat_map(|(c, a)| [c[0], c[1], c[2], *a]).collect::<Vec<u8>>())
            }
            None => None,
        };
        encoder.set_color(if both.is_some() { png::ColorType::Rgba } else { png::ColorType::Rgb });
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(both.as_ref().unwrap_or(&self.rgb)).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }

    /// Fills the rectangle, as far as it lies inside.
    pub(super) fn fill(&mut self, x: usize, y: usize, width: usize, height: usize, color: Rgb) {
        let color = bytes_of(color);
        for row in y..(y + height).min(self.height) {
            for column in x..(x + width).min(self.width) {
                let at = row * self.width + column;
                self.rgb[3 * at..3 * at + 3].copy_from_slice(&color);
                if let Some(alpha) = &mut self.alpha {
                    alpha[at] = u8::MAX;
                }
            }
        }
    }

    /// Writes a line of text with its top left corner at `(x, y)`; what the font lacks becomes `?`.
    pub(super) fn text(&mut self, x: usize, y: usize, text: &str, color: Rgb) {
        for (i, c) in text.chars().enumerate() {
            let left = x + i * font::ADVANCE * TEXT_SCALE;
            for (column, row) in font::dots(c) {
                self.fill(left + column * TEXT_SCALE, y + row * TEXT_SCALE, TEXT_SCALE, TEXT_SCALE, color);
            }
        }
    }

    fn paste(&mut self, other: &Picture, x: usize, y: usize) {
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let n = 3 * other.width.min(self.width.saturating_sub(x));
            let (to, from) = (3 * ((y + row) * self.width + x), 3 * row * other.width);
            self.rgb[to..to + n].copy_from_slice(&other.rgb[from..from + n]);
        }
    }
}

/// Width of a text in pixels.
pub(super) fn text_width(text: &str) -> usize {
    text.chars().count() * font::ADVANCE * TEXT_SCALE
}

/// The text shortened to at most `chars` characters, with an ellipsis in its middle where some are missing: names of
/// faces often begin alike.
pub(super) fn shortened(text: &str, chars: usize) -> String {
    let long = text.chars().count();
    if long <= chars {
        return text.to_owned();
    }
    let Some(shown) = chars.checked_sub(1) else { return String::new() };
    let tail = shown / 2;
    text.chars().take(shown - tail).chain(['…']).chain(text.chars().skip(long - tail)).collect()
}

/// Height of a line of text in pixels, descenders included.
pub(super) const TEXT_HEIGHT: usize = font::HEIGHT * TEXT_SCALE;

fn bytes_of(color: Rgb) -> [u8; 3] {
    color.map(|c| (c * 255.0).round().clamp(0.0, 255.0) as u8)
}

/// A contact sheet: the pictures in rows of `columns` (at least one), each with its caption below.
///
/// Cells are as large as the largest picture; captions too long for a cell are shortened. No cells give an image of one
/// pixel.
pub fn sheet(cells: &[(String, Picture)], columns: usize) -> Picture {
    let columns = columns.clamp(1, cells.len().max(1));
    let rows = cells.len().div_ceil(columns);
    let width = cells.iter().map(|c| c.1.width).max().unwrap_or(0);
    let height = cells.iter().map(|c| c.1.height).max().unwrap_or(0);
    if rows == 0 {
        return Picture::new(1, 1, BACKGROUND);
    }
    let (step_x, step_y) = (width + GAP, height + GAP + TEXT_HEIGHT + GAP);
    let mut picture = Picture::new(columns * step_x + GAP, rows * step_y + GAP, [1.0; 3]);
    for (i, (caption, cell)) in cells.iter().enumerate() {
        let (x, y) = (GAP + i % columns * step_x, GAP + i / columns * step_y);
        picture.fill(x, y, width, height, BACKGROUND);
        picture.paste(cell, x + (width - cell.width) / 2, y + (height - cell.height) / 2);
        let caption = shortened(caption, width / (font::ADVANCE * TEXT_SCALE));
        let indent = width.saturating_sub(text_width(&caption)) / 2;
        picture.text(x + indent, y + height + GAP / 2, &caption, INK);
    }
    picture
}
