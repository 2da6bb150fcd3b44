//! Light from a chosen point of a surface, as for a light sample, for sources that cells of the hemisphere hit too
//! rarely.
//!
//! With `d` the vector to the point, `r` its length, `n` the record's normal and `m` that of the surface there, a patch
//! of it causes the irradiance `e ∝ (n·d) (-m·d) / r⁴`. Its derivatives with respect to the record's place, along the
//! tangent plane, and with respect to the normal are
//!
//! ```text
//! ∇_t = e (m/(-m·d) + 4 d/r²)
//! H   = e (4 (m dᵀ + d mᵀ)/(-m·d r²) - 4 I/r² + 24 d dᵀ/r⁴)
//! ∇_r = e (n × d)/(n·d)
//! ```
//!
//! Visibility between the record and the point is taken as constant: the movement of shadows is ignored.

use glam::Vec3;

use super::{Gather, Hessian, LUMINANCE};

/// A point of a surface that lights a record, in the record's local coordinates, whose normal is z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSource {
    /// From the record to the point, in world units, z > 0.
    pub to_point: Vec3,
    /// The unit normal of the surface there, on the side that faces the record.
    pub normal: Vec3,
    /// The point's contribution to the irradiance, W/m².
    pub irradiance: Vec3,
}

impl PointSource {
    /// `-m·d`, and not so small that a quotient overflows: a grazing patch adds next to nothing.
    fn height(&self) -> f32 {
        (-self.normal.dot(self.to_point)).max(1e-4 * self.to_point.length())
    }
}

impl Gather {
    /// Adds a point's irradiance and gradients to those of a gather in local coordinates; distances and standard_error
    /// stay.
    pub fn add_source(&mut self, source: &PointSource) {
        let PointSource { to_point, normal, irradiance } = *source;
        let across = normal / source.height() + to_point * (4.0 / to_point.length_squared());
        let turn = Vec3::Z.cross(to_point) / to_point.z.max(1e-4 * to_point.length());
        self.irradiance += irradiance;
        for channel in 0..3 {
            self.translational[channel] += irradiance[channel] * across.with_z(0.0);
            self.rotational[channel] += irradiance[channel] * turn;
        }
    }
}

impl Hessian {
    /// Adds a point's second derivatives.
    pub fn add_source(&mut self, source: &PointSource) {
        let PointSource { to_point: d, normal: m, irradiance } = *source;
        let light = LUMINANCE.dot(irradiance);
        let (near, lean) = (1.0 / d.length_squared(), 4.0 / (source.height() * d.length_squared()));
        let (even, far) = (4.0 * near, 24.0 * near * near);
        self.xx += light * (2.0 * lean * m.x * d.x - even + far * d.x * d.x);
        self.xy += light * (lean * (m.x * d.y + m.y * d.x) + far * d.x * d.y);
        self.yy += light * (2.0 * lean * m.y * d.y - even + far * d.y * d.y);
        self.irradiance += light;
    }
}
