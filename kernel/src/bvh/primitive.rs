//! The builder's data: boxes in registers, and primitives of 32 bytes.

use core::cmp::Ordering;

use glam::{Vec3, Vec3A};

use crate::geometry::Aabb;

/// A box whose corners are vectors of the processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    /// The empty box.
    pub(super) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn grow(&mut self, other: &Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    #[inline(always)]
    pub(super) fn grow_to(&mut self, point: Vec3A) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// Half the surface area; unspecified for the empty box.
    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        (d.x + d.y) * d.z + d.x * d.y
    }

    pub(super) fn to_aabb(self) -> Aabb {
        Aabb { min: self.min.into(), max: self.max.into() }
    }
}

/// A primitive: its box and its index, side by side in 32 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Primitive {
    min: Vec3,
    id: u32,
    max: Vec3,
    unused: u32,
}

impl Primitive {
    pub(super) fn new(aabb: &Aabb, id: u32) -> Self {
        Self { min: aabb.min, id, max: aabb.max, unused: 0 }
    }

    #[inline(always)]
    pub(super) fn id(&self) -> u32 {
        self.id
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        Bounds { min: self.min.into(), max: self.max.into() }
    }

    /// The order along an axis; of equal centres, that of the indices.
    pub(super) fn cmp_along(&self, other: &Self, axis: usize) -> Ordering {
        self.center()[axis].total_cmp(&other.center()[axis]).then(self.id.cmp(&other.id))
    }

    /// Twice the box's middle: what primitives are sorted by.
    #[inline(always)]
    pub(super) fn center(&self) -> Vec3A {
        Vec3A::from(self.min) + Vec3A::from(self.max)
    }
}

/// The extent of a set of primitives.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimitiveBounds {
    /// The box around the primitives.
    pub bounds: Bounds,
    /// The box around their [centres](Primitive::center).
    pub centers: Bounds,
}

impl PrimitiveBounds {
    pub(super) const EMPTY: Self = Self { bounds: Bounds::EMPTY, centers: Bounds::EMPTY };

    pub(super) fn of(prims: &[Primitive]) -> Self {
        let mut bounds = Self::EMPTY;
        for prim in prims {
            bounds.bounds.grow(&prim.bounds());
            bounds.centers.grow_to(prim.center());
        }
        bounds
    }
}
