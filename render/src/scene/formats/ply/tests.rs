use glam::{Vec2, Vec3};

use super::*;

fn parse(text: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    read(Path::new("model.ply"), text.as_ref(), None)
}

fn mesh(text: impl AsRef<[u8]>) -> Mesh {
    let scene = parse(text).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!(scene.materials, [Material::default()]);
    let [mesh] = <[Mesh; 1]>::try_from(scene.meshes).unwrap();
    mesh
}

/// "place: problem" of the error that `text` gives.
fn problem(text: impl AsRef<[u8]>) -> String {
    let error = parse(text).unwrap_err();
    match error.place {
        Place::File => error.problem,
        Place::Line(line) => format!("{line}: {}", error.problem),
        Place::Part(part) => format!("{part}: {}", error.problem),
    }
}

const SQUARE: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

const CORNERS: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];

#[test]
fn ascii() {
    let square = mesh(SQUARE);
    assert_eq!(square.positions, CORNERS);
    assert_eq!(square.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert!(square.normals.is_empty() && square.texcoords.is_empty());
    assert_eq!(mesh(SQUARE.replace('\n', "\r\n")), square);
    assert_eq!(mesh(SQUARE.replace("vertex_indices", "vertex_index")), square);
    assert_eq!(mesh(SQUARE.replace("uchar int", "int32 uint8")), square);
    assert_eq!(mesh(SQUARE.trim_end()), square);
}

#[test]
fn normals_texture_coordinates_and_other_properties() {
    for names in TEXCOORDS {
        let text = format!(
            "ply\nformat ascii 1.0\nelement camera 1\nproperty list uchar float view\nelement vertex 3\n\
             property uchar red\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float {}\n\
             property float {}\nproperty double x\nproperty double y\nproperty double z\nelement face 1\n\
             property list uchar float quality\nproperty list uchar uint vertex_indices\nend_header\n2 1.5 2.5\n\
             255 0 0 2 0 0 0 0 0\n255 0 3 0 1 0 1 0 0\n255 -1 0 0 0 1 0 1 0\n1 0.5 3 0 1 2\n",
            names[0], names[1]
        );
        let mesh = mesh(text);
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert_eq!(mesh.normals, [Vec3::Z, Vec3::Y, Vec3::NEG_X]);
        assert_eq!(mesh.texcoords, [Vec2::Y, Vec2::ONE, Vec2::ZERO], "v counts from above");
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn a_normal_without_direction_makes_the_mesh_flat() {
    let text = SQUARE
        .replace("property float z\n", "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n")
        .replace("0 0 0\n", "0 0 0 0 0 0\n")
        .replace("1 0 0\n", "1 0 0 0 0 1\n")
        .replace("1 1 0\n", "1 1 0 0 0 1\n")
        .replace("\n0 1 0\n", "\n0 1 0 0 0 1\n");
    let scene = parse(text).unwrap();
    assert!(scene.meshes[0].normals.is_empty());
    assert_eq!(scene.warnings, ["model.ply: some normals have no direction; shading is flat"]);
}

/// The square with `bytes(number)` for each coordinate, then the face with 16-bit indices.
fn binary(encoding: &str, float: fn(f32) -> [u8; 4], short: fn(u16) -> [u8; 2]) -> Vec<u8> {
    let header = SQUARE.split("0 0 0\n").next().unwrap().replace("ascii", encoding).replace("int", "ushort");
    let mut bytes = header.into_bytes();
    bytes.extend(CORNERS.iter().flat_map(|corner| corner.to_array()).flat_map(float));
    bytes.push(4);
    bytes.extend((0..4).flat_map(short));
    bytes
}

#[test]
fn binary_in_both_byte_orders() {
    assert_eq!(mesh(binary("binary_little_endian", f32::to_le_bytes, u16::to_le_bytes)), mesh(SQUARE));
    assert_eq!(mesh(binary("binary_big_endian", f32::to_be_bytes, u16::to_be_bytes)), mesh(SQUARE));
}

/// More vertices and faces than a piece has, in each encoding.
#[test]
fn files_of_many_pieces_are_read_as_one() {
    const SIDE: u32 = 300;
    let header = |format: &str, faces: u32| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty double z\n\
             property uchar red\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n",
            SIDE * SIDE
        )
    };
    let vertices = (0..SIDE * SIDE).map(|i| [(i % SIDE) as f32 * 0.37, (i / SIDE) as f32 / 3.0, 1e-3 * i as f32]);
    let corner = |x: u32, y: u32| y * SIDE + x;
    // Squares and triangles by turns.
    let faces: Vec<Vec<u32>> = (0..SIDE - 1)
        .flat_map(|y| (0..SIDE - 1).map(move |x| (x, y)))
        .map(|(x, y)| {
            let all = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            all[..if (x + y) % 2 == 0 { 4 } else { 3 }].to_vec()
        })
        .collect();
    let words = |face: &Vec<u32>| face.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
    let mut text = header("ascii", faces.len() as u32);
    vertices.clone().for_each(|[x, y, z]| text += &format!("{x} {y} {z} 7\n"));
    faces.iter().for_each(|face| text += &format!("{} {}\n", face.len(), words(face)));
    assert!(text.len() > 3 << 20);
    let mesh = mesh(&text);
    assert_eq!(mesh.positions, vertices.clone().map(Vec3::from_array).collect::<Vec<_>>());
    let triangles = faces.iter().flat_map(|face| (2..face.len()).map(|last| [face[0], face[last - 1], face[last]]));
    assert_eq!(mesh.triangles, triangles.collect::<Vec<_>>());
    let mut bytes = header("binary_little_endian", faces.len() as u32).into_bytes();
    for [x, y, z] in vertices {
        bytes.extend([x.to_le_bytes(), y.to_le_bytes()].concat());
        bytes.extend(f64::from(z).to_le_bytes());
        bytes.push(7);
    }
    for face in &faces {
        bytes.push(face.len() as u8);
        face.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    }
    assert_eq!(super::tests::mesh(&bytes), mesh);
    // Errors give the index among all elements, and the line.
    let wrong = text.replace(&format!("\n4 {}\n", words(&faces[60_000])), "\n4 0 1 2 90000\n");
    assert_eq!(problem(&wrong), "face 60000: vertex 90000 does not exist: the file has 90000 vertices");
    let line = 10 + SIDE * SIDE + 60_001;
    let wrong = text.replace(&format!("\n4 {}\n", words(&faces[60_000])), "\n4 0 1 2 z\n");
    assert_eq!(problem(&wrong), format!("{line}: `4 0 1 2 z` is not a `face`"));
    let cut = bytes.len() - 5;
    let told = format!("element `face`: the file ends before the last of {}", faces.len());
    assert_eq!(problem(&bytes[..cut]), told);
}

#[test]
fn truncated() {
    let bytes = binary("binary_little_endian", f32::to_le_bytes, u16::to_le_bytes);
    let cut = |length: usize| problem(&bytes[..bytes.len() - length]);
    assert_eq!(cut(1), "element `face`: the file ends before the last of 1");
    assert_eq!(cut(9), "the file is cut short: the header announces at least 49 bytes of data, but 48 follow");
    let ascii = SQUARE.strip_suffix("4 0 1 2 3\n").unwrap();
    assert_eq!(problem(ascii), "the file is cut short: the header announces at least 26 bytes of data, but 24 follow");
    assert_eq!(problem(SQUARE.replace("face 1", "face 2")), "element `face`: the file ends before the last of 2");
    assert_eq!(problem(SQUARE.replace("1 2 3\n", "1 2\n")), "15: `4 0 1 2` is not a `face`");
    assert_eq!(problem("ply\nformat ascii 1.0\n"), "the header does not end, or is not text");
}

#[test]
fn huge_counts_are_refused_before_anything_is_read() {
    assert_eq!(
        problem(SQUARE.replace("vertex 4", "vertex 1000000000000000")),
        "the file is cut short: the header announces at least 6000000000000002 bytes of data, but 34 follow"
    );
    assert_eq!(
        problem(SQUARE.replace("vertex 4", "vertex 18446744073709551615")),
        format!("the file is cut short: the header announces at least {} bytes of data, but 34 follow", usize::MAX)
    );
    assert_eq!(
        problem(SQUARE.replace("end_header", "element nothing 1000000000000\nend_header")),
        "element `nothing`: it has no properties"
    );
    assert_eq!(problem(SQUARE.replace("4 0 1 2 3", "4000000000 0 1 2 3")), "15: `4000000000 0 1 2 3` is not a `face`");
    let mut bytes = binary("binary_little_endian", f32::to_le_bytes, u16::to_le_bytes);
    let count = bytes.len() - 9;
    bytes[count] = 255;
    assert_eq!(problem(bytes), "element `face`: the file ends before the last of 1");
}

#[test]
fn wrong_headers() {
    assert_eq!(problem(SQUARE.replace("float y", "float height")), "element `vertex`: there is no number `y`");
    assert_eq!(problem(SQUARE.replace("float x", "list uchar float x")), "element `vertex`: there is no number `x`");
    assert_eq!(problem(SQUARE.replace("element vertex", "element point")), "there is no element `vertex`");
    assert_eq!(problem(SQUARE.replace("element face", "element tristrips")), "there is no element `face`");
    assert_eq!(problem(SQUARE.replace("float y", "float x")), "the header declares one property twice");
    assert_eq!(
        problem(SQUARE.replace("element face", "element vertex 3\nelement face")),
        "the header declares one element twice"
    );
    for list in ["list uchar float vertex_indices", "int vertex_indices", "list uchar int corners"] {
        assert_eq!(
            problem(SQUARE.replace("list uchar int vertex_indices", list)),
            "element `face`: there is no list of whole numbers `vertex_indices` or `vertex_index`"
        );
    }
    assert_eq!(
        problem(SQUARE.replace("property float y", "property quaternion y")),
        "6: `property quaternion y` does not belong in the header of a PLY file"
    );
    assert_eq!(problem(SQUARE.replace("format ascii 1.0\n", "")), "the header has no line with a valid `format`");
}

#[test]
fn wrong_vertices() {
    assert_eq!(problem(SQUARE.replace("1 1 0", "1 here 0")), "13: `1 here 0` is not a `vertex`");
    assert_eq!(problem(SQUARE.replace("1 1 0", "1 1")), "13: `1 1` is not a `vertex`");
    assert_eq!(problem(SQUARE.replace("1 1 0", "nan 1 0")), "13: `nan 1 0` is not a `vertex`");
    assert_eq!(problem(SQUARE.replace("1 1 0", "1 1e39 0")), "vertex 2: a coordinate is not a finite number");
    let mut bytes = binary("binary_big_endian", f32::to_be_bytes, u16::to_be_bytes);
    let second = bytes.len() - 9 - 36;
    bytes[second..second + 4].copy_from_slice(&f32::NAN.to_be_bytes());
    assert_eq!(problem(bytes), "vertex 1: a coordinate is not a finite number");
}

#[test]
fn wrong_faces() {
    let face = |corners: &str| problem(SQUARE.replace("4 0 1 2 3", corners));
    assert_eq!(face("3 0 1 4"), "face 0: vertex 4 does not exist: the file has 4 vertices");
    assert_eq!(face("3 0 1 -1"), "face 0: it names a vertex by a negative number");
    assert_eq!(face("2 0 1"), "face 0: it has 2 corners");
    assert_eq!(face("0"), "face 0: it has 0 corners");
    assert_eq!(face("3 0 1 1.5"), "15: `3 0 1 1.5` is not a `face`");
    let two = SQUARE.replace("face 1", "face 2").replace("4 0 1 2 3\n", "4 0 1 2 3\n3 1 2 9\n");
    assert_eq!(problem(two), "face 1: vertex 9 does not exist: the file has 4 vertices");
}
