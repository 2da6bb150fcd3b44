//! Adds lightmaps to the glTF file that they were baked for.
//!
//! The file's JSON is changed as text (`text.rs`) and its binary data grow at the end, so that materials, names, extras
//! and extensions that are unknown here survive byte for byte. What changes:
//!
//! - Baked primitives get `TEXCOORD_1`. Where chart borders cut vertices, all attributes and morph targets are gathered
//!   anew, and the triangles are listed. A primitive on several pages becomes several.
//! - A mesh under several nodes is copied, so that each node has lightmap coordinates of its own.
//! - [`Target::Three`]: materials get `MOZ_lightmap`, in a copy for each page where several pages or surfaces without a
//!   lightmap share a material. Radiance pictures go by `MOZ_texture_rgbe`. Both are what Mozilla Hubs uses, as glTF
//!   has no ratified extension for either.
//! - [`Target::Bevy`]: a node's extras get `halfdome_lightmaps`, the file for each primitive of its mesh or `null`;
//!   Bevy would load textures that the file names as colours.

mod assembly;
mod data;
mod material;
mod primitive;
mod relocated;
mod text;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::Vec2;

use self::assembly::Home;
use self::data::Data;
use self::material::Materials;
use crate::scene::formats::gltf::{Document, open};
use crate::scene::{Mesh, SceneError};

/// What of a mesh lies on one page of the lightmap.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// The mesh as the scene has it, with its place in the file.
    pub mesh: &'a Mesh,
    /// The page.
    pub page: usize,
    /// For each vertex of the part the vertex of the mesh that it is a copy of.
    pub sources: &'a [u32],
    /// Where each vertex is on the page, in 0..=1; the first row of texels is at v = 0.
    pub uvs: &'a [Vec2],
    /// Vertices of the part, in the winding of the mesh.
    pub triangles: &'a [[u32; 3]],
}

/// A page as a file.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    /// Its name, beside the glTF file. The extension tells what it is: `.hdr`, `.exr` or `.ktx2`.
    pub file: &'a str,
    /// Its bytes, if they are to be in the glTF file itself; of use to [`Target::Three`] alone.
    pub embedded: Option<&'a [u8]>,
}

/// The engine that reads the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Bevy, with a plugin that reads the extras.
    Bevy,
    /// three.js, with a plugin for `MOZ_lightmap`.
    Three,
}

/// The new file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patched {
    /// All its bytes: a GLB container if the old one is, else JSON.
    pub bytes: Vec<u8>,
    /// Warnings, one line each.
    pub warnings: Vec<String>,
}

/// Puts lightmaps into the file whose `bytes` these are; `path` is for messages and for the files that it names, and
/// `folders` lead from the new file to it: its references to other files begin with them.
///
/// # Errors
/// If the file is broken; if a part is of another file, or names vertices or pages that are not there; if a material
/// uses the second texture coordinates, which the lightmap needs, for something else; if a GLB would exceed 4 GiB.
pub fn patch(
    path: &Path,
    bytes: &[u8],
    parts: &[Part],
    pages: &[Page],
    (target, folders): (Target, &[String]),
) -> Result<Patched, SceneError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (document, chunks) = open(path, bytes)?;
    let text = str::from_utf8(chunks.json).map_err(|_| document.error("JSON", "it is not UTF-8", "export it again"))?;
    let text = &relocated::relocated(text, folders);
    let home = Home::of(&document, &chunks, bytes.starts_with(b"glTF"));
    let data = home.data(&document, &chunks);
    let mut patch = Patch { document, text, pages, target, data, warnings: Vec::new() };
    let root = patch.root(&group(&patch.document, parts, pages)?)?;
    let Patch { document, data, warnings, .. } = patch;
    let bytes = home.assemble(&document, &chunks, root, &data)?;
    Ok(Patched { bytes, warnings })
}

/// The other files that the file with these `bytes` refers to, as it spells them: buffers, pictures and photometric
/// profiles. A copy in another folder must refer to them from there.
///
/// # Errors
/// If the file is broken.
pub fn external_files(path: &Path, bytes: &[u8]) -> Result<Vec<String>, SceneError> {
    let (document, _) = open(path, bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))?;
    let buffers = document.root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let images = document.root.images.iter().filter_map(|image| image.uri.as_deref());
    let extensions = document.root.extensions.as_ref();
    let profiles = extensions.and_then(|it| it.others.get(relocated::PROFILES[1])?.get("lights")?.as_array());
    let profiles = profiles.into_iter().flatten().filter_map(|profile| profile.get("uri")?.as_str());
    let all = buffers.chain(images).chain(profiles);
    Ok(all.filter(|uri| !uri.starts_with("data:")).map(str::to_owned).collect())
}

/// The parts of each node's primitives.
type Parts<'a> = BTreeMap<usize, BTreeMap<usize, Vec<Part<'a>>>>;

/// Sorts parts by node and primitive, and checks them.
fn group<'a>(document: &Document, parts: &[Part<'a>], pages: &[Page]) -> Result<Parts<'a>, SceneError> {
    let mut groups = Parts::new();
    for (number, part) in parts.iter().enumerate() {
        let error = |problem: &str| document.error(format!("lightmap part {number}"), problem, "bake the file again");
        let origin = part.mesh.origin.ok_or_else(|| error("it is not of a glTF file"))?;
        let node = document.root.nodes.get(origin.node);
        if node.and_then(|node| node.mesh).map(|mesh| mesh.value()) != Some(origin.mesh) {
            return Err(error(&format!("the file has no mesh {} at node {}", origin.mesh, origin.node)));
        }
        let (vertices, sources) = (part.mesh.positions.len(), part.sources.len());
        if part.page >= pages.len() || part.uvs.len() != sources {
            return Err(error("its page or a coordinate of a vertex is missing"));
        }
        let missing = part.sources.iter().any(|&source| source as usize >= vertices);
        if missing || part.triangles.as_flattened().iter().any(|&corner| corner as usize >= sources) {
            return Err(error("it names a vertex that is not there"));
        }
        groups.entry(origin.node).or_default().entry(origin.primitive).or_default().push(*part);
    }
    Ok(groups)
}

/// A file that is being changed.
struct Patch<'a> {
    document: Document<'a>,
    text: &'a str,
    pages: &'a [Page<'a>],
    target: Target,
    data: Data,
    warnings: Vec<String>,
}

impl Patch<'_> {
    /// The new JSON, but for the buffer that grows.
    fn root(&mut self, parts: &Parts) -> Result<String, SceneError> {
        let (mut nodes, mut meshes, mut copies) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
        let text = self.text;
        let node_texts = text::elements(text::member(text, "nodes").unwrap_or("[]"));
        let mesh_texts = text::elements(text::member(text, "meshes").unwrap_or("[]"));
        let mut materials = Materials::new(&self.document, text, parts);
        let kept = self.kept_meshes(parts);
        for (&node, primitives) in parts {
            let Some(mesh) = self.document.root.nodes[node].mesh.map(|mesh| mesh.value()) else { continue };
            let (changed, files) = self.mesh(mesh_texts[mesh], mesh, primitives, &mut materials)?;
            let mut node_text = node_texts[node].to_owned();
            if kept.contains(&mesh) || meshes.contains_key(&mesh) {
                copies.push(changed);
                let copy = mesh_texts.len() + copies.len() - 1;
                node_text = text::set(&node_text, "mesh", &copy.to_string());
            } else {
                meshes.insert(mesh, changed);
            }
            if self.target == Target::Bevy {
                node_text = self.with_extras(&node_text, node, &files);
            }
            nodes.insert(node, node_text);
        }
        let none = BTreeMap::new();
        let mut root = text::change_member(text, "nodes", &nodes, &[]);
        root = text::change_member(&root, "meshes", &meshes, &copies);
        if self.target == Target::Three {
            root = materials.finish(&self.document, &root, self.pages, &mut self.data);
        }
        root = text::change_member(&root, "bufferViews", &none, &self.data.views);
        root = text::change_member(&root, "accessors", &none, &self.data.accessors);
        Ok(root)
    }

    /// The meshes that a node without a lightmap shows, too: they stay as they are.
    fn kept_meshes(&self, parts: &Parts) -> BTreeSet<usize> {
        let nodes = self.document.root.nodes.iter().enumerate().filter(|(node, _)| !parts.contains_key(node));
        nodes.filter_map(|(_, node)| node.mesh).map(|mesh| mesh.value()).collect()
    }

    /// The mesh of this text with new primitives, and the file of each.
    fn mesh(
        &mut self,
        text: &str,
        mesh: usize,
        parts: &BTreeMap<usize, Vec<Part>>,
        materials: &mut Materials,
    ) -> Result<(String, Vec<Option<usize>>), SceneError> {
        let (mut primitives, mut files) = (Vec::new(), Vec::new());
        for (number, old) in text::elements(text::member(text, "primitives").unwrap_or("[]")).into_iter().enumerate() {
            let place = format!("mesh {mesh}, primitive {number}");
            let Some(parts) = parts.get(&number) else {
                primitives.push(old.to_owned());
                files.push(None);
                continue;
            };
            let typed = &self.document.root.meshes[mesh].primitives[number];
            let material = typed.material.map(|material| material.value());
            for part in parts {
                let is_all = parts.len() == 1;
                let mut new = primitive::with_lightmap(&self.document, &mut self.data, old, part, is_all, &place)?;
                if self.target == Target::Three {
                    let number = materials.with_lightmap(material, part.page);
                    new = text::set(&new, "material", &number.to_string());
                }
                primitives.push(new);
                files.push(Some(part.page));
            }
            if text::member(old, "extensions").is_some_and(|all| text::member(all, "KHR_materials_variants").is_some())
                && self.target == Target::Three
            {
                self.warnings.push(format!("{place}: its material variants have no lightmap"));
            }
        }
        Ok((text::set(text, "primitives", &format!("[{}]", primitives.join(","))), files))
    }

    /// The node with the files of its mesh's primitives in its extras.
    fn with_extras(&mut self, text: &str, node: usize, pages: &[Option<usize>]) -> String {
        if text::member(text, "extras").is_some_and(|extras| !extras.starts_with('{')) {
            let node = self.document.node(node);
            self.warnings.push(format!("{node}: its extras are no object, so the manifest alone names its lightmap"));
            return text.to_owned();
        }
        let file = |page: &Option<usize>| page.map_or("null".to_owned(), |page| text::string(self.pages[page].file));
        let files: Vec<String> = pages.iter().map(file).collect();
        text::set_at(text, &["extras", "halfdome_lightmaps"], &format!("[{}]", files.join(",")))
    }
}

#[cfg(test)]
mod tests;
