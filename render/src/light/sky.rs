//! The sky as a light.
//!
//! A constant sky is sampled by the cosine. A picture is sampled by its texels' brightness times their solid angle: a row
//! by the brightness of all of it, then a texel of the row, each by an alias table, and a direction in the texel evenly by
//! solid angle. So the density of a direction is its texel's share of all light over the texel's solid angle, exactly.
//!
//! Whoever gathers from all sides by evenly spread rays finds a sun by chance, or not at all. For gathers a picture is the
//! sum of two: its *sun*, that by which texels are brighter than a few times the rest, is sampled as a light is, and what
//! is left has no peaks.

mod sun;

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{AliasEntry, AliasTable, Frame, ONE_MINUS_EPSILON};

use self::sun::SunTexels;
use super::brightness;
use crate::scene::{Sky, SkyPicture};

/// The sky, ready to be sampled.
#[derive(Debug)]
pub(crate) struct SkyLight {
    constant: Vec3,
    mean: Vec3,
    panorama: Option<Panorama>,
    sun: Option<SunTexels>,
}

/// A picture with its tables.
#[derive(Debug)]
struct Panorama {
    picture: SkyPicture,
    rows: AliasTable<Vec<AliasEntry>>,
    /// `None` for rows that are black.
    texels: Vec<Option<AliasTable<Vec<AliasEntry>>>>,
}

impl SkyLight {
    pub(crate) fn new(sky: Sky) -> Self {
        let mean = sky.mean();
        let Sky { radiance: constant, picture } = sky;
        let panorama = picture.and_then(|mut picture| {
            picture.texels.iter_mut().for_each(|texel| *texel += constant);
            Panorama::new(picture)
        });
        let sun = panorama.as_ref().and_then(|panorama| SunTexels::of(&panorama.picture));
        Self { constant, mean, panorama, sun }
    }

    /// Radiance from this unit vector.
    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        match &self.panorama {
            Some(panorama) => panorama.picture.texels[panorama.texel(direction).2],
            None => self.constant,
        }
    }

    /// Radiance from this unit vector without the sun.
    pub(crate) fn ambient(&self, direction: Vec3) -> Vec3 {
        let radiance = self.radiance(direction);
        self.sun.as_ref().map_or(radiance, |sun| sun.split(radiance).0)
    }

    /// Mean radiance of all directions.
    pub(crate) fn mean(&self) -> Vec3 {
        self.mean
    }

    /// The part of the mean that is the sun's.
    pub(crate) fn mean_sun(&self) -> Vec3 {
        self.sun.as_ref().map_or(Vec3::ZERO, SunTexels::mean)
    }

    /// A direction in which to look for the sun, and its radiance there over the density per solid angle.
    pub(crate) fn sample_sun(&self, u: Vec2) -> Option<(Vec3, Vec3)> {
        Some(self.sun.as_ref()?.sample(&self.panorama.as_ref()?.picture, u))
    }

    /// A direction in which to look for light from a surface with this shading normal.
    pub(crate) fn sample(&self, normal: Vec3, u: Vec2) -> Vec3 {
        match &self.panorama {
            Some(panorama) => panorama.sample(u),
            None => Frame::from_normal(normal).to_world(CosineHemisphere.map(u)),
        }
    }

    /// The density per solid angle with which [`sample`](Self::sample) gives this unit vector.
    pub(crate) fn density(&self, normal: Vec3, direction: Vec3) -> f32 {
        match &self.panorama {
            Some(panorama) => panorama.density(direction),
            None => normal.dot(direction).max(0.0) * FRAC_1_PI,
        }
    }
}

impl Panorama {
    /// `None` if the picture is black.
    fn new(picture: SkyPicture) -> Option<Self> {
        let table = |weights: &[f64], greatest: f64| {
            let weights: Vec<f32> = weights.iter().map(|weight| (weight / greatest) as f32).collect();
            AliasTable::build(&weights, vec![AliasEntry::default(); weights.len()]).ok()
        };
        let (mut sums, mut texels) = (Vec::new(), Vec::new());
        for (row, colors) in (0..).zip(picture.texels.chunks_exact(picture.width as usize)) {
            let weights: Vec<f64> = colors.iter().map(|color| brightness(*color)).collect();
            let greatest = weights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            sums.push(weights.iter().sum::<f64>() * picture.solid_angle(row));
            texels.push(table(&weights, greatest));
        }
        let greatest = sums.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        Some(Self { rows: table(&sums, greatest)?, picture, texels })
    }

    /// Column, row and number of the texel in a direction.
    fn texel(&self, direction: Vec3) -> (usize, usize, usize) {
        let [width, height] = [self.picture.width, self.picture.height];
        let phi = direction.x.atan2(-direction.z) + self.picture.rotation;
        let across = (phi / TAU + 0.5).rem_euclid(1.0);
        // More exact near the poles than the arc cosine.
        let down = Vec2::new(direction.x, direction.z).length().atan2(direction.y) / PI;
        let place = |part: f32, size: u32| ((part * size as f32) as usize).min(size as usize - 1);
        let (column, row) = (place(across, width), place(down, height));
        (column, row, row * width as usize + column)
    }

    fn sample(&self, u: Vec2) -> Vec3 {
        let (row, _, down) = self.rows.sample(u.y.into());
        let Some(texels) = &self.texels[row] else { return Vec3::Y };
        let (column, _, across) = texels.sample(u.x.into());
        direction_in(&self.picture, (column, row), (across as f32, down as f32))
    }

    fn density(&self, direction: Vec3) -> f32 {
        let (column, row, _) = self.texel(direction);
        let Some(texels) = &self.texels[row] else { return 0.0 };
        self.rows.mass(row) * texels.mass(column) / self.picture.solid_angle(row as u32) as f32
    }
}

/// The direction of a place in a texel, `across` and `down` it in [0, 1): even by solid angle.
fn direction_in(picture: &SkyPicture, (column, row): (usize, usize), (across, down): (f32, f32)) -> Vec3 {
    // Even in the cosine.
    let border = |row: usize| (PI * row as f32 / picture.height as f32).cos();
    let cosine = border(row) + (border(row + 1) - border(row)) * down.min(ONE_MINUS_EPSILON);
    let phi = TAU * ((column as f32 + across) / picture.width as f32 - 0.5) - picture.rotation;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    Vec3::new(sine * phi.sin(), cosine, -sine * phi.cos())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use halfdome_kernel::sampling::Stream;

    use super::*;

    /// A sky of 12 x 6 texels with a sun, a black row and much that is dim.
    fn picture() -> SkyPicture {
        let texel = |i: usize| match i {
            29 => Vec3::new(1000.0, 900.0, 500.0),
            12..24 => Vec3::ZERO,
            _ => Vec3::new(0.1, 0.2, 0.01 * i as f32),
        };
        SkyPicture { width: 12, height: 6, texels: (0..72).map(texel).collect(), rotation: 1.0 }
    }

    fn directions(panorama: &Panorama, count: u32) -> Vec<Vec3> {
        (0..count).map(|i| panorama.sample(Stream::new(7, 0, i).uniform2(0))).collect()
    }

    #[test]
    fn the_mean_of_samples_is_the_pictures_integral() {
        let panorama = Panorama::new(picture()).unwrap();
        let mut sum = DVec3::ZERO;
        let count = 100_000;
        for direction in directions(&panorama, count) {
            assert!(direction.is_normalized());
            let (_, _, texel) = panorama.texel(direction);
            // A rounding error may lead to a neighbour, which is black or counts with its own density.
            if panorama.density(direction) > 0.0 {
                sum += (panorama.picture.texels[texel] / panorama.density(direction)).as_dvec3();
            }
        }
        let (found, expected) = (sum / f64::from(count), picture().mean().as_dvec3() * 4.0 * std::f64::consts::PI);
        assert!(((found - expected) / expected).abs().max_element() < 0.01, "{found}, not {expected}");
        // Directions follow luminance, whose estimate is the same for all of them.
        let luminance = crate::light::luminance(found.as_vec3()) / crate::light::luminance(expected.as_vec3());
        assert!((luminance - 1.0).abs() < 1e-4, "{luminance}");
    }

    #[test]
    fn directions_are_as_dense_as_the_density_says() {
        let texels = picture().texels.iter().map(|texel| texel.min(Vec3::splat(0.5))).collect();
        let panorama = Panorama::new(SkyPicture { texels, ..picture() }).unwrap();
        let count = 200_000;
        let mut counts = [0_u32; 72];
        for direction in directions(&panorama, count) {
            counts[panorama.texel(direction).2] += 1;
        }
        let mut total = 0.0;
        for (texel, found) in counts.into_iter().enumerate() {
            let (column, row) = (texel % 12, texel / 12);
            let (theta, phi) = (PI * (row as f32 + 0.5) / 6.0, TAU * ((column as f32 + 0.5) / 12.0 - 0.5) - 1.0);
            let middle = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            assert_eq!(panorama.texel(middle), (column, row, texel));
            let share = f64::from(panorama.density(middle)) * panorama.picture.solid_angle(row as u32);
            total += share;
            let (expected, standard_error) = (share * f64::from(count), (share * f64::from(count)).sqrt());
            assert!(
                (f64::from(found) - expected).abs() <= 5.0 * standard_error + 2.0,
                "{texel}: {found}, not {expected}"
            );
        }
        assert!((total - 1.0).abs() < 1e-5, "the density integrates to {total}");
    }

    #[test]
    fn a_turned_picture_is_seen_elsewhere() {
        let seen = |degrees: f32, direction: Vec3| {
            let panorama = Panorama::new(SkyPicture { rotation: 0.0, ..picture() }.turned(degrees)).unwrap();
            panorama.texel(direction).0
        };
        // The middle is towards -z, and the right of it towards +x. A quarter counter-clockwise brings it to -x.
        let slightly = Vec3::new(0.1, 0.0, 0.0);
        assert_eq!(seen(0.0, (Vec3::NEG_Z + slightly).normalize()), 6);
        assert_eq!(seen(0.0, (Vec3::X + Vec3::Z * 0.1).normalize()), 9);
        assert_eq!(seen(90.0, (Vec3::NEG_X - Vec3::Z * 0.1).normalize()), 6);
    }

    #[test]
    fn black_pictures_have_no_tables() {
        let black = SkyPicture { texels: vec![Vec3::ZERO; 72], ..picture() };
        assert!(Panorama::new(black.clone()).is_none());
        let sky = SkyLight::new(Sky { radiance: Vec3::ZERO, picture: Some(black) });
        assert_eq!((sky.radiance(Vec3::Y), sky.mean()), (Vec3::ZERO, Vec3::ZERO));
    }
}
