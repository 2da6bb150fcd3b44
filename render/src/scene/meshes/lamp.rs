//! Lamps of simple shapes: meshes of emissive triangles, visible to cameras, mirrors and bounces.
//!
//! A mesh has exactly the area of its shape, and so the same power: discs are fans of [`SIDES`] triangles, spheres are
//! icosahedra whose faces are subdivided [`LEVELS`] times (1280 triangles) with the sphere's normals. Both are a little
//! larger than their shape across corners: a disc by 0.08% of its radius, a sphere by 0.3%.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use crate::scene::description::Mesh;
use crate::scene::{Material, Scene};

/// Triangles of a disc.
const SIDES: u32 = 64;
/// How often each face of the icosahedron is parted into four.
const LEVELS: u32 = 3;

/// A surface that emits evenly, and is black otherwise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lamp {
    pub name: String,
    /// The light group that it is in, or empty.
    pub group: String,
    pub position: Vec3,
    pub shape: Shape,
    /// W/(m² sr).
    pub radiance: Vec3,
}

/// The appearance of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Emits outwards.
    Sphere { radius: f32 },
    /// Emits along a unit vector.
    Disc { radius: f32, direction: Vec3, two_sided: bool },
    /// Emits along a unit vector; its height is along another one, at a right angle to the first.
    Rectangle { size: Vec2, direction: Vec3, up: Vec3, two_sided: bool },
}

impl Shape {
    /// The area of all emitting sides.
    pub(crate) fn area(&self) -> f64 {
        let sides = |two: bool| if two { 2.0 } else { 1.0 };
        match *self {
            Self::Sphere { radius } => 4.0 * PI * f64::from(radius).powi(2),
            Self::Disc { radius, two_sided, .. } => sides(two_sided) * PI * f64::from(radius).powi(2),
            Self::Rectangle { size, two_sided, .. } => sides(two_sided) * f64::from(size.x) * f64::from(size.y),
        }
    }

    fn is_two_sided(&self) -> bool {
        matches!(self, Self::Disc { two_sided: true, .. } | Self::Rectangle { two_sided: true, .. })
    }

    /// Corners about the origin, normals if it is round, and triangles.
    fn mesh(&self) -> (Vec<DVec3>, Vec<Vec3>, Vec<[u32; 3]>) {
        match *self {
            Self::Sphere { radius } => {
                let (directions, triangles) = icosphere();
                let area: f64 = triangles.iter().map(|face| area(face.map(|i| directions[i as usize]))).sum();
                let scale = f64::from(radius) * (4.0 * PI / area).sqrt();
                let positions = directions.iter().map(|&direction| direction * scale).collect();
                (positions, directions.into_iter().map(DVec3::as_vec3).collect(), triangles)
            }
            Self::Disc { radius, direction, .. } => {
                let (x, y) = direction.as_dvec3().any_orthonormal_pair();
                let step = TAU / f64::from(SIDES);
                let scale = f64::from(radius) * (step / step.sin()).sqrt();
                let rim = (0..SIDES).map(|i| f64::from(i) * step).map(|a| (x * a.cos() + y * a.sin()) * scale);
                let triangles = (0..SIDES).map(|i| [0, 1 + i, 1 + (i + 1) % SIDES]).collect();
                (core::iter::once(DVec3::ZERO).chain(rim).collect(), Vec::new(), triangles)
            }
            Self::Rectangle { size, direction, up, .. } => {
                let (direction, up) = (direction.as_dvec3(), up.as_dvec3());
                let (x, y) = (up.cross(direction) * f64::from(0.5 * size.x), up * f64::from(0.5 * size.y));
                (vec![-x - y, x - y, x + y, y - x], Vec::new(), vec![[0, 1, 2], [0, 2, 3]])
            }
        }
    }
}

impl Lamp {
    /// Adds it to a scene, with a material of its own.
    pub(crate) fn add_to(&self, scene: &mut Scene) {
        let (positions, normals, triangles) = self.shape.mesh();
        let positions = positions.into_iter().map(|p| (self.position.as_dvec3() + p).as_vec3()).collect();
        let (name, material) = (self.name.clone(), scene.materials.len());
        scene.meshes.push(Mesh { name, positions, normals, triangles, material, is_added: true, ..Mesh::default() });
        scene.materials.push(Material {
            name: self.name.clone(),
            light_group: self.group.clone(),
            emission: self.radiance,
            emits_both_sides: self.shape.is_two_sided(),
            ..Material::matte(Vec3::ZERO)
        });
    }
}

/// Unit vectors to the corners of an icosahedron whose faces are parted, and its faces, counter-clockwise from outside.
fn icosphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    // Three rectangles at right angles to one another.
    let corners = [[-1.0, golden], [1.0, golden], [-1.0, -golden], [1.0, -golden]];
    let (xy, yz, zx) = (
        corners.map(|[a, b]| DVec3::new(a, b, 0.0)),
        corners.map(|[a, b]| DVec3::new(0.0, a, b)),
        corners.map(|[a, b]| DVec3::new(b, 0.0, a)),
    );
    let mut directions: Vec<DVec3> = [xy, yz, zx].concat().into_iter().map(DVec3::normalize).collect();
    let mut faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..LEVELS {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        let parts = faces.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        faces = parts.collect();
    }
    (directions, faces)
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> [Shape; 3] {
        let direction = Vec3::new(1.0, -2.0, 2.0) / 3.0;
        let up = Vec3::new(2.0, 2.0, 1.0) / 3.0;
        [
            Shape::Sphere { radius: 0.7 },
            Shape::Disc { radius: 0.7, direction, two_sided: false },
            Shape::Rectangle { size: Vec2::new(3.0, 0.5), direction, up, two_sided: false },
        ]
    }

    #[test]
    fn meshes_have_the_area_of_their_shape_and_face_where_it_shines() {
        for (shape, count) in shapes().into_iter().zip([1280, 64, 2]) {
            let position = Vec3::new(1.0, 2.0, 3.0);
            let mut scene = Scene::default();
            Lamp { name: "lamp".to_owned(), group: String::new(), position, shape, radiance: Vec3::ONE }
                .add_to(&mut scene);
            let mesh = &scene.meshes[0];
            assert_eq!(mesh.triangles.len(), count);
            let mut sum = 0.0;
            for face in 0..count {
                let corners = mesh.corners(face).map(|p| p.as_dvec3());
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).as_vec3();
                sum += area(corners);
                let front = match shape {
                    Shape::Sphere { .. } => corners[0].as_vec3() - position,
                    Shape::Disc { direction, .. } | Shape::Rectangle { direction, .. } => direction,
                };
                assert!(normal.normalize().dot(front.normalize()) > 0.99, "{shape:?}, face {face}");
            }
            assert!((sum / shape.area() - 1.0).abs() < 1e-6, "{shape:?}: {sum}");
        }
        let both = Shape::Disc { radius: 1.0, direction: Vec3::Y, two_sided: true };
        assert!((both.area() - TAU).abs() < 1e-12);
    }

    #[test]
    fn spheres_are_nearly_round_and_rectangles_upright() {
        let (positions, normals, _) = Shape::Sphere { radius: 2.0 }.mesh();
        for (position, normal) in positions.iter().zip(&normals) {
            assert!((position.length() / 2.0 - 1.0).abs() < 0.004, "{}", position.length());
            assert!((position.normalize().as_vec3() - normal).length() < 1e-6);
        }
        let (direction, up) = (Vec3::NEG_Y, Vec3::Z);
        let (corners, ..) = Shape::Rectangle { size: Vec2::new(4.0, 1.0), direction, up, two_sided: false }.mesh();
        for corner in corners {
            assert_eq!((corner.x.abs(), corner.y, corner.z.abs()), (2.0, 0.0, 0.5));
        }
    }
}
