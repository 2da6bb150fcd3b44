//! Times reading models: a wavy field with normals and texture coordinates as binary glTF, PLY in binary and in ASCII,
//! and OBJ, on all threads. The result is compared with the written data.
//!
//! `cargo bench -p halfdome-benches --bench loading [-- --triangles N] [--rounds N]`. With `--test`, or without the
//! `--bench` that `cargo bench` passes, everything is read once, untimed.

use std::fmt::Write as _;
use std::path::Path;

use clap::Parser;
use glam::{Vec2, Vec3};
use halfdome::scene::{Mesh, load};
use halfdome_benches::rounds::{Rounds, nanoseconds};

/// Times reading models.
#[derive(Parser)]
struct Options {
    /// About how many triangles a model has
    #[arg(long, default_value_t = 500_000)]
    triangles: u32,
    #[command(flatten)]
    rounds: Rounds,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = Options::parse();
    let rounds = options.rounds.timed();
    let triangles = if rounds == 0 { 1000 } else { options.triangles };
    let field = field((f64::from(triangles) / 2.0).sqrt().ceil() as u32);
    let folder = tempfile::tempdir()?;
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("field.glb"), glb(&field))?;
    std::fs::write(path("binary.ply"), binary_ply(&field))?;
    std::fs::write(path("ascii.ply"), ascii_ply(&field))?;
    std::fs::write(path("field.obj"), obj(&field))?;
    println!("{} triangles", field.triangles.len());
    println!("{:>12}{:>14}{:>12}", "file", "bytes", "ns/triangle");
    for name in ["field.glb", "binary.ply", "ascii.ply", "field.obj"] {
        check(&path(name), &field)?;
        let read = || drop(load(&path(name)).expect("it was read before"));
        let time = nanoseconds(rounds, field.triangles.len(), read);
        println!("{name:>12}{:>14}{time:>12}", path(name).metadata()?.len());
    }
    Ok(())
}

/// A field of `2 n²` triangles.
fn field(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (row, column) in (0..=n).flat_map(|row| (0..=n).map(move |column| (row, column))) {
        let (u, v) = (column as f32 / n as f32, row as f32 / n as f32);
        mesh.positions.push(Vec3::new(u, 0.1 * (9.0 * u).sin() * (7.0 * v).cos(), v));
        let slope = Vec2::new((9.0 * u).cos() * (7.0 * v).cos() * 0.9, (9.0 * u).sin() * (7.0 * v).sin() * -0.7);
        mesh.normals.push(Vec3::new(-slope.x, 1.0, -slope.y).normalize());
        mesh.texcoords.push(Vec2::new(u, v));
    }
    for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
        let a = row * (n + 1) + column;
        mesh.triangles.extend([[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]);
    }
    mesh
}

/// Fails if a file does not hold the field.
fn check(path: &Path, field: &Mesh) -> Result<(), Box<dyn std::error::Error>> {
    let scene = load(path)?;
    let mesh = &scene.meshes[0];
    let is_same = scene.meshes.len() == 1
        && mesh.triangles.len() == field.triangles.len()
        && (0..field.triangles.len()).all(|face| mesh.corners(face) == field.corners(face));
    if is_same { Ok(()) } else { Err(format!("{}: another model than was written", path.display()).into()) }
}

fn floats<'a>(values: impl Iterator<Item = &'a [f32]>) -> Vec<u8> {
    values.flatten().flat_map(|number| number.to_le_bytes()).collect()
}

fn glb(field: &Mesh) -> Vec<u8> {
    let vectors = |of: &[Vec3]| floats(of.iter().map(|it| it.as_ref().as_slice()));
    let texcoords = floats(field.texcoords.iter().map(|it| it.as_ref().as_slice()));
    let indices: Vec<u8> = field.triangles.iter().flatten().flat_map(|index| index.to_le_bytes()).collect();
    let parts = [vectors(&field.positions), vectors(&field.normals), texcoords, indices];
    let (mut views, mut binary) = (Vec::new(), Vec::new());
    for part in &parts {
        views.push(serde_json::json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": part.len() }));
        binary.extend(part);
    }
    let accessor = |view: usize, component: u32, count: usize, kind: &str| {
        serde_json::json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind
        })
    };
    let (vertices, corners) = (field.positions.len(), 3 * field.triangles.len());
    let mut json = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3 }] }],
        "buffers": [{ "byteLength": binary.len() }], "bufferViews": views,
        "accessors": [
            accessor(0, 5126, vertices, "VEC3"), accessor(1, 5126, vertices, "VEC3"), accessor(2, 5126, vertices, "VEC2"),
            accessor(3, 5125, corners, "SCALAR"),
        ],
    })
    .to_string();
    json.extend(std::iter::repeat_n(' ', json.len().next_multiple_of(4) - json.len()));
    let word = |number: usize| (number as u32).to_le_bytes();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    [
        b"glTF".as_slice(),
        &word(2),
        &word(length),
        &word(json.len()),
        b"JSON",
        json.as_bytes(),
        &word(binary.len()),
        b"BIN\0",
        &binary,
    ]
    .concat()
}

fn ply_header(field: &Mesh, format: &str) -> String {
    let numbers = ["x", "y", "z", "nx", "ny", "nz", "s", "t"].map(|name| format!("property float {name}\n")).concat();
    format!(
        "ply\nformat {format} 1.0\nelement vertex {}\n{numbers}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        field.positions.len(),
        field.triangles.len()
    )
}

/// The numbers of each vertex.
fn rows(field: &Mesh) -> impl Iterator<Item = [f32; 8]> + '_ {
    let vectors = field.positions.iter().zip(&field.normals).zip(&field.texcoords);
    vectors.map(|((p, n), t)| [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y])
}

fn binary_ply(field: &Mesh) -> Vec<u8> {
    let mut bytes = ply_header(field, "binary_little_endian").into_bytes();
    rows(field).flatten().for_each(|number| bytes.extend(number.to_le_bytes()));
    for triangle in &field.triangles {
        bytes.push(3);
        triangle.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    }
    bytes
}

fn ascii_ply(field: &Mesh) -> String {
    let mut text = ply_header(field, "ascii");
    for [x, y, z, nx, ny, nz, s, t] in rows(field) {
        let _ = writeln!(text, "{x} {y} {z} {nx} {ny} {nz} {s} {t}");
    }
    for [a, b, c] in &field.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

fn obj(field: &Mesh) -> String {
    let mut text = String::new();
    for [x, y, z, nx, ny, nz, s, t] in rows(field) {
        let _ = writeln!(text, "v {x} {y} {z}\nvt {s} {t}\nvn {nx} {ny} {nz}");
    }
    for triangle in &field.triangles {
        let [a, b, c] = triangle.map(|index| index + 1);
        let _ = writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}");
    }
    text
}
