//! Every warp against its own density: χ² over cells whose probabilities are integrals of the density, not of the map.

mod charts;

use glam::{Vec2, Vec3};

use super::*;
use crate::checksums::Checksum;
use crate::sampling::tests::statistics::{chi_squared, integrate};
use crate::sampling::{ONE_MINUS_EPSILON, Pattern, Sampler, Strata, Stream};
use crate::simd::isas;
use charts::{Barycentric, Cap, Chart, Disc, Patch, Square};

const COLUMNS: usize = 20;
const ROWS: usize = 16;
const SAMPLES: u32 = 64_000;

/// The probabilities of the chart's cells by the warp's density.
fn cell_probabilities<W: Warp<Point = C::Point>, C: Chart>(warp: &W, chart: C) -> Vec<f64> {
    let side = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
    let cells = (0..COLUMNS * ROWS).map(|i| {
        integrate(side(i / ROWS, COLUMNS), side(i % ROWS, ROWS), |s, t| {
            let (point, measure) = chart.at(s, t);
            f64::from(warp.pdf(point)) * measure
        })
    });
    cells.collect()
}

/// All that must hold of a warp over the domain of a chart; `golden` is the checksum of 10,000 of its points.
fn check<W: Warp<Point = C::Point>, C: Chart>(name: &str, warp: W, chart: C, golden: u64) {
    let probabilities = cell_probabilities(&warp, chart);
    let integral: f64 = probabilities.iter().sum();
    assert!((integral - 1.0).abs() < 1e-5, "{name}: its density integrates to {integral}");

    for seed in 1..4 {
        let mut counts = vec![0.0; COLUMNS * ROWS];
        for i in 0..SAMPLES {
            let point = warp.map(Stream::new(seed, i, 0).uniform2(0));
            assert!(warp.pdf(point) > 0.0, "{name}: {point:?} has no density");
            let [s, t] = chart.of(point);
            assert!((0.0..1.0 + 1e-6).contains(&s), "{name}: {point:?} is outside of the domain");
            let (column, row) = ((s * COLUMNS as f64) as usize, (t * ROWS as f64) as usize);
            counts[column.min(COLUMNS - 1) * ROWS + row.min(ROWS - 1)] += 1.0;
        }
        let expected: Vec<_> = probabilities.iter().map(|p| p / integral * f64::from(SAMPLES)).collect();
        let z = chi_squared(&counts, &expected);
        assert!(z.abs() < 4.0, "{name}, seed {seed}: chi squared is {z} standard deviations off");
    }

    let ends = [0.0, f32::MIN_POSITIVE, 2f32.powi(-24), 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, ONE_MINUS_EPSILON];
    let corners = ends.iter().flat_map(|&x| ends.iter().map(move |&y| Vec2::new(x, y)));
    let scattered = (0..20_000).map(|i| Sampler::new(Pattern::Sobol, 8, 0, i).uniform2(0));
    for u in corners.clone().chain(scattered) {
        let point = warp.map(u);
        assert!(C::coordinates(point).iter().all(|x| x.is_finite()), "{name}: {u} gives {point:?}");
        assert!(warp.pdf(point) > 0.0, "{name}: {u} gives {point:?}, which has no density");
        let back = warp.inverse(point);
        assert!((0.0..1.0).contains(&back.x) && (0.0..1.0).contains(&back.y), "{name}: {u} comes back as {back}");
        let again = C::distance(warp.map(back), point);
        assert!(again < 2e-6, "{name}: {u} and its return {back} are {again} apart");
        // At the border of u an angle may come back from the other side, and at a pole it is lost.
        let margin = 1e-5 * chart.magnification();
        if u.min_element() > margin && u.max_element() < 1.0 - margin {
            assert!((back - u).abs().max_element() < 0.2 * margin, "{name}: {u} comes back as {back}");
        }
    }

    let u: Vec<_> = corners.chain((0..10_000).map(|i| Stream::new(1, i, 0).uniform2(0))).collect();
    let bits = |point| C::coordinates(point).map(f32::to_bits);
    for isa in isas() {
        let mut points = vec![warp.map(Vec2::splat(0.7)); u.len()];
        warp.map_many(isa, &u, &mut points);
        for (&u, &point) in u.iter().zip(&points) {
            assert_eq!(bits(point), bits(warp.map(u)), "{name}: {u} on {isa:?}");
        }
    }

    let mut sum = Checksum::new();
    for &u in &u[ends.len() * ends.len()..] {
        sum.add(C::coordinates(warp.map(u)));
    }
    assert_eq!(sum.value(), golden, "{name}: {:#018X}", sum.value());
}

#[test]
fn hemispheres() {
    let hemisphere = Cap { height: 1.0 };
    check("uniform", UniformHemisphere, hemisphere, 0x2BE4_1C1C_C820_FEDA);
    check("cosine", CosineHemisphere, hemisphere, 0x01D5_FB31_69D9_1DE3);
    check("Malley", MalleyHemisphere, hemisphere, 0x3AEC_AA59_A917_CBAA);
    check("concentric", ConcentricHemisphere, hemisphere, 0x56CD_4E79_304C_2BAC);
    check("power 0", PowerCosineHemisphere { exponent: 0.0 }, hemisphere, 0x4CC7_4712_6CE6_3E10);
    check("power 1", PowerCosineHemisphere { exponent: 1.0 }, hemisphere, 0xB440_B18A_4309_D60D);
    check("power 37.5", PowerCosineHemisphere { exponent: 37.5 }, hemisphere, 0xB3F4_293D_0649_DA5A);
}

#[test]
fn strata() {
    // One cell alone is the whole cosine hemisphere.
    for (rings, sectors, ring, sector, golden) in [
        (1, 1, 0, 0, 0x01D5_FB31_69D9_1DE3),
        (4, 12, 0, 0, 0xCE6A_3DF0_998C_BE36),
        (4, 12, 2, 7, 0xE743_A7D2_86D5_494E),
        (4, 12, 3, 11, 0xD09C_3487_B5ED_E31A),
    ] {
        let cell = Strata::new(rings, sectors).unwrap().cell(ring, sector).unwrap();
        let height = |ring| (1.0 - f64::from(ring) / f64::from(rings)).sqrt();
        let z = [ring + 1, ring].map(height);
        let turns = [sector, sector + 1].map(|k| f64::from(k) / f64::from(sectors));
        check(&format!("cell {ring}, {sector} of {rings} x {sectors}"), cell, Patch { z, turns }, golden);
    }
}

#[test]
fn shapes() {
    check("sphere", UniformSphere, Cap { height: 2.0 }, 0x2E73_8224_6335_BDF7);
    check("polar disc", PolarDisc, Disc, 0x2AFF_62FE_1975_9C41);
    check("concentric disc", ConcentricDisc, Disc, 0x0A88_1084_71CB_D682);
    check("triangle", Triangle, Barycentric, 0x5540_D4F4_BAFE_6BD9);
}

#[test]
fn weighted_squares() {
    check("bilinear, even", Bilinear { weights: [1.0; 4] }, Square, 0x3BBF_EEC4_54EB_D8C2);
    check("bilinear, one-sided", Bilinear { weights: [0.05, 0.3, 1.0, 0.1] }, Square, 0xBC41_73AF_6654_940F);
    // Even weights change nothing, and a line from 0 to 1 is inverted by the root.
    let even = Bilinear { weights: [0.3; 4] };
    assert_eq!((even.map(Vec2::new(0.25, 0.75)), even.pdf(Vec2::splat(0.1))), (Vec2::new(0.25, 0.75), 1.0));
    let steep = Bilinear { weights: [1e-9, 1.0, 1e-9, 1.0] };
    assert!((steep.map(Vec2::new(0.25, 0.75)) - Vec2::new(0.5, 0.75)).length() < 1e-6);
    assert_eq!(even.pdf(Vec2::new(1.5, 0.5)), 0.0);
    let one_sided = Bilinear { weights: [0.05, 0.3, 1.0, 0.1] };
    for i in 0..100 {
        let point = Stream::new(1, i, 0).uniform2(0);
        assert!((one_sided.density(point) * one_sided.per_density(point) - 1.0).abs() < 4.0 * f32::EPSILON);
    }
}

#[test]
fn cones() {
    for (angle, golden) in
        [(0.004_65f32, 0xB16B_E20A_1910_1F80), (0.5, 0xAE3D_D0B6_DA45_A046), (2.5, 0x20C9_598E_0E2C_20F7)]
    {
        let height = 2.0 * (f64::from(angle) / 2.0).sin().powi(2);
        let cone = Cone::from_angle(angle);
        assert!((f64::from(cone.height()) / height - 1.0).abs() < 4e-7);
        check("cone", cone, Cap { height: cone.height().into() }, golden);
    }
    // Seen from twice its radius a sphere fills a cone of 30 degrees.
    let height = f64::from(Cone::from_sin_squared(0.25).height());
    assert!((height - (1.0 - 0.75f64.sqrt())).abs() < 1e-8);
    assert_eq!(Cone::from_sin_squared(1.0).height(), 1.0);
    assert_eq!(Cone::from_angle(core::f32::consts::PI).height(), 2.0);
}

/// Nothing outside of the domain has a density.
#[test]
fn outside_is_empty() {
    for z in [-1.0, -0.6, 0.0] {
        let d = Vec3::new((1.0f32 - z * z).sqrt(), 0.0, z);
        assert_eq!(UniformHemisphere.pdf(d), 0.0);
        assert_eq!(CosineHemisphere.pdf(d), 0.0);
        assert_eq!(MalleyHemisphere.pdf(d), 0.0);
        assert_eq!(ConcentricHemisphere.pdf(d), 0.0);
        assert_eq!(Strata::new(2, 4).unwrap().cell(1, 0).unwrap().pdf(d), 0.0);
        assert_eq!(PowerCosineHemisphere { exponent: 2.0 }.pdf(d), 0.0);
        assert_eq!(Cone::from_angle(1.0).pdf(d), 0.0);
    }
    assert_eq!(PolarDisc.pdf(Vec2::new(0.8, 0.7)), 0.0);
    assert_eq!(ConcentricDisc.pdf(Vec2::new(0.8, 0.7)), 0.0);
    assert_eq!(Triangle.pdf(Vec2::new(0.6, 0.5)), 0.0);
    assert_eq!(Triangle.pdf(Vec2::new(-0.1, 0.5)), 0.0);
}

/// Means over a grid of u against the moments of the distributions.
#[test]
fn moments() {
    let mean = |f: &dyn Fn(Vec2) -> f32| {
        let grid = (0..256 * 256).map(|i| (Vec2::new((i / 256) as f32, (i % 256) as f32) + 0.5) / 256.0);
        grid.map(|u| f64::from(f(u))).sum::<f64>() / 65_536.0
    };
    let directions = |name: &str, warp: &dyn Fn(Vec2) -> Vec3, first: f64, second: f64| {
        for (moment, expected) in [
            (mean(&|u| warp(u).x), 0.0),
            (mean(&|u| warp(u).y), 0.0),
            (mean(&|u| warp(u).z), first),
            (mean(&|u| warp(u).z.powi(2)), second),
            (mean(&|u| warp(u).x.powi(2)), (1.0 - second) / 2.0),
        ] {
            assert!((moment - expected).abs() < 2e-4, "{name}: {moment}, not {expected}");
        }
    };
    directions("uniform", &|u| UniformHemisphere.map(u), 1.0 / 2.0, 1.0 / 3.0);
    directions("cosine", &|u| CosineHemisphere.map(u), 2.0 / 3.0, 1.0 / 2.0);
    directions("concentric", &|u| ConcentricHemisphere.map(u), 1.0 / 2.0, 1.0 / 3.0);
    directions("Malley", &|u| MalleyHemisphere.map(u), 2.0 / 3.0, 1.0 / 2.0);
    // (n + 1)/(n + 2) and (n + 1)/(n + 3).
    directions("power", &|u| PowerCosineHemisphere { exponent: 9.0 }.map(u), 10.0 / 11.0, 10.0 / 12.0);
    directions("sphere", &|u| UniformSphere.map(u), 0.0, 1.0 / 3.0);
    // A cap of height 1/2 spans z from 1/2 to 1.
    directions("cone", &|u| Cone::from_sin_squared(0.75).map(u), 3.0 / 4.0, 7.0 / 12.0);
    for disc in [|u| PolarDisc.map(u), |u| ConcentricDisc.map(u)] {
        assert!((mean(&|u| disc(u).length_squared()) - 0.5).abs() < 1e-4);
        assert!(mean(&|u| disc(u).x).abs() < 1e-6 && mean(&|u| disc(u).y).abs() < 1e-6);
    }
    assert!((mean(&|u| Triangle.map(u).x) - 1.0 / 3.0).abs() < 1e-4);
    assert!((mean(&|u| Triangle.map(u).y) - 1.0 / 3.0).abs() < 1e-4);
    assert!((mean(&|u| Triangle.map(u).x.powi(2)) - 1.0 / 6.0).abs() < 1e-4);
}

#[test]
fn corners_of_the_square_are_kept() {
    let most = ONE_MINUS_EPSILON;
    assert_eq!(ConcentricDisc.map(Vec2::splat(0.5)), Vec2::ZERO);
    assert_eq!(ConcentricDisc.inverse(Vec2::ZERO), Vec2::splat(0.5));
    assert_eq!(ConcentricDisc.map(Vec2::new(0.0, 0.5)), Vec2::new(-1.0, 0.0));
    assert_eq!(CosineHemisphere.map(Vec2::ZERO), Vec3::Z);
    assert_eq!(CosineHemisphere.map(Vec2::new(most, 0.0)).z, 2f32.powi(-12));
    assert_eq!(MalleyHemisphere.map(Vec2::new(0.0, 0.5)).z, 2f32.powi(-12));
    assert_eq!(UniformHemisphere.map(Vec2::new(most, 0.0)).z, 2f32.powi(-24));
    assert_eq!(ConcentricHemisphere.map(Vec2::new(0.0, 0.5)).z, 2f32.powi(-24));
    assert_eq!(Triangle.map(Vec2::ZERO), Vec2::ZERO);
    assert!(Triangle.map(Vec2::splat(most)).element_sum() < 1.0);
}
