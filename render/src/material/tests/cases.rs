//! Materials of every kind.

use glam::Vec3;

use crate::material::Inputs;

/// A name for messages, and the material.
pub(super) type Case = (String, Inputs);

pub(super) const COSINES: [f32; 5] = [0.05, 0.2, 0.5, 0.8, 1.0];
pub(super) const ROUGHNESSES: [f32; 7] = [0.0, 0.1, 0.25, 0.4, 0.6, 0.8, 1.0];
/// For quadrature over directions.
const ROUGH: [f32; 2] = [0.5, 0.9];

const WHITE: Inputs = Inputs { base_color: Vec3::ONE, ..GREY };
const GREY: Inputs = Inputs::DEFAULT;

/// Materials that absorb nothing.
pub(super) fn white() -> Vec<Case> {
    let mut cases = vec![("matte".into(), WHITE)];
    for r in ROUGHNESSES {
        cases.push((format!("diffuse of roughness {r}"), Inputs { base_diffuse_roughness: r, ..WHITE }));
        for ior in [1.2, 1.5, 2.4] {
            let plastic = Inputs { specular_weight: 1.0, specular_roughness: r, specular_ior: ior, ..WHITE };
            cases.push((format!("plastic of roughness {r}, ior {ior}"), plastic));
        }
        let metal = Inputs { base_metalness: 1.0, specular_roughness: r, ..WHITE };
        cases.push((format!("metal of roughness {r}"), metal));
        let mixed = Inputs { base_metalness: 0.4, specular_weight: 1.0, ..metal };
        cases.push((format!("half a metal of roughness {r}"), mixed));
        let leaf = Inputs { diffuse_transmission_weight: 0.3, specular_weight: 1.0, specular_roughness: r, ..WHITE };
        cases.push((format!("leaf of roughness {r}"), leaf));
        for ior in [1.2, 1.5, 2.0] {
            let glass = Inputs {
                transmission_weight: 1.0,
                specular_weight: 1.0,
                specular_roughness: r,
                specular_ior: ior,
                ..WHITE
            };
            cases.push((format!("glass of roughness {r}, ior {ior}"), glass));
            let wall = Inputs { thin_walled: true, ..glass };
            cases.push((format!("thin wall of roughness {r}, ior {ior}"), wall));
            let mixed = Inputs { transmission_weight: 0.6, base_metalness: 0.3, ..glass };
            cases.push((format!("some glass of roughness {r}, ior {ior}"), mixed));
        }
        for (below, inputs) in [("matte", WHITE), ("metal", metal), ("half a metal", mixed)] {
            for c in [0.0, 0.5] {
                let coated = Inputs { coat_weight: 1.0, coat_roughness: c, coat_ior: 1.5, ..inputs };
                cases.push((format!("coat of roughness {c} over {below} of roughness {r}"), coated));
            }
        }
        let fuzzy = Inputs { fuzz_weight: 1.0, fuzz_roughness: r, ..WHITE };
        cases.push((format!("fuzz of roughness {r}"), fuzzy));
    }
    cases
}

/// Materials with colours, and of roughnesses that quadrature can do.
pub(super) fn coloured() -> Vec<Case> {
    let orange = Vec3::new(0.9, 0.5, 0.1);
    let teal = Vec3::new(0.1, 0.6, 0.7);
    let grey = Inputs { base_color: orange, base_diffuse_roughness: 0.7, ..GREY };
    let mut cases = vec![("orange matte".into(), Inputs { base_color: orange, ..GREY }), ("orange rough".into(), grey)];
    for r in ROUGH {
        for a in [0.0, 0.5] {
            let glossy = Inputs {
                specular_weight: 0.8,
                specular_color: teal,
                specular_roughness: r,
                specular_anisotropy: a,
                ..grey
            };
            cases.push((format!("plastic of roughness {r}, anisotropy {a}"), glossy));
            let metal = Inputs { base_metalness: 1.0, metal_edge_color: teal, ..glossy };
            cases.push((format!("metal of roughness {r}, anisotropy {a}"), metal));
            let leaf = Inputs { diffuse_transmission_weight: 0.6, diffuse_transmission_color: teal, ..glossy };
            cases.push((format!("leaf of roughness {r}, anisotropy {a}"), leaf));
            let glass = Inputs { transmission_weight: 1.0, transmission_color: orange, ..glossy };
            cases.push((format!("glass of roughness {r}, anisotropy {a}"), glass));
            let wall = Inputs { thin_walled: true, ..glass };
            cases.push((format!("thin wall of roughness {r}, anisotropy {a}"), wall));
            let mixed = Inputs { transmission_weight: 0.6, base_metalness: 0.3, ..glass };
            cases.push((format!("some glass of roughness {r}, anisotropy {a}"), mixed));
            for (below, inputs) in
                [("plastic", glossy), ("metal", metal), ("leaf", leaf), ("glass", glass), ("wall", wall)]
            {
                let name = format!("{below} of roughness {r}, anisotropy {a}");
                let coated = Inputs { coat_weight: 0.7, coat_color: teal, coat_roughness: 0.5, ..inputs };
                cases.push((format!("coated {name}"), coated));
                let fuzzy = Inputs { fuzz_weight: 0.8, fuzz_color: orange, fuzz_roughness: r, ..coated };
                cases.push((format!("fuzzy coated {name}"), fuzzy));
                let film = Inputs { thin_film_weight: 0.8, thin_film_thickness: 400.0, thin_film_ior: 1.3, ..inputs };
                cases.push((format!("{name} with a film"), film));
            }
        }
    }
    cases
}

/// Coats with a normal of their own, which are not reciprocal, as little as any shading normal is.
pub(super) fn tilted() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, inputs) in
        coloured().into_iter().filter(|(name, _)| name.starts_with("coated") || name.starts_with("fuzzy"))
    {
        for degrees in [10.0f32, 35.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let coat_normal = Vec3::new(0.6 * sin, -0.8 * sin, cos);
            cases.push((format!("{name}, coat tilted by {degrees} degrees"), Inputs { coat_normal, ..inputs }));
        }
    }
    cases
}
