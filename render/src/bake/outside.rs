//! Surfaces that nobody sees who stays inside, as the outer walls of a house: they need no texels of their own.
//!
//! Places inside are found step by step. A place is inside if at most a fifth of all rays from there reach nothing, glass
//! passed (at the foot of an outer wall it is a quarter), and at most half end on backs of bodies. It begins with places that the
//! caller knows, which may be open, or with places in front of surfaces that are not narrow beside the widest; from each the
//! next are sought along its rays, until they lie as close as a third of the way to what stands around. What rays from all
//! places hit is seen. Of what they did not hit, the pieces are asked once more, by rays to points on them. A surface without
//! creases is left out as a whole, or not at all.

use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle, UniformSphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use rayon::prelude::*;

use super::edges::SharedEdge;
use super::left_out::LeftOut;
use crate::scene::Scene;
use crate::settings::Invalid;
use crate::world::{Bodies, Hit, Side, World};

/// Rays by which a place is judged, ...
const RAYS: u32 = 256;
/// ... and those that say what is seen from there.
const MORE_RAYS: u32 = 2048;
/// Of these a place inside loses at most this part.
const OPEN: f32 = 0.2;
/// At most this part of them end on backs.
const BACKS: f32 = 0.5;
/// Places lie so far apart, as a part of the harmonic mean of distances, ...
const SPACING: f32 = 0.35;
/// ... which counts as no less than this part of the greatest: there is no end to the places in a corner.
const LEAST_DISTANCE: f32 = 0.3;
/// How much narrower than the widest a place may be where the search begins: a gap below a floor is no room.
const NARROW: f32 = 1.0 / 12.0;
/// Places that are sought from each.
const STEPS: u32 = 16;
/// The most places.
const MOST_PLACES: usize = 4096;
/// Panes of glass that are looked through, one behind the other.
const MOST_PANES: usize = 16;
/// Points on a piece that no ray has hit, and the nearest places from which each is looked at.
const POINTS: u32 = 32;
const NEAREST: usize = 32;

/// What is around a place.
struct Place {
    position: Vec3,
    /// The harmonic mean of distances.
    distance: f32,
    /// The rays, as far as the first thing that they meet, glass included.
    ways: Vec<(Vec3, f32)>,
    /// Whether too many rays reach nothing.
    is_open: bool,
    /// Whether too many end on backs of bodies.
    is_covered: bool,
}

impl LeftOut {
    /// What cannot be seen from inside of the world that is made of `scene`. Inside is what can be reached from `places`, or, if
    /// there are none, from anywhere in front of a surface.
    ///
    /// # Errors
    /// If no place is inside.
    pub fn outside(scene: &Scene, world: &World, places: &[Vec3]) -> Result<Self, Invalid> {
        let search = Search { world, bodies: world.bodies(), first_prims: first_prims(scene) };
        let found = if places.is_empty() { search.anywhere()? } else { search.known(places)? };
        let mut is_seen = vec![false; search.first_prims.last().map_or(0, |&end| end as usize)];
        search.look_around(&found, &mut is_seen);
        let edges = super::edges::shared_edges(scene);
        let pieces = search.pieces(&edges, is_seen.len());
        search.look_at_pieces(&found, &pieces, &mut is_seen);
        let mut piece_is_seen = vec![false; is_seen.len()];
        for (&piece, _) in pieces.iter().zip(&is_seen).filter(|(_, is_seen)| **is_seen) {
            piece_is_seen[piece as usize] = true;
        }
        let is_left_out = |prim: u32| !piece_is_seen[pieces[prim as usize] as usize];
        let of_mesh = |ends: &[u32]| (ends[0]..ends[1]).map(is_left_out).collect();
        Ok(Self::new(search.first_prims.windows(2).map(of_mesh).collect()))
    }

    /// The number of triangles, and their part of the area of all surfaces that could get light.
    pub fn extent(&self, scene: &Scene) -> (usize, f64) {
        let (mut triangles, mut left_out, mut all) = (0, 0.0, 0.0);
        for (number, mesh) in scene.meshes.iter().enumerate().filter(|(_, mesh)| !mesh.is_added) {
            for face in 0..mesh.triangles.len() {
                let area = super::islands::area(mesh.corners(face));
                all += area;
                if self.has(number, face) {
                    (triangles, left_out) = (triangles + 1, left_out + area);
                }
            }
        }
        (triangles, if all > 0.0 { left_out / all } else { 0.0 })
    }
}

/// For each mesh the number of its first triangle among all; and behind them the number of all.
fn first_prims(scene: &Scene) -> Vec<u32> {
    let counts = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u32);
    let ends = counts.scan(0, |sum, count| {
        *sum += count;
        Some(*sum)
    });
    std::iter::once(0).chain(ends).collect()
}

struct Search<'a> {
    world: &'a World,
    bodies: Bodies,
    first_prims: Vec<u32>,
}

impl Search<'_> {
    /// Places inside that can be reached from these.
    fn known(&self, places: &[Vec3]) -> Result<Vec<Place>, Invalid> {
        let look = |&position: &Vec3| {
            let Vec3 { x, y, z } = position;
            let problem = || format!("{x},{y},{z} is in no room: from there nothing is seen, or the backs of bodies");
            let seen = self.look(position, 0).filter(|seen| !seen.is_covered);
            seen.ok_or_else(|| Invalid::new(problem(), "name a place in a room: --skip-outside=X,Y,Z"))
        };
        let places = places.iter().map(look).collect::<Result<Vec<Place>, Invalid>>()?;
        Ok(self.reach(places))
    }

    /// Places inside that can be reached from the fronts of surfaces; where there are none, from their backs.
    fn anywhere(&self) -> Result<Vec<Place>, Invalid> {
        let begin = |side| {
            let places = self.look_from_all(&self.starts(side), |_| true);
            let widest = places.iter().map(|place| place.distance).fold(0.0, f32::max);
            self.reach(places.into_iter().filter(|place| place.distance >= NARROW * widest))
        };
        let mut found = [Side::Front, Side::Back].into_iter().map(begin);
        found.find(|places| !places.is_empty()).ok_or_else(|| {
            Invalid::new(
                "nothing can be left out, as no place is inside: more than a fifth of all rays from any reach nothing",
                "leave --skip-outside out, or name a place in a room: --skip-outside=X,Y,Z",
            )
        })
    }

    /// These places, and what can be reached from them, spread evenly.
    fn reach(&self, new: impl IntoIterator<Item = Place>) -> Vec<Place> {
        let (mut places, mut widest) = (Vec::<Place>::new(), 0.0f32);
        let mut new: Vec<Place> = new.into_iter().collect();
        while !new.is_empty() && places.len() < MOST_PLACES {
            let first = places.len();
            widest = new.iter().map(|place| place.distance).fold(widest, f32::max);
            let spacing = |distance: f32| SPACING * distance.max(LEAST_DISTANCE * widest);
            for place in new {
                let is_apart = |other: &Place| {
                    other.position.distance(place.position) > spacing(place.distance.min(other.distance))
                };
                if places.len() < MOST_PLACES && places.iter().all(is_apart) {
                    places.push(place);
                }
            }
            let candidates = Self::next(&places, first..places.len());
            // Most are too close to a place that is known, whatever is around them.
            new = self.look_from_all(&candidates, |position| {
                places.iter().all(|place| place.position.distance(position) > 0.5 * spacing(place.distance))
            });
        }
        places
    }

    /// What is around those positions that are inside, of those that are of interest.
    fn look_from_all(&self, positions: &[Vec3], is_of_interest: impl Fn(Vec3) -> bool + Sync) -> Vec<Place> {
        let look = |(number, &position): (usize, &Vec3)| {
            let place = is_of_interest(position).then(|| self.look(position, number as u32)).flatten();
            place.filter(|place| !place.is_open && !place.is_covered)
        };
        let looked: Vec<Option<Place>> = positions.par_iter().enumerate().map(look).collect();
        looked.into_iter().flatten().collect()
    }

    /// Places beside surfaces, half of the way to the next.
    fn starts(&self, side: Side) -> Vec<Vec3> {
        let rays = self.world.rays_from_surfaces(side);
        let mut hits = vec![Hit::MISS; rays.len()];
        self.world.intersect_many(&rays, &mut hits);
        let half = |(ray, hit): (&Ray, &Hit)| hit.is_hit().then(|| ray.origin + ray.direction * (0.5 * hit.t));
        rays.iter().zip(&hits).filter_map(half).collect()
    }

    /// Where to look next, along the rays of new places.
    fn next(places: &[Place], new: Range<usize>) -> Vec<Vec3> {
        let step = |number: usize| {
            let place = &places[number];
            let ways = place.ways.iter().step_by((place.ways.len() / STEPS as usize).max(1));
            ways.enumerate().map(move |(i, &(direction, t))| {
                let u = Sampler::new(Pattern::Sobol, 0, number as u32, i as u32).uniform2(1).x;
                place.position + direction * (t * (0.2 + 0.6 * u))
            })
        };
        new.flat_map(step).collect()
    }

    /// What is around a position; `None` if nothing is.
    fn look(&self, position: Vec3, number: u32) -> Option<Place> {
        let mut rays = around(position, number, 0..RAYS);
        let directions: Vec<Vec3> = rays.iter().map(|ray| ray.direction).collect();
        let mut ways = Vec::with_capacity(rays.len());
        let (mut backs, mut inverse) = (0, 0.0);
        let escaped = self.trace(&mut rays, |ray, pane, hit, is_back| {
            if pane == 0 {
                ways.push((directions[ray], hit.t));
                inverse += 1.0 / hit.t.max(f32::MIN_POSITIVE);
                backs += usize::from(is_back);
            }
        });
        let is_open = escaped as f32 > OPEN * RAYS as f32;
        let is_covered = backs as f32 > BACKS * RAYS as f32;
        let distance = ways.len() as f32 / inverse;
        distance.is_finite().then_some(Place { position, distance, ways, is_open, is_covered })
    }

    /// Marks what is seen from places all around.
    fn look_around(&self, places: &[Place], is_seen: &mut [bool]) {
        let chunk = |(number, place): (usize, &Place)| {
            let mut prims = Vec::new();
            let mut rays = around(place.position, number as u32, RAYS..RAYS + MORE_RAYS);
            self.trace(&mut rays, |_, _, hit, _| prims.push(hit.prim_id));
            prims.sort_unstable();
            prims.dedup();
            prims
        };
        let seen: Vec<Vec<u32>> = places.par_iter().enumerate().map(chunk).collect();
        mark(is_seen, seen.into_iter().flatten());
    }

    /// For each triangle the least one of its piece, which ends at creases.
    fn pieces(&self, edges: &[SharedEdge], triangles: usize) -> Vec<u32> {
        let mut parents: Vec<u32> = (0..triangles as u32).collect();
        fn root(parents: &mut [u32], mut number: u32) -> u32 {
            while parents[number as usize] != number {
                parents[number as usize] = parents[parents[number as usize] as usize];
                number = parents[number as usize];
            }
            number
        }
        for edge in edges.iter().filter(|edge| edge.is_smooth) {
            let [a, b] = edge.sides.map(|side| self.first_prims[side.mesh as usize] + side.face);
            let (a, b) = (root(&mut parents, a), root(&mut parents, b));
            parents[a.max(b) as usize] = a.min(b);
        }
        (0..triangles as u32).map(|triangle| root(&mut parents, triangle)).collect()
    }

    /// Marks what is seen by rays from places to points on pieces of which nothing is seen yet.
    fn look_at_pieces(&self, places: &[Place], pieces: &[u32], is_seen: &mut [bool]) {
        let mut order: Vec<u32> = (0..pieces.len() as u32).collect();
        order.sort_by_key(|&prim| pieces[prim as usize]);
        let unseen = order.chunk_by(|&a, &b| pieces[a as usize] == pieces[b as usize]);
        let unseen: Vec<&[u32]> = unseen.filter(|piece| !piece.iter().any(|&prim| is_seen[prim as usize])).collect();
        let look = |piece: &&[u32]| {
            let step = piece.len().div_ceil(POINTS as usize);
            let each = POINTS.div_ceil(piece.len().div_ceil(step) as u32);
            let points = piece.iter().step_by(step).flat_map(|&prim| (0..each).map(move |i| (prim, i)));
            let points = points.map(|(prim, i)| {
                let u: Vec2 = Triangle.map(Sampler::new(Pattern::Sobol, 0, prim, i).uniform2(0));
                self.world.receiver(prim, [u.x, u.y]).position
            });
            let mut seen = Vec::new();
            for point in points {
                let mut near: Vec<(f32, usize)> =
                    places.iter().enumerate().map(|(i, place)| (place.position.distance_squared(point), i)).collect();
                let nearest = near.len().min(NEAREST);
                near.select_nth_unstable_by(nearest - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let ray = |&(_, place): &(f32, usize)| {
                    let from = places[place].position;
                    Ray::new(from, (point - from).normalize_or(Vec3::Z))
                };
                let mut rays: Vec<Ray> = near[..nearest].iter().map(ray).collect();
                self.trace(&mut rays, |_, _, hit, _| {
                    if piece.binary_search(&hit.prim_id).is_ok() {
                        seen.push(hit.prim_id);
                    }
                });
                if !seen.is_empty() {
                    break;
                }
            }
            seen.first().copied()
        };
        let seen: Vec<Option<u32>> = unseen.par_iter().map(look).collect();
        mark(is_seen, seen.into_iter().flatten());
    }

    /// Traces rays through glass; tells of each hit its ray's number, the panes before it, and whether it is a back. Gives
    /// the number of rays that reach nothing.
    fn trace(&self, rays: &mut Vec<Ray>, mut hit: impl FnMut(usize, usize, &Hit, bool)) -> usize {
        let mut numbers: Vec<usize> = (0..rays.len()).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut escaped = 0;
        for pane in 0..MOST_PANES {
            hits.truncate(rays.len());
            self.world.intersect_many(rays, &mut hits);
            let mut kept = 0;
            for i in 0..rays.len() {
                let (ray, at) = (rays[i], hits[i]);
                if !at.is_hit() {
                    escaped += 1;
                    continue;
                }
                hit(numbers[i], pane, &at, self.bodies.is_back(self.world, &ray, &at));
                let surface = self.world.surface_at(&at);
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

/// Marks triangles; those of instances, which get no light of their own, have no mark.
fn mark(is_seen: &mut [bool], prims: impl Iterator<Item = u32>) {
    for prim in prims {
        if let Some(is_seen) = is_seen.get_mut(prim as usize) {
            *is_seen = true;
        }
    }
}

/// Rays in all directions from a place.
fn around(position: Vec3, number: u32, rays: Range<u32>) -> Vec<Ray> {
    let direction = |i| UniformSphere.map(Sampler::new(Pattern::Sobol, 0, number, i).uniform2(0));
    rays.map(|i| Ray::new(position, direction(i))).collect()
}
