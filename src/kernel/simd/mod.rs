//! Arithmetic on a few numbers at once, with the instructions of the machine that it runs on.
//!
//! A loop over bonds is a [`Kernel`]: its body is written once, for any [`Simd`], and compiled for each level.
//! [`SimdLevel::run`] is the one place where a level is entered; all below it is inlined there. Blocks of eight bonds
//! are computed in parts of [`Simd::WIDTH`]. Each lane is computed by itself, whatever the others hold.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod baseline;
mod level;
#[cfg(test)]
mod tests;

use std::ops::{Add, BitAnd, Div, Mul, Sub};

pub use level::SimdLevel;

/// A loop that is compiled for every level. `run` is to be `#[inline(always)]`, as all that it calls in its
/// inner loops: what is not inlined, as closures that are called twice and the longer methods of iterators, is compiled
/// for the baseline and passes lanes through memory.
pub(crate) trait Kernel {
    type Output;
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// The instructions of a level. A value of such a type exists only where the machine has them.
#[allow(dead_code)] // what a kernel may want, used yet or not
pub(crate) trait Simd: Copy {
    /// Lanes that are computed together: 2, 4 or 8.
    const WIDTH: usize;
    type Lanes: Lanes<Mask = Self::Mask>;
    type Mask: Mask;
    type Quad: Quad;

    fn splat(self, value: f64) -> Self::Lanes;

    /// The first numbers of `values`, one a lane. Panics when there are fewer.
    fn load(self, values: &[f64]) -> Self::Lanes;

    /// The number that `lane` gives for each lane.
    #[inline(always)]
    fn each(self, mut lane: impl FnMut(usize) -> f64) -> Self::Lanes {
        let mut values = [0.0; 8];
        // A loop, since calls of iterators may not be inlined into a level.
        for (k, value) in values[..Self::WIDTH].iter_mut().enumerate() {
            *value = lane(k);
        }
        self.load(&values)
    }

    fn quad(self, numbers: &[f64; 4]) -> Self::Quad;

    fn quad_of(self, number: f64) -> Self::Quad;

    /// The lanes whose bits are set; bits beyond the last lane do not matter.
    fn mask(self, bits: u8) -> Self::Mask;

    /// Columns `first` to `first + 4` of the rows that `at` names, one row a lane: rows are read whole and turned
    /// into columns. Panics when `at` has fewer names than there are lanes.
    ///
    /// # Safety
    /// The first `WIDTH` of `at` name rows of the table.
    unsafe fn columns<const C: usize>(
        self,
        table: &[[f64; C]],
        first: usize,
        at: &[u32],
    ) -> [Self::Lanes; 4];

    /// The numbers that `at` names, one a lane. Panics when `at` has fewer names than there are lanes.
    ///
    /// # Safety
    /// The first `WIDTH` of `at` name numbers of the table.
    #[inline(always)]
    unsafe fn gather(self, table: &[f64], at: &[u32]) -> Self::Lanes {
        let at = &at[..Self::WIDTH];
        // SAFETY: as the caller has promised.
        self.each(|k| unsafe { *table.get_unchecked(at[k] as usize) })
    }

    /// Writes the lanes whose bits are set, and the names that stand at these, one after the other to the front of both
    /// outputs; what is behind them there, up to so many lanes, does not matter. Panics when a slice is shorter than that.
    #[inline(always)]
    fn pack(
        self,
        bits: u8,
        lanes: Self::Lanes,
        names: &[u32],
        numbers: &mut [f64],
        packed: &mut [u32],
    ) {
        let mut values = [0.0; 8];
        lanes.store(&mut values);
        let (names, numbers, packed) =
            (&names[..Self::WIDTH], &mut numbers[..Self::WIDTH], &mut packed[..Self::WIDTH]);
        let mut end = 0;
        for lane in 0..Self::WIDTH {
            // Written whether set or not, so that nothing is to be guessed.
            (numbers[end], packed[end]) = (values[lane], names[lane]);
            end += usize::from(bits >> lane & 1);
        }
    }
}

/// Four numbers of one row: a vector, and what stands behind it.
pub(crate) trait Quad:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// self factor + term, rounded once where the level can.
    fn fused(self, factor: Self, term: Self) -> Self;

    /// One of the numbers in place of all.
    fn component<const K: usize>(self) -> Self;

    fn numbers(self) -> [f64; 4];
}

/// One number in each lane.
#[allow(dead_code)] // as above
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    type Mask: Mask;

    /// Writes the lanes to the first numbers of `values`. Panics when there is no room.
    fn store(self, values: &mut [f64]);

    /// self factor + term, rounded once where the level can.
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// term - self factor, rounded once where the level can.
    fn mul_sub_from(self, factor: Self, term: Self) -> Self;

    fn sqrt(self) -> Self;

    /// The larger of both; `other` where these are not numbers.
    fn max(self, other: Self) -> Self;

    /// 1/x to the last bits, where x and 1/x are normal numbers.
    fn reciprocal(self) -> Self;

    /// 1/sqrt(x) to the last bits, where x is between 1e-30 and 1e30: squares of lengths are to be divided by one.
    /// Exactly 1 of 1, and not a number of what is infinite or none.
    fn reciprocal_root(self) -> Self;

    /// Where these are greater than `other`; nothing is above what is not a number, nor is that above anything.
    fn above(self, other: Self) -> Self::Mask;

    /// The bits that either has: the sign is set where one of both is.
    fn joined(self, other: Self) -> Self;

    /// m between 3/4 and 3/2 and e with m 2^e, of positive normal numbers. Others give what they will.
    fn parts(self) -> (Self, Self);

    /// One bit a lane: its sign is set.
    fn signs(self) -> u8;

    /// These where the mask is set, else 0.
    fn only(self, mask: Self::Mask) -> Self;

    /// These where the mask is set, else `other`.
    fn or(self, mask: Self::Mask, other: Self) -> Self;

    /// 1 - 1/sqrt(1 + z) of these z, right to 2e-19 and to the last bits of z and of 1 + z, and exactly 0 of 0. With 1 + z = (l/L)^2
    /// this is (l - L)/l. Below 1e-15, where 1 + z is all rounding, it takes 1 + z for 1e-15. Not a number of what
    /// is infinite or none.
    fn shortfall(self) -> Self;

    /// The lanes added up, in an order that is the same for all of a level.
    fn total(self) -> f64;
}

/// The bits of an exponent, of 1, of the least number above which [`Lanes::parts`] halve up to 1, and of the number behind whose
/// digits an exponent is written to be read as a number: 2^52.
const EXPONENT: i64 = 0x7FF << 52;
const ONE: i64 = 0x3FF << 52;
const TO_ONE: i64 = 1 << 51;
const DIGITS: i64 = 0x433 << 52;

/// What that number is with the exponent of 1 behind it.
const EXPONENT_OF_ONE: f64 = 4_503_599_627_370_496.0 + 1023.0;

/// ln(1 + z) to the last bits, also where z is small, of normal 1 + z; not a number where 1 + z is not positive.
#[inline(always)]
pub(crate) fn ln_1p<S: Simd>(simd: S, z: S::Lanes) -> S::Lanes {
    logarithm(simd, simd.splat(1.0) + z, z)
}

/// The same of 1 + z and z, each with all its digits.
#[inline(always)]
pub(crate) fn logarithm<S: Simd>(simd: S, x: S::Lanes, z: S::Lanes) -> S::Lanes {
    let (zero, one, two) = (simd.splat(0.0), simd.splat(1.0), simd.splat(2.0));
    let (mantissa, exponent) = x.parts();
    // 1 + z has lost digits of a small z.
    let rest = (mantissa - one).or((exponent * exponent).above(zero), z);
    // ln(1 + rest) = 2 artanh s = 2 s (1 + s^2/3 + s^4/5 + ...), with s^2 < 1/25
    let s = rest / (two + rest);
    let square = s * s;
    let mut series = simd.splat(1.0 / 23.0);
    for term in 1..11 {
        series = series.mul_add(square, simd.splat(1.0 / (23 - 2 * term) as f64));
    }
    let twice = s + s;
    let logarithm = (series * square).mul_add(twice, twice);
    let logarithm = exponent.mul_add(simd.splat(std::f64::consts::LN_2), logarithm);
    logarithm.or(x.above(zero), simd.splat(f64::NAN))
}

/// The least 1 + z that [`Lanes::shortfall`] takes the root of.
const LEAST: f64 = 1e-15;

/// A length, of which others are taken parts before roots: see [`Lanes::reciprocal_root`]. A power of two, so that no digit is lost.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unit {
    inverse: f64,
    inverse_squared: f64,
}

impl Unit {
    pub(crate) fn near(length: f64) -> Self {
        let inverse = (-length.log2().round().clamp(-500.0, 500.0)).exp2();
        Self { inverse, inverse_squared: inverse * inverse }
    }

    /// 1/L of L^2.
    #[inline(always)]
    pub(crate) fn inverse_length<S: Simd>(self, simd: S, squared: S::Lanes) -> S::Lanes {
        let squared = squared * simd.splat(self.inverse_squared);
        squared.reciprocal_root() * simd.splat(self.inverse)
    }
}

/// Some of the lanes.
pub(crate) trait Mask: Copy + BitAnd<Output = Self> {
    /// One bit a lane.
    fn bits(self) -> u8;
}

/// Asks for what stands at an index to be brought near, if there is such a thing.
#[inline(always)]
pub(crate) fn prefetch<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: part of x86-64, and nothing is read, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(values.as_ptr().wrapping_add(index).cast()) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

/// Names whose rows are asked for ahead of their turn: a few blocks of bonds.
const ROWS_AHEAD: usize = 32;

/// Asks for the rows of a table that will be read after so many that names name from the first on, if there are as many.
#[inline(always)]
pub(crate) fn prefetch_rows<const C: usize>(
    table: &[[f64; C]],
    names: &[u32],
    first: usize,
    count: usize,
) {
    let numbers = table.as_flattened();
    let first = first + ROWS_AHEAD;
    if let Some(names) = names.get(first..first + count) {
        for &name in names {
            // A number of each line of the cache.
            for number in (0..C).step_by(8) {
                prefetch(numbers, name as usize * C + number);
            }
        }
    }
}

/// Numbers of records of rows of four, one record a lane, from the rows on that `at` names. Panics where there are fewer rows.
#[inline(always)]
pub(crate) fn read_records<S: Simd>(
    simd: S,
    rows: &[[f64; 4]],
    at: &[usize; 8],
    numbers: &mut [S::Lanes],
) {
    for (place, four) in numbers.chunks_exact_mut(4).enumerate() {
        let mut names = [0; 8];
        for lane in 0..S::WIDTH {
            let row = at[lane] + place;
            assert!(row < rows.len() && row <= u32::MAX as usize);
            names[lane] = row as u32;
        }
        // SAFETY: these are rows, as has been seen.
        four.copy_from_slice(&unsafe { simd.columns(rows, 0, &names) });
    }
}

/// Operators of a type of lanes, from an unsafe call of its level each.
macro_rules! operators {
    ($lanes:ident: $($trait:ident $method:ident = $call:path;)+) => {
        $(impl std::ops::$trait for $lanes {
            type Output = Self;
            #[inline(always)]
            #[allow(unused_unsafe)] // where all machines have the call
            fn $method(self, other: Self) -> Self {
                // SAFETY: lanes of a level exist only where the machine has its instructions.
                Self(unsafe { $call(self.0, other.0) })
            }
        })+
    };
}
use operators;
