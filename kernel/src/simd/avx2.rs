//! AVX2 and FMA.
//!
//! Safety of this module: values of its types come into being only in kernels that [`dispatch`](super::dispatch) runs
//! on this instruction set, after it has been detected or vouched for.

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use super::twice::Twice;
use super::{CompressChildren, Lanes, Mask, Simd};

/// AVX2, FMA and BMI.
#[derive(Clone, Copy)]
pub(crate) struct Avx2;

impl Simd for Avx2 {
    type F4 = wide::f32x4;
    type F8 = F32x8;
    type F16 = Twice<F32x8>;
    type F32 = Twice<Twice<F32x8>>;
    const WIDE: bool = false;

    #[inline(always)]
    fn prefetch<const BYTES: usize>(start: *const u8) {
        prefetch::<BYTES>(start);
    }

    #[inline(always)]
    fn compress_indices(bits: u32, base: u32, out: &mut [u32; 8]) -> usize {
        // SAFETY: AVX2 is there, see the module; the pointer is to eight elements.
        unsafe {
            let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(SET_BITS[bits as usize & 255] as i64));
            let lanes = _mm256_add_epi32(lanes, _mm256_set1_epi32(base as i32));
            _mm256_storeu_si256(out.as_mut_ptr().cast(), lanes);
        }
        (bits & 255).count_ones() as usize
    }

    #[inline(always)]
    fn classify(words: &[u32; 8]) -> [u32; 2] {
        classify(words)
    }

    #[inline(always)]
    fn permute(numbers: &[f32; 8], places: &[u32; 8]) -> F32x8 {
        permute(numbers, places)
    }

    #[inline(always)]
    fn transpose(rows: [F32x8; 8]) -> [F32x8; 8] {
        transpose(rows)
    }

    #[inline(always)]
    fn deinterleave(triples: &[[f32; 16]; 3]) -> [Self::F16; 3] {
        let [a, b, c, d, e, f]: &[[f32; 8]; 6] = bytemuck::cast_ref(triples);
        let ([x, y, z], [x_high, y_high, z_high]) = (deinterleave(a, b, c), deinterleave(d, e, f));
        [Twice(x, x_high), Twice(y, y_high), Twice(z, z_high)]
    }
}

/// [`Simd::classify`].
#[inline(always)]
pub(super) fn classify(words: &[u32; 8]) -> [u32; 2] {
    // SAFETY: AVX2 is there, see the module; the pointer is to eight elements.
    unsafe {
        let words = _mm256_loadu_si256(words.as_ptr().cast());
        let ones = _mm256_cmpeq_epi32(words, _mm256_set1_epi32(-1));
        [_mm256_movemask_ps(_mm256_castsi256_ps(words)) as u32, _mm256_movemask_ps(_mm256_castsi256_ps(ones)) as u32]
    }
}

/// [`Simd::permute`].
#[inline(always)]
pub(super) fn permute(numbers: &[f32; 8], places: &[u32; 8]) -> F32x8 {
    // SAFETY: AVX2 is there, see the module; the pointers are to eight elements each.
    unsafe {
        let places = _mm256_loadu_si256(places.as_ptr().cast());
        F32x8(_mm256_permutevar8x32_ps(_mm256_loadu_ps(numbers.as_ptr()), places))
    }
}

/// [`Simd::transpose`]: pairs of numbers first, then pairs of pairs, then halves.
#[inline(always)]
pub(super) fn transpose(rows: [F32x8; 8]) -> [F32x8; 8] {
    let [a, b, c, d, e, f, g, h] = rows;
    let (p, q) = (transpose_halves([a, b, c, d]), transpose_halves([e, f, g, h]));
    // SAFETY: AVX is there, see the module.
    unsafe {
        [
            F32x8(_mm256_permute2f128_ps::<0x20>(p[0], q[0])),
            F32x8(_mm256_permute2f128_ps::<0x20>(p[1], q[1])),
            F32x8(_mm256_permute2f128_ps::<0x20>(p[2], q[2])),
            F32x8(_mm256_permute2f128_ps::<0x20>(p[3], q[3])),
            F32x8(_mm256_permute2f128_ps::<0x31>(p[0], q[0])),
            F32x8(_mm256_permute2f128_ps::<0x31>(p[1], q[1])),
            F32x8(_mm256_permute2f128_ps::<0x31>(p[2], q[2])),
            F32x8(_mm256_permute2f128_ps::<0x31>(p[3], q[3])),
        ]
    }
}

/// Four times four numbers in the lower lanes, and as many in the upper ones, mirrored at their diagonals.
#[inline(always)]
fn transpose_halves([a, b, c, d]: [F32x8; 4]) -> [__m256; 4] {
    // SAFETY: AVX is there, see the module.
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpacklo_ps(c.0, d.0));
        let (ab_high, cd_high) = (_mm256_unpackhi_ps(a.0, b.0), _mm256_unpackhi_ps(c.0, d.0));
        [
            _mm256_shuffle_ps::<0x44>(ab, cd),
            _mm256_shuffle_ps::<0xee>(ab, cd),
            _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
            _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
        ]
    }
}

/// [`Simd::deinterleave`] of eight triples: the numbers of a kind are in other lanes of each eight, so they are put
/// together first and in order then.
#[inline(always)]
fn deinterleave(a: &[f32; 8], b: &[f32; 8], c: &[f32; 8]) -> [F32x8; 3] {
    // SAFETY: AVX2 is there, see the module; the pointers are to eight elements each.
    unsafe {
        let (a, b, c) = (_mm256_loadu_ps(a.as_ptr()), _mm256_loadu_ps(b.as_ptr()), _mm256_loadu_ps(c.as_ptr()));
        let x = _mm256_blend_ps::<0b0010_0100>(_mm256_blend_ps::<0b1001_0010>(a, b), c);
        let y = _mm256_blend_ps::<0b0100_1001>(_mm256_blend_ps::<0b0010_0100>(a, b), c);
        let z = _mm256_blend_ps::<0b1001_0010>(_mm256_blend_ps::<0b0100_1001>(a, b), c);
        [
            F32x8(_mm256_permutevar8x32_ps(x, _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5))),
            F32x8(_mm256_permutevar8x32_ps(y, _mm256_setr_epi32(1, 4, 7, 2, 5, 0, 3, 6))),
            F32x8(_mm256_permutevar8x32_ps(z, _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7))),
        ]
    }
}

/// Fetches the cache lines at an address.
#[inline(always)]
pub(super) fn prefetch<const BYTES: usize>(start: *const u8) {
    let mut offset = 0;
    while offset < BYTES {
        // SAFETY: SSE is part of x86-64, and a prefetch is a hint that may name any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset).cast()) };
        offset += 64;
    }
}

/// Eight lanes.
#[derive(Clone, Copy)]
pub(crate) struct F32x8(pub(super) __m256);

/// Eight truth values.
#[derive(Clone, Copy)]
pub(crate) struct Mask8(__m256);

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: AVX is there, see the module.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

operator!(F32x8, Add, add, _mm256_add_ps);
operator!(F32x8, Sub, sub, _mm256_sub_ps);
operator!(F32x8, Mul, mul, _mm256_mul_ps);
operator!(F32x8, Div, div, _mm256_div_ps);
operator!(Mask8, BitAnd, bitand, _mm256_and_ps);
operator!(Mask8, BitOr, bitor, _mm256_or_ps);

impl Lanes<8> for F32x8 {
    type Mask = Mask8;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: AVX is there, see the module.
        Self(unsafe { _mm256_set1_ps(value) })
    }
    #[inline(always)]
    fn load(values: &[f32; 8]) -> Self {
        // SAFETY: AVX is there, see the module; the pointer is to eight floats.
        Self(unsafe { _mm256_loadu_ps(values.as_ptr()) })
    }
    #[inline(always)]
    fn store(self) -> [f32; 8] {
        let mut values = [0.0; 8];
        // SAFETY: AVX is there, see the module; the pointer is to eight floats.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) };
        values
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, minuend: Self) -> Self {
        // SAFETY: FMA is there, see the module.
        Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, minuend.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: AVX is there, see the module.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: AVX is there, see the module.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: AVX is there, see the module.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn copysign(self, other: Self) -> Self {
        // SAFETY: AVX is there, see the module.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            Self(_mm256_or_ps(_mm256_andnot_ps(sign, self.0), _mm256_and_ps(sign, other.0)))
        }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask8 {
        // SAFETY: AVX is there, see the module.
        Mask8(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask8 {
        // SAFETY: AVX is there, see the module.
        Mask8(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask8 {
        // SAFETY: AVX is there, see the module.
        Mask8(unsafe { _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Mask8, yes: Self, no: Self) -> Self {
        // SAFETY: AVX is there, see the module.
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask.0) })
    }
}

impl Mask for Mask8 {
    const LANES: u32 = 8;
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: AVX is there, see the module.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        // SAFETY: AVX2 is there, see the module.
        unsafe {
            let of_lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), of_lanes);
            Self(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, of_lanes)))
        }
    }
}

/// For each mask the numbers of its set bits, lowest first, a byte each.
const SET_BITS: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 == 1 {
                table[mask] |= (bit as u64) << (8 * count);
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

/// The eight slots of an order, a lane each.
///
/// # Safety
/// AVX2 is there.
#[inline(always)]
pub(super) unsafe fn slots(order: u32) -> __m256i {
    // SAFETY: the caller's promise. Permutations look at the low three bits of each lane alone.
    unsafe { _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21)) }
}

impl CompressChildren for F32x8 {
    #[inline(always)]
    fn compress(
        near: Self,
        far: Self,
        order: u32,
        children: &[u32; 8],
        kept: &mut [u32; 8],
        distances: &mut [f32; 8],
    ) -> usize {
        // SAFETY: AVX2 is there, see the module; the pointers are to eight elements each.
        unsafe {
            let slots = slots(order);
            let (near_in_order, far_in_order) =
                (_mm256_permutevar8x32_ps(near.0, slots), _mm256_permutevar8x32_ps(far.0, slots));
            let bits = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near_in_order, far_in_order)) as usize;
            let to_front = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(SET_BITS[bits & 255] as i64));
            let slots = _mm256_permutevar8x32_epi32(slots, to_front);
            let children = _mm256_loadu_si256(children.as_ptr().cast());
            _mm256_storeu_si256(kept.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(children, slots));
            _mm256_storeu_ps(distances.as_mut_ptr(), _mm256_permutevar8x32_ps(near.0, slots));
            bits.count_ones() as usize
        }
    }
}
