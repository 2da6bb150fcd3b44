//! Energy, reciprocity, and densities both ways.

use super::cases::{COSINES, coloured, tilted, white};
use super::*;
use crate::material::{Event, Inputs, Kind, Sample};

#[test]
fn white_closures_scatter_all_light() {
    for (name, inputs) in white() {
        for is_inside in [false, true] {
            let closure = Closure::new(&inputs, is_inside);
            for cos in COSINES {
                // Rough glass from inside has the tables' greatest errors.
                let (count, tolerance) = if cos < 0.1 { (65_536, 0.008) } else { (16_384, 0.0075) };
                let albedo = furnace(&closure, direction(cos, 0.7), count);
                let error = (albedo - 1.0).abs().max_element();
                assert!(error < tolerance, "{name}, inside {is_inside}, cos {cos}: {albedo}");
            }
        }
    }
}

#[test]
fn coloured_closures_gain_no_light() {
    for (name, inputs) in coloured().into_iter().chain(tilted()) {
        for is_inside in [false, true] {
            let closure = Closure::new(&inputs, is_inside);
            for cos in COSINES {
                let albedo = furnace(&closure, direction(cos, 0.7), 16_384);
                assert!(albedo.max_element() < 1.04 && albedo.min_element() > 0.01, "{name}, cos {cos}: {albedo}");
            }
        }
    }
}

/// The refractive index on a side, of a surface that refracts.
fn index(inputs: &Inputs, is_inside: bool) -> f32 {
    let refracts = inputs.transmission_weight > 0.0 && !inputs.thin_walled;
    if refracts && is_inside { inputs.specular_ior } else { 1.0 }
}

#[test]
fn closures_are_reciprocal_and_know_the_reverse_density() {
    let pairs = 2000;
    for (number, (name, inputs)) in coloured().into_iter().enumerate() {
        for is_inside in [false, true] {
            let (here, beyond) = (Closure::new(&inputs, is_inside), Closure::new(&inputs, !is_inside));
            let mut lit = 0;
            for pair in 0..pairs {
                let sampler = Sampler::new(Pattern::Random, 3, number as u32, pair);
                let (u, v) = (sampler.uniform2(0), sampler.uniform2(1));
                let wo = direction(1.0 - u.x, std::f32::consts::TAU * u.y);
                let wi = direction(1.0 - 2.0 * v.x, std::f32::consts::TAU * v.y);
                if wo.z < 1e-3 || wi.z.abs() < 1e-3 {
                    continue;
                }
                let forth = here.eval(wo, wi);
                let back = if wi.z > 0.0 { here.eval(wi, wo) } else { beyond.eval(turned(wi), turned(wo)) };
                let (n_o, n_i) = (index(&inputs, is_inside), index(&inputs, is_inside != (wi.z < 0.0)));
                let (f, g) = (forth.f_cos / (wi.z.abs() * n_i * n_i), back.f_cos / (wo.z * n_o * n_o));
                let error = (f - g).abs().max_element() / (f + g).max_element().max(1e-6);
                assert!(error < 1e-5, "{name}, inside {is_inside}, {wo} {wi}: {f} {g}");
                for (a, b) in [(forth.density, back.reverse_density), (forth.reverse_density, back.density)] {
                    assert!((a - b).abs() <= 1e-4 * (a + b), "{name}, inside {is_inside}, {wo} {wi}: {a} {b}");
                }
                assert!(f.min_element() >= 0.0 && f.is_finite() && forth.density >= 0.0, "{name}: {wo} {wi} {f}");
                assert!(
                    f == Vec3::ZERO || forth.density > 0.0,
                    "{name}, inside {is_inside}: {wo} {wi} is never sampled"
                );
                lit += u32::from(f != Vec3::ZERO);
            }
            assert!(lit > pairs / 4, "{name}: {lit}");
        }
    }
}

#[test]
fn weights_are_values_by_densities() {
    for (name, inputs) in coloured().into_iter().chain(tilted()) {
        for is_inside in [false, true] {
            let closure = Closure::new(&inputs, is_inside);
            for cos in COSINES {
                let wo = direction(cos, 0.7);
                for sample in points(100).filter_map(|u| closure.sample(wo, u)) {
                    assert!((sample.wi.length() - 1.0).abs() < 1e-5, "{name}: {sample:?}");
                    let evaluation = closure.eval(wo, sample.wi);
                    assert_eq!(sample.density, evaluation.density, "{name}: {sample:?}");
                    let error = (sample.weight * sample.density - evaluation.f_cos).abs().max_element();
                    assert!(error <= 1e-5 * evaluation.f_cos.max_element(), "{name}: {sample:?}");
                }
            }
        }
    }
}

/// Whether a microfacet reflects is chosen by its own reflectance: that of one in total reflection, inside, is not rare.
#[test]
fn samples_of_glass_have_like_weights() {
    for (name, inputs) in white().into_iter().filter(|(name, _)| name.starts_with("glass of roughness 0.25")) {
        for is_inside in [false, true] {
            let closure = Closure::new(&inputs, is_inside);
            for cos in COSINES.into_iter().filter(|cos| *cos >= 0.5) {
                let samples = points(4096).map(|u| closure.sample(direction(cos, 0.7), u));
                let squares = samples.map(|sample| sample.map_or(0.0, |sample| sample.weight.x * sample.weight.x));
                let mean = squares.sum::<f32>() / 4096.0;
                assert!(mean < 1.3, "{name}, inside {is_inside}, cos {cos}: {mean}");
            }
        }
    }
}

#[test]
fn albedo_is_what_samples_find() {
    for (name, inputs) in white().into_iter().chain(coloured()) {
        // Those of anisotropic microfacets and of coloured glass are approximate, and more so below layers.
        let rough = inputs.specular_anisotropy > 0.0 || inputs.transmission_weight > 0.0;
        let tolerance = match Kind::of(&inputs) {
            Kind::Layered if inputs.transmission_weight > 0.0 => continue,
            Kind::Layered => 0.1,
            _ if rough => 0.1,
            // What metal gains by further reflections is told as if the colour were the same at all angles.
            _ if inputs.base_metalness > 0.0 => 0.015,
            _ => 0.01,
        };
        let closure = Closure::new(&inputs, false);
        for cos in COSINES {
            let wo = direction(cos, 0.7);
            let (told, found) = (Bsdf::albedo(&closure, wo), furnace(&closure, wo, 4096));
            assert!((told - found).abs().max_element() < tolerance, "{name}, cos {cos}: {told} {found}");
        }
    }
}

#[test]
fn a_tilted_coat_mirrors_about_its_own_normal() {
    let coat_normal = Vec3::new(0.3, -0.2, 0.9).normalize();
    let inputs = Inputs { coat_weight: 1.0, coat_normal, ..Inputs::default() };
    let closure = Closure::new(&inputs, false);
    for cos in COSINES {
        let wo = direction(cos, 2.0);
        // Where the coat reflects to below the surface, it is mirrored to above it.
        let mirrored = 2.0 * wo.dot(coat_normal) * coat_normal - wo;
        let mirrored = mirrored.with_z(mirrored.z.abs());
        let deltas: Vec<_> =
            points(256).filter_map(|u| closure.sample(wo, u)).filter(|it| it.density.is_infinite()).collect();
        assert!(deltas.iter().all(|sample| sample.wi.distance(mirrored) < 1e-5), "{cos}: {mirrored} {deltas:?}");
        assert!(!deltas.is_empty(), "{cos}");
    }
    // Hardly tilted, it is nearly the closure without a normal of its own.
    let upright = Closure::new(&Inputs { coat_roughness: 0.4, coat_normal: Vec3::Z, ..inputs }, false);
    let turned = Closure::new(
        &Inputs { coat_roughness: 0.4, coat_normal: Vec3::new(1e-4, 0.0, 1.0).normalize(), ..inputs },
        false,
    );
    for u in points(256) {
        let (wo, wi) = (direction(0.6, 1.0), direction(u.x.max(0.01), 6.0 * u.y));
        let [a, b] = [&upright, &turned].map(|closure| closure.eval(wo, wi));
        assert!((a.f_cos - b.f_cos).abs().max_element() < 5e-3 * a.f_cos.max_element() + 1e-5, "{wi}: {a:?} {b:?}");
    }
}

#[test]
fn mirrors_reflect_as_much_as_samples_do() {
    let mut mirrors = 0;
    for (name, inputs) in white().into_iter().chain(coloured()) {
        for is_inside in [false, true] {
            let closure = Closure::new(&inputs, is_inside);
            for cos in COSINES {
                let (wo, count) = (direction(cos, 0.7), 4096);
                let delta = |sample: &Sample| sample.event.contains(Event::SPECULAR | Event::REFLECTION);
                let samples = points(count).filter_map(|u| closure.sample(wo, u)).filter(delta);
                let sum: DVec3 = samples.map(|sample| sample.weight.as_dvec3()).sum();
                let (sampled, known) = ((sum / f64::from(count)).as_vec3(), closure.mirror_reflectance(wo));
                let error = (sampled - known).abs().max_element();
                assert!(error < 0.004, "{name}, inside {is_inside}, cos {cos}: {sampled}, not {known}");
                mirrors += u32::from(known != Vec3::ZERO);
            }
        }
    }
    assert!(mirrors > 200, "{mirrors}");
}
