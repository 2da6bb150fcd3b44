use glam::{Vec2, Vec3};

use super::*;
use crate::scene::{Disk, Place};

fn parse(text: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    read(&Disk, Path::new("model.obj"), text.as_ref(), None)
}

/// "line: problem" of the error that `text` gives.
fn problem(text: impl AsRef<[u8]>) -> String {
    let error = parse(text).unwrap_err();
    let Place::Line(line) = error.place else { panic!("{error} has no line") };
    format!("{line}: {}", error.problem)
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 2\nvn 0 3 0\n";

const ABCD: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];

fn mesh(faces: &str) -> Mesh {
    let scene = parse(format!("{CORNERS}{faces}\n")).unwrap();
    let [mesh] = <[Mesh; 1]>::try_from(scene.meshes).unwrap();
    mesh
}

#[test]
fn four_forms_of_corners() {
    let bare = mesh("f 1 2 3");
    assert_eq!((bare.positions, bare.triangles), (ABCD[..3].to_vec(), vec![[0, 1, 2]]));
    assert!(bare.normals.is_empty() && bare.texcoords.is_empty());
    let textured = mesh("f 1/1 2/2 4/3");
    assert_eq!(textured.texcoords, [Vec2::Y, Vec2::ONE, Vec2::ZERO], "v counts from above");
    assert_eq!(textured.positions, [ABCD[0], ABCD[1], ABCD[3]]);
    assert!(textured.normals.is_empty());
    let smooth = mesh("f 1//1 2//2 3//1");
    assert_eq!(smooth.normals, [Vec3::Z, Vec3::Y, Vec3::Z]);
    assert!(smooth.texcoords.is_empty());
    let both = mesh("f 1/3/2 2/2/1 3/1/1");
    assert_eq!(both.texcoords, [Vec2::ZERO, Vec2::ONE, Vec2::Y]);
    assert_eq!(both.normals, [Vec3::Y, Vec3::Z, Vec3::Z]);
    // Some exporters leave trailing slashes.
    assert_eq!(mesh("f 1// 2/ 3").triangles, [[0, 1, 2]]);
}

/// Squares in a row, each with its own vertices, of which a group has `GROUP`: more than one block of lines.
fn row_of_squares(face: impl Fn(usize) -> String) -> String {
    const GROUP: usize = 15_000;
    let square = |i: usize| {
        let name = if i.is_multiple_of(GROUP) { format!("g {}\n", i / GROUP) } else { String::new() };
        let x = i as f32;
        format!("{name}v {x} 0 0\nv {} 0 0\n# square\nv {} 1 0\nv {x} \\\n1 0\n{}\n", x + 0.5, x + 0.5, face(i))
    };
    (0..40_000).map(square).collect()
}

#[test]
fn files_of_many_blocks_are_read_as_one() {
    let back = row_of_squares(|_| "f -4 -3 -2 -1".to_owned());
    assert!(back.len() > 2 << 20);
    let scene = parse(&back).unwrap();
    let corners = |i: usize| format!("f {} {} {} {}", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4);
    assert_eq!(scene, parse(row_of_squares(corners)).unwrap());
    let meshes: Vec<_> = scene.meshes.iter().map(|mesh| (mesh.name.as_str(), mesh.triangles.len())).collect();
    assert_eq!(meshes, [("0", 30_000), ("1", 30_000), ("2", 20_000)]);
    let (mesh, last) = (&scene.meshes[2], 39_999.0);
    assert_eq!(
        mesh.corners(19_999),
        [Vec3::new(last, 0.0, 0.0), Vec3::new(last + 0.5, 1.0, 0.0), Vec3::new(last, 1.0, 0.0)]
    );
    // The first invalid line is reported, wherever others are.
    let wrong = row_of_squares(|i| if i == 25_000 || i == 38_000 { "f 1 2 9000000".to_owned() } else { corners(i) });
    let line = 25_001 * 7 + 2;
    assert_eq!(
        problem(&wrong),
        format!("{line}: vertex 9000000 does not exist: the file has 100004 vertices up to this line")
    );
}

#[test]
fn negative_indices_count_back_from_the_face() {
    let scene = parse("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n").unwrap();
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions, ABCD);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn polygons_become_triangles() {
    assert_eq!(mesh("f 1 2 3 4").triangles, [[0, 1, 2], [0, 2, 3]]);
    // To the fourth corner and back is a line without area.
    assert_eq!(mesh("f 4 3 2 1 3").triangles, [[1, 2, 3]]);
    let concave = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\nf 1 2 3 4\nf 3 4 1 2\n";
    let triangles = parse(concave).unwrap().meshes[0].triangles.clone();
    let sorted = |mut triangle: [u32; 3]| {
        let least = (0..3).min_by_key(|&corner| triangle[corner]).unwrap();
        triangle.rotate_left(least);
        triangle
    };
    // From (4, 0) to (3, 1) it is cut both times; the other diagonal lies outside.
    let cut: Vec<_> = triangles.into_iter().map(sorted).collect();
    for half in cut.chunks(2) {
        assert!(half.contains(&[0, 1, 3]) && half.contains(&[1, 2, 3]), "{cut:?}");
    }
}

#[test]
fn vertices_are_shared_within_a_mesh() {
    assert_eq!(mesh("f 1 2 3\nf 1 3 4").positions.len(), 4);
    let split = mesh("f 1//1 2//1 3//1\nf 1//2 3//1 4//1");
    assert_eq!(split.positions, [ABCD[0], ABCD[1], ABCD[2], ABCD[0], ABCD[3]]);
    assert_eq!(split.triangles, [[0, 1, 2], [3, 2, 4]]);
}

#[test]
fn blanks_comments_and_continuations() {
    let text = b"\t# C:\\models\\\r\nv\t0 0  0 # origin\r\nv 1e0 \\\r\n 0 \\\r\n0\r\n  v +1 1. .0 0.5 0.5 0.5\r\n\
          f 1 2 3\r\n\x1a";
    assert_eq!(parse(text).unwrap().meshes[0].positions, ABCD[..3]);
    // The line of an error is the one that the statement begins on, continuations counted.
    assert_eq!(problem("v 0 \\\n0 \\\n0\nv 1 2 x\n"), "4: `x` is not a number");
    assert_eq!(problem("v 0 \\\n0 \\"), "1: `v` needs 3 numbers, but 2 follow");
}

#[test]
fn names_need_not_be_utf8() {
    let scene =
        parse([b"o Stra\xdfe\nusemtl gr\xfcn #2\n".as_slice(), CORNERS.as_bytes(), b"f 1 2 3\n"].concat()).unwrap();
    assert_eq!(scene.meshes[0].name, "Stra\u{fffd}e");
    assert_eq!(scene.warnings, ["model.obj: material \"gr\u{fffd}n #2\" is not defined; grey instead"]);
    assert_eq!(problem("v 0 0 0\nv \0\x01\x02\n"), "2: this is not an OBJ file: the line holds binary data");
    assert_eq!(problem(b"v 0 0 0\nv 1 2 \xe9\n"), "2: `\u{fffd}` is not a number");
}

#[test]
fn runs_of_group_and_material_become_meshes() {
    let faces = "f 1 2 3\no a\ng b\nf 1 2 3\nusemtl m\nf 1 2 4\nusemtl m\nf 1 3 4\ng c d\nf 2 3 4\n";
    let scene = parse(format!("{CORNERS}{faces}")).unwrap();
    let meshes: Vec<_> = scene.meshes.iter().map(|mesh| (mesh.name.as_str(), mesh.triangles.len())).collect();
    assert_eq!(meshes, [("", 1), ("b", 1), ("b", 2), ("c d", 1)]);
    let faces = "o a\nf 1 2 3\ng b\nf 1 2 4\ng\nf 1 3 4\no c\nf 2 3 4\n";
    let meshes = parse(format!("{CORNERS}{faces}")).unwrap().meshes;
    let names: Vec<_> = meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "a", "c"], "without a group a face is the object's");
}

#[test]
fn faces_with_missing_normals_are_flat() {
    let faces = "vn 0 0 0\nf 1//1 2//1 3//1\nf 1//1 2//1 4\nf 1//3 2//1 4//1\nf 2//2 3//2 4//2\n";
    let scene = parse(format!("{CORNERS}{faces}")).unwrap();
    let [flat, smooth] = <[Mesh; 2]>::try_from(scene.meshes).unwrap();
    assert!(flat.normals.is_empty());
    assert_eq!((flat.positions.len(), flat.triangles), (3, vec![[0, 1, 2], [0, 1, 2]]));
    assert_eq!(smooth.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(smooth.normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y, Vec3::Y, Vec3::Y]);
}

#[test]
fn other_statements_are_skipped() {
    let scene = parse(format!("{CORNERS}s 1\ncurv 0 1 nonsense\nl 1 2\np 1\nl 3 4\nf 1 2 3\n")).unwrap();
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(scene.warnings, ["model.obj: 3 statements with lines or points are skipped"]);
}

#[test]
fn wrong_numbers() {
    assert_eq!(problem("v 0 0 0\nv 0 nan 0\n"), "2: `nan` is not a finite number");
    assert_eq!(problem("v 0 -inf 0\n"), "1: `-inf` is not a finite number");
    assert_eq!(problem("v 0 1e39 0\n"), "1: `1e39` is not a finite number");
    assert_eq!(problem("vn 0 infinity 0\n"), "1: `infinity` is not a finite number");
    assert_eq!(problem("vt nan\n"), "1: `nan` is not a finite number");
    assert_eq!(problem("\n\nv 0 1,5 0\n"), "3: `1,5` is not a number");
    assert_eq!(problem("v 0 1 # 2\n"), "1: `v` needs 3 numbers, but 2 follow");
    assert_eq!(problem("v 0\n"), "1: `v` needs 3 numbers, but 1 follows");
    assert_eq!(problem("vt\n"), "1: `vt` needs 2 numbers, but 0 follow");
}

#[test]
fn wrong_corners() {
    let problem = |face: &str| problem(format!("{CORNERS}{face}\n"));
    assert_eq!(problem("f 1 2 5"), "10: vertex 5 does not exist: the file has 4 vertices up to this line");
    assert_eq!(problem("f 1 2 -5"), "10: vertex -5 does not exist: the file has 4 vertices up to this line");
    assert_eq!(problem("f 1 2 0"), "10: vertex 0 does not exist: the file has 4 vertices up to this line");
    assert_eq!(
        problem("f 1/4 2/1 3/1"),
        "10: texture coordinate 4 does not exist: the file has 3 texture coordinates up to this line"
    );
    assert_eq!(problem("f 1//1 2//1 3//3"), "10: normal 3 does not exist: the file has 2 normals up to this line");
    assert_eq!(problem("f 1 2"), "10: this face has 2 corners");
    assert_eq!(problem("f"), "10: this face has 0 corners");
    assert_eq!(problem("f 1 2 /1"), "10: `/1` is not a corner of a face");
    assert_eq!(problem("f 1 2 3/1/1/1"), "10: `3/1/1/1` is not a corner of a face");
    assert_eq!(problem("f 1 2 3.0"), "10: `3.0` is not a corner of a face");
    assert_eq!(
        problem("f 1 2 9223372036854775807"),
        "10: vertex 9223372036854775807 does not exist: the file has 4 vertices up to this line"
    );
    assert_eq!(
        problem("f 1 2 -9223372036854775808"),
        "10: vertex -9223372036854775808 does not exist: the file has 4 vertices up to this line"
    );
    assert_eq!(super::tests::problem("v 0 0 0\nf 1 2 3\nv 1 0 0\nv 0 1 0\n"), {
        "2: vertex 2 does not exist: the file has 1 vertex up to this line"
    });
}

/// A model in a folder of its own, with material libraries.
fn with_libraries(text: &str, libraries: &[(&str, &str)]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in libraries {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    read(&Disk, &folder.path().join("model.obj"), format!("{text}\n{CORNERS}f 1 2 3\n").as_bytes(), None)
}

#[test]
fn materials() {
    let library = "newmtl lamp\nKd 0.1 0.2 0.3 # dark\nKe 5 6 7\nKs 0.5\nNs 96\nNi 1.45\nTf 0.7 0.8 0.9\nd 0.25\nillum 2\n\
                   newmtl glass pane\nTr 0.75\n";
    let scene = with_libraries("mtllib a.mtl\nusemtl lamp", &[("a.mtl", library)]).unwrap();
    assert!(scene.warnings.is_empty());
    let [lamp, pane] = &scene.materials[..] else { panic!() };
    assert_eq!((lamp.name.as_str(), lamp.opacity.value, lamp.inputs.specular_ior), ("lamp", 0.25, 1.45));
    assert_eq!((lamp.inputs.base_color, lamp.emission), (Vec3::new(0.1, 0.2, 0.3), Vec3::new(5.0, 6.0, 7.0)));
    assert_eq!((pane.name.as_str(), pane.opacity.value), ("glass pane", 0.25));
    assert_eq!(scene.meshes[0].material, 0);
    let scene = with_libraries("usemtl glass pane\nmtllib a.mtl", &[("a.mtl", library)]).unwrap();
    assert_eq!(scene.meshes[0].material, 1);
}

#[test]
fn mirrors_and_glass_by_illumination_model() {
    let library = "newmtl mirror\nillum 3\nKd 0.5 0.5 0.5\nKs 0.9 0.4 0.4\nnewmtl dull\nillum 5\nKd 0.5 0.5 0.5\n\
                   newmtl glass\nKd 1 1 1\nNi 1.33\nTf 0.9\nillum 7\nnewmtl pane\nillum 4\n\
                   newmtl void\nillum 6\nNi 0\n";
    let scene = with_libraries("mtllib a.mtl\nusemtl dull", &[("a.mtl", library)]).unwrap();
    let [mirror, dull, glasses @ ..] = &scene.materials[..] else { panic!() };
    // Reflectance at normal incidence, over diffuse light.
    let f0 = ((mirror.inputs.specular_ior - 1.0) / (mirror.inputs.specular_ior + 1.0)).powi(2);
    let reflectance = f0 * mirror.inputs.specular_color;
    assert!(reflectance.abs_diff_eq(Vec3::new(0.9, 0.4, 0.4), 1e-6), "{reflectance}");
    assert_eq!((mirror.inputs.base_color, mirror.inputs.specular_roughness), (Vec3::splat(0.5), 0.0));
    assert_eq!((dull.inputs.base_color, dull.inputs.specular_weight), (Vec3::splat(0.5), 0.0));
    let found: Vec<_> = glasses.iter().map(|it| (it.inputs.specular_ior, it.inputs.transmission_color.x)).collect();
    assert_eq!(found, [(1.33, 0.9), (1.5, 1.0), (1.5, 1.0)]);
    assert!(glasses.iter().all(|it| it.inputs.transmission_weight == 1.0));
    let warnings: Vec<_> = scene.warnings.iter().map(|warning| warning.rsplit("a.mtl: ").next().unwrap()).collect();
    assert_eq!(warnings, ["material \"void\": an index of refraction of 0 is no glass's; 1.5 is used",]);
}

#[test]
fn several_libraries_on_a_line_and_names_with_spaces() {
    let libraries = [("a.mtl", "newmtl one\n"), ("my things.mtl", "newmtl two\n"), ("b.mtl", "newmtl one\nKd 1 1 1\n")];
    let scene = with_libraries("mtllib a.mtl my things.mtl  .\\b.mtl\nusemtl one", &libraries).unwrap();
    let names: Vec<_> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["one", "two", "one"]);
    assert_eq!(scene.meshes[0].material, 0, "the first definition counts");
    assert!(scene.warnings.is_empty());
}

#[test]
fn missing_libraries_and_materials_are_warnings() {
    let scene = with_libraries("mtllib lost.mtl found.mtl\nusemtl x", &[("found.mtl", "newmtl y\n")]).unwrap();
    let [library, material] = <[String; 2]>::try_from(scene.warnings).unwrap();
    assert!(library.ends_with("model.obj:1: material library \"lost.mtl\": no such file"), "{library}");
    assert!(material.ends_with("model.obj: material \"x\" is not defined; grey instead"), "{material}");
    assert_eq!(scene.materials[scene.meshes[0].material], Material::default());
}

#[test]
fn what_materials_change_and_skip_is_told() {
    let library = "newmtl a\nKd 1.5 0.5 -1\nd 2\nmap_refl a.png\nKa 9 9 9\n";
    let scene = with_libraries("mtllib a.mtl\nusemtl a", &[("a.mtl", library)]).unwrap();
    assert_eq!(scene.materials[0].inputs.base_color, Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(scene.materials[0].opacity.value, 1.0);
    let ends = [
        "a.mtl:2: `Kd` is outside 0 to 1 and is clamped",
        "a.mtl:3: `d` is outside 0 to 1 and is clamped",
        "a.mtl: material \"a\": `map_refl` is not read",
    ];
    assert_eq!(scene.warnings.len(), ends.len());
    for (warning, end) in scene.warnings.iter().zip(ends) {
        assert!(warning.ends_with(end), "{warning}");
    }
}

#[test]
fn wrong_materials() {
    let cases = [
        ("newmtl a\nKe 1 -1 0\n", 2, "`Ke` is negative"),
        ("newmtl a\n\nKe 1 inf 0\n", 3, "`inf` is not a finite number"),
        ("newmtl a\nKd 1 nan 0\n", 2, "`nan` is not a finite number"),
        ("newmtl a\nKd 1 1\n", 2, "`Kd` needs 3 numbers, but 2 follow"),
        ("newmtl a\nKd spectral a.rfl\n", 2, "spectral colours are not read"),
        ("newmtl a\nKs xyz 1 1 1\n", 2, "CIE XYZ colours are not read"),
        ("newmtl a\nNs\n", 2, "`Ns` needs one number, but 0 follow"),
        ("newmtl a\nillum 2.5\n", 2, "there is no illumination model 2.5"),
        ("# no name\nKd 1 1 1\n", 2, "`Kd` stands before the first `newmtl`"),
        ("newmtl a\0b\n", 1, "this is not an MTL file: the line holds binary data"),
    ];
    for (library, line, problem) in cases {
        let error = with_libraries("mtllib a.mtl\nusemtl dull", &[("a.mtl", library)]).unwrap_err();
        assert_eq!((error.place, error.problem.as_str()), (Place::Line(line), problem));
        assert_eq!(error.file.file_name().unwrap(), "a.mtl");
    }
}
