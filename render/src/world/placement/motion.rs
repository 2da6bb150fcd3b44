//! Moving geometry, prepared for tracing.
//!
//! Every path has a time, and so have its hits ([`Hit::time`]). Rays without a time see the world at the middle time,
//! which is also the time of the records of triangles, instances and lights, and of light estimates. A point's position
//! at another time is interpolated exactly as in the kernel.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use halfdome_kernel::Triangle;
use halfdome_kernel::geometry::Moment;

use crate::scene::{self, CameraPose, Mesh, PunctualLight};

/// All that moves.
#[derive(Debug)]
pub(crate) struct Motion {
    keys: usize,
    /// The `prim_id` of the first triangle that moves by itself.
    first: u32,
    /// The corners of these at each key.
    corners: Vec<Vec<Triangle>>,
    /// The transforms of each instance that moves, by its index.
    instances: BTreeMap<usize, Arc<[Affine3A]>>,
    /// Each punctual light that moves, by its index in the scene.
    lights: BTreeMap<usize, Vec<PunctualLight>>,
    /// The camera's poses, empty if it is static.
    cameras: Vec<CameraPose>,
    shutter: scene::Motion,
}

impl Motion {
    /// The motion of the meshes with the indices `moving`, whose triangles have indices from `first` on.
    pub(crate) fn new(mut motion: scene::Motion, meshes: &[Mesh], moving: &[usize], first: u32) -> Self {
        let at = |key: usize| {
            let corners = |number: &usize| {
                let positions = &motion.meshes[number][key];
                meshes[*number].triangles.iter().map(|corners| corners.map(|corner| positions[corner as usize]))
            };
            moving.iter().flat_map(corners).collect()
        };
        let corners = (0..motion.keys).map(at).collect();
        motion.meshes.clear();
        Self {
            keys: motion.keys,
            first,
            corners,
            instances: std::mem::take(&mut motion.instances),
            lights: std::mem::take(&mut motion.lights),
            cameras: std::mem::take(&mut motion.cameras),
            shutter: motion,
        }
    }

    /// The corners of the triangles that move by themselves at each key, and the `prim_id` of the first.
    pub(crate) fn triangles(&self) -> (Vec<&[Triangle]>, u32) {
        (self.corners.iter().map(Vec::as_slice).collect(), self.first)
    }

    /// The transforms of an instance at the keys, if it moves.
    pub(crate) fn instance(&self, number: usize) -> Option<&Arc<[Affine3A]>> {
        self.instances.get(&number)
    }

    /// Between which keys a time lies.
    fn moment(&self, time: f32) -> Moment {
        Moment::new(time, self.keys).unwrap_or(Moment { key: 0, fraction: 0.0 })
    }

    /// The values at the key before a time and the one after.
    fn around<T>(keys: &[T], moment: Moment) -> (&T, &T) {
        (&keys[moment.key], &keys[(moment.key + 1).min(keys.len() - 1)])
    }

    /// The corners of a triangle at a time, if it moves by itself.
    #[inline]
    pub(crate) fn corners(&self, prim_id: u32, time: f32) -> Option<Triangle> {
        let index = prim_id.checked_sub(self.first).filter(|&index| (index as usize) < self.corners[0].len())?;
        let moment = self.moment(time);
        let (from, to) = Self::around(&self.corners, moment);
        let (from, to) = (&from[index as usize], &to[index as usize]);
        let corner = |k: usize| moment.vector(from[k], to[k]);
        Some([corner(0), corner(1), corner(2)])
    }

    /// The linear part and the translation of an instance at a time, if it moves.
    pub(crate) fn to_world(&self, instance: u32, time: f32) -> Option<[Vec3; 4]> {
        let keys = self.instances.get(&(instance.checked_sub(1)? as usize))?;
        let moment = self.moment(time);
        let (from, to) = Self::around(keys, moment);
        let columns = |it: &Affine3A| {
            [it.matrix3.x_axis.into(), it.matrix3.y_axis.into(), it.matrix3.z_axis.into(), it.translation.into()]
        };
        let (from, to): ([Vec3; 4], [Vec3; 4]) = (columns(from), columns(to));
        let column = |k: usize| moment.vector(from[k], to[k]);
        Some([column(0), column(1), column(2), column(3)])
    }

    /// The time at which the shutter lets through what `u` in [0, 1) means.
    pub(crate) fn time(&self, u: f32) -> f32 {
        self.shutter.time(u)
    }

    /// The camera's poses at the keys, empty if it is static.
    pub(crate) fn cameras(&self) -> &[CameraPose] {
        &self.cameras
    }

    /// Makes the camera static.
    pub(crate) fn stop_camera(&mut self) {
        self.cameras.clear();
    }

    /// Between which of the camera's keys a time lies.
    pub(crate) fn camera_moment(&self, time: f32) -> Moment {
        self.moment(time)
    }

    /// A punctual light, by its index in the scene, where it is at a time; `None` if it is static.
    pub(crate) fn light(&self, number: usize, still: &PunctualLight, time: f32) -> Option<PunctualLight> {
        let keys = self.lights.get(&number)?;
        let moment = self.moment(time);
        let (from, to) = Self::around(keys, moment);
        Some(still.between(moment, from, to))
    }
}

impl scene::Motion {
    /// Each light that moves, by its index, as one that reaches wherever it does at any time: light is chosen by these.
    pub(crate) fn spread_lights(&self, lights: &[PunctualLight]) -> Vec<(usize, PunctualLight)> {
        let spread = |(&number, keys): (&usize, &Vec<PunctualLight>)| {
            let still = &lights[number];
            let light = match (still, still.place()) {
                (PunctualLight::Directional { direction, irradiance, half_angle }, _) => {
                    let angle = |key: &PunctualLight| match key {
                        PunctualLight::Directional { direction: other, .. } => direction.angle_between(*other),
                        _ => 0.0,
                    };
                    let widest = keys.iter().map(angle).fold(0.0, f32::max);
                    let half_angle = (half_angle + widest).min(1.5);
                    PunctualLight::Directional { direction: *direction, irradiance: *irradiance, half_angle }
                }
                (_, Some((position, intensity, radius))) => {
                    let distance =
                        |key: &PunctualLight| key.place().map_or(0.0, |(other, ..)| other.distance(position));
                    let radius = radius + keys.iter().map(distance).fold(0.0, f32::max);
                    PunctualLight::Point { position, intensity, radius }
                }
                _ => still.clone(),
            };
            (number, light)
        };
        self.lights.iter().map(spread).collect()
    }
}
