//! The names of integrators' choices in scene files, on the command line and in films.

use super::{AoWeighting, HemisphereSampling, LightSampling, named};

named!(LightSampling: Naive = "naive", Direct = "direct", Mis = "mis");
named!(
    HemisphereSampling: Uniform = "uniform",
    Cosine = "cosine",
    Stratified = "stratified",
    StratifiedUniform = "stratified-uniform"
);
named!(AoWeighting: CacheMisses = "misses", HitLength = "hit-length");
