//! The options of a render that its film must agree with, as they are written on the command line, for films' headers.

use crate::cache;
use crate::settings::{
    AoOptions, AoWeighting, DirectOptions, Filter, HemisphereSampling, Integrator, LightSampling, MonteCarloOptions,
    PathOptions, Stop, Survival,
};

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
            option("sampling", hemisphere_sampling(*sampling)),
            option("survival", tail.map_or("off".to_owned(), survival)),
        ],
        Integrator::Direct(DirectOptions { max_depth }) => vec![option("max-depth", max_depth)],
        Integrator::Ao(AoOptions { weighting, max_distance, rays, sampling }) => vec![
            option(
                "ao-weighting",
                match weighting {
                    AoWeighting::CacheMisses => "misses",
                    AoWeighting::HitLength => "hit-length",
                },
            ),
            option("ao-distance", or(*max_distance, "the scene's diagonal")),
            option("rays", rays),
            option("sampling", hemisphere_sampling(*sampling)),
        ],
        Integrator::Cached(options) => {
            cache::named(options).into_iter().map(|(name, value)| option(name, value)).collect()
        }
        Integrator::HeatLights | Integrator::Flat | Integrator::Normals | Integrator::Albedo => Vec::new(),
    }
}

fn of_path(PathOptions { max_depth, lights, stop, clamp_indirect, guide }: &PathOptions) -> Named {
    let lights = match lights {
        LightSampling::Naive => "naive",
        LightSampling::Direct => "direct",
        LightSampling::Mis => "mis",
    };
    let mut named = vec![
        option("max-depth", max_depth),
        option("lights", lights),
        option("stop", stop.name()),
        option("clamp-indirect", or(*clamp_indirect, "off")),
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

fn hemisphere_sampling(of: HemisphereSampling) -> &'static str {
    match of {
        HemisphereSampling::Uniform => "uniform",
        HemisphereSampling::Cosine => "cosine",
        HemisphereSampling::Stratified => "stratified",
        HemisphereSampling::StratifiedUniform => "stratified-uniform",
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

    /// Otherwise films with different options would pass for parts of one picture.
    #[test]
    fn every_option_makes_a_difference() {
        let path = PathOptions::default();
        let others = [
            PathOptions { max_depth: 3, ..path.clone() },
            PathOptions { lights: LightSampling::Naive, ..path.clone() },
            PathOptions { clamp_indirect: Some(2.0), ..path.clone() },
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
        all.extend(
            [("mitchell", 4.0), ("mitchell", 3.0), ("tent", 3.0)]
                .map(|(name, width)| of_filter(&Filter::from_name(name, Some(width), None).unwrap())),
        );
        for (i, named) in all.iter().enumerate() {
            assert!(!all[..i].contains(named), "{named:?}");
        }
    }
}
