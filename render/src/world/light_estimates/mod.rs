//! What is estimated of lights before tracing, at a few points that paths come to: how much of them arrives there, where
//! it is reflected so strongly that it is sampled as a light, and through which openings the sky is seen. Besides, which
//! part of the light samples each light gets.

mod aim_plan;
mod bounces;
mod lamp_images;
mod lamps_in_glass;
mod lamps_in_mirrors;
mod light_shares;
mod light_visibility;
mod openings;
mod reflected;
mod secondary_lights;
pub(super) mod seen_points;
mod through_glass;
