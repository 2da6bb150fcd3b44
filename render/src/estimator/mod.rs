//! Estimators of the light received at a point of a surface, independent of caches and paths.

mod adaptive_gather;
mod aimed_rays;
mod direct;
mod follow;
mod gather;
mod hemisphere;
mod incident;
mod light_rays;
mod light_sample;
mod light_warp;
mod occluders;
mod punctual;
mod reflected;
mod refracted;
mod rounds;
pub(crate) mod salts;
mod secondary_lights;
mod seen_lights;
mod sky;
mod weight;

pub(crate) use adaptive_gather::{AdaptiveGatherer, RayBudget};
pub(crate) use aimed_rays::{AimedFrom, AimedRays};
pub(crate) use direct::{
    ShadowRay, area_light_sample, emitted_density, sample_direct, sample_direct_by, sample_light, scattered_weight,
};
pub(crate) use follow::Follow;
pub(crate) use gather::{GATHER_FIRST_SET, GatherPoint, Gathered, Gatherer};
pub(crate) use hemisphere::Hemisphere;
pub(crate) use incident::{IncidentSampler, IncidentSink};
pub(crate) use light_rays::LightRays;
pub(crate) use light_warp::light_warp;
pub use occluders::SECTORS;
pub(crate) use occluders::sector;
pub(crate) use reflected::sample_reflected;
pub(crate) use rounds::{RoundsMean, mean_in_rounds, mean_of_halves};
pub(crate) use secondary_lights::{AimedRay, aim, aimed_density, aimed_weight, lit_at};
pub(crate) use seen_lights::{SeenLight, seen_lights};
pub(crate) use sky::{seen_sky, sky_probability};
