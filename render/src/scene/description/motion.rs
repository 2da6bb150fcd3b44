//! Motion while the shutter is open.
//!
//! Motion is given at keys, evenly spaced from the opening of the shutter (time 0) to its closing (1), and is linear
//! between them: vertices, elements of transforms, the points of cameras and lights. The scene itself is that of the
//! middle key. A [`Scene`] has a `Motion` if anything moves; static elements are in none of the tables here, and cost
//! nothing.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use halfdome_kernel::geometry::Moment as Place;

use crate::scene::{CameraPose, PunctualLight};

/// Positions at the keys of the shutter's time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The number of keys: odd, and at least 3.
    pub keys: usize,
    /// The part of the time in which the shutter opens, and in which it closes: 0, all at once, to 0.5.
    pub ramp: f32,
    /// The positions of each mesh that moves, by its index: as many at each key as it has.
    pub meshes: BTreeMap<usize, Vec<Vec<Vec3>>>,
    /// The transforms of each instance that moves, by its index.
    pub instances: BTreeMap<usize, Arc<[Affine3A]>>,
    /// Each light that moves, by its index: of these alone place and direction count.
    pub lights: BTreeMap<usize, Vec<PunctualLight>>,
    /// The camera's poses, empty if it is static.
    pub cameras: Vec<CameraPose>,
}

/// When the shutter is open, in frames after the frame that is shown, or in seconds after its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// When it opens.
    pub open: f64,
    /// When it is closed, later.
    pub close: f64,
    /// Whether these are seconds.
    pub in_seconds: bool,
}

impl Shutter {
    /// The greatest number of keys.
    pub const MAX_KEYS: usize = 129;
    /// The default number of keys: a quarter of a turn deviates from a circle by half a percent of its radius.
    pub const DEFAULT_KEYS: usize = 5;

    /// The seconds after the frame's time at each of `keys` keys.
    pub(crate) fn times(&self, keys: usize, fps: f64) -> impl Iterator<Item = f64> + use<> {
        let unit = if self.in_seconds { 1.0 } else { fps.recip() };
        let (open, length) = (self.open * unit, (self.close - self.open) * unit);
        (0..keys).map(move |key| open + length * key as f64 / (keys - 1) as f64)
    }
}

impl Motion {
    /// The time at which `u` in [0, 1) of the light has come through the shutter. It opens and closes at an even rate.
    ///
    /// With `r` for the ramp the openness rises to 1 from 0 to `r`, and the light that has come through by the time `t`
    /// is `t² / 2r` there, then `t - r/2`, all over `1 - r`.
    pub(crate) fn time(&self, u: f32) -> f32 {
        let ramp = self.ramp;
        let rising = |light: f32| match light < 0.5 * ramp {
            true => (2.0 * ramp * light).sqrt(),
            false => light + 0.5 * ramp,
        };
        let light = u * (1.0 - ramp);
        let half = 0.5 * (1.0 - ramp);
        if light <= half { rising(light) } else { 1.0 - rising(1.0 - ramp - light) }
    }

    /// Whether nothing moves.
    pub(crate) fn is_still(&self) -> bool {
        let Self { meshes, instances, lights, cameras, .. } = self;
        meshes.is_empty() && instances.is_empty() && lights.is_empty() && cameras.is_empty()
    }
}

impl PunctualLight {
    /// The position, the greatest intensity, and the radius; `None` if it is infinitely far away.
    pub(crate) fn place(&self) -> Option<(Vec3, Vec3, f32)> {
        match self {
            Self::Point { position, intensity, radius } | Self::Spot { position, intensity, radius, .. } => {
                Some((*position, *intensity, *radius))
            }
            Self::Profiled { position, intensity, radius, profile, .. } => {
                Some((*position, *intensity * profile.greatest(), *radius))
            }
            Self::Directional { .. } => None,
        }
    }

    /// Whether it is no delta light.
    pub(crate) fn has_size(&self) -> bool {
        match self {
            Self::Directional { half_angle, .. } => *half_angle > 0.0,
            Self::Point { radius, .. } | Self::Spot { radius, .. } | Self::Profiled { radius, .. } => *radius > 0.0,
        }
    }

    /// The light where it is between two of its keys.
    pub(crate) fn between(&self, place: Place, from: &Self, to: &Self) -> Self {
        let turned = |from: Vec3, to: Vec3| place.vector(from, to).try_normalize().unwrap_or(from);
        let mut moved = self.clone();
        match (&mut moved, from, to) {
            (Self::Point { position, .. }, Self::Point { position: a, .. }, Self::Point { position: b, .. }) => {
                *position = place.vector(*a, *b);
            }
            (
                Self::Spot { position, direction, .. },
                Self::Spot { position: a, direction: along, .. },
                Self::Spot { position: b, direction: to, .. },
            ) => {
                *position = place.vector(*a, *b);
                *direction = turned(*along, *to);
            }
            (
                Self::Profiled { position, frame, .. },
                Self::Profiled { position: a, frame: turn, .. },
                Self::Profiled { position: b, .. },
            ) => {
                *position = place.vector(*a, *b);
                *frame = *turn;
            }
            (
                Self::Directional { direction, .. },
                Self::Directional { direction: along, .. },
                Self::Directional { direction: to, .. },
            ) => *direction = turned(*along, *to),
            // A light that becomes one of another kind stays what it is in the middle.
            _ => {}
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_follow_the_shutter() {
        let shutter = Shutter { open: -0.25, close: 0.25, in_seconds: false };
        let times: Vec<f64> = shutter.times(3, 25.0).collect();
        assert_eq!(times, [-0.01, 0.0, 0.01]);
        let shutter = Shutter { open: 0.0, close: 0.5, in_seconds: true };
        assert_eq!(shutter.times(5, 25.0).last(), Some(0.5));

        let box_shaped = Motion::default();
        assert_eq!([0.0, 0.25, 0.5, 0.75].map(|u| box_shaped.time(u)), [0.0, 0.25, 0.5, 0.75]);
        for ramp in [0.1_f32, 0.25, 0.5] {
            let motion = Motion { ramp, ..Motion::default() };
            let light = |t: f64| {
                let r = f64::from(ramp);
                let rising = |t: f64| if t < r { t * t / (2.0 * r) } else { t - 0.5 * r };
                (if t < 0.5 { rising(t) } else { 1.0 - r - rising(1.0 - t) }) / (1.0 - r)
            };
            for u in (0..1000).map(|i| i as f32 / 1000.0) {
                let time = motion.time(u);
                assert!((light(time.into()) - f64::from(u)).abs() < 1e-6, "{ramp} {u} {time}");
            }
        }
    }
}
