//! Surfaces, emitters and lights at the time of a path.
//!
//! Vertex normals and tangents are those of the middle of the shutter's time, rotated with the triangle: by the linear
//! map of its edges and its normal.

use glam::Mat3;
use halfdome_kernel::Triangle;

use crate::light::{TrianglePart, area};
use crate::scene::{PunctualLight, Turn};
use crate::world::{Hit, InstanceRecord, Motion, TriangleRecord, World};

/// The rotation of a triangle; `None` if it was or is a line.
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
    /// Motion, if there is any.
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
    pub(crate) fn turn_at(&self, hit: &Hit) -> Option<Turn> {
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

    /// The corners of a light that is a part of a triangle at a time, and its area.
    #[inline(always)]
    pub(crate) fn emitter_corners(&self, light: u32, part: &TrianglePart, time: f32) -> (Triangle, f32) {
        if let Some(corners) = self.motion.as_ref().and_then(|motion| motion.corners(part.prim_id, time)) {
            let corners = part.corners(&corners);
            return (corners, area(&corners));
        }
        let emitter = &self.emitter_records[light as usize];
        (emitter.corners, emitter.area)
    }

    /// The punctual light that `index` is, where it is at a time, if it moves.
    #[inline(never)]
    pub(crate) fn moved_light(&self, index: u32, still: &PunctualLight, time: f32) -> Option<PunctualLight> {
        let motion = self.motion.as_ref()?;
        motion.light(self.lights.punctual_number(index), still, time)
    }
}
