//! Equirectangular panoramas, of one eye or two.
//!
//! The azimuth runs from -180° at the left border over the view in the middle to 180°, to the right; the elevation from
//! 90° at the top to -90°. So a camera that looks along -z with +y up writes a valid sky picture.
//!
//! For two eyes (omni-directional stereo) rays start on a circle about the eye, of which they are tangents: wherever
//! the viewer looks horizontally, the eyes are beside each other. The left eye's picture is above the right one's.

use std::f64::consts::{PI, TAU};

use super::FilmPoint;

/// A film of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panorama {
    width: f64,
    /// The height of each eye's part.
    height: f64,
    /// Half the distance of the eyes; `None` for one eye.
    half_distance: Option<f64>,
}

/// Origin and direction in the view: right, up, forward.
pub(super) type Line = [[f64; 3]; 2];

impl Panorama {
    pub(super) fn new((width, height): (u32, u32), eye_distance: Option<f32>) -> Self {
        let views = if eye_distance.is_some() { 2.0 } else { 1.0 };
        let half_distance = eye_distance.map(|distance| 0.5 * f64::from(distance));
        Self { width: width.into(), height: f64::from(height) / views, half_distance }
    }

    pub(super) fn views(&self) -> u32 {
        if self.half_distance.is_some() { 2 } else { 1 }
    }

    /// Which eye a pixel belongs to, the left one being 0. Filters reach beyond a picture's border, but not into the
    /// other.
    fn view(&self, film: &FilmPoint) -> u32 {
        u32::from(self.half_distance.is_some() && f64::from(film.pixel.1) + 0.5 >= self.height)
    }

    /// The offset of an eye to the right.
    fn offset(&self, view: u32) -> f64 {
        self.half_distance.map_or(0.0, |half| if view == 0 { -half } else { half })
    }

    pub(super) fn line(&self, film: &FilmPoint) -> Line {
        let view = self.view(film);
        let azimuth = (f64::from(film.point.x) / self.width - 0.5) * TAU;
        let elevation = (0.5 - (f64::from(film.point.y) / self.height - f64::from(view))) * PI;
        let ((sin, cos), (up, across)) = (azimuth.sin_cos(), elevation.sin_cos());
        let offset = self.offset(view);
        [[offset * cos, 0.0, -offset * sin], [across * sin, up, across * cos]]
    }

    /// The origin of the ray with which an eye sees a point, and where on the film.
    pub(super) fn sight(&self, [right, up, forward]: [f64; 3], view: u32) -> Option<([f64; 3], [f64; 2])> {
        let (distance, offset) = (right.hypot(forward), self.offset(view));
        // A point within the circle of the eyes is on none of its tangents.
        if distance <= offset.abs() && offset != 0.0 || distance == 0.0 && up == 0.0 {
            return None;
        }
        let aside = if offset == 0.0 { 0.0 } else { (offset / distance).asin() };
        let azimuth = right.atan2(forward) - aside;
        let turns = azimuth / TAU + 0.5;
        let along = (distance * distance - offset * offset).max(0.0).sqrt();
        let elevation = up.atan2(along);
        let film = [(turns - turns.floor()) * self.width, (0.5 - elevation / PI + f64::from(view)) * self.height];
        let (sin, cos) = azimuth.sin_cos();
        Some(([offset * cos, 0.0, -offset * sin], film))
    }

    /// The angle that a pixel sees at the horizon. Towards the poles pixels see less across, which nothing is made of.
    pub(super) fn pixel_angle(&self) -> f32 {
        (TAU / self.width * PI / self.height).sqrt() as f32
    }

    /// Whether a line between two points of the film does not leave it in between.
    pub(super) fn joins(&self, a: [f32; 2], b: [f32; 2]) -> bool {
        f64::from((a[0] - b[0]).abs()) < 0.5 * self.width
    }
}
