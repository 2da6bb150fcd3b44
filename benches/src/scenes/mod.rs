//! The traced scenes: triangles, camera and light.
//!
//! All but the kitchen are built in. Those that are made come from the kernel's own sines and random numbers, and are
//! the same on every machine.

mod kitchen;
mod made;

use std::error::Error;
use std::fmt;
use std::process::ExitCode;

use glam::Vec3;
use halfdome::scene;
use halfdome_kernel::{Aabb, Triangle};

/// The names that [`by_name`] knows, from the least scene to the largest.
pub const NAMES: [&str; 6] = ["cornell", "city", "kitchen", "blob", "forest", "terrain"];

/// Grid cells along a side of the scene `terrain`, which has twice the square of that in triangles: 2.88 million.
pub const TERRAIN_SIDE: u32 = 1200;

/// A scene to trace.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name, as it was asked for.
    pub name: String,
    /// Triangles in world space.
    pub triangles: Vec<Triangle>,
    /// Where primary rays come from.
    pub camera: Camera,
    /// The point that shadow rays aim at.
    pub light: Vec3,
}

/// A pinhole camera with a square picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub target: Vec3,
    /// Half the picture's side at distance 1: the tangent of half the field of view.
    pub half_side: f32,
}

/// Why there is no such scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// No scene has this name.
    Unknown {
        /// The name.
        name: String,
    },
    /// The scene's file is not on this machine.
    Unavailable {
        /// The scene.
        name: String,
        /// What is missing.
        reason: String,
    },
}

/// Makes or loads a scene: one of [`NAMES`], or `terrain:N` with another N than [`TERRAIN_SIDE`].
///
/// # Errors
/// [`SceneError::Unknown`] if there is no such scene, [`SceneError::Unavailable`] if its file cannot be read.
pub fn by_name(name: &str) -> Result<Scene, SceneError> {
    let unknown = || SceneError::Unknown { name: name.to_owned() };
    let (kind, side) = match name.split_once(':') {
        Some((kind @ "terrain", side)) => {
            (kind, side.parse().ok().filter(|side| (1..=4096).contains(side)).ok_or_else(unknown)?)
        }
        _ => (name, TERRAIN_SIDE),
    };
    let scene = match kind {
        "cornell" => cornell(),
        "kitchen" => inside(
            kitchen::triangles()
                .map_err(|reason| SceneError::Unavailable { name: name.to_owned(), reason: reason.to_string() })?,
        ),
        "blob" => outside(made::blob(93)),
        "forest" => inside(made::forest(100_000)),
        "city" => outside(made::city(64)),
        "terrain" => outside(made::terrain(side)),
        _ => return Err(unknown()),
    };
    Ok(Scene { name: name.to_owned(), ..scene })
}

/// The triangles of the scene `blob`, as fine as one likes: 8 `side`².
pub fn blob(side: u32) -> Vec<Triangle> {
    made::blob(side)
}

/// The Cornell box, seen by its own camera.
fn cornell() -> Scene {
    let cornell = scene::cornell_box();
    let camera = cornell.camera.expect("the Cornell box comes with its camera");
    let half_side = (0.5 * camera.vfov.to_radians()).tan();
    Scene { camera: Camera { eye: camera.eye, target: camera.target, half_side }, ..inside(triangles(&cornell)) }
}

/// A scene that the camera and the light stand in.
fn inside(triangles: Vec<Triangle>) -> Scene {
    let Aabb { min, max } = bounds(&triangles);
    let (centre, extent) = (0.5 * (min + max), max - min);
    let camera = Camera {
        eye: centre + extent * Vec3::new(0.28, 0.1, 0.22),
        target: centre - extent * Vec3::new(0.3, 0.05, 0.3),
        half_side: 1.0,
    };
    Scene { name: String::new(), triangles, camera, light: centre + extent * Vec3::new(0.1, 0.35, 0.1) }
}

/// A scene that the camera and the light look at from above.
fn outside(triangles: Vec<Triangle>) -> Scene {
    let Aabb { min, max } = bounds(&triangles);
    let (centre, extent) = (0.5 * (min + max), max - min);
    let eye = centre + 0.8 * extent.length() * Vec3::new(0.6, 0.5, 1.0).normalize();
    let camera = Camera { eye, target: centre, half_side: 0.4 };
    Scene { name: String::new(), triangles, camera, light: centre + extent * Vec3::new(0.1, 2.0, 0.1) }
}

/// The box around all triangles.
pub(crate) fn bounds(triangles: &[Triangle]) -> Aabb {
    let corners = triangles.iter().flatten();
    corners.fold(Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY }, |bounds, &corner| Aabb {
        min: bounds.min.min(corner),
        max: bounds.max.max(corner),
    })
}

/// All triangles of a scene, mesh by mesh.
fn triangles(scene: &scene::Scene) -> Vec<Triangle> {
    let faces = |mesh: &scene::Mesh| (0..mesh.triangles.len()).map(|face| mesh.corners(face)).collect::<Vec<_>>();
    scene.meshes.iter().flat_map(faces).collect()
}

impl std::error::Error for SceneError {}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { name } => {
                let names = NAMES.join(", ");
                write!(f, "there is no scene `{name}`: say one of {names}, or terrain:N with N from 1 to 4096")
            }
            Self::Unavailable { name, reason } => write!(f, "the scene `{name}` is not here: {reason}"),
        }
    }
}

/// Runs `work` on each scene, skips unavailable ones, and stops at the first error; both are reported on stderr.
pub fn for_each(names: &[String], mut work: impl FnMut(&Scene) -> Result<(), Box<dyn Error>>) -> ExitCode {
    for name in names {
        let result = match by_name(name) {
            Ok(scene) => work(&scene),
            Err(error @ SceneError::Unavailable { .. }) => {
                eprintln!("skipped: {error}");
                Ok(())
            }
            Err(error) => Err(error.into()),
        };
        if let Err(error) = result {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_have_their_sizes() {
        for (name, count) in [("cornell", 32), ("city", 64 * 64 * 12), ("blob", 8 * 93 * 93), ("terrain:30", 1800)] {
            let scene = by_name(name).unwrap();
            assert_eq!(scene.triangles.len(), count, "{name}");
            assert_eq!(scene.name, name);
        }
        assert_eq!(by_name("forest").unwrap().triangles.len(), 100_000);
    }

    #[test]
    fn unknown_names_are_refused() {
        for name in ["", "kitchens", "terrain:", "terrain:0", "terrain:4097", "terrain:-1", "city:3"] {
            let error = by_name(name).unwrap_err();
            assert_eq!(error, SceneError::Unknown { name: name.to_owned() });
            assert!(error.to_string().contains("cornell, city, kitchen"), "{error}");
        }
    }

    #[test]
    fn bounds_hold_all_corners() {
        let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::NEG_Z, Vec3::new(3.0, -2.0, 0.5), Vec3::ONE]];
        assert_eq!(bounds(&triangles), Aabb { min: Vec3::new(0.0, -2.0, -1.0), max: Vec3::new(3.0, 1.0, 1.0) });
    }
}
