//! The triangle test of one ray and one triangle: the definition of a hit, which all other code paths equal bit for
//! bit.

use glam::Vec3;

use super::setup::{MIN_COMPONENT, MIN_DETERMINANT, OWN_PAD, raise};
use super::{Hit, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, Ray, Triangle};

/// Where `ray` meets `triangle`, from either side, with `prim_id` 0; `None` if it does not within `t_min..=t_max`, or
/// if one of them is out of the [numeric limits](crate#numeric-limits).
///
/// Woop, Benthin and Wald 2013, with the deviations that the [module](super) explains.
pub fn intersect_triangle(ray: &Ray, triangle: &Triangle) -> Option<Hit> {
    intersect_side(ray, triangle).map(|(hit, _)| hit)
}

/// [`intersect_triangle`], and whether `ray` comes from the front: whether the edge functions' sum, which decides it
/// exactly, is positive.
pub(crate) fn intersect_side(ray: &Ray, triangle: &Triangle) -> Option<(Hit, bool)> {
    let d = ray.direction;
    let largest = d.abs().max_element();
    if !d.is_finite() || !(MIN_DIRECTION..=MAX_DIRECTION).contains(&largest) {
        return None;
    }
    let [a, b, c] = *triangle;
    if ![ray.origin, a, b, c].iter().all(|p| p.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()) {
        return None;
    }

    // The axis along which the ray runs fastest becomes z; x and y swap if it runs backwards, to keep the winding.
    let kz = (0..3).find(|&k| d[k].abs() == largest)?;
    let forward = d[kz] > 0.0;
    let (kx, ky) = if forward { ((kz + 1) % 3, (kz + 2) % 3) } else { ((kz + 2) % 3, (kz + 1) % 3) };

    // Vertices relative to the origin, then sheared.
    let [a, b, c] = [a, b, c].map(|p| p - ray.origin);
    let sz = 1.0 / d[kz];
    let (sx, sy) = (d[kx] * sz, d[ky] * sz);
    let shear = |p: Vec3| (p[kx] - sx * p[kz], p[ky] - sy * p[kz]);
    let ((ax, ay), (bx, by), (cx, cy)) = (shear(a), shear(b), shear(c));

    // Scaled barycentric coordinates: edge functions of the origin.
    let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let determinant = u + v + w;
    let (u, v, w, front) = if u == 0.0 || v == 0.0 || w == 0.0 || determinant.abs() < MIN_DETERMINANT {
        let [ax, ay, bx, by, cx, cy] = [ax, ay, bx, by, cx, cy].map(f64::from);
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        ((u / determinant) as f32, (v / determinant) as f32, (w / determinant) as f32, determinant > 0.0)
    } else {
        let inverse = 1.0 / determinant;
        (u * inverse, v * inverse, w * inverse, determinant > 0.0)
    };
    let (u, v, w) = refine([(ax, ay), (bx, by), (cx, cy)], [u, v, w]);
    // Which zero the terms add up to is up to their order: the positive one counts.
    let mut t = (u * a[kz] + v * b[kz] + w * c[kz]) * sz + 0.0;

    // The ray's interval in the triangle's widened box.
    let reach = |k: usize| a[k].abs().max(b[k].abs()).max(c[k].abs());
    let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
    for k in [kx, ky, kz] {
        let pad = (reach(k) + reach(kz)) * OWN_PAD;
        let (lower, upper) = (a[k].min(b[k]).min(c[k]) - pad, a[k].max(b[k]).max(c[k]) + pad);
        let inverse = 1.0 / raise(d[k], largest * MIN_COMPONENT);
        let (enter, leave) =
            if inverse < 0.0 { (upper * inverse, lower * inverse) } else { (lower * inverse, upper * inverse) };
        near = near.max(enter);
        far = far.min(leave);
    }
    // A bound that is a negative zero counts as zero.
    if t < near {
        t = near + 0.0;
    }
    if t > far {
        t = far + 0.0;
    }
    (near <= far && ray.t_min <= t && t <= ray.t_max).then(|| (Hit { t, u: unit(v), v: unit(w), prim_id: 0 }, front))
}

/// A weight in 0..=1, never a negative zero.
fn unit(weight: f32) -> f32 {
    weight.clamp(0.0, 1.0) + 0.0
}

/// Weights with which the mean of the 2D `corners` is nearer to the origin: it is moved along the longest edge. One may
/// be slightly below zero.
fn refine(corners: [(f32, f32); 3], weights: [f32; 3]) -> (f32, f32, f32) {
    let [(ax, ay), (bx, by), (cx, cy)] = corners;
    let [u, v, w] = weights;
    let (x, y) = (u * ax + v * bx + w * cx, u * ay + v * by + w * cy);
    let edge = |(px, py): (f32, f32), (qx, qy): (f32, f32)| (qx - px, qy - py);
    let edges = [edge((ax, ay), (bx, by)), edge((bx, by), (cx, cy)), edge((cx, cy), (ax, ay))];
    let length = edges.map(|(ex, ey)| ex * ex + ey * ey);
    let longest = if length[1] <= length[0] && length[2] <= length[0] {
        0
    } else if length[2] <= length[1] {
        1
    } else {
        2
    };
    let (ex, ey) = edges[longest];
    let shift = if length[longest] < MIN_DETERMINANT { 0.0 } else { (x * ex + y * ey) / length[longest] };
    let mut refined = [u, v, w];
    refined[longest] += shift;
    refined[(longest + 1) % 3] -= shift;
    refined.into()
}
