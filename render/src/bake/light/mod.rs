//! The light of texels: irradiance or ambient occlusion, and what is kept of where light comes from.

mod ao;
pub(super) mod baker;
mod cached;
mod direct_points;
pub(super) mod moments;
mod partly_covered;
mod texel_irradiance;
mod values;
