use std::f32::consts::{FRAC_1_PI, PI};

use halfdome_kernel::sampling::warp::{CosineHemisphere, UniformSphere, Warp};
use halfdome_kernel::sampling::{Frame, Pattern, Sampler, Stream};

use super::*;

/// Bounces by the cosine that find what `light` gives for their direction.
fn bounces(count: u32, normal: Vec3, light: impl Fn(Vec3) -> f32) -> Vec<GuideSample> {
    bounces_at(count, normal, |_, direction| light(direction))
}

/// Bounces by the cosine from a square of two by two around the origin, that find what `light` gives for their place
/// and direction.
fn bounces_at(count: u32, normal: Vec3, light: impl Fn(Vec3, Vec3) -> f32) -> Vec<GuideSample> {
    let frame = Frame::from_normal(normal);
    let bounce = |i| {
        let [x, y, a, b] = Stream::new(1, i, 0).uniform4(0);
        let direction = frame.to_world(CosineHemisphere.map(Vec2::new(a, b)));
        let density = direction.dot(normal).max(0.0) * FRAC_1_PI;
        let position = frame.to_world(Vec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, 0.0));
        GuideSample {
            position,
            normal,
            direction,
            light: light(position, direction),
            closure_density: density,
            share: 1.0,
        }
    };
    (0..count).map(bounce).filter(|sample| sample.light > 0.0 && sample.closure_density > 0.0).collect()
}

/// A cone of light around a direction.
fn cone(axis: Vec3) -> impl Fn(Vec3) -> f32 {
    move |direction| f32::from(direction.dot(axis) > 0.98)
}

const SIDES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

#[test]
fn sides_are_those_that_normals_face() {
    for (number, normal) in SIDES.into_iter().enumerate() {
        assert_eq!(usize::from(cells::side(normal)), number);
        let (along, _) = to_square(normal, number as u8);
        assert!(along.x > 0.999, "{normal} is the pole of its side, not {along}");
    }
}

#[test]
fn places_of_the_square_are_directions() {
    for side in 0..6 {
        for i in 0..10_000 {
            let direction = UniformSphere.map(Stream::new(2, i, 0).uniform2(0));
            let (place, per_angle) = to_square(direction, side);
            assert!((0.0..1.0).contains(&place.x) && (0.0..1.0).contains(&place.y), "{place}");
            // 1 / 4π on average.
            assert!((0.0624..=0.1251).contains(&per_angle), "{per_angle}");
            let back = directions::from_square(place, side);
            assert!(back.distance(direction) < 2e-3, "{direction} is {place} is {back}");
        }
    }
}

#[test]
fn densities_integrate_to_one_and_are_those_of_samples() {
    for (side, normal) in SIDES.into_iter().enumerate() {
        let axis = (normal + 0.7 * normal.any_orthonormal_vector()).normalize();
        let guide = Guide::learn(bounces(200_000, normal, cone(axis))).expect("a cone is worth a guide");
        let cell = guide.cell(normal.any_orthonormal_vector(), normal);
        assert!(cell.fraction > 0.5 && usize::from(cell.side) == side, "{cell:?}");
        let count = 1 << 18;
        let (mut integral, mut inside, mut expected) = (0.0, 0.0, 0.0);
        for i in 0..count {
            let u = Sampler::new(Pattern::Sobol, 0, 0, i).uniform2(0);
            let even = UniformSphere.map(u);
            let density = guide.density(&cell, even);
            integral += density * 4.0 * PI;
            expected += density * 4.0 * PI * cone(axis)(even);
            inside += cone(axis)(guide.sample(&cell, u));
        }
        let mean = |sum: f32| sum / count as f32;
        assert!((mean(integral) - 1.0).abs() < 0.02, "side {side}: {}", mean(integral));
        assert!((mean(inside) - mean(expected)).abs() < 0.02, "side {side}: {} {}", mean(inside), mean(expected));
        assert!(mean(inside) > 0.5, "side {side}: {} of the samples are in the light", mean(inside));
    }
}

#[test]
fn samples_have_a_density_in_every_leaf() {
    let guide = Guide::learn(bounces(100_000, Vec3::Z, cone(Vec3::Z))).unwrap();
    let cell = guide.cell(Vec3::ZERO, Vec3::Z);
    for i in 0..100_000 {
        let direction = guide.sample(&cell, Stream::new(4, i, 0).uniform2(0));
        assert!(direction.is_normalized() && guide.density(&cell, direction) > 0.0, "{direction}");
    }
}

#[test]
fn where_closures_do_as_well_nothing_is_guided() {
    assert!(Guide::learn(bounces(100_000, Vec3::Z, |_| 1.0)).is_none(), "an even sky");
    let noise = |direction: Vec3| (direction.x * 1e5).fract().abs().powi(4);
    assert!(Guide::learn(bounces(100_000, Vec3::Z, noise)).is_none(), "light at random");
    assert!(Guide::learn(Vec::new()).is_none(), "darkness");
}

#[test]
fn cells_know_their_own_place() {
    let axis = |x: f32| Vec3::new(0.6 * x.signum(), 0.8, 0.0);
    let samples = bounces_at(400_000, Vec3::Y, |position, direction| cone(axis(position.x))(direction));
    let guide = Guide::learn(samples).unwrap();
    for x in [-0.7, 0.7] {
        let cell = guide.cell(Vec3::new(x, 0.0, 0.1), Vec3::Y);
        let (here, there) = (guide.density(&cell, axis(x)), guide.density(&cell, axis(-x)));
        assert!(here > 20.0 * there, "at {x}: {here} and {there}");
    }
}
