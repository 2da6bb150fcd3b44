//! Several hundred random quads above the horizon, seen from both sides, against the exact polygon light.

use glam::DVec3;
use halfdome_kernel::irradiance::Layout;
use halfdome_tests::polygon_light::polygon;
use halfdome_tests::random::Pcg;

use super::scene::{flat, gather, grey_or_nothing, hemicube, hit_quad, stratified};

/// A parallelogram above the horizon: its centre and half-edges.
struct Quad {
    centre: DVec3,
    a: DVec3,
    b: DVec3,
}

impl Quad {
    fn random(random: &mut Pcg) -> Self {
        loop {
            let direction = random.on_sphere();
            let centre = direction * (1.0 + 2.0 * random.unit());
            let (a, b) = (random.in_cube(), random.in_cube());
            let quad = Self { centre, a, b };
            let above = quad.corners().iter().all(|corner| corner.z > 0.05);
            // Not edge on: of such a sliver the fewest cells see anything.
            let facing = a.cross(b).normalize().dot(centre.normalize()).abs();
            if above && facing > 0.3 && a.cross(b).length() > 0.3 {
                return quad;
            }
        }
    }

    fn corners(&self) -> [DVec3; 4] {
        let Self { centre, a, b } = *self;
        [centre + a + b, centre - a + b, centre - a - b, centre + a - b]
    }
}

/// The median and the 95th percentile.
fn quantiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_unstable_by(f64::total_cmp);
    [values[values.len() / 2], values[values.len() * 95 / 100]]
}

/// The quantiles of the relative errors of E, ∇_r and ∇_t over `count` quads, one in two of them wound the other way.
fn errors(layout: &dyn Layout, count: u64) -> [[f64; 2]; 3] {
    let mut random = Pcg::new(2);
    let mut errors: [Vec<f64>; 3] = Default::default();
    for seed in 0..count {
        let quad = Quad::random(&mut random);
        let gather = gather(layout, Some(seed), |d| grey_or_nothing(hit_quad(d, quad.centre, quad.a, quad.b), 1.0));
        let exact = polygon(&quad.corners(), DVec3::ZERO, DVec3::Z);
        // Whether the quad's front or its back is seen says the sign of the polygon's irradiance.
        let sign = exact.irradiance.signum();
        // Turning the normal about x or y by an angle is turning the light back: ∇_r = n × V, V of components E(axis).
        let along = |axis| sign * polygon(&quad.corners(), DVec3::ZERO, axis).irradiance;
        let vector = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
        let rotational = DVec3::Z.cross(vector).truncate();
        let translational = sign * exact.gradient.truncate();
        let irradiance = sign * exact.irradiance;
        errors[0].push((f64::from(gather.irradiance.x) - irradiance).abs() / irradiance);
        errors[1].push((flat(gather.rotational[1]) - rotational).length() / rotational.length());
        errors[2].push((flat(gather.translational[2]) - translational).length() / translational.length());
    }
    errors.map(quantiles)
}

#[test]
fn errors_are_small_and_fall_as_strata_double() {
    // Medians and 95th percentiles of the relative errors of E, ∇_r and ∇_t. Of the finest strata it takes more quads:
    // the percentile of ∇_r of 400 is anything from 1.0 to 1.4%, 1.2% in the mean.
    let bounds = [
        (20, 63, 400, [[0.03, 0.12], [0.04, 0.2], [0.13, 0.7]]),
        (40, 126, 400, [[0.008, 0.04], [0.014, 0.07], [0.05, 0.32]]),
        (80, 251, 400, [[0.003, 0.02], [0.005, 0.03], [0.03, 0.2]]),
        (128, 402, 1600, [[0.0012, 0.008], [0.002, 0.0125], [0.016, 0.11]]),
    ];
    for (rings, sectors, count, bounds) in bounds {
        check(&format!("{rings} x {sectors}"), errors(&*stratified(rings, sectors), count), bounds);
    }
}

#[test]
fn errors_are_small_and_fall_as_texels_double() {
    let bounds = [
        (20, [[0.03, 0.12], [0.04, 0.2], [0.13, 0.7]]),
        // About as many cells as 40 x 126 and as 128 x 402 strata, and the same bounds.
        (40, [[0.008, 0.04], [0.014, 0.07], [0.05, 0.32]]),
        (64, [[0.003, 0.02], [0.005, 0.03], [0.03, 0.2]]),
        (130, [[0.0012, 0.008], [0.002, 0.012], [0.016, 0.11]]),
    ];
    for (size, bounds) in bounds {
        check(&format!("hemicube of {size}"), errors(&*hemicube(size), 400), bounds);
    }
}

fn check(name: &str, errors: [[f64; 2]; 3], bounds: [[f64; 2]; 3]) {
    println!("{name}: {errors:.4?}");
    for (error, bound) in errors.into_iter().flatten().zip(bounds.into_iter().flatten()) {
        assert!(error <= bound, "{name}: {errors:.4?}, bounds {bounds:?}");
    }
}
