//! Sampling of secondary lights (see [`light`](crate::light)): light from a lamp by way of a point `y`
//! of such a triangle to the surface at `x`.
//!
//! Light reflected at `y` has two estimates. A bounce of a path may hit `y`, or `x` chooses `y` like a point on a lamp,
//! with the density `p` per solid angle, and another path continues from `x` by way of `y`. Both are weighted by their
//! densities at `x` (Veach 1997). Emission at `y` belongs to the first estimate, so that nothing is counted twice. Lit
//! triangles do not sample other secondary lights, as their bounces hit each other: so paths do not multiply in a shade.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};

use crate::light::{ChosenPart, PartAt, Receiver};
use crate::settings::LightSampling;
use crate::world::{Hit, Surface, World, interpolate};

/// A ray to a point of a secondary light.
#[derive(Clone, Copy)]
pub(crate) struct AimedRay {
    /// A ray with a unit direction and no end.
    pub ray: Ray,
    pub prim_id: u32,
    /// The reciprocal of its density per solid angle.
    pub inv_density: f32,
}

/// Samples a secondary light from a surface, by numbers in [0, 1): one for the light, and one for the point, with the
/// remainder of the first. `None` if that does not pay.
#[inline(always)]
pub(crate) fn aim(world: &World, surface: &Surface, receiver: &Receiver, (choice, v): (f64, f32)) -> Option<AimedRay> {
    let ChosenPart { part, probability, rest } = world.lights.lit.choose(receiver, choice)?;
    let point = TriangleWarp.map(Vec2::new(rest as f32, v));
    let end = interpolate(*part.corners(), [1.0 - point.x - point.y, point.x, point.y]);
    let way = end - surface.position;
    let squared = way.length_squared();
    let direction = way * squared.sqrt().recip();
    let cosine = part.light.normal.dot(direction).abs();
    if !part.may_reach(-direction, squared.sqrt()) {
        return None;
    }
    let inv_density = part.light.area * cosine / (squared * probability);
    let is_any = inv_density > 0.0 && inv_density.is_finite();
    // From where it leaves, beside the surface: otherwise it might pass a small triangle far away.
    let origin = surface.origin_towards(direction);
    is_any.then(|| AimedRay {
        ray: Ray::new(origin, (end - origin).normalize()),
        prim_id: part.cell.prim_id,
        inv_density,
    })
}

/// The secondary light that a ray has come to, and the distance: if it has hit glass, a lamp straight behind that.
#[inline(always)]
pub(crate) fn lit_at<'w>(world: &'w World, ray: &Ray, hit: &Hit) -> Option<(PartAt<'w>, f32)> {
    let lit = &world.lights.lit;
    let lamp = || {
        let (id, distance) = world.image_behind(ray, hit)?;
        Some((lit.at(id, Vec2::ZERO)?, distance))
    };
    lamp().or_else(|| lit.at(hit.prim_id, Vec2::new(hit.u, hit.v)).map(|at| (at, hit.t)))
}

/// The density per solid angle with which [`aim`] sends a ray of a unit vector from `receiver` to where it hits
/// something.
#[inline(always)]
pub(crate) fn aimed_density(world: &World, receiver: &Receiver, ray: &Ray, (at, distance): &(PartAt, f32)) -> f32 {
    let probability = world.lights.lit.probability(at, receiver);
    if probability == 0.0 || !at.part.may_reach(-ray.direction, *distance) {
        return 0.0;
    }
    let cosine = at.part.light.normal.dot(ray.direction).abs();
    probability * distance * distance / (at.part.light.area * cosine)
}

/// The factor on the throughput of such a path: `scattered` is `f cos θ`, and `bounce` the density of the surface's own
/// bounce in this direction.
pub(crate) fn aimed_weight(scattered: Vec3, inv_density: f32, bounce: f32) -> Vec3 {
    scattered * (inv_density * LightSampling::Mis.light_weight(inv_density, bounce))
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;
    use halfdome_kernel::sampling::warp::UniformSphere;

    use super::*;
    use crate::light::{Division, LitPart, Reach, SecondaryLights, TriangleLight, TrianglePart, area};
    use crate::scene::{CameraPose, Material, Mesh, Scene};
    use crate::world::TriangleRecord;

    /// A floor, and above it a tilted square of two triangles, at which paths aim.
    fn world() -> World {
        let floor = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let plate = [[-0.1, -0.1], [-0.1, 0.1], [0.1, 0.1], [0.1, -0.1]].map(|[x, y]| Vec3::new(x, y, 2.0 + 0.3 * x));
        let mesh = |positions: [Vec3; 4]| {
            let positions = positions.to_vec();
            Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
        };
        let camera = CameraPose { eye: Vec3::new(0.0, -3.0, 1.5), target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 };
        let mut world = World::new(Scene {
            meshes: vec![mesh(floor), mesh(plate)],
            materials: vec![Material::matte(Vec3::splat(0.5))],
            camera: Some(camera),
            ..Scene::default()
        })
        .unwrap();
        // One is lit as a whole, of the other each cell but the last.
        let division = |prim: u32| Division::Congruent { side: if prim == 2 { 1 } else { 3 } };
        let everywhere = (0..4096).map(|i| (UniformSphere.map(Stream::new(3, i, 0).uniform2(0)), f32::INFINITY));
        let reach = Reach::of(everywhere);
        let cells = [2, 3]
            .into_iter()
            .flat_map(|prim| division(prim).corners().into_iter().take(8).map(move |cell| (prim, cell)));
        let parts = cells.map(|(prim_id, places)| {
            let TriangleRecord { corners, normal, .. } = world.triangle_records()[prim_id as usize];
            let cell = TrianglePart { prim_id, places };
            let corners = cell.corners(&corners);
            let light = TriangleLight { corners, normal, radiance: 10.0, area: area(&corners), both_sides: true };
            LitPart { cell, light, reach: reach.clone() }
        });
        world.lights.lit = SecondaryLights::new(parts.collect(), division, 4);
        world.lights.lit.aim_from(0.2, 1.0, false);
        world
    }

    #[test]
    fn aimed_rays_have_the_density_that_weights_them() {
        let world = world();
        let (mut aimed_rays, mut missed) = (0, 0);
        for i in 0..2000 {
            let [x, y, a, b] = Stream::new(1, i, 0).uniform4(0);
            let surface = world.surface(i % 2, x.min(1.0 - y), y.min(0.9)).facing(Vec3::NEG_Z);
            let receiver = surface.receiver();
            let Some(aimed) = aim(&world, &surface, &receiver, (f64::from(a), b)) else { continue };
            let mut hits = [Hit::MISS];
            world.intersect_many(&[aimed.ray], &mut hits);
            // Nothing is in between, but a ray to the very border may pass it by rounding.
            if hits[0].prim_id != aimed.prim_id {
                missed += 1;
                continue;
            }
            let at = lit_at(&world, &aimed.ray, &hits[0]).unwrap();
            let density = aimed_density(&world, &receiver, &aimed.ray, &at);
            // What is seen edge-on turns with the place that it is seen from.
            let slack = 0.01 + 1e-8 / aimed.inv_density;
            assert!((density * aimed.inv_density - 1.0).abs() < slack, "{density} and {}", aimed.inv_density);
            aimed_rays += 1;
        }
        assert!(aimed_rays > 300 && missed <= 1, "{aimed_rays}, {missed}");
    }

    /// A distant small light causes the irradiance `L Ω cos θ`, which samples by the triangles' solid angle must find.
    #[test]
    fn aimed_rays_find_the_solid_angle() {
        let world = world();
        let surface = world.surface(0, 0.3, 0.3).facing(Vec3::NEG_Z);
        let receiver = surface.receiver();
        let mut sum = 0.0;
        const COUNT: u32 = 20_000;
        for i in 0..COUNT {
            let [a, b, c, _] = Stream::new(2, i, 0).uniform4(0);
            let choice = halfdome_kernel::sampling::unit_double(Vec2::new(a, b));
            sum += aim(&world, &surface, &receiver, (choice, c)).map_or(0.0, |aimed| f64::from(aimed.inv_density));
        }
        let parts = world.lights.lit.parts().iter();
        let expected: f64 = parts
            .map(|part| {
                let corners = part.corners().map(|p| (p - surface.position).as_dvec3());
                let [a, b, c] = corners.map(|p| p.normalize());
                2.0 * (a.dot(b.cross(c)).abs()).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
            })
            .sum();
        let found = sum / f64::from(COUNT);
        assert!((found / expected - 1.0).abs() < 0.02, "{found}, not {expected}");
    }

    #[test]
    fn a_cornell_box_has_no_lit_triangles() {
        let world = World::new(crate::scene::cornell_box()).unwrap();
        assert!(!world.lights.lit.has_any());
    }
}
