//! The options that choose an integrator and belong to it.
//!
//! An option that the integrator would not use is refused, as it would have no effect.

use super::super::value;
use super::options::options;
use super::{CachedOverrides, replace};
use crate::settings::{
    AoWeighting, HemisphereSampling, Integrator, Invalid, LightSampling, PathOptions, Stop, Survival,
};

options! {
    /// Options that are set here; the others are `None` and leave the integrator's defaults.
    #[command(next_help_heading = "Integrator")]
    pub struct IntegratorOverrides;
    options {
        /// Integrator: path (path tracing), cached (irradiance caching), montecarlo (a few bounces, many rays each),
        /// direct (direct light only), ao (ambient occlusion), flat (base colours), heat (cost of path), heat-lights
        /// (which lights are chosen), normals or albedo [default: path]
        #[arg(value_name = "NAME")]
        integrator: Integrator = value::integrator, in "render";
        /// path, heat: most surface hits on a path; 1 shows only emitters, 2 adds direct light [default: 1024]. direct:
        /// most surfaces seen through mirrors and glass [default: 32]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        max_depth: u32 = value::count, in "render";
        /// path, heat: sampling of lights: naive (bounces hit emitters by chance), direct (light sampling) or mis
        /// (both, by multiple importance sampling) [default: mis]
        #[arg(value_name = "HOW")]
        lights: LightSampling = value::lights, in "render";
        /// path, heat: what ends a path: depth (only --max-depth), threshold or roulette (Russian roulette) [default:
        /// roulette]
        #[arg(value_name = "RULE")]
        stop: Stop = value::stop, in "render";
        /// --stop threshold: end a path when its throughput falls below this in all channels [default: 0.01]
        #[arg(value_name = "C", allow_hyphen_values = true)]
        cutoff: f32 = value::fraction, in "render";
        /// --stop threshold: add the scene's mean radiance in place of the lost light
        #[arg(num_args = 0..=1, require_equals = true)]
        #[arg(value_name = "BOOL", default_missing_value = "true")]
        add_back: bool = value::flag, in "render";
        /// --stop roulette: number of surfaces before roulette starts [default: 3]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        roulette_after: u32 = value::number, in "render";
        /// --stop roulette: probability of survival, or `throughput` for that of the path, at most 0.95, or
        /// `root` for its square root [default: root]. montecarlo: continue after the bounces by roulette, one ray per surface [default: off]
        #[arg(value_name = "P", allow_hyphen_values = true)]
        survival: Survival = value::survival, in "render";
        /// path, heat: clamp contributions after two reflections and more to this radiance: fewer fireflies, less light
        /// [default: off]
        #[arg(value_name = "L", allow_hyphen_values = true)]
        clamp_indirect: f32 = value::clamp, in "render";
        /// path, heat: least roughness of gloss behind diffuse and other wide bounces: fewer fireflies, blurred caustics
        /// [default: 0]
        #[arg(value_name = "R", allow_hyphen_values = true)]
        filter_glossy: f32 = value::fraction, in "render";
        /// path: path guiding: trace N paths first to learn where light comes from; for rooms lit through a small
        /// opening [default: false; N is 524288]
        #[arg(num_args = 0..=1, require_equals = true)]
        #[arg(value_name = "N", default_missing_value = "true")]
        guide: u32 = value::guide, in "render";
        /// montecarlo: number of indirect bounces [default: 1]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        bounces: u32 = value::number, in "render";
        /// montecarlo, ao: rays per surface [default: 16]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        rays: u32 = value::count, in "render";
        /// montecarlo, ao: sampling of the hemisphere: uniform, cosine, stratified (by the cosine) or
        /// stratified-uniform [default: stratified]
        #[arg(value_name = "HOW")]
        sampling: HemisphereSampling = value::hemisphere_sampling, in "render";
        /// ao: value of a ray: misses (1 if it hits nothing) or hit-length (more, the farther the hit) [default:
        /// misses]
        #[arg(value_name = "HOW")]
        ao_weighting: AoWeighting = value::ao_weighting, in "render";
        /// ao: hits farther away than this do not occlude [default: the scene's diagonal]
        #[arg(value_name = "D", allow_hyphen_values = true)]
        ao_distance: f32 = value::distance, in "render";
    }
    others {
        /// Options of the irradiance cache.
        #[command(flatten)]
        cached: CachedOverrides;
    }
}

/// Options of paths; a stopping rule adds its own.
const PATH: [&str; 6] = ["max_depth", "lights", "stop", "clamp_indirect", "filter_glossy", "guide"];
/// Options of the paths whose cost is shown.
const HEAT: [&str; 5] = ["max_depth", "lights", "stop", "clamp_indirect", "filter_glossy"];

impl IntegratorOverrides {
    /// These options, and those of `fallback` where these are not set. Options belong to their integrator, and to
    /// their stopping rule: if another is chosen here, those of the fallback's do not count.
    pub(super) fn or(self, fallback: Self) -> Self {
        let replaces_integrator = self.integrator.as_ref().is_some_and(|new| new.name() != fallback.chosen().name());
        let replaces_stop = self.stop.is_some_and(|new| new.name() != fallback.stop.unwrap_or_default().name());
        let mut fallback = if replaces_integrator { Self::default() } else { fallback };
        if replaces_stop {
            let Self { stop, cutoff, add_back, roulette_after, survival, .. } = &mut fallback;
            (*stop, *cutoff, *add_back, *roulette_after, *survival) = (None, None, None, None, None);
        }
        self.or_each(fallback)
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
            Integrator::HeatLights | Integrator::Flat | Integrator::Normals | Integrator::Albedo => {}
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
        replace(&mut path.filter_glossy, self.filter_glossy);
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
            Integrator::Cached(_) => CachedOverrides::NAMES,
            Integrator::HeatLights | Integrator::Flat | Integrator::Normals | Integrator::Albedo => &[],
        };
        let stop = self.stop.unwrap_or_default();
        let follows_paths = matches!(integrator, Integrator::Path(_) | Integrator::Heat(_));
        let used_by_stop: &[&str] = match (follows_paths, stop) {
            (true, Stop::Threshold { .. }) => &["cutoff", "add_back"],
            (true, Stop::Roulette { .. }) => &["roulette_after", "survival"],
            _ => &[],
        };
        let given = self.given().filter(|&(name, _)| name != "integrator").chain(self.cached.given());
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
            _ => format!(
                "leave it out; used are {}",
                known.iter().map(|name| option(name)).collect::<Vec<_>>().join(", ")
            ),
        };
        Err(Invalid::new(format!("{user} does not use {}", option(name)), remedy))
    }
}

/// An option as it is written on the command line; its key in a scene file has `_` for `-`.
fn option(name: &str) -> String {
    format!("--{}", name.replace('_', "-"))
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
            "the integrator `path` with the stop `roulette` does not use --cutoff\n  \
             help: leave it out; used are --max-depth, --lights, --stop, --clamp-indirect, --filter-glossy, --guide, --roulette-after, --survival"
        );
        assert_eq!(
            problem(IntegratorOverrides { rays: Some(3), ..named("flat") }),
            "the integrator `flat` does not use --rays\n  help: leave it out, or choose another integrator"
        );
        assert_eq!(
            problem(IntegratorOverrides { cutoff: Some(0.1), ..named("montecarlo") }),
            "the integrator `montecarlo` does not use --cutoff\n  help: leave it out; used are --bounces, --rays, --sampling, --survival"
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
