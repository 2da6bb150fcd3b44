//! Pictures on surfaces: texels in sRGB, looked up in linear colours.
//!
//! Filtering is bilinear or none; it mixes linear colours. Deviation: there are no smaller levels for surfaces far away:
//! the samples of a pixel take their mean.

use std::sync::LazyLock;

use glam::{Affine2, DVec4, IVec2, Vec2, Vec4};

/// A picture of 8 bits per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    texels: Vec<[u8; 4]>,
    mean: Vec4,
}

/// How a texture lies on surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureMap {
    /// An index into [`Scene::textures`](super::Scene::textures).
    pub texture: usize,
    /// The set of texture coordinates: 0 for a mesh's `texcoords`, 1 for its `lightmap_texcoords`. Where there are none,
    /// the texture's mean counts.
    pub set: u32,
    /// Takes texture coordinates to the picture.
    pub transform: Affine2,
    /// What is beyond the picture, across and down.
    pub wrap: [Wrap; 2],
    /// Whether texels are mixed.
    pub filter: TextureFilter,
}

/// What lies beyond a picture.
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

/// How a colour between the centres of texels is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// A mean of the nearest four.
    #[default]
    Bilinear,
    /// The nearest.
    Nearest,
}

impl Texture {
    /// A picture of these texels, sRGB and alpha, row by row from the top.
    ///
    /// # Panics
    /// If there are none, or not as many as the size says.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Self {
        assert!(!texels.is_empty() && texels.len() as u64 == u64::from(width) * u64::from(height), "texels of all");
        let sum: DVec4 = texels.iter().map(|&texel| linear(texel).as_dvec4()).sum();
        let mean = (sum / texels.len() as f64).as_vec4();
        Self { width, height, texels, mean }
    }

    /// The mean of all texels: linear colour and alpha.
    pub fn mean(&self) -> Vec4 {
        self.mean
    }

    /// Width, height, and all texels row by row.
    pub(super) fn parts(&self) -> (u32, u32, &[[u8; 4]]) {
        (self.width, self.height, &self.texels)
    }

    /// The colour, linear with alpha, at texture coordinates; (0, 0) is the picture's upper left corner.
    pub(crate) fn sample(&self, map: &TextureMap, texcoord: Vec2) -> Vec4 {
        let place = map.transform.transform_point2(texcoord) * Vec2::new(self.width as f32, self.height as f32);
        if map.filter == TextureFilter::Nearest {
            return self.texel(map.wrap, place.floor());
        }
        let corner = (place - 0.5).floor();
        let part = place - 0.5 - corner;
        let texel = |x, y| self.texel(map.wrap, corner + Vec2::new(x, y));
        let above = texel(0.0, 0.0).lerp(texel(1.0, 0.0), part.x);
        let below = texel(0.0, 1.0).lerp(texel(1.0, 1.0), part.x);
        let color = above.lerp(below, part.y);
        // What is far out has no part of a texel, nor has what is not a number.
        if color.is_finite() { color } else { self.texel(map.wrap, corner) }
    }

    fn texel(&self, wrap: [Wrap; 2], place: Vec2) -> Vec4 {
        let IVec2 { x, y } = place.as_ivec2();
        let (x, y) = (wrap[0].within(x, self.width), wrap[1].within(y, self.height));
        linear(self.texels[y * self.width as usize + x])
    }
}

impl Wrap {
    /// The texel that is seen at `place`, of `size`.
    fn within(self, place: i32, size: u32) -> usize {
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

/// The transfer function of sRGB (IEC 61966-2-1), from codes to linear light.
fn linear([r, g, b, a]: [u8; 4]) -> Vec4 {
    static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
        core::array::from_fn(|code| {
            let signal = code as f64 / 255.0;
            let light = if signal <= 0.04045 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) };
            light as f32
        })
    });
    let [r, g, b] = [r, g, b].map(|code| LINEAR[usize::from(code)]);
    Vec4::new(r, g, b, f32::from(a) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(wrap: Wrap, filter: TextureFilter) -> TextureMap {
        TextureMap { texture: 0, set: 0, transform: Affine2::IDENTITY, wrap: [wrap; 2], filter }
    }

    /// Three texels in a row, whose alphas are 0, 0.2 and 1, and whose colours are black, 188 and white.
    fn row() -> Texture {
        Texture::new(3, 1, vec![[0, 0, 0, 0], [188, 188, 188, 51], [255; 4]])
    }

    #[test]
    fn colours_are_linear() {
        // The inverse of the published codes for 0.5 and 0.18.
        assert!((linear([188, 118, 255, 0]) - Vec4::new(0.5, 0.18, 1.0, 0.0)).abs().max_element() < 0.003);
        let mean = row().mean();
        assert!((mean - Vec4::new(0.5, 0.5, 0.5, 0.4)).abs().max_element() < 0.002, "{mean}");
    }

    #[test]
    fn texels_are_mixed_between_their_centres() {
        let alpha = |filter, u: f32| row().sample(&map(Wrap::Repeat, filter), Vec2::new(u / 3.0, 0.3)).w;
        let near = |found: f32, expected: f32| assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
        for (u, expected) in [(0.5, 0.0), (1.5, 0.2), (1.0, 0.1), (2.0, 0.6), (2.25, 0.8), (3.0, 0.5), (0.0, 0.5)] {
            near(alpha(TextureFilter::Bilinear, u), expected);
        }
        for (u, expected) in [(0.9, 0.0), (1.1, 0.2), (2.9, 1.0), (3.1, 0.0)] {
            near(alpha(TextureFilter::Nearest, u), expected);
        }
    }

    #[test]
    fn pictures_are_wrapped() {
        let places = |wrap: Wrap| (-4..7).map(|place| wrap.within(place, 3)).collect::<Vec<_>>();
        assert_eq!(places(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(places(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!(places(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn no_coordinate_is_too_far_out() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for filter in [TextureFilter::Bilinear, TextureFilter::Nearest] {
                for u in [f32::MAX, f32::MIN, f32::NAN, f32::INFINITY, 1e9, -1e9] {
                    let color = row().sample(&map(wrap, filter), Vec2::new(u, u));
                    assert!(color.is_finite() && color.min_element() >= 0.0 && color.max_element() <= 1.0);
                }
            }
        }
    }
}
