//! Instances: a tree for each object, and one over all instances.
//!
//! Triangles that move between keys are in a tree of their own.
//!
//! Rays go through the tree of all other triangles first, in streams, and then, shortened, from instance to instance. A
//! hit refers to the object's triangle; an [`InstanceRecord`] transforms it to the world.
//!
//! A point of a triangle is off by the rounding of three multiplications and sums and by that of the local ray, whose
//! origin is rounded in the object's coordinates: so rays start farther away from it than from other triangles.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat3, Vec3};
use halfdome_kernel::bvh::MovingBvh;
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{
    BuildOptions, Bvh, Executor, Item, Ray, Scene, SceneHit, SceneRay, Triangle, Verdict, offset_distance,
    triangle_normal,
};

use crate::scene::{Instance, Mesh, Turn};
use crate::world::hit::time_of;
use crate::world::{Hit, Motion, TriangleRecord, World, WorldError};

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
pub(crate) struct Instances {
    scene: Scene<'static>,
    /// The index of the first triangle of each item's object.
    first_prims: Vec<u32>,
    /// The records of the items, after that of the world itself.
    records: Vec<InstanceRecord>,
    /// The item that has the triangles that move by themselves, in the world's coordinates.
    moving: Option<u32>,
    /// How many exceed the coordinate limits, and are invisible.
    pub(crate) out_of_range: usize,
}

/// Rays that are traced through instances together.
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

    /// The same instance elsewhere; `error` stays, as that of the greatest coordinates.
    pub(crate) fn moved(self, axes: [Vec3; 3], translation: Vec3) -> Self {
        let scale = axes.iter().map(|axis| axis.length_squared()).sum::<f32>().sqrt();
        let side = if Mat3::from_cols(axes[0], axes[1], axes[2]).determinant() < 0.0 { -1.0 } else { 1.0 };
        Self { axes, translation, scale, side, ..self }
    }

    /// The corners of this triangle, its unit normal on the front, and the offset of ray origins from its plane.
    #[inline(always)]
    pub(crate) fn place(&self, corners: &Triangle, offset: f32) -> (Triangle, Vec3, f32) {
        let [x, y, z] = self.axes;
        let corners = corners.map(|p| x * p.x + y * p.y + z * p.z + self.translation);
        let normal = triangle_normal(&corners) * self.side;
        let offset = offset_distance(&corners, normal) + offset * self.scale + self.error;
        (corners, normal, offset)
    }

    /// The transform to the world.
    fn placement(&self) -> Affine3A {
        Affine3A {
            matrix3: Mat3::from_cols(self.axes[0], self.axes[1], self.axes[2]).into(),
            translation: self.translation.into(),
        }
    }

    /// The rotation of directions.
    pub(crate) fn turn(&self) -> Turn {
        Turn::new(Mat3::from_cols(self.axes[0], self.axes[1], self.axes[2]))
    }
}

impl Instances {
    /// Objects, by their triangles, each with the index of its first one; and where they are.
    pub(crate) fn build<E: Executor>(
        executor: &E,
        objects: &[(Vec<Triangle>, u32)],
        instances: Vec<Instance>,
        motion: Option<&Motion>,
        options: &BuildOptions,
    ) -> Result<Self, WorldError> {
        let mut trees = Vec::new();
        for (triangles, _) in objects {
            trees.push(Arc::new(Bvh::build_on(executor, triangles, options)?.0));
        }
        let mut items = Vec::with_capacity(instances.len());
        let (mut first_prims, mut records) = (Vec::with_capacity(instances.len()), vec![InstanceRecord::WORLD]);
        for (number, Instance { object, to_world }) in instances.iter().enumerate() {
            let item = Item::new(trees[*object].clone());
            let keys = motion.and_then(|motion| motion.instance(number));
            let item = match keys {
                Some(keys) => item.moving_shared(keys.clone()),
                None => item.placed(to_world),
            };
            items.push(item.map_err(|error| WorldError::Instance { number, object: *object, error })?);
            first_prims.push(objects[*object].1);
            let bounds = trees[*object].view().bounds();
            let record = InstanceRecord::new(to_world, &bounds);
            let errors =
                keys.into_iter().flat_map(|keys| keys.iter()).map(|key| InstanceRecord::new(key, &bounds).error);
            records.push(InstanceRecord { error: errors.fold(record.error, f32::max), ..record });
        }
        drop(instances);
        let mut moving = None;
        if let Some((corners, first)) = motion.map(Motion::triangles)
            && !corners[0].is_empty()
        {
            let (tree, _) = MovingBvh::build_on(executor, &corners, options)?;
            items.push(Item::new(Arc::new(tree)));
            moving = Some(first_prims.len() as u32);
            first_prims.push(first);
        }
        let (scene, report) = Scene::build_on(executor, items, options)?;
        Ok(Self { scene, first_prims, records, moving, out_of_range: report.out_of_range })
    }

    pub(crate) fn records(&self) -> &[InstanceRecord] {
        &self.records
    }

    /// See [`World::instance_bytes`].
    pub(crate) fn bytes(&self) -> usize {
        self.scene.memory_bytes() + size_of_val(&self.first_prims[..]) + size_of_val(&self.records[..])
    }

    /// The box around all instances; empty if there are none.
    pub(crate) fn bounds(&self) -> Aabb {
        self.scene.view().bounds()
    }

    fn hit(&self, found: &SceneHit) -> Hit {
        let prim_id = self.first_prims[found.item as usize] + found.hit.prim_id;
        let instance = if self.moving == Some(found.item) { 0 } else { found.item + 1 };
        Hit { prim_id, instance, ..Hit::of(&found.hit) }
    }

    /// Replaces hits by those with instances that are nearer.
    pub(crate) fn intersect_nearer(&self, rays: &[Ray], times: &[f32], hits: &mut [Hit]) {
        let (view, reach) = (self.scene.view(), Reach::of(&self.scene));
        let mut found = [SceneHit::MISS; BATCH];
        let mut first = 0;
        while first < rays.len() {
            let batch = reach
                .batch(rays, times, &mut first, |i| Some(if hits[i].is_hit() { hits[i].t } else { rays[i].t_max }));
            view.intersect_many(batch.rays(), &mut found[..batch.len]);
            for (&i, found) in batch.numbers().iter().zip(&found) {
                let hit = &mut hits[i as usize];
                if found.is_hit() && (found.hit.t < hit.t || !hit.is_hit()) {
                    *hit = self.hit(found);
                }
            }
        }
    }

    /// Adds to what is known of each ray whether it hits an instance.
    pub(crate) fn occlude(&self, rays: &[Ray], times: &[f32], occluded: &mut [bool]) {
        let (view, reach) = (self.scene.view(), Reach::of(&self.scene));
        let mut found = [false; BATCH];
        let mut first = 0;
        while first < rays.len() {
            let batch = reach.batch(rays, times, &mut first, |i| (!occluded[i]).then_some(rays[i].t_max));
            view.occluded_many(batch.rays(), &mut found[..batch.len]);
            for (&i, found) in batch.numbers().iter().zip(&found) {
                occluded[i as usize] = *found;
            }
        }
    }

    /// The nearest hit with an instance that is accepted.
    pub(crate) fn intersect_filtered(&self, ray: &Ray, time: f32, accepts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let verdict = |hit: &SceneHit| if accepts(&self.hit(hit)) { Verdict::Accept } else { Verdict::Reject };
        self.scene.view().intersect_filtered(&SceneRay::new(*ray).at_time(time), verdict).map(|hit| self.hit(&hit))
    }

    /// Whether an instance is hit and accepted.
    pub(crate) fn occluded_filtered(&self, ray: &Ray, time: f32, accepts: impl Fn(&Hit) -> bool) -> bool {
        let verdict = |hit: &SceneHit| if accepts(&self.hit(hit)) { Verdict::Accept } else { Verdict::Reject };
        self.scene.view().occluded_filtered(&SceneRay::new(*ray).at_time(time), verdict)
    }
}

/// A box that no hit with an instance is outside of, a little larger than theirs.
struct Reach(Aabb);

/// Rays that may hit an instance, and their indices.
struct Batch {
    rays: [SceneRay; BATCH],
    numbers: [u32; BATCH],
    len: usize,
}

impl Reach {
    /// Beyond what is rounded in the test of a ray, of any of the magnitudes here.
    const PAD: f32 = 1e-5;

    fn of(scene: &Scene) -> Self {
        let Aabb { min, max } = scene.view().bounds();
        let pad = Vec3::splat(Self::PAD * min.abs().max(max.abs()).max_element());
        Self(Aabb { min: min - pad, max: max + pad })
    }

    /// Whether a ray comes into the box before `t_max`, or nearly.
    #[inline(always)]
    fn meets(&self, ray: &Ray, t_max: f32) -> bool {
        let pad = Self::PAD * ray.origin.abs();
        let inverse = ray.direction.recip();
        // Where a ray runs in a plane of the box, one of these is no number, which `min` and `max` pass over.
        let (near, far) = ((self.0.min - pad - ray.origin) * inverse, (self.0.max + pad - ray.origin) * inverse);
        let from = |a: f32, b: f32| a.min(b);
        let to = |a: f32, b: f32| a.max(b);
        let enter = from(near.x, far.x).max(from(near.y, far.y)).max(from(near.z, far.z));
        let leave = to(near.x, far.x).min(to(near.y, far.y)).min(to(near.z, far.z));
        let slack = 1.0 + Self::PAD;
        !(enter > leave * slack || enter > t_max * slack || leave * slack < ray.t_min)
    }

    /// The next rays from `first` on that may hit, as long as `t_max` says, if it says.
    fn batch(&self, rays: &[Ray], times: &[f32], first: &mut usize, t_max: impl Fn(usize) -> Option<f32>) -> Batch {
        let mut batch = Batch { rays: [SceneRay::zeroed(); BATCH], numbers: [0; BATCH], len: 0 };
        while *first < rays.len() && batch.len < BATCH {
            let (i, ray) = (*first, &rays[*first]);
            *first += 1;
            if let Some(t_max) = t_max(i).filter(|&t_max| self.meets(ray, t_max)) {
                batch.rays[batch.len] = SceneRay::new(Ray { t_max, ..*ray }).at_time(time_of(times, i));
                batch.numbers[batch.len] = i as u32;
                batch.len += 1;
            }
        }
        batch
    }
}

impl Batch {
    fn rays(&self) -> &[SceneRay] {
        &self.rays[..self.len]
    }

    fn numbers(&self) -> &[u32] {
        &self.numbers[..self.len]
    }
}

impl World {
    /// The record of each instance; `None` if all triangles are in world space.
    #[inline(always)]
    pub(crate) fn instance_records(&self) -> Option<&[InstanceRecord]> {
        self.instances.as_ref().map(Instances::records)
    }

    /// The transforms of a mesh, one or many.
    pub(crate) fn placements_of(&self, mesh: &Mesh) -> Vec<Affine3A> {
        if mesh.object.is_none() {
            return vec![Affine3A::IDENTITY];
        }
        let of_object = self.meshes.iter().zip(&self.first_faces).filter(|(other, _)| other.object == mesh.object);
        let (Some(all), Some(first)) = (&self.instances, of_object.map(|(_, first)| *first).min()) else {
            return Vec::new();
        };
        let placed = all.first_prims.iter().zip(&all.records[1..]).filter(|(number, _)| **number == first);
        placed.map(|(_, record)| record.placement()).collect()
    }

    /// The record of a hit's triangle in the world, at its time.
    #[inline(always)]
    pub(crate) fn placed_record(&self, hit: &Hit) -> TriangleRecord {
        let record = self.triangle_records[hit.prim_id as usize];
        let Some(records) = self.instance_records() else { return record };
        if let Some(moved) = self.moved_record(hit) {
            return moved;
        }
        if hit.instance == 0 {
            return record;
        }
        let (corners, normal, offset) = records[hit.instance as usize].place(&record.corners, record.offset);
        TriangleRecord { corners, normal, offset, ..record }
    }
}
