//! Four lanes in a register of AVX2, with fused multiply-add.

use std::arch::x86_64::*;
use std::ops::BitAnd;

use super::{
    DIGITS, EXPONENT, EXPONENT_OF_ONE, LEAST, Lanes, Mask, ONE, Quad, Simd, TO_ONE, operators,
};

/// AVX2 with fused multiply-add.
#[derive(Clone, Copy)]
pub(super) struct Avx2(());

#[derive(Clone, Copy)]
pub(super) struct Four(__m256d);

/// Which lanes come to the front: as such, and as halves of numbers.
#[derive(Clone, Copy)]
struct Packed {
    lanes: [u32; 4],
    halves: [u32; 8],
}

/// For each choice of lanes those that are chosen.
const PACKED: [Packed; 16] = {
    let mut all = [Packed { lanes: [0; 4], halves: [0; 8] }; 16];
    let mut bits = 0;
    while bits < 16 {
        let (mut lane, mut end) = (0, 0);
        while lane < 4 {
            if bits >> lane & 1 == 1 {
                all[bits].lanes[end] = lane;
                all[bits].halves[2 * end] = 2 * lane;
                all[bits].halves[2 * end + 1] = 2 * lane + 1;
                end += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    all
};

/// All bits of a lane are set, or none.
#[derive(Clone, Copy)]
pub(super) struct Chosen(__m256d);

impl Avx2 {
    /// # Safety
    /// The machine has the instructions.
    #[inline(always)]
    pub(super) unsafe fn new() -> Self {
        Self(())
    }
}

operators! { Four:
    Add add = _mm256_add_pd;
    Sub sub = _mm256_sub_pd;
    Mul mul = _mm256_mul_pd;
    Div div = _mm256_div_pd;
}

impl Simd for Avx2 {
    const WIDTH: usize = 4;
    type Lanes = Four;
    type Mask = Chosen;
    type Quad = Four;

    #[inline(always)]
    fn splat(self, value: f64) -> Four {
        // SAFETY: the machine has the level.
        Four(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn load(self, values: &[f64]) -> Four {
        let values = &values[..4];
        // SAFETY: the machine has the level, and there are four numbers.
        Four(unsafe { _mm256_loadu_pd(values.as_ptr()) })
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
    fn mask(self, bits: u8) -> Chosen {
        // SAFETY: the machine has the level.
        Chosen(unsafe {
            let each = _mm256_set_epi64x(8, 4, 2, 1);
            let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), each);
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, each))
        })
    }

    #[inline(always)]
    unsafe fn columns<const C: usize>(
        self,
        table: &[[f64; C]],
        first: usize,
        at: &[u32],
    ) -> [Four; 4] {
        assert!(first + 4 <= C && at.len() >= 4);
        // SAFETY: the machine has the level, and the caller names rows of the table, each of which has four numbers
        // from `first` on.
        unsafe {
            let row = |k: usize| table.as_ptr().add(at[k] as usize).cast::<f64>().add(first);
            // The halves of rows k and k + 2.
            let halves = |k: usize, half: usize| {
                let low = _mm256_castpd128_pd256(_mm_loadu_pd(row(k).add(half)));
                _mm256_insertf128_pd::<1>(low, _mm_loadu_pd(row(k + 2).add(half)))
            };
            let (a, b, c, d) = (halves(0, 0), halves(1, 0), halves(0, 2), halves(1, 2));
            [
                Four(_mm256_unpacklo_pd(a, b)),
                Four(_mm256_unpackhi_pd(a, b)),
                Four(_mm256_unpacklo_pd(c, d)),
                Four(_mm256_unpackhi_pd(c, d)),
            ]
        }
    }

    #[inline(always)]
    fn pack(self, bits: u8, lanes: Four, names: &[u32], numbers: &mut [f64], packed: &mut [u32]) {
        let (names, numbers, packed) = (&names[..4], &mut numbers[..4], &mut packed[..4]);
        let order = &PACKED[usize::from(bits & 15)];
        // SAFETY: the machine has the level, there are four of each, and eight in an order.
        unsafe {
            let halves = _mm256_loadu_si256(order.halves.as_ptr().cast());
            let lanes = _mm256_permutevar8x32_ps(_mm256_castpd_ps(lanes.0), halves);
            _mm256_storeu_pd(numbers.as_mut_ptr(), _mm256_castps_pd(lanes));
            let names = _mm_loadu_ps(names.as_ptr().cast());
            let order = _mm_loadu_si128(order.lanes.as_ptr().cast());
            _mm_storeu_ps(packed.as_mut_ptr().cast(), _mm_permutevar_ps(names, order));
        }
    }
}

impl Lanes for Four {
    type Mask = Chosen;

    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        let values = &mut values[..4];
        // SAFETY: lanes of a level exist only where the machine has it, and there is room for four numbers.
        unsafe { _mm256_storeu_pd(values.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: lanes of a level exist only where the machine has it.
        Self(unsafe { _mm256_fmadd_pd(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn mul_sub_from(self, factor: Self, term: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_fnmadd_pd(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_div_pd(_mm256_set1_pd(1.0), self.0) })
    }

    /// With an estimate r in single precision, good to 1.5 2^-12, and d = 1 - x r^2: 1/sqrt(x) = r (1 + d/2 + 3/8 d^2
    /// + 5/16 d^3 + 35/128 d^4) but for d^5.
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let splat = |value| _mm256_set1_pd(value);
            let one = splat(1.0);
            let r = _mm256_cvtps_pd(_mm_rsqrt_ps(_mm256_cvtpd_ps(self.0)));
            let d = _mm256_fnmadd_pd(_mm256_mul_pd(self.0, r), r, one);
            let series = _mm256_fmadd_pd(splat(35.0 / 128.0), d, splat(0.3125));
            let series = _mm256_fmadd_pd(series, d, splat(0.375));
            let series = _mm256_fmadd_pd(series, d, splat(0.5));
            let root = _mm256_fmadd_pd(_mm256_mul_pd(d, r), series, r);
            Self(_mm256_blendv_pd(root, one, _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, one)))
        }
    }

    /// As [`Lanes::reciprocal_root`], and d^5 as well: with d = (1 - r^2) - z r^2 no digit of a small z is lost.
    #[inline(always)]
    fn shortfall(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let splat = |value| _mm256_set1_pd(value);
            let (z, one) = (self.0, splat(1.0));
            let x = _mm256_max_pd(_mm256_add_pd(z, one), splat(LEAST));
            let r = _mm256_cvtps_pd(_mm_rsqrt_ps(_mm256_cvtpd_ps(x)));
            let d = _mm256_fnmadd_pd(_mm256_mul_pd(z, r), r, _mm256_fnmadd_pd(r, r, one));
            let series = _mm256_fmadd_pd(splat(63.0 / 256.0), d, splat(35.0 / 128.0));
            let series = _mm256_fmadd_pd(series, d, splat(0.3125));
            let series = _mm256_fmadd_pd(series, d, splat(0.375));
            let series = _mm256_fmadd_pd(series, d, splat(0.5));
            let value = _mm256_fnmadd_pd(_mm256_mul_pd(d, r), series, _mm256_sub_pd(one, r));
            // The estimate of 1 may be off.
            let moved = _mm256_cmp_pd::<_CMP_NEQ_UQ>(z, _mm256_setzero_pd());
            Self(_mm256_and_pd(value, moved))
        }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn above(self, other: Self) -> Chosen {
        // SAFETY: as above.
        Chosen(unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn joined(self, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_or_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn parts(self) -> (Self, Self) {
        // SAFETY: as above.
        unsafe {
            let all = |bits| _mm256_set1_epi64x(bits);
            let bits = _mm256_castpd_si256(self.0);
            let raised = _mm256_add_epi64(bits, all(TO_ONE));
            let exponent = _mm256_and_si256(raised, all(EXPONENT));
            let mantissa = _mm256_add_epi64(_mm256_sub_epi64(bits, exponent), all(ONE));
            let written = _mm256_or_si256(_mm256_srli_epi64::<52>(exponent), all(DIGITS));
            let number = _mm256_castsi256_pd(written);
            let number = _mm256_sub_pd(number, _mm256_set1_pd(EXPONENT_OF_ONE));
            (Self(_mm256_castsi256_pd(mantissa)), Self(number))
        }
    }

    #[inline(always)]
    fn signs(self) -> u8 {
        // SAFETY: as above.
        unsafe { _mm256_movemask_pd(self.0) as u8 }
    }

    #[inline(always)]
    fn only(self, mask: Chosen) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_and_pd(self.0, mask.0) })
    }

    #[inline(always)]
    fn or(self, mask: Chosen, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_blendv_pd(other.0, self.0, mask.0) })
    }

    #[inline(always)]
    fn total(self) -> f64 {
        // SAFETY: as above.
        unsafe {
            let high = _mm256_extractf128_pd::<1>(self.0);
            let pair = _mm_add_pd(_mm256_castpd256_pd128(self.0), high);
            _mm_cvtsd_f64(_mm_add_sd(pair, _mm_unpackhi_pd(pair, pair)))
        }
    }
}

impl Four {
    /// # Safety
    /// The machine has the instructions.
    #[inline(always)]
    pub(super) unsafe fn of(numbers: &[f64; 4]) -> Self {
        // SAFETY: as the caller has promised, and there are four numbers.
        Self(unsafe { _mm256_loadu_pd(numbers.as_ptr()) })
    }

    /// # Safety
    /// The machine has the instructions.
    #[inline(always)]
    pub(super) unsafe fn all(number: f64) -> Self {
        // SAFETY: as the caller has promised.
        Self(unsafe { _mm256_set1_pd(number) })
    }
}

impl Quad for Four {
    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        self.mul_add(factor, term)
    }

    #[inline(always)]
    fn component<const K: usize>(self) -> Self {
        // SAFETY: lanes of a level exist only where the machine has it.
        Self(unsafe {
            match K {
                0 => _mm256_permute4x64_pd::<0x00>(self.0),
                1 => _mm256_permute4x64_pd::<0x55>(self.0),
                2 => _mm256_permute4x64_pd::<0xaa>(self.0),
                _ => _mm256_permute4x64_pd::<0xff>(self.0),
            }
        })
    }

    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        let mut numbers = [0.0; 4];
        self.store(&mut numbers);
        numbers
    }
}

impl Mask for Chosen {
    #[inline(always)]
    fn bits(self) -> u8 {
        // SAFETY: lanes of a level exist only where the machine has it.
        unsafe { _mm256_movemask_pd(self.0) as u8 }
    }
}

impl BitAnd for Chosen {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_and_pd(self.0, other.0) })
    }
}
