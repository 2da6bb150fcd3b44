//! A furnished room: a table with chairs, a shelf of books, a sofa, a ball, and a lamp that mostly lights the ceiling,
//! so that most light is indirect. In metres, y up.

use glam::{Vec3, vec3};

use super::scenes::{Corners, cube, mesh, moved, quad, sphere, turned};
use crate::scene::{CameraPose, Material, Mesh, Scene};

/// The size of the room, from the origin.
const SIZE: Vec3 = vec3(5.0, 2.6, 4.0);

/// Reflectances.
const PLASTER: Vec3 = vec3(0.75, 0.73, 0.7);
const PARQUET: Vec3 = vec3(0.45, 0.3, 0.18);
const BLUE: Vec3 = vec3(0.2, 0.32, 0.5);
const WOOD: Vec3 = vec3(0.55, 0.38, 0.22);
const LINEN: Vec3 = vec3(0.6, 0.22, 0.16);
const BOOKS: [Vec3; 3] = [vec3(0.5, 0.12, 0.1), vec3(0.12, 0.3, 0.16), vec3(0.65, 0.6, 0.45)];
const CHINA: Vec3 = vec3(0.8, 0.8, 0.78);

/// The room, seen from one of its corners; 1,644 triangles, of which those of the ball alone are smooth.
pub fn furnished_room() -> Scene {
    let camera = CameraPose { eye: vec3(4.7, 1.65, 3.8), target: vec3(1.8, 0.75, 1.2), up: Vec3::Y, vfov: 62.0 };
    let mut scene = Scene { camera: Some(camera), ..Scene::default() };
    let mut add = |name: &str, triangles: &[Corners], albedo, emission| {
        let material = scene.materials.len();
        scene.materials.push(Material { name: name.to_owned(), emission, ..Material::matte(albedo) });
        scene.meshes.push(Mesh { name: name.to_owned(), ..mesh(triangles, material) });
    };
    // The faces of a cube: top, bottom, then front and back, then the sides.
    let walls = turned(&block(Vec3::ZERO, SIZE));
    add("ceiling", &walls[..2], PLASTER, Vec3::ZERO);
    add("floor", &walls[2..4], PARQUET, Vec3::ZERO);
    add("walls", &walls[4..10], PLASTER, Vec3::ZERO);
    add("blue wall", &walls[10..], BLUE, Vec3::ZERO);
    let tables: Vec<Corners> =
        [table(), chair(1.6, 1.0, 1.0), chair(2.5, 1.0, 1.0), chair(1.6, 2.3, -1.0), chair(2.5, 2.3, -1.0)].concat();
    add("table and chairs", &tables, WOOD, Vec3::ZERO);
    add("shelf", &shelf(), WOOD, Vec3::ZERO);
    for (number, colour) in BOOKS.into_iter().enumerate() {
        add("books", &books(number), colour, Vec3::ZERO);
    }
    add("sofa", &sofa(), LINEN, Vec3::ZERO);
    add(
        "lamp's foot",
        &[
            block(vec3(4.24, 0.0, 0.34), vec3(4.56, 0.03, 0.66)),
            block(vec3(4.385, 0.03, 0.485), vec3(4.415, 1.7, 0.515)),
        ]
        .concat(),
        BOOKS[2],
        Vec3::ZERO,
    );
    add("lamp's bowl", &block(vec3(4.2, 1.7, 0.3), vec3(4.6, 1.78, 0.7)), PLASTER, Vec3::ZERO);
    add(
        "lamp",
        &turned(&ceiling_of(vec3(4.22, 1.785, 0.32), vec3(4.58, 1.785, 0.68))),
        Vec3::ZERO,
        vec3(60.0, 52.0, 40.0),
    );
    add("panel", &ceiling_of(vec3(1.7, 2.59, 1.5), vec3(2.4, 2.59, 1.8)), Vec3::ZERO, vec3(6.0, 6.0, 5.6));
    add("ball", &moved(&sphere(2, 0.16), BALL), CHINA, Vec3::ZERO);
    let ball = scene.meshes.last_mut().expect("it was added");
    ball.normals = ball.positions.iter().map(|position| (*position - BALL).normalize()).collect();
    scene
}

/// The middle of the ball, which lies on the table.
const BALL: Vec3 = vec3(2.35, 0.91, 1.6);

/// A box between two corners, fronts outside.
fn block(lower: Vec3, upper: Vec3) -> Vec<Corners> {
    let place = |corner: Vec3| lower.midpoint(upper) + 0.5 * (upper - lower) * corner;
    cube().into_iter().map(|corners| corners.map(place)).collect()
}

/// A rectangle at one height, front down.
fn ceiling_of(lower: Vec3, upper: Vec3) -> [Corners; 2] {
    let at = |x, z| vec3(x, lower.y, z);
    quad([at(lower.x, lower.z), at(upper.x, lower.z), at(upper.x, upper.z), at(lower.x, upper.z)])
}

/// Four legs from the floor up to `height`, under a board from `lower` to `upper` seen from above.
fn legs([x0, z0]: [f32; 2], [x1, z1]: [f32; 2], height: f32, width: f32) -> Vec<Corners> {
    let leg = |x: f32, z: f32| block(vec3(x, 0.0, z), vec3(x + width, height, z + width));
    [leg(x0, z0), leg(x1 - width, z0), leg(x0, z1 - width), leg(x1 - width, z1 - width)].concat()
}

fn table() -> Vec<Corners> {
    [block(vec3(1.3, 0.71, 1.2), vec3(2.8, 0.75, 2.1)), legs([1.35, 1.25], [2.75, 2.05], 0.71, 0.06)].concat()
}

/// A chair about a point of the floor, its back away from the table along `facing`, 1 or -1.
fn chair(x: f32, z: f32, facing: f32) -> Vec<Corners> {
    let seat = block(vec3(x - 0.21, 0.43, z - 0.21), vec3(x + 0.21, 0.46, z + 0.21));
    let edge = z - 0.2 * facing;
    let post = |x: f32| block(vec3(x - 0.02, 0.46, edge - 0.015), vec3(x + 0.02, 0.95, edge + 0.015));
    let back = block(vec3(x - 0.17, 0.7, edge - 0.01), vec3(x + 0.17, 0.92, edge + 0.01));
    let legs = legs([x - 0.2, z - 0.2], [x + 0.2, z + 0.2], 0.43, 0.04);
    [seat, post(x - 0.19), post(x + 0.19), back, legs].concat()
}

/// Two sides and five boards against the wall at x = 0.
fn shelf() -> Vec<Corners> {
    let side = |z: f32| block(vec3(0.002, 0.0, z), vec3(0.35, 1.9, z + 0.03));
    let board = |i: i32| {
        let y = 0.08 + 0.4 * i as f32;
        block(vec3(0.002, y, 1.03), vec3(0.34, y + 0.025, 2.47))
    };
    (0..5).flat_map(board).chain(side(1.0)).chain(side(2.47)).collect()
}

/// Every third book on the shelf, from number `first` on; each shelf is two thirds full.
fn books(first: usize) -> Vec<Corners> {
    let book = |i: usize| {
        let (row, place) = (i / 14, i % 14);
        // Heights and depths that repeat only after the row.
        let (height, depth) = (0.2 + 0.02 * (i * 5 % 7) as f32, 0.16 + 0.02 * (i * 3 % 5) as f32);
        let (y, z) = (0.105 + 0.4 * row as f32, 1.05 + 0.068 * place as f32 + 0.25 * (row % 2) as f32);
        block(vec3(0.02, y, z), vec3(0.02 + depth, y + height, z + 0.062))
    };
    (0..56).skip(first).step_by(3).flat_map(book).collect()
}

fn sofa() -> Vec<Corners> {
    let part = |lower: [f32; 3], upper: [f32; 3]| block(lower.into(), upper.into());
    [
        part([1.4, 0.12, 0.05], [3.4, 0.4, 0.8]),
        part([1.4, 0.4, 0.05], [3.4, 0.85, 0.25]),
        part([1.2, 0.12, 0.05], [1.4, 0.6, 0.8]),
        part([3.4, 0.12, 0.05], [3.6, 0.6, 0.8]),
        part([1.42, 0.4, 0.26], [2.39, 0.52, 0.79]),
        part([2.41, 0.4, 0.26], [3.38, 0.52, 0.79]),
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_furnished_and_everything_stands_inside() {
        let scene = furnished_room();
        assert_eq!(scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>(), 1644);
        for position in scene.meshes.iter().flat_map(|mesh| &mesh.positions) {
            assert!(position.cmpge(Vec3::ZERO).all() && position.cmple(SIZE).all(), "{position}");
        }
        for mesh in scene.meshes.iter().filter(|mesh| mesh.name.contains("ball")) {
            assert_eq!(mesh.normals.len(), mesh.positions.len());
        }
    }

    /// The walls and the panel look into the room, the lamp looks up.
    #[test]
    fn fronts_are_where_light_is() {
        let scene = furnished_room();
        let middle = 0.5 * SIZE;
        for mesh in &scene.meshes {
            for face in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(face);
                let normal = (b - a).cross(c - a);
                match mesh.name.as_str() {
                    "ceiling" | "floor" | "walls" | "blue wall" => assert!(normal.dot(middle - a) > 0.0),
                    "lamp" => assert!(normal.y > 0.0),
                    "panel" => assert!(normal.y < 0.0),
                    _ => {}
                }
            }
        }
    }
}
