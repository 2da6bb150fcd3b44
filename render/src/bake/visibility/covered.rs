//! Covered texels: a point inside another body, such as on a floor under a crate, sees only the backs of surfaces.
//! Light from there would bleed out of the crate's foot, so it is taken from a free point of the same texel and chart;
//! where there is none, the texel is left out, and is filled later from others of its chart.
//!
//! Castaño detects such texels by the backs in a hemicube. Here rays spread evenly over the hemisphere detect them.
//! [`Bodies`] of the world defines what a body is.

use glam::Vec2;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use rayon::prelude::*;

use crate::bake::layout::texels::{Point, Surfaces, Texel};
use crate::world::{Bodies, Hit, World};

/// Rays of a point.
const RAYS: u32 = 32;
/// A point is covered if more than this part of its rays ends on the back of something.
const BACKS: f32 = 0.5;
/// The side of the grid on which free points of a covered texel are sought.
const GRID: u32 = 8;

/// The treatment of covered texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Uncovered {
    /// They have another point.
    pub(crate) moved: u64,
    /// They have none.
    pub(crate) lost: u64,
}

/// Moves covered texels to free points of their charts; gives for each texel whether it has one.
pub(crate) fn uncover(world: &World, surfaces: &Surfaces, texels: &mut [Texel]) -> (Vec<bool>, Uncovered) {
    let bodies = world.bodies();
    let outcome: Vec<Option<bool>> = texels
        .par_chunks_mut(64)
        .flat_map_iter(|texels| {
            let points: Vec<Point> = texels.iter().map(|texel| texel.point).collect();
            let covered = are_covered(world, &bodies, &points);
            let settle = |(texel, covered): (&mut Texel, bool)| {
                if !covered {
                    return None;
                }
                let others = surfaces.points_within(texel, GRID);
                let free = are_covered(world, &bodies, &others).into_iter().position(|covered| !covered);
                if let Some(free) = free {
                    (texel.point, texel.is_moved) = (others[free], true);
                }
                Some(free.is_some())
            };
            texels.iter_mut().zip(covered).map(settle).collect::<Vec<_>>()
        })
        .collect();
    let number = |state| outcome.iter().filter(|outcome| **outcome == state).count() as u64;
    let uncovered = Uncovered { moved: number(Some(true)), lost: number(Some(false)) };
    (outcome.into_iter().map(|outcome| outcome.unwrap_or(true)).collect(), uncovered)
}

/// Whether each point sees backs for the most part.
fn are_covered(world: &World, bodies: &Bodies, points: &[Point]) -> Vec<bool> {
    let rays: Vec<Ray> = points
        .iter()
        .flat_map(|point| {
            let surface = world.receiver(point.prim_id, point.barycentric);
            // The same pattern everywhere, turned with the frame.
            (0..RAYS).map(move |ray| {
                let u: Vec2 = Sampler::new(Pattern::Sobol, 0, 0, ray).uniform2(0);
                let direction = surface.frame().to_world(CosineHemisphere.map(u));
                // A shading normal may point a ray into the surface itself.
                let leaves = surface.normal.dot(direction) > 0.0;
                let t_max = if leaves { f32::INFINITY } else { -1.0 };
                Ray { t_max, ..Ray::new(surface.origin_towards(surface.normal), direction) }
            })
        })
        .collect();
    let mut hits = vec![Hit::MISS; rays.len()];
    world.intersect_many(&rays, &mut hits);
    let is_back = |(ray, hit): (&Ray, &Hit)| hit.is_hit() && bodies.is_back(world, ray, hit);
    let count = RAYS as usize;
    let backs = rays.chunks(count).zip(hits.chunks(count));
    backs
        .map(|(rays, hits)| rays.iter().zip(hits).filter(|&pair| is_back(pair)).count() as f32 > BACKS * RAYS as f32)
        .collect()
}
