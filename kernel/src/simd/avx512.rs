//! AVX-512 on eight and sixteen lanes: masks in registers of their own, and a compression that needs no table.
//!
//! Safety of this module: values of its types come into being only in kernels that [`dispatch`](super::dispatch) runs
//! on this instruction set, after it has been detected or vouched for.

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use super::avx2;
use super::twice::Twice;
use super::{CompressChildren, Lanes, Mask, Simd};

/// AVX-512 F, VL, BW and DQ, and all that AVX2 has.
#[derive(Clone, Copy)]
pub(crate) struct Avx512;

impl Simd for Avx512 {
    type F4 = wide::f32x4;
    type F8 = F32x8;
    type F16 = F32x16;
    type F32 = Twice<F32x16>;
    const WIDE: bool = true;

    #[inline(always)]
    fn prefetch<const BYTES: usize>(start: *const u8) {
        avx2::prefetch::<BYTES>(start);
    }

    #[inline(always)]
    fn compress_indices(bits: u32, base: u32, out: &mut [u32; 8]) -> usize {
        // SAFETY: AVX-512 VL is there, see the module; the pointer is to eight elements.
        unsafe {
            let lanes = _mm256_add_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_epi32(base as i32));
            _mm256_storeu_si256(out.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(bits as __mmask8, lanes));
        }
        (bits & 255).count_ones() as usize
    }

    #[inline(always)]
    fn classify(words: &[u32; 8]) -> [u32; 2] {
        avx2::classify(words)
    }

    #[inline(always)]
    fn permute(numbers: &[f32; 8], places: &[u32; 8]) -> F32x8 {
        F32x8(avx2::permute(numbers, places))
    }

    #[inline(always)]
    fn transpose([a, b, c, d, e, f, g, h]: [F32x8; 8]) -> [F32x8; 8] {
        let [a, b, c, d, e, f, g, h] = avx2::transpose([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0]);
        [F32x8(a), F32x8(b), F32x8(c), F32x8(d), F32x8(e), F32x8(f), F32x8(g), F32x8(h)]
    }

    #[inline(always)]
    fn deinterleave([a, b, c]: &[[f32; 16]; 3]) -> [F32x16; 3] {
        /// Lanes whose numbers have the remainders 0, 1 and 2 by 3.
        const EVERY_THIRD: [__mmask16; 3] = [0x9249, 0x2492, 0x4924];
        let [zero, one, two] = EVERY_THIRD;
        // SAFETY: AVX-512 F is there, see the module; the pointers are to sixteen elements each.
        unsafe {
            let (a, b, c) = (_mm512_loadu_ps(a.as_ptr()), _mm512_loadu_ps(b.as_ptr()), _mm512_loadu_ps(c.as_ptr()));
            // The numbers of a kind are in other lanes of each sixteen: put together first, and in order then.
            let x = _mm512_mask_blend_ps(one, _mm512_mask_blend_ps(two, a, b), c);
            let y = _mm512_mask_blend_ps(two, _mm512_mask_blend_ps(zero, a, b), c);
            let z = _mm512_mask_blend_ps(zero, _mm512_mask_blend_ps(one, a, b), c);
            let order = _mm512_setr_epi32(0, 3, 6, 9, 12, 15, 2, 5, 8, 11, 14, 1, 4, 7, 10, 13);
            // An index counts by its lowest four bits.
            let next = _mm512_add_epi32(order, _mm512_set1_epi32(1));
            let last = _mm512_add_epi32(order, _mm512_set1_epi32(2));
            [
                F32x16(_mm512_permutexvar_ps(order, x)),
                F32x16(_mm512_permutexvar_ps(next, y)),
                F32x16(_mm512_permutexvar_ps(last, z)),
            ]
        }
    }
}

/// Eight lanes: those of AVX2, but for what masks are.
#[derive(Clone, Copy)]
pub(crate) struct F32x8(avx2::F32x8);

/// Eight truth values.
#[derive(Clone, Copy)]
pub(crate) struct Mask8(__mmask8);

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for F32x8 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl BitAnd for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Lanes<8> for F32x8 {
    type Mask = Mask8;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(avx2::F32x8::splat(value))
    }
    #[inline(always)]
    fn load(values: &[f32; 8]) -> Self {
        Self(avx2::F32x8::load(values))
    }
    #[inline(always)]
    fn store(self) -> [f32; 8] {
        self.0.store()
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, minuend: Self) -> Self {
        Self(self.0.mul_sub(factor.0, minuend.0))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn copysign(self, other: Self) -> Self {
        Self(self.0.copysign(other.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask8 {
        // SAFETY: AVX-512 VL is there, see the module.
        Mask8(unsafe { _mm256_cmp_ps_mask::<_CMP_LT_OQ>(self.0.0, other.0.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask8 {
        // SAFETY: AVX-512 VL is there, see the module.
        Mask8(unsafe { _mm256_cmp_ps_mask::<_CMP_LE_OQ>(self.0.0, other.0.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask8 {
        // SAFETY: AVX-512 VL is there, see the module.
        Mask8(unsafe { _mm256_cmp_ps_mask::<_CMP_EQ_OQ>(self.0.0, other.0.0) })
    }
    #[inline(always)]
    fn select(mask: Mask8, yes: Self, no: Self) -> Self {
        // SAFETY: AVX-512 VL is there, see the module.
        Self(avx2::F32x8(unsafe { _mm256_mask_blend_ps(mask.0, no.0.0, yes.0.0) }))
    }
}

impl Mask for Mask8 {
    const LANES: u32 = 8;
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.into()
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as __mmask8)
    }
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
        // SAFETY: AVX-512 VL is there, see the module; the pointers are to eight elements each.
        unsafe {
            let slots = avx2::slots(order);
            let near = _mm256_permutevar8x32_ps(near.0.0, slots);
            let far = _mm256_permutevar8x32_ps(far.0.0, slots);
            let children = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(children.as_ptr().cast()), slots);
            let mask = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(near, far);
            // In registers first: compressing into memory takes tens of cycles on some processors.
            _mm256_storeu_si256(kept.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(mask, children));
            _mm256_storeu_ps(distances.as_mut_ptr(), _mm256_maskz_compress_ps(mask, near));
            mask.count_ones() as usize
        }
    }
}

/// Sixteen lanes.
#[derive(Clone, Copy)]
pub(crate) struct F32x16(__m512);

/// Sixteen truth values.
#[derive(Clone, Copy)]
pub(crate) struct Mask16(__mmask16);

macro_rules! operator16 {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for F32x16 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: AVX-512 F is there, see the module.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

operator16!(Add, add, _mm512_add_ps);
operator16!(Sub, sub, _mm512_sub_ps);
operator16!(Mul, mul, _mm512_mul_ps);
operator16!(Div, div, _mm512_div_ps);

impl BitAnd for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Mask for Mask16 {
    const LANES: u32 = 16;
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.into()
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as __mmask16)
    }
}

impl Lanes<16> for F32x16 {
    type Mask = Mask16;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: AVX-512 F is there, see the module.
        Self(unsafe { _mm512_set1_ps(value) })
    }
    #[inline(always)]
    fn load(values: &[f32; 16]) -> Self {
        // SAFETY: AVX-512 F is there, see the module; the pointer is to sixteen floats.
        Self(unsafe { _mm512_loadu_ps(values.as_ptr()) })
    }
    #[inline(always)]
    fn store(self) -> [f32; 16] {
        let mut values = [0.0; 16];
        // SAFETY: AVX-512 F is there, see the module; the pointer is to sixteen floats.
        unsafe { _mm512_storeu_ps(values.as_mut_ptr(), self.0) };
        values
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, minuend: Self) -> Self {
        // SAFETY: AVX-512 F is there, see the module.
        Self(unsafe { _mm512_fmsub_ps(self.0, factor.0, minuend.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: AVX-512 F is there, see the module.
        Self(unsafe { _mm512_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: AVX-512 F is there, see the module.
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: AVX-512 F is there, see the module.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn copysign(self, other: Self) -> Self {
        // SAFETY: AVX-512 F and DQ are there, see the module.
        unsafe {
            let sign = _mm512_set1_ps(-0.0);
            Self(_mm512_or_ps(_mm512_andnot_ps(sign, self.0), _mm512_and_ps(sign, other.0)))
        }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask16 {
        // SAFETY: AVX-512 F is there, see the module.
        Mask16(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask16 {
        // SAFETY: AVX-512 F is there, see the module.
        Mask16(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask16 {
        // SAFETY: AVX-512 F is there, see the module.
        Mask16(unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Mask16, yes: Self, no: Self) -> Self {
        // SAFETY: AVX-512 F is there, see the module.
        Self(unsafe { _mm512_mask_blend_ps(mask.0, no.0, yes.0) })
    }
}
