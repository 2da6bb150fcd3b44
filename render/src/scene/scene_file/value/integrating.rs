//! Values of options of integrators and the irradiance cache.

use super::{Reading, Value, expected};
use crate::settings::{
    AoWeighting, CachedOptions, GatherLayout, Gradients, HemisphereSampling, Integrator, LightSampling, Metric,
    PathOptions, Stop, Survival,
};

/// An integrator's name.
pub(in crate::scene) fn integrator(value: &Value) -> Reading<Integrator> {
    value.named(&Integrator::NAMES, Integrator::named)
}

/// The sampling of lights.
pub(in crate::scene) fn lights(value: &Value) -> Reading<LightSampling> {
    value.one_of(&LightSampling::ALL.map(|sampling| (sampling.name(), sampling)))
}

/// A stopping rule's name.
pub(in crate::scene) fn stop(value: &Value) -> Reading<Stop> {
    value.named(&Stop::NAMES, Stop::named)
}

/// A part of a whole.
pub(in crate::scene) fn fraction(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(fraction @ 0.0..=1.0) => Ok(fraction),
        _ => expected("a number from 0 to 1"),
    }
}

/// The survival probability of a path, or the word for one by its throughput or that one's root.
pub(in crate::scene) fn survival(value: &Value) -> Reading<Survival> {
    match value {
        Value::Text(text) if text == "root" => Ok(Survival::RootThroughput),
        Value::Text(text) if text == "throughput" => Ok(Survival::THROUGHPUT),
        _ => match value.finite() {
            Some(probability) if probability > 0.0 && probability <= 1.0 => Ok(Survival::Constant(probability)),
            _ => expected("`root`, `throughput`, or a probability, more than 0 and at most 1"),
        },
    }
}

/// The sampling of directions.
pub(in crate::scene) fn hemisphere_sampling(value: &Value) -> Reading<HemisphereSampling> {
    value.one_of(&HemisphereSampling::ALL.map(|sampling| (sampling.name(), sampling)))
}

/// The values of occlusion rays.
pub(in crate::scene) fn ao_weighting(value: &Value) -> Reading<AoWeighting> {
    value.one_of(&AoWeighting::ALL.map(|weighting| (weighting.name(), weighting)))
}

/// A distance in the scene's units.
pub(in crate::scene) fn distance(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(distance) if distance > 0.0 => Ok(distance),
        _ => expected("a number more than 0, in the scene's units"),
    }
}

/// The error that a record of the irradiance cache may have.
pub(in crate::scene) fn cache_error(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(error) if error > 0.0 && error <= CachedOptions::MAX_ERROR => Ok(error),
        _ => expected(format!("a number more than 0 and at most {}", CachedOptions::MAX_ERROR)),
    }
}

/// A root mean square error relative to the mean, as a percentage or a number.
pub(crate) fn accuracy(value: &Value) -> Reading<f32> {
    let accuracy = match value {
        Value::Text(text) => {
            text.strip_suffix('%').and_then(|percent| Some(percent.trim().parse::<f32>().ok()? / 100.0))
        }
        _ => value.finite(),
    };
    match accuracy {
        Some(accuracy) if accuracy > 0.0 && accuracy <= CachedOptions::MAX_ACCURACY => Ok(accuracy),
        _ => expected(format!("a percentage more than 0 and at most {}%, as 1%", 100.0 * CachedOptions::MAX_ACCURACY)),
    }
}

/// The gradients of records.
pub(in crate::scene) fn gradients(value: &Value) -> Reading<Gradients> {
    value.one_of(&Gradients::ALL.map(|gradients| (gradients.name(), gradients)))
}

/// The metric of a record's radius.
pub(in crate::scene) fn metric(value: &Value) -> Reading<Metric> {
    value.one_of(&Metric::ALL.map(|metric| (metric.name(), metric)))
}

/// The layout of a record's rays.
pub(in crate::scene) fn gather_layout(value: &Value) -> Reading<GatherLayout> {
    value.one_of(&GatherLayout::ALL.map(|layout| (layout.name(), layout)))
}

/// Rays of a record.
pub(in crate::scene) fn record_rays(value: &Value) -> Reading<u32> {
    const RANGE: std::ops::RangeInclusive<u32> = CachedOptions::MIN_RAYS..=CachedOptions::MAX_RAYS;
    match value.integer() {
        Some(rays) if RANGE.contains(&rays) => Ok(rays),
        _ => expected(format!("a whole number from {} to {}", RANGE.start(), RANGE.end())),
    }
}

/// Reflections of light that have a cache each.
pub(in crate::scene) fn cache_bounces(value: &Value) -> Reading<u32> {
    match value.integer() {
        Some(bounces) if (1..=CachedOptions::MAX_BOUNCES).contains(&bounces) => Ok(bounces),
        _ => expected(format!("a whole number from 1 to {}", CachedOptions::MAX_BOUNCES)),
    }
}

/// The greatest radiance of a sample.
pub(in crate::scene) fn clamp(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(most) if most > 0.0 => Ok(most),
        _ => expected("a number, finite and more than 0"),
    }
}

/// Whether paths are guided, or by how many others; 0 for none.
pub(in crate::scene) fn guide(value: &Value) -> Reading<u32> {
    match (value, value.integer()) {
        (Value::Boolean(true), _) => Ok(PathOptions::GUIDE_PATHS),
        (Value::Boolean(false), _) => Ok(0),
        (_, Some(paths @ PathOptions::MIN_GUIDE_PATHS..=PathOptions::MAX_GUIDE_PATHS)) => Ok(paths),
        _ => {
            let (least, most) = (PathOptions::MIN_GUIDE_PATHS, PathOptions::MAX_GUIDE_PATHS);
            expected(format!("true, false, or a number of paths from {least} to {most}"))
        }
    }
}
