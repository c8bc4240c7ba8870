//! Families of bonds: for each bond of a point, sums over those bonds of it that end near its other end, and vectors
//! that it adds to them. [P 4.15-4.20]
//!
//! Every bond looks at all the others, so the family is first laid out in columns.

use super::simd::{Kernel, Lanes, Simd};
use crate::families::LANES;

/// Columns of a family in 3D: xi, u_j - u_i, w V, V, and what is added to each bond.
const COLUMNS: usize = 11;

/// The bonds of a point, laid out for all of them to be looked at by each.
#[derive(Debug, Default)]
pub(crate) struct Members {
    table: Vec<f64>,
    /// Numbers of a column, whole groups of lanes; those beyond the members weigh nothing.
    stride: usize,
    count: usize,
}

/// A bond of the point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Member<const D: usize> {
    /// xi
    pub(crate) reference: [f64; D],
    /// u_j - u_i
    pub(crate) moved: [f64; D],
    /// w V
    pub(crate) weight: f64,
    /// V
    pub(crate) volume: f64,
}

/// Sums over the family of a bond.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near<const D: usize> {
    /// sum w xi xi^T V
    pub(crate) shape: [[f64; D]; D],
    /// sum w (u_j - u_i) xi^T V
    pub(crate) moved: [[f64; D]; D],
    /// sum V
    pub(crate) volume: f64,
}

impl Members {
    /// With room for as many bonds, in 3D or less.
    pub(crate) fn with_room(table: Vec<f64>) -> Self {
        Self { table, stride: 0, count: 0 }
    }

    /// Numbers of the table of a family of so many bonds.
    pub(crate) const fn room(bonds: usize) -> usize {
        COLUMNS * bonds.next_multiple_of(LANES)
    }

    /// Makes way for the family of a point that has no more than `most` bonds.
    pub(crate) fn clear(&mut self, most: usize) {
        (self.stride, self.count) = (most.next_multiple_of(LANES), 0);
        self.table[..COLUMNS * self.stride].fill(0.0);
    }

    pub(crate) fn add<const D: usize>(&mut self, member: &Member<D>) {
        let Self { stride, count, .. } = *self;
        for axis in 0..D {
            self.table[axis * stride + count] = member.reference[axis];
            self.table[(D + axis) * stride + count] = member.moved[axis];
        }
        self.table[2 * D * stride + count] = member.weight;
        self.table[(2 * D + 1) * stride + count] = member.volume;
        self.count += 1;
    }

    /// What was added to a member.
    pub(crate) fn sum<const D: usize>(&self, number: usize) -> [f64; D] {
        std::array::from_fn(|axis| self.table[(2 * D + 2 + axis) * self.stride + number])
    }

    pub(crate) fn bytes(&self) -> usize {
        crate::memory::bytes(&self.table)
    }
}

/// Calls `each` for each member with the sums over its family, the members no farther from it than a reach. A tensor A that
/// it gives adds A xi to the sums of these.
pub(crate) struct FamilySweep<'a, const D: usize> {
    pub(crate) members: &'a mut Members,
    /// The reach squared.
    pub(crate) reach: f64,
    pub(crate) each: &'a mut EachFamily<'a, D>,
}

/// What is made of the family of a member with a number.
pub(crate) type EachFamily<'a, const D: usize> =
    dyn FnMut(usize, &Near<D>) -> Option<[[f64; D]; D]> + 'a;

impl<const D: usize> Kernel for FamilySweep<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Members { table, stride, count } = self.members;
        let (stride, count) = (*stride, *count);
        let (columns, sums) = table.split_at_mut((2 * D + 2) * stride);
        let columns = Columns { simd, columns, stride, reach: simd.splat(self.reach.next_up()) };
        // Lanes beyond the members are zero.
        let lanes = count.next_multiple_of(LANES);
        for number in 0..count {
            let end = columns.at::<D>(number);
            let near = columns.near(&end, lanes);
            if let Some(tensor) = (self.each)(number, &near) {
                columns.add(&end, &tensor, lanes, sums);
            }
        }
    }
}

/// What the loops over members share.
struct Columns<'a, S: Simd> {
    simd: S,
    columns: &'a [f64],
    stride: usize,
    /// The least square of a length that is beyond reach.
    reach: S::Lanes,
}

impl<S: Simd> Columns<'_, S> {
    #[inline(always)]
    fn load(&self, column: usize, lane: usize) -> S::Lanes {
        self.simd.load(&self.columns[column * self.stride + lane..])
    }

    #[inline(always)]
    fn at<const D: usize>(&self, number: usize) -> [S::Lanes; D] {
        let mut end = [self.simd.splat(0.0); D];
        for (axis, end) in end.iter_mut().enumerate() {
            *end = self.simd.splat(self.columns[axis * self.stride + number]);
        }
        end
    }

    /// Members from a lane on, and which of them are near a place. Not fused: on all levels the same are.
    #[inline(always)]
    fn members<const D: usize>(
        &self,
        end: &[S::Lanes; D],
        lane: usize,
    ) -> ([S::Lanes; D], S::Mask) {
        let mut reference = *end;
        let mut apart = self.simd.splat(0.0);
        for (axis, place) in reference.iter_mut().enumerate() {
            *place = self.load(axis, lane);
            let away = *place - end[axis];
            apart = apart + away * away;
        }
        (reference, self.reach.above(apart))
    }

    #[inline(always)]
    fn near<const D: usize>(&self, end: &[S::Lanes; D], lanes: usize) -> Near<D> {
        let zero = self.simd.splat(0.0);
        let (mut shape, mut pulled, mut volumes) = ([[zero; D]; D], [[zero; D]; D], zero);
        for lane in (0..lanes).step_by(S::WIDTH) {
            let (reference, mask) = self.members(end, lane);
            let weight = self.load(2 * D, lane).only(mask);
            volumes = volumes + self.load(2 * D + 1, lane).only(mask);
            for row in 0..D {
                let place = weight * reference[row];
                let moved = weight * self.load(D + row, lane);
                for column in 0..D {
                    if column <= row {
                        shape[row][column] = place.mul_add(reference[column], shape[row][column]);
                    }
                    pulled[row][column] = moved.mul_add(reference[column], pulled[row][column]);
                }
            }
        }
        let mut near = Near { shape: [[0.0; D]; D], moved: [[0.0; D]; D], volume: volumes.total() };
        for row in 0..D {
            for column in 0..D {
                near.moved[row][column] = pulled[row][column].total();
                near.shape[row][column] = shape[row.max(column)][row.min(column)].total();
            }
        }
        near
    }

    #[inline(always)]
    fn add<const D: usize>(
        &self,
        end: &[S::Lanes; D],
        tensor: &[[f64; D]; D],
        lanes: usize,
        sums: &mut [f64],
    ) {
        for lane in (0..lanes).step_by(S::WIDTH) {
            let (reference, mask) = self.members(end, lane);
            for row in 0..D {
                let mut pull = self.simd.splat(0.0);
                for column in 0..D {
                    pull = self.simd.splat(tensor[row][column]).mul_add(reference[column], pull);
                }
                let sum = &mut sums[row * self.stride + lane..];
                (self.simd.load(sum) + pull.only(mask)).store(sum);
            }
        }
    }
}
