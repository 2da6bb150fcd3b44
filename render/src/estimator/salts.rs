//! Salts keep the random numbers of different purposes apart: each xors the seed with its own, and what is done for another
//! purpose with both. They are initial values of SHA-512; 0x5be0_cd19_137e_2179 is not used yet.
//!
//! Two purposes share the salt of another, as a new one would change pictures. Why their numbers do not meet stands there.

/// Rays of gathers.
pub(crate) const GATHER: u64 = 0x6a09_e667_f3bc_c908;
/// Rays that are aimed at lights, beside others.
pub(crate) const AIMED: u64 = 0x1f83_d9ab_fb41_bd6b;
/// Direct light.
pub(crate) const INCIDENT: u64 = 0x3c6e_f372_fe94_f82b;
/// Gathers of doubtful records, made again. Seeds have [`GATHER`], too, which those of direct light never have.
pub(crate) const AGAIN: u64 = INCIDENT;
/// Gathers that tell the error of a cache, two at each point.
pub(crate) const HELD_OUT: [u64; 2] = [0x510e_527f_ade6_82d1, 0x9b05_688c_2b3e_6c1f];
/// Light of probes, which have no cache, and so no held-out gathers.
pub(crate) const PROBE: u64 = HELD_OUT[0];
/// The rough cache of a bake.
pub(crate) const ROUGH: u64 = 0xbb67_ae85_84ca_a73b;
/// Where light comes from that directional lightmaps keep.
pub(crate) const MOMENTS: u64 = 0xa54f_f53a_5f1d_36f1;
