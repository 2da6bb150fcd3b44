//! Wavefront OBJ with lightmap coordinates as its `vt`, for pipelines without glTF.
//!
//! Positions are the scene's, in world space. OBJ counts v from below, so it is turned; the page of a group is in its
//! name.

use std::fmt::Write as _;

use crate::bake::layout::atlas::Atlas;
use crate::scene::Scene;

/// The text of the file: an object for each part, named after its mesh.
pub fn write(scene: &Scene, atlas: &Atlas) -> String {
    let mut text = "# texture coordinates are those of the lightmap\n".to_owned();
    let (mut first, mut first_normal) = (1, 1);
    for (number, part) in atlas.parts.iter().enumerate() {
        let mesh = &scene.meshes[part.mesh];
        let name = if mesh.name.is_empty() { format!("mesh{}", part.mesh) } else { one_word(&mesh.name) };
        let _ = writeln!(text, "o {name}.{number}\ng page{}", part.page);
        let material = &scene.materials[mesh.material].name;
        if !material.is_empty() {
            let _ = writeln!(text, "usemtl {}", one_word(material));
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

/// A name without spaces, which would end it.
fn one_word(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join("_")
}
