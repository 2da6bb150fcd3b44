//! Fisheyes: a disc whose radius stands for the angle from the view.

use glam::Vec2;

use crate::scene::FisheyeMapping;

/// A film with a disc in the middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fisheye {
    middle: Vec2,
    /// Pixels.
    radius: f64,
    mapping: FisheyeMapping,
    /// The greatest angle from the view.
    half_angle: f64,
}

impl Fisheye {
    pub(super) fn new((width, height): (u32, u32), mapping: FisheyeMapping, field_of_view: f32) -> Self {
        Self {
            middle: 0.5 * Vec2::new(width as f32, height as f32),
            radius: 0.5 * f64::from(width.min(height)),
            mapping,
            half_angle: 0.5 * f64::from(field_of_view).to_radians(),
        }
    }

    /// Whether a point of the film lies in the disc.
    pub(super) fn covers(&self, film: Vec2) -> bool {
        let from_middle = (film - self.middle).as_dvec2();
        from_middle.length_squared() <= self.radius * self.radius
    }

    /// The direction of a point of the disc: right, up, forward.
    pub(super) fn direction(&self, film: Vec2) -> [f64; 3] {
        let from_middle = (film - self.middle).as_dvec2();
        let distance = from_middle.length();
        let part = (distance / self.radius).min(1.0);
        let angle = match self.mapping {
            FisheyeMapping::Equidistant => part * self.half_angle,
            FisheyeMapping::Equisolid => 2.0 * (part * (0.5 * self.half_angle).sin()).asin(),
        };
        let (sin, cos) = angle.sin_cos();
        let across = if distance > 0.0 { from_middle * (sin / distance) } else { from_middle };
        [across.x, -across.y, cos]
    }

    /// The film point of a direction, if it is in the disc.
    pub(super) fn film(&self, [right, up, forward]: [f64; 3]) -> Option<[f64; 2]> {
        let sin = right.hypot(up);
        let angle = sin.atan2(forward);
        // Rounding must not lose the border.
        if angle > self.half_angle * (1.0 + 1e-6) || sin == 0.0 && forward == 0.0 {
            return None;
        }
        let part = match self.mapping {
            FisheyeMapping::Equidistant => angle / self.half_angle,
            FisheyeMapping::Equisolid => (0.5 * angle).sin() / (0.5 * self.half_angle).sin(),
        };
        let scale = if sin > 0.0 { part * self.radius / sin } else { 0.0 };
        Some([f64::from(self.middle.x) + right * scale, f64::from(self.middle.y) - up * scale])
    }

    /// The angle that a pixel in the middle sees.
    pub(super) fn pixel_angle(&self) -> f32 {
        let angle = match self.mapping {
            FisheyeMapping::Equidistant => self.half_angle,
            FisheyeMapping::Equisolid => 2.0 * (0.5 * self.half_angle).sin(),
        };
        (angle / self.radius) as f32
    }
}
