//! The mean radiance of a scene: the average light lost by a truncated path.
//!
//! In a closed room all of whose surfaces emit `E` and reflect `R`, radiance is `E + R E + R² E + … = E / (1 - R)`, as
//! Shirley has it. For other rooms the series is taken with means over their area `A`: lights send the power `Φ`, which
//! falls on surfaces evenly, and each reflection leaves a part `R̄` of it: `L̄ = Φ / (π A (1 - R̄))`, the ambient term of
//! Cohen, Chen, Wallace and Greenberg 1988. The sky counts as a black sphere around the scene that glows.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome_kernel::{Aabb, Triangle};

use super::{area, flux, radius};
use crate::scene::{Material, PunctualLight};

/// Rooms that reflect more than this are taken to reflect this much: the series must end.
const MAX_REFLECTANCE: f64 = 0.99;

/// The mean radiance of the scene that [`Lights::new`](super::Lights::new) takes; zero without surfaces.
pub(super) fn mean_radiance<'m>(
    triangles: &[Triangle],
    material: impl Fn(usize) -> &'m Material,
    punctual: &[PunctualLight],
    sky: Vec3,
    bounds: Aabb,
) -> Vec3 {
    let (mut total_area, mut reflecting, mut power) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for (prim_id, triangle) in triangles.iter().enumerate() {
        let (material, area) = (material(prim_id), f64::from(area(triangle)));
        total_area += area;
        reflecting += area * material.mean_albedo().as_dvec3();
        power += PI * area * material.emission.as_dvec3();
    }
    for light in punctual {
        let (color, extent) = flux(light, bounds);
        power += extent * color.as_dvec3();
    }
    if sky != Vec3::ZERO {
        let sphere = 4.0 * PI * radius(bounds).powi(2);
        total_area += sphere;
        power += PI * sphere * sky.as_dvec3();
    }
    if total_area == 0.0 {
        return Vec3::ZERO;
    }
    let reflectance = (reflecting / total_area).min(DVec3::splat(MAX_REFLECTANCE));
    (power / (PI * total_area * (1.0 - reflectance))).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn surface(diffuse: f32, emission: f32) -> Material {
        Material { emission: Vec3::splat(emission), ..Material::matte(Vec3::splat(diffuse)) }
    }

    #[test]
    fn a_room_of_one_material_has_shirleys_radiance() {
        let material = surface(0.5, 0.5);
        let mean = mean_radiance(&[WALL; 4], |_| &material, &[], Vec3::ZERO, Aabb::EMPTY);
        assert_eq!(mean, Vec3::ONE);
    }

    #[test]
    fn light_of_all_kinds_adds_up() {
        let material = surface(0.0, 0.0);
        let mean = |lights: &[PunctualLight], sky: f32| {
            let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
            let sky = Vec3::splat(sky);
            mean_radiance(&[WALL; 2], |_| &material, lights, sky, bounds).x
        };
        // 4π W on a square metre of black is 4 W/(m² sr) from everywhere.
        let point = PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::ONE, radius: 0.0 };
        assert!((mean(&[point], 0.0) - 4.0).abs() < 1e-6);
        // A sky of 12π square metres around one of black.
        let share = 12.0 * PI / (12.0 * PI + 1.0);
        assert!((f64::from(mean(&[], 3.0)) - 3.0 * share).abs() < 1e-6);
        assert_eq!(mean_radiance(&[], |_| &material, &[], Vec3::ZERO, Aabb::EMPTY), Vec3::ZERO);
    }
}
