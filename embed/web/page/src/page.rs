//! A worker's state: a scene, and its share of a picture.

use std::path::Path;

use halfdome::cache::Cache;
use halfdome::driver::{self, Step, TileWorker, Watch};
use halfdome::output::ToneMapping;
use halfdome::overlay::visible_records;
use halfdome::scene::{self, Overrides};
use halfdome::settings::Integrator;
use halfdome::world::World;
use halfdome::{RayonExecutor, scene::Scene};
use halfdome_kernel::Quality;

use crate::files::Dropped;
use crate::progress;
use crate::view::{Summary, View};

/// The sky of a scene that has no light.
const SKY: f32 = 1.0;

/// All that an instance has.
#[derive(Default)]
pub(crate) struct Page {
    files: Dropped,
    world: Option<World>,
    cache: Option<Cache>,
    worker: Option<TileWorker>,
}

/// What a function answers: bytes, or a message.
type Answer = Result<Vec<u8>, String>;

impl Page {
    /// Keeps the first `length` bytes as the file that the rest names.
    pub(crate) fn add_file(&mut self, mut input: Vec<u8>, length: usize) -> Answer {
        let name = input.get(length..).and_then(|name| str::from_utf8(name).ok()).map(str::to_owned);
        let name = name.ok_or("the file has no name")?;
        input.truncate(length);
        self.files.add(&name, input);
        Ok(Vec::new())
    }

    /// Opens the model of this name.
    pub(crate) fn open(&mut self, name: Vec<u8>) -> Answer {
        let files = std::mem::take(&mut self.files);
        let name = String::from_utf8(name).map_err(|_| "the model's name is not text")?;
        let mut scene = match name.as_str() {
            "" => scene::cornell_box(),
            name => scene::load_from(&files, Path::new(name)).map_err(|error| error.to_string())?,
        };
        let mut warnings = std::mem::take(&mut scene.warnings);
        if !scene.has_light() {
            scene.sky.radiance = [SKY; 3].into();
            warnings.push("The model has no light: it stands under a white sky.".to_owned());
        }
        Overrides::default().apply(&mut scene).map_err(|conflict| conflict.to_string())?;
        let summary = self.build(scene, warnings)?;
        serde_json::to_vec(&summary).map_err(|error| error.to_string())
    }

    fn build(&mut self, scene: Scene, warnings: Vec<String>) -> Result<Summary, String> {
        let triangles = scene.triangle_count();
        let (lower, upper) = scene.bounds().unwrap_or_default();
        let world = World::build(scene, &Quality::Medium.into(), &RayonExecutor::UNWATCHED);
        let world = world.map_err(|error| error.to_string())?;
        let camera = world.camera().into();
        *self = Self { world: Some(world), ..Self::default() };
        Ok(Summary { triangles, bounds: [lower.into(), upper.into()], camera, warnings })
    }

    /// Adds to the cache what a view needs.
    pub(crate) fn fill(&mut self, view: Vec<u8>) -> Answer {
        let (settings, camera) = View::parse(&view)?.apply()?;
        let Integrator::Cached(options) = settings.integrator else {
            return Err(format!("the integrator `{}` has no cache", settings.integrator.name()));
        };
        let world = self.world.as_mut().ok_or("no scene is open")?;
        world.set_camera(camera);
        let cache = self.cache.take().filter(|cache| cache.scene_hash() == world.surroundings_hash());
        let cache = cache.unwrap_or_else(|| Cache::new(options, world.surroundings_hash()));
        let cache = driver::fill_cache(world, &settings, cache, &Progress);
        let visible = visible_records(world, &cache, settings.width, settings.height);
        let mut answer = (visible.len() as u32).to_le_bytes().to_vec();
        answer.extend(visible.iter().flat_map(|(_, point)| [point.x, point.y]).flat_map(f32::to_le_bytes));
        answer.extend(cache.encode());
        Ok(answer)
    }

    /// Takes the bytes of a cache.
    pub(crate) fn take_cache(&mut self, bytes: Vec<u8>) -> Answer {
        self.cache = Some(Cache::decode(&bytes).map_err(|error| error.to_string())?);
        Ok(Vec::new())
    }

    /// Prepares to render a view.
    pub(crate) fn start(&mut self, view: &[u8], number: usize, count: usize) -> Answer {
        let (settings, camera) = View::parse(view)?.apply()?;
        if count == 0 {
            return Err("the picture is for no worker".to_owned());
        }
        let world = self.world.as_mut().ok_or("no scene is open")?;
        world.set_camera(camera);
        self.worker = Some(TileWorker::new(world, &settings, self.cache.take(), number, count));
        Ok(Vec::new())
    }

    /// Renders a tile a little further, and writes what the page shows of it; false if all is done.
    pub(crate) fn step(&mut self, output: &mut Vec<u8>) -> bool {
        let Self { world: Some(world), worker: Some(worker), .. } = self else { return false };
        let Some(Step { x, y, radiance, samples, rays }) = worker.step(world) else { return false };
        let numbers = [x.start, y.start, x.end - x.start, y.end - y.start, samples as u32, rays as u32];
        let tone = ToneMapping::default();
        output.clear();
        output.extend(numbers.into_iter().flat_map(u32::to_le_bytes));
        for radiance in radiance {
            let [red, green, blue] = tone.to_srgb8(radiance);
            output.extend([red, green, blue, u8::MAX]);
        }
        true
    }
}

/// Tells the page of rays.
struct Progress;

impl Watch for Progress {
    fn advance(&self, _samples: u64, rays: u64) {
        progress(rays as f64);
    }

    fn stop(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: &str = r#"{"width": 40, "height": 30, "spp": 2, "integrator": "cached",
        "camera": {"eye": [0.278, 0.273, -0.8], "target": [0.278, 0.273, 0], "up": [0, 1, 0], "vfov": 39}}"#;

    #[test]
    fn a_scene_is_opened_and_a_bad_file_leaves_it() {
        let mut page = Page::default();
        assert_eq!(page.start(VIEW.as_bytes(), 0, 1).unwrap_err(), "no scene is open");
        let summary = String::from_utf8(page.open(Vec::new()).unwrap()).unwrap();
        assert!(summary.starts_with(r#"{"triangles":32,"#) && summary.ends_with(r#""warnings":[]}"#), "{summary}");
        page.add_file(b"not a modela.glb".to_vec(), 11).unwrap();
        let message = page.open(b"a.glb".to_vec()).unwrap_err();
        assert!(message.starts_with("a.glb: this is not binary glTF (GLB)"), "{message}");
        assert!(page.open(b"a.glb".to_vec()).unwrap_err().contains("no such file"), "files are forgotten");
        page.start(VIEW.as_bytes(), 0, 1).unwrap();
    }

    #[test]
    fn a_dark_model_has_a_sky() {
        let mut page = Page::default();
        let model = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        page.add_file([model.as_slice(), b"a.obj"].concat(), model.len()).unwrap();
        let summary = String::from_utf8(page.open(b"a.obj".to_vec()).unwrap()).unwrap();
        assert!(summary.contains("under a white sky") && !summary.contains("--eye"), "{summary}");
    }

    #[test]
    fn a_view_is_filled_and_rendered() {
        let mut page = Page::default();
        page.open(Vec::new()).unwrap();
        let filled = page.fill(VIEW.into()).unwrap();
        let seen = u32::from_le_bytes(*filled.first_chunk().unwrap()) as usize;
        let cache = &filled[4 + 8 * seen..];
        assert!(seen > 10 && seen <= Cache::decode(cache).unwrap().records().len());
        page.take_cache(cache.to_vec()).unwrap();
        assert_eq!(page.fill(VIEW.into()).unwrap(), filled, "nothing was missing");
        page.take_cache(cache.to_vec()).unwrap();
        page.start(VIEW.as_bytes(), 0, 1).unwrap();
        let (mut output, mut samples) = (Vec::new(), 0);
        while page.step(&mut output) {
            let header: [u32; 6] = std::array::from_fn(|i| u32::from_le_bytes(*output[4 * i..].first_chunk().unwrap()));
            let [x, y, width, height, taken, rays] = header;
            assert!(x + width <= 40 && y + height <= 30 && rays >= taken);
            assert_eq!(output.len() as u32, 24 + 4 * width * height);
            assert!(output[24..].chunks(4).all(|pixel| pixel[3] == 255));
            samples += taken;
        }
        assert_eq!(samples, 40 * 30 * 2);
    }

    #[test]
    fn what_is_no_view_is_refused() {
        let mut page = Page::default();
        page.open(Vec::new()).unwrap();
        let problem = |page: &mut Page, from: &str, to: &str| {
            assert!(VIEW.contains(from));
            page.start(VIEW.replace(from, to).as_bytes(), 0, 1).unwrap_err()
        };
        assert!(problem(&mut page, "\"width\": 40", "\"width\": -1").starts_with("the view cannot be read"));
        assert!(problem(&mut page, "cached", "cast").starts_with("there is no integrator \"cast\""));
        assert!(
            problem(&mut page, "\"target\": [0.278, 0.273, 0]", "\"target\": [0.278, 0.273, -0.8]")
                .contains("same point")
        );
        assert!(page.start(VIEW.as_bytes(), 0, 0).is_err());
        assert!(page.take_cache(b"none".to_vec()).is_err());
        assert!(!page.step(&mut Vec::new()));
    }
}
