//! The six faces of a cube side by side, in the order and the orientation of the cube maps' [`Face`].
//!
//! The cube's +x is the camera's right, +y its up, +z its view. So a camera that looks along -z with +y up has the
//! faces of a cube map with Bevy's axes.

use glam::DVec3;

use super::{Face, FilmPoint};

/// A strip of faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cube {
    /// Of a face, in pixels: in a picture of other than six squares they are no squares.
    width: f64,
    height: f64,
}

impl Cube {
    pub(super) fn new((width, height): (u32, u32)) -> Self {
        Self { width: f64::from(width) / Face::ALL.len() as f64, height: height.into() }
    }

    /// The index of the face that a pixel belongs to. Filters reach beyond a face's border, but not into the next face.
    fn face(&self, film: &FilmPoint) -> usize {
        ((f64::from(film.pixel.0) + 0.5) / self.width) as usize
    }

    /// The face's coordinates of a point, -1 to 1 on the face.
    fn coordinates(&self, film: &FilmPoint, face: usize) -> [f64; 2] {
        let across = f64::from(film.point.x) / self.width - face as f64;
        [2.0 * across - 1.0, 2.0 * f64::from(film.point.y) / self.height - 1.0]
    }

    /// The direction of a point of the film, of any length: right, up, forward.
    pub(super) fn direction(&self, film: &FilmPoint) -> [f64; 3] {
        let face = self.face(film).min(Face::ALL.len() - 1);
        let [u, v] = self.coordinates(film, face);
        Face::ALL[face].point(u, v).to_array()
    }

    /// The film point of a direction.
    pub(super) fn film(&self, direction: [f64; 3]) -> Option<[f64; 2]> {
        let direction = DVec3::from_array(direction);
        let face = Face::of(direction);
        let [u, v] = face.coordinates(direction)?;
        Some([(0.5 * (u + 1.0) + f64::from(face as u8)) * self.width, 0.5 * (v + 1.0) * self.height])
    }

    /// The angle that a pixel sees: the root of its solid angle.
    pub(super) fn pixel_angle(&self, film: &FilmPoint) -> f32 {
        let [u, v] = self.coordinates(film, self.face(film));
        let area = 4.0 / (self.width * self.height);
        (area * (1.0 + u * u + v * v).powf(-1.5)).sqrt() as f32
    }

    /// Whether two points of the film are on one face.
    pub(super) fn joins(&self, a: [f32; 2], b: [f32; 2]) -> bool {
        let face = |point: [f32; 2]| (f64::from(point[0]) / self.width) as u32;
        face(a) == face(b)
    }
}
