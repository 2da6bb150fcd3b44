//! What the tests of the samplers share.

pub(super) mod statistics;
