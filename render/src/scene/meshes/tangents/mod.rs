//! Tangents for meshes that have none: MikkTSpace (Mikkelsen 2008), by which most programs make their normal maps.
//!
//! It is given texture coordinates with v upwards, so that bitangents point up in pictures, as glTF has them, and
//! positions and normals in the coordinates in which normal maps apply.
//!
//! Large meshes are done in parts on all threads, each with the triangles around it ([`Neighbours`]), so that corners get
//! what they get in the whole mesh, bit for bit. The library recurses from triangle to triangle around a corner, and seeks
//! tangents for triangles without extent among all others: parts need a larger stack where many triangles meet, and keep
//! the search short.

mod neighbours;

use std::ops::Range;
use std::thread;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DMat3, Mat3, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::scene::{Mesh, Scene};
use neighbours::Neighbours;

/// Triangles of a part.
const PART: usize = 1 << 15;
/// The most triangles of a part and of those around it; in meshes whose parts have more, these lie all over the mesh.
const MOST: usize = 3 * PART;
/// So many triangles may meet on a stack of common size, ...
const SURE: usize = 2000;
/// ... and on a larger one each has so many bytes: it takes about 140 in optimised builds.
const STACK: usize = 2048;

impl Scene {
    /// Gives tangents to meshes that need them for their material and have none. What is left without: meshes without
    /// texture coordinates.
    pub(crate) fn complete_tangents(&mut self) {
        self.meshes.par_iter_mut().with_max_len(1).for_each(|mesh| {
            let set = self.materials[mesh.material].tangent_set();
            if let Some(set) = set.filter(|&set| mesh.tangents.is_empty() && mesh.texcoord_set(set).is_some()) {
                mesh.tangents = tangents(mesh, set);
            }
        });
    }
}

/// Tangents of all corners, from texture coordinates of this set; zero where the direction is undefined.
pub(super) fn tangents(mesh: &Mesh, set: u32) -> Vec<[Vec4; 3]> {
    tangents_in_parts(mesh, set, PART, MOST)
}

/// The same in parts of so many triangles, unless one has more than `most` with those around it.
fn tangents_in_parts(mesh: &Mesh, set: u32, part: usize, most: usize) -> Vec<[Vec4; 3]> {
    let (work, count) = (Work::new(mesh, set), mesh.triangles.len());
    let all = || (0..count as u32).collect::<Vec<_>>();
    if count <= SURE.min(part) {
        return work.tangents_of(&all(), count);
    }
    let neighbours = Neighbours::new(&work.positions, &mesh.triangles);
    let meeting = neighbours.most_meeting();
    let of_part = |part: Range<usize>| {
        let faces = neighbours.around_all(part.clone(), |face| work.is_undecided(face), most)?;
        let mut found = work.tangents_of(&faces, meeting);
        let first = faces.partition_point(|&face| (face as usize) < part.start);
        found.truncate(first + part.len());
        Some(found.split_off(first))
    };
    let parts = (0..count).step_by(part).map(|first| first..count.min(first + part)).collect::<Vec<_>>();
    let found = match parts.len() {
        1 => None,
        _ => parts.into_par_iter().map(of_part).collect::<Option<Vec<_>>>(),
    };
    match found {
        Some(parts) => parts.concat(),
        None => work.tangents_of(&all(), meeting),
    }
}

/// A mesh in the coordinates in which normal maps apply.
struct Work<'a> {
    mesh: &'a Mesh,
    texcoords: &'a [Vec2],
    positions: Vec<Vec3>,
    /// Of normals to those coordinates, but for their length.
    normals: DMat3,
    /// The corners of triangles as they are in order there.
    order: [usize; 3],
}

impl<'a> Work<'a> {
    fn new(mesh: &'a Mesh, set: u32) -> Self {
        let space = mesh.map_space.unwrap_or(Mat3::IDENTITY).as_dmat3();
        let from_mesh = space.inverse();
        // Zeros are equal to the library, whatever their sign.
        let position = |position: &Vec3| (from_mesh * position.as_dvec3()).as_vec3() + Vec3::ZERO;
        Self {
            mesh,
            texcoords: mesh.texcoord_set(set).unwrap_or_default(),
            positions: mesh.positions.par_iter().map(position).collect(),
            normals: space.transpose(),
            order: if space.determinant() < 0.0 { [0, 2, 1] } else { [0, 1, 2] },
        }
    }

    fn corner(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][self.order[corner]] as usize
    }

    fn texcoord(&self, face: usize, corner: usize) -> Vec2 {
        let Vec2 { x, y } = self.texcoords[self.corner(face, corner)];
        Vec2::new(x, 1.0 - y)
    }

    /// Whether a triangle has so little extent, or its picture, that the library may let those around it decide whether it
    /// is mirrored.
    fn is_undecided(&self, face: usize) -> bool {
        let [a, b, c] = [0, 1, 2].map(|corner| self.texcoord(face, corner));
        let [p, q, r] = [0, 1, 2].map(|corner| self.positions[self.corner(face, corner)]);
        let (b, c, q, r) = (b - a, c - a, q - p, r - p);
        let (area, s, t) = (b.x * c.y - b.y * c.x, c.y * q - b.y * r, b.x * r - c.x * q);
        // The library's bound is the least normal number, for the area and for lengths over the area. False for NaN too.
        let is_clear = area.abs() > 1e-30 && s.length() > 1e-30 * area.abs() && t.length() > 1e-30 * area.abs();
        !is_clear
    }

    /// Tangents of these triangles, in order, of which at most `meeting` meet in a point.
    fn tangents_of(&self, faces: &[u32], meeting: usize) -> Vec<[Vec4; 3]> {
        let generate = || {
            let mut part = Part { work: self, faces, tangents: vec![[Vec4::ZERO; 3]; faces.len()] };
            // The error has no value that could occur.
            let _ = generate_tangents(&mut part);
            part.tangents
        };
        if meeting <= SURE {
            return generate();
        }
        let deep = thread::Builder::new().stack_size(STACK * meeting);
        thread::scope(|scope| match deep.spawn_scoped(scope, generate) {
            Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            // Without threads, and where there is no memory for it, the triangles are not bent by maps.
            Err(_) => vec![[Vec4::ZERO; 3]; faces.len()],
        })
    }
}

/// Some triangles of a mesh, as the library takes them.
struct Part<'a> {
    work: &'a Work<'a>,
    /// Their numbers, in order.
    faces: &'a [u32],
    tangents: Vec<[Vec4; 3]>,
}

impl Geometry for Part<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.work.positions[self.work.corner(self.faces[face] as usize, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let (Work { mesh, normals, .. }, face) = (self.work, self.faces[face] as usize);
        let normal = match mesh.normals.get(self.work.corner(face, corner)) {
            Some(normal) if mesh.map_space.is_none() => return normal.to_array(),
            Some(normal) => normal.as_dvec3(),
            None => {
                let [a, b, c] = mesh.corners(face).map(Vec3::as_dvec3);
                (b - a).cross(c - a)
            }
        };
        (*normals * normal).normalize_or_zero().as_vec3().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.work.texcoord(self.faces[face] as usize, corner).to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = tangent.map_or(Vec4::ZERO, |tangent| Vec4::from(tangent.tangent_encoded()));
        let corner = self.work.order[corner];
        self.tangents[face][corner] = if tangent.is_finite() { tangent } else { Vec4::ZERO };
    }
}

#[cfg(test)]
mod tests;
