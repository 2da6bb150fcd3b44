//! Shading records: the data of triangles, their materials and their lights, in eight words or a multiple. Shading of
//! many surfaces transposes records into columns.
//!
//! A triangle is *plain* if nothing varies over it. All its data is then in its own record and its material's. A light
//! has another record; its vertex normals only matter if they disagree on the front.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halfdome_kernel::{Triangle, offset_distance, triangle_normal};

use crate::light::{TrianglePart, area};
use crate::material::Kind;
use crate::scene::Material;

/// A triangle, with the data that most hits need in one cache line.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct TriangleRecord {
    pub(crate) corners: Triangle,
    /// Unit normal by the winding.
    pub(crate) normal: Vec3,
    /// The offset of ray origins from its plane.
    pub(crate) offset: f32,
    pub(crate) mesh: u32,
    pub(crate) material: u32,
    /// Whether it has neither vertex normals nor textures nor holes: 1, else 0.
    pub(crate) is_plain: u32,
}

/// The data of a material for plain triangles.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MaterialRecord {
    /// The albedo of diffuse reflection: if it is matte, all that it reflects, else about.
    pub(crate) diffuse: Vec3,
    /// The kind of its closure, [`Kind`] as a number.
    pub(crate) kind: u32,
    /// Radiance emitted, from the sides that emit.
    pub(crate) emission: Vec3,
    /// Whether both do: 1, else 0.
    pub(crate) emits_both_sides: u32,
}

/// A triangle that emits.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct EmitterRecord {
    pub(crate) corners: Triangle,
    /// Unit normal, on the side that emits if there is only one.
    pub(crate) normal: Vec3,
    /// The offset of ray origins from its plane.
    pub(crate) offset: f32,
    pub(crate) emission: Vec3,
    pub(crate) area: f32,
    /// Whether both sides emit: 1, else 0.
    pub(crate) emits_both_sides: u32,
    /// Whether it emits evenly, so that all there is to know is here: 1, else 0.
    pub(crate) is_plain: u32,
    unused: [u32; 5],
}

impl TriangleRecord {
    /// The same triangle elsewhere.
    pub(crate) fn with_corners(self, corners: Triangle) -> Self {
        let normal = triangle_normal(&corners);
        Self { corners, normal, offset: offset_distance(&corners, normal), ..self }
    }
}

impl MaterialRecord {
    /// The record of `material`.
    pub(crate) fn of(material: &Material) -> Self {
        let Material { emission, emits_both_sides, .. } = *material;
        let (diffuse, kind) = (material.mean_diffuse(), material.kind() as u32);
        Self { diffuse, kind, emission, emits_both_sides: emits_both_sides.into() }
    }

    /// Whether its closure is Lambert's.
    pub(crate) fn is_matte(&self) -> bool {
        self.kind == Kind::Matte as u32
    }
}

impl EmitterRecord {
    /// The value for lights of other kinds.
    pub(crate) const NONE: Self = Self {
        corners: [Vec3::ZERO; 3],
        normal: Vec3::ZERO,
        offset: 0.0,
        emission: Vec3::ZERO,
        area: 0.0,
        emits_both_sides: 0,
        is_plain: 0,
        unused: [0; 5],
    };

    /// The light that a part of a triangle of this material is, with the unit normal of its front if that is the same
    /// side everywhere.
    pub(crate) fn of(face: &TriangleRecord, part: &TrianglePart, front: Option<Vec3>, material: &Material) -> Self {
        let TriangleRecord { normal, offset, .. } = *face;
        let corners = part.corners(&face.corners);
        let area = area(&corners);
        let is_plain = front.is_some() && material.is_uniform() && !material.has_holes();
        let MaterialRecord { emission, emits_both_sides, .. } = MaterialRecord::of(material);
        let normal = front.unwrap_or(normal);
        Self { corners, normal, offset, emission, area, emits_both_sides, is_plain: is_plain.into(), ..Self::NONE }
    }
}
