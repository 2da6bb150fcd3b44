//! The lookup of engines in a cube map for a direction of the world.

use glam::DVec3;

pub use crate::camera::Face;
use crate::settings::named;

/// The lookup direction of an engine for a direction of its right-handed world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// `(x, y, -z)`, as Bevy does: the face +z shows what is in front, at -z.
    Bevy,
    /// `(-x, y, z)`, as three.js does: the face -z shows what is in front.
    Three,
    /// `(x, y, z)`: seen from within, all faces are mirrored.
    World,
}

named!(Axes: Bevy = "bevy", Three = "three", World = "world");

impl Axes {
    /// The direction in the world that a direction of the cube's space stands for; and the other way around.
    pub fn swap(self, direction: DVec3) -> DVec3 {
        match self {
            Self::Bevy => direction * DVec3::new(1.0, 1.0, -1.0),
            Self::Three => direction * DVec3::new(-1.0, 1.0, 1.0),
            Self::World => direction,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_front_and_to_the_right_is_so_on_the_face() {
        let (front, right) = (DVec3::NEG_Z, DVec3::X);
        for (axes, face) in [(Axes::Bevy, Face::PositiveZ), (Axes::Three, Face::NegativeZ)] {
            assert_eq!(Face::of(axes.swap(front)), face);
            let [u, v] = face.coordinates(axes.swap(front + 0.5 * right)).unwrap();
            assert_eq!((u, v), (0.5, 0.0), "{axes:?} is not mirrored");
            assert_eq!(axes.swap(axes.swap(DVec3::new(1.0, 2.0, 3.0))), DVec3::new(1.0, 2.0, 3.0));
        }
    }
}
