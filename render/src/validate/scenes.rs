//! Parts of the experiments' scenes. All are grey.

use glam::{DVec3, Vec3};

use crate::scene::{CameraPose, Material, Mesh, Scene};
use crate::world::World;

/// A triangle, with its front on the side from which its corners run counter-clockwise.
pub(super) type Corners = [Vec3; 3];

/// The sphere about the origin of `20 · 4^level` triangles, fronts outside, with the surface of a sphere of this
/// radius: by Cauchy's theorem it then hides as much as that sphere does, on average over directions.
pub(super) fn sphere(level: u32, radius: f32) -> Vec<Corners> {
    let mut triangles = icosahedron();
    for _ in 0..level {
        let split = |[a, b, c]: [DVec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    let area: f64 = triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
    let scale = f64::from(radius) * (4.0 * std::f64::consts::PI / area).sqrt();
    triangles.into_iter().map(|corners| corners.map(|corner| (corner * scale).as_vec3())).collect()
}

/// The twelve corners are those of three golden rectangles.
fn icosahedron() -> Vec<[DVec3; 3]> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut corners = Vec::new();
    for axis in 0..3 {
        for (short, long) in [(-1.0, -golden), (-1.0, golden), (1.0, -golden), (1.0, golden)] {
            let mut corner = DVec3::ZERO;
            (corner[axis], corner[(axis + 1) % 3]) = (short, long);
            corners.push(corner.normalize());
        }
    }
    // Neighbours are nearer than any others: the edge is 1.05 radii, the next distance 1.7.
    let near = |a: DVec3, b: DVec3| a.distance(b) < 1.2;
    let mut triangles = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outside = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outside { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    triangles
}

/// A tetrahedron about the origin with edges of √8, fronts outside.
pub(super) fn tetrahedron() -> Vec<Corners> {
    let [a, b, c, d] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vec3::from);
    vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]]
}

/// The box from -1 to 1, fronts outside; the first two triangles are its top, at y = 1.
pub(super) fn cube() -> Vec<Corners> {
    let face = |axis: usize, side: f32| {
        let at = |a: f32, b: f32| {
            let mut point = Vec3::ZERO;
            (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, a * side, b);
            point
        };
        quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)])
    };
    [1, 2, 0].into_iter().flat_map(|axis| [face(axis, 1.0), face(axis, -1.0)]).flatten().collect()
}

/// Two triangles of a flat quadrilateral.
pub(super) fn quad([a, b, c, d]: [Vec3; 4]) -> [Corners; 2] {
    [[a, b, c], [a, c, d]]
}

/// The ground: y = 0 up to `half` from the origin, front up.
pub(super) fn ground(half: f32) -> [Corners; 2] {
    quad([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Vec3::new(x, 0.0, z) * half))
}

/// The same triangles with their fronts on the other side.
pub(super) fn turned(triangles: &[Corners]) -> Vec<Corners> {
    triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

/// The same triangles elsewhere.
pub(super) fn moved(triangles: &[Corners], by: Vec3) -> Vec<Corners> {
    triangles.iter().map(|corners| corners.map(|corner| corner + by)).collect()
}

/// A mesh of triangles of the scene's material of this index.
pub(super) fn mesh(triangles: &[Corners], material: usize) -> Mesh {
    let corners = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh { positions: triangles.concat(), triangles: corners.collect(), material, ..Mesh::default() }
}

/// A grey diffuse surface.
pub(super) fn grey(reflectance: f32, emission: f32) -> Material {
    Material { emission: Vec3::splat(emission), ..Material::matte(Vec3::splat(reflectance)) }
}

/// A scene of meshes, each with a material of its own, and a camera.
pub(super) fn scene<'a>(parts: impl IntoIterator<Item = (&'a [Corners], Material)>, camera: CameraPose) -> Scene {
    let mut scene = Scene { camera: Some(camera), ..Scene::default() };
    for (triangles, material) in parts {
        scene.meshes.push(mesh(triangles, scene.materials.len()));
        scene.materials.push(material);
    }
    scene
}

/// The scene, ready for tracing. Its camera may be moved.
pub(super) fn world(scene: Scene) -> World {
    World::new(scene).expect("the experiments' scenes have cameras and few triangles")
}

/// A camera at `eye` that sees a quarter turn.
pub(super) fn view(eye: Vec3, target: Vec3) -> CameraPose {
    CameraPose { eye, target, up: (target - eye).any_orthogonal_vector(), vfov: 90.0 }
}

/// A camera so near to `point`, on the side of the unit vector `normal`, that all of its pixels see the same place and
/// nothing is between: a light meter.
pub(super) fn meter(point: Vec3, normal: Vec3) -> CameraPose {
    CameraPose { eye: point + normal * 0.01, target: point, up: normal.any_orthogonal_vector(), vfov: 0.01 }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    fn area(triangles: &[Corners]) -> f32 {
        triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Every edge belongs to two triangles, which run along it in opposite directions, and fronts look outside.
    #[test]
    fn solids_are_closed() {
        for (triangles, count) in [(sphere(0, 1.0), 20), (sphere(2, 3.0), 320), (tetrahedron(), 4), (cube(), 12)] {
            assert_eq!(triangles.len(), count);
            let bits = |v: Vec3| v.to_array().map(f32::to_bits);
            let edges: Vec<_> =
                triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|edge| edge.map(bits)).collect();
            assert!(edges.iter().all(|&[a, b]| edges.iter().filter(|&&edge| edge == [b, a]).count() == 1));
            for [a, b, c] in &triangles {
                assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
            }
            let inside = turned(&triangles);
            assert!(inside.iter().all(|[a, b, c]| (b - a).cross(c - a).dot(a + b + c) < 0.0));
        }
    }

    #[test]
    fn solids_have_their_areas() {
        for level in 0..4 {
            assert!((area(&sphere(level, 2.0)) / (16.0 * PI) - 1.0).abs() < 1e-5);
        }
        assert_eq!(area(&cube()), 24.0);
        assert!((area(&tetrahedron()) - 8.0 * 3f32.sqrt()).abs() < 1e-5);
        assert_eq!(area(&ground(3.0)), 36.0);
        for [a, b, c] in &cube()[..2] {
            assert_eq!([a.y, b.y, c.y], [1.0; 3]);
        }
        assert!(ground(1.0).iter().all(|[a, b, c]| (b - a).cross(c - a).normalize() == Vec3::Y));
    }
}
