//! Environment maps: from pbrt's square, the equal-area octahedral map of Clarberg ("Fast Equal-Area Mapping of the
//! (Hemi)Sphere using SIMD", 2008), to an equirectangular picture.
//!
//! The picture is twice as wide and as high as the square, and so has twice as many texels; each is the mean of the
//! nearest texels at [`SAMPLES`]² points, evenly spread in longitude and in the sine of the latitude.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use glam::{DMat3, DVec2, DVec3, Vec3};

use super::spectrum::LUMINANCE;
use crate::scene::{ColorSpace, SkyPicture, Texture, TextureFilter, TextureMap, Wrap};

/// Places along each side of a texel.
const SAMPLES: u32 = 4;

/// Where a unit vector is in the square, whose first row is at y = 0.
fn to_square(direction: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = direction.abs();
    let radius = (1.0 - z).max(0.0).sqrt();
    let turn = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) * FRAC_2_PI };
    let (mut u, mut v) = (radius - turn * radius, turn * radius);
    if direction.z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    0.5 * (DVec2::new(u.copysign(direction.x), v.copysign(direction.y)) + 1.0)
}

/// The sky of a square picture, in the colours of `scale`. `to_light` takes directions of the world to those of the
/// light.
pub(super) fn resample(square: &Texture, to_light: DMat3, scale: Vec3) -> SkyPicture {
    let (side, _) = square.size();
    let map = TextureMap {
        filter: TextureFilter::Nearest,
        wrap: [Wrap::Clamp; 2],
        space: ColorSpace::Srgb,
        ..TextureMap::default()
    };
    let (width, height) = (2 * side, side);
    let texel = |index: u32| {
        let (column, row) = (index % width, index / width);
        let edges = [row, row + 1].map(|row| (PI * f64::from(row) / f64::from(height)).cos());
        let mut sum = Vec3::ZERO;
        for place in 0..SAMPLES * SAMPLES {
            let [across, down] =
                [place % SAMPLES, place / SAMPLES].map(|it| (f64::from(it) + 0.5) / f64::from(SAMPLES));
            // Longitude runs from -z in the middle to +x on the right.
            let longitude = TAU * ((f64::from(column) + across) / f64::from(width) - 0.5);
            let y = edges[0] + (edges[1] - edges[0]) * down;
            let ring = (1.0 - y * y).max(0.0).sqrt();
            let direction = DVec3::new(ring * longitude.sin(), y, -ring * longitude.cos());
            let found = to_square((to_light * direction).normalize_or(DVec3::Z));
            sum += square.sample(&map, found.as_vec2()).truncate();
        }
        (sum * scale / (SAMPLES * SAMPLES) as f32).max(Vec3::ZERO)
    };
    SkyPicture::new(width, height, (0..width * height).map(texel).collect())
}

/// What pbrt takes for the irradiance of a plane that faces +z of the light, by luminance: half of what it is, as it
/// takes 2π for the solid angle of all directions. `illuminance` is divided by it, so that pictures are as bright as
/// pbrt's.
pub(super) fn illuminance(square: &Texture) -> f64 {
    let (side, _) = square.size();
    let map = TextureMap { filter: TextureFilter::Nearest, ..TextureMap::default() };
    let texel = |index: u32| {
        let place = DVec2::new(f64::from(index % side) + 0.5, f64::from(index / side) + 0.5) / f64::from(side);
        let cos = height(place);
        if cos > 0.0 { cos * f64::from(square.sample(&map, place.as_vec2()).truncate().dot(LUMINANCE)) } else { 0.0 }
    };
    TAU * (0..side * side).map(texel).sum::<f64>() / f64::from(side * side)
}

/// The z of a place in the square.
fn height(place: DVec2) -> f64 {
    let DVec2 { x, y } = (2.0 * place - 1.0).abs();
    let distance = 1.0 - (x + y);
    let radius = 1.0 - distance.abs();
    (1.0 - radius * radius).copysign(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::texture::Texels;

    fn square(side: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Texture {
        let texels = (0..side * side).flat_map(|index| texel(index % side, index / side)).collect();
        Texture::from_texels(side, side, 3, Texels::F32(texels))
    }

    #[test]
    fn axes_are_where_the_map_has_them() {
        let near = |direction: DVec3, x: f64, y: f64| {
            let found = to_square(direction);
            assert!((found - DVec2::new(x, y)).length() < 1e-12, "{direction}: {found}");
        };
        near(DVec3::Z, 0.5, 0.5);
        near(DVec3::X, 1.0, 0.5);
        near(DVec3::NEG_X, 0.0, 0.5);
        near(DVec3::Y, 0.5, 1.0);
        near(DVec3::NEG_Y, 0.5, 0.0);
        near(DVec3::NEG_Z, 1.0, 1.0);
        for direction in [DVec3::new(0.3, -0.5, 0.2), DVec3::new(-0.3, 0.1, -0.9), DVec3::new(0.7, 0.7, 0.01)] {
            let direction = direction.normalize();
            assert!((height(to_square(direction)) - direction.z).abs() < 1e-12);
        }
    }

    /// Equal areas of the square are equal solid angles, so means agree; and where the light is does, too.
    #[test]
    fn the_sky_has_the_mean_of_the_square_and_its_light_at_the_same_place() {
        let lit = |x, y| if x >= 16 && y >= 16 && x + y < 40 { [8.0, 2.0, 1.0] } else { [0.5, 0.25, 0.125] };
        let texture = square(32, lit);
        let sky = resample(&texture, DMat3::IDENTITY, Vec3::ONE);
        let (found, expected) = (sky.mean(), texture.mean().truncate());
        assert!((found / expected - 1.0).abs().max_element() < 0.01, "{found}, not {expected}");
        // +x, +y, +z: the upper half, behind (+z) and to the right.
        let texel = |direction: DVec3| {
            let (x, y) = (direction.x.atan2(-direction.z) / TAU + 0.5, direction.normalize().y.acos() / PI);
            sky.texels[(y * 32.0) as usize * 64 + (x * 64.0) as usize]
        };
        assert_eq!(texel(DVec3::new(1.0, 1.0, 4.0)), Vec3::new(8.0, 2.0, 1.0));
        assert_eq!(texel(DVec3::new(-1.0, 1.0, 4.0)), Vec3::new(0.5, 0.25, 0.125));
    }

    #[test]
    fn a_constant_sky_has_half_of_pi() {
        assert!((illuminance(&square(64, |_, _| [2.0; 3])) - PI).abs() < 1e-2);
    }
}
