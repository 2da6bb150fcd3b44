//! Shading normals lose no energy.

use super::*;
use crate::material::{BumpShadowing, Evaluation, Inputs, Shading, bent_normal};

/// Normals that lean away from the surface's, which is z, and directions to look from.
fn leaning() -> impl Iterator<Item = (Vec3, Vec3)> {
    [0.2f32, 0.5, 0.9].into_iter().flat_map(|cos| {
        [(0.05, 0.0), (0.1, 3.0), (0.5, 2.0), (0.9, 1.0)]
            .map(|(z, azimuth)| (direction(cos, 0.3), direction(z, azimuth)))
    })
}

#[test]
fn bent_normals_face_the_viewer() {
    for (shading, wo) in leaning() {
        for shading in [shading, -shading] {
            let normal = bent_normal(Vec3::Z, shading, wo);
            assert!((normal.length() - 1.0).abs() < 1e-5 && normal.z > 0.0, "{shading} {wo}: {normal}");
            // As much as it faces away, or faces `wo` already; or enough.
            let cosine = shading.dot(wo).abs().max(0.01);
            assert!((normal.dot(wo) - cosine).abs() < 1e-5, "{shading} {wo}: {normal}");
            if shading.z > 0.0 && shading.dot(wo) > 0.1 {
                assert_eq!(normal, shading);
            }
        }
    }
    let wo = direction(0.05, std::f32::consts::PI);
    let behind = bent_normal(Vec3::Z, direction(0.99, 0.0), wo);
    let expected = direction(0.99, 0.0).dot(wo).abs();
    assert!((behind.dot(wo) - expected).abs() < 1e-5 && expected > 0.05, "as much as it faced away: {behind}");
    assert!((bent_normal(Vec3::Z, direction(0.05, 0.0), wo) - wo).length() < 0.11, "one that faces away from {wo}");
}

#[test]
fn no_light_is_lost_under_shading_normals() {
    let white = Inputs { base_color: Vec3::ONE, specular_weight: 1.0, specular_roughness: 0.5, ..Inputs::default() };
    let leaf = Inputs { diffuse_transmission_weight: 0.5, ..white };
    let glass = Inputs { transmission_weight: 1.0, ..white };
    let mirror = Inputs { base_metalness: 1.0, specular_roughness: 0.0, ..white };
    for (name, inputs) in [("plastic", white), ("leaf", leaf), ("glass", glass), ("mirror", mirror)] {
        let closure = Closure::new(&inputs, false);
        for (normal, wo) in leaning() {
            let shading = Shading::new(Vec3::Z, normal, Vec3::X, wo);
            let count = 16_384;
            let mut sum = 0.0;
            for sample in points(count).filter_map(|u| shading.sample(&closure, wo, u)) {
                sum += f64::from(sample.weight.x);
                if sample.density.is_finite() {
                    let evaluation = shading.eval(&closure, wo, sample.wi);
                    let error = sample.weight.x * sample.density - evaluation.f_cos.x;
                    assert!(error.abs() <= 1e-3 * evaluation.f_cos.x, "{name}: {sample:?} {evaluation:?}");
                    assert!((sample.density / evaluation.density - 1.0).abs() < 1e-3, "{name}: {sample:?}");
                }
                let is_before = sample.event.contains(crate::material::Event::REFLECTION);
                assert_eq!(sample.wi.z > 0.0, is_before, "{name}: {sample:?}");
            }
            let albedo = sum / f64::from(count);
            assert!((albedo - 1.0).abs() < 0.02, "{name}, normal {normal}, wo {wo}: {albedo}");
        }
    }
}

#[test]
fn densities_under_shading_normals_integrate_to_one() {
    let closure = Closure::new(&Inputs { diffuse_transmission_weight: 0.5, ..Inputs::default() }, false);
    for (normal, wo) in leaning() {
        let shading = Shading::new(Vec3::Z, normal, Vec3::X, wo);
        let count = 40_000;
        let sum: f64 = points(count)
            .map(|u| direction(1.0 - 2.0 * u.x, std::f32::consts::TAU * u.y))
            .map(|wi| f64::from(shading.eval(&closure, wo, wi).density))
            .sum();
        let integral = sum / f64::from(count) * 4.0 * std::f64::consts::PI;
        assert!((integral - 1.0).abs() < 0.01, "normal {normal}, wo {wo}: {integral}");
    }
}

/// Normals that a map tilts by these degrees from the surface's, which is z.
fn tilted() -> impl Iterator<Item = (Vec3, f32)> {
    [5.0f32, 15.0, 30.0, 50.0, 70.0].into_iter().map(|degrees| (direction(degrees.to_radians().cos(), 2.0), degrees))
}

#[test]
fn bumps_absorb_a_part_of_what_they_catch() {
    let wo = Vec3::Z;
    for albedo in [0.0f32, 0.3, 0.8, 1.0].map(Vec3::splat) {
        // What a white surface leaves of uniform light, of which bumps of this albedo catch a part.
        let closure = Closure::new(&Inputs { base_color: Vec3::ONE, ..Inputs::default() }, false);
        for (normal, degrees) in tilted() {
            let bumps = BumpShadowing::new(Vec3::Z, normal, albedo);
            let shading = Shading::new(Vec3::Z, normal, Vec3::X, wo).with_bumps(Vec3::Z, bumps);
            let count = 16_384;
            let mut sum = 0.0;
            for sample in points(count).filter_map(|u| shading.sample(&closure, wo, u)) {
                sum += sample.weight.x;
                let Evaluation { f_cos, density, .. } = shading.eval(&closure, wo, sample.wi);
                assert!((sample.density / density - 1.0).abs() < 1e-3, "{sample:?}, {density}");
                assert!((sample.weight.x * density - f_cos.x).abs() <= 1e-3 * density, "{sample:?}, {f_cos}");
            }
            let left = sum / count as f32;
            assert!((bumps.mean().x - left).abs() < 0.008, "{albedo}, {degrees}°: {left}, {bumps:?}");
            if albedo == Vec3::ONE {
                assert!((left - 1.0).abs() < 1e-4, "white bumps lose no light: {left}");
            }
        }
    }
}

#[test]
fn bumps_shadow_light_from_low_directions() {
    let bumps = BumpShadowing::new(Vec3::Z, direction(30.0f32.to_radians().cos(), 0.0), Vec3::ZERO);
    // α² = tan² 30° / 8; at 60°, tan² θ = 3.
    let expected = 2.0 / (1.0 + (1.0f32 + 3.0 / 24.0).sqrt());
    let at = |cos: f32| bumps.factor(direction(cos, 1.0)).x;
    assert!((at(0.5) - expected).abs() < 1e-5, "{}", at(0.5));
    assert_eq!(at(1.0), 1.0);
    assert!(at(0.01) < 0.2 && at(-0.01) == 0.0 && at(-1.0) == 0.0);
}

#[test]
fn surfaces_without_bumps_have_no_shadowing() {
    for (normal, _) in tilted() {
        let bumps = BumpShadowing::new(normal, normal, Vec3::splat(0.2));
        for wi in [0.0, 0.01, 0.5, 1.0, -0.5].map(|cos| direction(cos, 1.0)) {
            assert_eq!((bumps.factor(wi), BumpShadowing::NONE.factor(wi)), (Vec3::ONE, Vec3::ONE));
        }
        assert_eq!(bumps.mean(), Vec3::ONE);
    }
}
