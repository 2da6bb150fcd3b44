//! Triangles and rays for property tests: of any bits, of all scales, on grids.

use glam::Vec3;
use halfdome_kernel::{Ray, Triangle};
use proptest::collection::vec;
use proptest::prelude::*;

/// What coordinates are drawn from.
pub(crate) type Coordinate = BoxedStrategy<f32>;

pub(crate) fn raw() -> Coordinate {
    any::<u32>().prop_map(f32::from_bits).boxed()
}

/// Numbers of all sizes that coordinates may have, and a few that they may not.
fn scaled() -> Coordinate {
    (-1.0f32..1.0, -60i32..44).prop_map(|(mantissa, exponent)| mantissa * 2f32.powi(exponent)).boxed()
}

pub(crate) fn grid() -> Coordinate {
    (-2i8..=2).prop_map(f32::from).boxed()
}

pub(crate) fn coordinate() -> Coordinate {
    prop_oneof![1 => raw(), 3 => scaled(), 4 => grid(), 3 => -1.0f32..1.0].boxed()
}

fn vector(of: Coordinate) -> impl Strategy<Value = Vec3> {
    [of.clone(), of.clone(), of].prop_map(Vec3::from)
}

/// Triangles over a pool of points, so that they share corners and edges, and some are degenerate.
fn over_pool(of: Coordinate, most: usize) -> impl Strategy<Value = Vec<Triangle>> {
    vec(vector(of), 1..12).prop_flat_map(move |pool| {
        let size = pool.len();
        vec([0..size, 0..size, 0..size], 0..=most)
            .prop_map(move |all| all.into_iter().map(|corners| corners.map(|i| pool[i])).collect())
    })
}

fn interval() -> impl Strategy<Value = (f32, f32)> {
    prop_oneof![
        4 => Just((0.0, f32::INFINITY)),
        1 => Just((f32::NEG_INFINITY, f32::INFINITY)),
        2 => (-2.0f32..2.0, 0.0f32..4.0).prop_map(|(start, length)| (start, start + length)),
        1 => (raw(), raw()),
    ]
}

/// A ray: free, along an axis, or aimed at a combination of a triangle's corners with few different weights.
fn ray(of: Coordinate) -> impl Strategy<Value = Aim> {
    let axis = (0usize..3, any::<bool>()).prop_map(|(axis, back)| Vec3::AXES[axis] * if back { -1.0 } else { 1.0 });
    let direction = prop_oneof![2 => vector(of.clone()), 1 => axis.clone()];
    let weights = [0u8..3, 0u8..3, 0u8..3];
    let target = prop_oneof![2 => (any::<prop::sample::Index>(), weights).prop_map(Some), 1 => Just(None)];
    let along_axis = prop_oneof![2 => Just(None), 1 => axis.prop_map(Some)];
    (vector(of), direction, interval(), target, along_axis).prop_map(
        |(origin, direction, (t_min, t_max), target, along_axis)| Aim {
            ray: Ray { origin, t_min, direction, t_max },
            target,
            along_axis,
        },
    )
}

/// A ray that still has to be aimed at a triangle, if there is one.
#[derive(Clone, Debug)]
struct Aim {
    ray: Ray,
    target: Option<(prop::sample::Index, [u8; 3])>,
    along_axis: Option<Vec3>,
}

impl Aim {
    fn at(&self, triangles: &[Triangle]) -> Ray {
        let Some((index, weights)) = self.target.filter(|_| !triangles.is_empty()) else { return self.ray };
        let triangle = triangles[index.index(triangles.len())];
        let weights = weights.map(f32::from);
        let sum = weights.iter().sum::<f32>().max(1.0);
        let point = (triangle[0] * weights[0] + triangle[1] * weights[1] + triangle[2] * weights[2]) / sum;
        match self.along_axis {
            Some(axis) => Ray { origin: point - axis * 4.0, direction: axis, ..self.ray },
            None => Ray { direction: point - self.ray.origin, ..self.ray },
        }
    }
}

pub(crate) fn scene(of: Coordinate, most: usize) -> impl Strategy<Value = (Vec<Triangle>, Vec<Ray>)> {
    (over_pool(of.clone(), most), vec(ray(of), 1..20)).prop_map(|(triangles, aims)| {
        let rays = aims.iter().map(|aim| aim.at(&triangles)).collect();
        (triangles, rays)
    })
}
