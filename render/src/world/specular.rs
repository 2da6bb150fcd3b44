//! Specular connections: smooth faces between a surface and a light that no bounce can be relied on to hit.
//!
//! Light of points, spots and suns, those of sky pictures too, that reaches a scattering surface through smooth glass, or
//! from a mirror, is found by light samples alone: rays cannot hit delta lights, and for lights with a size bounces are
//! used only for gloss that sees them in mirrors or behind [panes](panes). Where the two faces of a solid are parallel, as
//! in a window, light leaves in its old direction, and a straight shadow ray finds it. Light that is refracted by balls,
//! bottles and water, or reflected, arrives from another direction, which [manifold exploration](manifold) finds.
//!
//! The flux through a plane also crosses any parallel plane. Paths carry basic radiance, `L / n²`, so entering or
//! leaving a solid needs no factor `n²`.
//!
//! Deviations: rough faces are no part of a connection, and neither are reflections by faces with a normal map. A
//! connection has one reflection at most.

mod chain;
mod manifold;
mod panes;
mod photons;

use glam::{Mat2, Vec2, Vec3};
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{Ray, Triangle};

use super::surface::interpolate;
use super::{Hit, Surface, TriangleRecord, World};
use crate::material::Inputs;
use crate::material::fresnel::Dielectric;
use crate::material::ggx::Ggx;
use crate::scene::Material;
pub(crate) use chain::LightEnd;
pub(crate) use manifold::SpecularConnection;
pub(crate) use panes::glass_tree::{GlassTree, Pane};
use photons::Photons;
pub(crate) use photons::{LightInMirrors, Start, Starts};

/// The most faces that a connection to a light may have.
const MAX_FACES: usize = 16;

/// The least cosine, of 0.06°, between directions of light that a pane has not bent.
const MIN_STRAIGHT_COS: f32 = 1.0 - 5e-7;

/// The smooth faces between surfaces and lights that bounces cannot hit.
#[derive(Debug)]
pub(super) struct Specular {
    /// By material, whether it transmits light; empty if none does.
    transmits: Vec<bool>,
    /// By material, whether it reflects light as a mirror does; empty if none does, or if there are no such lights.
    mirrors: Vec<bool>,
    /// The bounds of all surfaces that transmit.
    bounds: Aabb,
    /// Those that stand still, and whether these are all.
    glass: Option<GlassTree>,
    is_all_glass_still: bool,
    /// Light that is refracted, and light that is reflected once.
    refracted: Photons,
    reflected: Photons,
}

impl Specular {
    /// The smooth faces among the triangles of `records`. The first ones have these `corners`; the positions of the others are
    /// unknown. `has_narrow` says whether there are points, spots or suns.
    pub(super) fn new(
        materials: &[Material],
        records: &[TriangleRecord],
        corners: &[Triangle],
        has_narrow: bool,
    ) -> Self {
        let mut specular = Self {
            transmits: materials.iter().map(Material::is_glass).collect(),
            mirrors: materials.iter().map(Material::is_mirror).collect(),
            bounds: Aabb::EMPTY,
            glass: None,
            is_all_glass_still: false,
            refracted: Photons::default(),
            reflected: Photons::default(),
        };
        let among = |kind: &[bool]| records.iter().any(|record| kind[record.material as usize]);
        if !has_narrow || !among(&specular.mirrors) {
            specular.mirrors.clear();
        }
        if !among(&specular.transmits) {
            specular.transmits.clear();
            return specular;
        }
        let is_glass = |record: &TriangleRecord| specular.transmits[record.material as usize];
        let placed = corners.iter().zip(records).filter(|(_, record)| is_glass(record));
        let bounds = placed.fold(Aabb::EMPTY, |all, (corners, _)| all.union(&Aabb::around(corners)));
        let is_known = !records[corners.len()..].iter().any(is_glass);
        let everywhere = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
        specular.bounds = if is_known { bounds } else { everywhere };
        specular
    }

    /// Adds the glass that stands still among all triangles.
    pub(super) fn set_glass(&mut self, glass: Option<GlassTree>, all: &[TriangleRecord]) {
        let transmits = |record: &&TriangleRecord| self.transmits.get(record.material as usize) == Some(&true);
        self.is_all_glass_still = glass.as_ref().map_or(0, GlassTree::count) == all.iter().filter(transmits).count();
        self.glass = glass;
    }

    /// Whether a ray is known to meet no glass.
    fn misses_glass(&self, ray: &Ray) -> bool {
        self.is_all_glass_still && self.glass.as_ref().is_none_or(|glass| !glass.is_met(ray))
    }

    /// Whether a ray may meet glass, rounding included.
    fn may_meet(&self, ray: &Ray) -> bool {
        let margin = 1e-4 * (self.bounds.max.abs().max(self.bounds.min.abs()).max_element() + ray.origin.length());
        let [a, b] = [self.bounds.min - margin, self.bounds.max + margin].map(|at| (at - ray.origin) / ray.direction);
        let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element().min(ray.t_max));
        // True for NaN.
        near <= far || near.is_nan() || far.is_nan()
    }
}

/// The glass between a surface and a light.
pub(crate) enum Between {
    /// No glass; the shadow ray finds opaque occluders.
    NoGlass,
    /// Panes.
    Panes {
        /// The part of the shadow ray beyond them.
        rest: Ray,
        transmittance: Vec3,
        /// Whether they do not bend light at all.
        are_exact: bool,
    },
    /// Glass that refracts light.
    Bends,
}

/// A smooth face that a ray has hit.
struct Face<'w> {
    /// The surface, facing the ray's origin.
    surface: Surface<'w>,
    /// The ray's hit.
    hit: Hit,
    /// The transmission tint; zero if nothing is transmitted.
    tint: Vec3,
    is_thin: bool,
    /// Absorption coefficient of the solid behind the front.
    absorption: Vec3,
    ior: f32,
    /// Fresnel's reflectance from outside.
    fresnel: Dielectric,
}

impl Face<'_> {
    /// The face's reflectance and the cosine inside, for the cosine outside. Reflectance is the greatest of the three
    /// channels, and transmittance is 1 minus it, as in the glass closure.
    fn at(&self, cos_outside: f32) -> (f32, f32) {
        let (reflected, cos_inside) = self.fresnel.at(cos_outside);
        (reflected.max_element(), cos_inside)
    }

    /// The transmittance of a thin wall, all inner reflections summed.
    fn thin_wall_transmittance(&self, cos: f32) -> Vec3 {
        let (reflected, _) = self.at(cos);
        self.tint * ((1.0 - reflected) / (1.0 + reflected))
    }
}

impl World {
    /// Whether there is clear glass.
    #[inline(always)]
    pub(crate) fn has_clear_glass(&self) -> bool {
        !self.specular.transmits.is_empty()
    }

    /// Whether the surface that was hit may be clear glass.
    #[inline(always)]
    pub(crate) fn is_clear_glass(&self, hit: &Hit) -> bool {
        self.has_clear_glass()
            && hit.is_hit()
            && self.specular.transmits[self.triangle_records[hit.prim_id as usize].material as usize]
    }

    /// The glass among which are panes, through which light samples and bounces go straight.
    #[inline(always)]
    pub(crate) fn panes(&self) -> Option<&GlassTree> {
        self.specular.glass.as_ref().filter(|glass| glass.has_panes)
    }

    /// Whether there are mirrors that show lights to other surfaces.
    #[inline(always)]
    pub(crate) fn has_reflected_light(&self) -> bool {
        !self.specular.reflected.is_empty()
    }

    /// The nearest surface along a ray, if it is smooth glass.
    fn face(&self, ray: &Ray, time: f32) -> Option<Face<'_>> {
        if !self.has_clear_glass() || !self.specular.may_meet(ray) {
            return None;
        }
        let hit = self.intersect_at(ray, time);
        if !self.is_clear_glass(&hit) {
            return None;
        }
        Some(self.face_at(hit, ray.direction)).filter(|face| face.tint != Vec3::ZERO)
    }

    /// The nearest surface along a ray, if it may be a mirror.
    fn mirror_face(&self, ray: &Ray, time: f32) -> Option<Face<'_>> {
        let hit = self.intersect_at(ray, time);
        self.is_mirror(&hit).then(|| self.face_at(hit, ray.direction))
    }

    /// Whether the surface that was hit may show lights to others.
    fn is_mirror(&self, hit: &Hit) -> bool {
        let mirrors = &self.specular.mirrors;
        !mirrors.is_empty() && hit.is_hit() && mirrors[self.triangle_records[hit.prim_id as usize].material as usize]
    }

    /// The face that a ray in this direction has hit.
    fn face_at(&self, hit: Hit, direction: Vec3) -> Face<'_> {
        let surface = self.surface_at(&hit).facing(direction);
        let inputs = self.inputs(&surface);
        let is_smooth = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy).is_delta();
        let weight = if is_smooth { inputs.transmission_weight * (1.0 - inputs.base_metalness) } else { 0.0 };
        let Inputs { specular_ior: ior, specular_weight, specular_color, .. } = inputs;
        Face {
            surface,
            hit,
            tint: weight * inputs.transmission_color,
            is_thin: inputs.thin_walled,
            absorption: inputs.absorption,
            ior,
            fresnel: Dielectric::new(ior, false, specular_weight, specular_color),
        }
    }

    /// The part of light that a face reflects as a mirror.
    fn mirror_reflectance(&self, face: &Face) -> Vec3 {
        let mut surface = face.surface.smooth();
        self.scattering(&mut surface).mirror_reflectance()
    }

    /// Whether a face's shading normal is constant over its triangle.
    fn is_flat(&self, face: &Face) -> bool {
        let Surface { prim_id, barycentric: [u, v], .. } = face.surface;
        let point = self.mesh_point(prim_id, [1.0 - u - v, u, v]);
        point.mesh.normals.is_empty() || {
            let [a, b, c] = point.corners(&point.mesh.normals);
            a == b && b == c
        }
    }

    /// The derivative of a face's shading normal across its triangle.
    fn normal_derivative(&self, face: &Face) -> NormalDerivative {
        if self.is_flat(face) {
            return NormalDerivative::default();
        }
        let corners = self.placed_record(&face.hit).corners;
        let Hit { prim_id, u, v, .. } = face.hit;
        let weights = [1.0 - u - v, u, v];
        let point = self.mesh_point(prim_id, weights);
        let turn = self.instance_records().and_then(|_| self.turn_at(&face.hit));
        let normals = point.corners(&point.mesh.normals).map(|own| turn.map_or(own, |turn| turn.unscaled_normal(own)));
        let (sum, normal) = (interpolate(normals, weights), face.surface.smooth_normal);
        // The derivative of the normalised sum: the part across the normal, divided by the sum's length.
        let by = |change: Vec3| (change - normal * normal.dot(change)) / sum.dot(normal);
        let [along_u, along_v] = [1, 2].map(|corner| corners[corner] - corners[0]);
        let [by_u, by_v] = [1, 2].map(|corner| by(normals[corner] - normals[0]));
        let dot = along_u.dot(along_v);
        let gram = Mat2::from_cols_array(&[along_u.length_squared(), dot, dot, along_v.length_squared()]);
        NormalDerivative { weights: gram.inverse(), along: [along_u, along_v], by: [by_u, by_v] }
    }
}

/// The derivative of a shading normal across a triangle.
#[derive(Default)]
struct NormalDerivative {
    /// Turns the dot products of a step with two sides into the change of two corner weights.
    weights: Mat2,
    along: [Vec3; 2],
    /// The normal's derivatives by two corner weights.
    by: [Vec3; 2],
}

impl NormalDerivative {
    /// The normal's change for a step across the triangle.
    fn at(&self, way: Vec3) -> Vec3 {
        let weights = self.weights * Vec2::new(self.along[0].dot(way), self.along[1].dot(way));
        self.by[0] * weights.x + self.by[1] * weights.y
    }
}

/// The rest of a ray behind a surface that it has hit.
fn beyond(ray: &Ray, surface: &Surface) -> Ray {
    let origin = surface.origin_towards(ray.direction);
    let t = (origin - ray.origin).dot(ray.direction) / ray.direction.length_squared();
    Ray { origin, t_min: 0.0, t_max: ray.t_max - t, ..*ray }
}
