//! The six faces of a cube, as KTX2, Vulkan and Direct3D order and turn them.
//!
//! A face is a square at distance 1 from the origin. Its coordinates run from -1 to 1, `u` to the right and `v` down as
//! the face is stored. Looked at from the origin with +y up, the faces are pictures that are not mirrored, if +z is in
//! front and +x on the right: the space is left-handed.
//!
//! Source: "Vulkan Specification", version 1.3, section 16.5.4 (cube map face selection).

use glam::DVec3;

use crate::settings::named;

/// A face of a cube map, named by its axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// +x.
    PositiveX,
    /// -x.
    NegativeX,
    /// +y.
    PositiveY,
    /// -y.
    NegativeY,
    /// +z.
    PositiveZ,
    /// -z.
    NegativeZ,
}

named!(Face: PositiveX = "px", NegativeX = "nx", PositiveY = "py", NegativeY = "ny", PositiveZ = "pz", NegativeZ = "nz");

impl Face {
    /// The middle of the face, and the steps that `u` and `v` stand for.
    fn axes(self) -> [DVec3; 3] {
        match self {
            Self::PositiveX => [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
            Self::NegativeX => [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y],
            Self::PositiveY => [DVec3::Y, DVec3::X, DVec3::Z],
            Self::NegativeY => [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
            Self::PositiveZ => [DVec3::Z, DVec3::X, DVec3::NEG_Y],
            Self::NegativeZ => [DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y],
        }
    }

    /// The point of the face at these coordinates, in the cube's space. Points that two faces share are equal bit for
    /// bit.
    pub(crate) fn point(self, u: f64, v: f64) -> DVec3 {
        let [middle, right, down] = self.axes();
        // Adding 0 makes -0 positive.
        middle + right * u + down * v + DVec3::ZERO
    }

    /// The face's coordinates of a direction in the cube's space; `None` if it points away from the face.
    pub(crate) fn coordinates(self, direction: DVec3) -> Option<[f64; 2]> {
        let [middle, right, down] = self.axes();
        let depth = direction.dot(middle);
        (depth > 0.0).then(|| [direction.dot(right) / depth, direction.dot(down) / depth])
    }

    /// The face through which a direction leaves the cube; of two at an edge, the first.
    pub fn of(direction: DVec3) -> Self {
        let deepest = direction.abs().max_element();
        let is_deepest = |face: &Self| direction.dot(face.axes()[0]) == deepest;
        Self::ALL.into_iter().find(is_deepest).unwrap_or(Self::PositiveX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_and_coordinates_are_inverse() {
        for face in Face::ALL {
            for (u, v) in [(0.0, 0.0), (0.5, -0.25), (-0.9, 0.75)] {
                let point = face.point(u, v);
                assert_eq!(Face::of(point), face);
                assert_eq!(face.coordinates(point * 3.0), Some([u, v]));
            }
        }
        assert_eq!(Face::PositiveX.coordinates(DVec3::NEG_X), None);
    }

    /// The table of the specification: s grows along rx = -z for the face +x, and so on; t always along -y but at the
    /// poles.
    #[test]
    fn faces_are_turned_as_the_specification_says() {
        let corner = |face: Face| face.point(1.0, 1.0).to_array();
        let expected = [
            [1.0, -1.0, -1.0],
            [-1.0, -1.0, 1.0],
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [1.0, -1.0, 1.0],
            [-1.0, -1.0, -1.0],
        ];
        assert_eq!(Face::ALL.map(corner), expected);
    }
}
