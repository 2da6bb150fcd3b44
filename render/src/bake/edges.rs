//! Edges of the scene's triangles that two of them share, and whether light goes on smoothly over them.
//!
//! Triangles share an edge if its two ends are equal bit for bit, whatever mesh they belong to. Edges that meet another
//! in its middle (T-junctions) are not found.

use glam::Vec3;

use crate::scene::{Mesh, Scene};

/// Shading normals this far apart at both ends of an edge, or less, are those of one smooth surface: cos 37°.
const SMOOTH: f32 = 0.8;

/// A side of a triangle, from corner `side` to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// Index of the mesh.
    pub(crate) mesh: u32,
    /// Number of the triangle in the mesh.
    pub(crate) face: u32,
    /// 0, 1 or 2.
    pub(crate) side: u8,
}

/// Two sides with the same ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SharedEdge {
    pub(crate) sides: [Side; 2],
    /// Whether the surface goes on over it without a crease.
    pub(crate) is_smooth: bool,
    /// Whether the second side runs from the first one's end to its start.
    pub(crate) is_reversed: bool,
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

/// All shared edges, in a fixed order.
pub(crate) fn shared_edges(scene: &Scene) -> Vec<SharedEdge> {
    let mut sides: Vec<([[u32; 3]; 2], Side)> = Vec::with_capacity(3 * scene.triangle_count());
    for (mesh, m) in (0..).zip(&scene.meshes) {
        for face in 0..m.triangles.len() as u32 {
            for side in 0..3 {
                let side = Side { mesh, face, side };
                let mut ends = side.ends(scene).map(key);
                ends.sort_unstable();
                if ends[0] != ends[1] {
                    sides.push((ends, side));
                }
            }
        }
    }
    sides.sort_unstable();
    let mut edges = Vec::new();
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        for (i, &(_, first)) in group.iter().enumerate() {
            for &(_, second) in &group[i + 1..] {
                let is_reversed = key(first.ends(scene)[0]) != key(second.ends(scene)[0]);
                let is_smooth = is_smooth(scene, first, second, is_reversed);
                // Of several sheets that meet at an edge, those that go on smoothly belong together.
                if is_smooth || group.len() == 2 {
                    edges.push(SharedEdge { sides: [first, second], is_smooth, is_reversed });
                }
            }
        }
    }
    edges
}

/// A position's bits; both zeros are one.
fn key(position: Vec3) -> [u32; 3] {
    position.to_array().map(|coordinate| (coordinate + 0.0).to_bits())
}

fn is_smooth(scene: &Scene, first: Side, second: Side, is_reversed: bool) -> bool {
    let normals = |side: Side| {
        let mesh = &scene.meshes[side.mesh as usize];
        side.corners().map(|corner| corner_normal(mesh, side.face as usize, corner))
    };
    let ([a0, a1], [mut b0, mut b1]) = (normals(first), normals(second));
    if is_reversed {
        (b0, b1) = (b1, b0);
    }
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
            assert_eq!(edges, [SharedEdge { sides, is_smooth, is_reversed: true }], "{degrees}");
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
}
