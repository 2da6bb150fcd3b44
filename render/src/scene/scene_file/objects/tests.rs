//! Objects and instances of scene files.

use std::fs;

use glam::{Quat, Vec3};

use super::*;
use crate::scene::{Overrides, Sharing, open, open_with};

/// A triangle with a material called leaf.
const TREE: &str = "mtllib tree.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nusemtl leaf\nf 1 2 3\n";
const MATERIALS: &str = "newmtl leaf\nKd .1 .2 .3\n";

/// What a scene file with this text becomes; `%` stands for the object.
fn scene(text: &str) -> Result<Scene, SceneError> {
    with_table("", text)
}

fn with_table(table: &str, text: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("tree.obj", TREE);
    write("tree.mtl", MATERIALS);
    write("trees.csv", table);
    write("scene.toml", &text.replace('%', "[[object]]\nname = \"tree\"\nfile = \"tree.obj\"\n"));
    open(&folder.path().join("scene.toml")).map(|(scene, _)| scene)
}

/// Where corner number 1 of the tree is, for each instance.
fn tips(scene: &Scene) -> Vec<Vec3> {
    scene.instances.iter().map(|instance| instance.to_world.transform_point3(Vec3::X)).collect()
}

fn near(found: &[Vec3], expected: &[[f32; 3]]) {
    let near = |(a, b): (&Vec3, &[f32; 3])| a.distance((*b).into()) < 1e-5;
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?}");
}

#[test]
fn instances_are_scaled_then_turned_then_moved() {
    let scene = scene(
        "%[[instance]]\nof = \"tree\"\n\
         [[instance]]\nof = \"tree\"\nat = [1, 2, 3]\nrotate = [90, 90, 0]\nscale = 2\n\
         [[instance]]\nof = \"tree\"\nmatrix = [0, 0, 1, 5,  0, 1, 0, 6,  -1, 0, 0, 7]\n",
    )
    .unwrap();
    // x stays where it is when turned about x, and becomes -z about y.
    near(&tips(&scene), &[[1.0, 0.0, 0.0], [1.0, 2.0, 1.0], [5.0, 6.0, 6.0]]);
    assert_eq!((scene.triangle_count(), scene.stored_triangle_count()), (3, 1));
    assert_eq!(scene.materials[scene.meshes[0].material].name, "tree/leaf");
}

#[test]
fn instances_that_are_flattened_are_told() {
    let text = "%[[instance]]\nof = \"tree\"\nscale = 0\n\n[[instance]]\nof = \"tree\"\ntable = \"trees.csv\"\n";
    let warnings = with_table("x y z scale\n0 0 0 1\n1 0 0 0\n2 0 0 0\n3 0 0 1e-16\n", text).unwrap().warnings;
    let told: Vec<&str> = warnings.iter().map(|it| it.rsplit('/').next().unwrap()).collect();
    let why = "may not be seen: the transform flattens it, for example by a scale of 0, and flat instances are hidden \
               where they are shared";
    let expected = [(4, "1 instance of"), (8, "2 instances of")];
    assert_eq!(told, expected.map(|(line, of)| format!("scene.toml:{line}: {of} \"tree\" {why}")));
}

#[test]
fn tables_say_where_and_how_often() {
    let text = "%[[instance]]\nof = \"tree\"\nat = [0, 10, 0]\ntable = \"trees.csv\"\n";
    let found = |table: &str| tips(&with_table(table, text).unwrap());
    near(&found("x,y,z\n1,2,3\n\n# a comment\n4;5;6\n"), &[[2.0, 12.0, 3.0], [5.0, 15.0, 6.0]]);
    let half = Quat::from_rotation_y(1.0);
    let quaternions = format!("scale y x z qw qx qy qz id\n3 0 0 0 {} {} {} {} 77\n", half.w, half.x, half.y, half.z);
    near(&found(&quaternions), &[[3.0 * 1f32.cos(), 10.0, -3.0 * 1f32.sin()]]);
    near(&found("x y z rx ry rz sx sy sz\n0 0 0 0 0 90 2 1 1\n"), &[[0.0, 12.0, 0.0]]);
    // Up becomes x, and x becomes down.
    near(&found("x y z nx ny nz\n0 0 0 4 0 0\n"), &[[0.0, 9.0, 0.0]]);
}

#[test]
fn tables_may_be_points_of_ply() {
    let folder = tempfile::tempdir().unwrap();
    let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
                  property double scale\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\n\
                  end_header\n";
    let path = folder.path().join("points.ply");
    fs::write(&path, format!("{header}1 2 3 2 255\n4 5 6 1 0\n3 0 0 0\n")).unwrap();
    let tips: Vec<Vec3> = place_table::read(&path).unwrap().iter().map(|it| it.transform_point3(Vec3::X)).collect();
    near(&tips, &[[3.0, 2.0, 3.0], [5.0, 5.0, 6.0]]);
    fs::write(&path, header.replace("float z", "float w")).unwrap();
    assert!(place_table::read(&path).is_err());
    fs::write(&path, header.replace("vertex 2", "vertex 200000000000")).unwrap();
    assert!(place_table::read(&path).unwrap_err().problem.contains("too short"));
}

#[test]
fn instances_may_have_other_materials() {
    let text = "%[[material]]\nname = \"autumn\"\nbase_color = [1, 0, 0]\n\
                [[material]]\nname = \"tree/leaf\"\nbase_color = [0, 1, 0]\n\
                [[instance]]\nof = \"tree\"\n\
                [[instance]]\nof = \"tree\"\nmaterials = { leaf = \"autumn\" }\n\
                [[instance]]\nof = \"tree\"\nat = [0, 0, 1]\nmaterials = { leaf = \"autumn\" }\n";
    let scene = scene(text).unwrap();
    let color = |instance: &Instance| {
        let mesh = scene.meshes.iter().find(|mesh| mesh.object == Some(instance.object)).unwrap();
        scene.materials[mesh.material].inputs.base_color
    };
    let colors: Vec<Vec3> = scene.instances.iter().map(color).collect();
    assert_eq!(colors, [Vec3::Y, Vec3::X, Vec3::X]);
    assert_eq!(scene.objects.len(), 2, "those with the same materials share a copy");
}

#[test]
fn nothing_is_shared_if_not_wanted() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tree.obj"), TREE.replace("mtllib tree.mtl\n", "")).unwrap();
    let text = "[[object]]\nname = \"tree\"\nfile = \"tree.obj\"\n[[instance]]\nof = \"tree\"\nscale = [-1, 1, 1]\n";
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let (scene, _) = open_with(&path, &Overrides { instances: Some(Sharing::Never), ..Overrides::default() }).unwrap();
    assert!(scene.instances.is_empty() && scene.objects.is_empty() && scene.meshes[0].object.is_none());
    // The front stays the front.
    let [a, b, c] = scene.meshes[0].corners(0);
    assert!((b - a).cross(c - a).z > 0.0 && a.min(b).min(c).x == -1.0);
}

#[test]
fn errors_name_the_place_and_say_what_would_be_right() {
    let told = |text: &str| scene(text).unwrap_err().to_string();
    let instance = |rest: &str| told(&format!("%[[instance]]\nof = \"tree\"\n{rest}\n"));
    assert!(instance("at = 3").contains("scene.toml:6: instance.at is 3\n  help: expected three numbers x, y, z"));
    assert!(instance("scale = \"big\"").contains("expected one number, or three numbers x, y, z"));
    assert!(
        instance("rotat = [0, 0, 0]").contains("unknown key \"rotat\" of an instance\n  help: did you mean `rotate`?")
    );
    assert!(instance("matrix = [1, 2]").contains("expected 12 or 16 numbers, row by row"));
    assert!(instance("matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1]").contains("a fourth row is 0, 0, 0, 1"));
    assert!(instance("at = [0,0,0]\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0]").contains("both matrix and at"));
    assert!(instance("table = \"no.csv\"").contains("no.csv, which does not exist"));
    assert!(instance("materials = { bark = \"x\" }").contains("the object has no material \"tree/bark\""));
    assert!(instance("materials = { leaf = \"x\" }").contains("the scene has no material \"x\""));
    assert!(told("%[[instance]]\nat = [0, 0, 0]\n").contains(":4: this instance has no of"));
    assert!(told("%[[instance]]\nof = \"tre\"\n").contains("there is no object \"tre\"\n  help: did you mean `tree`?"));
    assert!(told("%%").contains("there is another object \"tree\""));
    assert!(told("[[object]]\nname = \"a\"\nfile = \"scene.toml\"").contains("an object is a model, not a scene file"));
    let table =
        |rows: &str| with_table(rows, "%[[instance]]\nof = \"tree\"\ntable = \"trees.csv\"\n").unwrap_err().to_string();
    assert!(table("1,2,3\n").contains("trees.csv:1: the first line has no names"));
    assert!(table("x,y\n1,2\n").contains("there is a column x, but none called z"));
    assert!(table("x,y,z,scale,sx,sy,sz\n").contains("there are both scale and sx"));
    assert!(table("x,y,z\n1,2\n").contains(":2: this line has 2 values"));
    assert!(table("x,y,z\n1,2,a\n").contains("`a` is not a number"));
    assert!(table("x,y,z\n1,2,inf\n").contains("z is inf, which is not finite"));
    assert!(table("x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0\n").contains("the quaternion is zero"));
    assert!(table("").contains("the table is empty"));
}
