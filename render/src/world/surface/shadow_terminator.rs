//! Shadow terminators: where a convex mesh has vertex normals, light arrives and leaves as at the round surface that
//! the normals describe.
//!
//! A light below the plane of a triangle may be above the plane of its vertex normals. The triangle's own plane would
//! cut off the light there, facet by facet, and the shadow terminator on a ball would be a staircase. So the side of a
//! surface is that of its vertex normal, and rays start at the point `p' = Σ wᵢ (p - min(0, (p - pᵢ)·nᵢ) nᵢ)`, which is
//! on or above the planes about its corners and so above the facets around (Hanika, "Hacking the Shadow Terminator",
//! Ray Tracing Gems II, 2021).
//!
//! The round surface of an object on a floor may extend below the floor. So a point is lifted at most half of the
//! distance to the next surface.
//!
//! Deviations: only the height of `p'` above the triangle is used; triangles that are not convex, whose normals deviate
//! by more than [`STEEPEST`], that emit or transmit light stay flat, as there a ray from such a point would hit its own
//! surface, or start on the wrong side.

use glam::Vec3;
use halfdome_kernel::{Ray, Triangle, triangle_normal};

use crate::material::bent_normal;
use crate::scene::{Material, Mesh};
use crate::world::{Hit, World};

/// The least cosine between a triangle and its vertex normals, of 30°.
const STEEPEST: f32 = 0.866;
/// The height of a corner above the plane of another's normal, relative to their distance, below which it counts as
/// rounding.
const MIN_SLOPE: f32 = 1e-4;
/// A height below this part of a ray's length is not visible, and needs no ray.
const UNSEEN: f32 = 1e-4;

/// The side on which the round surface of its vertex normals rises above a triangle: transforms preserve it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Convexity {
    /// On neither side, or the triangle is to stay flat.
    None,
    /// On the side of the normals.
    Front,
    /// On the other side.
    Back,
}

impl Convexity {
    /// The convexity of each triangle of a mesh.
    pub(crate) fn of_mesh<'a>(mesh: &'a Mesh, material: &Material) -> impl Iterator<Item = Self> + use<'a> {
        let can_round = !mesh.normals.is_empty() && material.is_opaque_and_dark();
        mesh.triangles.iter().enumerate().map(move |(face, triangle)| {
            if can_round {
                Self::of(&mesh.corners(face), triangle.map(|at| mesh.normals[at as usize]))
            } else {
                Self::None
            }
        })
    }

    fn of(corners: &Triangle, normals: [Vec3; 3]) -> Self {
        let cosines = normals.map(|corner| corner.normalize_or_zero().dot(triangle_normal(corners)));
        if !cosines.iter().all(|cosine| *cosine >= STEEPEST) && !cosines.iter().all(|cosine| *cosine <= -STEEPEST) {
            return Self::None;
        }
        let (mut is_convex, mut is_concave) = (true, true);
        for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            let edge = corners[j] - corners[i];
            let (height, least) = (edge.dot(normals[i]), MIN_SLOPE * edge.length());
            is_convex &= height <= least;
            is_concave &= height >= -least;
        }
        match (is_convex, is_concave) {
            (true, false) => Self::Front,
            (false, true) => Self::Back,
            _ => Self::None,
        }
    }
}

/// The height of the round surface above a point of a triangle, on its front and on its back; less than 0 where that is
/// flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TerminatorOffset {
    front: f32,
    back: f32,
}

impl TerminatorOffset {
    /// A flat triangle, or one that is to stay flat.
    pub(crate) const FLAT: Self = Self { front: -1.0, back: -1.0 };

    /// The heights above the point with these weights in a triangle. `normals` are the unit normals of its corners, on
    /// the side of its own.
    pub(crate) fn new(
        bulge: Convexity,
        corners: &Triangle,
        normal: Vec3,
        normals: [Vec3; 3],
        weights: [f32; 3],
    ) -> Self {
        let side = match bulge {
            Convexity::None => return Self::FLAT,
            Convexity::Front => 1.0,
            Convexity::Back => -1.0,
        };
        let point: Vec3 = (0..3).map(|i| weights[i] * corners[i]).sum();
        // The point's depth below each corner's plane, along the triangle's normal.
        let depth = |i: usize| (side * normals[i].dot(corners[i] - point)).max(0.0) * normals[i].dot(normal);
        let lift: f32 = (0..3).map(|i| weights[i] * depth(i)).sum::<f32>().max(0.0);
        if bulge == Convexity::Front { Self { front: lift, ..Self::FLAT } } else { Self { back: lift, ..Self::FLAT } }
    }

    /// Bounds the height on the round side, if any, by `free(height, side)`: the side is 1 for the front, -1 for the
    /// back.
    #[inline]
    pub(crate) fn below(self, free: impl FnOnce(f32, f32) -> f32) -> Self {
        let Self { front, back } = self;
        if front > 0.0 {
            Self { front: free(front, 1.0), back }
        } else if back > 0.0 {
            Self { front, back: free(back, -1.0) }
        } else {
            self
        }
    }

    /// The height on a side, if that is round.
    #[inline(always)]
    pub(crate) fn lift(self, is_back: bool) -> Option<f32> {
        let lift = if is_back { self.back } else { self.front };
        (lift >= 0.0).then_some(lift)
    }
}

impl World {
    /// The height by which a hit's `origin`, just above its triangle, may be lifted along the triangle's normal, given
    /// the obstacles along the smooth normal.
    pub(super) fn free_lift(&self, hit: &Hit, origin: Vec3, [normal, smooth]: [Vec3; 2], lift: f32) -> f32 {
        if hit.t.is_finite() && lift < UNSEEN * hit.t {
            return lift;
        }
        let offset = smooth * (lift / smooth.dot(normal).max(0.5));
        let other = self.intersect_at(&Ray { t_max: 1.0, ..Ray::new(origin, offset) }, hit.time);
        if other.is_hit() { 0.5 * other.t * lift } else { lift }
    }
}

/// The normal of a round surface as seen from `wo`, and the offset of ray origins: `offset` from the triangle, plus
/// `lift`.
#[inline]
pub(super) fn rounded(normal: Vec3, smooth: Vec3, wo: Vec3, (offset, lift): (f32, f32)) -> (Vec3, f32) {
    let round = bent_normal(normal, smooth, wo);
    (round, (offset + lift) / round.dot(normal).max(0.5))
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_1_PI;

    use glam::{Affine3A, vec3};
    use halfdome_kernel::Ray;

    use super::*;
    use crate::estimator::sample_direct;
    use crate::fixtures::{self, square, sun};
    use crate::light::SkyPart;
    use crate::material::Inputs;
    use crate::scene::{CameraPose, Instance, Object, Scene};
    use crate::settings::LightSampling;
    use crate::world::{Hit, World};

    const TO_SUN: Vec3 = Vec3::new(0.48, 0.64, 0.6);

    /// A ball of few facets, whose vertices have the normals of a ball.
    fn ball() -> Mesh {
        fixtures::ball([8, 12])
    }

    /// The ball under the sun, and another that does not matter; as an instance that is flattened and turned if
    /// `placed` says so.
    fn world(mesh: Mesh, material: Material, placed: Option<Affine3A>) -> World {
        let mesh = Mesh { object: placed.map(|_| 0), ..mesh };
        let mut scene = Scene {
            meshes: vec![mesh],
            materials: vec![material],
            lights: vec![sun(TO_SUN)],
            camera: Some(CameraPose { eye: Vec3::Z * 9.0, target: Vec3::ZERO, up: Vec3::Y, vfov: 30.0 }),
            ..Scene::default()
        };
        if let Some(to_world) = placed {
            scene.objects.push(Object::default());
            scene.instances.push(Instance { object: 0, to_world });
        }
        World::new(scene).unwrap()
    }

    /// The light of the sun at many points that are seen from afar, and the cosine with their shading normals.
    fn lit(world: &World) -> Vec<(f32, f32)> {
        let points = (0..2000).map(|i| {
            let (z, phi) = (1.0 - (i as f32 + 0.5) / 1000.0, 2.399_963 * i as f32);
            let from = 5.0 * vec3((1.0 - z * z).sqrt() * phi.cos(), z, (1.0 - z * z).sqrt() * phi.sin());
            let (ray, mut hits) = (Ray::between(from, Vec3::ZERO), [Hit::MISS]);
            world.intersect_many(&[ray], &mut hits);
            let surface = world.surface_at(&hits[0]).facing(ray.direction.normalize());
            let numbers = (0.5, 0.5);
            let how = (LightSampling::Direct, SkyPart::Sun);
            let found = sample_direct(world, &surface, &surface.white(), how, numbers).next();
            let free = found.filter(|light| !world.occluded(&light.ray));
            (free.map_or(0.0, |light| light.radiance.x), surface.shading_normal.dot(TO_SUN).max(0.0))
        });
        points.collect()
    }

    fn matte() -> Material {
        Material::matte(Vec3::ONE)
    }

    #[test]
    fn light_ends_where_it_would_on_a_round_surface() {
        let flattened = Affine3A::from_scale(vec3(1.0, 0.7, 1.2)) * Affine3A::from_rotation_x(1.0);
        for placed in [None, Some(flattened)] {
            for (light, cosine) in lit(&world(ball(), matte(), placed)) {
                assert!((light - FRAC_1_PI * cosine).abs() < 1e-5, "{light} for {cosine}, {placed:?}");
            }
        }
    }

    #[test]
    fn no_light_from_below_a_floor_reaches_what_stands_on_it() {
        let to_sun = vec3(0.3, 0.1, -0.9).normalize();
        let camera = Some(CameraPose { eye: Vec3::Z * 9.0, target: Vec3::ZERO, up: Vec3::Y, vfov: 30.0 });
        let (meshes, materials) = (vec![ball(), square(-0.8, true, 0)], vec![matte()]);
        let world =
            World::new(Scene { meshes, materials, lights: vec![sun(to_sun)], camera, ..Scene::default() }).unwrap();
        // From all around just above the floor.
        for i in 0..2000 {
            let phi = 2.399_963 * i as f32;
            let height = -0.8 + 1e-5 * (i as f32 + 0.5);
            let ray = Ray::between(vec3(5.0 * phi.cos(), 5.0 * phi.sin(), height), vec3(0.0, 0.0, height));
            let hit = world.intersect_at(&ray, 0.5);
            let surface = world.surface_at(&hit).facing(ray.direction.normalize());
            let shadow = Ray::new(surface.origin_towards(to_sun), to_sun);
            let is_lit = surface.normal.dot(to_sun) > 0.0 && !world.occluded(&shadow);
            assert!(!is_lit, "{} from {}", surface.position, shadow.origin);
        }
    }

    #[test]
    fn glass_lamps_and_flat_meshes_stay_flat() {
        let glass = Inputs { transmission_weight: 1.0, specular_weight: 1.0, ..Inputs::default() };
        let glowing = Material { emission: Vec3::ONE, ..matte() };
        let flat = Mesh { normals: Vec::new(), ..ball() };
        for (mesh, material) in [(ball(), Material { inputs: glass, ..matte() }), (ball(), glowing), (flat, matte())] {
            let world = world(mesh, material, None);
            let surface = world.surface(40, 0.3, 0.3);
            assert_eq!(surface.rounding, TerminatorOffset::FLAT);
            assert_eq!(surface.facing(-surface.normal).offset, surface.offset);
        }
    }

    #[test]
    fn the_convex_side_is_as_high_as_planes_at_corners_say() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let leaning =
            |lean: f32| corners.map(|corner| (Vec3::Z + lean * (2.0 * corner - Vec3::ONE).with_z(0.0)).normalize());
        let rounding = |normals: [Vec3; 3], weights| {
            TerminatorOffset::new(Convexity::of(&corners, normals), &corners, Vec3::Z, normals, weights)
        };
        let at = |lean: f32, weights| rounding(leaning(lean), weights);
        let corner = at(0.2, [1.0, 0.0, 0.0]);
        assert_eq!((corner.lift(false), corner.lift(true)), (Some(0.0), None));
        // Between two corners: each plane is 0.5 of the way times the slope above, along its own normal.
        let normal = leaning(0.2)[1];
        let expected = 0.5 * normal.x * normal.z;
        let half = at(0.2, [0.5, 0.5, 0.0]).lift(false).unwrap();
        assert!((half - expected).abs() < 0.02, "{half}, not about {expected}");
        let inside = at(-0.2, [0.5, 0.5, 0.0]);
        assert!(inside.lift(false).is_none() && inside.lift(true).unwrap() > 0.0, "{inside:?}");
        // All normals along the triangle's own; too steep; convex along one side and concave along another.
        assert_eq!(at(0.0, [0.5, 0.5, 0.0]), TerminatorOffset::FLAT);
        assert_eq!(at(1.0, [0.5, 0.5, 0.0]), TerminatorOffset::FLAT);
        let saddle = [vec3(-0.2, 0.2, 1.0), vec3(0.2, 0.2, 1.0), vec3(-0.2, -0.2, 1.0)].map(Vec3::normalize);
        assert_eq!(rounding(saddle, [0.5, 0.5, 0.0]), TerminatorOffset::FLAT);
    }
}
