//! What moves while the shutter is open.
//!
//! Whatever moves is known at keys, evenly spaced from the opening of the shutter (time 0) to its closing (1), and moves in
//! straight lines between them: vertices, elements of transforms, the points of cameras and lights. The scene itself is that of
//! the middle key. A [`Scene`] has a `Motion` if something moves; what stands still is in none of the tables here, and costs
//! nothing.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use halfdome_kernel::geometry::Moment as Place;

use super::{CameraPose, PunctualLight, Scene};

/// Where things are at the keys of the shutter's time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The number of keys: odd, and at least 3.
    pub keys: usize,
    /// The part of the time in which the shutter opens, and in which it closes: 0, all at once, to 0.5.
    pub ramp: f32,
    /// The positions of each mesh that moves, by its number: as many at each key as it has.
    pub meshes: BTreeMap<usize, Vec<Vec<Vec3>>>,
    /// The transforms of each instance that moves, by its number.
    pub instances: BTreeMap<usize, Arc<[Affine3A]>>,
    /// Each light that moves, by its number: of these alone place and direction count.
    pub lights: BTreeMap<usize, Vec<PunctualLight>>,
    /// The camera's poses, none if it stands still.
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
    /// The number of keys if nobody says: a quarter of a turn is off a circle by half a percent of its radius.
    pub const DEFAULT_KEYS: usize = 5;

    /// The seconds after the frame's time at each of so many keys.
    pub(crate) fn times(&self, keys: usize, fps: f64) -> impl Iterator<Item = f64> + use<> {
        let unit = if self.in_seconds { 1.0 } else { fps.recip() };
        let (open, length) = (self.open * unit, (self.close - self.open) * unit);
        (0..keys).map(move |key| open + length * key as f64 / (keys - 1) as f64)
    }
}

impl Motion {
    /// The time at which `u` in [0, 1) of the light has come through the shutter. It opens and closes at an even rate.
    ///
    /// With `r` for the ramp the openness rises to 1 from 0 to `r`, and the light that has come through by the time `t` is
    /// `t² / 2r` there, then `t - r/2`, all over `1 - r`.
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

    /// Notes how `scene`, that of a key, differs from that of the middle one; in words why that cannot be told.
    pub(crate) fn note(&mut self, middle: &Scene, key: usize, scene: Scene) -> Result<(), String> {
        let Scene { meshes, instances, lights, camera, .. } = scene;
        let counts = [
            ("meshes", middle.meshes.len(), meshes.len()),
            ("instances", middle.instances.len(), instances.len()),
            ("lights", middle.lights.len(), lights.len()),
        ];
        if let Some((what, shown, other)) = counts.iter().find(|(_, shown, other)| shown != other) {
            return Err(format!("it has {shown} {what} in the middle, and {other} at another time"));
        }
        for (number, (mesh, still)) in meshes.into_iter().zip(&middle.meshes).enumerate() {
            if mesh.positions.len() != still.positions.len() || mesh.triangles != still.triangles {
                return Err(format!("mesh {number} ({:?}) has other triangles at another time", still.name));
            }
            if mesh.positions != still.positions {
                if mesh.object.is_some() {
                    return Err(format!("object mesh {number} ({:?}) changes its shape", still.name));
                }
                self.meshes.entry(number).or_insert_with(|| vec![still.positions.clone(); self.keys])[key] =
                    mesh.positions;
            }
        }
        for (number, (instance, still)) in instances.into_iter().zip(&middle.instances).enumerate() {
            if instance.to_world != still.to_world {
                let keys = self.instances.entry(number).or_insert_with(|| vec![still.to_world; self.keys].into());
                Arc::make_mut(keys)[key] = instance.to_world;
            }
        }
        for (number, (light, still)) in lights.into_iter().zip(&middle.lights).enumerate() {
            if light != *still {
                self.lights.entry(number).or_insert_with(|| vec![still.clone(); self.keys])[key] = light;
            }
        }
        if let (Some(pose), Some(still)) = (camera, middle.camera)
            && pose != still
        {
            if self.cameras.is_empty() {
                self.cameras = vec![still; self.keys];
            }
            self.cameras[key] = pose;
        }
        Ok(())
    }
}

impl PunctualLight {
    /// Where it stands, its greatest intensity, and its radius; `None` if it is infinitely far away.
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
    use crate::scene::{Instance, Mesh, Object};

    fn at(x: f32) -> Scene {
        let mesh = |x: f32| Mesh {
            positions: vec![Vec3::X * x, Vec3::X * x + Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
        let to_world = Affine3A::from_translation(Vec3::X * x);
        Scene {
            meshes: vec![mesh(0.0), mesh(x)],
            objects: vec![Object::default()],
            instances: vec![Instance { object: 0, to_world }],
            lights: vec![PunctualLight::Point { position: Vec3::X * x, intensity: Vec3::ONE, radius: 0.1 }],
            camera: Some(camera),
            ..Scene::default()
        }
    }

    #[test]
    fn what_moves_is_noted_and_the_rest_is_not() {
        let mut motion = Motion { keys: 3, ..Motion::default() };
        let middle = at(1.0);
        for (key, x) in [(0, 0.5), (2, 4.0)] {
            motion.note(&middle, key, at(x)).unwrap();
        }
        assert_eq!(motion.meshes.keys().collect::<Vec<_>>(), [&1]);
        assert_eq!(motion.meshes[&1].iter().map(|positions| positions[0].x).collect::<Vec<_>>(), [0.5, 1.0, 4.0]);
        assert_eq!(motion.instances[&0].iter().map(|it| it.translation.x).collect::<Vec<_>>(), [0.5, 1.0, 4.0]);
        assert!(motion.cameras.is_empty() && !motion.is_still());
        let [from, to] = [&motion.lights[&0][1], &motion.lights[&0][2]];
        let light = PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::splat(7.0), radius: 0.2 };
        let PunctualLight::Point { position, intensity, radius } =
            light.between(Place::new(0.75, 3).unwrap(), from, to)
        else {
            panic!("a point stays one")
        };
        assert_eq!((position, intensity, radius), (Vec3::X * 2.5, Vec3::splat(7.0), 0.2));

        let mut still = Motion { keys: 3, ..Motion::default() };
        still.note(&middle, 0, at(1.0)).unwrap();
        assert!(still.is_still());
        let mut other = at(1.0);
        other.meshes.pop();
        assert_eq!(still.note(&middle, 0, other).unwrap_err(), "it has 2 meshes in the middle, and 1 at another time");
    }

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
