use std::path::PathBuf;

use glam::{Vec2, Vec3};

use super::*;
use crate::scene::Material;

/// A folder of input files that goes away with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn problem(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        load(&self.write(name, bytes)).unwrap_err().problem
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

const PLY_TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn the_extension_chooses_the_format_in_any_case() {
    let folder = Folder::new();
    for (name, text) in [("a.obj", TRIANGLE), ("a.OBJ", TRIANGLE), ("a.ply", PLY_TRIANGLE), ("a.Ply", PLY_TRIANGLE)] {
        let scene = load(&folder.write(name, text)).unwrap();
        assert_eq!(scene.bounds(), Some((Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0))), "{name}");
        assert_eq!(scene.materials, [Material::default()]);
        assert_eq!(scene.meshes[0].material, 0);
    }
    let error = load(&folder.write("a.stl", TRIANGLE)).unwrap_err();
    assert_eq!(error.problem, "this is an STL model (`.stl`), which cannot be read");
    assert_eq!(error.remedy, "export it as glTF (.glb), which keeps most, or name a .gltf, .obj, .pbrt or .ply file");
    for (name, what) in [("a.blend", "a Blender project"), ("a.FBX", "an FBX model"), ("a.usd", "a USD scene")] {
        assert!(folder.problem(name, TRIANGLE).starts_with(&format!("this is {what}")), "{name}");
    }
    let error = load(&folder.write("a.txt", TRIANGLE)).unwrap_err();
    assert_eq!(error.problem, "`.txt` is not a model format that can be read");
    assert_eq!(error.remedy, "name a .glb, .gltf, .obj, .pbrt or .ply file");
    assert_eq!(folder.problem("model", TRIANGLE), "the name has no extension that would tell the format");
}

#[test]
fn what_cannot_be_read_is_named() {
    let folder = Folder::new();
    let missing = folder.0.path().join("missing.obj");
    let error = load(&missing).unwrap_err();
    assert_eq!((error.file, error.problem.as_str()), (missing, "no such file"));
    let inner = folder.0.path().join("folder.obj");
    std::fs::create_dir(&inner).unwrap();
    assert_eq!(load(&inner).unwrap_err().problem, "this is a folder");
    for name in ["a.obj", "a.ply", "a.gltf", "a.glb"] {
        assert_eq!(folder.problem(name, ""), "the file is empty");
        assert_eq!(folder.problem(name, "\u{feff} \r\n\t\n"), "the file is empty");
    }
}

#[test]
fn a_file_of_another_kind_is_recognised() {
    let folder = Folder::new();
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
    assert_eq!(folder.problem("a.obj", png), "this is a PNG image, not an OBJ model");
    assert_eq!(folder.problem("a.glb", "{\"asset\":{}}"), "this is JSON text, not binary glTF (GLB)");
    assert_eq!(folder.problem("a.gltf", b"glTF\x02\0\0\0"), "this is binary glTF (GLB), not glTF, which is JSON text");
    assert_eq!(folder.problem("a.obj", PLY_TRIANGLE), "this is a PLY model, not an OBJ model");
    assert_eq!(folder.problem("a.ply", TRIANGLE), "this is not a PLY model: it does not begin with `ply`");
    assert_eq!(folder.problem("a.gltf", "<html>"), "this is HTML or XML text, not glTF, which is JSON text");
}

#[test]
fn a_model_without_triangles_is_refused() {
    assert_eq!(Folder::new().problem("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"), "the model has no triangles");
}

#[test]
fn positions_too_far_away_are_refused() {
    let folder = Folder::new();
    let error = load(&folder.write("a.obj", format!("o far\n{}", TRIANGLE.replace("v 1", "v 4.5e12")))).unwrap_err();
    assert_eq!(error.place, Place::Part("mesh 0 (\"far\")".to_owned()));
    assert_eq!(error.problem, "the position (4500000000000.0, 0.0, 0.0) is too far away");
    assert!(load(&folder.write("b.obj", TRIANGLE.replace("v 1", "v -4e12"))).is_ok());
}

#[test]
fn degenerate_triangles_stay() {
    let scene = load(&Folder::new().write("a.obj", format!("{TRIANGLE}f 1 1 1\n"))).unwrap();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [0, 0, 0]]);
}

/// Loads `bytes` with every byte changed in a few ways, and cut at every length. Whatever is accepted must be a scene
/// that keeps its promises.
fn survive_damage(name: &str, bytes: &[u8]) {
    let path = Path::new(name);
    let attempt = |damaged: &[u8]| {
        if let Ok(scene) = parse(&Disk, path, Format::of(path).unwrap(), damaged, &LoadOptions::default()) {
            check_promises(&scene);
        }
    };
    attempt(bytes);
    for length in 0..bytes.len() {
        attempt(&bytes[..length]);
    }
    let mut damaged = bytes.to_vec();
    for place in 0..bytes.len() {
        let byte = bytes[place];
        for other in [0, b' ', b'\n', b'-', b'0', b'9', b'/', 0x7f, 0xff, byte ^ 1, byte ^ 0x80, byte.wrapping_add(1)] {
            damaged[place] = other;
            attempt(&damaged);
        }
        damaged[place] = byte;
    }
}

fn check_promises(scene: &Scene) {
    assert!(scene.triangle_count() > 0);
    for mesh in &scene.meshes {
        assert!(mesh.material < scene.materials.len());
        assert!(mesh.positions.iter().all(|position| position.is_finite()));
        assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
        assert!(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
        assert!(mesh.texcoords.is_empty() || mesh.texcoords.len() == mesh.positions.len());
        assert!(mesh.triangles.iter().flatten().all(|&corner| (corner as usize) < mesh.positions.len()));
    }
    for material in &scene.materials {
        let color = material.inputs.base_color;
        assert!(color.min_element() >= 0.0 && color.max_element() <= 1.0);
        assert!(material.emission.is_finite() && material.emission.min_element() >= 0.0);
    }
}

#[test]
fn damaged_obj_gives_no_panic() {
    survive_damage(
        "a.obj",
        b"# ab\nmtllib a.mtl b.mtl\no cube\nv 0 -1.5 2e1 \\\n 1\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.5 1\nvn 0 0 1\n\
         usemtl red\nf 1/1/1 2/1/1 3/1/1\nf -1//-1 -2// 1\nf 1 2 4 3\ns off\nl 1 2\n",
    );
}

#[test]
fn damaged_mtl_gives_no_panic() {
    let mtl = b"newmtl a\nKd 0.5 0.25 1\nKe 1\nNs 3.5\nd -halo 1\nTr 0\nillum 2\nmap_Kd a.png\n";
    let folder = Folder::new();
    let obj = folder.write("a.obj", format!("mtllib a.mtl\nusemtl a\n{TRIANGLE}"));
    for place in 0..mtl.len() {
        for byte in [0, b' ', b'\n', b'-', b'9', 0xff, mtl[place] ^ 1] {
            let mut damaged = mtl.to_vec();
            damaged[place] = byte;
            folder.write("a.mtl", &damaged);
            if let Ok(scene) = load(&obj) {
                check_promises(&scene);
            }
        }
    }
}

#[test]
fn damaged_ascii_ply_gives_no_panic() {
    survive_damage("a.ply", PLY_TRIANGLE.as_bytes());
}

#[test]
fn damaged_binary_ply_gives_no_panic() {
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let mut bytes = format!(
            "ply\nformat {encoding} 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
             element face 1\nproperty list uint short vertex_index\nelement edge 1\nproperty int a\nend_header\n"
        )
        .into_bytes();
        bytes.extend([0x3f; 3 * 29]);
        let little = encoding == "binary_little_endian";
        bytes.extend(if little { 3_u32.to_le_bytes() } else { 3_u32.to_be_bytes() });
        for index in 0..3_u16 {
            bytes.extend(if little { index.to_le_bytes() } else { index.to_be_bytes() });
        }
        bytes.extend([0; 4]);
        let scene = load(&Folder::new().write("a.ply", &bytes)).unwrap();
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
        survive_damage("a.ply", &bytes);
    }
}

#[test]
fn damaged_glb_gives_no_panic() {
    let bytes = crate::scene::formats::gltf::tests::small_glb();
    let scene = load(&Folder::new().write("a.glb", &bytes)).unwrap();
    assert_eq!(scene.meshes[0].texcoords, [Vec2::ZERO, Vec2::X, Vec2::Y]);
    survive_damage("a.glb", &bytes);
}

#[test]
fn files_may_be_anywhere() {
    /// A model and its materials in memory.
    struct Pair;
    impl Files for Pair {
        fn read(&self, path: &Path) -> std::io::Result<std::borrow::Cow<'_, [u8]>> {
            match path.to_str() {
                Some("there/a.obj") => Ok(format!("mtllib my paint.mtl\nusemtl red\n{TRIANGLE}").into_bytes().into()),
                Some("there/my paint.mtl") => Ok((&b"newmtl red\nKd 1 0 0\n"[..]).into()),
                _ => Err(std::io::ErrorKind::NotFound.into()),
            }
        }
        fn contains(&self, path: &Path) -> bool {
            self.read(path).is_ok()
        }
    }
    let scene = load_from(&Pair, Path::new("there/a.obj")).unwrap();
    assert_eq!((scene.materials[0].inputs.base_color, scene.warnings), (Vec3::X, vec![]));
    assert_eq!(load_from(&Pair, Path::new("b.obj")).unwrap_err().problem, "no such file");
}
