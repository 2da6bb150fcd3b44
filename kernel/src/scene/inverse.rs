//! Inverses of affine transforms in `f64`, and bounds of their norms between two transforms.
//!
//! By cofactors, `M⁻¹ = adj M / det M`; norms are the greatest sum of absolute values along a row.

use glam::{Affine3A, DMat3, DVec3, Vec3};

use crate::geometry::{Ray, RayPacket};

/// The greatest `‖M‖ ‖M⁻¹‖`: about the ratio of the longest to the shortest image of a unit vector.
pub const MAX_CONDITION: f64 = 65536.0;

/// The inverse of a matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inverse(DMat3);

impl Inverse {
    /// `None` if the matrix has no inverse.
    pub(super) fn new(linear: DMat3) -> Option<Self> {
        let [a, b, c] = linear.to_cols_array_2d().map(DVec3::from_array);
        let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
        let determinant = dot(a, bc);
        let inverse = DMat3::from_cols(bc / determinant, ca / determinant, ab / determinant).transpose();
        (determinant != 0.0 && inverse.is_finite()).then_some(Self(inverse))
    }

    /// The ray in the space of an item whose transform has this inverse and this translation.
    pub(super) fn ray(&self, translation: DVec3, ray: &Ray) -> Ray {
        let origin = self.rotate(ray.origin.as_dvec3() - translation);
        Ray { origin: origin.as_vec3(), direction: self.rotate(ray.direction.as_dvec3()).as_vec3(), ..*ray }
    }

    /// Sets origins and directions to those of a packet in the item's space, each as of [`ray`](Self::ray).
    #[inline(always)]
    pub(super) fn packet<const N: usize>(&self, translation: DVec3, rays: &RayPacket<N>, local: &mut RayPacket<N>) {
        let ([x, y, z], [tx, ty, tz]) = (self.0.to_cols_array_2d(), translation.to_array());
        let product = |k: usize, [a, b, c]: [f64; 3]| (x[k] * a + y[k] * b + z[k] * c) as f32;
        let ([ox, oy, oz], [dx, dy, dz]) = (&rays.origin, &rays.direction);
        for k in 0..3 {
            for lane in 0..N {
                let from = [f64::from(ox[lane]) - tx, f64::from(oy[lane]) - ty, f64::from(oz[lane]) - tz];
                local.origin[k][lane] = product(k, from);
                local.direction[k][lane] = product(k, [dx[lane].into(), dy[lane].into(), dz[lane].into()]);
            }
        }
    }

    /// The norm of the inverse matrix.
    pub(super) fn norm(&self) -> f64 {
        norm(&self.0)
    }

    fn rotate(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.0.to_cols_array_2d().map(DVec3::from_array);
        x * v.x + y * v.y + z * v.z
    }
}

// Written out, as these decide where hits are: the same operations everywhere.
fn cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// The matrix of a transform.
pub(super) fn linear(transform: &Affine3A) -> DMat3 {
    let [x, y, z] = transform.matrix3.to_cols_array_2d().map(|c| Vec3::from_array(c).as_dvec3());
    DMat3::from_cols(x, y, z)
}

/// The translation of a transform.
pub(super) fn translation(transform: &Affine3A) -> DVec3 {
    Vec3::from(transform.translation).as_dvec3()
}

/// Sums of absolute values along the rows.
pub(super) fn row_sums(matrix: &DMat3) -> DVec3 {
    let [x, y, z] = matrix.to_cols_array_2d().map(DVec3::from_array);
    x.abs() + y.abs() + z.abs()
}

/// The greatest sum of absolute values along a row.
pub(super) fn norm(matrix: &DMat3) -> f64 {
    row_sums(matrix).max_element()
}

/// A bound of the inverse's norm during the interpolation between two matrices; `None` if the condition gets too large.
///
/// If `A` is the inverse of `M` and `h ‖A D‖ <= 1/2`, then that of `M + h D` has at most twice the norm of `A`.
pub(super) fn inverse_norm_between(from: &DMat3, to: &DMat3) -> Option<f64> {
    let change = *to - *from;
    let size = norm(from).max(norm(to));
    let (mut start, mut length, mut largest) = (0.0, 1.0, 0.0f64);
    while start < 1.0 {
        let middle = *from + change * (start + 0.5 * length);
        let Inverse(inverse) = Inverse::new(middle)?;
        let step = 0.5 * length * norm(&(inverse * change));
        let bound = norm(&inverse) / (1.0 - step);
        if norm(&inverse) * size > MAX_CONDITION {
            return None;
        }
        if step <= 0.5 && bound * size <= MAX_CONDITION {
            largest = largest.max(bound);
            start += length;
            length = (2.0 * length).min(1.0 - start);
        } else {
            length *= 0.5;
            // Shorter than any fraction of time that matters: too near to singular.
            if length < 1e-9 {
                return None;
            }
        }
    }
    Some(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_norm_on_the_way_is_a_bound_that_is_not_wasteful() {
        let from = DMat3::IDENTITY;
        let to = |angle: f64| DMat3::from_rotation_y(angle) * DMat3::from_diagonal(DVec3::new(2.0, 1.0, 0.5));
        // The determinant in x and z is negative halfway.
        assert_eq!(inverse_norm_between(&from, &to(3.0)), None);
        for angle in [0.0, 0.5, 1.5, 2.0] {
            let to = to(angle);
            let bound = inverse_norm_between(&from, &to).unwrap();
            let most = (0..=10_000)
                .map(|i| norm(&Inverse::new(from + (to - from) * (i as f64 * 1e-4)).unwrap().0))
                .fold(0.0, f64::max);
            assert!(most <= bound * (1.0 + 1e-12) && bound <= 4.0 * most, "{angle}: {most} {bound}");
        }
    }
}
