//! The options that choose an integrator and belong to it.
//!
//! An option that the integrator would not use is refused: whoever gives it expects something else than would happen.

use clap::Args;

use super::super::value::{self, argument};
use super::{CachedOverrides, replace};
use crate::settings::{
    AoWeighting, HemisphereSampling, Integrator, Invalid, LightSampling, PathOptions, Stop, Survival,
};

/// Options that are set here; the others are `None` and leave the integrator's defaults.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Integrator")]
pub struct IntegratorOverrides {
    /// Integrator: path (path tracing), cached (irradiance caching), montecarlo (a few bounces, many rays each), direct
    /// (direct light only), ao (ambient occlusion), flat (base colours), heat (cost of path), normals or albedo
    /// [default: path]
    #[arg(long, value_name = "NAME", value_parser = argument(value::integrator))]
    pub integrator: Option<Integrator>,
    /// path, heat: most surface hits on a path; 1 shows only emitters, 2 adds direct light [default: 1024]. direct:
    /// most surfaces seen through mirrors and glass [default: 32]
    #[arg(long, value_name = "N", value_parser = argument(value::count), allow_negative_numbers = true)]
    pub max_depth: Option<u32>,
    /// path, heat: how light is found: naive (bounces hit emitters by chance), direct (light sampling) or mis (both, by
    /// multiple importance sampling) [default: mis]
    #[arg(long, value_name = "HOW", value_parser = argument(value::lights))]
    pub lights: Option<LightSampling>,
    /// path, heat: what ends a path: depth (only --max-depth), threshold or roulette (Russian roulette) [default:
    /// roulette]
    #[arg(long, value_name = "RULE", value_parser = argument(value::stop))]
    pub stop: Option<Stop>,
    /// --stop threshold: end a path when its throughput falls below this in all channels [default: 0.01]
    #[arg(long, value_name = "C", value_parser = argument(value::fraction), allow_negative_numbers = true)]
    pub cutoff: Option<f32>,
    /// --stop threshold: add the scene's mean radiance in place of the light that is cut off
    #[arg(long, num_args = 0..=1, require_equals = true)]
    #[arg(value_name = "BOOL", default_missing_value = "true", value_parser = argument(value::flag))]
    pub add_back: Option<bool>,
    /// --stop roulette: number of surfaces before roulette starts [default: 3]
    #[arg(long, value_name = "N", value_parser = argument(value::number), allow_negative_numbers = true)]
    pub roulette_after: Option<u32>,
    /// --stop roulette: probability of survival, or `throughput` for that of the path, at most 0.95 [default:
    /// throughput]. montecarlo: continue after the bounces by roulette, one ray per surface [default: off]
    #[arg(long, value_name = "P", value_parser = argument(value::survival), allow_negative_numbers = true)]
    pub survival: Option<Survival>,
    /// path, heat: scale down what a light adds after two reflections and more to at most this radiance: fewer
    /// fireflies, less light [default: off]
    #[arg(long, value_name = "L", value_parser = argument(value::clamp), allow_negative_numbers = true)]
    pub clamp_indirect: Option<f32>,
    /// path: trace paths before the picture and learn from them where light comes from, for rooms that are lit through a
    /// window or a door ajar; =N by so many paths [default: false; N is 524288]
    #[arg(long, num_args = 0..=1, require_equals = true)]
    #[arg(value_name = "N", default_missing_value = "true", value_parser = argument(value::guide))]
    pub guide: Option<u32>,
    /// montecarlo: number of indirect bounces [default: 1]
    #[arg(long, value_name = "N", value_parser = argument(value::number), allow_negative_numbers = true)]
    pub bounces: Option<u32>,
    /// montecarlo, ao: rays per surface [default: 16]
    #[arg(long, value_name = "N", value_parser = argument(value::count), allow_negative_numbers = true)]
    pub rays: Option<u32>,
    /// montecarlo, ao: sampling of the hemisphere: uniform, cosine, stratified (by the cosine) or stratified-uniform
    /// [default: stratified]
    #[arg(long, value_name = "HOW", value_parser = argument(value::hemisphere_sampling))]
    pub sampling: Option<HemisphereSampling>,
    /// ao: value of a ray: misses (1 if it hits nothing) or hit-length (more, the farther the hit) [default: misses]
    #[arg(long, value_name = "HOW", value_parser = argument(value::ao_weighting))]
    pub ao_weighting: Option<AoWeighting>,
    /// ao: hits farther away than this do not occlude [default: the scene's diagonal]
    #[arg(long, value_name = "D", value_parser = argument(value::distance), allow_negative_numbers = true)]
    pub ao_distance: Option<f32>,
    /// Options of the irradiance cache.
    #[command(flatten)]
    pub cached: CachedOverrides,
}

/// What paths have; a stopping rule adds its own.
const PATH: [&str; 5] = ["max_depth", "lights", "stop", "clamp_indirect", "guide"];
/// What those have whose cost is shown.
const HEAT: [&str; 4] = ["max_depth", "lights", "stop", "clamp_indirect"];

impl IntegratorOverrides {
    /// These options, and those of `fallback` where these are not set. Options belong to their integrator, and to
    /// their stopping rule: if another is chosen here, those of the fallback's do not count.
    pub(super) fn or(self, fallback: Self) -> Self {
        let replaces_integrator = self.integrator.as_ref().is_some_and(|new| new.name() != fallback.chosen().name());
        let replaces_stop = self.stop.is_some_and(|new| new.name() != fallback.stop.unwrap_or_default().name());
        let fallback = if replaces_integrator { Self::default() } else { fallback };
        let rule = if replaces_stop { Self::default() } else { fallback.clone() };
        Self {
            integrator: self.integrator.or(fallback.integrator),
            max_depth: self.max_depth.or(fallback.max_depth),
            lights: self.lights.or(fallback.lights),
            stop: self.stop.or(rule.stop),
            cutoff: self.cutoff.or(rule.cutoff),
            add_back: self.add_back.or(rule.add_back),
            roulette_after: self.roulette_after.or(rule.roulette_after),
            survival: self.survival.or(rule.survival),
            clamp_indirect: self.clamp_indirect.or(fallback.clamp_indirect),
            guide: self.guide.or(fallback.guide),
            bounces: self.bounces.or(fallback.bounces),
            rays: self.rays.or(fallback.rays),
            sampling: self.sampling.or(fallback.sampling),
            ao_weighting: self.ao_weighting.or(fallback.ao_weighting),
            ao_distance: self.ao_distance.or(fallback.ao_distance),
            cached: self.cached.or(fallback.cached),
        }
    }

    /// The integrator with these options in place of its defaults.
    pub(super) fn integrator(&self) -> Result<Integrator, Invalid> {
        let mut integrator = self.chosen();
        self.refuse_unused(&integrator)?;
        match &mut integrator {
            Integrator::Path(path) | Integrator::Heat(path) => self.set_path(path),
            Integrator::MonteCarlo(options) => {
                replace(&mut options.bounces, self.bounces);
                replace(&mut options.rays, self.rays);
                replace(&mut options.sampling, self.sampling);
                options.tail = self.survival.or(options.tail);
            }
            Integrator::Direct(options) => replace(&mut options.max_depth, self.max_depth),
            Integrator::Ao(options) => {
                replace(&mut options.weighting, self.ao_weighting);
                options.max_distance = self.ao_distance.or(options.max_distance);
                replace(&mut options.rays, self.rays);
                replace(&mut options.sampling, self.sampling);
            }
            Integrator::Cached(options) => *options = self.cached.options(),
            Integrator::Flat | Integrator::Normals | Integrator::Albedo => {}
        }
        integrator.check()?;
        Ok(integrator)
    }

    /// Whether any option is set.
    pub(super) fn sets_any(&self) -> bool {
        *self != Self::default()
    }

    fn chosen(&self) -> Integrator {
        self.integrator.clone().unwrap_or(Integrator::Path(PathOptions::default()))
    }

    fn set_path(&self, path: &mut PathOptions) {
        replace(&mut path.max_depth, self.max_depth);
        replace(&mut path.lights, self.lights);
        replace(&mut path.stop, self.stop);
        path.clamp_indirect = self.clamp_indirect.or(path.clamp_indirect);
        if let Some(paths) = self.guide {
            path.guide = (paths > 0).then_some(paths);
        }
        match &mut path.stop {
            Stop::Depth => {}
            Stop::Threshold { cutoff, add_back } => {
                replace(cutoff, self.cutoff);
                replace(add_back, self.add_back);
            }
            Stop::Roulette { after, survival } => {
                replace(after, self.roulette_after);
                replace(survival, self.survival);
            }
        }
    }

    /// Refuses options that belong to another integrator or stopping rule.
    fn refuse_unused(&self, integrator: &Integrator) -> Result<(), Invalid> {
        let used: &[&str] = match integrator {
            Integrator::Path(_) => &PATH,
            Integrator::Heat(_) => &HEAT,
            Integrator::MonteCarlo(_) => &["bounces", "rays", "sampling", "survival"],
            Integrator::Direct(_) => &["max_depth"],
            Integrator::Ao(_) => &["rays", "sampling", "ao_weighting", "ao_distance"],
            Integrator::Cached(_) => &CachedOverrides::NAMES,
            Integrator::Flat | Integrator::Normals | Integrator::Albedo => &[],
        };
        let stop = self.stop.unwrap_or_default();
        let follows_paths = matches!(integrator, Integrator::Path(_) | Integrator::Heat(_));
        let used_by_stop: &[&str] = match (follows_paths, stop) {
            (true, Stop::Threshold { .. }) => &["cutoff", "add_back"],
            (true, Stop::Roulette { .. }) => &["roulette_after", "survival"],
            _ => &[],
        };
        let given = [
            ("max_depth", self.max_depth.is_some()),
            ("lights", self.lights.is_some()),
            ("stop", self.stop.is_some()),
            ("cutoff", self.cutoff.is_some()),
            ("add_back", self.add_back.is_some()),
            ("roulette_after", self.roulette_after.is_some()),
            ("survival", self.survival.is_some()),
            ("clamp_indirect", self.clamp_indirect.is_some()),
            ("guide", self.guide.is_some()),
            ("bounces", self.bounces.is_some()),
            ("rays", self.rays.is_some()),
            ("sampling", self.sampling.is_some()),
            ("ao_weighting", self.ao_weighting.is_some()),
            ("ao_distance", self.ao_distance.is_some()),
        ];
        let given = given.into_iter().chain(self.cached.given());
        let is_unused = |name: &str| !used.contains(&name) && !used_by_stop.contains(&name);
        let Some((name, _)) = { given }.find(|&(name, is_given)| is_given && is_unused(name)) else {
            return Ok(());
        };
        let of_stop = matches!(name, "cutoff" | "add_back" | "roulette_after" | "survival");
        let user = match integrator.name() {
            path if of_stop && follows_paths => format!("the integrator `{path}` with the stop `{}`", stop.name()),
            other => format!("the integrator `{other}`"),
        };
        let known = [used, used_by_stop].concat();
        let remedy = match known.len() {
            0 => "leave it out, or choose another integrator".to_owned(),
            _ => format!("leave it out; used are {}", known.join(", ")),
        };
        Err(Invalid::new(format!("{user} does not use `{name}`"), remedy))
    }
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::AoOptions;

    fn named(name: &str) -> IntegratorOverrides {
        IntegratorOverrides { integrator: Integrator::named(name), ..Default::default() }
    }

    fn problem(overrides: IntegratorOverrides) -> String {
        overrides.integrator().unwrap_err().to_string()
    }

    #[test]
    fn options_replace_the_defaults_of_their_integrator() {
        let roulette = IntegratorOverrides {
            roulette_after: Some(0),
            survival: Some(Survival::Constant(0.8)),
            lights: Some(LightSampling::Naive),
            ..Default::default()
        };
        let path = PathOptions {
            lights: LightSampling::Naive,
            stop: Stop::Roulette { after: 0, survival: Survival::Constant(0.8) },
            ..PathOptions::default()
        };
        assert_eq!(roulette.integrator().unwrap(), Integrator::Path(path.clone()));
        let heat = IntegratorOverrides { integrator: Integrator::named("heat"), ..roulette };
        assert_eq!(heat.integrator().unwrap(), Integrator::Heat(path));
        let ao = IntegratorOverrides { ao_distance: Some(2.0), rays: Some(5), ..named("ao") };
        let expected = AoOptions { max_distance: Some(2.0), rays: 5, ..AoOptions::default() };
        assert_eq!(ao.integrator().unwrap(), Integrator::Ao(expected));
    }

    #[test]
    fn options_of_others_are_refused() {
        let cutoff = IntegratorOverrides { cutoff: Some(0.1), ..Default::default() };
        assert_eq!(
            problem(cutoff.clone()),
            "the integrator `path` with the stop `roulette` does not use `cutoff`\n  \
             help: leave it out; used are max_depth, lights, stop, clamp_indirect, guide, roulette_after, survival"
        );
        assert_eq!(
            problem(IntegratorOverrides { rays: Some(3), ..named("flat") }),
            "the integrator `flat` does not use `rays`\n  help: leave it out, or choose another integrator"
        );
        assert_eq!(
            problem(IntegratorOverrides { cutoff: Some(0.1), ..named("montecarlo") }),
            "the integrator `montecarlo` does not use `cutoff`\n  help: leave it out; used are bounces, rays, sampling, survival"
        );
        let threshold = Stop::named("threshold");
        assert!(IntegratorOverrides { stop: threshold, ..cutoff }.integrator().is_ok());
        assert!(IntegratorOverrides { stop: threshold, ..named("direct") }.integrator().is_err());
    }

    #[test]
    fn a_new_integrator_or_rule_comes_without_the_options_of_the_old_one() {
        let file = IntegratorOverrides { max_depth: Some(5), roulette_after: Some(7), ..Default::default() };
        assert_eq!(named("ao").or(file.clone()).integrator(), named("ao").integrator());
        let deep = Integrator::Path(PathOptions {
            max_depth: 5,
            stop: Stop::Roulette { after: 7, survival: Survival::default() },
            ..PathOptions::default()
        });
        assert_eq!(named("path").or(file.clone()).integrator(), Ok(deep));
        let by_depth = IntegratorOverrides { stop: Stop::named("depth"), ..Default::default() };
        let expected = PathOptions { max_depth: 5, stop: Stop::Depth, ..PathOptions::default() };
        assert_eq!(by_depth.or(file).integrator(), Ok(Integrator::Path(expected)));
    }
}
