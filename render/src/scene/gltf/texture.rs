//! Textures: PNG and JPEG images from files, data URIs or buffers, with samplers and `KHR_texture_transform`.
//!
//! Images of 16 bits per channel are read as of 8. An image that is missing or damaged is an error. One of another kind
//! (KTX2, WebP), for which the file need not hold a substitute, is left out with a warning.

use std::collections::BTreeMap;

use ::gltf::json::texture::{Info, MagFilter, Sampler, WrappingMode};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Image, Index};
use glam::{Affine2, Mat2, Vec2};
use image::ImageFormat;

use super::{Document, accessor, container};
use crate::scene::count;
use crate::scene::{SceneError, Texture, TextureFilter, TextureMap, Wrap};

/// The textures that materials use, each image once.
#[derive(Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    /// The number in the list of each image that was asked for; `None` if it cannot be read.
    images: BTreeMap<usize, Option<usize>>,
    /// Uses of textures that cannot be read.
    unread: usize,
}

impl Textures {
    /// How the texture that `info` names lies on surfaces; `None` if it is of a kind that is not read. `user` is the
    /// material.
    pub(super) fn map(
        &mut self,
        document: &Document,
        info: &Info,
        user: &str,
        warnings: &mut Vec<String>,
    ) -> Result<Option<TextureMap>, SceneError> {
        let texture = document.object(info.index, "texture", user)?;
        let place = format!("texture {}", info.index.value());
        /// What the crate `gltf` has for a texture without an image.
        const NO_IMAGE: usize = u32::MAX as usize;
        let number = match texture.source.value() {
            NO_IMAGE => None,
            _ => self.image(document, texture.source, &place)?,
        };
        let Some(number) = number else {
            self.unread += 1;
            return Ok(None);
        };
        let sampler = texture.sampler.map(|sampler| document.object(sampler, "sampler", &place)).transpose()?;
        let (wrap, filter) = sampler.map_or_else(Default::default, sampling);
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord);
        if set > 1 {
            let path = document.path.display();
            warnings.push(format!("{path}: {user}: TEXCOORD_{set} is not read, so a texture's mean colour is used"));
        }
        let transform = transform.map_or(Affine2::IDENTITY, |transform| {
            // Scale, then turn counter-clockwise as one sees it, with v downwards.
            let (sin, cos) = transform.rotation.0.sin_cos();
            let scale = Mat2::from_diagonal(Vec2::from(transform.scale.0));
            let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
            Affine2::from_mat2_translation(turn * scale, Vec2::from(transform.offset.0))
        });
        Ok(Some(TextureMap { texture: number, set, transform, wrap, filter }))
    }

    /// The number in the list of this image.
    fn image(&mut self, document: &Document, index: Index<Image>, user: &str) -> Result<Option<usize>, SceneError> {
        if let Some(known) = self.images.get(&index.value()) {
            return Ok(*known);
        }
        let texture = read(document, document.object(index, "image", user)?, index.value())?;
        let number = texture.map(|texture| {
            self.list.push(texture);
            self.list.len() - 1
        });
        self.images.insert(index.value(), number);
        Ok(number)
    }

    /// What was left out, for the warnings.
    pub(super) fn warning(&self, document: &Document) -> Option<String> {
        let unread = count(self.unread, "texture is", "textures are");
        let path = document.path.display();
        (self.unread > 0).then(|| format!("{path}: {unread} neither PNG nor JPEG; the material's factor is used alone"))
    }
}

/// The image's texels, if it is a PNG or a JPEG.
fn read(document: &Document, image: &Image, index: usize) -> Result<Option<Texture>, SceneError> {
    let place = format!("image {index}");
    let bytes = match (image.buffer_view, &image.uri) {
        (Some(view), _) => accessor::view(document, view, &place)?.to_vec(),
        (None, Some(uri)) => container::fetch(document.files, document.path, uri, &place)?,
        (None, None) => return Err(document.error(place, "it has no data", "give it a `uri` or a `bufferView`")),
    };
    let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = image::guess_format(&bytes).ok() else {
        return Ok(None);
    };
    let image = image::load_from_memory_with_format(&bytes, format).map_err(|error| {
        document.error(place.clone(), format!("it is damaged: {error}"), "export the model again, with its textures")
    })?;
    let image = image.into_rgba8();
    if image.is_empty() {
        return Err(document.error(place, "it has no texels", "export the model again, with its textures"));
    }
    let (width, height) = image.dimensions();
    let texels = image.pixels().map(|pixel| pixel.0).collect();
    Ok(Some(Texture::new(width, height, texels)))
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
