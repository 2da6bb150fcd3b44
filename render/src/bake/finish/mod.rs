//! From the light of texels to finished maps: less noise, gutters, borders of charts that cannot be seen, estimates of
//! errors.

pub(super) mod denoise;
pub(super) mod dilate;
pub(super) mod errors;
pub(super) mod filter;
mod noise;
pub(super) mod seams;
