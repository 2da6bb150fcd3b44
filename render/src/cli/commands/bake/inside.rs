//! `halfdome bake --skip-outside`: where inside is, and what cannot be seen from there.

use glam::Vec3;

use crate::bake::{BakeOptions, LeftOut};
use crate::cli::error::{CliError, invalid};
use crate::cli::messages::{Style, print_text};
use crate::scene::scene_file::value;
use crate::scene::{Scene, count};
use crate::world::World;

/// A place inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Inside {
    /// Wherever it is.
    Anywhere,
    /// The position of the file's camera.
    Camera,
    /// This one.
    At(Vec3),
}

impl Inside {
    /// Reads an argument.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Anywhere),
            "camera" => Ok(Self::Camera),
            _ => value::argument(value::point)(text)
                .map(Self::At)
                .map_err(|_| "expected a place as X,Y,Z, `camera`, or `auto`".to_owned()),
        }
    }

    /// The places that all of them name; `None` if there are none. `eye` is the position of the file's camera.
    ///
    /// # Errors
    /// If the file has no camera.
    pub(crate) fn places(all: &[Self], eye: Option<Vec3>) -> Result<Option<Vec<Vec3>>, CliError> {
        let without = || {
            let problem = "the file has no camera, from which --skip-outside=camera would look".to_owned();
            invalid(problem, "name a place in a room: --skip-outside=X,Y,Z")
        };
        let place = |inside: &Self| match inside {
            Self::Anywhere => None,
            Self::At(place) => Some(Ok(*place)),
            Self::Camera => Some(eye.ok_or_else(without)),
        };
        let places = all.iter().filter_map(place).collect::<Result<Vec<Vec3>, CliError>>()?;
        Ok((!all.is_empty()).then_some(places))
    }
}

/// Finds the surfaces to leave out, and prints how many they are.
pub(super) fn left_out(scene: &Scene, world: &World, options: &BakeOptions, style: Style) -> Result<LeftOut, CliError> {
    let Some(places) = &options.skip_outside else { return Ok(LeftOut::default()) };
    let left_out = LeftOut::outside(scene, world, places)?;
    let (triangles, part) = left_out.extent(scene);
    let triangles = count(triangles, "triangle", "triangles");
    print_text(style, &format!("outside: {triangles}, {:.1}% of the surfaces' area, get no light", 100.0 * part));
    Ok(left_out)
}
