//! What moves while the shutter is open, ready to be traced.
//!
//! Every path has a time, and so have its hits ([`Hit::time`]). Rays without one see the world as it is in the middle, where
//! the records of triangles, instances and lights have it; so does whoever estimates how much light there is. A point's place
//! at another time is interpolated just as the kernel does it.
//!
//! Vertex normals and tangents are those of the middle, turned as the triangle has turned since: by the linear map of its
//! edges and its normal.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};
use halfdome_kernel::Triangle;
use halfdome_kernel::geometry::Moment;

use super::{Hit, InstanceRecord, TriangleRecord, World};
use crate::light::area;
use crate::scene::{self, CameraPose, Mesh, PunctualLight, Turn};

/// All that moves.
#[derive(Debug)]
pub(crate) struct Motion {
    keys: usize,
    /// The `prim_id` of the first triangle that moves by itself.
    first: u32,
    /// The corners of these at each key.
    corners: Vec<Vec<Triangle>>,
    /// The transforms of each instance that moves, by its number.
    instances: BTreeMap<usize, Arc<[Affine3A]>>,
    /// Each punctual light that moves, by its number in the scene.
    lights: BTreeMap<usize, Vec<PunctualLight>>,
    /// The camera's poses, none if it stands still.
    cameras: Vec<CameraPose>,
    shutter: scene::Motion,
}

impl Motion {
    /// Of the meshes that these numbers name, whose triangles have numbers from `first` on.
    pub(super) fn new(mut motion: scene::Motion, meshes: &[Mesh], moving: &[usize], first: u32) -> Self {
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
    pub(super) fn triangles(&self) -> (Vec<&[Triangle]>, u32) {
        (self.corners.iter().map(Vec::as_slice).collect(), self.first)
    }

    /// The transforms of an instance at the keys, if it moves.
    pub(super) fn instance(&self, number: usize) -> Option<&Arc<[Affine3A]>> {
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
    fn corners(&self, prim_id: u32, time: f32) -> Option<Triangle> {
        let index = prim_id.checked_sub(self.first).filter(|&index| (index as usize) < self.corners[0].len())?;
        let moment = self.moment(time);
        let (from, to) = Self::around(&self.corners, moment);
        let (from, to) = (&from[index as usize], &to[index as usize]);
        Some([0, 1, 2].map(|corner| moment.vector(from[corner], to[corner])))
    }

    /// The linear part and the translation of an instance at a time, if it moves.
    fn to_world(&self, instance: u32, time: f32) -> Option<[Vec3; 4]> {
        let keys = self.instances.get(&(instance.checked_sub(1)? as usize))?;
        let moment = self.moment(time);
        let (from, to) = Self::around(keys, moment);
        let columns = |it: &Affine3A| {
            [it.matrix3.x_axis.into(), it.matrix3.y_axis.into(), it.matrix3.z_axis.into(), it.translation.into()]
        };
        let (from, to): ([Vec3; 4], [Vec3; 4]) = (columns(from), columns(to));
        Some([0, 1, 2, 3].map(|column| moment.vector(from[column], to[column])))
    }

    /// The time at which the shutter lets through what `u` in [0, 1) means.
    pub(crate) fn time(&self, u: f32) -> f32 {
        self.shutter.time(u)
    }

    /// The camera's poses at the keys, none if it stands still.
    pub(crate) fn cameras(&self) -> &[CameraPose] {
        &self.cameras
    }

    /// Lets the camera stand still.
    pub(super) fn stop_camera(&mut self) {
        self.cameras.clear();
    }

    /// Between which of the camera's keys a time lies.
    pub(crate) fn camera_moment(&self, time: f32) -> Moment {
        self.moment(time)
    }

    fn light(&self, number: usize, still: &PunctualLight, time: f32) -> Option<PunctualLight> {
        let keys = self.lights.get(&number)?;
        let moment = self.moment(time);
        let (from, to) = Self::around(keys, moment);
        Some(still.between(moment, from, to))
    }
}

impl scene::Motion {
    /// Each light that moves, by its number, as one that reaches wherever it does at any time: light is chosen by these.
    pub(super) fn spread_lights(&self, lights: &[PunctualLight]) -> Vec<(usize, PunctualLight)> {
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

/// How a triangle has turned; `None` if it was or is a line.
fn turn_between(from: &Triangle, to: &Triangle) -> Option<Turn> {
    let frame = |[a, b, c]: &Triangle| {
        let [b, c] = [(b - a).as_dvec3(), (c - a).as_dvec3()];
        let normal = b.cross(c);
        // As long as the edges are, so that the map is of their magnitude.
        let length = normal.length().sqrt();
        (length > 0.0).then(|| glam::DMat3::from_cols(b, c, normal / length))
    };
    let (from, to) = (frame(from)?, frame(to)?);
    let map: Mat3 = (to * from.inverse()).as_mat3();
    map.is_finite().then(|| Turn::new(map))
}

impl World {
    /// What moves, if anything does.
    pub(crate) fn motion(&self) -> Option<&Motion> {
        self.motion.as_ref()
    }

    /// The record of a triangle that moves by itself or with its instance, where it is at the time of a hit; `None` for
    /// others.
    pub(super) fn moved_record(&self, hit: &Hit) -> Option<TriangleRecord> {
        let motion = self.motion.as_ref()?;
        let record = self.triangle_records[hit.prim_id as usize];
        if let Some(corners) = motion.corners(hit.prim_id, hit.time) {
            return Some(record.with_corners(corners));
        }
        let (corners, normal, offset) = self.moved_instance(hit)?.place(&record.corners, record.offset);
        Some(TriangleRecord { corners, normal, offset, ..record })
    }

    /// The record of a hit's instance at its time, if that moves.
    fn moved_instance(&self, hit: &Hit) -> Option<InstanceRecord> {
        let [x, y, z, translation] = self.motion.as_ref()?.to_world(hit.instance, hit.time)?;
        let still = self.instance_records()?[hit.instance as usize];
        Some(still.moved([x, y, z], translation))
    }

    /// How directions on the surface of a hit's triangle have turned: with its instance, or by itself since the middle.
    pub(super) fn turn_at(&self, hit: &Hit) -> Option<Turn> {
        if let Some(motion) = &self.motion {
            if let Some(corners) = motion.corners(hit.prim_id, hit.time) {
                return turn_between(&self.triangle_records[hit.prim_id as usize].corners, &corners);
            }
            if let Some(record) = self.moved_instance(hit) {
                return Some(record.turn());
            }
        }
        let records = self.instance_records().filter(|_| hit.instance != 0)?;
        Some(records[hit.instance as usize].turn())
    }

    /// The corners of an emitter at a time, and its area.
    #[inline(always)]
    pub(crate) fn emitter_at(&self, prim_id: u32, time: f32) -> (Triangle, f32) {
        if let Some(corners) = self.motion.as_ref().and_then(|motion| motion.corners(prim_id, time)) {
            return (corners, area(&corners));
        }
        let emitter = self.emitter(prim_id);
        (emitter.corners, emitter.area)
    }

    /// The punctual light that `index` is, where it is at a time, if it moves.
    #[inline(never)]
    pub(crate) fn moved_light(&self, index: u32, still: &PunctualLight, time: f32) -> Option<PunctualLight> {
        let motion = self.motion.as_ref().filter(|motion| !motion.lights.is_empty())?;
        motion.light(self.lights.punctual_number(index), still, time)
    }
}
