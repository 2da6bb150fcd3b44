//! Materials with lightmaps: `MOZ_lightmap` belongs to the material, so that each page needs materials of its own.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::data::Data;
use super::{Page, Parts, text};
use crate::scene::formats::gltf::Document;

/// The file's materials, and what becomes of them.
pub(super) struct Materials<'a> {
    texts: Vec<&'a str>,
    /// Materials that need no copy.
    in_place: BTreeSet<usize>,
    /// Index of the material that stands for an old one, or for none, on a page.
    numbers: BTreeMap<(Option<usize>, usize), usize>,
    /// Old material and page of each copy.
    copies: Vec<(Option<usize>, usize)>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &Document, text: &'a str, parts: &Parts) -> Self {
        let texts = text::elements(text::member(text, "materials").unwrap_or("[]"));
        // The pages of each material; surfaces without a lightmap count as one more.
        let mut pages = vec![BTreeSet::new(); texts.len()];
        for (number, node) in document.root.nodes.iter().enumerate() {
            let mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
            for (primitive, typed) in mesh.iter().flat_map(|mesh| mesh.primitives.iter().enumerate()) {
                let Some(pages) = typed.material.and_then(|material| pages.get_mut(material.value())) else { continue };
                match parts.get(&number).and_then(|primitives| primitives.get(&primitive)) {
                    Some(parts) => pages.extend(parts.iter().map(|part| Some(part.page))),
                    None => drop(pages.insert(None)),
                }
            }
        }
        let in_place = (0..texts.len()).filter(|&material| pages[material].len() == 1).collect();
        Self { texts, in_place, numbers: BTreeMap::new(), copies: Vec::new() }
    }

    /// The index of the material that is to be used on this page in place of `material`.
    pub(super) fn with_lightmap(&mut self, material: Option<usize>, page: usize) -> usize {
        *self.numbers.entry((material, page)).or_insert_with(|| match material {
            Some(material) if self.in_place.contains(&material) => material,
            _ => {
                self.copies.push((material, page));
                self.texts.len() + self.copies.len() - 1
            }
        })
    }

    /// `root` with the materials, and with the pages as textures.
    pub(super) fn finish(&self, document: &Document, root: &str, pages: &[Page], data: &mut Data) -> String {
        let (first_texture, none) = (document.root.textures.len(), BTreeMap::new());
        let lightmap = |material: Option<usize>, page: usize| {
            let extension = json!({"index": first_texture + page, "texCoord": 1, "intensity": 1.0});
            let text = material.map_or("{}", |material| self.texts[material]);
            text::set_at(text, &["extensions", "MOZ_lightmap"], &extension.to_string())
        };
        let changed = self.numbers.iter().filter(|(_, number)| **number < self.texts.len());
        let changed = changed.map(|(&(material, page), &number)| (number, lightmap(material, page))).collect();
        let copies: Vec<String> = self.copies.iter().map(|&(material, page)| lightmap(material, page)).collect();
        let mut root = text::change_member(root, "materials", &changed, &copies);

        const LINEAR: u32 = 9729;
        const CLAMP_TO_EDGE: u32 = 33071;
        let sampler = json!({"magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE});
        let (sampler_number, first_image) = (document.root.samplers.len(), document.root.images.len());
        let (mut images, mut textures, mut used) = (Vec::new(), Vec::new(), vec!["MOZ_lightmap"]);
        for (source, page) in (first_image..).zip(pages) {
            let (kind, is_radiance) = kind(page.file);
            let mut image = json!({"name": page.file, "mimeType": kind});
            match page.embedded {
                Some(bytes) => image["bufferView"] = data.view(bytes).into(),
                None => image["uri"] = escaped(page.file).into(),
            }
            images.push(image.to_string());
            let texture = match is_radiance {
                true => {
                    used.push("MOZ_texture_rgbe");
                    json!({"sampler": sampler_number, "extensions": {"MOZ_texture_rgbe": {"source": source}}})
                }
                false => json!({"sampler": sampler_number, "source": source}),
            };
            textures.push(texture.to_string());
        }
        root = text::change_member(&root, "samplers", &none, &[sampler.to_string()]);
        root = text::change_member(&root, "images", &none, &images);
        root = text::change_member(&root, "textures", &none, &textures);
        used.dedup();
        used.retain(|name| document.root.extensions_used.iter().all(|other| other != name));
        let used: Vec<String> = used.into_iter().map(text::string).collect();
        text::change_member(&root, "extensionsUsed", &none, &used)
    }
}

/// The media type of a file by its name, and whether it is a Radiance picture.
fn kind(file: &str) -> (&'static str, bool) {
    match file.rsplit_once('.').map(|(_, extension)| extension) {
        Some("hdr") => ("image/vnd.radiance", true),
        Some("ktx2") => ("image/ktx2", false),
        _ => ("image/x-exr", false),
    }
}

/// A file's name as a URI.
fn escaped(file: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
    let escape = |byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    file.bytes().map(escape).collect()
}
