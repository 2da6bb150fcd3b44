//! The compared renderers, each on one thread.

use halfdome::driver::{self, Watch};
use halfdome::film::Picture;
use halfdome::settings::{Filter, Integrator, PathOptions, Settings, Stop, Survival};
use halfdome::world::World;
use halfdome_kernel::sampling::Pattern;
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike as _;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// A renderer that has the scene.
pub(crate) trait Renderer {
    /// What it is called in the results.
    fn name(&self) -> &str;
    /// Its version, and what in its settings is worth knowing.
    fn about(&self) -> &str;
    /// Renders with `spp` samples a pixel. Pictures of different seeds are independent.
    ///
    /// # Errors
    /// If a peer gives no picture.
    fn render(&mut self, spp: u32, seed: u32) -> Result<Rendering, String>;
}

/// A picture, and what it took.
#[derive(Clone, Debug)]
pub(crate) struct Rendering {
    /// Red, green and blue, row by row.
    pub(crate) pixels: Vec<f32>,
    /// Seconds of the processor, without loading and compiling.
    pub(crate) seconds: f64,
    /// Rays traced, of every kind, if the renderer counts them.
    pub(crate) rays: Option<u64>,
}

/// Our path tracer.
pub(crate) struct Halfdome<'a> {
    name: String,
    world: &'a World,
    settings: Settings,
    /// The one thread.
    pool: ThreadPool,
}

impl<'a> Halfdome<'a> {
    pub(crate) fn new(
        name: impl Into<String>,
        world: &'a World,
        settings: Settings,
        threads: usize,
    ) -> Result<Self, ThreadPoolBuildError> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(Self { name: name.into(), world, settings, pool })
    }
}

impl Renderer for Halfdome<'_> {
    fn name(&self) -> &str {
        &self.name
    }

    fn about(&self) -> &str {
        concat!("halfdome ", env!("CARGO_PKG_VERSION"))
    }

    fn render(&mut self, spp: u32, seed: u32) -> Result<Rendering, String> {
        let settings = Settings { spp, seed: seed.into(), ..self.settings.clone() };
        let start = processor_seconds();
        let render = self.pool.install(|| driver::render(self.world, &settings, &NeverStops));
        let seconds = processor_seconds() - start;
        Ok(Rendering { pixels: pixels(&render.picture), seconds, rays: Some(render.rays) })
    }
}

/// What this process has had of the processor so far; NaN where it is not counted.
fn processor_seconds() -> f64 {
    getrusage(UsageWho::RUSAGE_SELF).map_or(f64::NAN, |usage| {
        [usage.user_time(), usage.system_time()].map(|time| time.num_microseconds() as f64 * 1e-6).iter().sum()
    })
}

/// Settings of our path tracer for a square picture, as the peers have them too: a box filter, light by multiple
/// importance sampling, and roulette by the throughput alone after `sure_bounces` bounces.
pub(crate) fn settings(side: u32, sure_bounces: u32, sampler: Pattern) -> Settings {
    let stop = Stop::Roulette { after: sure_bounces, survival: Survival::Throughput { max: 0.95 } };
    Settings {
        width: side,
        height: side,
        filter: Filter::Box { width: 1.0 },
        integrator: Integrator::Path(PathOptions { stop, ..PathOptions::default() }),
        sampler,
        ..Settings::default()
    }
}

/// Lets every render run to its end.
struct NeverStops;

impl Watch for NeverStops {
    fn advance(&self, _: u64, _: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

fn pixels(picture: &Picture) -> Vec<f32> {
    let [r, g, b] = ["R", "G", "B"].map(|name| &picture.channel(name).expect("every picture has colours").values);
    (0..r.len()).flat_map(|i| [r[i], g[i], b[i]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfdome::scene::cornell_box;

    #[test]
    fn pictures_depend_on_the_seed_and_count_their_rays() {
        let world = World::new(cornell_box()).unwrap();
        let mut halfdome = Halfdome::new("halfdome", &world, settings(8, 8, Pattern::Sobol), 1).unwrap();
        let [first, again, other] = [1, 1, 2].map(|seed| halfdome.render(2, seed).unwrap());
        assert_eq!(first.pixels.len(), 8 * 8 * 3);
        assert_eq!((&first.pixels, first.rays), (&again.pixels, again.rays));
        assert_ne!(first.pixels, other.pixels);
        // A camera ray each, and for most a shadow ray too.
        assert!(first.rays.unwrap() > 8 * 8 * 2 * 2);
    }
}
