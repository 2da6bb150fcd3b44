//! Bodies: closed solid meshes. A point that sees their back faces lies inside them.
//!
//! The back of a single-sided material is always the back of a body. Exporters mark most materials double-sided without
//! need, so there the geometry decides: a body is a closed mesh, each edge of which is traversed as often in one
//! direction as in the other, wound outwards, and solid, which it is not if a light or all of another mesh is inside:
//! then it is a room. Edges are joined where their ends are equal bit for bit. Glass is not a body.
//!
//! A closed mesh that is wound inwards, without a light or anything else inside, is a body that is inside out.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome_kernel::{Aabb, Ray};

use super::{Hit, World};
use crate::light::Light;
use crate::scene::{Key, Material, PunctualLight, UnionFind, key};

/// Corners of a mesh that must be inside of another, spread over it.
const PROBES: usize = 4;

/// Which double-sided triangles belong to solid bodies.
#[derive(Debug)]
pub(crate) struct Bodies {
    /// By `prim_id`; empty if there are none.
    is_solid: Vec<bool>,
}

/// Connected triangles.
struct Piece {
    triangles: Vec<u32>,
    bounds: Aabb,
}

impl Bodies {
    /// Whether `ray`, which hits something, comes from within a body.
    pub(crate) fn is_back(&self, world: &World, ray: &Ray, hit: &Hit) -> bool {
        let surface = world.surface_at(hit);
        let has_back = !surface.material.emits_both_sides || self.is_solid.get(hit.prim_id as usize) == Some(&true);
        has_back && !surface.material.is_glass() && surface.normal.dot(ray.direction) > 0.0
    }
}

impl World {
    /// Finds the bodies among what is double-sided.
    pub(crate) fn bodies(&self) -> Bodies {
        let materials = || self.placed_records().iter().map(|record| &self.materials[record.material as usize]);
        if !materials().any(|material| material.emits_both_sides) {
            return Bodies { is_solid: Vec::new() };
        }
        let (pieces, lights) = (self.pieces(), self.light_positions());
        let mut is_solid = vec![false; self.triangle_records.len()];
        for piece in &pieces {
            let has_back = |&prim: &u32| {
                let material = self.material_of(prim);
                material.emits_both_sides && !material.is_glass()
            };
            let is_outwards = || self.volume(piece).is_some_and(|volume| volume > 0.0);
            if piece.triangles.iter().all(has_back) && is_outwards() && !self.is_room(piece, &pieces, &lights) {
                piece.triangles.iter().for_each(|&prim| is_solid[prim as usize] = true);
            }
        }
        Bodies { is_solid }
    }

    /// The meshes of bodies that are inside out, in the scene's order: closed pieces wound inwards that are no rooms. A
    /// room has a light or something else inside, or glows itself; a piece within a body is the inner wall of a hollow
    /// one.
    pub(crate) fn inside_out(&self) -> Vec<usize> {
        let (pieces, lights) = (self.pieces(), self.light_positions());
        let may_be = |&prim: &u32| {
            let record = &self.triangle_records[prim as usize];
            let material = self.material_of(prim);
            !self.meshes[record.mesh as usize].is_added && !material.is_glass() && material.emission == Vec3::ZERO
        };
        let is_inside_out = |piece: &&Piece| {
            piece.triangles.iter().all(may_be)
                && self.volume(piece).is_some_and(|volume| volume < 0.0)
                && !self.is_room(piece, &pieces, &lights)
                && !self.is_in_body(piece, &pieces)
        };
        let prims = pieces.iter().filter(is_inside_out).flat_map(|piece| &piece.triangles);
        let meshes: BTreeSet<usize> = prims.map(|&prim| self.mesh_number(prim)).collect();
        meshes.into_iter().collect()
    }

    fn material_of(&self, prim: u32) -> &Material {
        &self.materials[self.triangle_records[prim as usize].material as usize]
    }

    /// The positions of lights that have one.
    fn light_positions(&self) -> Vec<Vec3> {
        let place = |light: &Light| match light {
            Light::Punctual(PunctualLight::Directional { .. }) | Light::Triangle(_) | Light::Sky => None,
            Light::Punctual(
                PunctualLight::Point { position, .. }
                | PunctualLight::Spot { position, .. }
                | PunctualLight::Profiled { position, .. },
            ) => Some(*position),
        };
        self.lights.lights().iter().filter_map(place).collect()
    }

    /// All triangles by connected component, in the order of the least x.
    fn pieces(&self) -> Vec<Piece> {
        let mut numbers: HashMap<Key, u32> = HashMap::new();
        let mut sets = UnionFind::default();
        let mut first_corners = Vec::with_capacity(self.placed_records().len());
        for record in self.placed_records() {
            let [a, b, c] = record.corners.map(|corner| *numbers.entry(key(corner)).or_insert_with(|| sets.push()));
            sets.join(a, b);
            sets.join(a, c);
            first_corners.push(a);
        }
        let mut of_root: HashMap<u32, usize> = HashMap::new();
        let mut pieces: Vec<Piece> = Vec::new();
        for ((prim, record), corner) in (0..).zip(self.placed_records()).zip(first_corners) {
            let place = *of_root.entry(sets.root(corner)).or_insert(pieces.len());
            if place == pieces.len() {
                pieces.push(Piece { triangles: Vec::new(), bounds: Aabb::EMPTY });
            }
            pieces[place].triangles.push(prim);
            pieces[place].bounds = pieces[place].bounds.union(&Aabb::around(&record.corners));
        }
        pieces.sort_by(|a, b| a.bounds.min.x.total_cmp(&b.bounds.min.x));
        pieces
    }

    /// Six times the volume of a closed piece, each edge of which is passed as often in both directions; it is negative
    /// if the triangles are wound inwards.
    fn volume(&self, piece: &Piece) -> Option<f64> {
        let mut balance: HashMap<[Key; 2], i32> = HashMap::new();
        let origin = piece.bounds.min.as_dvec3();
        let mut volume = 0.0;
        for &prim in &piece.triangles {
            let corners = self.triangle_records[prim as usize].corners;
            let keys = corners.map(key);
            for side in 0..3 {
                let (start, end) = (keys[side], keys[(side + 1) % 3]);
                match start.cmp(&end) {
                    std::cmp::Ordering::Less => *balance.entry([start, end]).or_insert(0) += 1,
                    std::cmp::Ordering::Greater => *balance.entry([end, start]).or_insert(0) -= 1,
                    std::cmp::Ordering::Equal => {}
                }
            }
            let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
            volume += a.dot(b.cross(c));
        }
        balance.values().all(|&count| count == 0).then_some(volume)
    }

    /// Whether a light or all of another piece lies inside. The pieces are in the order of their least x.
    fn is_room(&self, piece: &Piece, pieces: &[Piece], lights: &[Vec3]) -> bool {
        let has = |point: Vec3| contains(&piece.bounds, point) && self.is_inside(piece, point);
        let holds = |other: &Piece| {
            let is_within = contains(&piece.bounds, other.bounds.min) && contains(&piece.bounds, other.bounds.max);
            let step = other.triangles.len().div_ceil(PROBES);
            let corner = |&prim: &u32| self.triangle_records[prim as usize].corners[0];
            is_within && other.triangles.iter().step_by(step).map(corner).all(has)
        };
        let first = pieces.partition_point(|other| other.bounds.min.x < piece.bounds.min.x);
        let end = pieces.partition_point(|other| other.bounds.min.x <= piece.bounds.max.x);
        let mut others = pieces[first..end].iter().filter(|other| !std::ptr::eq(*other, piece));
        lights.iter().copied().any(has) || others.any(holds)
    }

    /// Whether a piece lies inside of a closed one that is wound outwards.
    fn is_in_body(&self, piece: &Piece, pieces: &[Piece]) -> bool {
        let end = pieces.partition_point(|other| other.bounds.min.x < piece.bounds.min.x);
        let corner = self.triangle_records[piece.triangles[0] as usize].corners[0];
        pieces[..end].iter().any(|other| {
            let is_around = contains(&other.bounds, piece.bounds.min) && contains(&other.bounds, piece.bounds.max);
            is_around && self.volume(other).is_some_and(|volume| volume > 0.0) && self.is_inside(other, corner)
        })
    }

    /// Whether a closed piece, wound outwards or inwards, goes round a point, by its solid angle (van Oosterom and
    /// Strackee 1983).
    fn is_inside(&self, piece: &Piece, point: Vec3) -> bool {
        let solid_angle = |&prim: &u32| {
            let corners = self.triangle_records[prim as usize].corners;
            let [a, b, c] = corners.map(|corner| (corner.as_dvec3() - point.as_dvec3()).normalize_or(DVec3::ZERO));
            2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        };
        piece.triangles.iter().map(solid_angle).sum::<f64>().abs() > 2.0 * PI
    }
}

/// Whether a box has a point.
fn contains(bounds: &Aabb, point: Vec3) -> bool {
    point.cmpge(bounds.min).all() && point.cmple(bounds.max).all()
}
