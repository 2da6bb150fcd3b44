//! TEMPORARY, until the branches merge: the thinnest stand-ins for what the command line calls elsewhere.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::driver::{Render, Watch};
use crate::film::{Channel, Filter, Metadata, Picture};
use crate::scene::{Place, Scene, SceneError};
use crate::settings::{Invalid, Settings};

/// Becomes what `Filter::from_name` gives.
pub(crate) struct FilterError {
    pub(crate) problem: String,
    pub(crate) remedy: String,
}

impl Filter {
    pub(crate) const NAMES: [&'static str; 4] = ["box", "tent", "gaussian", "mitchell"];

    pub(crate) fn from_name(name: &str, width: Option<f32>, sharpness: Option<f32>) -> Result<Filter, FilterError> {
        let width = width.unwrap_or(if name == "box" { 1.0 } else { 4.0 });
        match name {
            "box" => Ok(Filter::Box { width }),
            "tent" => Ok(Filter::Tent { width }),
            "gaussian" => Ok(Filter::Gaussian { width }),
            "mitchell" => Ok(Filter::Mitchell { width, sharpness: sharpness.unwrap_or(2.0 / 3.0) }),
            _ => Err(FilterError {
                problem: format!("there is no pixel filter {name:?}"),
                remedy: format!("choose one of {}", Self::NAMES.join(", ")),
            }),
        }
    }
}

/// Becomes `scene::load`.
pub(crate) fn load(path: &Path) -> Result<Scene, SceneError> {
    Err(SceneError::new(path, Place::File, "models cannot be read yet", "render `cornell`"))
}

/// Becomes `world::World`.
pub(crate) struct World(Scene);

/// Becomes what `World::tree_statistics` gives.
#[derive(serde::Serialize)]
pub(crate) struct TreeStatistics {
    pub(crate) degenerate_triangles: usize,
    pub(crate) bytes: usize,
    pub(crate) sah_cost: f32,
    pub(crate) depth: usize,
    pub(crate) nodes: usize,
    pub(crate) leaf_blocks: usize,
}

impl World {
    pub(crate) fn new(scene: Scene) -> Result<Self, Invalid> {
        Ok(Self(scene))
    }

    pub(crate) fn tree_statistics(&self) -> TreeStatistics {
        TreeStatistics { degenerate_triangles: 0, bytes: 0, sah_cost: 0.0, depth: 0, nodes: 0, leaf_blocks: 0 }
    }
}

/// Becomes `driver::render`.
pub(crate) fn render(world: &World, settings: &Settings, watch: &dyn Watch) -> Result<Render, Invalid> {
    let start = Instant::now();
    let samples = u64::from(settings.width) * u64::from(settings.spp);
    let mut rays = 0;
    for _ in 0..settings.height {
        if watch.stop() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
        watch.advance(samples, 3 * samples);
        rays += 3 * samples;
    }
    let size = settings.width as usize * settings.height as usize;
    let channels = ["R", "G", "B"].map(|name| Channel { name: name.to_owned(), values: vec![0.0; size] }).to_vec();
    let metadata = Metadata { scene_hash: world.0.triangle_count() as u64, ..Metadata::default() };
    let picture = Picture { width: settings.width, height: settings.height, channels, metadata };
    Ok(Render { picture, finished: !watch.stop(), rays, elapsed: start.elapsed() })
}

/// Becomes `crate::output`.
pub(crate) mod output {
    use std::path::Path;

    use crate::film::Picture;
    use crate::settings::Invalid;

    #[derive(Clone, Debug)]
    pub(crate) struct ToneMapping {
        pub(crate) exposure: f32,
        pub(crate) curve: ToneCurve,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum ToneCurve {
        Linear,
        Reinhard,
        Neutral,
    }

    impl ToneCurve {
        pub(crate) const NAMES: [&'static str; 3] = ["linear", "reinhard", "neutral"];

        pub(crate) fn from_name(name: &str) -> Option<Self> {
            let curves = [Self::Linear, Self::Reinhard, Self::Neutral];
            Self::NAMES.iter().position(|known| *known == name).map(|i| curves[i])
        }
    }

    pub(crate) struct Format;

    impl Format {
        pub(crate) fn from_path(path: &Path) -> Result<Self, Invalid> {
            match path.extension().and_then(|extension| extension.to_str()) {
                Some("exr" | "png") => Ok(Self),
                _ => Err(Invalid::new(format!("{}: unknown format", path.display()), "end the name in .exr or .png")),
            }
        }
    }

    pub(crate) fn check(path: &Path) -> Result<(), Invalid> {
        let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
        let missing = || Invalid::new(format!("{}: no such folder", path.display()), "choose another folder");
        if folder.is_dir() { Ok(()) } else { Err(missing()) }
    }

    pub(crate) fn write(path: &Path, picture: &Picture, tone: &ToneMapping) -> Result<(), Invalid> {
        let text = format!("{} {} {:?}", picture.width, tone.exposure, tone.curve);
        std::fs::write(path, text).map_err(|error| Invalid::new(format!("{}: {error}", path.display()), "make room"))
    }
}
