//! Warnings about a bake's model and light.

use std::path::PathBuf;

use glam::Vec3;

use super::{BakeOptions, Map, Mode, Statistics};
use crate::scene::{Scene, count, listed};
use crate::world::World;

/// Warnings about a model to be baked, a line each; `world` must be of `scene`.
pub fn model_warnings(scene: &Scene, world: &World) -> Vec<String> {
    let mut warnings = world.dropped(scene.files.first().map(PathBuf::as_path));
    let names: Vec<String> = world.inside_out().into_iter().map(|mesh| world.mesh_name(mesh)).collect();
    if !names.is_empty() {
        let file = scene.files.first().map(|file| format!("{}: ", file.display())).unwrap_or_default();
        warnings.push(format!(
            "{file}{} closed and inside out, so that light is baked onto the inner sides: {}; unless these are empty rooms, \
             turn the normals outwards (Blender: select all in Edit Mode, Shift+N)",
            count(names.len(), "mesh is", "meshes are"),
            listed(&names)
        ));
    }
    warnings
}

/// Warnings about the light, a line each; charts of the meshes `mixed` are too close.
pub(super) fn warnings(
    world: &World,
    options: &BakeOptions,
    maps: &[Map],
    statistics: &Statistics,
    mixed: &[usize],
) -> Vec<String> {
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
        let names: Vec<String> = mixed.iter().map(|&mesh| world.mesh_name(mesh)).collect();
        warnings.push(format!(
            "seams may show at {points}: charts of the model's own coordinates are too close in {}",
            listed(&names)
        ));
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
