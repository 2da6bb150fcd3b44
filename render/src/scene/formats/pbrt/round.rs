//! Surfaces of revolution about z as strips around it, in their own coordinates: spheres, discs and cylinders, each
//! with exactly the area of the shape, and so the same power. Fronts are where the normals point.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::parameters::Parameters;
use crate::scene::{Mesh, SceneError};

/// Strips around an axis.
const SIDES: u32 = 64;
/// Bands of a sphere from pole to pole.
const BANDS: u32 = 32;

/// The angle around the axis, radians.
fn phi_max(parameters: &Parameters) -> Result<f64, SceneError> {
    Ok(f64::from(parameters.positive("phimax", 360.0)?).min(360.0).to_radians())
}

/// A profile of radius, height and normal that turns about z. Texture coordinates go around, and from 0 at its start to
/// 1 at its end, which are given with it. Fronts are where the normals point.
fn revolve(profile: &[(DVec2, DVec2, f64)], phi_max: f64, is_flat: bool) -> Mesh {
    let mut mesh = Mesh::default();
    for &(place, normal, v) in profile {
        for side in 0..=SIDES {
            let u = f64::from(side) / f64::from(SIDES);
            let (sin, cos) = (u * phi_max).sin_cos();
            let around = |it: DVec2| DVec3::new(it.x * cos, it.x * sin, it.y).as_vec3();
            mesh.positions.push(around(place));
            mesh.texcoords.push(Vec2::new(u as f32, 1.0 - v as f32));
            if !is_flat {
                mesh.normals.push(around(normal));
            }
        }
    }
    for (row, pair) in (0..).zip(profile.windows(2)) {
        let [(begin, normal, _), (end, ..)] = [pair[0], pair[1]];
        // Along the profile and counter-clockwise about z.
        let is_outside = (end - begin).perp_dot(normal) < 0.0;
        for side in 0..SIDES {
            let [p, q] = [row * (SIDES + 1) + side, row * (SIDES + 1) + side + 1];
            let [r, s] = [p + SIDES + 1, q + SIDES + 1];
            let mut add = |corners: [u32; 3]| {
                let [a, b, c] = corners;
                mesh.triangles.push(if is_outside { corners } else { [a, c, b] });
            };
            // Where a ring is a point, one of two triangles has no area.
            if begin.x > 0.0 {
                add([p, q, s]);
            }
            if end.x > 0.0 {
                add([p, s, r]);
            }
        }
    }
    mesh
}

pub(super) fn sphere(parameters: &Parameters) -> Result<Mesh, SceneError> {
    let radius = f64::from(parameters.positive("radius", 1.0)?);
    let [low, high] = [("zmin", -radius), ("zmax", radius)].map(|(name, default)| {
        parameters.float(name, default as f32).map(|z| (f64::from(z) / radius).clamp(-1.0, 1.0))
    });
    let (low, high) = (low?, high?);
    let (low, high) = (low.min(high), low.max(high));
    let phi_max = phi_max(parameters)?;
    let (begin, end) = (low.acos(), high.acos());
    let ring = |band: u32| {
        let v = f64::from(band) / f64::from(BANDS);
        let theta = begin + (end - begin) * v;
        // Poles are exactly on the axis.
        let sin = if theta < 1e-9 || PI - theta < 1e-9 { 0.0 } else { theta.sin() };
        (DVec2::new(sin, theta.cos()), v)
    };
    let profile: Vec<_> = (0..=BANDS).map(ring).map(|(it, v)| (it, it, v)).collect();
    let mut mesh = revolve(&profile, phi_max, false);
    let exact = phi_max * (high - low);
    let scale = radius * (exact / area(&mesh)).sqrt();
    mesh.positions.iter_mut().for_each(|position| *position = (position.as_dvec3() * scale).as_vec3());
    Ok(mesh)
}

pub(super) fn disk(parameters: &Parameters) -> Result<Mesh, SceneError> {
    let (height, radius) =
        (f64::from(parameters.float("height", 0.0)?), f64::from(parameters.positive("radius", 1.0)?));
    let inner = f64::from(parameters.float("innerradius", 0.0)?).clamp(0.0, radius);
    let phi_max = phi_max(parameters)?;
    let step = phi_max / f64::from(SIDES);
    let scale = (step / step.sin()).sqrt();
    let ring = |radius: f64, v: f64| (DVec2::new(radius * scale, height), DVec2::Y, v);
    Ok(revolve(&[ring(radius, 0.0), ring(inner, 1.0)], phi_max, true))
}

pub(super) fn cylinder(parameters: &Parameters) -> Result<Mesh, SceneError> {
    let radius = f64::from(parameters.positive("radius", 1.0)?);
    let [low, high] = [parameters.float("zmin", -1.0)?, parameters.float("zmax", 1.0)?].map(f64::from);
    let phi_max = phi_max(parameters)?;
    let half = 0.5 * phi_max / f64::from(SIDES);
    let ring = |z: f64, v: f64| (DVec2::new(radius * half / half.sin(), z), DVec2::X, v);
    Ok(revolve(&[ring(low.min(high), 0.0), ring(low.max(high), 1.0)], phi_max, false))
}

/// The area of all triangles.
pub(super) fn area(mesh: &Mesh) -> f64 {
    let of_face = |face: usize| {
        let [a, b, c] = mesh.corners(face).map(Vec3::as_dvec3);
        0.5 * (b - a).cross(c - a).length()
    };
    (0..mesh.triangles.len()).map(of_face).sum()
}
