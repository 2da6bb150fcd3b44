//! A cube map as one picture: its levels as vertical crosses, unfolded so that neighbours touch.
//!
//! With four rows and three columns of faces, a cross of faces of `n` texels is `3n` wide and `4n` high:
//!
//! ```text
//!      +y
//!  -x  +z  +x
//!      -y
//!      -z      upside down: its rows run upwards
//! ```
//!
//! The first level's cross stands on the left. On its right stand those of all others, each below the one before, which
//! together are as high. The area between them is black.
//!
//! A second picture shows all crosses at equal size side by side, each pixel by a bilinear filter within one face, so
//! that seams are visible.

use glam::Vec3;

use super::face::Face;
use super::level::Level;
use crate::film::{Channel, Metadata, Picture};

/// The position of a face in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Its left column and top row.
    pub corner: [u32; 2],
    /// Whether it is turned by half a turn.
    pub turned: bool,
}

/// Width and height of the picture of levels whose first has faces of `size` texels.
pub fn extent(size: u32, levels: usize) -> [u32; 2] {
    // The second cross is half as wide.
    [3 * size + if levels > 1 { 3 * (size / 2) } else { 0 }, 4 * size]
}

/// The position of a level's face.
pub fn place(size: u32, level: u32, face: Face) -> Place {
    let side = size >> level;
    let left = if level == 0 { 0 } else { 3 * size };
    let top: u32 = (1..level).map(|level| 4 * (size >> level)).sum();
    let [column, row] = match face {
        Face::PositiveY => [1, 0],
        Face::NegativeX => [0, 1],
        Face::PositiveZ => [1, 1],
        Face::PositiveX => [2, 1],
        Face::NegativeY => [1, 2],
        Face::NegativeZ => [1, 3],
    };
    Place { corner: [left + column * side, top + row * side], turned: face == Face::NegativeZ }
}

/// The picture of all texels.
pub fn unfold(levels: &[Level]) -> Picture {
    let size = levels.first().map_or(1, |level| level.grid.size);
    let mut canvas = Canvas::new(extent(size, levels.len()));
    for (number, level) in (0..).zip(levels) {
        let side = level.grid.size;
        for face in Face::ALL {
            let texels = level.face(face);
            canvas.draw(place(size, number, face), side, |x, y| texels[(y * side + x) as usize]);
        }
    }
    canvas.picture()
}

/// The picture of what lookups show, with faces of at most [`SHOWN`] pixels.
pub fn show(levels: &[Level]) -> Picture {
    let side = levels.first().map_or(1, |level| level.grid.size).min(SHOWN);
    let mut canvas = Canvas::new([3 * side * levels.len() as u32, 4 * side]);
    let coordinate = |pixel: u32| (2.0 * f64::from(pixel) + 1.0) / f64::from(side) - 1.0;
    for (number, level) in (0..).zip(levels) {
        for face in Face::ALL {
            let mut place = place(side, 0, face);
            place.corner[0] += 3 * side * number;
            let shown = |x, y| level.sample(face, face.point(coordinate(x), coordinate(y))).unwrap_or_default();
            canvas.draw(place, side, |x, y| shown(x, y).as_vec3());
        }
    }
    canvas.picture()
}

/// Pixels across a face of the picture to look at.
pub const SHOWN: u32 = 128;

/// A picture that is being drawn.
struct Canvas {
    extent: [u32; 2],
    pixels: Vec<Vec3>,
}

impl Canvas {
    fn new(extent: [u32; 2]) -> Self {
        Self { extent, pixels: vec![Vec3::ZERO; extent[0] as usize * extent[1] as usize] }
    }

    /// Draws a face of `side` pixels.
    fn draw(&mut self, Place { corner: [left, top], turned }: Place, side: u32, color: impl Fn(u32, u32) -> Vec3) {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let (right, down) = if turned { (side - 1 - x, side - 1 - y) } else { (x, y) };
            self.pixels[((top + down) * self.extent[0] + left + right) as usize] = color(x, y);
        }
    }

    fn picture(self) -> Picture {
        let channel = |(i, name): (usize, &str)| Channel {
            name: name.to_owned(),
            values: self.pixels.iter().map(|pixel| pixel[i]).collect(),
        };
        let channels = ["R", "G", "B"].into_iter().enumerate().map(channel).collect();
        let metadata = Metadata { integrator: "cubemap".to_owned(), ..Metadata::default() };
        Picture { width: self.extent[0], height: self.extent[1], channels, metadata }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::grid::{Seams, TexelGrid};
    use super::*;

    /// Each texel has its direction for a colour: neighbours in a cross differ little, across borders of faces too.
    #[test]
    fn neighbours_on_the_sphere_are_neighbours_in_the_cross() {
        let level = |size: u32| {
            let grid = TexelGrid { size, seams: Seams::None };
            let direction = |(face, x, y)| grid.point(face, x, y).normalize().as_vec3() + 2.0;
            Level { grid, lobe: None, texels: grid.places().map(direction).collect() }
        };
        let picture = unfold(&[level(16), level(8), level(4)]);
        assert_eq!((picture.width, picture.height), (72, 64));
        let pixel = |x: u32, y: u32| {
            let at = (y * picture.width + x) as usize;
            DVec3::from_array([0, 1, 2].map(|i| f64::from(picture.channels[i].values[at])))
        };
        let filled = (0..64).flat_map(|y| (0..72).map(move |x| (x, y))).filter(|&(x, y)| pixel(x, y) != DVec3::ZERO);
        assert_eq!(filled.count(), 6 * (256 + 64 + 16));
        for y in 0..63 {
            let step = pixel(24, y).distance(pixel(24, y + 1));
            assert!(step < 0.13, "row {y}: {step}");
        }
        for x in 0..47 {
            assert!(pixel(x, 24).distance(pixel(x + 1, 24)) < 0.13, "column {x}");
        }
        // In the picture to look at, the first level has its texels and the others as many pixels.
        let shown = show(&[level(16), level(8), level(4)]);
        assert_eq!((shown.width, shown.height), (3 * 48, 64));
        let red = |picture: &Picture, x: u32, y: u32| picture.channels[0].values[(y * picture.width + x) as usize];
        for (x, y) in [(20, 3), (40, 20), (3, 30), (17, 60)] {
            assert_eq!(red(&shown, x, y), red(&picture, x, y), "{x} {y}");
            assert!((red(&shown, 48 + x, y) - red(&picture, x, y)).abs() < 0.1, "{x} {y}");
        }
        // The middle of +z of the third level.
        let middle = place(16, 2, Face::PositiveZ).corner;
        assert_eq!(middle, [52, 36]);
        assert!(pixel(middle[0] + 2, middle[1] + 2).distance(DVec3::new(2.0, 2.0, 3.0)) < 0.5);
    }
}
