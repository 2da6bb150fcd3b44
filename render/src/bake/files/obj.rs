//! Wavefront OBJ with lightmap coordinates as its `vt`, for pipelines without glTF.
//!
//! Positions are the scene's, in world space. OBJ counts v from below, so it is turned; the page of a group is in its
//! name. Materials are those of the libraries that the old model names, if it is an OBJ.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::bake::layout::atlas::{Atlas, Part};
use crate::scene::Scene;

/// The text of the file: an object for each part, with the name of its mesh, and a number behind it if other parts have
/// that name. `libraries` are the material libraries, as the file is to name them.
pub fn write(scene: &Scene, atlas: &Atlas, libraries: &[String]) -> String {
    let mut text = "# texture coordinates are those of the lightmap\n".to_owned();
    for library in libraries {
        let _ = writeln!(text, "mtllib {library}");
    }
    let mut parts_of: BTreeMap<&str, usize> = BTreeMap::new();
    for part in &atlas.parts {
        *parts_of.entry(&scene.meshes[part.mesh].name).or_default() += 1;
    }
    let (mut first, mut first_normal) = (1, 1);
    let material = |part: &Part| &scene.materials[scene.meshes[part.mesh].material].name;
    // A name of a material holds until the next one, so parts without come first.
    let mut parts: Vec<(usize, &Part)> = atlas.parts.iter().enumerate().collect();
    parts.sort_by_key(|(_, part)| !material(part).is_empty());
    for (number, part) in parts {
        let mesh = &scene.meshes[part.mesh];
        let name = if mesh.name.is_empty() { format!("mesh{}", part.mesh) } else { one_line(&mesh.name) };
        let number = if parts_of[mesh.name.as_str()] > 1 { format!(".{number}") } else { String::new() };
        let _ = writeln!(text, "o {name}{number}\ng page{}", part.page);
        let material = material(part);
        if !material.is_empty() {
            let _ = writeln!(text, "usemtl {}", one_line(material));
        }
        for vertex in &part.vertices {
            let p = mesh.positions[vertex.source as usize];
            let _ = writeln!(text, "v {} {} {}\nvt {} {}", p.x, p.y, p.z, vertex.uv.x, 1.0 - vertex.uv.y);
        }
        if !mesh.normals.is_empty() {
            for vertex in &part.vertices {
                let n = mesh.normals[vertex.source as usize];
                let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
            }
        }
        for triangle in &part.triangles {
            text.push('f');
            for &corner in triangle {
                let index = first + corner;
                let _ = match mesh.normals.is_empty() {
                    true => write!(text, " {index}/{index}"),
                    false => write!(text, " {index}/{index}/{}", first_normal + corner),
                };
            }
            text.push('\n');
        }
        first += part.vertices.len() as u32;
        first_normal += if mesh.normals.is_empty() { 0 } else { part.vertices.len() as u32 };
    }
    text
}

/// A name without the ends of lines, which would end it.
fn one_line(name: &str) -> String {
    name.split(['\n', '\r']).collect::<Vec<_>>().join("_")
}
