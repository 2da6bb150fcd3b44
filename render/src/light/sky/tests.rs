use std::f64::consts::PI as PI64;

use glam::{DVec3, IVec2};
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::sampling::warp::UniformSphere;

use super::*;
use crate::light::luminance_weight;

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
    let (mut sum, picture) = (DVec3::ZERO, sky.picture.as_ref().unwrap().picture());
    if let Some((sun, _)) = sky.part(SkyPart::Sun) {
        sun.each(picture, |row, _, texel| sum += sun.split(texel).1.as_dvec3() * picture.solid_angle(row));
    }
    (sum / (4.0 * PI64)).as_vec3()
}

/// The middle of a texel.
fn middle(picture: &SkyPicture, column: usize, row: usize) -> Vec3 {
    SkyTexels::new(picture.clone()).direction_to(Vec2::new(column as f32 + 0.5, row as f32 + 0.5))
}

/// The texel that a direction is in, by its column and row.
fn texel(picture: &SkyPicture, direction: Vec3) -> (usize, usize) {
    let place = SkyTexels::new(picture.clone()).place(direction);
    (place.x as usize % picture.width as usize, (place.y as usize).min(picture.height as usize - 1))
}

/// Directions that are spread evenly over a texel, each with the solid angle around it.
fn within(picture: &SkyPicture, column: usize, row: usize) -> impl Iterator<Item = (Vec3, f64)> {
    const SIDE: usize = 8;
    // Of a tent, this part is in the texel's own row.
    let solid_angle = picture.row_solid_angles(row as u32)[1] / 0.75 / (SIDE * SIDE) as f64;
    let texels = SkyTexels::new(picture.clone());
    let at = |base: usize, i: usize| base as f32 + (i as f32 + 0.5) / SIDE as f32;
    (0..SIDE * SIDE)
        .map(move |i| (texels.direction_to(Vec2::new(at(column, i % SIDE), at(row, i / SIDE))), solid_angle))
}

#[test]
fn places_and_directions_belong_together() {
    for (width, height) in [(12, 6), (2048, 1024), (3, 1), (1, 2)] {
        let white = SkyPicture::new(width, height, vec![Vec3::ONE; (width * height) as usize]);
        let texels = SkyTexels::new(SkyPicture { rotation: 2.0, ..white });
        for i in 0..1000 {
            let u = Stream::new(3, i, 0).uniform2(0);
            let there = Vec2::new(u.x * width as f32, u.y * height as f32);
            let direction = texels.direction_to(there);
            assert!(direction.is_normalized());
            let step = (texels.place(direction) - there).abs();
            let around = step.x.min(width as f32 - step.x);
            // As floats have so many digits; near the poles a column is narrow.
            let sine = Vec2::new(direction.x, direction.z).length();
            assert!(around * sine < 1e-6 * width as f32 + 1e-5, "{there}: {step}");
            assert!(step.y < 2e-6 * height as f32 + 2e-3, "{there}: {step}");
        }
    }
}

#[test]
fn pictures_are_interpolated_around_and_over_the_poles() {
    let texels = SkyTexels::new(SkyPicture { rotation: 0.0, ..picture() });
    let at = |x: f32, y: f32| texels.around(texels.direction_to(Vec2::new(x, y))).mean(|texel| texel);
    let texel = |column: usize, row: usize| texels.picture().texels[row * 12 + column];
    let near = |found: Vec3, expected: Vec3| {
        assert!(
            (found - expected).abs().max_element() < 1e-3 * (1.0 + expected.max_element()),
            "{found}, not {expected}"
        );
    };
    near(at(5.5, 2.5), texel(5, 2));
    near(at(6.0, 2.5), 0.5 * (texel(5, 2) + texel(6, 2)));
    near(at(5.75, 3.0), 0.5 * (0.75 * (texel(5, 2) + texel(5, 3)) + 0.25 * (texel(6, 2) + texel(6, 3))));
    near(at(0.0, 4.5), 0.5 * (texel(11, 4) + texel(0, 4)));
    near(at(11.75, 4.5), 0.75 * texel(11, 4) + 0.25 * texel(0, 4));
    // Above the middle of the first row, and below that of the last.
    near(at(3.5, 0.2), texel(3, 0));
    near(at(3.5, 5.9), texel(3, 5));
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
    let luminance = luminance_weight(found.as_vec3()) / luminance_weight(expected.as_vec3());
    assert!((luminance - 1.0).abs() < 1e-4, "{luminance}");
}

#[test]
fn directions_are_as_dense_as_the_density_says() {
    let mut texels: Vec<_> = picture().texels.iter().map(|texel| texel.min(Vec3::splat(0.5))).collect();
    texels[..12].fill(Vec3::splat(0.01));
    texels[12..48].fill(Vec3::ZERO);
    let picture = SkyPicture { texels, ..picture() };
    let sky = sky(picture.clone());
    // A texel is dark if all around it is.
    for (part, expected_dark) in [(SkyPart::All, 12), (SkyPart::Bright, 36)] {
        let count = 200_000;
        let mut counts = [0_u32; 72];
        for sample in samples(&sky, part, count) {
            let (column, row) = texel(&picture, sample.direction);
            counts[row * 12 + column] += 1;
        }
        let (mut total, mut dark) = (0.0, 0);
        for (number, found) in counts.into_iter().enumerate() {
            let (column, row) = (number % 12, number / 12);
            assert_eq!(texel(&picture, middle(&picture, column, row)), (column, row));
            let density = |direction| f64::from(sky.seen(&receiver(Vec3::Y), part, &sky.view(direction)).density);
            let share: f64 = within(&picture, column, row).map(|(direction, angle)| density(direction) * angle).sum();
            total += share;
            dark += usize::from(share == 0.0);
            let (expected, deviation) = (share * f64::from(count), (share * f64::from(count)).sqrt());
            // Means of a few places stand for the texel.
            let most = 5.0 * deviation + 0.01 * expected + 2.0;
            assert!((f64::from(found) - expected).abs() <= most, "{number}: {found}, not {expected}");
        }
        assert!((total - 1.0).abs() < 1e-3, "the density integrates to {total}");
        assert_eq!(dark, expected_dark, "texels are not sampled");
    }
}

#[test]
fn weights_are_irradiances_and_vanish_only_below_the_horizon() {
    // With twice as many texels, as an estimate of few is a coarse one.
    let coarse = picture();
    let texels = (0..288).map(|i| coarse.texels[i / 24 / 2 * 12 + i % 24 / 2]).collect();
    let picture = SkyPicture { width: 24, height: 12, texels, ..coarse };
    let sky = sky(picture.clone());
    for i in 0..100 {
        let normal = halfdome_kernel::sampling::warp::UniformSphere;
        let normal = halfdome_kernel::sampling::warp::Warp::map(&normal, Stream::new(1, i, 0).uniform2(0));
        let receiver = receiver(normal);
        for part in [SkyPart::All, SkyPart::Bright, SkyPart::Sun] {
            let (mut expected, mut power) = (0.0, 0.0);
            for (number, color) in picture.texels.iter().enumerate() {
                let (column, row) = (number % 24, number / 24);
                // Texels are large: their means, by many places in each.
                for (direction, angle) in within(&picture, column, row) {
                    let flux = angle * f64::from(sky.seen(&receiver, part, &sky.view(direction)).density);
                    expected += flux * f64::from(receiver.normal.dot(direction).max(0.0));
                    power += flux;
                }
                assert!(color.min_element() >= 0.0);
            }
            assert!((power - 1.0).abs() < 2e-3, "{power}");
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
    assert_eq!((sky.radiance(&sky.view(Vec3::Y)), sky.mean()), (Vec3::ZERO, Vec3::ZERO));
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
            let dim = sky.ambient(&sky.view(middle(&whole, column, row)));
            let is_sun = column == 20 || column == 5;
            assert!(dim.max_element() < 40.0 && ((dim - 1.0).abs().max_element() < 1e-3 || is_sun), "{dim}");
            sum += dim.as_dvec3() * whole.solid_angle(row as u32);
            weight += whole.solid_angle(row as u32);
        }
    }
    assert!((weight / (4.0 * PI64) - 1.0).abs() < 1e-12);
    let mean = (sum / weight).as_vec3() + mean_sun(&sky);
    assert!((mean / sky.mean() - 1.0).abs().max_element() < 1e-4, "{mean}, not {}", sky.mean());
}

#[test]
fn samples_of_the_sun_have_its_mean_and_lead_to_suns() {
    let sky = sky(suns([Vec3::splat(2000.0), Vec3::splat(1000.0)]));
    for sample in samples(&sky, SkyPart::Sun, 1000) {
        assert!(sample.direction.is_normalized() && sky.radiance(&sky.view(sample.direction)).x > 1.0);
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
    assert_eq!(constant.ambient(&constant.view(Vec3::Y)), Vec3::ONE);
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

/// A grey sky of 512 x 256 texels with discs of this radiance and radius in radians about directions.
fn discs(discs: &[(Vec3, Vec3, f32)]) -> SkyPicture {
    let picture = SkyPicture { rotation: 2.0, ..SkyPicture::new(512, 256, vec![Vec3::ONE; 512 * 256]) };
    let texels = SkyTexels::new(picture.clone());
    let texel = |i: u32| {
        let direction = texels.middle(i % 512, i / 512);
        let disc = discs.iter().find(|(_, to_middle, radius)| direction.angle_between(*to_middle) < *radius);
        disc.map_or(Vec3::ONE, |(radiance, ..)| *radiance)
    };
    SkyPicture { texels: (0..512 * 256).map(texel).collect(), ..picture }
}

const SUNLIGHT: Vec3 = Vec3::new(9000.0, 8000.0, 5000.0);

#[test]
fn a_narrow_sun_is_a_light_of_its_own() {
    let to_sun = Vec3::new(0.3, 0.8, -0.4).normalize();
    // The glare around is no part of it.
    let sky = sky(discs(&[(SUNLIGHT, to_sun, 0.02), (Vec3::splat(12.0), to_sun, 0.2)]));
    let Some(&PunctualLight::Directional { direction, irradiance, half_angle }) = sky.sun() else { panic!("no sun") };
    assert!(direction.angle_between(-to_sun) < 1e-3 && (0.02..0.05).contains(&half_angle), "{direction}, {half_angle}");
    let expected = SUNLIGHT * PI * 0.02 * 0.02;
    assert!((irradiance / expected - 1.0).abs().max_element() < 0.05, "{irradiance}, not {expected}");
    let (mut sum, count) = (DVec3::ZERO, 20_000);
    for i in 0..count {
        let Some(point) = sky.point_of_sun(Stream::new(7, 0, i).uniform2(0)) else { continue };
        let PunctualLight::Directional { direction, irradiance, half_angle } = point else { panic!("{point:?}") };
        assert!(half_angle == 0.0 && direction.angle_between(-to_sun) < 0.05, "{direction}");
        sum += irradiance.as_dvec3();
    }
    // All of it, with the faintest borders of the tents.
    let found = (sum / f64::from(count)).as_vec3();
    assert!((found / irradiance - 1.0).abs().max_element() < 0.05, "{found}, not {irradiance}");
}

#[test]
fn the_sun_and_what_is_beside_it_are_the_sky() {
    let to_sun = Vec3::new(0.3, 0.8, -0.4).normalize();
    let sky = sky(discs(&[(SUNLIGHT, to_sun, 0.02), (Vec3::splat(500.0), -to_sun, 0.02)]));
    let (axis, across) = (to_sun.any_orthonormal_vector(), 0.001);
    for i in 0..100 {
        let direction = (to_sun + axis * (across * i as f32)).normalize();
        let seen = sky.seen(&receiver(Vec3::Y), SkyPart::Bright, &sky.view(direction));
        assert_eq!(seen.radiance, sky.radiance(&sky.view(direction)));
        let (sum, whole) = (sky.beside_sun(&sky.view(direction)) + seen.of_sun, seen.radiance);
        assert!((sum / whole - 1.0).abs().max_element() < 1e-5, "{i}: {sum}, not {whole}");
        assert!(i > 10 || seen.of_sun.x > 8000.0, "{i}: {}", seen.of_sun);
        assert!(i < 60 || seen.of_sun == Vec3::ZERO, "{i}: {}", seen.of_sun);
    }
    // As bright as a sun, but not in the same place.
    assert_eq!(sky.beside_sun(&sky.view(-to_sun)), sky.radiance(&sky.view(-to_sun)));
}

#[test]
fn what_is_wide_or_in_several_places_is_no_sun() {
    let [a, b, c] = [Vec3::Y, Vec3::new(0.6, 0.2, 0.1).normalize(), Vec3::Z];
    for picture in [
        discs(&[a, b, c].map(|to_middle| (SUNLIGHT, to_middle, 0.02))),
        discs(&[(SUNLIGHT, b, 0.3)]),
        discs(&[(Vec3::splat(7.0), b, 0.02)]),
        suns([SUNLIGHT, Vec3::ONE]),
    ] {
        let sky = sky(picture);
        assert!(sky.sun().is_none() && sky.point_of_sun(Vec2::splat(0.5)).is_none());
        assert_eq!(sky.beside_sun(&sky.view(b)), sky.radiance(&sky.view(b)));
    }
}

#[test]
fn views_of_many_directions_are_those_of_each() {
    for sky in [sky(picture()), sky(discs(&[(SUNLIGHT, Vec3::Z, 0.02)])), SkyLight::new(Sky::constant(Vec3::ONE))] {
        let directions: [Vec3; 7] = std::array::from_fn(|i| UniformSphere.map(Stream::new(9, i as u32, 0).uniform2(0)));
        let views = sky.views(&directions);
        for (view, direction) in views.iter().zip(directions) {
            let of_one = sky.view(direction);
            assert_eq!((view.direction, sky.radiance(view)), (direction, sky.radiance(&of_one)));
            let densities = [view, &of_one].map(|view| sky.seen(&receiver(Vec3::Y), SkyPart::All, view).density);
            assert_eq!(densities[0], densities[1], "{direction}");
        }
        assert!(sky.radiance(&views[0]) != Vec3::ZERO || sky.radiance(&views[1]) != Vec3::ZERO);
    }
}

#[test]
fn middles_of_texels_are_directions_to_their_places() {
    let texels = SkyTexels::new(SkyPicture { rotation: 0.7, ..picture() });
    let (middles, [width, height]) = (texels.middles(), [texels.picture().width, texels.picture().height]);
    for (column, row) in (0..height).flat_map(|row| (0..width).map(move |column| (column, row))) {
        let at = |x: i32, y: i32| {
            let place = IVec2::new(column as i32 + x, row as i32 + y).as_vec2() + 0.5;
            texels.direction_to(place)
        };
        assert_eq!(middles.of(column, row), at(0, 0));
        let around: Vec<Vec3> = middles.around(column, row).collect();
        let expected: Vec<Vec3> = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))).map(|(x, y)| at(x, y)).collect();
        assert_eq!(around, expected, "{column} {row}");
    }
}

/// Most texels are left out when the radius of a patch is found, as none of theirs can be farther.
#[test]
fn patches_reach_as_far_as_if_all_texels_were_looked_at() {
    let to_sun = Vec3::new(0.3, 0.8, -0.4).normalize();
    let noise = |i: u32| Vec3::splat(Stream::new(11, i, 0).uniform2(0).x.powi(8));
    let noisy = SkyPicture::new(90, 45, (0..90 * 45).map(noise).collect());
    let mut too_near = 0;
    for picture in [picture(), discs(&[(SUNLIGHT, to_sun, 0.02), (SUNLIGHT, Vec3::Y, 0.3)]), noisy] {
        let sky = sky(picture);
        let texels = sky.picture.as_ref().unwrap();
        for (peaks, patches) in sky.parts.iter().flatten() {
            let all = peaks.patches_by(texels, f32::INFINITY);
            assert_eq!(format!("{patches:?}"), format!("{all:?}"));
            too_near += usize::from(format!("{:?}", peaks.patches_by(texels, 0.0)) != format!("{all:?}"));
        }
    }
    assert!(too_near > 0, "tents do not matter");
}
