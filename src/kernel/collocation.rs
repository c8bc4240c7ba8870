//! The divergence of a stress by collocation, over blocks of bonds: sum w V_j (S_j - S_i) (A_i q + B_i du) with the
//! monomials q of bonds. [P 3.51; B]
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::family::{Family, Table};
use super::gradient::monomials;
use super::simd::{Kernel, Lanes, Simd};
use crate::families::Property;

/// Forces of the points of a range. Rows of the table have the tensor S from `first` on; `operators`: A and B of a point.
/// Gives the first point whose force is not finite.
pub(crate) struct Collocation<'a, O, const D: usize, const SIZE: usize, const C: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) table: Table<'a, C>,
    pub(crate) first: usize,
    pub(crate) horizons: &'a Property,
    pub(crate) operators: O,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
}

impl<O, const D: usize, const SIZE: usize, const C: usize> Kernel for Collocation<'_, O, D, SIZE, C>
where
    O: Fn(usize) -> ([[f64; SIZE]; D], [[f64; D]; D]),
{
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { family, table, first, horizons, operators, range, force } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let (own, horizon) = (family.own(simd, point), horizons.at(point));
            let tensor = &table.row(point)[first..first + D * D];
            let (of_monomials, of_moved) = operators(point);
            let mut sum = [simd.splat(0.0); D];
            let (start, end) = family.swept(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume);
                let weight = weight.only(simd.mask(family.bits(slot)));
                let q = monomials::<S, D, SIZE>(simd, &bonds.reference, horizon);
                let mut along = bonds.moved;
                for row in 0..D {
                    let mut sum = simd.splat(of_moved[row][0]) * bonds.moved[0];
                    for column in 1..D {
                        sum = simd.splat(of_moved[row][column]).mul_add(bonds.moved[column], sum);
                    }
                    for k in 0..SIZE {
                        sum = simd.splat(of_monomials[row][k]).mul_add(q[k], sum);
                    }
                    along[row] = weight * sum;
                }
                let mut other = [simd.splat(0.0); 12];
                for number in (0..D * D).step_by(4) {
                    let names = family.names::<S>(slot);
                    // SAFETY: the search makes neighbours of points of the body alone, and each has a row.
                    let four = unsafe { table.columns(simd, first + number, names) };
                    other[number..number + 4].copy_from_slice(&four);
                }
                for row in 0..D {
                    for column in 0..D {
                        let place = row * D + column;
                        let apart = other[place] - simd.splat(tensor[place]);
                        sum[row] = apart.mul_add(along[column], sum[row]);
                    }
                }
            }
            for axis in 0..D {
                force[axis] = sum[axis].total();
            }
            if bad.is_none() && !force.iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }
}
