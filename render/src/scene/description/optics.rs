//! A camera's optics, without its pose: the mapping from points of the film to rays.
//!
//! Lengths are in the units of the scene, angles in degrees.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::settings::named;

/// The optics of a camera. The default is a pinhole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Optics {
    /// The mapping from film points to rays.
    pub projection: Projection,
    /// The lens in place of a pinhole; only perspective and orthographic cameras have one.
    pub lens: Option<Lens>,
    /// How far the film is shifted to the right and up, in parts of its longer side; of the same cameras.
    pub shift: Vec2,
    /// Nothing is seen before the first and beyond the second distance: along the view for perspective and orthographic
    /// cameras, from the eye for others.
    pub clip: Clip,
}

/// The mapping from film points to rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Projection {
    /// Through one point, onto a plane; the pose has the field of view.
    #[default]
    Perspective,
    /// Parallel rays, from the plane of the eye on.
    Orthographic {
        /// The height of the view.
        height: f32,
    },
    /// All directions, equirectangular: the view is in the middle, up is the top row, right the right half.
    Panorama {
        /// The distance of the eyes, of a picture for two: the upper half for the left one, the lower for the right.
        eye_distance: Option<f32>,
    },
    /// A disc in the middle of the film, as wide as its shorter side.
    Fisheye {
        /// The mapping from the distance to the middle to the angle from the view.
        mapping: FisheyeMapping,
        /// The angle that the disc's diameter sees, up to 360.
        field_of_view: f32,
    },
    /// The six faces of a cube, side by side: +x, -x, +y, -y, +z, -z, with +x to the right, +y up and +z in front.
    Cube,
    /// A ray of its own for each pixel.
    Rays(Arc<RayTable>),
}

/// How a fisheye maps the angle θ from the view to the distance r from the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FisheyeMapping {
    /// r grows with θ.
    #[default]
    Equidistant,
    /// r grows with sin(θ/2), so that equal areas of the film see equal solid angles.
    Equisolid,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// The radius of the circle around the aperture, across the film's height.
    pub radius: f32,
    /// Distance along the view of the plane that is sharp.
    pub focus: f32,
    /// Corners of the aperture, a regular polygon, from 3 on; 0 is a disc.
    pub blades: u32,
    /// The turn of the polygon. At 0 a corner points to the right; positive is counter-clockwise in the picture's
    /// sense, from right to up.
    pub rotation: f32,
    /// The aperture's height over its width.
    pub ratio: f32,
}

/// The range of distances that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// The least.
    pub near: f32,
    /// The greatest.
    pub far: f32,
}

/// The rays of a picture's pixels, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct RayTable {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Origin and unit direction, `width * height` times.
    pub rays: Vec<[Vec3; 2]>,
}

/// A kind of camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CameraKind {
    /// A pinhole or a thin lens.
    #[default]
    Perspective,
    /// Parallel rays.
    Orthographic,
    /// Equirectangular, all directions.
    Panorama,
    /// A disc of up to all directions.
    Fisheye,
    /// Six faces.
    Cube,
    /// A file of rays.
    Rays,
}

named!(CameraKind: Perspective = "perspective", Orthographic = "orthographic", Panorama = "panorama", Fisheye = "fisheye", Cube = "cube", Rays = "rays");

/// Which side of the picture the sensor's size is about, as Blender has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorFit {
    /// The sensor's width is the picture's longer side.
    #[default]
    Auto,
    /// The sensor's width is the picture's.
    Horizontal,
    /// The sensor's height is the picture's.
    Vertical,
}

named!(SensorFit: Auto = "auto", Horizontal = "horizontal", Vertical = "vertical");

impl Projection {
    /// As the option `--camera` calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Perspective => "perspective",
            Self::Orthographic { .. } => "orthographic",
            Self::Panorama { .. } => "panorama",
            Self::Fisheye { .. } => "fisheye",
            Self::Cube => "cube",
            Self::Rays(_) => "rays",
        }
    }
}

named!(FisheyeMapping: Equidistant = "equidistant", Equisolid = "equisolid");

impl Clip {
    /// No planes.
    pub const NONE: Self = Self { near: 0.0, far: f32::INFINITY };
}

impl Default for Clip {
    fn default() -> Self {
        Self::NONE
    }
}
