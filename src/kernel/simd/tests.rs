//! Every level that this machine has, lane by lane against plain arithmetic.

use super::{Kernel, Lanes, Mask, Simd, SimdLevel, ln_1p};

fn on_each_level(kernel: impl Kernel<Output = ()> + Copy) {
    for level in SimdLevel::ALL {
        if level.is_available() {
            level.run(kernel);
        } else {
            println!("skipped: this machine does not have the level {}", level.name());
        }
    }
}

fn lanes<S: Simd>(_: S, lanes: S::Lanes) -> Vec<f64> {
    let mut values = [0.0; 8];
    lanes.store(&mut values);
    values[..S::WIDTH].to_vec()
}

const A: [f64; 8] = [1.7, -0.3, 1e100, 5e-9, -2.5, 0.0, 3.0, 7.5];
const B: [f64; 8] = [0.1, 2.9, 1e-30, 4.0, 2.5, 1.0, 1e7, 0.5];

#[derive(Clone, Copy)]
struct Arithmetic;

impl Kernel for Arithmetic {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (a, b) = (simd.load(&A), simd.each(|k| B[k]));
        let each = |result: S::Lanes, plain: fn(f64, f64) -> f64| {
            for (k, value) in lanes(simd, result).into_iter().enumerate() {
                let expected = plain(A[k], B[k]);
                // Without fusion the product is rounded, too.
                let scale = expected.abs().max((A[k] * B[k]).abs().min(1.0));
                assert!((value - expected).abs() <= 4e-16 * scale, "{k}: {value}, {expected}");
            }
        };
        each(a + b, |a, b| a + b);
        each(a - b, |a, b| a - b);
        each(a * b, |a, b| a * b);
        each(a / b, |a, b| a / b);
        each(a.mul_add(b, simd.splat(1.0)), |a, b| a * b + 1.0);
        each(a.mul_sub_from(b, simd.splat(1.0)), |a, b| 1.0 - a * b);
        each(b.sqrt(), |_, b| b.sqrt());
        each(b.reciprocal(), |_, b| 1.0 / b);
        each(a.max(b), f64::max);
        let bits = a.above(b).bits();
        let all = (0..S::WIDTH).fold(0, |bits, k| bits | u8::from(A[k] > B[k]) << k);
        assert_eq!(bits, all);
        let odd = simd.mask(0b1010_1010);
        for k in 0..S::WIDTH {
            let chosen = k % 2 == 1;
            assert_eq!(lanes(simd, a.only(odd))[k], if chosen { A[k] } else { 0.0 });
            assert_eq!(lanes(simd, a.or(odd, b))[k], if chosen { A[k] } else { B[k] });
        }
        assert_eq!((odd & a.above(b)).bits(), bits & 0b1010_1010);
        let shifted = b - simd.splat(2.5);
        let negative = |k: usize| A[k] < 0.0 || B[k] < 2.5;
        let all = (0..S::WIDTH).fold(0, |bits, k| bits | u8::from(negative(k)) << k);
        assert_eq!((a.joined(shifted).signs(), b.joined(b).signs()), (all, 0));
        let (sum, expected) = (b.total(), B[..S::WIDTH].iter().sum::<f64>());
        assert!((sum - expected).abs() <= 1e-15 * expected);
    }
}

#[test]
fn each_lane_is_its_own() {
    on_each_level(Arithmetic);
}

#[derive(Clone, Copy)]
struct NotNumbers;

impl Kernel for NotNumbers {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (nan, zero) = (simd.splat(f64::NAN), simd.splat(0.0));
        assert_eq!(nan.above(zero).bits(), 0);
        assert_eq!(zero.above(nan).bits(), 0);
    }
}

#[test]
fn what_is_not_a_number_is_above_nothing() {
    on_each_level(NotNumbers);
}

#[derive(Clone, Copy)]
struct Columns;

impl Kernel for Columns {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let table: Vec<[f64; 6]> = (0..20)
            .map(|row| [0, 1, 2, 3, 4, 5].map(|column| f64::from(10 * row + column)))
            .collect();
        let at = [3, 19, 0, 7, 7, 11, 2, 5];
        // SAFETY: all of these are rows.
        let columns = unsafe { simd.columns(&table, 2, &at) };
        let numbers = table.as_flattened();
        // SAFETY: all of these are numbers of the table.
        let gathered = lanes(simd, unsafe { simd.gather(numbers, &at) });
        for k in 0..S::WIDTH {
            for (column, values) in columns.iter().enumerate() {
                assert_eq!(lanes(simd, *values)[k], table[at[k] as usize][2 + column]);
            }
            assert_eq!(gathered[k], numbers[at[k] as usize]);
        }
    }
}

#[test]
fn rows_are_turned_into_columns() {
    on_each_level(Columns);
}

#[derive(Clone, Copy)]
struct Packing;

impl Kernel for Packing {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let names = [10, 11, 12, 13, 14, 15, 16, 17];
        for choice in 0..1_u16 << S::WIDTH {
            let (mut numbers, mut packed) = ([0.0; 8], [0; 8]);
            simd.pack(choice as u8, simd.load(&A), &names, &mut numbers, &mut packed);
            let chosen = (0..S::WIDTH).filter(|lane| choice >> lane & 1 == 1);
            for (place, lane) in chosen.enumerate() {
                assert_eq!((numbers[place], packed[place]), (A[lane], names[lane]));
            }
        }
    }
}

#[test]
fn chosen_lanes_are_packed_in_their_order() {
    on_each_level(Packing);
}

#[derive(Clone, Copy)]
struct Roots;

impl Kernel for Roots {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let root = |x: f64| lanes(simd, simd.splat(x).reciprocal_root())[0];
        for step in -3000..3000 {
            let x = (0.02 * f64::from(step)).exp();
            let error = root(x) * x.sqrt() - 1.0;
            assert!(error.abs() < 5e-16, "{x}: {error}");
            let reciprocal = lanes(simd, simd.splat(x).reciprocal())[0];
            assert!((reciprocal * x - 1.0).abs() < 4e-16, "{x}");
        }
        assert_eq!(root(1.0), 1.0);
        assert!(root(f64::NAN).is_nan());
        assert!(root(f64::INFINITY).is_nan() || root(f64::INFINITY) == 0.0);
    }
}

#[test]
fn roots_are_right_to_the_last_bits_and_that_of_one_is_one() {
    on_each_level(Roots);
}

/// 1 - 1/sqrt(1 + z) without cancellation.
fn exact(z: f64) -> f64 {
    let root = (1.0 + z).sqrt();
    z / (root * (root + 1.0))
}

#[derive(Clone, Copy)]
struct Shortfall;

impl Kernel for Shortfall {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let of = |z: f64| lanes(simd, simd.splat(z).shortfall())[0];
        for step in 1..4000 {
            let size = (-0.01 * f64::from(step)).exp();
            for z in [size, -size, 3.0 * size, 1e3 * size] {
                // A short bond has lost digits already in z; an estimate good to 2^-11 adds as much of a rounding.
                let tolerance = 2e-19 + 1e-15 * exact(z).abs() / (1.0 + z).min(1.0);
                assert!((of(z) - exact(z)).abs() < tolerance, "{z}: {}, {}", of(z), exact(z));
            }
        }
        assert_eq!([of(0.0), of(-0.0)], [0.0; 2]);
        for z in [-1.0, -1.0 - 1e-15, -1.0 + 1e-16] {
            assert!(of(z) < 0.0 && of(z) > -1e9, "{}", of(z));
        }
        assert!(of(f64::INFINITY).is_nan());
    }
}

#[test]
fn the_shortfall_keeps_its_digits_and_is_zero_where_nothing_moved() {
    on_each_level(Shortfall);
}

#[derive(Clone, Copy)]
struct Logarithm;

impl Kernel for Logarithm {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let of = |z: f64| lanes(simd, ln_1p(simd, simd.splat(z)))[0];
        for step in -700..700 {
            let size = (0.1 * f64::from(step)).exp();
            for z in [size, -size, 1.3 * size, size - 1.0] {
                if z > -1.0 {
                    let error = of(z) - z.ln_1p();
                    assert!(error.abs() <= 4e-16 * z.ln_1p().abs(), "{z}: {}", of(z));
                }
            }
        }
        // Between mantissas of 3/4 and 3/2.
        for z in [-0.25, 0.5, 2.0, -0.25 - 1e-16, 0.5 - 1e-16] {
            assert!((of(z) - z.ln_1p()).abs() <= 4e-16 * z.ln_1p().abs(), "{z}: {}", of(z));
        }
        assert_eq!(of(0.0), 0.0);
        for z in [-1.0, -1.5, -1e300, f64::NAN] {
            assert!(of(z).is_nan(), "{z}");
        }
    }
}

#[test]
fn logarithms_are_right_to_the_last_bits() {
    on_each_level(Logarithm);
}
