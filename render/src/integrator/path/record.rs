//! Contributions of a step of paths to AOVs by light path expressions; it costs nothing without them.

use glam::Vec3;

use super::Advance;
use crate::integrator::light_paths::{LightPaths, Lobe};
use crate::integrator::path_block::{BlockClosures, Bounces, PathBlock, ShadowRays};
use crate::integrator::shadow_queue::ShadowQueue;
use crate::integrator::wavefront::first_set;
use crate::world::{Hit, WHITE};

/// Memory from one batch to the next.
#[derive(Default)]
pub(crate) struct RecorderMemory {
    /// The state of each path in each channel.
    states: Vec<[u32; 3]>,
    /// The states of the continuing paths.
    next: Vec<[u32; 3]>,
    /// Those of the aimed paths.
    aimed: Vec<[u32; 3]>,
    waiting: Vec<Waiting>,
    /// Those whose shadow rays are deferred.
    deferred: Vec<Waiting>,
}

/// A part of a light sample that waits for its shadow ray.
struct Waiting {
    shadow_ray: usize,
    index: usize,
    states: [u32; 3],
    light: Vec3,
}

/// The destination of AOVs.
pub(in crate::integrator) struct Recorder<'a> {
    paths: &'a LightPaths,
    memory: &'a mut RecorderMemory,
    /// The AOVs of each camera ray, side by side.
    aovs: &'a mut [Vec3],
}

/// The lobes of a closure for one direction.
struct Lobes {
    /// The part of it that its glossy lobes do, by channel.
    glossy: Vec3,
    mesh: usize,
    transmits: bool,
}

impl<'a> Recorder<'a> {
    /// A recorder for a batch of camera rays.
    pub(in crate::integrator) fn new(
        paths: &'a LightPaths,
        memory: &'a mut RecorderMemory,
        count: usize,
        aovs: &'a mut [Vec3],
    ) -> Self {
        memory.states.clear();
        memory.states.resize(count, paths.start());
        memory.next.clear();
        memory.aimed.clear();
        memory.waiting.clear();
        memory.deferred.clear();
        aovs.fill(Vec3::ZERO);
        Self { paths, memory, aovs }
    }

    fn add(&mut self, index: usize, states: [u32; 3], light: Vec3) {
        let count = self.paths.count();
        self.paths.add(states, light, &mut self.aovs[index * count..][..count]);
    }

    /// Replaces all paths by the continuing ones, and lets deferred light samples wait, whose first shadow ray has this
    /// number.
    pub(super) fn keep_next(&mut self, first_deferred: usize) {
        let RecorderMemory { states, next, aimed, waiting, deferred } = &mut *self.memory;
        next.append(aimed);
        std::mem::swap(states, next);
        next.clear();
        waiting.extend(deferred.drain(..).map(|w| Waiting { shadow_ray: first_deferred + w.shadow_ray, ..w }));
    }

    /// Adds the light samples whose shadow rays are free.
    pub(super) fn resolve(&mut self, queue: &ShadowQueue) {
        let mut waiting = std::mem::take(&mut self.memory.waiting);
        for Waiting { shadow_ray, index, states, light } in waiting.drain(..) {
            if queue.is_free(shadow_ray) {
                self.add(index, states, light);
            }
        }
        self.memory.waiting = waiting;
    }

    /// The parts of a light sample, each of which waits for the shadow ray.
    fn parts(
        &self,
        (shadow_ray, index): (usize, usize),
        (before, event): ([u32; 3], u32),
        (light, lobes): (Vec3, &Lobes),
    ) -> impl Iterator<Item = Waiting> + use<'a> {
        let (glossy, paths, mesh, transmits) = (light * lobes.glossy, self.paths, lobes.mesh, lobes.transmits);
        let parts = [(Lobe::Wide, light - glossy), (Lobe::Glossy, glossy)];
        parts.into_iter().filter(|(_, light)| *light != Vec3::ZERO).map(move |(lobe, light)| {
            let scattered = paths.after(before, paths.surface(mesh, transmits, lobe));
            Waiting { shadow_ray, index, states: paths.after(scattered, event), light }
        })
    }

    /// The states of a continuing path, by a number in [0, 1) that chooses its lobe.
    fn onwards(&self, before: [u32; 3], lobes: &Lobes, is_delta: bool, u: f32) -> [u32; 3] {
        let chosen = |part: f32| match () {
            () if is_delta => Lobe::Delta,
            () if u < part => Lobe::Glossy,
            () => Lobe::Wide,
        };
        let event = |part: f32| self.paths.surface(lobes.mesh, lobes.transmits, chosen(part));
        let after = |c: usize| self.paths.after(before, event(lobes.glossy[c]))[c];
        [after(0), after(1), after(2)]
    }
}

impl Advance<'_, '_> {
    /// Records light that a path has found on a surface.
    pub(super) fn record_emission(&mut self, source: usize, light: Vec3) {
        if let Some(recorder) = &mut self.recorder {
            let mesh = self.world.mesh_number(self.wave.hits[source].prim_id);
            let states = recorder.paths.after(recorder.memory.states[source], recorder.paths.emitter(mesh));
            recorder.add(self.wave.paths[source].index as usize, states, light);
        }
    }

    /// Records light that a path has found in the sky.
    pub(super) fn record_sky(&mut self, source: usize, light: Vec3) {
        if let Some(recorder) = &mut self.recorder {
            let states = recorder.paths.after(recorder.memory.states[source], recorder.paths.sky());
            recorder.add(self.wave.paths[source].index as usize, states, light);
        }
    }

    /// Records what a path has found of the light of this number, on its way.
    pub(super) fn record_light(&mut self, source: usize, number: u32, light: Vec3) {
        if let Some(recorder) = &mut self.recorder {
            let event = recorder.paths.light(self.world, number);
            let states = recorder.paths.after(recorder.memory.states[source], event);
            recorder.add(self.wave.paths[source].index as usize, states, light);
        }
    }

    /// Records that a pane has reflected a path.
    pub(super) fn record_mirrored(&mut self, source: usize, pane: &Hit) {
        if let Some(recorder) = &mut self.recorder {
            let event = recorder.paths.surface(self.world.mesh_number(pane.prim_id), false, Lobe::Delta);
            recorder.memory.states[source] = recorder.paths.after(recorder.memory.states[source], event);
        }
    }

    /// Records the light samples of a block, which are about to join the shadow queue.
    #[inline(never)]
    pub(super) fn record_light_samples<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        shadows: &ShadowRays,
        light: impl Fn(&PathBlock, usize) -> u32,
    ) {
        let lit = (0..block.len).filter(|&i| shadows.is_lit(i));
        for (shadow_ray, i) in (self.wave.shadow_queue.len()..).zip(lit) {
            let found = (shadow_ray, light(block, i), shadows.direction(i), shadows.light(i));
            self.record_light_sample(closures, block, i, found, |memory| &mut memory.waiting);
        }
    }

    /// Records a light sample of path `i` whose shadow ray is deferred, with its place among those.
    pub(super) fn record_deferred<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        i: usize,
        found: (usize, u32, Vec3, Vec3),
    ) {
        self.record_light_sample(closures, block, i, found, |memory| &mut memory.deferred);
    }

    /// Records a light sample of path `i`: the number of its shadow ray, its light's number, its direction, its light.
    fn record_light_sample<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        i: usize,
        (shadow_ray, number, direction, light): (usize, u32, Vec3, Vec3),
        list: impl Fn(&mut RecorderMemory) -> &mut Vec<Waiting>,
    ) {
        let lobes = self.lobes(closures, block, i, direction);
        if let Some(recorder) = &mut self.recorder {
            let event = recorder.paths.light(self.world, number);
            let before = recorder.memory.states[block.source[i] as usize];
            let parts = recorder.parts((shadow_ray, block.index(i)), (before, event), (light, &lobes));
            list(recorder.memory).extend(parts);
        }
    }

    /// Records the bounces of a block's paths.
    #[inline(never)]
    pub(super) fn record_bounces<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock, bounces: &Bounces) {
        for i in (0..block.len).filter(|&i| bounces.goes_on[i] != 0) {
            let is_delta = bounces.density(i) == f32::INFINITY;
            let states = self.states_onwards(closures, block, i, (bounces.direction(i), is_delta, 2));
            self.recorder.iter_mut().for_each(|recorder| recorder.memory.next.push(states));
        }
    }

    /// Records that path `i` continues as one that is aimed in a direction.
    pub(super) fn record_aimed<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        i: usize,
        direction: Vec3,
    ) {
        let states = self.states_onwards(closures, block, i, (direction, false, 3));
        self.recorder.iter_mut().for_each(|recorder| recorder.memory.aimed.push(states));
    }

    /// The states of path `i` if it continues in a direction, by a delta function or not; its lobe is chosen by an
    /// unused number of the path's set for the bounce.
    fn states_onwards<C: BlockClosures>(
        &self,
        closures: &C,
        block: &PathBlock,
        i: usize,
        (direction, is_delta, place): (Vec3, bool, usize),
    ) -> [u32; 3] {
        let lobes = self.lobes(closures, block, i, direction);
        let sampler = &self.batch.samplers[block.index(i)];
        let u = sampler.uniform4(first_set(self.batch, self.depth) + 2)[place];
        self.recorder.as_ref().map_or([0; 3], |recorder| {
            let before = recorder.memory.states[block.source[i] as usize];
            recorder.onwards(before, &lobes, is_delta, u)
        })
    }

    /// The lobes of path `i`'s closure for a direction.
    fn lobes<C: BlockClosures>(&self, closures: &C, block: &PathBlock, i: usize, direction: Vec3) -> Lobes {
        let (surface, direction) = (block.surface(i, &WHITE), direction.normalize_or_zero());
        let all = closures.eval(i, &surface, direction).0;
        let glossy = closures.glossy(i, direction) / all;
        Lobes {
            glossy: Vec3::select(all.cmpgt(Vec3::ZERO), glossy.clamp(Vec3::ZERO, Vec3::ONE), Vec3::ZERO),
            mesh: self.world.mesh_number(self.wave.hits[block.source[i] as usize].prim_id),
            transmits: surface.normal.dot(direction) < 0.0,
        }
    }
}
