//! Lists the light paths of a pixel's samples, as matched by light path expressions.

use std::ops::Range;

use glam::Vec3;

use super::frame::{FrameRender, TileScratch};
use crate::film::{Extras, tiles};
use crate::integrator::{LightPaths, Prepared};
use crate::lpe::Event;
use crate::settings::{Cryptomatte, Integrator, Invalid, PathOptions, Settings, Stop};
use crate::world::World;

/// The paths of one sample.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleHistory {
    /// The sample's index.
    pub sample: u32,
    /// Its radiance, linear sRGB.
    pub radiance: Vec3,
    /// Each of its paths that found light; their light adds up to the radiance.
    pub paths: Vec<LightPath>,
}

/// A path from the camera to a light, or several of one sample to which the same has happened.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPath {
    /// The events at surfaces, and the light.
    pub events: Vec<Event>,
    /// The contribution to the sample's radiance.
    pub light: Vec3,
}

/// The paths of some samples of a pixel, which are those of [`render`](super::render()) with these settings.
///
/// # Errors
/// If the integrator follows no light paths, adds light without a path, or is guided.
pub fn pixel_history(
    world: &World,
    settings: &Settings,
    pixel: (u32, u32),
    samples: Range<u32>,
) -> Result<Vec<SampleHistory>, Invalid> {
    let refusal = match &settings.integrator {
        Integrator::Path(PathOptions { guide: Some(_), .. }) => Some("guided paths cannot be followed one by one"),
        Integrator::Path(PathOptions { stop: Stop::Threshold { add_back: true, .. }, .. }) => {
            Some("add-back adds light without a path")
        }
        Integrator::Path(_) => None,
        _ => Some("the integrator follows no light paths"),
    };
    if let Some(problem) = refusal {
        return Err(Invalid::new(problem, "use the integrator path, without --guide and --add-back"));
    }
    let settings = Settings {
        aov: false,
        halves: false,
        cryptomatte: Cryptomatte::default(),
        aovs: Vec::new(),
        light_groups: false,
        ..settings.clone()
    };
    let frame = FrameRender::new(world, settings, Prepared::Nothing, Some(LightPaths::listing(world)));
    let mut scratch = TileScratch::default();
    let history = |sample: u32| {
        let mut tile = tiles(1, 1, Extras::default()).swap_remove(0);
        frame.sample(world, &mut scratch, &mut tile, &[(0, pixel)], sample..sample + 1);
        let paths = frame.take_paths().into_iter().map(|(events, light)| LightPath { events, light });
        SampleHistory { sample, radiance: tile.radiance(0).into(), paths: paths.collect() }
    };
    Ok(samples.map(history).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::{Watch, render};
    use crate::scene::cornell_box;

    struct Unwatched;

    impl Watch for Unwatched {
        fn advance(&self, _samples: u64, _rays: u64) {}
        fn stop(&self) -> bool {
            false
        }
    }

    #[test]
    fn paths_add_up_to_the_pixel() {
        let mut scene = cornell_box();
        // A mirror, and what is half of it metal: all lobes happen.
        (scene.materials[1].inputs.base_metalness, scene.materials[1].inputs.specular_roughness) = (1.0, 0.0);
        (scene.materials[0].inputs.base_metalness, scene.materials[0].inputs.specular_roughness) = (0.5, 0.3);
        let world = World::new(scene).unwrap();
        let settings = Settings { width: 24, height: 24, spp: 16, ..Settings::default() };
        let picture = render(&world, &settings, &Unwatched).picture;
        let mut count = 0;
        for (x, y) in [(12, 12), (3, 20), (20, 7), (12, 0), (0, 0)] {
            let history = pixel_history(&world, &settings, (x, y), 0..16).unwrap();
            let mut mean = Vec3::ZERO;
            for SampleHistory { radiance, paths, .. } in &history {
                let sum: Vec3 = paths.iter().map(|path| path.light).sum();
                assert!((sum - radiance).length() <= 1e-5 * radiance.length(), "{sum} {radiance}");
                mean += radiance / 16.0;
                count += paths.len();
            }
            let value = ["R", "G", "B"].map(|name| picture.channel(name).unwrap().values[(y * 24 + x) as usize]);
            assert!((mean - Vec3::from(value)).length() <= 1e-5 * mean.length(), "{mean} {value:?} at {x}, {y}");
        }
        assert!(count > 100, "{count}");
    }

    #[test]
    fn a_path_says_what_happened() {
        let world = World::new(cornell_box()).unwrap();
        let settings = Settings { width: 8, height: 8, ..Settings::default() };
        let history = pixel_history(&world, &settings, (4, 7), 0..32).unwrap();
        let text = |path: &LightPath| path.events.iter().map(Event::to_string).collect::<Vec<_>>().join(", ");
        let texts: Vec<String> = history.iter().flat_map(|sample| &sample.paths).map(text).collect();
        assert!(texts.contains(&"RD floor, O light".to_owned()), "{texts:?}");
        assert!(texts.iter().any(|text| text.starts_with("RD floor, RD ")), "{texts:?}");
    }

    #[test]
    fn what_follows_no_paths_says_so() {
        let world = World::new(cornell_box()).unwrap();
        let settings = Settings { integrator: Integrator::named("ao").unwrap(), ..Settings::default() };
        let error = pixel_history(&world, &settings, (0, 0), 0..1).unwrap_err().to_string();
        assert!(error.starts_with("the integrator follows no light paths"), "{error}");
    }
}
