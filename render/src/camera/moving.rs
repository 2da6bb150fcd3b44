//! A camera that moves while the shutter is open.
//!
//! A ray lies between those that the camera sends through the same point of the film, and of the lens, at the two keys
//! of its time: origins, directions and clipping planes are interpolated, and directions are made unit vectors again.
//! So eyes move in straight lines, and views turn as quickly as chords do.

use glam::Vec3;
use halfdome_kernel::geometry::Moment;
use halfdome_kernel::{Isa, Ray};

use super::{Camera, FilmSample};

/// The camera at each key.
pub(crate) struct MovingCamera(Vec<Camera>);

impl MovingCamera {
    /// `None` without a key.
    pub(crate) fn new(cameras: Vec<Camera>) -> Option<Self> {
        (!cameras.is_empty()).then_some(Self(cameras))
    }

    /// Takes rays of samples to their moments, given by the number of each.
    pub(crate) fn rays(&self, isa: Isa, samples: &[FilmSample], moment: impl Fn(usize) -> Moment, rays: &mut [Ray]) {
        let at_keys: Vec<Vec<Ray>> = self.0.iter().map(|camera| camera_rays(camera, isa, samples)).collect();
        for (i, ray) in rays.iter_mut().enumerate() {
            let moment = moment(i);
            let [from, to] = [moment.key, (moment.key + 1).min(self.0.len() - 1)].map(|key| at_keys[key][i]);
            // One that is infinitely far away would give no number.
            let number = |from: f32, to: f32| match from == to {
                true => from,
                false => from * (1.0 - moment.fraction) + to * moment.fraction,
            };
            let direction = moment.vector(from.direction, to.direction);
            *ray = Ray {
                origin: moment.vector(from.origin, to.origin),
                t_min: number(from.t_min, to.t_min),
                direction: direction.try_normalize().unwrap_or(from.direction),
                t_max: number(from.t_max, to.t_max),
            };
        }
    }
}

fn camera_rays(camera: &Camera, isa: Isa, samples: &[FilmSample]) -> Vec<Ray> {
    let mut rays = vec![Ray::new(Vec3::ZERO, Vec3::ZERO); samples.len()];
    camera.rays(isa, samples, &mut rays);
    rays
}
