//! Statistics of a render as JSON (`--stats-json`): the scene, the options, times, rays, samples, errors.
//!
//! Times, rates and memory depend on the machine and differ from run to run; the rest does not.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use super::summary::End;
use crate::cli::usage;
use crate::driver::{CacheUse, RaysByKind, Render};
use crate::film::{Film, Picture};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::world::World;

/// All that is told.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Statistics {
    /// The program's version, and the arguments that it was given.
    pub(crate) version: &'static str,
    pub(crate) arguments: Vec<String>,
    /// The instruction set.
    pub(crate) instruction_set: &'static str,
    pub(crate) threads: usize,
    pub(crate) scene: SceneFacts,
    pub(crate) options: Options,
    /// Seconds of wall-clock time.
    pub(crate) seconds: Seconds,
    /// Seconds of all threads, where the system reports them.
    pub(crate) processor_seconds: Option<f64>,
    pub(crate) rays: u64,
    pub(crate) rays_by_kind: RayFacts,
    pub(crate) rays_per_second: f64,
    pub(crate) camera_samples: u64,
    /// Of a pixel.
    pub(crate) least_samples: u32,
    pub(crate) most_samples: u32,
    /// Samples that are not finite numbers, which count as black.
    pub(crate) bad_samples: u64,
    /// The estimated relative error: the root of the pixels' mean square.
    pub(crate) error: Option<f64>,
    pub(crate) cache: Option<CacheFacts>,
    /// After each wave of samples.
    pub(crate) history: Vec<Moment>,
    /// `done`, `limit` or `interrupted`.
    pub(crate) end: &'static str,
    /// XXH3 of the pixels' values, hexadecimal: equal for equal pictures.
    pub(crate) picture_hash: String,
    /// The most memory that the process had, in bytes, where the system reports it.
    pub(crate) peak_memory: Option<u64>,
    pub(crate) files: Vec<String>,
    pub(crate) warnings: Vec<String>,
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneFacts {
    pub(crate) name: String,
    /// Equal for scenes that give equal pictures, hexadecimal.
    pub(crate) hash: String,
    pub(crate) meshes: usize,
    /// All triangles, with those of instances.
    pub(crate) triangles: usize,
    /// Triangles in memory.
    pub(crate) stored_triangles: usize,
    pub(crate) objects: usize,
    pub(crate) instances: usize,
    pub(crate) materials: usize,
    pub(crate) textures: usize,
    /// Point, spot and directional lights.
    pub(crate) punctual_lights: usize,
    pub(crate) tree_bytes: usize,
    pub(crate) instance_bytes: usize,
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct Options {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) spp: u32,
    pub(crate) seed: u64,
    pub(crate) sampler: String,
    pub(crate) integrator: &'static str,
    /// The relative error to reach; `None` if all samples were requested.
    pub(crate) target: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Seconds {
    /// Reading the scene.
    pub(crate) load: f64,
    /// The tree, the lights and what else is made of the scene.
    pub(crate) build: f64,
    /// Sampling, irradiance cache included.
    pub(crate) render: f64,
    /// Denoising and writing.
    pub(crate) output: f64,
}

/// Rays by what they are for; they sum to all.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct RayFacts {
    /// Those that fill an irradiance cache or train a guide, before the first sample.
    pub(crate) preparation: u64,
    pub(crate) camera: u64,
    pub(crate) bounce: u64,
    /// Shadow rays, with those of ambient occlusion.
    pub(crate) shadow: u64,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct CacheFacts {
    records: u64,
    misses: u64,
    negative: u64,
}

/// The progress of a render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Moment {
    pub(crate) seconds: f64,
    pub(crate) camera_samples: u64,
    pub(crate) error: Option<f64>,
}

/// Moments of a render that runs, and a clock for its stages.
pub(super) struct Recorder {
    last: Instant,
    history: Mutex<Vec<Moment>>,
}

impl Recorder {
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), history: Mutex::default() }
    }

    /// Seconds since the last call, or the start.
    pub(super) fn lap(&mut self) -> f64 {
        let before = std::mem::replace(&mut self.last, Instant::now());
        (self.last - before).as_secs_f64()
    }

    /// Notes how far the film is.
    pub(crate) fn note(&self, film: &Film) {
        let moment =
            Moment { seconds: film.seconds, camera_samples: film.total_samples(), error: film.relative_error() };
        // Nobody panics with it in hand.
        if let Ok(mut history) = self.history.lock() {
            history.push(moment);
        }
    }

    pub(super) fn into_history(self) -> Vec<Moment> {
        self.history.into_inner().unwrap_or_default()
    }
}

impl SceneFacts {
    pub(crate) fn of(name: String, scene: &Scene) -> Self {
        Self {
            name,
            hash: String::new(),
            meshes: scene.meshes.len(),
            triangles: scene.triangle_count(),
            stored_triangles: scene.stored_triangle_count(),
            objects: scene.objects.len(),
            instances: scene.instances.len(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            punctual_lights: scene.lights.len(),
            tree_bytes: 0,
            instance_bytes: 0,
        }
    }

    /// The statistics before rendering.
    pub(crate) fn with_world(self, world: &World) -> Self {
        let (tree_bytes, instance_bytes) = (world.tree_statistics().memory_bytes, world.instance_bytes());
        Self { hash: format!("{:016x}", world.hash()), tree_bytes, instance_bytes, ..self }
    }
}

impl Options {
    pub(crate) fn of(settings: &Settings, target: Option<f64>) -> Self {
        let Settings { width, height, spp, seed, sampler, ref integrator, .. } = *settings;
        Self {
            width,
            height,
            spp,
            seed,
            sampler: format!("{sampler:?}").to_lowercase(),
            integrator: integrator.name(),
            target,
        }
    }
}

impl Statistics {
    pub(crate) fn of(scene: SceneFacts, options: Options, render: &Render, history: Vec<Moment>, end: End) -> Self {
        let film = &render.film;
        let usage = usage::of_process();
        let RaysByKind { preparation, camera, bounce, shadow } = render.rays_by_kind;
        let cache = render.cache.map(|CacheUse { records, misses, negative }| CacheFacts { records, misses, negative });
        Self {
            version: env!("CARGO_PKG_VERSION"),
            arguments: std::env::args().skip(1).collect(),
            instruction_set: halfdome_kernel::Isa::detect().level().name(),
            threads: rayon::current_num_threads(),
            scene,
            options,
            seconds: Seconds { render: render.elapsed.as_secs_f64(), ..Seconds::default() },
            processor_seconds: usage.map(|usage| usage.processor),
            rays: render.rays,
            rays_by_kind: RayFacts { preparation, camera, bounce, shadow },
            rays_per_second: crate::cli::progress::per_second(render.rays, render.elapsed),
            camera_samples: film.total_samples(),
            least_samples: film.samples().start,
            most_samples: film.samples().end,
            bad_samples: film.bad_samples().count,
            error: film.relative_error(),
            cache,
            history,
            end: match end {
                End::Done => "done",
                End::Limit => "limit",
                End::Interrupted => "interrupted",
            },
            picture_hash: picture_hash(&render.picture),
            peak_memory: usage.map(|usage| usage.peak_bytes),
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The statistics of the whole run as text.
    pub(crate) fn duration(&self) -> Duration {
        let Seconds { load, build, render, output } = self.seconds;
        Duration::from_secs_f64(load + build + render + output)
    }
}

/// A hash of the names and values of all channels.
fn picture_hash(picture: &Picture) -> String {
    let mut hash = Xxh3::new();
    for channel in &picture.channels {
        hash.update(channel.name.as_bytes());
        channel.values.iter().for_each(|value| hash.update(&value.to_bits().to_le_bytes()));
    }
    format!("{:016x}", hash.digest())
}
