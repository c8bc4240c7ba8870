//! Two lanes: a register of SSE2 on x86-64, and elsewhere two numbers that the compiler has a free hand with. Each
//! lane is rounded by itself, so both give the same bits.

use std::ops::{Add, BitAnd, Mul, Sub};

use super::{LEAST, Lanes, Mask, Quad, Simd, operators};
use registers::{Chosen as ChosenPair, Pair};

/// What every machine has.
#[derive(Clone, Copy)]
pub(super) struct Baseline;

#[derive(Clone, Copy)]
pub(super) struct Two(Pair);

#[derive(Clone, Copy)]
pub(super) struct Chosen(ChosenPair);

operators! { Two:
    Add add = registers::add;
    Sub sub = registers::subtract;
    Mul mul = registers::multiply;
    Div div = registers::divide;
}

/// Four numbers, two by two.
#[derive(Clone, Copy)]
pub(super) struct Pairs([Two; 2]);

impl Pairs {
    #[inline(always)]
    fn with(self, other: Self, pair: impl Fn(Two, Two) -> Two) -> Self {
        Self([pair(self.0[0], other.0[0]), pair(self.0[1], other.0[1])])
    }
}

impl Add for Pairs {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |one, two| one + two)
    }
}

impl Sub for Pairs {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |one, two| one - two)
    }
}

impl Mul for Pairs {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |one, two| one * two)
    }
}

impl Quad for Pairs {
    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn component<const K: usize>(self) -> Self {
        let pair = self.0[K / 2].0;
        let number = if K & 1 == 0 { registers::low(pair) } else { registers::high(pair) };
        Baseline.quad_of(number)
    }

    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        let [one, two] = self.0;
        [
            registers::low(one.0),
            registers::high(one.0),
            registers::low(two.0),
            registers::high(two.0),
        ]
    }
}

impl Simd for Baseline {
    const WIDTH: usize = 2;
    type Lanes = Two;
    type Mask = Chosen;
    type Quad = Pairs;

    #[inline(always)]
    fn splat(self, value: f64) -> Two {
        Two(registers::pair(value, value))
    }

    #[inline(always)]
    fn load(self, values: &[f64]) -> Two {
        let values = &values[..2];
        Two(registers::pair(values[0], values[1]))
    }

    #[inline(always)]
    fn quad(self, numbers: &[f64; 4]) -> Pairs {
        Pairs([self.load(numbers), self.load(&numbers[2..])])
    }

    #[inline(always)]
    fn quad_of(self, number: f64) -> Pairs {
        Pairs([self.splat(number); 2])
    }

    #[inline(always)]
    fn mask(self, bits: u8) -> Chosen {
        let lane = |k: u8| f64::from(bits >> k & 1);
        Chosen(registers::above(registers::pair(lane(0), lane(1)), registers::pair(0.0, 0.0)))
    }

    #[inline(always)]
    unsafe fn columns<const C: usize>(
        self,
        table: &[[f64; C]],
        first: usize,
        at: &[u32],
    ) -> [Two; 4] {
        assert!(first + 4 <= C && at.len() >= 2);
        // SAFETY: the caller names rows of the table.
        let [low, high] = [0, 1].map(|k| unsafe { table.get_unchecked(at[k] as usize) });
        [0, 1, 2, 3].map(|column| Two(registers::pair(low[first + column], high[first + column])))
    }
}

impl Lanes for Two {
    type Mask = Chosen;

    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        (values[0], values[1]) = (registers::low(self.0), registers::high(self.0));
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn mul_sub_from(self, factor: Self, term: Self) -> Self {
        term - self * factor
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(registers::root(self.0))
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Baseline.splat(1.0) / self
    }

    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        self.sqrt().reciprocal()
    }

    /// With r = sqrt(1 + z): z/(r (r + 1)).
    #[inline(always)]
    fn shortfall(self) -> Self {
        let one = Baseline.splat(1.0);
        let root = (one + self).max(Baseline.splat(LEAST)).sqrt();
        self / (root * (root + one))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(registers::larger(self.0, other.0))
    }

    #[inline(always)]
    fn above(self, other: Self) -> Chosen {
        Chosen(registers::above(self.0, other.0))
    }

    #[inline(always)]
    fn joined(self, other: Self) -> Self {
        Self(registers::joined(self.0, other.0))
    }

    #[inline(always)]
    fn parts(self) -> (Self, Self) {
        (Self(registers::mantissa(self.0)), Self(registers::exponent(self.0)))
    }

    #[inline(always)]
    fn signs(self) -> u8 {
        registers::signs(self.0)
    }

    #[inline(always)]
    fn only(self, mask: Chosen) -> Self {
        Self(registers::only(self.0, mask.0))
    }

    #[inline(always)]
    fn or(self, mask: Chosen, other: Self) -> Self {
        Self(registers::choose(self.0, mask.0, other.0))
    }

    #[inline(always)]
    fn total(self) -> f64 {
        registers::low(self.0) + registers::high(self.0)
    }
}

impl Mask for Chosen {
    #[inline(always)]
    fn bits(self) -> u8 {
        registers::bits(self.0)
    }
}

impl BitAnd for Chosen {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(registers::both(self.0, other.0))
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(dead_code)] // as what calls it
mod registers {
    use super::super::{DIGITS, EXPONENT, EXPONENT_OF_ONE, ONE, TO_ONE};
    use std::arch::x86_64 as sse2;
    pub(super) type Pair = sse2::__m128d;
    /// All bits of a lane are set, or none.
    pub(super) type Chosen = sse2::__m128d;

    macro_rules! calls {
        ($($name:ident($($argument:ident: $type:ty),*) -> $result:ty = $call:expr;)+) => {
            $(#[inline(always)]
            pub(super) fn $name($($argument: $type),*) -> $result {
                // SAFETY: SSE2 is part of x86-64.
                unsafe { $call }
            })+
        };
    }
    calls! {
        pair(low: f64, high: f64) -> Pair = sse2::_mm_set_pd(high, low);
        low(a: Pair) -> f64 = sse2::_mm_cvtsd_f64(a);
        high(a: Pair) -> f64 = sse2::_mm_cvtsd_f64(sse2::_mm_unpackhi_pd(a, a));
        add(a: Pair, b: Pair) -> Pair = sse2::_mm_add_pd(a, b);
        subtract(a: Pair, b: Pair) -> Pair = sse2::_mm_sub_pd(a, b);
        multiply(a: Pair, b: Pair) -> Pair = sse2::_mm_mul_pd(a, b);
        divide(a: Pair, b: Pair) -> Pair = sse2::_mm_div_pd(a, b);
        root(a: Pair) -> Pair = sse2::_mm_sqrt_pd(a);
        above(a: Pair, b: Pair) -> Chosen = sse2::_mm_cmpgt_pd(a, b);
        larger(a: Pair, b: Pair) -> Pair = sse2::_mm_max_pd(a, b);
        joined(a: Pair, b: Pair) -> Pair = sse2::_mm_or_pd(a, b);
        signs(a: Pair) -> u8 = sse2::_mm_movemask_pd(a) as u8;
        only(a: Pair, chosen: Chosen) -> Pair = sse2::_mm_and_pd(a, chosen);
        choose(a: Pair, chosen: Chosen, b: Pair) -> Pair =
            sse2::_mm_or_pd(sse2::_mm_and_pd(chosen, a), sse2::_mm_andnot_pd(chosen, b));
        both(a: Chosen, b: Chosen) -> Chosen = sse2::_mm_and_pd(a, b);
        bits(a: Chosen) -> u8 = sse2::_mm_movemask_pd(a) as u8;
        exponent_bits(a: Pair) -> sse2::__m128i = {
            let raised = sse2::_mm_add_epi64(sse2::_mm_castpd_si128(a), sse2::_mm_set1_epi64x(TO_ONE));
            sse2::_mm_and_si128(raised, sse2::_mm_set1_epi64x(EXPONENT))
        };
        mantissa(a: Pair) -> Pair = {
            let less = sse2::_mm_sub_epi64(sse2::_mm_castpd_si128(a), exponent_bits(a));
            sse2::_mm_castsi128_pd(sse2::_mm_add_epi64(less, sse2::_mm_set1_epi64x(ONE)))
        };
        exponent(a: Pair) -> Pair = {
            let written = sse2::_mm_srli_epi64::<52>(exponent_bits(a));
            let written = sse2::_mm_or_si128(written, sse2::_mm_set1_epi64x(DIGITS));
            let one = sse2::_mm_set1_pd(EXPONENT_OF_ONE);
            sse2::_mm_sub_pd(sse2::_mm_castsi128_pd(written), one)
        };
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod registers {
    use super::super::{DIGITS, EXPONENT, EXPONENT_OF_ONE, ONE, TO_ONE};
    pub(super) type Pair = [f64; 2];
    pub(super) type Chosen = [bool; 2];

    macro_rules! calls {
        ($($name:ident($($argument:ident: $type:ty),*) -> $result:ty = $each:expr;)+) => {
            $(#[inline(always)]
            pub(super) fn $name($($argument: [$type; 2]),*) -> [$result; 2] {
                let each: fn($($type),*) -> $result = $each;
                [each($($argument[0]),*), each($($argument[1]),*)]
            })+
        };
    }
    calls! {
        add(a: f64, b: f64) -> f64 = |a, b| a + b;
        subtract(a: f64, b: f64) -> f64 = |a, b| a - b;
        multiply(a: f64, b: f64) -> f64 = |a, b| a * b;
        divide(a: f64, b: f64) -> f64 = |a, b| a / b;
        root(a: f64) -> f64 = f64::sqrt;
        above(a: f64, b: f64) -> bool = |a, b| a > b;
        larger(a: f64, b: f64) -> f64 = |a, b| if a > b { a } else { b };
        joined(a: f64, b: f64) -> f64 = |a, b| f64::from_bits(a.to_bits() | b.to_bits());
        only(a: f64, chosen: bool) -> f64 = |a, chosen| if chosen { a } else { 0.0 };
        choose(a: f64, chosen: bool, b: f64) -> f64 = |a, chosen, b| if chosen { a } else { b };
        both(a: bool, b: bool) -> bool = |a, b| a & b;
        mantissa(a: f64) -> f64 = |a| {
            f64::from_bits((a.to_bits() as i64 - exponent_bits(a) + ONE) as u64)
        };
        exponent(a: f64) -> f64 = |a| {
            f64::from_bits((exponent_bits(a) >> 52 | DIGITS) as u64) - EXPONENT_OF_ONE
        };
    }

    fn exponent_bits(a: f64) -> i64 {
        (a.to_bits() as i64).wrapping_add(TO_ONE) & EXPONENT
    }

    #[inline(always)]
    pub(super) fn pair(low: f64, high: f64) -> Pair {
        [low, high]
    }
    #[inline(always)]
    pub(super) fn low(a: Pair) -> f64 {
        a[0]
    }
    #[inline(always)]
    pub(super) fn high(a: Pair) -> f64 {
        a[1]
    }
    #[inline(always)]
    pub(super) fn signs(a: Pair) -> u8 {
        bits(a.map(f64::is_sign_negative))
    }
    #[inline(always)]
    pub(super) fn bits(a: Chosen) -> u8 {
        u8::from(a[0]) | u8::from(a[1]) << 1
    }
}
