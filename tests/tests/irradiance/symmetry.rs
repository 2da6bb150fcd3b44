//! Invariance under the azimuth, units of length and of light, and the position of the gather.

use glam::{DMat3, DVec3, Vec3, dvec3};
use halfdome_kernel::sampling::Frame;
use halfdome_tests::polygon_light::polygon;

use super::scene::{Found, gather, gather_hessian, grey_or_nothing, hemicube, hit_quad, stratified};

/// A light with an edge on φ = 0, an occluder before it, and sky.
fn scene(d: DVec3) -> Found {
    if hit_quad(d, dvec3(0.2, 0.4, 0.7), DVec3::X * 0.1, DVec3::Y * 0.2).is_some() {
        return (Vec3::new(0.0, 0.1, 0.0), 0.7 / d.z);
    }
    let light = hit_quad(d, dvec3(1.0, 1.0, 1.5), DVec3::X, DVec3::Y);
    light.map_or((Vec3::new(0.1, 0.2, 0.3), f64::INFINITY), |t| (Vec3::new(3.0, 2.0, 1.0), t))
}

#[test]
fn turning_by_a_sector_turns_the_gradients() {
    let layout = stratified(20, 64);
    let (still, angle) = (gather(&*layout, None, scene), std::f64::consts::TAU / 64.0);
    for turns in [1, 2, 33, 63] {
        let turn = DMat3::from_rotation_z(angle * f64::from(turns));
        let turned = gather(&*layout, None, |d| scene(turn.transpose() * d));
        for channel in 0..3 {
            for (still, turned) in [
                (still.rotational[channel], turned.rotational[channel]),
                (still.translational[channel], turned.translational[channel]),
            ] {
                let expected = (turn * still.as_dvec3()).as_vec3();
                assert!((turned - expected).length() < 1e-5 * expected.length().max(1.0), "{turned} {expected}");
            }
        }
        assert!((turned.irradiance - still.irradiance).length() < 1e-5);
    }
}

#[test]
fn a_quarter_turn_of_a_hemicube_turns_all() {
    let layout = hemicube(16);
    let (still, hessian) = (gather(&*layout, None, scene), gather_hessian(&*layout, None, scene));
    let turn = |d: DVec3| dvec3(d.y, -d.x, d.z);
    let turned = gather(&*layout, None, |d| scene(turn(d)));
    for channel in 0..3 {
        for (still, turned) in [
            (still.rotational[channel], turned.rotational[channel]),
            (still.translational[channel], turned.translational[channel]),
        ] {
            assert!((turned - Vec3::new(-still.y, still.x, 0.0)).length() < 1e-5, "{turned} {still}");
        }
    }
    let turned = gather_hessian(&*layout, None, |d| scene(turn(d)));
    // The diagonals of quads turn with it, so that only about the same triangles remain.
    let size = hessian.xx.abs() + hessian.yy.abs();
    assert!((turned.xx - hessian.yy).abs() + (turned.xy + hessian.xy).abs() < 0.2 * size, "{turned:?} {hessian:?}");
}

#[test]
fn scales_of_length_and_light_scale_the_results() {
    for layout in [stratified(10, 31), hemicube(8)] {
        let (unit, unit_hessian) = (gather(&*layout, Some(5), scene), gather_hessian(&*layout, Some(5), scene));
        for (length, light) in [(1e3f32, 1e-6f32), (1e-3, 1e6)] {
            let scaled = |d| {
                let (radiance, distance) = scene(d);
                (radiance * light, distance * f64::from(length))
            };
            let close = |a: f32, b: f32| assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
            let found = gather(&*layout, Some(5), scaled);
            close(found.harmonic_mean_distance, length * unit.harmonic_mean_distance);
            close(found.minimum_distance, length * unit.minimum_distance);
            for channel in 0..3 {
                close(found.irradiance[channel], light * unit.irradiance[channel]);
                close(found.rotational[channel].length(), light * unit.rotational[channel].length());
                close(found.translational[channel].length(), light / length * unit.translational[channel].length());
            }
            let hessian = gather_hessian(&*layout, Some(5), scaled);
            close(hessian.xx, light / length / length * unit_hessian.xx);
            close(hessian.yy, light / length / length * unit_hessian.yy);
            // The bound of an integral over an area scales with it; then the radii scale as lengths do.
            let (radii, unit_radii) = (hessian.radii(0.1 * length * length).radii, unit_hessian.radii(0.1).radii);
            close(radii[0], length * unit_radii[0]);
            close(radii[1], length * unit_radii[1]);
        }
    }
}

#[test]
fn extrapolation_follows_the_exact_irradiance_in_the_world() {
    // A light in the world, and a record on a slanted surface.
    let (place, normal) = (dvec3(3.0, -2.0, 1.0), dvec3(0.3, -0.8, 0.4).normalize());
    let frame = Frame::from_normal(normal.as_vec3());
    let world = |v: DVec3| frame.to_world(v.as_vec3()).as_dvec3();
    let (centre, a, b) = (world(dvec3(1.0, 0.5, 1.5)), world(dvec3(0.8, 0.0, 0.3)), world(dvec3(0.0, 0.9, 0.1)));
    let corners = [centre + a + b, centre - a + b, centre - a - b, centre + a - b].map(|corner| place + corner);
    let exact = |x, n| polygon(&corners, x, n).irradiance.abs();
    let found = gather(&*stratified(128, 402), Some(1), |d| grey_or_nothing(hit_quad(world(d), centre, a, b), 1.0));
    let record = found.to_world(&frame);
    for (x, y, lean_x, lean_y) in
        [(0.02, 0.0, 0.0, 0.0), (0.0, 0.02, 0.0, 0.0), (0.0, 0.0, 0.02, 0.0), (0.0, 0.0, 0.0, 0.02)]
    {
        let at = |sign: f64| {
            let displacement = world(sign * dvec3(x, y, 0.0));
            let leaning = world(dvec3(sign * lean_x, sign * lean_y, 1.0)).normalize();
            let (extrapolated, clamped) =
                record.extrapolate(displacement.as_vec3(), normal.as_vec3(), leaning.as_vec3());
            assert!(!clamped);
            (f64::from(extrapolated.y), exact(place + displacement, leaning))
        };
        let ((found, expected), (found_back, expected_back)) = (at(1.0), at(-1.0));
        let (found, expected) = (found - found_back, expected - expected_back);
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }
}

#[test]
fn negative_extrapolations_are_clamped_and_told() {
    let lit_from_one_side = |d: DVec3| grey_or_nothing(hit_quad(d, dvec3(2.0, 0.0, 1.0), DVec3::X, DVec3::Y), 1.0);
    let mut found = gather(&*stratified(20, 63), Some(1), lit_from_one_side);
    let slope = found.translational[0].x;
    assert!(slope > 0.0);
    let (darker, clamped) = found.extrapolate(Vec3::X * -2.0 * found.irradiance.x / slope, Vec3::Z, Vec3::Z);
    assert_eq!((darker, clamped), (Vec3::ZERO, true));
    // A channel without a gradient keeps its irradiance.
    found.translational[2] = Vec3::ZERO;
    let (darker, clamped) = found.extrapolate(Vec3::X * -2.0 * found.irradiance.x / slope, Vec3::Z, Vec3::Z);
    assert_eq!((darker, clamped), (Vec3::new(0.0, 0.0, found.irradiance.z), true));
    assert_eq!(found.extrapolate(Vec3::ZERO, Vec3::Z, Vec3::Z), (found.irradiance, false));
}
