//! A clear sky and its sun, by one of two models: that of Hošek and Wilkie is in `hosek.rs`, and this one is of
//! Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999.
//!
//! Luminance and chromaticity are `F(θ, γ) / F(0, θ_s)` times those of the zenith, with Perez's
//! `F(θ, γ) = (1 + A e^{B / cos θ}) (1 + C e^{D γ} + E cos² γ)`, `θ` being a direction's angle from the zenith, `γ`
//! that from the sun, and the letters linear in turbidity.
//!
//! # Deviations
//! - Radiance is luminance over 683 lm/W: that of green light of the same luminance.
//! - The sun is an even disc of half a degree, without limb darkening, invisible to the camera itself but visible in
//!   mirrors. Its colour is white, dimmed by air and haze (the paper's Rayleigh and Ångström terms) at one wavelength a
//!   channel; ozone, other gases and vapour, which take a few percent, are left out.
//! - The sky is black below the horizon.

mod hosek;

use glam::{DMat3, DVec3, Vec3};

use super::{PunctualLight, SkyPicture};

/// The sun's place and the air's haze.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Daylight {
    /// Degrees above the horizon, from 0 to 90.
    pub elevation: f32,
    /// Degrees about +y from -z, clockwise as seen from above: 90 is +x.
    pub azimuth: f32,
    /// Haze: 2 for very clear air, 3 for clear, 6 for a hazy day; from [`Self::MIN_TURBIDITY`] to
    /// [`Self::MAX_TURBIDITY`].
    pub turbidity: f32,
}

/// The distribution of the sky's light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DaylightModel {
    /// Preetham, Shirley and Smits 1999.
    #[default]
    Preetham,
    /// Hošek and Wilkie 2012, which knows the ground.
    Hosek,
}

impl DaylightModel {
    /// Both, by their names in scene files and on the command line.
    pub const NAMES: [(&str, Self); 2] = [("preetham", Self::Preetham), ("hosek", Self::Hosek)];
}

/// Texels around the sky and down to its bottom.
const SIZE: [u32; 2] = [512, 256];
/// The factor from kcd/m² to W/(m² sr).
const RADIANCE: f64 = 1000.0 / 683.0;
/// Illuminance of the sun outside of the air, klx.
const SUN: f64 = 127.5;
/// Half the angle that the sun's disc subtends, radians.
const SUN_HALF_ANGLE: f32 = 0.004_65;
/// A wavelength for each channel, µm.
const WAVELENGTHS: [f64; 3] = [0.610, 0.550, 0.465];

/// Perez's letters for Y, x and y: factors of turbidity, and constants.
const PEREZ: [[[f64; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];
/// Of the zenith's x and y: rows for T², T and 1, columns for θ_s³, θ_s², θ_s and 1.
const ZENITH: [[[f64; 4]; 3]; 2] = [
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]],
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]],
];

impl Daylight {
    /// The clearest air for which the model holds.
    pub const MIN_TURBIDITY: f32 = 1.7;
    /// The haziest.
    pub const MAX_TURBIDITY: f32 = 10.0;

    /// The sky without the sun's disc, and the sun, both multiplied by `scale`; `albedo` is the ground's, which only
    /// some models have.
    pub fn light(&self, scale: f32, model: DaylightModel, albedo: Vec3) -> (SkyPicture, PunctualLight) {
        match model {
            DaylightModel::Preetham => self.light_of(scale, |direction| self.radiance(direction)),
            DaylightModel::Hosek => self.light_of(scale, hosek::sky(self, albedo)),
        }
    }

    fn light_of(&self, scale: f32, radiance: impl Fn(DVec3) -> DVec3) -> (SkyPicture, PunctualLight) {
        let [width, height] = SIZE;
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| {
            let theta = std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(height);
            let phi = std::f64::consts::TAU * ((f64::from(x) + 0.5) / f64::from(width) - 0.5);
            let direction = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            radiance(direction).as_vec3() * scale
        });
        let picture = SkyPicture { width, height, texels: texels.collect(), rotation: 0.0 };
        let sun = self.sun();
        let irradiance = (self.sun_irradiance() * f64::from(scale)).as_vec3();
        (picture, PunctualLight::Directional { direction: -sun.as_vec3(), irradiance, half_angle: SUN_HALF_ANGLE })
    }

    /// The unit vector to the sun.
    fn sun(&self) -> DVec3 {
        let (sin, cos) = f64::from(self.elevation).to_radians().sin_cos();
        let azimuth = f64::from(self.azimuth).to_radians();
        DVec3::new(cos * azimuth.sin(), sin, -cos * azimuth.cos())
    }

    /// The sky's radiance in a unit vector, linear sRGB.
    fn radiance(&self, direction: DVec3) -> DVec3 {
        if direction.y <= 0.0 {
            return DVec3::ZERO;
        }
        let (turbidity, sun) = (f64::from(self.turbidity), self.sun());
        let theta_s = sun.y.clamp(-1.0, 1.0).acos();
        let gamma = direction.dot(sun).clamp(-1.0, 1.0).acos();
        let chi = (4.0 / 9.0 - turbidity / 120.0) * (std::f64::consts::PI - 2.0 * theta_s);
        let zenith_luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
        let angles = [theta_s.powi(3), theta_s.powi(2), theta_s, 1.0];
        let chromaticity = |rows: [[f64; 4]; 3]| {
            let [a, b, c] = rows.map(|row| row.iter().zip(angles).map(|(factor, angle)| factor * angle).sum::<f64>());
            a * turbidity * turbidity + b * turbidity + c
        };
        let zenith = [zenith_luminance.max(0.0), chromaticity(ZENITH[0]), chromaticity(ZENITH[1])];
        let [luminance, x, y] = core::array::from_fn(|i| {
            let letters = PEREZ[i].map(|[factor, constant]| factor * turbidity + constant);
            zenith[i] * perez(letters, direction.y, gamma) / perez(letters, 1.0, theta_s)
        });
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        // IEC 61966-2-1.
        let to_rgb =
            DMat3::from_cols_array(&[3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415, 1.0570]);
        (to_rgb * xyz * RADIANCE).max(DVec3::ZERO)
    }

    /// The sun's irradiance on a surface that faces it.
    fn sun_irradiance(&self) -> DVec3 {
        let zenith_degrees = 90.0 - f64::from(self.elevation);
        let cosine = zenith_degrees.to_radians().cos();
        let air_mass = 1.0 / (cosine + 0.15 * (93.885 - zenith_degrees).powf(-1.253));
        let haze = 0.04608 * f64::from(self.turbidity) - 0.04586;
        DVec3::from(WAVELENGTHS.map(|wavelength| {
            let depth = 0.008735 * wavelength.powf(-4.08) + haze * wavelength.powf(-1.3);
            RADIANCE * SUN * (-depth * air_mass).exp()
        }))
    }
}

/// Perez's function, less its scale.
fn perez([a, b, c, d, e]: [f64; 5], cos_theta: f64, gamma: f64) -> f64 {
    (1.0 + a * (b / cos_theta).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::LUMINANCE;

    pub(super) fn luminance(radiance: DVec3) -> f64 {
        radiance.dot(LUMINANCE) / RADIANCE
    }

    /// Illuminance of a horizontal plane by a picture of the sky, klx.
    pub(super) fn horizontal(picture: &SkyPicture) -> f64 {
        let cosine = |row: usize| (std::f32::consts::PI * (row as f32 + 0.5) / 256.0).cos().max(0.0);
        let of_texel = |texel: usize| {
            let row = texel / 512;
            f64::from(cosine(row)) * picture.solid_angle(row as u32) * luminance(picture.texels[texel].as_dvec3())
        };
        (0..picture.texels.len()).map(of_texel).sum()
    }

    #[test]
    fn the_zenith_has_the_papers_luminance() {
        // χ of a sun at the zenith and T = 3 is (4/9 - 1/40) π; 7.1649 tan χ + 1.7727 is 27.77 kcd/m².
        let noon = Daylight { elevation: 90.0, azimuth: 0.0, turbidity: 3.0 };
        let zenith = luminance(noon.radiance(DVec3::Y));
        let expected = (4.0453 * 3.0 - 4.9710) * 1.317_628_f64.tan() - 0.2155 * 3.0 + 2.4192;
        assert!((zenith / expected - 1.0).abs() < 0.002, "{zenith}, not {expected}");
    }

    #[test]
    fn the_sky_is_brightest_about_the_sun_and_blue_across() {
        let day = Daylight { elevation: 30.0, azimuth: 90.0, turbidity: 2.5 };
        let sun = day.sun();
        assert!((sun - DVec3::new(0.75_f64.sqrt(), 0.5, 0.0)).length() < 1e-6);
        let at_sun = luminance(day.radiance(sun));
        let across = day.radiance(DVec3::new(-0.5, 0.75_f64.sqrt(), 0.0));
        assert!(at_sun > 5.0 * luminance(across));
        assert!(across.z > 1.5 * across.x, "{across}");
        let (left, right) = (day.radiance(DVec3::new(0.5, 0.5, 0.5)), day.radiance(DVec3::new(0.5, 0.5, -0.5)));
        assert!((left - right).length() < 1e-12 * left.length());
        assert_eq!(day.radiance(DVec3::NEG_Y), DVec3::ZERO);
    }

    #[test]
    fn a_low_sun_is_red_and_a_hazy_one_dim() {
        let sun = |elevation, turbidity| Daylight { elevation, azimuth: 0.0, turbidity }.sun_irradiance();
        let (high, low, hazy) = (sun(60.0, 2.5), sun(5.0, 2.5), sun(60.0, 8.0));
        assert!(low.x > 3.0 * low.z && high.x < 1.5 * high.z);
        assert!(hazy.max_element() < 0.8 * high.max_element());
        // A clear noon has 80 to 110 klx.
        assert!((80.0..110.0).contains(&luminance(high)), "{}", luminance(high));
    }

    #[test]
    fn the_picture_shows_the_sky_where_it_is() {
        let day = Daylight { elevation: 20.0, azimuth: 90.0, turbidity: 3.0 };
        let (picture, light) = day.light(2.0, DaylightModel::Preetham, Vec3::ZERO);
        let brightest =
            (0..picture.texels.len()).max_by(|&a, &b| picture.texels[a].y.total_cmp(&picture.texels[b].y)).unwrap();
        let (x, y) = (brightest as f32 % 512.0 / 512.0, (brightest / 512) as f32 / 256.0);
        // +x is three quarters across, and 70 degrees from the top are 0.39 down.
        assert!((x - 0.75).abs() < 0.02 && (y - 70.0 / 180.0).abs() < 0.05, "{x}, {y}");
        let PunctualLight::Directional { direction, irradiance, .. } = light else { panic!("the sun is far away") };
        assert!(direction.x < -0.9 && direction.y < 0.0);
        assert_eq!(irradiance, (2.0 * day.sun_irradiance()).as_vec3());
        // What a horizontal plane gets of a clear sky, without the sun: some klx.
        let received = horizontal(&picture);
        assert!((4.0..20.0).contains(&(received / 2.0)), "{received}");
        assert_eq!(picture.texels[512 * 200], glam::Vec3::ZERO);
    }
}
