//! Every backend that this machine has against plain numbers.

use alloc::vec::Vec;

use super::*;

/// Runs `work` while the processor takes subnormal numbers for zero and gives zero in place of them, as audio programs
/// and engines have it: bits 15 (FTZ) and 6 (DAZ) of MXCSR.
#[cfg(all(target_arch = "x86_64", not(miri)))]
pub(crate) fn flushing_subnormals<T>(work: impl FnOnce() -> T) -> T {
    let mut usual = 0u32;
    // SAFETY: writes four bytes to the variable.
    unsafe { core::arch::asm!("stmxcsr [{}]", in(reg) &raw mut usual, options(nostack)) };
    let flushing = usual | 1 << 15 | 1 << 6;
    // SAFETY: sets two bits that every processor with 64 bits has. The compiler assumes that they are not set: what it
    // computes itself differs, which the test's numbers are kept from by `black_box`.
    unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const flushing, options(nostack)) };
    let result = work();
    // SAFETY: sets the register to what it was.
    unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const usual, options(nostack)) };
    result
}

#[test]
#[cfg(all(target_arch = "x86_64", not(miri)))]
fn subnormals_are_flushed_where_it_is_asked_for_and_only_there() {
    let half = |x: f32| core::hint::black_box(x) * 0.5;
    let sum = |x: f32| core::hint::black_box(x) + core::hint::black_box(1e-40);
    assert_eq!(flushing_subnormals(|| [half(f32::MIN_POSITIVE), sum(0.0)]), [0.0, 0.0]);
    assert!(half(f32::MIN_POSITIVE) > 0.0 && sum(0.0) > 0.0);
}

/// Every operation against the same operation on scalars, over pairs that include zeros, infinities and NaN.
#[inline(always)]
fn check<const N: usize, L: Lanes<N>>() {
    let values = [0.0, -0.0, 1.0, -1.5, 1e-40, -3e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.1, 7.0, 1e30];
    for i in 0..values.len() {
        for j in (0..values.len()).step_by(if cfg!(miri) { 5 } else { 1 }) {
            let a: [f32; N] = core::array::from_fn(|k| values[(i + k) % values.len()]);
            let b: [f32; N] = core::array::from_fn(|k| values[(j + 3 * k) % values.len()]);
            let (x, y) = (L::load(&a), L::load(&b));
            let same = |lanes: L, scalar: &dyn Fn(f32, f32) -> f32| {
                for (k, value) in lanes.store().into_iter().enumerate() {
                    let expected = scalar(a[k], b[k]);
                    assert!(value.to_bits() == expected.to_bits() || value.is_nan() && expected.is_nan());
                }
            };
            same(x + y, &|p, q| p + q);
            same(x - y, &|p, q| p - q);
            same(x * y, &|p, q| p * q);
            same(x / y, &|p, q| p / q);
            same(x.abs(), &|p, _| p.abs());
            same(x.copysign(y), &f32::copysign);
            same(L::splat(2.5), &|_, _| 2.5);
            same(L::select(x.lt(y), x, y), &|p, q| if p < q { p } else { q });
            let bits = |mask: L::Mask, scalar: &dyn Fn(f32, f32) -> bool| {
                let expected = (0..N).map(|k| (scalar(a[k], b[k]) as u32) << k).sum::<u32>();
                assert_eq!(mask.bits(), expected);
                let without_lane = u32::MAX.checked_shl(N as u32).unwrap_or(0);
                assert_eq!(L::Mask::from_bits(expected | without_lane).bits(), expected);
            };
            bits(x.lt(y), &|p, q| p < q);
            bits(x.le(y), &|p, q| p <= q);
            bits(x.eq(y), &|p, q| p == q);
            bits(x.lt(y) | x.eq(y), &|p, q| p <= q);
            bits(x.le(y) & y.le(x), &|p, q| p == q);
            for k in 0..N {
                if !a[k].is_nan() && !b[k].is_nan() {
                    assert_eq!(x.min(y).store()[k], a[k].min(b[k]));
                    assert_eq!(x.max(y).store()[k], a[k].max(b[k]));
                }
            }
            // A product that is exact, so that fused or not makes no difference.
            let (two, three) = (L::splat(2.0), L::splat(3.0));
            same(two.mul_sub(three, L::splat(5.0)), &|_, _| 1.0);
        }
    }
}

/// Which children are kept, for every mask and several orders.
#[inline(always)]
fn check_children<L: Lanes<8> + CompressChildren>() {
    let children: [u32; 8] = core::array::from_fn(|slot| 100 + slot as u32);
    let orders = [[0, 1, 2, 3, 4, 5, 6, 7], [7, 6, 5, 4, 3, 2, 1, 0], [3, 1, 4, 0, 5, 7, 2, 6]];
    for slots in orders {
        let order = slots.iter().rev().fold(0u32, |order, slot| order << 3 | slot);
        for mask in 0..256u32 {
            let near: [f32; 8] = core::array::from_fn(|slot| slot as f32);
            let far = near.map(|near| if mask >> near as u32 & 1 == 1 { near } else { near - 1.0 });
            let (mut kept, mut distances) = ([0; 8], [0.0; 8]);
            let count = L::compress(L::load(&near), L::load(&far), order, &children, &mut kept, &mut distances);
            let expected = slots.into_iter().filter(|slot| mask >> slot & 1 == 1);
            assert!(expected.clone().map(|slot| 100 + slot).eq(kept[..count].iter().copied()));
            assert!(expected.map(|slot| slot as f32).eq(distances[..count].iter().copied()));
        }
    }
}

/// Every number is distinguished.
#[inline(always)]
fn check_transposition<S: Simd>() {
    let rows: [[f32; 8]; 8] = core::array::from_fn(|row| core::array::from_fn(|lane| (8 * row + lane) as f32));
    let [a, b, c, d, e, f, g, h] = &rows;
    let load = S::F8::load;
    let mirrored = S::transpose([load(a), load(b), load(c), load(d), load(e), load(f), load(g), load(h)]);
    for (lane, numbers) in mirrored.into_iter().enumerate() {
        assert_eq!(numbers.store(), core::array::from_fn(|row| rows[row][lane]));
    }
    assert_eq!(S::permute(h, &[3, 0, 7, 7, 1, 2, 12, 5]).store(), [59.0, 56.0, 63.0, 63.0, 57.0, 58.0, 60.0, 61.0]);
    let triples = core::array::from_fn(|row| core::array::from_fn(|lane| (16 * row + lane) as f32));
    for (part, numbers) in S::deinterleave(&triples).into_iter().enumerate() {
        assert_eq!(numbers.store(), core::array::from_fn(|triple| (3 * triple + part) as f32));
    }
}

/// Words by their highest bit, and those with all bits set.
#[inline(always)]
fn check_classes<S: Simd>() {
    let words = [0, 1 << 31, u32::MAX, u32::MAX - 1, i32::MAX as u32, u32::MAX, 7, 0xff00_0000];
    assert_eq!(S::classify(&words), [0b1010_1110, 0b0010_0100]);
}

struct Check;

impl Work for Check {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        check::<4, S::F4>();
        check::<8, S::F8>();
        check::<16, S::F16>();
        check::<32, S::F32>();
        check_children::<S::F8>();
        check_transposition::<S>();
        check_classes::<S>();
        S::prefetch::<320>(core::ptr::null());
    }
}

#[test]
fn lanes_compute_as_scalars_do() {
    dispatch(Isa::PORTABLE, Check);
    if cfg!(miri) {
        return;
    }
    dispatch(Isa::detect(), Check);
    #[cfg(feature = "std")]
    isas().for_each(|isa| dispatch(isa, Check));
}

#[test]
fn levels_are_found_by_their_names() {
    for level in Level::ALL {
        assert_eq!(level.name().parse(), Ok(level));
    }
    assert_eq!("portable".parse(), Ok(Level::Portable));
    assert_eq!("mmx".parse::<Level>(), Err(UnknownLevel));
}

#[test]
fn set_lanes_are_listed_in_order() {
    assert!(lanes_of(0b1010_0001).eq([0, 5, 7]));
    assert!(lanes_of(0).next().is_none());
    assert!(lanes_of(u32::MAX).eq(0..32));
}

#[test]
fn proofs_are_for_code_that_is_there() {
    // SAFETY: nothing runs on these.
    let assumed = Level::ALL.map(|level| unsafe { Isa::assume(level) }.level());
    if cfg!(all(target_arch = "x86_64", target_feature = "sse2")) {
        assert_eq!(assumed, Level::ALL);
    } else {
        assert_eq!(assumed, [Level::Scalar, Level::Portable, Level::Portable, Level::Portable]);
    }
    let known: Vec<Level> = Level::ALL.into_iter().filter(|&level| Isa::new(level).is_some()).collect();
    assert!(known.starts_with(&[Level::Scalar, Level::Portable]) && known.iter().all(|level| assumed.contains(level)));
}
