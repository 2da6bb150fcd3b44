//! The mapping of a texture: texture coordinates, their transform, wrapping, filtering.

use glam::{Affine2, Vec2};

/// The mapping of a texture onto surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureMap {
    /// An index into [`Scene::textures`](super::super::Scene::textures).
    pub texture: usize,
    /// The set of texture coordinates: 0 for a mesh's `texcoords`, 1 for its `lightmap_texcoords`. Where there are
    /// none, the texture's mean counts.
    pub set: u32,
    /// Takes texture coordinates to the picture, whose upper left corner is (0, 0).
    pub transform: Affine2,
    /// Wrapping beyond the picture, across and down.
    pub wrap: [Wrap; 2],
    /// Whether texels are mixed.
    pub filter: TextureFilter,
    /// The meaning of the texels' numbers.
    pub space: ColorSpace,
}

/// Wrapping beyond a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The picture's mirror image.
    Mirror,
    /// Its border.
    Clamp,
}

/// Interpolation between the centres of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// A mean of the nearest four.
    #[default]
    Bilinear,
    /// The nearest.
    Nearest,
}

/// The meaning of the texels' numbers. Alpha is always linear, and so are pictures of 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorSpace {
    /// Colours, encoded with the transfer function of sRGB (IEC 61966-2-1).
    #[default]
    Srgb,
    /// Numbers as they are: roughness, normals, weights.
    Linear,
}

impl Default for TextureMap {
    /// The first texture, in sRGB, repeated over the first set of coordinates.
    fn default() -> Self {
        Self {
            texture: 0,
            set: 0,
            transform: Affine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            filter: TextureFilter::Bilinear,
            space: ColorSpace::Srgb,
        }
    }
}

impl TextureMap {
    /// Texture coordinates in units of the picture: 0 to 1.
    #[inline]
    pub(super) fn place(&self, texcoord: Vec2) -> Vec2 {
        self.transform.transform_point2(texcoord)
    }
}

impl Wrap {
    /// The texel that is seen at `place`, of `size`.
    #[inline]
    pub(super) fn within(self, place: i32, size: u32) -> usize {
        // Mostly it is, and divisions are slow.
        if (place as u32) < size && place >= 0 {
            return place as usize;
        }
        let (place, size) = (i64::from(place), i64::from(size));
        let within = match self {
            Self::Repeat => place.rem_euclid(size),
            Self::Mirror => {
                let place = place.rem_euclid(2 * size);
                place.min(2 * size - 1 - place)
            }
            Self::Clamp => place.clamp(0, size - 1),
        };
        within as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_wrapped() {
        let places = |wrap: Wrap| (-4..7).map(|place| wrap.within(place, 3)).collect::<Vec<_>>();
        assert_eq!(places(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(places(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!(places(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
    }
}
