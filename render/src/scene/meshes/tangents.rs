//! Tangents for meshes that have none: MikkTSpace (Mikkelsen 2008), by which most programs make their normal maps.
//!
//! It is given texture coordinates with v upwards, so that bitangents point up in pictures, as glTF has them, and
//! positions and normals in the coordinates in which normal maps apply.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DMat3, Mat3, Vec3, Vec4};
use rayon::prelude::*;

use crate::scene::{Mesh, Scene};

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

/// Tangents of all corners, from texture coordinates of this set.
pub(super) fn tangents(mesh: &Mesh, set: u32) -> Vec<[Vec4; 3]> {
    let space = mesh.map_space.unwrap_or(Mat3::IDENTITY).as_dmat3();
    let tangents = vec![[Vec4::ZERO; 3]; mesh.triangles.len()];
    let order = if space.determinant() < 0.0 { [0, 2, 1] } else { [0, 1, 2] };
    let mut work = Work { mesh, set, from_mesh: space.inverse(), normals: space.transpose(), order, tangents };
    // The error has no value that could occur.
    let _ = generate_tangents(&mut work);
    work.tangents
}

struct Work<'a> {
    mesh: &'a Mesh,
    set: u32,
    /// Of positions and of normals, but for their length, to the coordinates in which normal maps apply.
    from_mesh: DMat3,
    normals: DMat3,
    /// The corners of triangles as they are in order there.
    order: [usize; 3],
    /// Zero where the direction is undefined.
    tangents: Vec<[Vec4; 3]>,
}

impl Work<'_> {
    fn corner(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][self.order[corner]] as usize
    }
}

impl Geometry for Work<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        (self.from_mesh * self.mesh.positions[self.corner(face, corner)].as_dvec3()).as_vec3().to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let normal = match self.mesh.normals.get(self.corner(face, corner)) {
            Some(normal) if self.mesh.map_space.is_none() => return normal.to_array(),
            Some(normal) => normal.as_dvec3(),
            None => {
                let [a, b, c] = self.mesh.corners(face).map(Vec3::as_dvec3);
                (b - a).cross(c - a)
            }
        };
        (self.normals * normal).normalize_or_zero().as_vec3().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let texcoords = self.mesh.texcoord_set(self.set).unwrap_or_default();
        let texcoord = texcoords[self.corner(face, corner)];
        [texcoord.x, 1.0 - texcoord.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = tangent.map_or(Vec4::ZERO, |tangent| Vec4::from(tangent.tangent_encoded()));
        let corner = self.order[corner];
        self.tangents[face][corner] = if tangent.is_finite() { tangent } else { Vec4::ZERO };
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::scene::{ColorSpace, Material, NormalMap, TextureMap};

    /// A square seen from +z; texture coordinates go right and down, or are given.
    fn square(texcoords: [[f32; 2]; 4]) -> Mesh {
        Mesh {
            positions: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).into(),
            texcoords: texcoords.map(Vec2::from).into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    }

    const UPRIGHT: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

    #[test]
    fn tangents_point_right_and_bitangents_up_in_pictures() {
        for (texcoords, expected) in [
            (UPRIGHT, Vec4::new(1.0, 0.0, 0.0, 1.0)),
            // The mirrored picture: right is -x, and up needs the other sign.
            (UPRIGHT.map(|[u, v]| [1.0 - u, v]), Vec4::new(-1.0, 0.0, 0.0, -1.0)),
            // A quarter turn: u goes up, v right.
            (UPRIGHT.map(|[u, v]| [1.0 - v, u]), Vec4::new(0.0, 1.0, 0.0, 1.0)),
        ] {
            for corner in tangents(&square(texcoords), 0).into_iter().flatten() {
                assert!((corner - expected).abs().max_element() < 1e-6, "{corner}, not {expected}");
            }
        }
    }

    #[test]
    fn only_meshes_that_need_tangents_get_them() {
        let texture = TextureMap { space: ColorSpace::Linear, ..TextureMap::default() };
        let normal_map = Some(NormalMap { texture, scale: Vec2::ONE });
        let mut bare = square(UPRIGHT);
        bare.texcoords.clear();
        bare.material = 1;
        let mut given = square(UPRIGHT);
        (given.material, given.tangents) = (1, vec![[Vec4::X; 3]; 2]);
        let needy = Mesh { material: 1, ..square(UPRIGHT) };
        let materials = vec![Material::default(), Material { normal_map, ..Material::default() }];
        let mut scene = Scene { meshes: vec![square(UPRIGHT), bare, given, needy], materials, ..Scene::default() };
        scene.complete_tangents();
        let lengths = scene.meshes.iter().map(|mesh| mesh.tangents.len()).collect::<Vec<_>>();
        assert_eq!(lengths, [0, 0, 2, 2]);
        assert_eq!(scene.meshes[2].tangents[0][0], Vec4::X);
    }

    #[test]
    fn triangles_without_extent_have_no_tangent_and_no_nan() {
        let found = tangents(&square([[0.5; 2]; 4]), 0);
        assert!(found.iter().flatten().all(|tangent| tangent.is_finite()), "{found:?}");
        let mut point = square(UPRIGHT);
        point.positions = vec![Vec3::ONE; 4];
        assert!(tangents(&point, 0).iter().flatten().all(|tangent| tangent.is_finite()));
    }
}
