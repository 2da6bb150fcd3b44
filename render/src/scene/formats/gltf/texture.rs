//! Textures: images from files, data URIs or buffers, with samplers and `KHR_texture_transform`.
//!
//! `EXT_texture_webp` and `KHR_texture_basisu` name an image before the texture's own `source`. An image that is
//! missing or damaged is an error; one of an unsupported kind is left out with a warning, and only the factor is used.

use std::collections::BTreeMap;

use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::texture::{Info, MagFilter, Sampler, WrappingMode};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Image, Index, Value};
use glam::{Affine2, Mat2, Vec2};

use super::{Document, accessor, container};
use crate::scene::formats::notes::Notes;
use crate::scene::texture::decode;
use crate::scene::{ColorSpace, SceneError, Texture, TextureFilter, TextureMap, Wrap};

/// The textures that materials use, each image once.
#[derive(Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    /// The number in the list of each image that was asked for; `None` if it cannot be read.
    images: BTreeMap<usize, Option<usize>>,
}

/// A material's reference to a texture.
pub(super) struct Reference<'a> {
    index: Index<::gltf::json::Texture>,
    set: u32,
    transform: Option<&'a TextureTransform>,
}

impl<'a> From<&'a Info> for Reference<'a> {
    fn from(info: &'a Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        Self { index: info.index, set: info.tex_coord, transform }
    }
}

impl<'a> Reference<'a> {
    /// A reference of a kind for which the crate `gltf` has no transform.
    pub(super) fn new(index: Index<::gltf::json::Texture>, set: u32, transform: Option<&'a TextureTransform>) -> Self {
        Self { index, set, transform }
    }
}

impl Textures {
    /// How the texture that `reference` names lies on surfaces; `None` if it is of a kind that is not read. `user` is
    /// the material and its slot.
    pub(super) fn map<'r>(
        &mut self,
        document: &Document,
        reference: impl Into<Reference<'r>>,
        space: ColorSpace,
        user: &str,
        notes: &mut Notes,
    ) -> Result<Option<TextureMap>, SceneError> {
        let Reference { index, set, transform } = reference.into();
        let texture = document.object(index, "texture", user)?;
        let place = format!("texture {}", index.value());
        let Some(number) = self.source(document, texture, &place, user, notes)? else { return Ok(None) };
        let sampler = texture.sampler.map(|sampler| document.object(sampler, "sampler", &place)).transpose()?;
        let (wrap, filter) = sampler.map_or_else(Default::default, sampling);
        let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(set);
        if set > 1 {
            notes.add(format!("TEXCOORD_{set} is not read, so a texture's mean is used"), user);
        }
        let transform = transform.map_or(Affine2::IDENTITY, |transform| {
            // Scale, then turn counter-clockwise as one sees it, with v downwards.
            let (sin, cos) = transform.rotation.0.sin_cos();
            let scale = Mat2::from_diagonal(Vec2::from(transform.scale.0));
            let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
            Affine2::from_mat2_translation(turn * scale, Vec2::from(transform.offset.0))
        });
        if !transform.is_finite() {
            return Err(document.error(user, "its KHR_texture_transform is not finite", "use smaller numbers"));
        }
        Ok(Some(TextureMap { texture: number, set, transform, wrap, filter, space }))
    }

    /// The number in the list of the first image of a texture that can be read.
    fn source(
        &mut self,
        document: &Document,
        texture: &::gltf::json::Texture,
        place: &str,
        user: &str,
        notes: &mut Notes,
    ) -> Result<Option<usize>, SceneError> {
        /// What the crate `gltf` has for a texture without an image.
        const NO_IMAGE: u32 = u32::MAX;
        let objects = texture.extensions.as_ref().map(|extensions| &extensions.others);
        let mut sources: Vec<u32> = Vec::new();
        for (name, value) in objects.into_iter().flatten() {
            match (name.as_str(), value.get("source").and_then(Value::as_u64)) {
                ("EXT_texture_webp" | "KHR_texture_basisu", Some(source)) => {
                    sources.push(u32::try_from(source).unwrap_or(NO_IMAGE));
                }
                _ => notes.add(format!("{name} is not read"), place),
            }
        }
        sources.push(texture.source.value() as u32);
        let mut unread = None;
        for source in sources.into_iter().filter(|&source| source != NO_IMAGE) {
            match self.image(document, Index::new(source), place, user)? {
                Ok(number) => return Ok(Some(number)),
                Err(problem) => unread = unread.or(Some(problem)),
            }
        }
        let problem = unread.unwrap_or_else(|| format!("{place} has no image"));
        notes.add(format!("{problem}, so the material's factor is used alone"), user);
        Ok(None)
    }

    /// The number in the list of this image; or in words why it is of a kind that is not read.
    fn image(
        &mut self,
        document: &Document,
        index: Index<Image>,
        place: &str,
        user: &str,
    ) -> Result<Result<usize, String>, SceneError> {
        let image = document.object(index, "image", place)?;
        let name = named(index.value(), image);
        if let Some(known) = self.images.get(&index.value()) {
            return Ok(known.ok_or_else(|| format!("{name} is of a kind that is not read")));
        }
        let read = read(document, image, &name).map_err(|error| about(error, user))?;
        let number = read.map(|texture| {
            self.list.push(texture);
            self.list.len() - 1
        });
        self.images.insert(index.value(), number.as_ref().ok().copied());
        Ok(number)
    }
}

/// An image for messages: with the file that it is in, or else its name.
fn named(index: usize, image: &Image) -> String {
    let file = image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    match file.or(image.name.as_ref()) {
        Some(name) => format!("image {index} ({name:?})"),
        None => format!("image {index}"),
    }
}

/// Adds the user of an invalid texture to the error.
fn about(error: SceneError, user: &str) -> SceneError {
    SceneError { remedy: format!("{}; it is used by {user}", error.remedy), ..error }
}

/// The image's texels; or in words why it is of a kind that is not read.
fn read(document: &Document, image: &Image, place: &str) -> Result<Result<Texture, String>, SceneError> {
    let bytes = match (image.buffer_view, &image.uri) {
        (Some(view), _) => accessor::view(document, view, place)?.to_vec(),
        (None, Some(uri)) => container::fetch(document.files, document.path, uri, place)?,
        (None, None) => return Err(document.error(place, "it has no data", "give it a `uri` or a `bufferView`")),
    };
    if document.without_pictures {
        return Ok(Ok(Texture::new(1, 1, vec![[255; 4]])));
    }
    match decode(&bytes, None) {
        Ok(texture) => Ok(Ok(texture)),
        Err(error) if error.is_unknown_kind => Ok(Err(format!("{place}: {}", error.problem))),
        Err(error) => Err(document.error(place, error.problem, error.remedy)),
    }
}

fn sampling(sampler: &Sampler) -> ([Wrap; 2], TextureFilter) {
    let wrap = |wrap: &Checked<WrappingMode>| match wrap {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    let filter = match sampler.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => TextureFilter::Nearest,
        _ => TextureFilter::Bilinear,
    };
    ([wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)], filter)
}
