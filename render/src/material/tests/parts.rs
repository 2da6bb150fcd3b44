//! Fresnel's equations, films and columns against exact values.

use super::cases::COSINES;
use super::*;
use crate::material::column::Column;
use crate::material::film::Film;
use crate::material::fresnel::{self, Metal};

#[test]
fn fresnel_is_exact_where_it_is_simple() {
    assert!((fresnel::dielectric(1.0, 1.5).0 - 0.04).abs() < 1e-6);
    assert!((fresnel::dielectric(1.0, 1.0 / 1.5).0 - 0.04).abs() < 1e-6);
    // Brewster's angle: only half of the light is reflected, that of one polarization.
    let brewster = (1.0 + 1.5f32 * 1.5).sqrt().recip();
    assert!((fresnel::dielectric(brewster, 1.5).0 - 0.5 * (1.25f32 / 3.25).powi(2)).abs() < 1e-6);
    assert_eq!(fresnel::dielectric(0.5, 1.0 / 1.5), (1.0, 0.0), "total reflection");
    for cos in COSINES {
        let (reflectance, beyond) = fresnel::dielectric(cos, 1.7);
        assert!((fresnel::of_refraction(beyond, cos, 1.0 / 1.7) - reflectance).abs() < 1e-6);
        assert!((fresnel::conductor(cos, 1.7, 0.0) - reflectance).abs() < 1e-5, "a conductor that does not absorb");
    }
}

#[test]
fn metals_are_exact_at_two_angles() {
    let (n, k) = (Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603));
    let gold = Metal::from_complex_index(n, k);
    for cos in [1.0, 1.0 / 7.0] {
        let exact = Vec3::from_array(std::array::from_fn(|i| fresnel::conductor(cos, n[i], k[i])));
        assert!((gold.at(cos) - exact).abs().max_element() < 1e-5, "{cos}: {} {exact}", gold.at(cos));
    }
    let mean = points(4096).map(|u| gold.at(u.x.sqrt())).sum::<Vec3>() / 4096.0;
    assert!((gold.mean() - mean).abs().max_element() < 1e-4, "{} {mean}", gold.mean());
}

#[test]
fn films_without_thickness_are_not_seen() {
    let film = Film { weight: 1.0, thickness: 0.0, ior: 1.3 };
    for cos in COSINES {
        for ior in [1.1, 1.5, 2.0] {
            let (bare, covered) = (fresnel::dielectric(cos, ior).0, film.over_dielectric(cos, ior));
            // Two terms of the sum.
            let error = (covered - bare).abs().max_element();
            assert!(error < 0.02, "index {ior}, cos {cos}: {bare} {covered}");
        }
    }
    let metal = Vec3::new(0.9, 0.6, 0.3);
    let covered = film.over_metal(1.0, metal);
    assert!((covered - metal).abs().max_element() < 0.03, "{covered}");
}

#[test]
fn films_shine_where_waves_add_up() {
    // A quarter of a wave of 540 nm, which green is: the two faces' waves cancel under a denser base.
    let film = Film { weight: 1.0, thickness: 540.0 / (4.0 * 1.22), ior: 1.22 };
    let dark = film.over_dielectric(1.0, 1.5);
    assert!(dark.y < 0.003 && dark.y < dark.x && dark.y < dark.z, "{dark}");
    // Half a wave does as no film does.
    let film = Film { thickness: 2.0 * film.thickness, ..film };
    let bright = film.over_dielectric(1.0, 1.5);
    assert!((bright.y - 0.04).abs() < 0.004 && bright.y > bright.x && bright.y > bright.z, "{bright}");
}

#[test]
fn means_of_columns_are_those_of_uniform_light() {
    assert!((Column::ONE.mean() - 1.0).abs() < 1e-6);
    // The column is linear in the root of the cosine.
    assert!((Column::from_fn(f32::sqrt).mean() - 0.8).abs() < 1e-5);
    assert!((Column::from_fn(|cos| cos).mean() - 2.0 / 3.0).abs() < 1e-3);
    let square = Column::from_fn(|cos| cos * cos);
    for cos in [0.0, 0.001, 0.3, 0.77, 1.0] {
        assert!((square.at(cos) - cos * cos).abs() < 2e-3);
    }
}
