//! Statistics of a render as JSON (`--stats-json`): the scene, the options, times, rays, samples, errors.
//!
//! Times, rates and memory depend on the machine and differ from run to run; the rest does not.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use super::summary::End;
use super::usage;
use crate::driver::{CacheUse, RaysByKind, Render};
use crate::film::{Film, Picture};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::world::World;

/// All that is told.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Statistics {
    /// The program's version, and the arguments that it was given.
    pub(super) version: &'static str,
    pub(super) arguments: Vec<String>,
    /// The instruction set.
    pub(super) instruction_set: &'static str,
    pub(super) threads: usize,
    pub(super) scene: SceneFacts,
    pub(super) options: Options,
    /// Seconds of wall-clock time.
    pub(super) seconds: Seconds,
    /// Seconds of all threads, where the system reports them.
    pub(super) processor_seconds: Option<f64>,
    pub(super) rays: u64,
    pub(super) rays_by_kind: RayFacts,
    pub(super) rays_per_second: f64,
    pub(super) camera_samples: u64,
    /// Of a pixel.
    pub(super) least_samples: u32,
    pub(super) most_samples: u32,
    /// Samples that are not finite numbers, which count as black.
    pub(super) bad_samples: u64,
    /// The estimated relative error: the root of the pixels' mean square.
    pub(super) error: Option<f64>,
    pub(super) cache: Option<CacheFacts>,
    /// After each wave of samples.
    pub(super) history: Vec<Moment>,
    /// `done`, `limit` or `interrupted`.
    pub(super) end: &'static str,
    /// XXH3 of the pixels' values, hexadecimal: equal for equal pictures.
    pub(super) picture_hash: String,
    /// The most memory that the process had, in bytes, where the system reports it.
    pub(super) peak_memory: Option<u64>,
    pub(super) files: Vec<String>,
    pub(super) warnings: Vec<String>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct SceneFacts {
    pub(super) name: String,
    /// Equal for scenes that give equal pictures, hexadecimal.
    pub(super) hash: String,
    pub(super) meshes: usize,
    /// All triangles, with those of instances.
    pub(super) triangles: usize,
    /// Triangles in memory.
    pub(super) stored_triangles: usize,
    pub(super) objects: usize,
    pub(super) instances: usize,
    pub(super) materials: usize,
    pub(super) textures: usize,
    /// Point, spot and directional lights.
    pub(super) punctual_lights: usize,
    pub(super) tree_bytes: usize,
    pub(super) instance_bytes: usize,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Options {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) spp: u32,
    pub(super) seed: u64,
    pub(super) sampler: String,
    pub(super) integrator: &'static str,
    /// The relative error to reach; `None` if all samples were requested.
    pub(super) target: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Seconds {
    /// Reading the scene.
    pub(super) load: f64,
    /// The tree, the lights and what else is made of the scene.
    pub(super) build: f64,
    /// Sampling, irradiance cache included.
    pub(super) render: f64,
    /// Denoising and writing.
    pub(super) output: f64,
}

/// Rays by what they are for; they sum to all.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct RayFacts {
    /// Those that fill an irradiance cache or train a guide, before the first sample.
    pub(super) preparation: u64,
    pub(super) camera: u64,
    pub(super) bounce: u64,
    /// Shadow rays, with those of ambient occlusion.
    pub(super) shadow: u64,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct CacheFacts {
    records: u64,
    misses: u64,
    negative: u64,
}

/// The progress of a render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Moment {
    pub(super) seconds: f64,
    pub(super) camera_samples: u64,
    pub(super) error: Option<f64>,
}

/// Moments of a render that runs, and a clock for its stages.
pub(super) struct Recorder {
    last: Instant,
    history: Mutex<Vec<Moment>>,
}

impl Recorder {
    pub(super) fn start() -> Self {
        Self { last: Instant::now(), history: Mutex::default() }
    }

    /// Seconds since the last call, or the start.
    pub(super) fn lap(&mut self) -> f64 {
        let before = std::mem::replace(&mut self.last, Instant::now());
        (self.last - before).as_secs_f64()
    }

    /// Notes how far the film is.
    pub(super) fn note(&self, film: &Film) {
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
    pub(super) fn of(name: String, scene: &Scene) -> Self {
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
    pub(super) fn with_world(self, world: &World) -> Self {
        let (tree_bytes, instance_bytes) = (world.tree_statistics().bytes, world.instance_bytes());
        Self { hash: format!("{:016x}", world.hash()), tree_bytes, instance_bytes, ..self }
    }
}

impl Options {
    pub(super) fn of(settings: &Settings, target: Option<f64>) -> Self {
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
    pub(super) fn of(scene: SceneFacts, options: Options, render: &Render, history: Vec<Moment>, end: End) -> Self {
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
            rays_per_second: super::progress::per_second(render.rays, render.elapsed),
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
    pub(super) fn duration(&self) -> Duration {
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
