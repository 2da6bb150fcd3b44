//! What the user should know of a bake's light.

use glam::Vec3;

use super::{BakeOptions, Map, Mode, Statistics};
use crate::scene::count;
use crate::world::World;

/// Warnings, a line each.
pub(super) fn warnings(world: &World, options: &BakeOptions, maps: &[Map], statistics: &Statistics) -> Vec<String> {
    let mut warnings = Vec::new();
    let texels = |number: u64| count(number as usize, "texel", "texels");
    if maps.iter().all(|map| map.layers[0].texels.iter().all(|value| *value == Vec3::ZERO)) {
        warnings.push(match (options.mode, world.lights.sky.mean() != Vec3::ZERO) {
            (Mode::Direct, true) => {
                "all maps are black: the sky is the only light, and a sky without a sun counts as indirect light; use \
                 --mode full"
                    .to_owned()
            }
            (Mode::Ao, _) => "all maps are black: every ray is occluded; use a shorter --ao-distance".to_owned(),
            _ => "all maps are black: no light reaches the front of any surface; add an emitter, a light or --sky"
                .to_owned(),
        });
    }
    if statistics.mixed > 0 {
        let points = count(statistics.mixed as usize, "point", "points");
        warnings.push(format!("seams may show at {points}: charts of the model's own coordinates are too close"));
    }
    if statistics.covered * 4 > statistics.texels {
        warnings.push(format!(
            "{} of {} mostly see the backs of surfaces, and took the light of neighbours: check the orientation of faces",
            texels(statistics.covered),
            statistics.texels
        ));
    }
    warnings
}
