//! The sweeps of the linear peridynamic solid over blocks of bonds. [P 3.14-3.20]
//!
//! With s = l/L - 1, a = C/m and b = theta/m (D kappa - C/D), both ends of a bond pull with w (a s + b) L, so that the
//! force on i is sum w V_j L/l (a_i s + b_i) y + sum w V_j L/l (a_j s + b_j) y. The sums of the first part need nothing of
//! the neighbours: the first sweep makes them with m_i and theta_i, and leaves a_j V_j and b_j V_j for the second.

use std::ops::Range;

use super::family::{BreakHere, Family, Record};
use super::simd::{Kernel, Lanes, Simd};

/// The first sweep: what the ends of bonds pull at their own points, and records with a V and b V for the second.
pub(crate) struct OwnPull<'a, M, const D: usize> {
    pub(crate) family: Family<'a>,
    /// kappa and C of a point.
    pub(crate) moduli: M,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    pub(crate) left: &'a mut [Record],
    pub(crate) breaking: Option<BreakHere<'a>>,
}

impl<M: Fn(usize) -> [f64; 2], const D: usize> Kernel for OwnPull<'_, M, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, moduli, range, force, left, mut breaking } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        for ((force, left), point) in forces.iter_mut().zip(left).zip(range) {
            let zero = simd.splat(0.0);
            let own = family.own(simd, point);
            let (mut weighted, mut sum) = (zero, zero);
            let (mut shear, mut dilated) = ([zero; D], [zero; D]);
            let (start, end) = family.slots(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let lengths = bonds.lengths(simd);
                let mut bits = family.bits(slot);
                if let Some(breaking) = &mut breaking {
                    breaking.at(simd, &family, (point, slot), &lengths, &mut bits);
                }
                let mask = simd.mask(bits);
                let at = lengths.stretches(simd);
                let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume);
                let moment = (weight * lengths.squared).only(mask);
                weighted = weighted + moment;
                sum = sum + (moment * at.stretch).only(mask);
                let dilating = (weight * at.shrunk).only(mask);
                let shearing = (dilating * at.stretch).only(mask);
                let deformed = bonds.deformed();
                for axis in 0..D {
                    shear[axis] = shearing.mul_add(deformed[axis], shear[axis]);
                    dilated[axis] = dilating.mul_add(deformed[axis], dilated[axis]);
                }
            }
            let weighted = weighted.total();
            let inverse = if weighted > 0.0 { 1.0 / weighted } else { 0.0 };
            let dimension = D as f64;
            let theta = dimension * inverse * sum.total();
            let [kappa, deviatoric] = moduli(point);
            let a = inverse * deviatoric;
            let b = inverse * theta * (dimension * kappa - deviatoric / dimension);
            for axis in 0..D {
                force[axis] = a * shear[axis].total() + b * dilated[axis].total();
            }
            *left = *family.record(point);
            left[7] = b * left[3];
            left[3] *= a;
        }
    }
}

/// The second sweep: adds what the other ends of bonds pull. Gives the first point whose force is not finite.
pub(crate) struct OtherPull<'a, const D: usize> {
    /// With the records that the first sweep has left.
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
}

impl<const D: usize> Kernel for OtherPull<'_, D> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { family, range, force } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let own = family.own(simd, point);
            let mut sum = [simd.splat(0.0); D];
            let (start, end) = family.slots(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let at = bonds.lengths(simd).stretches(simd);
                let tension = at.stretch.mul_add(bonds.volume, bonds.last);
                let pull = family.weighted(simd, slot, &bonds.reference, tension) * at.shrunk;
                let pull = pull.only(simd.mask(family.bits(slot)));
                let deformed = bonds.deformed();
                for axis in 0..D {
                    sum[axis] = pull.mul_add(deformed[axis], sum[axis]);
                }
            }
            for axis in 0..D {
                force[axis] += sum[axis].total();
            }
            if bad.is_none() && !force.iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }
}
