//! The sun of a sky picture: the one narrow cone from which most of its brightest light comes.
//!
//! As a light of its own it is found where glass refracts it, and where mirrors show it to surfaces, as a directional light
//! is: paths would find it there by chance. Its light is the excess of each texel over the limit of [`Peaks`].

use glam::{DVec3, Vec3};

use super::peaks::Peaks;
use super::texels::SkyTexels;
use crate::light::luminance_weight;
use crate::scene::PunctualLight;

/// The greatest angle between the brightest texel and the others of a sun, in radians: 3°.
const REACH: f32 = 0.05;
/// The part of the light within that reach that is the sun's. The rest is glare around it.
const PART: f64 = 0.95;
/// The least part of all of the brightest light that is a sun's.
const LEAST: f64 = 0.5;

/// Where the sun of a picture is, and what it is as a directional light.
#[derive(Debug)]
pub(super) struct PictureSun {
    /// It shines from the middle of the cone, as much as all of the sun does.
    pub(super) light: PunctualLight,
    to_middle: Vec3,
    /// The square of the greatest distance of its unit vectors from the middle.
    chord_squared: f32,
}

/// The brightest light of one texel.
struct Spot {
    direction: Vec3,
    /// Irradiance on what faces it, and its weight.
    irradiance: DVec3,
    weight: f64,
}

impl PictureSun {
    /// The sun among the peaks of a picture; `None` if they are spread widely.
    pub(super) fn of(texels: &SkyTexels, peaks: &Peaks) -> Option<Self> {
        let mut brightest = (0.0, Vec3::ZERO);
        Self::each_spot(texels, peaks, |spot, brightness| {
            if brightness > brightest.0 {
                brightest = (brightness, spot.direction);
            }
        });
        let mut spots = Vec::new();
        Self::each_spot(texels, peaks, |spot, _| {
            if spot.direction.distance(brightest.1) < REACH {
                spots.push(spot);
            }
        });
        let middle: DVec3 = spots.iter().map(|spot| spot.weight * spot.direction.as_dvec3()).sum();
        let to_middle = middle.as_vec3().normalize_or_zero();
        let distance = |spot: &Spot| spot.direction.distance_squared(to_middle);
        spots.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let enough = PART * spots.iter().map(|spot| spot.weight).sum::<f64>();
        let (mut weight, mut irradiance, mut farthest) = (0.0, DVec3::ZERO, 0.0);
        for spot in &spots {
            if weight >= enough {
                break;
            }
            weight += spot.weight;
            irradiance += spot.irradiance;
            farthest = distance(spot);
        }
        // The tents of the outermost texels reach this far.
        let chord = farthest.sqrt() + texels.texel_angle();
        let light = PunctualLight::Directional {
            direction: -to_middle,
            irradiance: irradiance.as_vec3(),
            half_angle: 2.0 * (0.5 * chord).asin(),
        };
        let is_narrow = chord < 2.0 * REACH && weight > LEAST * peaks.total();
        is_narrow.then_some(Self { light, to_middle, chord_squared: chord * chord })
    }

    /// Calls `see` with each texel's part of the peaks, and its brightness.
    fn each_spot(texels: &SkyTexels, peaks: &Peaks, mut see: impl FnMut(Spot, f32)) {
        peaks.each(texels.picture(), |row, column, texel| {
            let solid_angle = texels.picture().solid_angle(row);
            let excess = peaks.split(texel).1;
            let (irradiance, weight) =
                (excess.as_dvec3() * solid_angle, f64::from(luminance_weight(excess)) * solid_angle);
            let direction = texels.middle(column, row);
            see(Spot { direction, irradiance, weight }, luminance_weight(texel));
        });
    }

    /// Whether a unit vector looks at the sun.
    pub(super) fn contains(&self, direction: Vec3) -> bool {
        self.to_middle.distance_squared(direction) <= self.chord_squared
    }
}
