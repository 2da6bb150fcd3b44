//! Points as spheres and lines as cylinders: triangles with the normals of the true surfaces.
//!
//! A sphere is a subdivided icosahedron, with fewer levels the more spheres there are. A line is a cylinder of twelve
//! sides between spheres, so that connected lines have no gap. Inner surfaces are not removed, which is visible only in
//! glass.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;

use crate::scene::Mesh;

/// The most triangles that all balls of a mesh have together, but for the coarsest.
const MAX_BALL_TRIANGLES: usize = 1 << 21;
/// Cuts of the finest ball: 320 triangles.
const FINEST: u32 = 2;
const SIDES: u32 = 12;

/// Vertices that replace those of a mesh.
#[derive(Default)]
struct Solid {
    /// The vertex of the mesh that each belongs to.
    of: Vec<u32>,
    /// The direction from there, in units of the radius: also the normal.
    outward: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// The mesh with balls of a radius at these of its vertices, in place of its triangles.
pub(crate) fn balls(mesh: Mesh, vertices: &[u32], radius: f32) -> Mesh {
    let mut solid = Solid::default();
    solid.add_balls(vertices);
    solid.replace(mesh, radius)
}

/// The mesh with tubes of a radius between these of its vertices, in place of its triangles.
pub(crate) fn tubes(mesh: Mesh, lines: &[[u32; 2]], radius: f32) -> Mesh {
    let mut solid = Solid::default();
    let ends: BTreeSet<u32> = lines.iter().flatten().copied().collect();
    solid.add_balls(&ends.into_iter().collect::<Vec<_>>());
    for &[from, to] in lines {
        let along = mesh.positions[to as usize] - mesh.positions[from as usize];
        if let Some(along) = along.try_normalize() {
            solid.add_tube(from, to, along);
        }
    }
    solid.replace(mesh, radius)
}

impl Solid {
    fn add_balls(&mut self, vertices: &[u32]) {
        let fits = |cuts: &u32| vertices.len().saturating_mul(20 << (2 * cuts)) <= MAX_BALL_TRIANGLES;
        let (outward, triangles) = ball((0..=FINEST).rev().find(fits).unwrap_or(0));
        for &vertex in vertices {
            self.add(vertex, &outward, &triangles);
        }
    }

    fn add(&mut self, vertex: u32, outward: &[Vec3], triangles: &[[u32; 3]]) {
        let first = self.of.len() as u32;
        self.of.resize(self.of.len() + outward.len(), vertex);
        self.outward.extend_from_slice(outward);
        self.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }

    fn add_tube(&mut self, from: u32, to: u32, along: Vec3) {
        let (across, above) = along.any_orthonormal_pair();
        let first = self.of.len() as u32;
        for side in 0..SIDES {
            let (sine, cosine) = (std::f32::consts::TAU * side as f32 / SIDES as f32).sin_cos();
            let outward = across * cosine + above * sine;
            let next = (side + 1) % SIDES;
            let corner = |side: u32, end: u32| first + 2 * side + end;
            let quad = [corner(side, 0), corner(next, 0), corner(next, 1), corner(side, 1)];
            // From `across` to `above` is counter-clockwise seen against `along`.
            self.triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            self.of.extend([from, to]);
            self.outward.extend([outward, outward]);
        }
    }

    fn replace(self, mesh: Mesh, radius: f32) -> Mesh {
        let Self { of, outward, triangles } = self;
        fn taken<T: Copy>(values: &[T], of: &[u32]) -> Vec<T> {
            if values.is_empty() { Vec::new() } else { of.iter().map(|&vertex| values[vertex as usize]).collect() }
        }
        let centers = taken(&mesh.positions, &of);
        Mesh {
            positions: centers.iter().zip(&outward).map(|(&center, &outward)| center + radius * outward).collect(),
            texcoords: taken(&mesh.texcoords, &of),
            lightmap_texcoords: taken(&mesh.lightmap_texcoords, &of),
            colors: taken(&mesh.colors, &of),
            normals: outward,
            tangents: Vec::new(),
            triangles,
            is_added: true,
            ..mesh
        }
    }
}

/// The vertices and triangles of an icosahedron in the unit ball whose faces were cut in four so many times.
fn ball(cuts: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f32.sqrt());
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    // The corners of three rectangles.
    let corners = signs.iter().flat_map(|&(a, b)| {
        [Vec3::new(0.0, a, b * golden), Vec3::new(a, b * golden, 0.0), Vec3::new(b * golden, 0.0, a)]
    });
    let mut vertices: Vec<Vec3> = corners.map(Vec3::normalize).collect();
    // Three corners that are as near to each other as can be are a face.
    let edge = (0..12).skip(1).map(|i| vertices[0].distance(vertices[i])).fold(f32::INFINITY, f32::min);
    let is_edge = |a: usize, b: usize| vertices[a].distance(vertices[b]) < 1.1 * edge;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let is_outward = vertices[a].cross(vertices[b]).dot(vertices[c]) > 0.0;
                    let [b, c] = if is_outward { [b, c] } else { [c, b] };
                    triangles.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for _ in 0..cuts {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let cut = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every triangle shows its front to the outside, and normals point there.
    fn check(mesh: &Mesh, centers: &[Vec3], radius: f32) {
        assert_eq!(mesh.normals.len(), mesh.positions.len());
        for &corners in &mesh.triangles {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
            let front = (b - a).cross(c - a);
            for corner in corners {
                assert!(front.dot(mesh.normals[corner as usize]) > 0.0, "{corners:?}");
            }
        }
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            let center = *position - radius * *normal;
            assert!(centers.iter().any(|other| other.distance(center) < 1e-5), "{position}");
        }
    }

    fn points() -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X * 3.0, Vec3::new(3.0, 4.0, 1.0), Vec3::NEG_Z];
        let texcoords = (0..4).map(|i| glam::Vec2::splat(i as f32)).collect();
        Mesh { positions, texcoords, ..Mesh::default() }
    }

    #[test]
    fn balls_are_nearly_round() {
        for (cuts, count) in [(0, 20), (1, 80), (2, 320)] {
            let (vertices, triangles) = ball(cuts);
            assert_eq!((triangles.len(), vertices.len()), (count, count / 2 + 2), "closed, by Euler");
            assert!(vertices.iter().all(|vertex| (vertex.length() - 1.0).abs() < 1e-6));
        }
        let mesh = balls(points(), &[0, 2, 3], 0.5);
        assert_eq!(mesh.triangles.len(), 3 * 320);
        check(&mesh, &points().positions, 0.5);
        let of_last = mesh.positions.iter().zip(&mesh.texcoords).filter(|(_, texcoord)| texcoord.x == 3.0);
        assert!(of_last.clone().count() == 162 && of_last.into_iter().all(|(p, _)| p.distance(Vec3::NEG_Z) < 0.51));
    }

    #[test]
    fn tubes_reach_from_end_to_end() {
        let mesh = tubes(points(), &[[0, 1], [1, 2], [3, 3]], 0.25);
        assert_eq!(mesh.triangles.len(), 4 * 320 + 2 * 24, "four balls, and no tube from a point to itself");
        check(&mesh, &points().positions, 0.25);
        assert_eq!(mesh.texcoords.len(), mesh.positions.len());
    }

    #[test]
    fn many_are_coarser() {
        let positions = vec![Vec3::ZERO; 30_000];
        let vertices: Vec<u32> = (0..30_000).collect();
        assert_eq!(balls(Mesh { positions, ..Mesh::default() }, &vertices, 1.0).triangles.len(), 30_000 * 20);
        let positions = vec![Vec3::ZERO; 20_000];
        assert_eq!(balls(Mesh { positions, ..Mesh::default() }, &vertices[..20_000], 1.0).triangles.len(), 20_000 * 80);
    }
}
