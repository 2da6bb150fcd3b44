//! Viewpoints inside a level's rooms.
//!
//! A viewpoint is inside if at most a fifth of its rays, passing through glass, hit nothing (at the foot of an outer
//! wall a quarter do), and at most half hit backs of bodies. The search begins with given positions, which may be open,
//! or with positions in front of surfaces whose surroundings are not narrow beside the widest; from each viewpoint the
//! next are sought along its rays, until they are as close as a third of the distance to the surroundings.

use std::ops::Range;

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{UniformSphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use rayon::prelude::*;

use crate::settings::Invalid;
use crate::world::{Bodies, Hit, Side, World};

/// Rays by which a viewpoint is judged.
pub(super) const RAYS: u32 = 256;
/// The greatest part of rays without a hit at a viewpoint inside.
const OPEN: f32 = 0.2;
/// At most this part of them end on backs.
const BACKS: f32 = 0.5;
/// Viewpoints lie so far apart, as a part of the harmonic mean of distances, ...
const SPACING: f32 = 0.35;
/// ... which counts as no less than this part of the greatest: there is no end to the viewpoints in a corner.
const MIN_DISTANCE: f32 = 0.3;
/// How much narrower than the widest the first ones may be: a gap below a floor is no room.
const NARROW: f32 = 1.0 / 12.0;
/// Positions that are tried from each.
const STEPS: u32 = 16;
/// The most viewpoints.
const MAX_VIEWPOINTS: usize = 4096;
/// Panes of glass that are looked through, one behind the other.
const MAX_PANES: usize = 16;

/// The surroundings of a position.
pub(super) struct Viewpoint {
    pub(super) position: Vec3,
    /// The harmonic mean of distances.
    distance: f32,
    /// Directions of rays, and the distances of what they meet first, glass included.
    rays: Vec<(Vec3, f32)>,
    /// Whether too many rays reach nothing.
    is_open: bool,
    /// Whether too many end on backs of bodies.
    is_covered: bool,
}

/// A hit of one of many rays.
pub(super) struct Seen<'a> {
    /// The ray's index.
    ray: usize,
    /// The panes of glass before it.
    panes: usize,
    pub(super) hit: &'a Hit,
    /// Whether it is on the back of a body.
    is_back: bool,
}

/// Looks around in a world.
pub(super) struct Search<'a> {
    world: &'a World,
    bodies: Bodies,
}

impl<'a> Search<'a> {
    pub(super) fn new(world: &'a World) -> Self {
        Self { world, bodies: world.bodies() }
    }

    /// Viewpoints that can be reached from these positions.
    pub(super) fn known(&self, positions: &[Vec3]) -> Result<Vec<Viewpoint>, Invalid> {
        let look = |&position: &Vec3| {
            let Vec3 { x, y, z } = position;
            let problem =
                || format!("the position {x},{y},{z} is not inside a room: its rays hit nothing, or back faces");
            let seen = self.look(position, 0).filter(|seen| !seen.is_covered);
            seen.ok_or_else(|| Invalid::new(problem(), "name a place in a room: --skip-outside=X,Y,Z"))
        };
        Ok(self.reach(positions.iter().map(look).collect::<Result<Vec<Viewpoint>, Invalid>>()?))
    }

    /// Viewpoints that can be reached from the fronts of surfaces; where there are none, from their backs.
    pub(super) fn anywhere(&self) -> Result<Vec<Viewpoint>, Invalid> {
        let begin = |side| {
            let first = self.look_from_all(&self.starts(side), |_| true);
            let widest = first.iter().map(|it| it.distance).fold(0.0, f32::max);
            self.reach(first.into_iter().filter(|it| it.distance >= NARROW * widest))
        };
        let mut found = [Side::Front, Side::Back].into_iter().map(begin);
        found.find(|found| !found.is_empty()).ok_or_else(|| {
            Invalid::new(
                "nothing can be left out, as no place is inside: more than a fifth of all rays from any reach nothing",
                "leave --skip-outside out, or name a place in a room: --skip-outside=X,Y,Z",
            )
        })
    }

    /// These viewpoints, and those that can be reached from them, spread evenly.
    fn reach(&self, new: impl IntoIterator<Item = Viewpoint>) -> Vec<Viewpoint> {
        let (mut viewpoints, mut widest) = (Vec::<Viewpoint>::new(), 0.0f32);
        let mut new: Vec<Viewpoint> = new.into_iter().collect();
        while !new.is_empty() && viewpoints.len() < MAX_VIEWPOINTS {
            let first = viewpoints.len();
            widest = new.iter().map(|it| it.distance).fold(widest, f32::max);
            let spacing = |distance: f32| SPACING * distance.max(MIN_DISTANCE * widest);
            for it in new {
                let is_apart =
                    |other: &Viewpoint| other.position.distance(it.position) > spacing(it.distance.min(other.distance));
                if viewpoints.len() < MAX_VIEWPOINTS && viewpoints.iter().all(is_apart) {
                    viewpoints.push(it);
                }
            }
            let positions = Self::next(&viewpoints, first..viewpoints.len());
            // Most are too close to a viewpoint that is known, whatever is around them.
            new = self.look_from_all(&positions, |position| {
                viewpoints.iter().all(|it| it.position.distance(position) > 0.5 * spacing(it.distance))
            });
        }
        viewpoints
    }

    /// The surroundings of the positions that are of interest and inside.
    fn look_from_all(&self, positions: &[Vec3], is_of_interest: impl Fn(Vec3) -> bool + Sync) -> Vec<Viewpoint> {
        let look = |(number, &position): (usize, &Vec3)| {
            let found = is_of_interest(position).then(|| self.look(position, number as u32)).flatten();
            found.filter(|it| !it.is_open && !it.is_covered)
        };
        let looked: Vec<Option<Viewpoint>> = positions.par_iter().enumerate().map(look).collect();
        looked.into_iter().flatten().collect()
    }

    /// Positions beside surfaces, halfway to the next.
    fn starts(&self, side: Side) -> Vec<Vec3> {
        let rays = self.world.rays_from_surfaces(side);
        let mut hits = vec![Hit::MISS; rays.len()];
        self.world.intersect_many(&rays, &mut hits);
        let half = |(ray, hit): (&Ray, &Hit)| hit.is_hit().then(|| ray.origin + ray.direction * (0.5 * hit.t));
        rays.iter().zip(&hits).filter_map(half).collect()
    }

    /// The next positions, along the rays of new viewpoints.
    fn next(viewpoints: &[Viewpoint], new: Range<usize>) -> Vec<Vec3> {
        let step = |index: usize| {
            let it = &viewpoints[index];
            let found = it.rays.iter().step_by((it.rays.len() / STEPS as usize).max(1));
            found.enumerate().map(move |(i, &(direction, t))| {
                let u = Sampler::new(Pattern::Sobol, 0, index as u32, i as u32).uniform2(1).x;
                it.position + direction * (t * (0.2 + 0.6 * u))
            })
        };
        new.flat_map(step).collect()
    }

    /// What is around a position; `None` if nothing is.
    fn look(&self, position: Vec3, number: u32) -> Option<Viewpoint> {
        let rays = around(position, number, 0..RAYS);
        let directions: Vec<Vec3> = rays.iter().map(|ray| ray.direction).collect();
        let mut found = Vec::with_capacity(rays.len());
        let (mut backs, mut inverse) = (0, 0.0);
        let escaped = self.trace(rays, |&Seen { ray, panes, hit, is_back }| {
            if panes == 0 {
                found.push((directions[ray], hit.t));
                inverse += 1.0 / hit.t.max(f32::MIN_POSITIVE);
                backs += usize::from(is_back);
            }
        });
        let is_open = escaped as f32 > OPEN * RAYS as f32;
        let is_covered = backs as f32 > BACKS * RAYS as f32;
        let distance = found.len() as f32 / inverse;
        distance.is_finite().then_some(Viewpoint { position, distance, rays: found, is_open, is_covered })
    }

    /// Traces rays through glass, and reports each hit. Returns the number of rays that miss.
    pub(super) fn trace(&self, mut rays: Vec<Ray>, mut tell: impl FnMut(&Seen)) -> usize {
        let mut numbers: Vec<usize> = (0..rays.len()).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut escaped = 0;
        for panes in 0..MAX_PANES {
            hits.truncate(rays.len());
            self.world.intersect_many(&rays, &mut hits);
            let mut kept = 0;
            for i in 0..rays.len() {
                let (ray, hit) = (rays[i], &hits[i]);
                if !hit.is_hit() {
                    escaped += 1;
                    continue;
                }
                tell(&Seen { ray: numbers[i], panes, hit, is_back: self.bodies.is_back(self.world, &ray, hit) });
                let surface = self.world.surface_at(hit);
                if surface.material.is_glass() {
                    (rays[kept], numbers[kept]) =
                        (Ray::new(surface.origin_towards(ray.direction), ray.direction), numbers[i]);
                    kept += 1;
                }
            }
            rays.truncate(kept);
            if rays.is_empty() {
                break;
            }
        }
        escaped
    }
}

/// Rays in all directions from a position.
pub(super) fn around(position: Vec3, number: u32, rays: Range<u32>) -> Vec<Ray> {
    let direction = |i| UniformSphere.map(Sampler::new(Pattern::Sobol, 0, number, i).uniform2(0));
    rays.map(|i| Ray::new(position, direction(i))).collect()
}
