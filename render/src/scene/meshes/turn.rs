//! Transforms of normals and tangents.
//!
//! Normals are transformed by the inverse transpose. That is the matrix of cofactors over the determinant, and as
//! normals become unit vectors its sign suffices: `M⁻ᵀ n ∥ sign(det M) cof(M) n`. So normals are defined for transforms
//! that flatten, too.

use glam::{DMat3, Mat3, Vec3, Vec4};

/// The directions of normals that `linear` takes along, but for their length.
pub(super) fn normal_matrix(linear: DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * if linear.determinant() < 0.0 { -1.0 } else { 1.0 }
}

/// The rotation of directions on surfaces by an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    linear: Mat3,
    normals: Mat3,
    side: f32,
}

impl Turn {
    /// The turn of a transform with this linear part.
    pub(crate) fn new(linear: Mat3) -> Self {
        let normals = normal_matrix(linear.as_dmat3()).as_mat3();
        Self { linear, normals, side: if linear.determinant() < 0.0 { -1.0 } else { 1.0 } }
    }

    /// The turn after a transform with this linear part.
    pub(super) fn after(&self, linear: Mat3) -> Self {
        Self::new(self.linear * linear)
    }

    /// The normal that is turned to this one, as long.
    pub(super) fn normal_before(&self, normal: Vec3) -> Vec3 {
        (self.linear.transpose() * normal).normalize_or_zero() * normal.length()
    }

    /// A direction across the surface, with its length.
    pub(crate) fn vector(&self, vector: Vec3) -> Vec3 {
        self.linear * vector
    }

    /// A normal, as long as before.
    pub(crate) fn normal(&self, normal: Vec3) -> Vec3 {
        (self.normals * normal).normalize_or_zero() * normal.length()
    }

    /// A normal of another length: a linear function.
    pub(crate) fn unscaled_normal(&self, normal: Vec3) -> Vec3 {
        self.normals * normal
    }

    /// A tangent, as long as before, with the sign of its bitangent.
    pub(crate) fn tangent(&self, tangent: Vec4) -> Vec4 {
        let along = (self.linear * tangent.truncate()).normalize_or_zero() * tangent.truncate().length();
        along.extend(tangent.w * self.side)
    }
}
