//! Eight lanes in a register of AVX-512.

use std::arch::x86_64::*;
use std::ops::BitAnd;

use super::avx2::Four;
use super::{DIGITS, EXPONENT, EXPONENT_OF_ONE, LEAST, Lanes, Mask, ONE, Simd, TO_ONE, operators};

/// AVX-512 with the F, DQ, BW and VL parts.
#[derive(Clone, Copy)]
pub(super) struct Avx512(());

#[derive(Clone, Copy)]
pub(super) struct Eight(__m512d);

#[derive(Clone, Copy)]
pub(super) struct Bits(u8);

impl Avx512 {
    /// # Safety
    /// The machine has the instructions.
    #[inline(always)]
    pub(super) unsafe fn new() -> Self {
        Self(())
    }
}

operators! { Eight:
    Add add = _mm512_add_pd;
    Sub sub = _mm512_sub_pd;
    Mul mul = _mm512_mul_pd;
    Div div = _mm512_div_pd;
}

impl Simd for Avx512 {
    const WIDTH: usize = 8;
    type Lanes = Eight;
    type Mask = Bits;
    type Quad = Four;

    #[inline(always)]
    fn splat(self, value: f64) -> Eight {
        // SAFETY: the machine has the level.
        Eight(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn load(self, values: &[f64]) -> Eight {
        let values = &values[..8];
        // SAFETY: the machine has the level, and there are eight numbers.
        Eight(unsafe { _mm512_loadu_pd(values.as_ptr()) })
    }

    #[inline(always)]
    fn quad(self, numbers: &[f64; 4]) -> Four {
        // SAFETY: the machine has the level.
        unsafe { Four::of(numbers) }
    }

    #[inline(always)]
    fn quad_of(self, number: f64) -> Four {
        // SAFETY: as above.
        unsafe { Four::all(number) }
    }

    #[inline(always)]
    fn mask(self, bits: u8) -> Bits {
        Bits(bits)
    }

    #[inline(always)]
    unsafe fn columns<const C: usize>(
        self,
        table: &[[f64; C]],
        first: usize,
        at: &[u32],
    ) -> [Eight; 4] {
        assert!(first + 4 <= C && at.len() >= 8);
        // SAFETY: the machine has the level, and the caller names rows of the table, each of which has four numbers
        // from `first` on.
        unsafe {
            let row = |k: usize| table.as_ptr().add(at[k] as usize).cast::<f64>().add(first);
            let two = |low: usize, high: usize| {
                let low = _mm512_castpd256_pd512(_mm256_loadu_pd(row(low)));
                _mm512_insertf64x4::<1>(low, _mm256_loadu_pd(row(high)))
            };
            let (a, b, c, d) = (two(0, 2), two(1, 3), two(4, 6), two(5, 7));
            let (ab_even, ab_odd) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
            let (cd_even, cd_odd) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
            [
                Eight(_mm512_shuffle_f64x2::<0b10_00_10_00>(ab_even, cd_even)),
                Eight(_mm512_shuffle_f64x2::<0b10_00_10_00>(ab_odd, cd_odd)),
                Eight(_mm512_shuffle_f64x2::<0b11_01_11_01>(ab_even, cd_even)),
                Eight(_mm512_shuffle_f64x2::<0b11_01_11_01>(ab_odd, cd_odd)),
            ]
        }
    }

    #[inline(always)]
    fn pack(self, bits: u8, lanes: Eight, names: &[u32], numbers: &mut [f64], packed: &mut [u32]) {
        let (names, numbers, packed) = (&names[..8], &mut numbers[..8], &mut packed[..8]);
        // SAFETY: the machine has the level, and there are eight of each.
        unsafe {
            let lanes = _mm512_maskz_compress_pd(bits, lanes.0);
            _mm512_storeu_pd(numbers.as_mut_ptr(), lanes);
            let names = _mm256_loadu_si256(names.as_ptr().cast());
            let names = _mm256_maskz_compress_epi32(bits, names);
            _mm256_storeu_si256(packed.as_mut_ptr().cast(), names);
        }
    }
}

impl Lanes for Eight {
    type Mask = Bits;

    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        let values = &mut values[..8];
        // SAFETY: lanes of a level exist only where the machine has it, and there is room for eight numbers.
        unsafe { _mm512_storeu_pd(values.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: lanes of a level exist only where the machine has it.
        Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn mul_sub_from(self, factor: Self, term: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_fnmadd_pd(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    /// With an estimate t, good to 2^-14, and d = 1 - x t: 1/x = t (1 + d + d^2 + d^3) but for d^4.
    #[inline(always)]
    fn reciprocal(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let one = _mm512_set1_pd(1.0);
            let t = _mm512_rcp14_pd(self.0);
            let d = _mm512_fnmadd_pd(self.0, t, one);
            let series = _mm512_fmadd_pd(d, _mm512_fmadd_pd(d, d, d), d);
            Self(_mm512_fmadd_pd(series, t, t))
        }
    }

    /// With an estimate r, good to 2^-14, and d = 1 - x r^2: 1/sqrt(x) = r (1 + d/2 + 3/8 d^2 + 5/16 d^3) but for d^4.
    /// The estimate of 1 is defined to be 1.
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let splat = |value| _mm512_set1_pd(value);
            let r = _mm512_rsqrt14_pd(self.0);
            let d = _mm512_fnmadd_pd(_mm512_mul_pd(self.0, r), r, splat(1.0));
            let series = _mm512_fmadd_pd(splat(0.3125), d, splat(0.375));
            let series = _mm512_fmadd_pd(series, d, splat(0.5));
            Self(_mm512_fmadd_pd(_mm512_mul_pd(d, r), series, r))
        }
    }

    /// As [`Lanes::reciprocal_root`], and d^4 as well: with d = (1 - r^2) - z r^2 no digit of a small z is lost.
    #[inline(always)]
    fn shortfall(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let splat = |value| _mm512_set1_pd(value);
            let (z, one) = (self.0, splat(1.0));
            let r = _mm512_rsqrt14_pd(_mm512_max_pd(_mm512_add_pd(z, one), splat(LEAST)));
            let d = _mm512_fnmadd_pd(_mm512_mul_pd(z, r), r, _mm512_fnmadd_pd(r, r, one));
            let series = _mm512_fmadd_pd(splat(35.0 / 128.0), d, splat(0.3125));
            let series = _mm512_fmadd_pd(series, d, splat(0.375));
            let series = _mm512_fmadd_pd(series, d, splat(0.5));
            Self(_mm512_fnmadd_pd(_mm512_mul_pd(d, r), series, _mm512_sub_pd(one, r)))
        }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn above(self, other: Self) -> Bits {
        // SAFETY: as above.
        Bits(unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn joined(self, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_or_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn parts(self) -> (Self, Self) {
        // SAFETY: as above.
        unsafe {
            let all = |bits| _mm512_set1_epi64(bits);
            let bits = _mm512_castpd_si512(self.0);
            let raised = _mm512_add_epi64(bits, all(TO_ONE));
            let exponent = _mm512_and_si512(raised, all(EXPONENT));
            let mantissa = _mm512_add_epi64(_mm512_sub_epi64(bits, exponent), all(ONE));
            let written = _mm512_or_si512(_mm512_srli_epi64::<52>(exponent), all(DIGITS));
            let number = _mm512_castsi512_pd(written);
            let number = _mm512_sub_pd(number, _mm512_set1_pd(EXPONENT_OF_ONE));
            (Self(_mm512_castsi512_pd(mantissa)), Self(number))
        }
    }

    #[inline(always)]
    fn signs(self) -> u8 {
        // SAFETY: as above.
        unsafe { _mm512_movepi64_mask(_mm512_castpd_si512(self.0)) }
    }

    #[inline(always)]
    fn only(self, mask: Bits) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_maskz_mov_pd(mask.0, self.0) })
    }

    #[inline(always)]
    fn or(self, mask: Bits, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_mask_mov_pd(other.0, mask.0, self.0) })
    }

    #[inline(always)]
    fn total(self) -> f64 {
        // SAFETY: as above.
        unsafe { _mm512_reduce_add_pd(self.0) }
    }
}

impl Mask for Bits {
    #[inline(always)]
    fn bits(self) -> u8 {
        self.0
    }
}

impl BitAnd for Bits {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}
