//! Wavefront OBJ with lightmap coordinates as its `vt`, for pipelines without glTF.
//!
//! Positions are the scene's, in world space. OBJ counts v from below, so it is turned; the page of a group is in its
//! name. Materials are those of the libraries that the old model names, if it is an OBJ.

use std::collections::{BTreeMap, BTreeSet};
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
    let meshes = atlas.parts.iter().map(|part| match scene.meshes[part.mesh].name.as_str() {
        "" => format!("mesh{}", part.mesh),
        name => one_line(name),
    });
    let names = distinct(&meshes.collect::<Vec<_>>());
    let (mut first, mut first_normal) = (1, 1);
    let material = |part: &Part| &scene.materials[scene.meshes[part.mesh].material].name;
    // A name of a material holds until the next one, so parts without come first.
    let mut parts: Vec<(usize, &Part)> = atlas.parts.iter().enumerate().collect();
    parts.sort_by_key(|(_, part)| !material(part).is_empty());
    for (number, part) in parts {
        let mesh = &scene.meshes[part.mesh];
        let _ = writeln!(text, "o {}\ng page{}", names[number], part.page);
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

/// The names, with numbers behind those that are there more than once, which make no name that is there already.
fn distinct<'a>(names: &'a [String]) -> Vec<String> {
    let mut taken: BTreeSet<String> = names.iter().cloned().collect();
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    for name in names {
        *uses.entry(name).or_default() += 1;
    }
    // The next number of each.
    let mut next: BTreeMap<&str, usize> = BTreeMap::new();
    let distinct = |name: &'a String| {
        if uses[name.as_str()] == 1 {
            return name.clone();
        }
        let number = next.entry(name).or_default();
        loop {
            let numbered = format!("{name}.{number}");
            *number += 1;
            if taken.insert(numbered.clone()) {
                return numbered;
            }
        }
    };
    names.iter().map(distinct).collect()
}

/// A name without the ends of lines, which would end it.
fn one_line(name: &str) -> String {
    name.split(['\n', '\r']).collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_behind_names_make_no_other_name() {
        let names = ["a", "a", "a.1", "b", "a"].map(str::to_owned);
        assert_eq!(distinct(&names), ["a.0", "a.2", "a.1", "b", "a.3"]);
        let names = ["a.0", "a", "a.0", "a", "a.0.1"].map(str::to_owned);
        assert_eq!(distinct(&names), ["a.0.0", "a.1", "a.0.2", "a.2", "a.0.1"]);
    }
}
