//! The surfaces of AOVs: the first surface along a camera ray, or those seen through it.
//!
//! The albedo and normal of a mirror or clear glass do not help a denoiser: the visible surfaces are those behind. So
//! mirrors and clear glass are followed. At the first such surface both reflection and transmission are followed, and
//! blended by their light (Fresnel); after that only the greater one. Nothing is random: a closure is sampled at fixed
//! numbers, and where most of it is a delta function, its directions and weights are known exactly.
//!
//! Source: the manual of Intel's Open Image Denoise 2, "Albedos" and "Normals", which recommends just that.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;

use crate::film::Features;
use crate::world::{Hit, World};

/// Mirrors and panes of glass that are looked through, one behind the other.
const MAX_BOUNCES: u32 = 8;
/// Fixed numbers at which a closure is sampled: lobes with a smaller probability are left out.
const PROBES: u32 = 16;
/// Directions that differ by less than this are one.
const SAME_DIRECTION: f32 = 1e-6;

/// A delta function of a closure: where it leads, and how much light comes from there.
#[derive(Clone, Copy)]
struct Branch {
    direction: Vec3,
    weight: Vec3,
}

/// The features of the first surface.
pub(super) fn first(world: &World, ray: &Ray, hit: &Hit) -> Features {
    if !hit.is_hit() {
        return Features::default();
    }
    let surface = world.surface_at(hit);
    Features {
        albedo: world.scattering(&mut surface.facing(ray.direction)).albedo(),
        position: surface.position,
        normal: surface.normal,
        shading_normal: surface.shading_normal,
        uv: world.texcoord(hit),
    }
}

/// The features of the surfaces seen through the first one, if it is a mirror or clear glass; with tinted albedos.
pub(super) fn through(world: &World, ray: &Ray, hit: &Hit) -> Features {
    follow(world, ray, hit, 0)
}

fn follow(world: &World, ray: &Ray, hit: &Hit, bounce: u32) -> Features {
    if !hit.is_hit() || bounce == MAX_BOUNCES {
        return first(world, ray, hit);
    }
    let mut surface = world.surface_at(hit).facing(ray.direction);
    let Some(mut branches) = branches(world, &mut surface) else { return first(world, ray, hit) };
    if bounce > 0 && branches[1].weight.element_sum() > branches[0].weight.element_sum() {
        branches.swap(0, 1);
    }
    let total = match bounce {
        0 => branches[0].weight.element_sum() + branches[1].weight.element_sum(),
        _ => branches[0].weight.element_sum(),
    };
    let mut sum = Features::default();
    for Branch { direction, weight } in branches.into_iter().take(if bounce == 0 { 2 } else { 1 }) {
        if weight == Vec3::ZERO {
            continue;
        }
        let (ray, mut hits) = (Ray::new(surface.origin_towards(direction), direction), [Hit::MISS]);
        world.intersect_many_at(&[ray], &[hit.time], &mut hits);
        let seen = follow(world, &ray, &hits[0], bounce + 1);
        let share = weight.element_sum() / total;
        sum.albedo += weight * seen.albedo;
        sum.position += share * seen.position;
        sum.normal += share * seen.normal;
        sum.shading_normal += share * seen.shading_normal;
        sum.uv += share * seen.uv;
    }
    sum
}

/// The two delta functions of a closure, the second perhaps with the weight 0; `None` if it has other lobes.
fn branches(world: &World, surface: &mut crate::world::Surface) -> Option<[Branch; 2]> {
    let scattering = world.scattering(surface);
    let none = Branch { direction: Vec3::Z, weight: Vec3::ZERO };
    let mut branches = [none; 2];
    let mut deltas = 0;
    for probe in 0..PROBES {
        let Some(bounce) = scattering.sample(Vec2::new((probe as f32 + 0.5) / PROBES as f32, 0.5)) else { continue };
        if bounce.density.is_finite() {
            // A quarter of diffuse light is enough to be seen.
            if 4 * (probe + 1 - deltas) > PROBES {
                return None;
            }
            continue;
        }
        deltas += 1;
        let same = |branch: &&mut Branch| {
            branch.weight == Vec3::ZERO || (branch.direction - bounce.direction).length_squared() < SAME_DIRECTION
        };
        if let Some(branch) = branches.iter_mut().find(same) {
            branch.direction = bounce.direction;
            branch.weight += bounce.weight / PROBES as f32;
        }
    }
    (deltas > 0).then_some(branches)
}
