//! Path tracing (Kajiya 1986): `L = L_e + ∫ f L cos θ dω`, one sample of the integral a surface.
//!
//! With `LightSampling::Naive` a ray hits a surface, adds its emission, and continues by the cosine. `Direct` also
//! samples a light at every surface, and ignores emission at the next bounce; `Mis` weights both by the power heuristic
//! (Veach 1997). The module [`material`](crate::material) explains why mirrors and the first surface need no rule of
//! their own.
//!
//! Each surface reflects a part of the light, and a path may stop when little is left ([`Stop`]): where the product of
//! all reflectances falls below a threshold, with or without the scene's mean radiance in place of the lost light, or
//! by Russian roulette, where a path that survives with the probability `p` counts for `1/p`.
//!
//! `clamp_indirect` scales down contributions of lights after two reflections and more. `filter_glossy` makes gloss rougher that
//! paths meet after a wide lobe.
//!
//! A step works on a block of paths: it looks up their hits, computes light samples and bounces in lanes (see
//! [`path_block`](super::path_block)), and compacts the continuing paths. Emission, textures, glass, layers, the sky
//! and delta lights are done one by one.

mod absorb;
mod aim;
mod dispersion;
mod panes;
mod record;
mod seen_lights;
mod step;
mod train;

use glam::Vec3;
use halfdome_kernel::Task;

use super::path_block::{Bounces, Closures, GlossyLanes, GuidedBlock, Lambert, PathBlock, ShadowRays};
use super::wavefront::WavefrontStep;
use super::{RayBatch, Wavefront};
use crate::guide::Guide;
use crate::light::SkyPart;
use crate::material::{Kind, Layered, Transmissive};
use crate::settings::PathOptions;
use crate::world::World;
pub(in crate::integrator) use record::{Recorder, RecorderMemory};
pub(in crate::integrator) use train::Trainer;

/// The part of the sky for light samples: cosine-distributed bounces find the rest.
pub(super) const SKY: SkyPart = SkyPart::Bright;

/// Observers of paths.
#[derive(Default)]
pub(super) struct PathObservers<'a> {
    /// Gets what AOVs by light path expressions have of them.
    pub recorder: Option<Recorder<'a>>,
    /// The guide of the paths.
    pub guide: Option<&'a Guide>,
    /// Learns that.
    pub trainer: Option<&'a mut Trainer>,
}

/// Writes the radiance along each camera ray; gives the number of further rays.
///
/// `watch` sees the rays that are to be traced before they are: the shadow rays of each bounce, and the paths'.
pub(super) fn radiance(
    world: &World,
    options: &PathOptions,
    batch: &RayBatch,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
    watch: &mut dyn FnMut(&Wavefront),
    PathObservers { recorder, guide, mut trainer }: PathObservers,
) -> u64 {
    if let Some(trainer) = &mut trainer {
        trainer.start(batch.rays.len());
    }
    let scratch = Scratch {
        block: PathBlock::new(),
        rays: BlockRays { shadows: ShadowRays::new(), to_sky: ShadowRays::to_sky(), bounces: Bounces::new() },
        glossy: GlossyLanes::default(),
        transmissive: Closures::default(),
        layered: Closures::default(),
    };
    wave.follow(
        world,
        batch,
        &mut PathTracer { world, options, watch, recorder, guide: guide.map(GuidedBlock::new), trainer, scratch },
        radiance,
    )
}

struct PathTracer<'a> {
    world: &'a World,
    options: &'a PathOptions,
    watch: &'a mut dyn FnMut(&Wavefront),
    recorder: Option<Recorder<'a>>,
    guide: Option<GuidedBlock<'a>>,
    trainer: Option<&'a mut Trainer>,
    scratch: Scratch,
}

/// Memory for a block of paths.
struct Scratch {
    block: PathBlock,
    rays: BlockRays,
    glossy: GlossyLanes,
    transmissive: Closures<Transmissive>,
    layered: Closures<Layered>,
}

/// The rays that leave a block's surfaces.
struct BlockRays {
    shadows: ShadowRays,
    /// Shadow rays of samples of the sky through openings.
    to_sky: ShadowRays,
    bounces: Bounces,
}

impl WavefrontStep for PathTracer<'_> {
    fn max_depth(&self) -> u32 {
        self.options.max_depth
    }

    fn advance(&mut self, wave: &mut Wavefront, batch: &RayBatch, depth: u32, radiance: &mut [Vec3]) {
        let Self { world, options, scratch, recorder, guide, trainer, .. } = self;
        let (recorder, guide, trainer) = (recorder.as_mut(), guide.as_mut(), trainer.as_deref_mut());
        let step = Advance { world, options, wave, batch, depth, radiance, recorder, guide, trainer, kept: 0 };
        world.isa().run(Steps { step, scratch });
    }

    fn watch(&mut self, wave: &Wavefront) {
        (self.watch)(wave);
    }

    fn resolved(&mut self, wave: &Wavefront) {
        if let Some(recorder) = &mut self.recorder {
            recorder.resolve(&wave.shadow_queue);
        }
        if let Some(trainer) = &mut self.trainer {
            trainer.resolve(&wave.shadow_queue);
        }
    }
}

/// The step of all paths from hit number `depth`.
struct Advance<'a, 'b> {
    world: &'a World,
    options: &'a PathOptions,
    wave: &'a mut Wavefront,
    batch: &'a RayBatch<'a>,
    depth: u32,
    radiance: &'a mut [Vec3],
    recorder: Option<&'a mut Recorder<'b>>,
    guide: Option<&'a mut GuidedBlock<'b>>,
    trainer: Option<&'a mut Trainer>,
    /// The number of continuing paths.
    kept: usize,
}

/// The same block by block, as a task that is compiled for each instruction set.
struct Steps<'a, 'b> {
    step: Advance<'a, 'b>,
    scratch: &'a mut Scratch,
}

impl Task for Steps<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { mut step, scratch } = self;
        let Scratch { block, rays, glossy, transmissive, layered } = scratch;
        step.see_lights();
        for crossing in step.wave.pass_panes(step.world, step.batch.times) {
            if let Some(pane) = crossing.mirrored {
                step.record_mirrored(crossing.source, &pane);
            }
        }
        if step.aims() {
            step.wave.lose_aimed(step.world);
        }
        let ends = step.wave.sort_by_kind(step.world);
        step.miss(ends[Kind::COUNT - 1]);
        step.advance(0..ends[0], &mut Lambert, block, rays);
        if step.world.has_closures() {
            step.advance(ends[0]..ends[1], glossy, block, rays);
            step.advance(ends[1]..ends[2], transmissive, block, rays);
            step.advance(ends[2]..ends[3], layered, block, rays);
        }
        // What blocks add behind all others, so that the order of a sample's contributions does not depend on blocks.
        let first_deferred = step.wave.shadow_queue.queue_deferred();
        step.wave.keep_next(step.kept);
        if let Some(recorder) = step.recorder {
            recorder.keep_next(first_deferred);
        }
        if let Some(trainer) = step.trainer {
            trainer.keep_next(first_deferred);
        }
    }
}
