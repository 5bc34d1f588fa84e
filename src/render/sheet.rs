//! Several pictures with captions on one sheet.

use super::font::{text, text_width};
use super::picture::Picture;

/// Height of the captions' letters, pixels.
const LETTER: f64 = 18.0;

/// Space around a caption, pixels.
const MARGIN: f64 = 10.0;

/// Puts pictures, each below its caption, into rows of `columns`. An empty list gives one white pixel.
pub fn sheet(cells: &[(String, Picture)], columns: usize) -> Picture {
    let columns = columns.clamp(1, cells.len().max(1));
    let width = cells.iter().map(|c| c.1.width).max().unwrap_or(1);
    let caption = (LETTER + 2.0 * MARGIN) as u32;
    let height = cells.iter().map(|c| c.1.height + caption).max().unwrap_or(1);
    let rows = cells.len().div_ceil(columns).max(1);
    let mut out = Picture::filled(width * columns as u32, height * rows as u32, [255; 3]);
    for (i, (name, picture)) in cells.iter().enumerate() {
        let (x, y) = ((i % columns) as u32 * width, (i / columns) as u32 * height);
        out.paste(picture, x, y + caption);
        let shrink = ((f64::from(width) - 2.0 * MARGIN) / text_width(name, LETTER)).min(1.0);
        text(&mut out, name, f64::from(x) + MARGIN, f64::from(y) + MARGIN, LETTER * shrink, [30, 34, 42]);
    }
    out
}
