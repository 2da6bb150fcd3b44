use glam::{Quat, Vec2};
use halfdome_kernel::sampling::warp::{UniformSphere, Warp};
use halfdome_kernel::sampling::{Stream, unit_double};

use super::*;
use crate::scene::{Sky, SkyPicture, SpotEdge};

const PARTS: [SkyPart; 3] = [SkyPart::All, SkyPart::Bright, SkyPart::Sun];

/// A vector in a cube of ±1.
fn place(seed: u64, i: u32) -> Vec3 {
    let [x, y, z, _] = Stream::new(seed, i, 0).uniform4(0);
    2.0 * Vec3::new(x, y, z) - 1.0
}

fn direction(seed: u64, i: u32) -> Vec3 {
    UniformSphere.map(Stream::new(seed, i, 1).uniform2(0))
}

/// Small triangles all over a cube of ±1, times `scale`, every third of which shines to both sides.
fn triangles(count: u32, scale: f32) -> (Vec<Triangle>, Vec<Material>) {
    let one = |i: u32| {
        let [a, b, c, power] = Stream::new(3, i, 2).uniform4(0);
        let turn = Quat::from_rotation_arc(Vec3::Z, direction(3, i));
        let corners = [Vec2::new(a, 0.1), Vec2::new(-0.2, b), Vec2::new(0.2 * c, -0.3)];
        let emission = Vec3::new(power * power, power, 0.3) * 10.0;
        let material = Material { emission, emits_both_sides: i.is_multiple_of(3), ..Material::default() };
        (corners.map(|corner| scale * (place(3, i) + 0.05 * (turn * corner.extend(0.0)))), material)
    };
    (0..count).map(one).unzip()
}

fn punctual(count: u32, scale: f32) -> Vec<PunctualLight> {
    let radius = |i: u32| 0.1 * scale * (i % 2) as f32;
    let one = |i: u32| {
        let (position, direction) = (scale * place(4, i), direction(4, i));
        let [red, green, blue, cone] = Stream::new(4, i, 2).uniform4(0);
        let color = Vec3::new(red, green, blue);
        match i % 3 {
            0 => PunctualLight::Point { position, intensity: color * 0.1 * scale * scale, radius: radius(i) },
            1 => {
                let (cos_inner, cos_outer, intensity) = (0.5 + 0.5 * cone, 0.4 * cone, color * scale * scale);
                let edge = [SpotEdge::Square, SpotEdge::Smooth][i as usize / 3 % 2];
                PunctualLight::Spot { position, direction, intensity, radius: radius(i), cos_inner, cos_outer, edge }
            }
            _ => PunctualLight::Directional { direction, irradiance: color, half_angle: 0.1 * (i % 2) as f32 },
        }
    };
    (0..count).map(one).collect()
}

fn picture() -> Sky {
    let texel = |i: usize| if i == 40 { Vec3::splat(90.0) } else { Vec3::new(0.2, 0.3, 0.01 * i as f32) };
    Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(16, 8, (0..128).map(texel).collect())) }
}

fn lights(
    (triangles, materials): (Vec<Triangle>, Vec<Material>),
    punctual: Vec<PunctualLight>,
    sky: Sky,
) -> LightSampler {
    let bounds = triangles.iter().fold(Aabb::EMPTY, |bounds, triangle| bounds.union(&Aabb::around(triangle)));
    let front = |prim: usize| Some(halfdome_kernel::triangle_normal(&triangles[prim]));
    LightSampler::new(&triangles, |prim| &materials[prim], front, |_| None, (punctual, SkyLight::new(sky)), bounds)
}

fn receiver(i: u32, scale: f32) -> Receiver {
    Receiver::new(1.5 * scale * place(9, i), direction(9, i), i.is_multiple_of(5))
}

/// A receiver close to one of many lamps: clusters about it, whose estimates do not tell that, are opened.
#[test]
fn close_choices_know_which_lamp_is_near() {
    let lamp = |i: u32| PunctualLight::Point {
        position: Vec3::new((i % 20) as f32, (i / 20) as f32, 0.0),
        intensity: Vec3::ONE,
        radius: 0.0,
    };
    let lamps: Vec<PunctualLight> = (0..400).map(lamp).collect();
    let lights = lights((Vec::new(), Vec::new()), lamps.clone(), Sky::default());
    for (near, distance) in [(0, 0.1), (7, 0.1), (210, 0.1), (389, 1.0), (210, 1.5)] {
        let place = |light: &PunctualLight| light.place().map(|(position, ..)| position).unwrap();
        let receiver = Receiver::new(place(&lamps[near]) - distance * Vec3::Z, Vec3::Z, false);
        let irradiance = |light: &PunctualLight| {
            let way = place(light) - receiver.position;
            way.z / way.length_squared().powf(1.5)
        };
        let expected: f32 = lamps.iter().map(irradiance).sum();
        let estimate = lights.lamp_irradiance(&receiver);
        assert!((estimate / expected - 1.0).abs() < 0.08, "{estimate}, not {expected}");
        let chosen = |i: u32| {
            let numbers = Stream::new(8, i, 0).uniform2(0).to_array();
            let (total, index) = lights.choose_closely(&receiver, SkyPart::All, numbers).unwrap();
            assert_eq!(total, estimate);
            place(match &lights.lights()[index as usize] {
                Light::Punctual(light) => light,
                light => panic!("{light:?}"),
            })
        };
        let hits = (0..2000).filter(|&i| chosen(i) == place(&lamps[near])).count();
        let share = irradiance(&lamps[near]) / expected;
        assert!((hits as f32 / 2000.0 - share).abs() < 0.03, "{hits} of 2000, not {share}");
    }
}

/// Of few lights all are weighed, so that close choices are those of light samples: of each kind of light.
#[test]
fn close_choices_among_few_lights_have_the_probabilities_of_light_samples() {
    let (corners, mut materials) = triangles(6, 1.0);
    materials.iter_mut().for_each(|material| material.emission *= 1e3);
    let lights = lights((corners, materials), punctual(9, 1.0), picture());
    let mut kinds = [0; 4];
    for i in 0..20 {
        let receiver = receiver(i, 1.0);
        let expected = probabilities(&lights, &receiver, SkyPart::All);
        let mut hits = vec![0; expected.len()];
        for number in 0..4000 {
            let numbers = Stream::new(12, number, i).uniform2(0).to_array();
            let (total, index) = lights.choose_closely(&receiver, SkyPart::All, numbers).unwrap();
            assert!((total / lights.weigh(&receiver, SkyPart::All).total() - 1.0).abs() < 1e-5);
            hits[index as usize] += 1;
        }
        for (index, (hits, expected)) in hits.into_iter().zip(expected).enumerate() {
            assert!((f64::from(hits) / 4000.0 - expected).abs() < 0.03, "{i}, {index}: {hits}, not {expected}");
            let kind = match lights.lights()[index] {
                Light::Triangle(_) => 0,
                Light::Punctual(PunctualLight::Directional { .. }) => 2,
                Light::Punctual(_) => 1,
                Light::Sky => 3,
            };
            kinds[kind] += hits;
        }
    }
    assert!(kinds.iter().all(|&hits| hits > 400), "{kinds:?}");
}

/// The probability of every source. That of triangles is what a bounce that hits one asks for.
fn probabilities(lights: &LightSampler, receiver: &Receiver, part: SkyPart) -> Vec<f64> {
    let weights = lights.weigh(receiver, part);
    let total = f64::from(weights.total());
    let (mut points, mut directional) = (0, 0);
    let share = |source: &Light| {
        f64::from(match source {
            Light::Triangle(part_of) => {
                let light = lights.emitter_at(part_of.prim_id, part_of.middle()).unwrap();
                return lights.probability(light, receiver, part).into();
            }
            Light::Sky => return weights.sky_probability().into(),
            Light::Punctual(PunctualLight::Directional { .. }) => {
                directional += 1;
                let row = lights.directional.rows(receiver).nth((directional - 1) / tree::WIDTH).unwrap();
                row[(directional - 1) % tree::WIDTH]
            }
            Light::Punctual(_) => {
                points += 1;
                lights.points.as_ref().unwrap().weight(points - 1, receiver)
            }
        }) / total
    };
    lights.lights().iter().map(share).collect()
}

fn scenes() -> Vec<LightSampler> {
    let none = || (Vec::new(), Vec::new());
    vec![
        lights(triangles(2, 1.0), Vec::new(), Sky::default()),
        lights(triangles(20, 1.0), punctual(5, 1.0), picture()),
        lights(triangles(700, 1.0), punctual(70, 1.0), Sky::constant(Vec3::ONE)),
        lights(none(), punctual(300, 1.0), Sky::default()),
        lights(none(), Vec::new(), picture()),
    ]
}

#[test]
fn probabilities_add_up_to_1() {
    for (number, lights) in scenes().iter().enumerate() {
        for part in PARTS {
            let mut lit = 0;
            for i in 0..100 {
                let receiver = receiver(i, 1.0);
                let probabilities = probabilities(lights, &receiver, part);
                assert!(probabilities.iter().all(|probability| *probability >= 0.0));
                let sum: f64 = probabilities.iter().sum();
                if lights.weigh(&receiver, part).total() > 0.0 {
                    assert!((sum - 1.0).abs() < 1e-5, "scene {number}, {part:?}, receiver {i}: {sum}");
                    lit += 1;
                } else {
                    assert!(lights.choose(&receiver, &lights.weigh(&receiver, part), 0.5).is_none());
                }
            }
            assert!(lit > 20 || (number == 0 && lit > 0), "scene {number}, {part:?}: {lit} receivers");
        }
    }
}

/// Pearson's test with classes of five samples and more, at a significance of 1% for all tests together (Šidák).
#[test]
fn lights_are_chosen_as_often_as_their_densities_say() {
    const SAMPLES: u32 = 40_000;
    let mut tests = 0;
    for (number, lights) in scenes().iter().enumerate() {
        for i in 0..8 {
            let (receiver, part) = (receiver(i, 1.0), PARTS[i as usize % 3]);
            let weights = lights.weigh(&receiver, part);
            let expected = probabilities(lights, &receiver, part);
            if weights.total() == 0.0 {
                continue;
            }
            let mut counts = vec![0.0; expected.len()];
            for sample in 0..SAMPLES {
                let choice =
                    lights.choose(&receiver, &weights, unit_double(Stream::new(6, i, sample).uniform2(0))).unwrap();
                assert!((0.0..1.0).contains(&choice.rest));
                let density = f64::from(choice.probability);
                let known = expected[choice.index as usize];
                assert!((density / known - 1.0).abs() < 1e-5, "{density}, not {known}");
                counts[choice.index as usize] += 1.0;
            }
            let (mut statistic, mut classes, mut rare) = (0.0, 0.0, (0.0, 0.0));
            for (count, probability) in counts.into_iter().zip(expected) {
                let expected = probability * f64::from(SAMPLES);
                if expected < 5.0 {
                    rare = (rare.0 + count, rare.1 + expected);
                } else {
                    statistic += (count - expected) * (count - expected) / expected;
                    classes += 1.0;
                }
            }
            if rare.1 >= 5.0 {
                statistic += (rare.0 - rare.1) * (rare.0 - rare.1) / rare.1;
                classes += 1.0;
            }
            tests += 1;
            if classes < 2.0 {
                continue;
            }
            // Wilson and Hilferty's transform to a normal distribution; 1% in 40 tests is 3.5 deviations.
            let freedom: f64 = classes - 1.0;
            let spread = 2.0 / (9.0 * freedom);
            let z = ((statistic / freedom).cbrt() - (1.0 - spread)) / spread.sqrt();
            assert!(z < 3.5, "scene {number}, receiver {i}, {part:?}: {z} deviations, χ² = {statistic} of {freedom}");
        }
    }
    assert!(tests > 25, "{tests}");
}

#[test]
fn choices_do_not_depend_on_the_scale() {
    let of = |scale: f32| lights(triangles(300, scale), punctual(40, scale), picture());
    let reference = of(1.0);
    for scale in [1000.0, 0.001] {
        let scaled = of(scale);
        for i in 0..100 {
            let (small, large) = (receiver(i, 1.0), receiver(i, scale));
            let before = probabilities(&reference, &small, SkyPart::All);
            let after = probabilities(&scaled, &large, SkyPart::All);
            for (before, after) in before.into_iter().zip(after) {
                assert!((before - after).abs() < 1e-5, "receiver {i}, times {scale}: {after}, not {before}");
            }
        }
    }
}

/// The irradiance at a receiver by one triangle without shadows, by many points of it.
fn irradiance(receiver: &Receiver, &[a, b, c]: &Triangle, both_sides: bool) -> f64 {
    const STEPS: u32 = 24;
    let normal = halfdome_kernel::triangle_normal(&[a, b, c]);
    let mut sum = 0.0;
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let u = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / STEPS as f32;
        let point = halfdome_kernel::sampling::warp::Triangle.map(u);
        let way = a + (b - a) * point.x + (c - a) * point.y - receiver.position;
        let before = -normal.dot(way);
        let before = if both_sides { before.abs() } else { before.max(0.0) };
        sum += f64::from(receiver.height(way) * before / way.length_squared().powi(2));
    }
    sum / f64::from(STEPS * STEPS) * f64::from(area(&[a, b, c]))
}

#[test]
fn what_can_send_light_is_never_without_a_chance() {
    let (triangles, materials) = triangles(400, 1.0);
    let lights = lights((triangles.clone(), materials.clone()), Vec::new(), Sky::default());
    let mut seen = 0;
    for i in 0..60 {
        // In between them, for half of all.
        let receiver = if i % 2 == 0 { receiver(i, 1.0) } else { receiver(i, 0.3) };
        let weights = lights.weigh(&receiver, SkyPart::Bright);
        let all: f64 = (0..400)
            .map(|prim| {
                let material = &materials[prim];
                let brightness = f64::from(luminance_weight(material.emission));
                brightness * irradiance(&receiver, &triangles[prim], material.emits_both_sides)
            })
            .sum();
        if all == 0.0 {
            continue;
        }
        for prim in 0..400 {
            let material = &materials[prim];
            let sent = irradiance(&receiver, &triangles[prim], material.emits_both_sides);
            let share = sent * f64::from(luminance_weight(material.emission)) / all;
            let probability = f64::from(lights.probability(prim as u32, &receiver, SkyPart::Bright));
            if share > 1e-7 {
                assert!(probability > 0.02 * share, "receiver {i}, triangle {prim}: {probability} for {share}");
                seen += 1;
            }
        }
        let estimate = f64::from(weights.total()) / all;
        assert!((0.1..10.0).contains(&estimate), "receiver {i}: estimated {estimate} of the irradiance");
    }
    assert!(seen > 3000, "{seen}");
}

/// A light has a weight wherever it sends something.
fn check_weights(punctual: &[PunctualLight], sent: impl Fn(&PunctualLight, &Receiver) -> f32) {
    let lights = lights((Vec::new(), Vec::new()), punctual.to_vec(), Sky::default());
    let tree = lights.points.as_ref().unwrap();
    let mut lit = 0;
    for i in 0..100 {
        let receiver = receiver(i, 1.0);
        for (number, light) in (0..).zip(punctual) {
            let (sent, weight) = (sent(light, &receiver), tree.weight(number, &receiver));
            assert!(weight > 0.0 || sent == 0.0, "receiver {i}, {light:?}: {weight} for {sent}");
            lit += u32::from(sent > 0.0);
        }
    }
    assert!(lit > 300, "{lit}");
}

/// Where spots shine they have a weight, whatever their edge.
#[test]
fn points_and_spots_are_never_without_a_chance() {
    let punctual: Vec<PunctualLight> = punctual(90, 1.0).into_iter().filter(is_delta).collect();
    check_weights(&punctual, |light, receiver| {
        let (position, intensity, part) = match *light {
            PunctualLight::Point { position, intensity, .. } => (position, intensity, 1.0),
            PunctualLight::Spot { position, direction, intensity, cos_inner, cos_outer, edge, .. } => {
                let cosine = direction.dot((receiver.position - position).normalize());
                let ramp = ((cosine - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0);
                let square = ramp * ramp;
                (position, intensity, if edge == SpotEdge::Square { square } else { square * (3.0 - 2.0 * ramp) })
            }
            PunctualLight::Profiled { .. } | PunctualLight::Directional { .. } => unreachable!("there is none"),
        };
        let way = position - receiver.position;
        luminance_weight(intensity) * part * receiver.height(way) / way.length().powi(3)
    });
}

/// Likewise lights with a profile, wherever they shine.
#[test]
fn profiles_are_never_without_a_chance() {
    let path = std::path::Path::new("lamp.ies");
    let text = "IESNA91\nTILT=NONE\n1 1 1 4 2 1 2 0 0 0\n1 1 1\n0 30 60 90\n0 180\n0 9 2 0\n1 4 0 0\n";
    let profile = std::sync::Arc::new(crate::scene::formats::ies::parse(path, text.as_bytes()).unwrap());
    let punctual: Vec<PunctualLight> = (0..60)
        .map(|i| {
            let (position, frame) = (place(4, i), crate::scene::ProfileFrame::new(direction(4, i), i as f32));
            PunctualLight::Profiled { position, frame, intensity: Vec3::ONE, radius: 0.0, profile: profile.clone() }
        })
        .collect();
    check_weights(&punctual, |light, receiver| {
        let PunctualLight::Profiled { position, frame, .. } = light else { unreachable!("all have a profile") };
        let way = position - receiver.position;
        profile.candela(frame, -way.normalize()) * receiver.height(way)
    });
}

fn is_delta(light: &PunctualLight) -> bool {
    matches!(light, PunctualLight::Point { radius: 0.0, .. } | PunctualLight::Spot { radius: 0.0, .. })
}

#[test]
fn few_lights_are_chosen_by_what_they_send() {
    let (triangles, materials) = triangles(12, 1.0);
    let lights = lights((triangles.clone(), materials.clone()), punctual(12, 1.0), Sky::default());
    for i in 0..100 {
        // Outside, where the triangles are small.
        let receiver = Receiver::new(place(9, i).normalize() * 3.0, -place(9, i).normalize(), false);
        let sent: Vec<f64> = (0..12)
            .map(|prim| {
                let both = materials[prim].emits_both_sides;
                f64::from(luminance_weight(materials[prim].emission)) * irradiance(&receiver, &triangles[prim], both)
            })
            .collect();
        let probabilities = probabilities(&lights, &receiver, SkyPart::All);
        let among: f64 = probabilities[..12].iter().sum();
        for (probability, part) in probabilities.iter().zip(&sent) {
            let expected = part / sent.iter().sum::<f64>() * among;
            assert!((probability - expected).abs() < 0.01 * among, "receiver {i}: {probability}, not {expected}");
        }
    }
}

/// On walls that meet a light, or are nearly in its plane, most of the light comes from what is nearest.
#[test]
fn large_lights_have_their_share_however_near_they_are() {
    let wall = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 0.0, 1.0)];
    let ceiling = [Vec3::new(0.0, -1.0, 2.0), Vec3::new(0.0, 0.0, 2.0), Vec3::new(1.0, 0.0, 2.0)];
    let material = Material { emission: Vec3::ONE, emits_both_sides: true, ..Material::default() };
    let lights = lights((vec![wall, ceiling], vec![material.clone(), material]), Vec::new(), Sky::default());
    for power in 1..16 {
        let distance = 0.5f32.powi(power);
        let receiver = Receiver::new(Vec3::new(0.3, -distance, 1e-4), Vec3::Z, false);
        let near = f64::from(lights.probability(0, &receiver, SkyPart::Bright));
        assert!(near > 0.3, "{distance} from the wall: {near}");
    }
}
