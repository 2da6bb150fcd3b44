//! Values of closures for `benches/renderers/mitsuba_closures.py` to compare with those of Mitsuba's models that are
//! the same: one JSON object a line.
//!
//!     cargo run --release -p halfdome-benches --bin closures | target/renderers/bin/python benches/renderers/mitsuba_closures.py

use std::io::{self, BufWriter, Write};

use glam::{Vec2, Vec3};
use halfdome::material::{Bsdf, Closure, Inputs, fresnel};
use halfdome_kernel::sampling::{Pattern, Sampler};
use serde_json::{Value, json};

const PAIRS: u32 = 2000;

/// Refractive indices of gold at 650, 550 and 450 nm, about: Johnson and Christy 1972.
const GOLD: [(f32, f32); 3] = [(0.16, 3.40), (0.42, 2.35), (1.38, 1.91)];

fn main() -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    let mut write = |value: Value| writeln!(out, "{value}");
    let grey = Inputs::default();
    for (wo, wi) in pairs(0, false) {
        let f_cos = Closure::new(&grey, false).eval(wo, wi).f_cos.x;
        write(json!({"model": "diffuse", "wo": wo, "wi": wi, "value": f_cos}))?;
    }
    for (n, k) in GOLD {
        for step in 0..=100 {
            let cos = 0.01f32.max(step as f32 / 100.0);
            write(json!({"model": "conductor", "n": n, "k": k, "cos": cos, "value": fresnel::conductor(cos, n, k)}))?;
        }
    }
    for roughness in [0.2f32, 0.5, 0.8, 1.0] {
        for anisotropy in [0.0f32, 0.6] {
            let metal = Inputs {
                base_color: Vec3::ONE,
                base_metalness: 1.0,
                specular_roughness: roughness,
                specular_anisotropy: anisotropy,
                ..grey
            };
            let glass = Inputs { base_metalness: 0.0, specular_weight: 1.0, transmission_weight: 1.0, ..metal };
            // OpenPBR's, which the closures limit to 1.
            let ratio = 1.0 - anisotropy;
            let x = roughness * roughness * (2.0 / (1.0 + ratio * ratio)).sqrt();
            let alpha = [x.min(1.0), (ratio * x).min(1.0)];
            for (wo, wi) in pairs(1, false) {
                let f_cos = Closure::new(&metal, false).eval_single(wo, wi).x;
                write(json!({"model": "rough conductor", "alpha": alpha, "wo": wo, "wi": wi, "value": f_cos}))?;
            }
            for is_inside in [false, true] {
                for (wo, wi) in pairs(2, true) {
                    let f_cos = Closure::new(&glass, is_inside).eval_single(wo, wi).x;
                    write(json!({
                        "model": "rough dielectric", "alpha": alpha, "ior": glass.specular_ior, "inside": is_inside,
                        "wo": wo, "wi": wi, "value": f_cos,
                    }))?;
                }
            }
        }
    }
    let wall =
        Inputs { specular_weight: 1.0, specular_roughness: 0.0, transmission_weight: 1.0, thin_walled: true, ..grey };
    for step in 1..=50 {
        let wo = direction(step as f32 / 50.0, 1.0);
        let closure = Closure::new(&wall, false);
        let count = 1 << 16;
        let reflected: f64 = (0..count)
            .filter_map(|i| closure.sample(wo, Vec2::new((i as f32 + 0.5) / count as f32, 0.5)))
            .filter(|sample| sample.wi.z > 0.0)
            .map(|sample| f64::from(sample.weight.x))
            .sum();
        write(json!({
            "model": "thin dielectric", "ior": wall.specular_ior, "wo": wo, "value": reflected / f64::from(count),
        }))?;
    }
    out.flush()
}

/// Directions above the horizon, and others: above it too, or on both sides.
fn pairs(pixel: u32, are_both: bool) -> impl Iterator<Item = (Vec3, Vec3)> {
    let lowest = if are_both { -1.0 } else { 0.0 };
    (0..PAIRS).map(move |index| {
        let sampler = Sampler::new(Pattern::Random, 11, pixel, index);
        let (u, v) = (sampler.uniform2(0), sampler.uniform2(1));
        let cos = lowest + (1.0 - lowest) * v.x;
        let cos = if cos.abs() < 0.02 { 0.02 } else { cos };
        (direction(0.02 + 0.98 * u.x, u.y), direction(cos, v.y))
    })
}

/// By cosine and azimuth in turns.
fn direction(cos: f32, turns: f32) -> Vec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let (y, x) = (std::f32::consts::TAU * turns).sin_cos();
    Vec3::new(sin * x, sin * y, cos)
}
