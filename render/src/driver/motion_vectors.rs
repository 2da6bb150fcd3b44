//! Motion vectors: the movement of a pixel's visible point on the film from the opening of the shutter to its closing.
//!
//! The point of the surface that a ray hits is moved to both times, with its triangle and its instance, and projected
//! by the camera of each. Rays that miss use a point at infinity. Mirrors and glass have their own motion.

use glam::Vec2;
use halfdome_kernel::Ray;

use crate::camera::Camera;
use crate::settings::Settings;
use crate::world::{Hit, World};

/// As far away as the camera's own motion does not matter.
const FAR: f32 = 1e9;

/// The cameras where the shutter opens and closes.
pub(super) struct MotionVectors {
    cameras: [Camera; 2],
    height: u32,
}

impl MotionVectors {
    /// `None` if nothing moves.
    pub(super) fn new(world: &World, settings: &Settings, still: &Camera) -> Option<Self> {
        world.motion()?;
        let cameras = world.cameras_on(settings.width, settings.height);
        let at = |key: Option<&Camera>| key.unwrap_or(still).clone();
        Some(Self { cameras: [at(cameras.first()), at(cameras.last())], height: settings.height })
    }

    /// The motion in pixels, to the right and up, of the hit of a ray through the row `y`; zero where a camera does not
    /// see it.
    pub(super) fn at(&self, world: &World, y: u32, ray: &Ray, hit: &Hit) -> [f32; 2] {
        let place = |time: f32| match hit.is_hit() {
            true => world.surface_at(&Hit { time, ..*hit }).position,
            false => ray.origin + ray.direction * FAR,
        };
        let seen = |camera: &Camera, time: f32| -> Option<Vec2> {
            let view = (u64::from(y) * u64::from(camera.views()) / u64::from(self.height)) as u32;
            Some(camera.sight(place(time), view)?.film)
        };
        let [opening, closing] = &self.cameras;
        match (seen(opening, 0.0), seen(closing, 1.0)) {
            (Some(from), Some(to)) if closing.joins(from, to) => [to.x - from.x, from.y - to.y],
            _ => [0.0; 2],
        }
    }
}
