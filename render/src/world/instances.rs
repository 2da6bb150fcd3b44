//! Objects that are kept once and seen at many places: a tree for each object, and one over all instances.
//!
//! Rays go through the tree of all other triangles first, in streams, and then, shortened, from instance to instance. A
//! hit's triangle is that of the object; an [`InstanceRecord`] takes it to the world.
//!
//! A point of a triangle is off by the rounding of three multiplications and sums and by that of the local ray, whose
//! origin is rounded in the object's coordinates: so rays start farther away from it than from other triangles.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat3, Vec3};
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{
    BuildOptions, Bvh, Executor, Item, Ray, Scene, SceneHit, SceneRay, Triangle, Verdict, offset_distance,
    triangle_normal,
};

use super::{Hit, TriangleRecord, World, WorldError};
use crate::scene::{Instance, Turn};

/// An instance, as far as shading needs to know.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct InstanceRecord {
    /// Columns of the transform to the world.
    pub(crate) axes: [Vec3; 3],
    pub(crate) translation: Vec3,
    /// The greatest factor by which it lengthens, of an error in the object's coordinates.
    pub(crate) scale: f32,
    /// The error of a transformed point.
    pub(crate) error: f32,
    /// -1 if it mirrors, else 1.
    pub(crate) side: f32,
    pub(crate) unused: u32,
}

/// All instances of a world.
#[derive(Debug)]
pub(super) struct Instances {
    scene: Scene<'static>,
    /// For each item of the scene the number of its object's first triangle.
    first_prims: Vec<u32>,
    /// Those of the items, after that of the world itself.
    records: Vec<InstanceRecord>,
    /// How many reach beyond what coordinates may be, and are not seen.
    pub(super) out_of_range: usize,
}

/// Rays whose hits with instances are looked for at once.
const BATCH: usize = 64;

impl InstanceRecord {
    /// What is in the world already.
    const WORLD: Self =
        Self { axes: Vec3::AXES, translation: Vec3::ZERO, scale: 0.0, error: 0.0, side: 1.0, unused: 0 };

    /// An instance of an object within these bounds.
    fn new(to_world: &Affine3A, object: &Aabb) -> Self {
        /// Units in the last place: of three products, three sums and the rounding of a local origin.
        const ERROR: f32 = 8.0 / (1u32 << 24) as f32;
        let (linear, translation) = (Mat3::from(to_world.matrix3), Vec3::from(to_world.translation));
        let absolute = |p: Vec3| linear.x_axis.abs() * p.x + linear.y_axis.abs() * p.y + linear.z_axis.abs() * p.z;
        let reach = if object.is_empty() { Vec3::ZERO } else { object.min.abs().max(object.max.abs()) };
        let error = ERROR * (absolute(reach) + translation.abs()).max_element();
        let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
        // A bound of the greatest singular value: the Frobenius norm.
        let scale = axes.iter().map(|axis| axis.length_squared()).sum::<f32>().sqrt();
        let side = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        Self { axes, translation, scale, error, side, unused: 0 }
    }

    /// Where corners of this triangle are, its unit normal on the front, and how far from its plane rays start.
    #[inline(always)]
    pub(crate) fn place(&self, corners: &Triangle, offset: f32) -> (Triangle, Vec3, f32) {
        let [x, y, z] = self.axes;
        let corners = corners.map(|p| x * p.x + y * p.y + z * p.z + self.translation);
        let normal = triangle_normal(&corners) * self.side;
        let offset = offset_distance(&corners, normal) + offset * self.scale + self.error;
        (corners, normal, offset)
    }

    /// How it turns directions.
    pub(super) fn turn(&self) -> Turn {
        Turn::new(Mat3::from_cols(self.axes[0], self.axes[1], self.axes[2]))
    }
}

impl Instances {
    /// Objects, by their triangles, each with the number of its first one; and where they are.
    pub(super) fn build<E: Executor>(
        executor: &E,
        objects: &[(Vec<Triangle>, u32)],
        instances: Vec<Instance>,
        options: &BuildOptions,
    ) -> Result<Self, WorldError> {
        let mut trees = Vec::new();
        for (triangles, _) in objects {
            trees.push(Arc::new(Bvh::build_on(executor, triangles, options)?.0));
        }
        let mut items = Vec::with_capacity(instances.len());
        let (mut first_prims, mut records) = (Vec::with_capacity(instances.len()), vec![InstanceRecord::WORLD]);
        for (number, Instance { object, to_world }) in instances.iter().enumerate() {
            let item = Item::new(trees[*object].clone()).placed(to_world);
            items.push(item.map_err(|error| WorldError::Instance { number, object: *object, error })?);
            first_prims.push(objects[*object].1);
            records.push(InstanceRecord::new(to_world, &trees[*object].view().bounds()));
        }
        drop(instances);
        let (scene, report) = Scene::build_on(executor, items, options)?;
        Ok(Self { scene, first_prims, records, out_of_range: report.out_of_range })
    }

    pub(super) fn records(&self) -> &[InstanceRecord] {
        &self.records
    }

    /// See [`World::instance_bytes`].
    pub(super) fn bytes(&self) -> usize {
        self.scene.bytes() + size_of_val(&self.first_prims[..]) + size_of_val(&self.records[..])
    }

    /// The box around all instances; empty if there are none.
    pub(super) fn bounds(&self) -> Aabb {
        self.scene.view().bounds()
    }

    fn hit(&self, found: &SceneHit) -> Hit {
        let prim_id = self.first_prims[found.geometry_id as usize] + found.hit.prim_id;
        Hit { prim_id, instance: found.geometry_id + 1, ..Hit::of(&found.hit) }
    }

    /// Replaces hits by those with instances that are nearer.
    pub(super) fn intersect_nearer(&self, rays: &[Ray], hits: &mut [Hit]) {
        let view = self.scene.view();
        for (rays, hits) in rays.chunks(BATCH).zip(hits.chunks_mut(BATCH)) {
            let (mut shortened, mut found) = ([SceneRay::zeroed(); BATCH], [SceneHit::MISS; BATCH]);
            for ((to, ray), hit) in shortened.iter_mut().zip(rays).zip(hits.iter()) {
                *to = SceneRay::new(Ray { t_max: if hit.is_hit() { hit.t } else { ray.t_max }, ..*ray });
            }
            view.intersect_many(&shortened[..rays.len()], &mut found[..rays.len()]);
            for (hit, found) in hits.iter_mut().zip(&found) {
                if found.is_hit() && (found.hit.t < hit.t || !hit.is_hit()) {
                    *hit = self.hit(found);
                }
            }
        }
    }

    /// Adds to what is known of each ray whether it hits an instance.
    pub(super) fn occlude(&self, rays: &[Ray], occluded: &mut [bool]) {
        let view = self.scene.view();
        for (ray, occluded) in rays.iter().zip(occluded).filter(|(_, occluded)| !**occluded) {
            *occluded = view.occluded(&SceneRay::new(*ray));
        }
    }

    /// The nearest hit with an instance that is accepted.
    pub(super) fn intersect_filtered(&self, ray: &Ray, accepts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let verdict = |hit: &SceneHit| if accepts(&self.hit(hit)) { Verdict::Accept } else { Verdict::Reject };
        self.scene.view().intersect_filtered(&SceneRay::new(*ray), verdict).map(|hit| self.hit(&hit))
    }

    /// Whether an instance is hit and accepted.
    pub(super) fn occluded_filtered(&self, ray: &Ray, accepts: impl Fn(&Hit) -> bool) -> bool {
        let verdict = |hit: &SceneHit| if accepts(&self.hit(hit)) { Verdict::Accept } else { Verdict::Reject };
        self.scene.view().occluded_filtered(&SceneRay::new(*ray), verdict)
    }
}

impl World {
    /// What is known of each instance; `None` if all triangles are in world space.
    #[inline(always)]
    pub(crate) fn instance_records(&self) -> Option<&[InstanceRecord]> {
        self.instances.as_ref().map(Instances::records)
    }

    /// A triangle's record in the world.
    #[inline(always)]
    pub(super) fn placed_record(&self, prim_id: u32, instance: u32) -> TriangleRecord {
        let record = self.triangle_records[prim_id as usize];
        match self.instance_records() {
            Some(records) if instance != 0 => {
                let (corners, normal, offset) = records[instance as usize].place(&record.corners, record.offset);
                TriangleRecord { corners, normal, offset, ..record }
            }
            _ => record,
        }
    }
}
