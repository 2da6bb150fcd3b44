//! The Cornell box, which needs no file.
//!
//! Geometry, camera and the light's reflectance (78 %) are the measured ones that the Cornell University Program of
//! Computer Graphics published ("Cornell Box Data", 1998), from millimetres to metres. Deviations: the spectra of walls
//! and light are replaced by linear sRGB triples in common use, and the light hangs 0.1 mm below the ceiling instead of
//! in it, so that neither hides the other.

use glam::Vec3;

use super::{CameraPose, Material, Mesh, Scene};

/// Corners of a quadrilateral in millimetres, counter-clockwise seen from its front.
type Quad = [[f32; 3]; 4];

/// A divisor, for 1 / 1000 is no 32-bit float: so 556 mm become the float nearest to 0.556.
const MILLIMETRES_PER_METRE: f32 = 1000.0;

const FLOOR: Quad = [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]];
const CEILING: Quad = [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]];
const BACK_WALL: Quad = [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]];
const RIGHT_WALL: Quad = [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]];
const LEFT_WALL: Quad = [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]];
const LIGHT: Quad = [[343.0, 548.7, 227.0], [343.0, 548.7, 332.0], [213.0, 548.7, 332.0], [213.0, 548.7, 227.0]];

/// The short block's corners on the floor, `[x, z]`, in the order in which its top is counter-clockwise.
const SHORT_BLOCK: [[f32; 2]; 4] = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
const SHORT_HEIGHT: f32 = 165.0;
/// The tall block's, likewise.
const TALL_BLOCK: [[f32; 2]; 4] = [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]];
const TALL_HEIGHT: f32 = 330.0;

const WHITE: Vec3 = Vec3::splat(0.73);
const RED: Vec3 = Vec3::new(0.57, 0.043, 0.044);
const GREEN: Vec3 = Vec3::new(0.105, 0.378, 0.077);
const LIGHT_REFLECTANCE: Vec3 = Vec3::splat(0.78);
/// W/(m² sr).
const LIGHT_RADIANCE: Vec3 = Vec3::new(18.4, 15.6, 8.0);

/// The camera's film and focal length in metres: a square of 25 mm behind a lens of 35 mm.
const FILM_HEIGHT: f32 = 0.025;
const FOCAL_LENGTH: f32 = 0.035;

/// The Cornell box in metres, with a square picture's camera: white floor, ceiling, back wall and blocks, a red wall on
/// the left, a green one on the right, open at the front. All front faces look into the room, the light's face down.
pub fn cornell_box() -> Scene {
    let material = |name: &str, albedo| Material { name: name.to_owned(), ..Material::matte(albedo) };
    let light = Material { emission: LIGHT_RADIANCE, ..material("light", LIGHT_REFLECTANCE) };
    let materials = vec![material("white", WHITE), material("red", RED), material("green", GREEN), light];
    let meshes = vec![
        mesh("floor", 0, &[FLOOR]),
        mesh("ceiling", 0, &[CEILING]),
        mesh("back wall", 0, &[BACK_WALL]),
        mesh("left wall", 1, &[LEFT_WALL]),
        mesh("right wall", 2, &[RIGHT_WALL]),
        mesh("short block", 0, &block(SHORT_BLOCK, SHORT_HEIGHT)),
        mesh("tall block", 0, &block(TALL_BLOCK, TALL_HEIGHT)),
        mesh("light", 3, &[LIGHT]),
    ];
    let camera = CameraPose {
        eye: Vec3::new(278.0, 273.0, -800.0) / MILLIMETRES_PER_METRE,
        target: Vec3::new(278.0, 273.0, 0.0) / MILLIMETRES_PER_METRE,
        up: Vec3::Y,
        vfov: 2.0 * (0.5 * FILM_HEIGHT / FOCAL_LENGTH).atan().to_degrees(),
    };
    Scene { meshes, materials, camera: Some(camera), ..Scene::default() }
}

/// The top and the four sides of a block that stands on the floor.
fn block(corners: [[f32; 2]; 4], height: f32) -> [Quad; 5] {
    let at = |i: usize, y| [corners[i % 4][0], y, corners[i % 4][1]];
    let side = |i| [at(i + 1, 0.0), at(i + 1, height), at(i, height), at(i, 0.0)];
    let top = [0, 1, 2, 3].map(|i| at(i, height));
    [top, side(0), side(1), side(2), side(3)]
}

/// Two triangles for every quadrilateral.
fn mesh(name: &str, material: usize, quads: &[Quad]) -> Mesh {
    let positions = quads.iter().flatten().map(|&corner| Vec3::from(corner) / MILLIMETRES_PER_METRE).collect();
    let first = (0..quads.len() as u32).map(|quad| 4 * quad);
    let triangles = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
    Mesh { name: name.to_owned(), positions, triangles, material, ..Mesh::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area of each triangle, times its unit normal.
    fn crosses<'a>(scene: &'a Scene, name: &str) -> impl Iterator<Item = (Vec3, Vec3)> + 'a {
        let mesh = scene.meshes.iter().find(|mesh| mesh.name == name).unwrap();
        mesh.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            ((b - a).cross(c - a), (a + b + c) / 3.0)
        })
    }

    fn area(scene: &Scene, name: &str) -> f32 {
        crosses(scene, name).map(|(cross, _)| 0.5 * cross.length()).sum()
    }

    #[test]
    fn all_fronts_of_the_room_look_at_a_point_in_its_air() {
        let scene = cornell_box();
        let air = Vec3::new(0.278, 0.45, 0.1);
        for name in ["floor", "ceiling", "back wall", "left wall", "right wall", "light"] {
            for (cross, middle) in crosses(&scene, name) {
                assert!(cross.dot(air - middle) > 0.0, "{name}");
            }
        }
    }

    #[test]
    fn all_fronts_of_the_blocks_look_outwards() {
        let scene = cornell_box();
        for (name, middle) in [("short block", [0.186, 0.08, 0.169]), ("tall block", [0.368, 0.16, 0.351])] {
            assert_eq!(crosses(&scene, name).count(), 10);
            for (cross, centroid) in crosses(&scene, name) {
                assert!(cross.dot(centroid - Vec3::from(middle)) > 0.0, "{name}");
            }
        }
    }

    #[test]
    fn the_light_faces_down_and_has_the_published_area() {
        let scene = cornell_box();
        for (cross, middle) in crosses(&scene, "light") {
            assert_eq!(cross.normalize(), Vec3::NEG_Y);
            assert!(middle.y < 0.5488);
        }
        assert!((area(&scene, "light") - 0.130 * 0.105).abs() < 1e-7);
        let emitters: Vec<_> = scene.materials.iter().filter(|material| material.emission != Vec3::ZERO).collect();
        assert_eq!(emitters.len(), 1);
        assert!(!emitters[0].emits_both_sides);
    }

    #[test]
    fn walls_have_their_areas() {
        let scene = cornell_box();
        let trapezium = 0.5 * (0.5528 + 0.5496) * 0.5592;
        assert!((area(&scene, "floor") - trapezium).abs() < 1e-6);
        assert!((area(&scene, "ceiling") - 0.556 * 0.5592).abs() < 1e-6);
        assert!((area(&scene, "right wall") - 0.5488 * 0.5592).abs() < 1e-6);
        assert_eq!(scene.triangle_count(), 32);
    }

    #[test]
    fn the_red_wall_is_left_in_the_picture_and_the_camera_sees_the_opening() {
        let scene = cornell_box();
        let camera = scene.camera.unwrap();
        let right = (camera.target - camera.eye).cross(camera.up).normalize();
        let (_, red) = crosses(&scene, "left wall").next().unwrap();
        assert!(right.dot(red - camera.eye) < -0.2);
        assert_eq!(scene.materials[1].name, "red");
        assert!((camera.vfov - 39.307_7).abs() < 1e-3);
    }
}
