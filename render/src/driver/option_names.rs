//! The options of a render that its film must agree with, as they are written on the command line, for films' headers.

use crate::cache;
use crate::settings::{AoOptions, DirectOptions, Filter, Integrator, MonteCarloOptions, PathOptions, Stop, Survival};

/// Options and their values.
pub(super) type Named = Vec<(String, String)>;

/// The pixel filter's options.
pub(super) fn of_filter(filter: &Filter) -> Named {
    let mut named = vec![option("filter", filter.name()), option("filter-width", filter.width())];
    if let Filter::Mitchell { sharpness, .. } = filter {
        named.push(option("sharpness", sharpness));
    }
    named
}

/// The integrator's own options.
pub(super) fn of_integrator(integrator: &Integrator) -> Named {
    match integrator {
        Integrator::Path(path) | Integrator::Heat(path) => of_path(path),
        Integrator::MonteCarlo(MonteCarloOptions { bounces, rays, sampling, tail }) => vec![
            option("bounces", bounces),
            option("rays", rays),
            option("sampling", sampling.name()),
            option("survival", tail.map_or("off".to_owned(), survival)),
        ],
        Integrator::Direct(DirectOptions { max_depth }) => vec![option("max-depth", max_depth)],
        Integrator::Ao(AoOptions { weighting, max_distance, rays, sampling }) => vec![
            option("ao-weighting", weighting.name()),
            option("ao-distance", or(*max_distance, "the scene's diagonal")),
            option("rays", rays),
            option("sampling", sampling.name()),
        ],
        Integrator::Cached(options) => {
            cache::named(options).into_iter().map(|(name, value)| option(name, value)).collect()
        }
        Integrator::HeatLights | Integrator::Flat | Integrator::Normals | Integrator::Albedo => Vec::new(),
    }
}

fn of_path(PathOptions { max_depth, lights, stop, clamp_indirect, filter_glossy, guide }: &PathOptions) -> Named {
    let mut named = vec![
        option("max-depth", max_depth),
        option("lights", lights.name()),
        option("stop", stop.name()),
        option("clamp-indirect", or(*clamp_indirect, "off")),
        option("filter-glossy", filter_glossy),
        option("guide", or(*guide, "off")),
    ];
    match stop {
        Stop::Depth => {}
        Stop::Threshold { cutoff, add_back } => {
            named.extend([option("cutoff", cutoff), option("add-back", add_back)]);
        }
        Stop::Roulette { after, survival: of } => {
            named.extend([option("roulette-after", after), option("survival", survival(*of))]);
        }
    }
    named
}

fn survival(of: Survival) -> String {
    match of {
        Survival::Constant(probability) => probability.to_string(),
        Survival::Throughput { max } => format!("throughput, at most {max}"),
        Survival::RootThroughput => "root".to_owned(),
    }
}

fn or(value: Option<impl ToString>, otherwise: &str) -> String {
    value.map_or(otherwise.to_owned(), |value| value.to_string())
}

fn option(name: &str, value: impl ToString) -> (String, String) {
    (format!("--{name}"), value.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{
        AoWeighting, CachedOptions, GatherLayout, Gradients, HemisphereSampling, LightSampling, Metric,
    };

    /// Integrators with each option once at another value.
    fn other_integrators() -> Vec<Integrator> {
        let (cosine, uniform) = (HemisphereSampling::Cosine, HemisphereSampling::Uniform);
        let montecarlo = MonteCarloOptions { bounces: 7, rays: 5, sampling: cosine, tail: None };
        let tail = |survival: Survival| MonteCarloOptions { tail: Some(survival), ..montecarlo.clone() };
        let ao = AoOptions { weighting: AoWeighting::CacheMisses, max_distance: Some(2.0), rays: 7, sampling: cosine };
        let cached = CachedOptions::default();
        let all_montecarlo = [
            MonteCarloOptions { bounces: 8, ..montecarlo.clone() },
            MonteCarloOptions { rays: 6, ..montecarlo.clone() },
            MonteCarloOptions { sampling: uniform, ..montecarlo.clone() },
            tail(Survival::Constant(0.5)),
            tail(Survival::Constant(0.25)),
            tail(Survival::Throughput { max: 0.5 }),
            montecarlo,
        ];
        let all_ao = [
            AoOptions { weighting: AoWeighting::HitLength, ..ao.clone() },
            AoOptions { max_distance: Some(3.0), ..ao.clone() },
            AoOptions { max_distance: None, ..ao.clone() },
            AoOptions { rays: 8, ..ao.clone() },
            AoOptions { sampling: uniform, ..ao.clone() },
            ao,
        ];
        let all_cached = [
            CachedOptions { error: 0.2, ..cached },
            CachedOptions { gradients: Gradients::Off, ..cached },
            CachedOptions { metric: Metric::Bounded, ..cached },
            CachedOptions { layout: GatherLayout::Hemicube, ..cached },
            CachedOptions { rays: 100, ..cached },
            CachedOptions { bounces: Some(2), ..cached },
            CachedOptions { bounces: Some(3), ..cached },
            CachedOptions { accuracy: Some(0.01), ..cached },
            CachedOptions { accuracy: Some(0.02), ..cached },
        ];
        let direct = [6, 7].map(|max_depth| Integrator::Direct(DirectOptions { max_depth }));
        let others =
            all_montecarlo.into_iter().map(Integrator::MonteCarlo).chain(all_ao.into_iter().map(Integrator::Ao));
        others.chain(direct).chain(all_cached.into_iter().map(Integrator::Cached)).collect()
    }

    /// Otherwise films with different options would pass for parts of one picture.
    #[test]
    fn every_option_makes_a_difference() {
        let path = PathOptions::default();
        let others = [
            PathOptions { max_depth: 3, ..path.clone() },
            PathOptions { lights: LightSampling::Naive, ..path.clone() },
            PathOptions { clamp_indirect: Some(2.0), ..path.clone() },
            PathOptions { filter_glossy: 0.5, ..path.clone() },
            PathOptions { guide: Some(4096), ..path.clone() },
            PathOptions { stop: Stop::Depth, ..path.clone() },
            PathOptions { stop: Stop::Threshold { cutoff: 0.1, add_back: true }, ..path.clone() },
            PathOptions { stop: Stop::Threshold { cutoff: 0.1, add_back: false }, ..path.clone() },
            PathOptions { stop: Stop::Roulette { after: 4, survival: Survival::default() }, ..path.clone() },
            PathOptions { stop: Stop::Roulette { after: 3, survival: Survival::Constant(0.5) }, ..path.clone() },
        ];
        let mut all: Vec<Named> = others.into_iter().map(|it| of_integrator(&Integrator::Path(it))).collect();
        assert!(all[0].contains(&("--max-depth".to_owned(), "3".to_owned())), "{:?}", all[0]);
        all.push(of_integrator(&Integrator::Path(path)));
        all.extend(Integrator::NAMES[1..6].iter().map(|name| of_integrator(&Integrator::named(name).unwrap())));
        all.extend(other_integrators().iter().map(of_integrator));
        all.extend(
            [("mitchell", 4.0, None), ("mitchell", 3.0, None), ("mitchell", 3.0, Some(0.5)), ("tent", 3.0, None)]
                .map(|(name, width, sharpness)| of_filter(&Filter::from_name(name, Some(width), sharpness).unwrap())),
        );
        for (i, named) in all.iter().enumerate() {
            assert!(!all[..i].contains(named), "{named:?}");
        }
    }
}
