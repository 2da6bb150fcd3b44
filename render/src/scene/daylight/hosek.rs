//! The sky of Hošek and Wilkie, "An Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012, by the crate
//! `hw-skymodel`: fitted to path traced skies, it is valid for a low sun and much haze too, and includes light from the
//! ground.
//!
//! The tables are for linear sRGB, in the unit that [`Daylight`] has: luminance over 683 lm/W.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};

use super::Daylight;

/// The radiance of a sky above ground of this albedo, by direction.
pub(super) fn sky(day: &Daylight, albedo: Vec3) -> impl Fn(DVec3) -> DVec3 + use<> {
    let elevation = f64::from(day.elevation).to_radians().clamp(0.0, FRAC_PI_2) as f32;
    let turbidity = day.turbidity.clamp(Daylight::MIN_TURBIDITY, Daylight::MAX_TURBIDITY);
    let albedo = albedo.clamp(Vec3::ZERO, Vec3::ONE).to_array();
    // Half a right angle may round to more than the crate takes.
    let elevation = elevation.min(core::f32::consts::FRAC_PI_2);
    let state = SkyState::new(&SkyParams { elevation, turbidity, albedo }).expect("within the ranges of the model");
    let sun = day.sun();
    move |direction| {
        if direction.y <= 0.0 {
            return DVec3::ZERO;
        }
        let theta = direction.y.min(1.0).acos() as f32;
        let gamma = direction.dot(sun).clamp(-1.0, 1.0).acos() as f32;
        let channels = [Channel::R, Channel::G, Channel::B];
        DVec3::from(channels.map(|channel| f64::from(state.radiance(theta, gamma, channel)))).max(DVec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{horizontal, luminance};
    use super::*;
    use crate::scene::DaylightModel;

    fn day(elevation: f32, turbidity: f32) -> Daylight {
        Daylight { elevation, azimuth: 90.0, turbidity }
    }

    /// The values of the crate, and so of the authors' tables.
    #[test]
    fn zeniths_are_those_of_the_tables() {
        for (elevation, turbidity, albedo, expected) in [
            (45.0, 3.0, 0.0, DVec3::new(2.160_820, 3.677_414, 7.475_573)),
            (10.0, 2.0, 0.3, DVec3::new(0.845_777, 1.760_816, 3.151_126)),
            (90.0, 6.0, 0.3, DVec3::new(37.035_145, 46.285_065, 37.409_65)),
        ] {
            let found = sky(&day(elevation, turbidity), Vec3::splat(albedo))(DVec3::Y);
            assert!((found - expected).abs().max_element() < 1e-3 * expected.max_element(), "{found}, not {expected}");
        }
    }

    #[test]
    fn skies_are_finite_positive_and_brightest_about_the_sun() {
        for elevation in [0.0, 2.0, 20.0, 45.0, 89.9, 90.0] {
            for turbidity in [1.7, 3.0, 6.5, 10.0] {
                for albedo in [Vec3::ZERO, Vec3::new(0.2, 0.5, 1.0)] {
                    let day = day(elevation, turbidity);
                    let radiance = sky(&day, albedo);
                    let towards = |elevation: f64, azimuth: f64| {
                        let ((y, cos), (x, z)) = (elevation.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
                        radiance(DVec3::new(cos * x, y, -cos * z))
                    };
                    for i in 0..18 {
                        for j in 0..36 {
                            let found = towards(0.5 + 5.0 * f64::from(i), 10.0 * f64::from(j));
                            assert!(found.is_finite() && found.min_element() >= 0.0, "{day:?}: {found}");
                            assert!(luminance(found) > 0.0, "{day:?}: {found}");
                        }
                    }
                    let at_sun = luminance(towards(f64::from(elevation).clamp(1.0, 89.0), 90.0));
                    let across = luminance(towards(f64::from(elevation).clamp(1.0, 60.0), 270.0));
                    assert!(at_sun > 1.1 * across, "{day:?}: {at_sun} and {across}");
                    assert_eq!(radiance(DVec3::NEG_Y), DVec3::ZERO);
                }
            }
        }
    }

    /// Klux on a horizontal plane of the sky alone: both models within what clear skies differ by, and more above snow.
    #[test]
    fn skies_have_about_the_light_of_preethams() {
        for (elevation, turbidity) in [(20.0, 2.5), (45.0, 3.0), (70.0, 3.0)] {
            let [hosek, snow, preetham] =
                [(DaylightModel::Hosek, 0.2), (DaylightModel::Hosek, 0.9), (DaylightModel::Preetham, 0.0)].map(
                    |(model, albedo)| {
                        let (picture, _) = day(elevation, turbidity).light(1.0, model, Vec3::splat(albedo));
                        horizontal(&picture)
                    },
                );
            assert!((8.0..25.0).contains(&hosek), "{elevation}: {hosek} klx");
            assert!((0.5..2.0).contains(&(hosek / preetham)), "{elevation}: {hosek}, and {preetham} by Preetham");
            assert!(snow > 1.1 * hosek, "{elevation}: {snow} above snow, and {hosek}");
        }
    }
}
