//! Single scenes with closed forms, for each term of the sums.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3, dvec2, dvec3};
use halfdome_kernel::irradiance::{Gather, Layout};
use halfdome_tests::polygon_light::{polygon, sphere};

use super::scene::{AnyLayout, Found, flat, gather, grey_or_nothing, hemicube, hit_quad, room, stratified};

/// The means of E, ∇_r and ∇_t of a channel over several jitters.
fn mean(layout: &dyn Layout, seeds: u64, scene: impl Fn(DVec3) -> Found) -> (f64, DVec2, DVec2) {
    let mut sum = (0.0, DVec2::ZERO, DVec2::ZERO);
    for seed in 0..seeds {
        let Gather { irradiance, rotational, translational, .. } = gather(layout, Some(seed), &scene);
        sum.0 += f64::from(irradiance.x) / seeds as f64;
        sum.1 += flat(rotational[0]) / seeds as f64;
        sum.2 += flat(translational[0]) / seeds as f64;
    }
    sum
}

/// Each layout at three resolutions, each twice as fine as the one before, with how many jitters to average.
fn layouts() -> [(&'static str, [AnyLayout; 3], u64); 2] {
    [
        ("strata", [stratified(20, 63), stratified(40, 126), stratified(80, 251)], 16),
        ("hemicube", [hemicube(32), hemicube(64), hemicube(128)], 1),
    ]
}

/// Relative errors of E, ∇_r and ∇_t of a scene are within bounds at the coarser two and the finest resolution. ∇_r is
/// left out if it is not given.
fn check(
    scene: impl Fn(DVec3) -> Found,
    (irradiance, rotational, translational): (f64, Option<DVec2>, DVec2),
    [coarse, fine]: [[f64; 3]; 2],
) {
    for (name, layouts, seeds) in layouts() {
        for (layout, bounds) in layouts.iter().zip([coarse, coarse, fine]) {
            let found = mean(&**layout, seeds, &scene);
            let errors = [
                (found.0 / irradiance - 1.0).abs(),
                rotational.map_or(0.0, |exact| (found.1 - exact).length() / exact.length()),
                (found.2 - translational).length() / translational.length(),
            ];
            println!("{name} of {}: {errors:.4?}", layout.cells());
            assert!(errors.into_iter().zip(bounds).all(|(error, bound)| error <= bound), "{errors:?}, {bounds:?}");
        }
    }
}

#[test]
fn a_furnace_has_no_gradient() {
    let inside = |d| room(d, dvec3(-0.2, -3.0, -1e-9), dvec3(5.0, 2.0, 1.5), |_, _, _| Vec3::ONE);
    for (name, layout) in [("strata", stratified(40, 126)), ("hemicube", hemicube(64))] {
        let gather = gather(&*layout, Some(3), inside);
        assert!((f64::from(gather.irradiance.x) / PI - 1.0).abs() < 1e-5, "{name}: {gather:?}");
        assert!(gather.translational.iter().all(|gradient| *gradient == Vec3::ZERO), "{name}: {gather:?}");
        assert!(gather.rotational.iter().all(|gradient| gradient.length() < 1e-5), "{name}: {gather:?}");
    }
}

#[test]
fn a_sphere_light() {
    let (centre, radius) = (dvec3(0.8, -0.5, 1.6), 0.5);
    let (irradiance, gradient) = sphere(centre, radius, DVec3::ZERO, DVec3::Z);
    let light = |d: DVec3| {
        let nearest = d.dot(centre);
        let half = radius * radius - (centre - d * nearest).length_squared();
        grey_or_nothing((half > 0.0 && nearest > 0.0).then(|| nearest - half.max(0.0).sqrt()), 1.0)
    };
    // V points at the centre, with E as its z. The hits beside the limb are nearer than it, hence the slow ∇_t.
    let turned = DVec3::Z.cross(centre * irradiance / centre.z).truncate();
    check(light, (irradiance, Some(turned), gradient.truncate()), [[0.02, 0.02, 0.15], [0.002, 0.002, 0.08]]);
}

#[test]
fn the_sky_over_a_wall() {
    let (a, height) = (1.0f64, 2.0f64);
    let hypotenuse = a.hypot(height);
    let wall = |d: DVec3| {
        let below = d.x < 0.0 && -d.z / d.x * a < height;
        if below { (Vec3::ZERO, -a / d.x) } else { (Vec3::ONE, f64::INFINITY) }
    };
    let (irradiance, slope) = (PI / 2.0 * (1.0 + a / hypotenuse), PI / 2.0 * height.powi(2) / hypotenuse.powi(3));
    check(wall, (irradiance, None, dvec2(slope, 0.0)), [[2e-3, 0.0, 0.1], [2e-4, 0.0, 0.025]]);
}

#[test]
fn an_occluder_before_an_emitter() {
    let scene = |d: DVec3| {
        if d.x / d.z < -0.3 {
            return (Vec3::ZERO, 1.0 / d.z);
        }
        grey_or_nothing(hit_quad(d, dvec3(-0.3, 0.0, 2.0), DVec3::X, DVec3::Y), 1.0)
    };
    check(scene, (0.52692, None, dvec2(0.38715, 0.0)), [[0.06, 0.0, 0.05], [0.015, 0.0, 0.01]]);
}

#[test]
fn a_rectangle_overhead() {
    // One of its edges is nearly above the receiver.
    let (centre, a, b) = (dvec3(1.04, 0.3, 1.0), DVec3::X, DVec3::Y);
    let exact = polygon(&[centre + a + b, centre - a + b, centre - a - b, centre + a - b], DVec3::ZERO, DVec3::Z);
    let light = |d| grey_or_nothing(hit_quad(d, centre, a, b), 1.0);
    check(light, (exact.irradiance, None, exact.gradient.truncate()), [[0.04, 0.0, 0.03], [0.01, 0.0, 0.02]]);
}

#[test]
fn a_ceiling_in_a_corner() {
    // Black walls meet it all around, so that depth is continuous across its edges.
    let (lower, upper) = (dvec3(-0.5, -0.6, -1e-9), dvec3(3.0, 2.0, 1.0));
    let corners = [(upper.x, upper.y), (lower.x, upper.y), (lower.x, lower.y), (upper.x, lower.y)];
    let exact = polygon(&corners.map(|(x, y)| dvec3(x, y, 1.0)), DVec3::ZERO, DVec3::Z);
    let shine = |_, axis, _| if axis == 2 { Vec3::ONE } else { Vec3::ZERO };
    let scene = |d| room(d, lower, upper, shine);
    check(scene, (exact.irradiance, None, exact.gradient.truncate()), [[0.02, 0.0, 0.05], [0.003, 0.0, 0.02]]);
}

#[test]
fn half_of_the_first_ring() {
    // Light in the cells of ring 0 with φ < π, at distance 1: the walls sum to 2 sin³ θ_1 along y.
    for (rings, sectors) in [(10, 64), (16, 128)] {
        let layout = stratified(rings, sectors);
        let mut radiance = vec![Vec3::ZERO; layout.cells()];
        radiance[..sectors as usize / 2].fill(Vec3::new(1.0, 2.0, 0.0));
        let found = layout.accumulate(&radiance, &vec![1.0; layout.cells()]).unwrap();
        let exact = 2.0 * (1.0 / f64::from(rings)).powf(1.5);
        assert!((flat(found.translational[0]) - dvec2(0.0, exact)).length() < 0.02 * exact, "{found:?} {exact}");
        assert_eq!(found.translational[1], 2.0 * found.translational[0]);
        assert_eq!(found.translational[2], Vec3::ZERO);
    }
}

#[test]
fn the_rotational_gradient_is_exact_for_lit_cells() {
    // The last two rings of 8 of 31 sectors: ∫ sin² θ dθ times ∫ φ̂ dφ = (cos φ, sin φ) between the borders.
    let layout = stratified(10, 31);
    let lit = |cell: usize| cell / 31 >= 8 && cell % 31 < 8;
    let radiance: Vec<Vec3> = (0..310).map(|cell| Vec3::splat(f32::from(u8::from(lit(cell))))).collect();
    let found = layout.accumulate(&radiance, &vec![1.0; 310]).unwrap();
    let border = 0.8f64.sqrt().asin();
    let zone = 0.5 * (PI / 2.0 - (border - border.sin() * border.cos()));
    let phi = 16.0 * PI / 31.0;
    let exact = zone * (dvec2(phi.cos(), phi.sin()) - dvec2(1.0, 0.0));
    assert!((flat(found.rotational[0]) - exact).length() < 1e-6, "{found:?} {exact}");
}
