//! `halfdome bake --skip-outside`: where inside is, and what cannot be seen from there.

use glam::Vec3;

use super::super::error::CliError;
use super::super::messages::{Style, print_text};
use crate::bake::{BakeOptions, LeftOut};
use crate::scene::value;
use crate::scene::{Scene, count};
use crate::world::World;

/// A place inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Inside {
    /// Wherever it is.
    Anywhere,
    /// The eye of the scene's camera, or of the one that stands for it.
    Camera,
    /// This one.
    At(Vec3),
}

impl Inside {
    /// Reads an argument.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Anywhere),
            "camera" => Ok(Self::Camera),
            _ => value::argument(value::point)(text)
                .map(Self::At)
                .map_err(|_| "expected a place as X,Y,Z, `camera`, or `auto`".to_owned()),
        }
    }

    /// The places that all of them name; `None` if there are none.
    pub(super) fn places(all: &[Self], scene: &Scene) -> Option<Vec<Vec3>> {
        let place = |inside: &Self| match inside {
            Self::Anywhere => None,
            Self::At(place) => Some(*place),
            Self::Camera => scene.camera.map(|camera| camera.eye),
        };
        (!all.is_empty()).then(|| all.iter().filter_map(place).collect())
    }
}

/// Finds what is left out, and says how much it is.
pub(super) fn left_out(scene: &Scene, world: &World, options: &BakeOptions, style: Style) -> Result<LeftOut, CliError> {
    let Some(places) = &options.skip_outside else { return Ok(LeftOut::default()) };
    let left_out = LeftOut::outside(scene, world, places)?;
    let (triangles, part) = left_out.extent(scene);
    let triangles = count(triangles, "triangle", "triangles");
    print_text(style, &format!("outside: {triangles}, {:.1}% of the surfaces' area, get no light", 100.0 * part));
    Ok(left_out)
}
