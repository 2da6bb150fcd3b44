//! Surfaces: the world at a ray's hit.
//!
//! Most triangles are plain: all their data is in their [`TriangleRecord`] and their material. Vertex normals and
//! textures are looked up only for the others; see [`bsdf`](crate::bsdf) for closures.
//!
//! Functions on the hot path are force-inlined: a surface whose address is passed lives in memory, written in small
//! pieces and read in large ones, which is slow (failed store forwarding).

pub(super) mod closures;
pub(super) mod inputs;
pub(super) mod shading_records;
pub(super) mod shadow_terminator;

use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::{offset_distance, offset_point};

use super::hit::MIDDLE;
use super::{Convexity, Hit, InputChange, TerminatorOffset, TriangleRecord, World};
use crate::light::Receiver;
use crate::scene::{Material, MeshPoint};
use shadow_terminator::rounded;

/// The material of whatever measures light, or just scatters it.
pub(crate) static WHITE: LazyLock<Material> = LazyLock::new(|| Material::matte(Vec3::ONE));

/// The hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<'w> {
    pub position: Vec3,
    /// Unit normal of the triangle, on its front side.
    pub normal: Vec3,
    /// Unit normal by vertices, before normal maps tilt it.
    pub smooth_normal: Vec3,
    /// Unit normal by vertices and maps, on the same side as long as it can be.
    pub shading_normal: Vec3,
    /// Unit vector across it along which anisotropy is measured; zero where any will do.
    pub tangent: Vec3,
    /// Unit vector to where it is seen from, on the side of the normals once they [face](Self::facing) it.
    pub wo: Vec3,
    /// Albedo of diffuse reflection: here, if it is [matte](crate::material::Kind::Matte); else about.
    pub diffuse: Vec3,
    /// Radiance emitted here, from the sides that emit.
    pub emission: Vec3,
    /// The offset of ray origins from the triangle's plane, or from the point where it is [rounded](super::rounding).
    pub offset: f32,
    /// The offsets of the front and the back.
    pub rounding: TerminatorOffset,
    /// What the path changes in the material's inputs.
    pub change: InputChange,
    pub prim_id: u32,
    /// As [`Hit::instance`].
    pub instance: u32,
    /// Weights of the second and the third corner.
    pub barycentric: [f32; 2],
    /// When, as [`Hit::time`].
    pub time: f32,
    /// Whether the normals were turned: it is seen from behind, or from within.
    pub is_back: bool,
    /// Whether light from behind counts too, as its closure says, if anyone has asked.
    pub transmits: bool,
    pub material: &'w Material,
}

/// Data that varies over a triangle that is not plain.
struct Details {
    normal: Vec3,
    smooth_normal: Vec3,
    shading_normal: Vec3,
    tangent: Vec3,
    diffuse: Vec3,
    emission: Vec3,
    rounding: TerminatorOffset,
}

impl World {
    /// A small white surface at a point in space, which receives what a sensor with this unit normal would. Rays leave
    /// it as they would leave a triangle there that is as large as the scene.
    pub(crate) fn sensor(&self, position: Vec3, normal: Vec3) -> Surface<'_> {
        let bounds = self.bounds();
        let [b, c] = if bounds.is_empty() { [position; 2] } else { [bounds.min, bounds.max] };
        Surface {
            position,
            normal,
            smooth_normal: normal,
            shading_normal: normal,
            tangent: Vec3::ZERO,
            wo: normal,
            diffuse: Vec3::ONE,
            emission: Vec3::ZERO,
            offset: offset_distance(&[position, b, c], normal),
            rounding: TerminatorOffset::FLAT,
            change: InputChange::NONE,
            prim_id: Hit::NO_PRIM,
            instance: 0,
            barycentric: [0.0; 2],
            time: MIDDLE,
            is_back: false,
            transmits: false,
            material: &WHITE,
        }
    }

    /// The front of a triangle at barycentric coordinates, as if it were white: what it reflects is what it receives.
    pub(crate) fn receiver(&self, prim_id: u32, [u, v]: [f32; 2]) -> Surface<'_> {
        let surface = self.surface(prim_id, u, v);
        Surface { material: &WHITE, diffuse: Vec3::ONE, ..surface.facing(-surface.normal) }
    }

    /// The surface at a hit.
    #[inline(always)]
    pub(crate) fn surface_at(&self, hit: &Hit) -> Surface<'_> {
        let face = self.placed_record(hit);
        self.surface_of(&face, hit)
    }

    /// The surface at barycentric coordinates of a triangle that is in world space, in the middle of the shutter's
    /// time.
    #[inline(always)]
    pub(crate) fn surface(&self, prim_id: u32, u: f32, v: f32) -> Surface<'_> {
        self.surface_of(&self.triangle_records[prim_id as usize], &Hit { prim_id, u, v, ..Hit::MISS })
    }

    /// The surface at a hit with a triangle that has this record.
    #[inline(always)]
    fn surface_of(&self, face: &TriangleRecord, hit: &Hit) -> Surface<'_> {
        let Hit { prim_id, u, v, .. } = *hit;
        let weights = [1.0 - u - v, u, v];
        let material = &self.materials[face.material as usize];
        let record = &self.material_records[face.material as usize];
        let mut surface = Surface {
            position: interpolate(face.corners, weights),
            normal: face.normal,
            smooth_normal: face.normal,
            shading_normal: face.normal,
            tangent: Vec3::ZERO,
            wo: face.normal,
            diffuse: record.diffuse,
            emission: record.emission,
            offset: face.offset,
            rounding: TerminatorOffset::FLAT,
            change: InputChange::NONE,
            prim_id,
            instance: hit.instance,
            barycentric: [u, v],
            time: hit.time,
            is_back: false,
            transmits: false,
            material,
        };
        if face.is_plain == 0 {
            // Field by field, or the compiler would keep every surface in memory instead of in registers.
            let details = self.details(face, hit, weights);
            surface.normal = details.normal;
            surface.smooth_normal = details.smooth_normal;
            surface.shading_normal = details.shading_normal;
            surface.tangent = details.tangent;
            surface.diffuse = details.diffuse;
            surface.emission = details.emission;
            surface.rounding = details.rounding;
        }
        surface
    }

    /// Data of vertices and textures.
    #[inline(never)]
    fn details(&self, face: &TriangleRecord, hit: &Hit, weights: [f32; 3]) -> Details {
        let normal = face.normal;
        let material = self.triangle_records[hit.prim_id as usize].material;
        let turn = self.instance_records().and_then(|_| self.turn_at(hit));
        let point = MeshPoint { turn, ..self.mesh_point(hit.prim_id, weights) };
        let (record, material) = (&self.material_records[material as usize], &self.materials[material as usize]);
        let interpolated = if point.mesh.normals.is_empty() {
            normal
        } else {
            let own = interpolate(point.corners(&point.mesh.normals), weights);
            point.turn.map_or(own, |turn| turn.normal(own))
        };
        let frame = material.frame_at(&point, interpolated);
        // A model's own normals say which side is the front, whatever the winding.
        let is_turned = normal.dot(interpolated) < 0.0;
        let normal = if is_turned { -normal } else { normal };
        let bulge = self.bulges[hit.prim_id as usize];
        let rounding = if bulge == Convexity::None {
            TerminatorOffset::FLAT
        } else {
            let corner = |own: Vec3| point.turn.map_or(own, |turn| turn.normal(own)).normalize_or(normal);
            TerminatorOffset::new(bulge, &face.corners, normal, point.corners(&point.mesh.normals).map(corner), weights)
                .below(|lift, side| {
                    let [normal, smooth] = [normal, interpolated.normalize_or(normal)].map(|it| side * it);
                    let origin = offset_point(interpolate(face.corners, weights), normal, face.offset, normal);
                    self.free_lift(hit, origin, [normal, smooth], lift)
                })
        };
        Details {
            normal,
            smooth_normal: match material.tilts_normals() {
                true => interpolated.normalize_or(frame.normal),
                false => frame.normal,
            },
            shading_normal: frame.normal,
            tangent: frame.tangent,
            diffuse: match record.is_matte() {
                true if material.unlit => Vec3::ZERO,
                true => material.inputs_at(&point).base_color,
                false => record.diffuse,
            },
            emission: material.emission_at(&point),
            rounding,
        }
    }

    /// A point of a triangle, as materials look it up.
    pub(super) fn mesh_point(&self, prim_id: u32, weights: [f32; 3]) -> MeshPoint<'_> {
        let mesh = &self.meshes[self.triangle_records[prim_id as usize].mesh as usize];
        MeshPoint { textures: &self.textures, mesh, triangle: self.index_in_mesh(prim_id), weights, turn: None }
    }

    /// Texture coordinates at a hit, or the barycentric ones if the mesh has none.
    pub(crate) fn texcoord(&self, hit: &Hit) -> Vec2 {
        let mesh = &self.meshes[self.triangle_records[hit.prim_id as usize].mesh as usize];
        if mesh.texcoords.is_empty() {
            return Vec2::new(hit.u, hit.v);
        }
        let [a, b, c] = mesh.triangles[self.index_in_mesh(hit.prim_id)];
        let at = |corner: u32| mesh.texcoords[corner as usize];
        at(a) * (1.0 - hit.u - hit.v) + at(b) * hit.u + at(c) * hit.v
    }
}

/// The sum of values at corners by barycentric weights.
#[inline(always)]
pub(crate) fn interpolate(values: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}

impl Surface<'_> {
    /// The origin of a ray that leaves in `direction`.
    #[inline(always)]
    pub(crate) fn origin_towards(&self, direction: Vec3) -> Vec3 {
        offset_point(self.position, self.normal, self.offset, direction)
    }

    /// The end of a ray from `point` to this surface, just before a hit. Its test has errors of the last place at the
    /// distance of `point`, which are more than those of a ray that leaves.
    #[inline(always)]
    pub(crate) fn end_from(&self, point: Vec3) -> Vec3 {
        const ERROR: f32 = 8.0 / (1u32 << 24) as f32;
        let back = point - self.position;
        let distance = ERROR * back.abs().max_element() * self.normal.abs().element_sum();
        offset_point(self.position, self.normal, self.offset + distance, back)
    }

    /// The same surface with its normals on the side from which a ray in `direction` comes.
    #[inline(always)]
    pub(crate) fn facing(self, direction: Vec3) -> Self {
        let is_behind = self.normal.dot(direction) > 0.0;
        let side = if is_behind { -1.0 } else { 1.0 };
        let (normal, smooth_normal) = (self.normal * side, self.smooth_normal * side);
        let (normal, offset) = match self.rounding.lift(is_behind) {
            None => (normal, self.offset),
            Some(lift) => rounded(normal, smooth_normal, -direction, (self.offset, lift)),
        };
        Self {
            normal,
            smooth_normal,
            shading_normal: self.shading_normal * side,
            wo: -direction,
            offset,
            rounding: TerminatorOffset::FLAT,
            is_back: self.is_back != is_behind,
            ..self
        }
    }

    /// The same surface without what maps do to its normals.
    pub(crate) fn smooth(self) -> Self {
        Self { shading_normal: self.smooth_normal, ..self }
    }

    /// The receiver for the choice of lights.
    #[inline(always)]
    pub(crate) fn receiver(&self) -> Receiver {
        Receiver::new(self.position, self.shading_normal, self.transmits)
    }

    /// The frame about the shading normal.
    #[inline(always)]
    pub(crate) fn frame(&self) -> Frame {
        Frame::from_normal(self.shading_normal)
    }

    /// Radiance emitted towards the origin of a ray in `direction`.
    #[inline(always)]
    pub(crate) fn emitted(&self, direction: Vec3) -> Vec3 {
        if self.emits_towards(direction) { self.emission } else { Vec3::ZERO }
    }

    /// Whether the origin of a ray in `direction` is on a side that emits.
    #[inline(always)]
    pub(crate) fn emits_towards(&self, direction: Vec3) -> bool {
        self.material.emits_both_sides | (self.normal.dot(direction) < 0.0)
    }
}
