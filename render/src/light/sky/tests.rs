use std::f64::consts::PI as PI64;

use glam::DVec3;
use halfdome_kernel::sampling::Stream;

use super::*;
use crate::light::luminance;

/// A sky of 12 x 6 texels with a sun, a black row and much that is dim.
fn picture() -> SkyPicture {
    let texel = |i: usize| match i {
        29 => Vec3::new(1000.0, 900.0, 500.0),
        12..24 => Vec3::ZERO,
        _ => Vec3::new(0.1, 0.2, 0.01 * i as f32),
    };
    SkyPicture { width: 12, height: 6, texels: (0..72).map(texel).collect(), rotation: 1.0 }
}

fn sky(picture: SkyPicture) -> SkyLight {
    SkyLight::new(Sky { radiance: Vec3::ZERO, picture: Some(picture) })
}

fn receiver(normal: Vec3) -> Receiver {
    Receiver::new(Vec3::ZERO, normal, false)
}

fn samples(sky: &SkyLight, part: SkyPart, count: u32) -> impl Iterator<Item = SkySample> {
    (0..count).map(move |i| sky.sample(&receiver(Vec3::Y), part, Stream::new(7, 0, i).uniform2(0)))
}

/// The part of the mean that is the sun's.
fn mean_sun(sky: &SkyLight) -> Vec3 {
    let (mut sum, picture) = (DVec3::ZERO, sky.picture.as_ref().unwrap());
    if let Some((sun, _)) = sky.part(SkyPart::Sun) {
        sun.each(picture, |row, _, texel| sum += sun.split(texel).1.as_dvec3() * picture.solid_angle(row));
    }
    (sum / (4.0 * PI64)).as_vec3()
}

/// The middle of a texel.
fn middle(picture: &SkyPicture, column: usize, row: usize) -> Vec3 {
    direction_in(picture, (column, row), (0.5, 0.5))
}

#[test]
fn the_mean_of_samples_is_the_pictures_integral() {
    let sky = sky(picture());
    let (mut sum, count) = (DVec3::ZERO, 100_000);
    for sample in samples(&sky, SkyPart::All, count) {
        assert!(sample.direction.is_normalized());
        // A rounding error may lead to a neighbour, which is black or counts with its own density.
        if sample.density > 0.0 {
            sum += (sample.radiance / sample.density).as_dvec3();
        }
    }
    let (found, expected) = (sum / f64::from(count), picture().mean().as_dvec3() * 4.0 * PI64);
    assert!(((found - expected) / expected).abs().max_element() < 0.01, "{found}, not {expected}");
    // Directions follow luminance, whose estimate is the same for all of them.
    let luminance = luminance(found.as_vec3()) / luminance(expected.as_vec3());
    assert!((luminance - 1.0).abs() < 1e-4, "{luminance}");
}

#[test]
fn directions_are_as_dense_as_the_density_says() {
    let mut texels: Vec<_> = picture().texels.iter().map(|texel| texel.min(Vec3::splat(0.5))).collect();
    texels[60..].fill(Vec3::splat(0.01));
    let picture = SkyPicture { texels, ..picture() };
    let sky = sky(picture.clone());
    for (part, expected_dark) in [(SkyPart::All, 12), (SkyPart::Bright, 24)] {
        let count = 200_000;
        let mut counts = [0_u32; 72];
        for sample in samples(&sky, part, count) {
            counts[texel(&picture, sample.direction).2] += 1;
        }
        let (mut total, mut dark) = (0.0, 0);
        for (number, found) in counts.into_iter().enumerate() {
            let (column, row) = (number % 12, number / 12);
            let middle = middle(&picture, column, row);
            assert_eq!(texel(&picture, middle), (column, row, number));
            let density = sky.density(&receiver(Vec3::Y), part, middle);
            let share = f64::from(density) * picture.solid_angle(row as u32);
            total += share;
            dark += usize::from(share == 0.0);
            let (expected, deviation) = (share * f64::from(count), (share * f64::from(count)).sqrt());
            assert!((f64::from(found) - expected).abs() <= 5.0 * deviation + 2.0, "{number}: {found}, not {expected}");
        }
        assert!((total - 1.0).abs() < 1e-5, "the density integrates to {total}");
        assert_eq!(dark, expected_dark, "texels are not sampled");
    }
}

#[test]
fn weights_are_irradiances_and_vanish_only_below_the_horizon() {
    let picture = picture();
    let sky = sky(picture.clone());
    for i in 0..300 {
        let normal = halfdome_kernel::sampling::warp::UniformSphere;
        let normal = halfdome_kernel::sampling::warp::Warp::map(&normal, Stream::new(1, i, 0).uniform2(0));
        let receiver = receiver(normal);
        for part in [SkyPart::All, SkyPart::Bright, SkyPart::Sun] {
            let (mut expected, mut power) = (0.0, 0.0);
            for (number, color) in picture.texels.iter().enumerate() {
                let (column, row) = (number % 12, number / 12);
                // Texels are large: their means, by many places in each.
                for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
                    let place = ((x as f32 + 0.5) / 8.0, (y as f32 + 0.5) / 8.0);
                    let direction = direction_in(&picture, (column, row), place);
                    let density = sky.density(&receiver, part, middle(&picture, column, row));
                    let flux = picture.solid_angle(row as u32) / 64.0 * f64::from(density);
                    expected += flux * f64::from(receiver.normal.dot(direction).max(0.0));
                    power += flux;
                }
                assert!(color.min_element() >= 0.0);
            }
            assert!((power - 1.0).abs() < 1e-3, "{power}");
            let total = sky.part(part).unwrap().0.total();
            let found = f64::from(sky.weight(&receiver, part)) / total;
            assert!((found - expected).abs() < 0.1, "{part:?}, {normal}: {found}, not {expected}");
            assert!(found > 0.0 || expected == 0.0, "{part:?}, {normal}: {expected}");
        }
    }
}

#[test]
fn a_turned_picture_is_seen_elsewhere() {
    let seen =
        |degrees: f32, direction: Vec3| texel(&SkyPicture { rotation: 0.0, ..picture() }.turned(degrees), direction).0;
    // The middle is towards -z, and the right of it towards +x. A quarter counter-clockwise brings it to -x.
    let slightly = Vec3::new(0.1, 0.0, 0.0);
    assert_eq!(seen(0.0, (Vec3::NEG_Z + slightly).normalize()), 6);
    assert_eq!(seen(0.0, (Vec3::X + Vec3::Z * 0.1).normalize()), 9);
    assert_eq!(seen(90.0, (Vec3::NEG_X - Vec3::Z * 0.1).normalize()), 6);
}

#[test]
fn black_pictures_are_no_lights() {
    let sky = sky(SkyPicture { texels: vec![Vec3::ZERO; 72], ..picture() });
    assert_eq!((sky.radiance(Vec3::Y), sky.mean()), (Vec3::ZERO, Vec3::ZERO));
    for part in [SkyPart::All, SkyPart::Bright, SkyPart::Sun] {
        assert!(!sky.has(part) && sky.weight(&receiver(Vec3::Y), part) == 0.0);
    }
}

/// A sky of 32 x 16 texels, grey but for two suns.
fn suns(suns: [Vec3; 2]) -> SkyPicture {
    let mut texels = vec![Vec3::ONE; 32 * 16];
    [texels[3 * 32 + 20], texels[9 * 32 + 5]] = suns;
    SkyPicture { rotation: 1.0, ..SkyPicture::new(32, 16, texels) }
}

#[test]
fn a_sky_is_its_sun_and_the_rest() {
    let whole = suns([Vec3::new(4000.0, 3000.0, 2000.0), Vec3::splat(400.0)]);
    let sky = sky(whole.clone());
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for row in 0..16 {
        for column in 0..32 {
            let dim = sky.ambient(middle(&whole, column, row));
            assert!(dim.max_element() < 40.0 && (dim == Vec3::ONE || column == 20 || column == 5), "{dim}");
            sum += dim.as_dvec3() * whole.solid_angle(row as u32);
            weight += whole.solid_angle(row as u32);
        }
    }
    assert!((weight / (4.0 * PI64) - 1.0).abs() < 1e-12);
    let mean = (sum / weight).as_vec3() + mean_sun(&sky);
    assert!((mean / sky.mean() - 1.0).abs().max_element() < 1e-5, "{mean}, not {}", sky.mean());
}

#[test]
fn samples_of_the_sun_have_its_mean_and_lead_to_suns() {
    let sky = sky(suns([Vec3::splat(2000.0), Vec3::splat(1000.0)]));
    for sample in samples(&sky, SkyPart::Sun, 1000) {
        assert!(sample.direction.is_normalized() && sky.radiance(sample.direction).x >= 1000.0);
        let (estimate, expected) = (sample.radiance / sample.density, 4.0 * PI * mean_sun(&sky));
        assert!((estimate / expected - 1.0).abs().max_element() < 1e-4, "{estimate}, not {expected}");
    }
}

#[test]
fn an_overcast_sky_has_no_sun() {
    let overcast = sky(suns([Vec3::splat(7.0), Vec3::splat(3.0)]));
    assert!(overcast.has(SkyPart::All) && overcast.has(SkyPart::Bright) && !overcast.has(SkyPart::Sun));
    let even = sky(suns([Vec3::ONE; 2]));
    assert!(even.has(SkyPart::All) && !even.has(SkyPart::Sun));
    let constant = SkyLight::new(Sky::constant(Vec3::ONE));
    assert!(constant.has(SkyPart::All) && !constant.has(SkyPart::Bright) && !constant.has(SkyPart::Sun));
    assert_eq!(constant.ambient(Vec3::Y), Vec3::ONE);
}

#[test]
fn light_samples_of_a_constant_sky_follow_the_cosine_on_one_side_or_both() {
    let sky = SkyLight::new(Sky::constant(Vec3::ONE));
    for (behind, sides) in [(false, 1.0), (true, 2.0)] {
        let receiver = Receiver::new(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8), behind);
        assert!((sky.weight(&receiver, SkyPart::All) - sides * PI).abs() < 1e-5);
        for i in 0..1000 {
            let sample = sky.sample(&receiver, SkyPart::All, Stream::new(7, 0, i).uniform2(0));
            let cosine = receiver.normal.dot(sample.direction);
            assert!(cosine > -1e-6 || behind);
            assert!((sample.density - cosine.abs() * FRAC_1_PI / sides).abs() < 1e-6);
        }
    }
}
