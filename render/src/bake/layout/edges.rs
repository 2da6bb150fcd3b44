//! Edges that two of the scene's triangles share, and whether light is continuous across them.
//!
//! Triangles share an edge if its two ends are equal bit for bit, whatever mesh they belong to. Other sides may be
//! shared piece by piece: where corners lie in the middle of a side ([`t_junctions`](super::t_junctions)), it is cut
//! there.

use glam::Vec3;

use super::t_junctions::corners_on;
use crate::scene::{Key, key};
use crate::scene::{Mesh, Scene};

/// Shading normals this far apart at both ends of an edge, or less, are those of one smooth surface: cos 37°.
const SMOOTH: f32 = 0.8;

/// A side of a triangle, from corner `side` to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// Index of the mesh.
    pub(crate) mesh: u32,
    /// Index of the triangle in the mesh.
    pub(crate) face: u32,
    /// 0, 1 or 2.
    pub(crate) side: u8,
}

/// Two sides, or pieces of sides, with the same ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SharedEdge {
    pub(crate) sides: [Side; 2],
    /// Where on each side it starts and ends, from 0 to 1: both start at one point, and end at one.
    pub(crate) spans: [[f64; 2]; 2],
    /// Whether the surface continues across it without a crease.
    pub(crate) is_smooth: bool,
}

/// A piece of a side.
#[derive(Clone, Copy)]
struct Piece {
    /// Its ends, the lesser first.
    ends: [Key; 2],
    start: Key,
    side: Side,
    span: [f64; 2],
}

impl Side {
    /// The numbers of the corners at its ends.
    pub(crate) fn corners(self) -> [usize; 2] {
        [usize::from(self.side), (usize::from(self.side) + 1) % 3]
    }

    fn ends(self, scene: &Scene) -> [Vec3; 2] {
        let mesh = &scene.meshes[self.mesh as usize];
        let triangle = mesh.triangles[self.face as usize];
        self.corners().map(|corner| mesh.positions[triangle[corner] as usize])
    }
}

impl Piece {
    fn new(side: Side, ends: [Vec3; 2], span: [f64; 2]) -> Self {
        let mut keys = ends.map(key);
        let start = keys[0];
        keys.sort_unstable();
        Self { ends: keys, start, side, span }
    }
}

/// All shared edges of what gets light, in a fixed order.
pub(crate) fn shared_edges(scene: &Scene) -> Vec<SharedEdge> {
    let mut whole = Vec::with_capacity(3 * scene.triangle_count());
    for (mesh, m) in (0..).zip(&scene.meshes).filter(|(_, mesh)| !mesh.is_added) {
        for face in 0..m.triangles.len() as u32 {
            let sides = (0..3).map(|side| Side { mesh, face, side });
            whole.extend(sides.map(|side| Piece::new(side, side.ends(scene), [0.0, 1.0])));
        }
    }
    whole.retain(|piece| piece.ends[0] != piece.ends[1]);
    let (mut edges, open) = pairs(scene, whole);
    let ends: Vec<[Vec3; 2]> = open.iter().map(|side| side.ends(scene)).collect();
    let mut pieces = Vec::new();
    for ((side, [start, end]), corners) in open.into_iter().zip(&ends).zip(corners_on(&ends)) {
        let mut from = (0.0, *start);
        for to in corners.into_iter().chain([(1.0, *end)]) {
            pieces.push(Piece::new(side, [from.1, to.1], [from.0, to.0]));
            from = to;
        }
    }
    edges.extend(pairs(scene, pieces).0);
    edges
}

/// Edges of pieces with the same ends, and the sides of pieces that are alone.
fn pairs(scene: &Scene, mut pieces: Vec<Piece>) -> (Vec<SharedEdge>, Vec<Side>) {
    pieces.sort_unstable_by_key(|piece| (piece.ends, piece.side));
    let (mut edges, mut alone) = (Vec::new(), Vec::new());
    for group in pieces.chunk_by(|a, b| a.ends == b.ends) {
        if let [piece] = group {
            alone.push(piece.side);
        }
        for (i, first) in group.iter().enumerate() {
            for second in &group[i + 1..] {
                let [start, end] = second.span;
                let spans = [first.span, if first.start == second.start { [start, end] } else { [end, start] }];
                let sides = [first.side, second.side];
                let is_smooth = is_smooth(scene, sides, spans);
                // If several sheets meet at an edge, those that continue smoothly belong together.
                if is_smooth || group.len() == 2 {
                    edges.push(SharedEdge { sides, spans, is_smooth });
                }
            }
        }
    }
    (edges, alone)
}

fn is_smooth(scene: &Scene, sides: [Side; 2], spans: [[f64; 2]; 2]) -> bool {
    let normals = |i: usize| {
        let mesh = &scene.meshes[sides[i].mesh as usize];
        let [a, b] = sides[i].corners().map(|corner| corner_normal(mesh, sides[i].face as usize, corner));
        spans[i].map(|t| a.lerp(b, t as f32).normalize_or_zero())
    };
    let ([a0, a1], [b0, b1]) = (normals(0), normals(1));
    a0.dot(b0) > SMOOTH && a1.dot(b1) > SMOOTH
}

/// The shading normal of a triangle's corner: the vertex's, or the triangle's; zero if it has no area.
fn corner_normal(mesh: &Mesh, face: usize, corner: usize) -> Vec3 {
    match mesh.normals.is_empty() {
        true => {
            let [a, b, c] = mesh.corners(face).map(|p| p.as_dvec3());
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        }
        false => mesh.normals[mesh.triangles[face][corner] as usize],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    /// Two triangles that share the y axis; the second is turned up by an angle.
    fn wings(degrees: f32) -> Scene {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let positions = vec![vec3(-1.0, 0.0, 0.0), vec3(-0.0, 1.0, 0.0), Vec3::ZERO, vec3(cos, 0.0, sin), Vec3::Y];
        let mesh = Mesh { positions, triangles: vec![[0, 2, 1], [3, 4, 2]], ..Mesh::default() };
        Scene { meshes: vec![mesh], ..Scene::default() }
    }

    #[test]
    fn edges_are_found_by_position_and_told_smooth_by_normals() {
        for (degrees, is_smooth) in [(0.0, true), (30.0, true), (45.0, false), (90.0, false)] {
            let edges = shared_edges(&wings(degrees));
            let sides = [Side { mesh: 0, face: 0, side: 1 }, Side { mesh: 0, face: 1, side: 1 }];
            let spans = [[0.0, 1.0], [1.0, 0.0]];
            assert_eq!(edges, [SharedEdge { sides, spans, is_smooth }], "{degrees}");
        }
    }

    #[test]
    fn vertex_normals_decide_before_the_shape_does() {
        let mut scene = wings(90.0);
        scene.meshes[0].normals = vec![Vec3::Z; 5];
        assert!(shared_edges(&scene)[0].is_smooth);
        let mut creased = wings(0.0);
        creased.meshes[0].normals = vec![Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Z, Vec3::X];
        assert!(!shared_edges(&creased)[0].is_smooth, "one end agrees, the other does not");
    }

    #[test]
    fn both_sides_of_a_sheet_have_nothing_in_common() {
        let mut scene = wings(0.0);
        scene.meshes[0].triangles = vec![[0, 2, 1], [0, 1, 2]];
        let edges = shared_edges(&scene);
        assert_eq!(edges.len(), 3);
        assert!(edges.iter().all(|edge| !edge.is_smooth));
    }

    /// A triangle above an edge, and two below it that meet in its middle, all turned; the lower ones are bent down.
    #[test]
    fn a_side_is_shared_piece_by_piece() {
        for (bend, is_smooth) in [(0.2, true), (1.0, false)] {
            let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
            let below = vec3(0.0, -1.0, -bend);
            let corners = [Vec3::ZERO, Vec3::X * 3.0, vec3(1.0, 1.0, 0.0), Vec3::X, below, below + Vec3::X * 2.0];
            let positions = corners.map(|corner| turn * corner + vec3(10.0, -20.0, 5.0)).to_vec();
            let triangles = vec![[0, 1, 2], [0, 4, 3], [3, 5, 1]];
            let scene = Scene { meshes: vec![Mesh { positions, triangles, ..Mesh::default() }], ..Scene::default() };
            let mut edges = shared_edges(&scene);
            edges.sort_by(|a, b| a.spans[0][0].total_cmp(&b.spans[0][0]));
            assert_eq!(edges.len(), 2);
            for (edge, (span, face)) in edges.iter().zip([([0.0, 1.0 / 3.0], 1), ([1.0 / 3.0, 1.0], 2)]) {
                let side = |face, side| Side { mesh: 0, face, side };
                assert_eq!((edge.sides, edge.is_smooth), ([side(0, 0), side(face, 2)], is_smooth));
                assert!(edge.spans[0].iter().zip(span).all(|(a, b)| (a - b).abs() < 1e-5), "{:?}", edge.spans);
                assert_eq!(edge.spans[1], [1.0, 0.0]);
            }
        }
    }
}
