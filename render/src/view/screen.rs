//! Draws the picture and the text beside it into one pixel buffer.
//!
//! The picture fills its part of the window as far as its shape allows: by the nearest pixel where it is enlarged, so
//! that the renderer's pixels are visible, and by the mean of all covered pixels where it is reduced.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::{COLUMNS, Line, Style};

/// Pixels around text.
const MARGIN: usize = 14;
/// The distance between lines.
const ROW: usize = 18;
const BACKGROUND: [u8; 3] = [24; 3];
const PANEL: [u8; 3] = [34, 36, 40];

/// A window's pixels, row by row from the top.
pub struct Screen {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// The position of the picture in a window.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    left: f64,
    top: f64,
    /// Pixels of the window for one of the picture.
    scale: f64,
}

/// The width of the text in pixels.
pub fn panel_width() -> usize {
    2 * MARGIN + COLUMNS * get_raster_width(FontWeight::Regular, RasterHeight::Size16)
}

impl Screen {
    /// An empty one of this size.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![BACKGROUND; width * height] }
    }

    /// Its pixels, sRGB codes.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The width of the picture left of the text, if the text is shown.
    pub fn picture_width(width: usize, has_panel: bool) -> usize {
        if has_panel { width.saturating_sub(panel_width()) } else { width }
    }

    /// How many lines of text there is room for.
    pub fn rows(height: usize) -> usize {
        height.saturating_sub(2 * MARGIN) / ROW
    }

    /// The pixel of a picture of this size that is at a place of the window; `None` beside it.
    pub fn pixel_at(window: (usize, usize), has_panel: bool, size: (u32, u32), at: (f64, f64)) -> Option<(u32, u32)> {
        let Place { left, top, scale } = place((Self::picture_width(window.0, has_panel), window.1), size)?;
        let (x, y) = ((at.0 - left) / scale, (at.1 - top) / scale);
        let is_inside = x >= 0.0 && y >= 0.0 && x < f64::from(size.0) && y < f64::from(size.1);
        is_inside.then_some((x as u32, y as u32))
    }

    /// Draws a picture of these codes, as wide as said, left of the text if that is shown.
    pub fn draw_picture(&mut self, codes: &[[u8; 3]], width: u32, has_panel: bool) {
        let size = (width, codes.len() as u32 / width.max(1));
        let part = (Self::picture_width(self.width, has_panel), self.height);
        let Some(Place { left, top, scale }) = place(part, size) else { return };
        let (columns, rows) = (part.0, self.height);
        // The pixels of the picture that a pixel of the window shows, along one axis.
        let span = |pixel: usize, start: f64, end: u32| {
            let from = (pixel as f64 - start) / scale;
            let to = (pixel as f64 + 1.0 - start) / scale;
            let middle = 0.5 * (from + to);
            if middle < 0.0 || middle >= f64::from(end) {
                return None;
            }
            if scale >= 1.0 {
                return Some(middle as usize..middle as usize + 1);
            }
            let first = from.round().max(0.0) as usize;
            Some(first..(to.round() as usize).clamp(first + 1, end as usize).max(first + 1))
        };
        let across: Vec<_> = (0..columns).map(|x| span(x, left, size.0)).collect();
        for y in 0..rows {
            let Some(down) = span(y, top, size.1) else { continue };
            for (x, across) in across.iter().enumerate() {
                let Some(across) = across else { continue };
                let mut sum = [0_u32; 3];
                for row in down.clone() {
                    for code in &codes[row * width as usize..][across.clone()] {
                        sum = std::array::from_fn(|c| sum[c] + u32::from(code[c]));
                    }
                }
                let count = (down.len() * across.len()) as u32;
                self.pixels[y * self.width + x] = sum.map(|sum| ((sum + count / 2) / count) as u8);
            }
        }
    }

    /// Frames a pixel of a picture of this size.
    pub fn mark(&mut self, (x, y): (u32, u32), size: (u32, u32), has_panel: bool) {
        let part = (Self::picture_width(self.width, has_panel), self.height);
        let Some(Place { left, top, scale }) = place(part, size) else { return };
        let corner = |pixel: u32, start: f64| (start + f64::from(pixel) * scale).floor() as isize;
        let side = scale.ceil().max(1.0) as isize;
        let (left, top) = (corner(x, left), corner(y, top));
        // A dark square around a light one is seen on everything.
        for (distance, color) in [(3, [255; 3]), (4, [0; 3])] {
            let (low, high) = (-distance, side - 1 + distance);
            for i in low..=high {
                for (dx, dy) in [(i, low), (i, high), (low, i), (high, i)] {
                    let (column, row) = (left + dx, top + dy);
                    let is_inside = (0..part.0 as isize).contains(&column) && (0..part.1 as isize).contains(&row);
                    if is_inside {
                        self.pixels[row as usize * self.width + column as usize] = color;
                    }
                }
            }
        }
    }

    /// Draws the text at the right.
    pub fn draw_panel(&mut self, lines: &[Line]) {
        let left = Self::picture_width(self.width, true);
        for row in self.pixels.chunks_mut(self.width.max(1)) {
            row[left..].fill(PANEL);
        }
        for (number, line) in lines.iter().enumerate() {
            let (color, weight) = match line.style {
                Style::Heading => ([255, 255, 255], FontWeight::Bold),
                Style::Text => ([216, 218, 222], FontWeight::Regular),
                Style::Faint => ([158, 164, 172], FontWeight::Regular),
                Style::Chosen => ([255, 200, 90], FontWeight::Bold),
            };
            self.print((left + MARGIN, MARGIN + number * ROW), &line.text, color, weight);
        }
    }

    fn print(&mut self, (left, top): (usize, usize), text: &str, color: [u8; 3], weight: FontWeight) {
        let advance = get_raster_width(weight, RasterHeight::Size16);
        for (number, letter) in text.chars().enumerate() {
            let raster = get_raster(letter, weight, RasterHeight::Size16)
                .or_else(|| get_raster('\u{fffd}', weight, RasterHeight::Size16));
            let Some(raster) = raster else { continue };
            for (y, row) in raster.raster().iter().enumerate() {
                for (x, &part) in row.iter().enumerate() {
                    let (column, line) = (left + number * advance + x, top + y);
                    if column < self.width && line < self.height {
                        let below = &mut self.pixels[line * self.width + column];
                        let part = u32::from(part);
                        let mix = |c: usize| (u32::from(color[c]) * part + u32::from(below[c]) * (255 - part)) / 255;
                        *below = [mix(0) as u8, mix(1) as u8, mix(2) as u8];
                    }
                }
            }
        }
    }
}

/// Where a picture of this size is in a part of the window; `None` if there is no room.
fn place((width, height): (usize, usize), size: (u32, u32)) -> Option<Place> {
    let (across, down) = (f64::from(size.0), f64::from(size.1));
    let fit = (width as f64 / across).min(height as f64 / down);
    // Whole factors keep pixels square.
    let scale = if fit >= 1.0 { fit.floor() } else { fit };
    let middle = |room: usize, side: f64| (0.5 * (room as f64 - side * scale)).floor();
    let is_seen = width > 0 && height > 0 && scale > 0.0 && scale.is_finite();
    is_seen.then(|| Place { left: middle(width, across), top: middle(height, down), scale })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [u8; 3] = [255, 0, 0];
    const BLUE: [u8; 3] = [0, 0, 255];

    #[test]
    fn pictures_are_enlarged_by_whole_factors() {
        let mut screen = Screen::new(10, 7);
        screen.draw_picture(&[RED, BLUE], 2, false);
        // Twice two pixels fit five times: 10 by 5, one row from the top.
        assert_eq!(screen.pixels()[0], BACKGROUND);
        assert!(screen.pixels()[10..15].iter().all(|&pixel| pixel == RED));
        assert!(screen.pixels()[55..60].iter().all(|&pixel| pixel == BLUE));
        assert_eq!(screen.pixels()[60], BACKGROUND);
        assert_eq!(Screen::pixel_at((10, 7), false, (2, 1), (4.9, 1.0)), Some((0, 0)));
        assert_eq!(Screen::pixel_at((10, 7), false, (2, 1), (5.0, 5.9)), Some((1, 0)));
        assert_eq!(Screen::pixel_at((10, 7), false, (2, 1), (5.0, 6.0)), None);
    }

    #[test]
    fn pictures_are_made_smaller_by_means() {
        let mut screen = Screen::new(2, 1);
        screen.draw_picture(&[RED, BLUE, BLUE, BLUE, BLUE, RED, BLUE, BLUE], 4, false);
        assert_eq!(screen.pixels(), [[128, 0, 128], BLUE]);
        let mut narrow = Screen::new(3, 3);
        narrow.draw_picture(&vec![RED; 70 * 70], 70, false);
        assert!(narrow.pixels().iter().all(|&pixel| pixel == RED));
    }

    #[test]
    fn text_is_beside_the_picture() {
        let width = panel_width() + 40;
        let mut screen = Screen::new(width, 60);
        screen.draw_picture(&[RED], 1, true);
        let line = Line { text: "Ä \u{4e00}".to_owned(), style: Style::Heading };
        screen.draw_panel(&[line]);
        let is_lit = |x: usize| (0..60).any(|y| screen.pixels()[y * width + x] == [255; 3]);
        assert!((40..width).any(is_lit) && !(0..40).any(is_lit));
        assert_eq!(screen.pixels()[20 * width + 20], RED);
        assert_eq!(screen.pixels()[width - 1], PANEL);
        // Without room for both nothing breaks.
        let mut tiny = Screen::new(5, 5);
        tiny.draw_picture(&[RED], 1, true);
        tiny.draw_panel(&[]);
        tiny.mark((0, 0), (1, 1), true);
    }
}
