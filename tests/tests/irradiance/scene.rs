//! Shared code: scenes that answer rays by formula, and gathers of them.

use glam::{DVec2, DVec3, Vec2, Vec3};
use halfdome_kernel::irradiance::{Gather, Hemicube, Hessian, Layout, Stratified};
use halfdome_kernel::sampling::{Strata, Stream};

/// A layout that owns its table.
pub(crate) type AnyLayout = Box<dyn Layout>;

pub(crate) fn stratified(rings: u32, sectors: u32) -> AnyLayout {
    let strata = Strata::new(rings, sectors).unwrap();
    Box::new(Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap())
}

pub(crate) fn hemicube(size: u32) -> AnyLayout {
    Box::new(Hemicube::new(size, vec![0.0; Hemicube::table_len(size)]).unwrap())
}

/// What a ray finds: radiance, and the distance, infinite for a miss.
pub(crate) type Found = (Vec3, f64);

/// The local directions of a layout, jittered by a seed, or through the middles of the cells.
pub(crate) fn directions(layout: &dyn Layout, seed: Option<u64>) -> Vec<Vec3> {
    let mut directions = vec![Vec3::ZERO; layout.cells()];
    let mut jitter = |cell: usize| seed.map_or(Vec2::splat(0.5), |s| Stream::new(s, cell as u32, 0).uniform2(0));
    layout.directions(&mut jitter, &mut directions).unwrap();
    directions
}

/// Looks along all directions with the receiver at the origin and its normal z.
fn look(directions: &[Vec3], scene: impl Fn(DVec3) -> Found) -> (Vec<Vec3>, Vec<f32>) {
    directions.iter().map(|&d| scene(d.as_dvec3())).map(|(radiance, distance)| (radiance, distance as f32)).unzip()
}

pub(crate) fn gather(layout: &dyn Layout, seed: Option<u64>, scene: impl Fn(DVec3) -> Found) -> Gather {
    let (radiance, distance) = look(&directions(layout, seed), scene);
    layout.accumulate(&radiance, &distance).unwrap()
}

pub(crate) fn gather_hessian(layout: &dyn Layout, seed: Option<u64>, scene: impl Fn(DVec3) -> Found) -> Hessian {
    let directions = directions(layout, seed);
    let (radiance, distance) = look(&directions, scene);
    layout.hessian(&directions, &radiance, &distance).unwrap()
}

/// The distance from the origin along `d` to the parallelogram about `centre` with the half-edges `a` and `b`.
pub(crate) fn hit_quad(d: DVec3, centre: DVec3, a: DVec3, b: DVec3) -> Option<f64> {
    let normal = a.cross(b);
    let distance = centre.dot(normal) / d.dot(normal);
    let offset = d * distance - centre;
    let u = offset.cross(b).dot(normal) / normal.length_squared();
    let v = a.cross(offset).dot(normal) / normal.length_squared();
    (distance > 0.0 && u.abs() <= 1.0 && v.abs() <= 1.0).then_some(distance)
}

/// A hit at the distance to a quad of this radiance, or a black miss.
pub(crate) fn grey_or_nothing(hit: Option<f64>, radiance: f32) -> Found {
    hit.map_or((Vec3::ZERO, f64::INFINITY), |distance| (Vec3::splat(radiance), distance))
}

/// The walls of a box around the origin, from `lower` to `upper`; `radiance(point, axis, is_upper)`.
pub(crate) fn room(d: DVec3, lower: DVec3, upper: DVec3, radiance: impl Fn(DVec3, usize, bool) -> Vec3) -> Found {
    let planes = [0, 1, 2].map(|axis| (if d[axis] > 0.0 { upper[axis] } else { lower[axis] }) / d[axis]);
    let axis = (0..3).filter(|&axis| d[axis] != 0.0).min_by(|&a, &b| planes[a].total_cmp(&planes[b])).unwrap();
    (radiance(d * planes[axis], axis, d[axis] > 0.0), planes[axis])
}

/// The part in the tangent plane of a channel's gradient.
pub(crate) fn flat(gradient: Vec3) -> DVec2 {
    gradient.as_dvec3().truncate()
}
