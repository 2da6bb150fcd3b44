//! Selection of an instruction set, and dispatch of kernels to it.

use core::fmt;
use core::str::FromStr;

use super::{Portable, Simd};

/// Whether this processor has a feature: detected if possible, else as the program was compiled.
#[cfg(all(feature = "std", target_arch = "x86_64"))]
use std::arch::is_x86_feature_detected as has;
#[cfg(not(all(feature = "std", target_arch = "x86_64")))]
macro_rules! has {
    ($feature:tt) => {
        cfg!(target_feature = $feature)
    };
}

/// A level of instruction sets. Hits are equal on all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Level {
    /// The scalar reference: for comparison, many times slower.
    Scalar,
    /// The target's baseline: SSE2 on x86-64, NEON on AArch64, simd128 on wasm if it is enabled.
    Portable,
    /// AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
    Avx2,
    /// AVX-512 F, VL, BW and DQ besides.
    Avx512,
}

impl Level {
    /// All levels, the slowest first.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Portable, Self::Avx2, Self::Avx512];

    /// `scalar`, `sse2` (`portable` on other targets), `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Portable if cfg!(target_arch = "x86_64") => "sse2",
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Level {
    type Err = UnknownLevel;

    /// The level of this [`name`](Self::name); `portable` works everywhere.
    fn from_str(name: &str) -> Result<Self, UnknownLevel> {
        let is_named = |level: &Level| level.name() == name || (*level == Self::Portable && name == "portable");
        Self::ALL.into_iter().find(is_named).ok_or(UnknownLevel)
    }
}

/// A name that is not the name of a [`Level`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownLevel;

impl fmt::Display for UnknownLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("instruction sets are named scalar, portable (or sse2, on x86-64), avx2 and avx512")
    }
}

impl core::error::Error for UnknownLevel {}

/// Every instruction set of this machine.
#[cfg(test)]
pub(crate) fn isas() -> impl Iterator<Item = Isa> {
    Level::ALL.into_iter().filter_map(Isa::new)
}

/// A level that this processor has: proof that its instructions may run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Isa(Level);

impl Isa {
    /// The scalar reference.
    pub const SCALAR: Self = Self(Level::Scalar);
    /// The target's baseline.
    pub const PORTABLE: Self = Self(Level::Portable);

    /// The level.
    pub fn level(self) -> Level {
        self.0
    }

    /// The proof for `level`, if this processor is known to have it: detected with `std`, otherwise as the compiler was
    /// told (`-C target-feature=+avx2,+fma,…`, `-C target-cpu=…`). Under Miri only the target's baseline.
    pub fn new(level: Level) -> Option<Self> {
        let has = match level {
            Level::Scalar | Level::Portable => true,
            Level::Avx2 => has_avx2(),
            Level::Avx512 => has_avx2() && has_avx512(),
        };
        has.then_some(Self(level))
    }

    /// The best level that this processor has or, if the environment variable `HALFDOME_ISA` names one that it has,
    /// that one. Found once.
    #[cfg(feature = "std")]
    pub fn detect() -> Self {
        static FOUND: std::sync::OnceLock<Isa> = std::sync::OnceLock::new();
        *FOUND.get_or_init(|| {
            let wanted = std::env::var("HALFDOME_ISA").ok().and_then(|name| name.parse().ok()).and_then(Self::new);
            wanted.unwrap_or_else(Self::best)
        })
    }

    /// The best level that this processor is known to have. Without `std` that is what the program was compiled for;
    /// [`Isa::assume`] overrides it.
    #[cfg(not(feature = "std"))]
    pub fn detect() -> Self {
        Self::best()
    }

    /// Runs `task` with the instructions of this level: plain loops in it, and in what is inlined into it, are
    /// vectorised to that width. Results do not depend on the level, as the compiler fuses nothing.
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        dispatch(self, Plain(task))
    }

    fn best() -> Self {
        Level::ALL.into_iter().rev().find_map(Self::new).unwrap_or(Self::PORTABLE)
    }

    /// The proof for `level` on the caller's word; for where nothing can be detected. Where the target has no code for
    /// that level, the proof is for [`Level::Portable`].
    ///
    /// There is code for AVX2 and AVX-512 on x86-64 if floats are passed in registers. `x86_64-unknown-none` passes
    /// them in integers, so that a system's kernel need not save the vector registers, and the compiler makes no vector
    /// instruction for it at all: the kernel runs there in software floats, with the same hits. A program without an
    /// operating system that may use the registers is built without the standard library for a target that has them,
    /// such as `x86_64-unknown-linux-musl`.
    ///
    /// # Safety
    /// The processor must support every extension that [`Level`] names for `level` and those below it, and the code
    /// that switches contexts (an operating system; start-up code by `CR4.OSXSAVE` and `XCR0`) must enable and preserve
    /// the registers: 256 bits wide for AVX2, 512 and the masks for AVX-512.
    pub const unsafe fn assume(level: Level) -> Self {
        match level {
            Level::Avx2 | Level::Avx512 if !HAS_VECTOR_CODE => Self::PORTABLE,
            _ => Self(level),
        }
    }
}

/// Whether AVX2 and AVX-512 are compiled: x86-64, with floats in registers.
const HAS_VECTOR_CODE: bool = cfg!(all(target_arch = "x86_64", target_feature = "sse2"));

/// Whether this processor has the instructions of [`Level::Avx2`].
fn has_avx2() -> bool {
    let features = [has!("avx2"), has!("fma"), has!("bmi1"), has!("bmi2"), has!("lzcnt"), has!("popcnt")];
    HAS_VECTOR_CODE && !cfg!(miri) && features == [true; 6]
}

/// Whether it is known to have what [`Level::Avx512`] adds.
fn has_avx512() -> bool {
    [has!("avx512f"), has!("avx512vl"), has!("avx512bw"), has!("avx512dq")] == [true; 4]
}

/// Code without intrinsics that [`Isa::run`] compiles for every level.
pub trait Task {
    /// The result.
    type Output;

    /// The code. It must be `#[inline(always)]`, as must all expensive functions that it calls: functions that are not
    /// inlined are compiled for the target's baseline.
    fn run(self) -> Self::Output;
}

/// A task as a kernel that makes no use of intrinsics.
struct Plain<T>(T);

impl<T: Task> Work for Plain<T> {
    type Output = T::Output;
    #[inline(always)]
    fn run<S: Simd>(self) -> T::Output {
        self.0.run()
    }
}

/// A kernel: code that is generic over the instruction set. `run` must be `#[inline(always)]`, as must all functions
/// that it calls.
pub(crate) trait Work {
    type Output;
    fn run<S: Simd>(self) -> Self::Output;
}

/// Runs `work` with the instructions of `isa`; of [`Isa::SCALAR`] with those of [`Isa::PORTABLE`]. None of the kernels
/// becomes part of the caller: else its stack frame would have room for those of all levels.
#[inline(always)]
pub(crate) fn dispatch<W: Work>(isa: Isa, work: W) -> W::Output {
    match isa.0 {
        // SAFETY: an `Isa` is proof of its level.
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        Level::Avx2 => unsafe { on_avx2(work) },
        // SAFETY: an `Isa` is proof of its level.
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        Level::Avx512 => unsafe { on_avx512(work) },
        _ => on_portable(work),
    }
}

#[inline(never)]
fn on_portable<W: Work>(work: W) -> W::Output {
    work.run::<Portable>()
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(never)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn on_avx2<W: Work>(work: W) -> W::Output {
    work.run::<super::avx2::Avx2>()
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(never)]
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn on_avx512<W: Work>(work: W) -> W::Output {
    work.run::<super::avx512::Avx512>()
}
