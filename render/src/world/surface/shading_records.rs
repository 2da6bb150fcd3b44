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
use crate::scene::{Material, Mesh};

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
    /// Whether it has neither textures nor holes, nor vertex normals but its own: 1, else 0.
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
    /// Whether the vertex normals of a triangle, if it has any, are its own, `normal`: files often have some for flat
    /// faces too.
    pub(crate) fn is_flat(mesh: &Mesh, triangle: [u32; 3], normal: Vec3) -> bool {
        // Blender's exporter rounds normals to four digits.
        const ROUNDING: f32 = 2e-4;
        let is_close = |corner: u32| {
            let own = mesh.normals[corner as usize].normalize_or_zero();
            own.distance_squared(normal) < ROUNDING * ROUNDING
        };
        mesh.normals.is_empty() || triangle.into_iter().all(is_close)
    }

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

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::material::Inputs;
    use crate::scene::{CameraPose, Scene};
    use crate::world::World;

    /// Whether each triangle is plain of two that lean by 0.3 and have such vertex normals and this material.
    fn are_plain(normals: impl Fn(Vec3) -> [Vec3; 4], change: impl FnOnce(&mut Material, &mut Mesh)) -> [bool; 2] {
        let own = Vec3::new(-0.3, 0.0, 1.0).normalize();
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let mut mesh = Mesh {
            positions: corners.map(|(x, y)| Vec3::new(x, y, 0.3 * x)).to_vec(),
            normals: normals(own).to_vec(),
            texcoords: corners.map(|(x, y)| Vec2::new(x, y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let mut material = Material::matte(Vec3::splat(0.5));
        change(&mut material, &mut mesh);
        let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
        let scene = Scene { meshes: vec![mesh], materials: vec![material], camera: Some(camera), ..Scene::default() };
        let world = World::new(scene).unwrap();
        [0, 1].map(|face| world.triangle_records()[face].is_plain != 0)
    }

    /// As glTF's exporters write a normal.
    fn rounded(normal: Vec3) -> Vec3 {
        (normal * 1e4).round() / 1e4
    }

    #[test]
    fn flat_faces_are_plain_if_they_have_vertex_normals_too() {
        assert_eq!(are_plain(|own| [rounded(own); 4], |_, _| {}), [true; 2]);
        assert_eq!(are_plain(|own| [2.0 * own; 4], |_, _| {}), [true; 2]);
    }

    #[test]
    fn faces_that_curve_or_are_turned_over_are_not_plain() {
        let bent = |own: Vec3| [own, own, own, own + Vec3::X * 5e-4];
        assert_eq!(are_plain(bent, |_, _| {}), [true, false]);
        assert_eq!(are_plain(|own| [-own; 4], |_, _| {}), [false; 2]);
        assert_eq!(are_plain(|own| [own, own, Vec3::ZERO, own], |_, _| {}), [false; 2]);
    }

    #[test]
    fn what_varies_over_a_face_is_not_plain() {
        let colored = |material: &mut Material, mesh: &mut Mesh| {
            material.uses_vertex_colors = true;
            mesh.colors = vec![glam::Vec4::splat(0.3); 4];
        };
        assert_eq!(are_plain(|own| [own; 4], colored), [false; 2]);
        let brushed = |material: &mut Material, _: &mut Mesh| {
            material.inputs = Inputs { specular_anisotropy: 0.5, base_metalness: 1.0, ..Inputs::default() };
        };
        assert_eq!(are_plain(|own| [own; 4], brushed), [false; 2]);
        // A flag that formats set, without colours.
        assert_eq!(are_plain(|own| [own; 4], |material, _| material.uses_vertex_colors = true), [true; 2]);
    }
}
