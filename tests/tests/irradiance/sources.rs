//! Points that were chosen on a light against the exact derivatives of the whole light.

use glam::{DVec3, Vec3, dvec3};
use halfdome_kernel::irradiance::{Gather, Hessian, PointSource};
use halfdome_tests::polygon_light::polygon;

/// The light of unit radiance of a parallelogram at `corner` with these sides, as points of it.
fn points([corner, side, other]: [DVec3; 3]) -> impl Iterator<Item = PointSource> {
    const STEPS: u32 = 64;
    let normal = side.cross(other);
    let patch = normal.length() / f64::from(STEPS * STEPS);
    let normal = normal.normalize();
    let normal = if normal.dot(corner) < 0.0 { normal } else { -normal };
    (0..STEPS * STEPS).map(move |i| {
        let [u, v] = [i % STEPS, i / STEPS].map(|i| (f64::from(i) + 0.5) / f64::from(STEPS));
        let way = corner + side * u + other * v;
        let irradiance = way.z * -normal.dot(way) / way.length_squared().powi(2) * patch;
        let irradiance = Vec3::new(1.0, 2.0, 0.5) * irradiance as f32;
        PointSource { to_point: way.as_vec3(), normal: normal.as_vec3(), irradiance }
    })
}

#[test]
fn points_of_a_light_have_its_derivatives() {
    for corners in [
        [dvec3(-0.3, 0.2, 1.0), dvec3(0.6, 0.1, 0.0), dvec3(0.0, 0.5, 0.3)],
        [dvec3(1.0, -0.4, 0.2), dvec3(0.0, 0.9, 0.0), dvec3(0.2, 0.0, 0.8)],
        [dvec3(-3.0, -2.0, 0.5), dvec3(0.3, -0.3, 0.1), dvec3(0.1, 0.2, 0.4)],
    ] {
        let mut gather = Gather {
            irradiance: Vec3::ZERO,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::ZERO; 3],
            harmonic_mean_distance: f32::INFINITY,
            minimum_distance: f32::INFINITY,
            standard_error: 0.0,
        };
        let mut hessian = Hessian { xx: 0.0, xy: 0.0, yy: 0.0, irradiance: 0.0 };
        for source in points(corners) {
            gather.add_source(&source);
            hessian.add_source(&source);
        }
        let [corner, side, other] = corners;
        let loop_of = [corner, corner + side, corner + side + other, corner + other];
        let at = |normal: DVec3| {
            let found = polygon(&loop_of, DVec3::ZERO, normal);
            let sign = found.irradiance.signum();
            (found.irradiance * sign, found.gradient * sign, found.hessian * sign)
        };
        let (irradiance, gradient, second) = at(DVec3::Z);
        let close = |found: f32, expected: f64, scale: f64, what: &str| {
            assert!((f64::from(found) - expected).abs() < 2e-3 * scale, "{what}: {found}, not {expected}");
        };
        for (channel, part) in [(0, 1.0), (1, 2.0), (2, 0.5)] {
            close(gather.irradiance[channel], part * irradiance, part * irradiance, "E");
            let found = gather.translational[channel];
            let steepest = part * gradient.length();
            close(found.x, part * gradient.x, steepest, "x");
            close(found.y, part * gradient.y, steepest, "y");
            // E of a leaning normal, by its rotational gradient: E(n) = E + (z × n)·∇_r.
            for lean in [dvec3(1e-3, 0.0, 1.0), dvec3(0.0, 1e-3, 1.0)] {
                let lean = lean.normalize();
                let turned = Vec3::Z.cross(lean.as_vec3()).dot(gather.rotational[channel]);
                close(turned, part * (at(lean).0 - irradiance), 1e-3 * part * irradiance, "turned");
            }
        }
        let light = f64::from(hessian.irradiance) / irradiance;
        assert!((light - (0.2126 + 2.0 * 0.7152 + 0.5 * 0.0722)).abs() < 2e-3);
        let scale = light * second.x_axis.length().max(second.y_axis.length());
        close(hessian.xx, light * second.x_axis.x, scale, "xx");
        close(hessian.xy, light * second.x_axis.y, scale, "xy");
        close(hessian.yy, light * second.y_axis.y, scale, "yy");
    }
}
