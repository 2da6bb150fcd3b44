//! Runs experiments: renders whose pixels are independent runs.

use std::cell::Cell;

use crate::driver;
use crate::scene::fnv;
use crate::settings::Filter;
use crate::settings::Settings;
use crate::watch::Watch;
use crate::world::World;

/// The amount of measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// An eighth of the runs, or of the samples, to see whether all is well.
    Quick,
    /// As much as figures need.
    Full,
}

/// Someone has stopped the experiment, which has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interrupted;

/// Runs the renders of experiments.
pub(crate) struct Runner<'a> {
    effort: Effort,
    watch: &'a dyn Watch,
    seed: u64,
    /// Renders made with this seed.
    renders: Cell<u64>,
}

/// The result of a render.
pub(super) struct Runs {
    /// Radiance, one value a pixel.
    pub values: Vec<f64>,
    /// Rays traced.
    pub rays: u64,
}

impl<'a> Runner<'a> {
    /// A lab that makes the same experiments whenever it has the same `effort` and `seed`.
    pub(crate) fn new(effort: Effort, seed: u64, watch: &'a dyn Watch) -> Self {
        Self { effort, watch, seed, renders: Cell::new(0) }
    }

    /// The lab with random numbers that belong to `name`: so experiments come out the same in any company.
    pub(super) fn for_experiment(&self, name: &str) -> Self {
        let seed = fnv(&[&self.seed.to_le_bytes()[..], name.as_bytes()].concat());
        Self { seed, renders: Cell::new(0), ..*self }
    }

    /// Selects the random numbers of experiments that need more than renders.
    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

    /// The watcher, which may stop an experiment.
    pub(super) fn watch(&self) -> &'a dyn Watch {
        self.watch
    }

    /// `full`, or an eighth of it for a quick look, at least one.
    pub(super) fn share(&self, full: u32) -> u32 {
        match self.effort {
            Effort::Full => full,
            Effort::Quick => (full / 8).max(1),
        }
    }

    /// Renders a grey world, each time with random numbers of its own, under a box filter of one pixel.
    pub(super) fn render(&self, world: &World, settings: Settings) -> Result<Runs, Interrupted> {
        let seed = self.seed.wrapping_add(self.renders.replace(self.renders.get() + 1));
        let settings = Settings { seed, filter: Filter::Box { width: 1.0 }, ..settings };
        let render = driver::render(world, &settings, self.watch);
        if !render.finished {
            return Err(Interrupted);
        }
        let channel = render.picture.channel("G").expect("every picture has colours");
        Ok(Runs { values: channel.values.iter().copied().map(f64::from).collect(), rays: render.rays })
    }
}
