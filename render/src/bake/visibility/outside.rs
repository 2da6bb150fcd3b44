//! Surfaces that cannot be seen from inside, such as the outer walls of a house: they need no texels.
//!
//! Surfaces hit by rays from the viewpoints inside ([`Search`]) are visible. The others are tested again, piece by
//! piece, by rays to points on them. A surface without creases is left out as a whole, or not at all.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use rayon::prelude::*;

use super::inside::{RAYS, Search, Viewpoint, around};
use crate::bake::layout::edges::{SharedEdge, shared_edges};
use crate::bake::layout::islands::area;
use crate::bake::layout::left_out::LeftOut;
use crate::bake::layout::texels::first_prims;
use crate::scene::{Scene, UnionFind};
use crate::settings::Invalid;
use crate::world::World;

/// Rays from each viewpoint.
const MORE_RAYS: u32 = 2048;
/// Points on a piece that none of these rays has hit, ...
const POINTS: u32 = 32;
/// ... and the nearest viewpoints from which each is looked at.
const MAX_VIEWPOINTS: usize = 32;

impl LeftOut {
    /// What cannot be seen from inside of the world that is made of `scene`. Inside is what can be reached from
    /// `positions`, or, if there are none, from anywhere in front of a surface.
    ///
    /// # Errors
    /// If no position is inside.
    pub fn outside(scene: &Scene, world: &World, positions: &[Vec3]) -> Result<Self, Invalid> {
        let (search, first_prims) = (Search::new(world), first_prims(scene));
        let viewpoints = if positions.is_empty() { search.anywhere()? } else { search.known(positions)? };
        let mut is_seen = vec![false; first_prims[scene.meshes.len()] as usize];
        look_around(&search, &viewpoints, &mut is_seen);
        let pieces = pieces(&shared_edges(scene), &first_prims);
        look_at_pieces(world, &search, &viewpoints, &pieces, &mut is_seen);
        let mut piece_is_seen = vec![false; is_seen.len()];
        for (&piece, _) in pieces.iter().zip(&is_seen).filter(|(_, is_seen)| **is_seen) {
            piece_is_seen[piece as usize] = true;
        }
        let is_left_out = |prim: u32| !piece_is_seen[pieces[prim as usize] as usize];
        let of_mesh = |ends: &[u32]| (ends[0]..ends[1]).map(is_left_out).collect();
        Ok(Self::new(first_prims.windows(2).map(of_mesh).collect()))
    }

    /// The number of triangles, and their part of the area of all surfaces that could get light.
    pub fn extent(&self, scene: &Scene) -> (usize, f64) {
        let (mut triangles, mut left_out, mut all) = (0, 0.0, 0.0);
        for (number, mesh) in scene.meshes.iter().enumerate().filter(|(_, mesh)| !mesh.is_added) {
            for face in 0..mesh.triangles.len() {
                let area = area(mesh.corners(face));
                all += area;
                if self.has(number, face) {
                    (triangles, left_out) = (triangles + 1, left_out + area);
                }
            }
        }
        (triangles, if all > 0.0 { left_out / all } else { 0.0 })
    }
}

/// For each triangle the least one of its piece, which ends at creases.
fn pieces(edges: &[SharedEdge], first_prims: &[u32]) -> Vec<u32> {
    let mut sets = UnionFind::new(first_prims.last().map_or(0, |&count| count as usize));
    for edge in edges.iter().filter(|edge| edge.is_smooth) {
        let [a, b] = edge.sides.map(|side| first_prims[side.mesh as usize] + side.face);
        sets.join(a, b);
    }
    sets.roots()
}

/// Marks the surfaces seen from all viewpoints, in all directions.
fn look_around(search: &Search, viewpoints: &[Viewpoint], is_seen: &mut [bool]) {
    let look = |(number, viewpoint): (usize, &Viewpoint)| {
        let mut prims = Vec::new();
        let rays = around(viewpoint.position, number as u32, RAYS..RAYS + MORE_RAYS);
        search.trace(rays, |seen| prims.push(seen.hit.prim_id));
        prims.sort_unstable();
        prims.dedup();
        prims
    };
    let seen: Vec<Vec<u32>> = viewpoints.par_iter().enumerate().map(look).collect();
    mark(is_seen, seen.into_iter().flatten());
}

/// Marks pieces of which nothing is seen yet, if rays from viewpoints to points on them hit any of their triangles.
fn look_at_pieces(world: &World, search: &Search, viewpoints: &[Viewpoint], pieces: &[u32], is_seen: &mut [bool]) {
    let mut order: Vec<u32> = (0..pieces.len() as u32).collect();
    order.sort_by_key(|&prim| pieces[prim as usize]);
    let unseen = order.chunk_by(|&a, &b| pieces[a as usize] == pieces[b as usize]);
    let unseen: Vec<&[u32]> = unseen.filter(|piece| !piece.iter().any(|&prim| is_seen[prim as usize])).collect();
    // The triangles of a piece are in ascending order.
    let hit_along = |rays: Vec<Ray>, piece: &[u32]| {
        let mut found = None;
        search.trace(rays, |seen| found = found.or(piece.binary_search(&seen.hit.prim_id).ok()));
        found.map(|place| piece[place])
    };
    let look = |piece: &&[u32]| points_on(world, piece).find_map(|at| hit_along(rays_to(at, viewpoints), piece));
    let seen: Vec<Option<u32>> = unseen.par_iter().map(look).collect();
    mark(is_seen, seen.into_iter().flatten());
}

/// Points spread over the triangles of a piece.
fn points_on(world: &World, piece: &[u32]) -> impl Iterator<Item = Vec3> {
    let step = piece.len().div_ceil(POINTS as usize);
    let each = POINTS.div_ceil(piece.len().div_ceil(step) as u32);
    let points = piece.iter().step_by(step).flat_map(move |&prim| (0..each).map(move |i| (prim, i)));
    points.map(|(prim, i)| {
        let u: Vec2 = Triangle.map(Sampler::new(Pattern::Sobol, 0, prim, i).uniform2(0));
        world.receiver(prim, [u.x, u.y]).position
    })
}

/// Rays to a point from the nearest viewpoints.
fn rays_to(point: Vec3, viewpoints: &[Viewpoint]) -> Vec<Ray> {
    let distance = |(number, it): (usize, &Viewpoint)| (it.position.distance_squared(point), number);
    let mut near: Vec<(f32, usize)> = viewpoints.iter().enumerate().map(distance).collect();
    let count = near.len().min(MAX_VIEWPOINTS);
    near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let ray = |&(_, number): &(f32, usize)| {
        let from = viewpoints[number].position;
        Ray::new(from, (point - from).normalize_or(Vec3::Z))
    };
    near[..count].iter().map(ray).collect()
}

/// Marks triangles; those of instances, which get no light of their own, have no mark.
fn mark(is_seen: &mut [bool], prims: impl Iterator<Item = u32>) {
    for prim in prims {
        if let Some(is_seen) = is_seen.get_mut(prim as usize) {
            *is_seen = true;
        }
    }
}
