//! A few numbers at once: the arithmetic that the sweeps over bonds are written in.
//!
//! On x86-64 two numbers share a register, as on every processor of that kind; elsewhere the compiler
//! has a free hand. Each lane is rounded by itself, so both give the same bits.

use std::array;
use std::ops::{Add, Div, Mul, Sub};

/// Lanes that are computed together; a block of bonds holds a multiple of it.
pub(crate) const WIDTH: usize = 2;

/// One number for each of [`WIDTH`] bonds.
#[derive(Clone, Copy)]
pub(crate) struct Lanes(Pair);

impl Lanes {
    #[inline(always)]
    pub(crate) fn splat(value: f64) -> Self {
        Self(registers::pair(value, value))
    }

    #[inline(always)]
    pub(crate) fn load(values: &[f64; WIDTH]) -> Self {
        Self(registers::pair(values[0], values[1]))
    }

    /// The number that `lane` gives for each lane.
    #[inline(always)]
    pub(crate) fn from_fn(lane: impl FnMut(usize) -> f64) -> Self {
        Self::load(&array::from_fn(lane))
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(registers::root(self.0))
    }

    /// Where these are greater than `other`, as bits.
    #[inline(always)]
    pub(crate) fn above(self, other: Self) -> u8 {
        registers::bits_above(self.0, other.0)
    }

    /// These where `probe` is above zero, else 0.
    #[inline(always)]
    pub(crate) fn where_positive(self, probe: Self) -> Self {
        Self(registers::where_positive(self.0, probe.0))
    }

    /// These where a bit is set, else 0.
    #[inline(always)]
    pub(crate) fn only(self, bits: u8) -> Self {
        self.where_positive(Self::from_fn(|k| f64::from(bits >> k & 1)))
    }

    /// The lanes added up.
    #[inline(always)]
    pub(crate) fn total(self) -> f64 {
        registers::low(self.0) + registers::high(self.0)
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(registers::add(self.0, other.0))
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(registers::subtract(self.0, other.0))
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(registers::multiply(self.0, other.0))
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(registers::divide(self.0, other.0))
    }
}

use registers::Pair;

/// Two numbers in a register.
#[cfg(target_arch = "x86_64")]
mod registers {
    use std::arch::x86_64 as sse2;
    pub(super) type Pair = sse2::__m128d;

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
        bits_above(a: Pair, b: Pair) -> u8 = sse2::_mm_movemask_pd(sse2::_mm_cmpgt_pd(a, b)) as u8;
        where_positive(a: Pair, probe: Pair) -> Pair =
            sse2::_mm_and_pd(a, sse2::_mm_cmpgt_pd(probe, sse2::_mm_setzero_pd()));
    }
}

/// Two numbers side by side.
#[cfg(not(target_arch = "x86_64"))]
mod registers {
    pub(super) type Pair = [f64; 2];

    macro_rules! calls {
        ($($name:ident = $each:expr;)+) => {
            $(#[inline(always)]
            pub(super) fn $name(a: Pair, b: Pair) -> Pair {
                let each: fn(f64, f64) -> f64 = $each;
                [each(a[0], b[0]), each(a[1], b[1])]
            })+
        };
    }
    calls! {
        add = |a, b| a + b;
        subtract = |a, b| a - b;
        multiply = |a, b| a * b;
        divide = |a, b| a / b;
        where_positive = |a, probe| if probe > 0.0 { a } else { 0.0 };
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
    pub(super) fn root(a: Pair) -> Pair {
        a.map(f64::sqrt)
    }
    #[inline(always)]
    pub(super) fn bits_above(a: Pair, b: Pair) -> u8 {
        u8::from(a[0] > b[0]) | u8::from(a[1] > b[1]) << 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lane_is_its_own() {
        let (a, b) = ([1.7, -0.3], [0.1, 2.9]);
        let (x, y) = (Lanes::load(&a), Lanes::from_fn(|k| b[k]));
        let lanes = |lanes: Lanes| [registers::low(lanes.0), registers::high(lanes.0)];
        let each = |operation: fn(f64, f64) -> f64| [operation(a[0], b[0]), operation(a[1], b[1])];
        assert_eq!(lanes(x + y), each(|a, b| a + b));
        assert_eq!(lanes(x - y), each(|a, b| a - b));
        assert_eq!(lanes(x * y), each(|a, b| a * b));
        assert_eq!(lanes(x / y), each(|a, b| a / b));
        assert_eq!(lanes(y.sqrt()), b.map(f64::sqrt));
        assert_eq!(lanes(y.where_positive(x)), [0.1, 0.0]);
        assert_eq!(lanes(x.only(2)), [0.0, -0.3]);
        assert_eq!(x.above(y), 1);
        assert_eq!(x.total(), 1.7 + -0.3);
    }

    #[test]
    fn what_is_not_a_number_is_above_nothing() {
        assert_eq!(Lanes::splat(f64::NAN).above(Lanes::splat(0.0)), 0);
    }
}
