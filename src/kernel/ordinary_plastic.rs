//! The sweeps of the linear peridynamic solid that flows, over blocks of bonds (Mitchell 2011): what each end of a bond
//! remembers and pulls, and the forces of bonds that pull along themselves.

use std::ops::Range;

use super::family::Family;
use super::fields::both_ends;
use super::simd::{Kernel, Lanes, Simd};
use crate::families::LANES;

/// p and x of a block of bonds.
pub(crate) type Extensions = [[f64; LANES]; 2];

/// What the bonds of a point have come to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sums {
    /// 1/m, 0 without a family.
    pub(crate) inverse: f64,
    pub(crate) theta: f64,
    /// sum w x^2 V
    pub(crate) squares: f64,
}

/// Makes the extensions of a range from the committed ones.
pub(crate) struct Return<'a, W, M, Y, F, const D: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    /// Points that are not wanted keep what they have.
    pub(crate) wanted: W,
    /// Extensions of all blocks.
    pub(crate) old: &'a [Extensions],
    pub(crate) new: &'a mut [Extensions],
    /// |t_ij|/L of each lane, if that is wanted, of D kappa and C.
    pub(crate) pulls: Option<&'a mut [f64]>,
    pub(crate) moduli: M,
    /// What is left of x where a point flows, from its sums as if nothing did.
    pub(crate) left: Y,
    /// Takes the sums of a wanted point, and where it has flowed what was left of x, and sum w x dp V over the step.
    pub(crate) finish: F,
}

impl<W, M, Y, F, const D: usize> Kernel for Return<'_, W, M, Y, F, D>
where
    W: Fn(usize) -> bool,
    M: Fn(usize) -> [f64; 2],
    Y: Fn(usize, Sums) -> Option<f64>,
    F: FnMut(usize, Sums, Option<[f64; 2]>),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, range, wanted, old, new, mut pulls, moduli, left, mut finish } = self;
        let (start, _) = family.slots(range.start);
        for point in range {
            let (from, to) = family.slots(point);
            let old = &old[from / LANES..to / LANES];
            let new = &mut new[(from - start) / LANES..(to - start) / LANES];
            if !wanted(point) {
                new.copy_from_slice(old);
                continue;
            }
            let mut pulls = pulls.as_mut().map(|pulls| &mut pulls[from - start..to - start]);
            let moduli = moduli(point);
            // Twice where it flows: asked again at this displacement, it answers with the same bits.
            let mut share = None;
            loop {
                let ([inverse, theta], product) =
                    elastic::<S, D>(simd, &family, (point, share), old, new);
                let [kappa, stiffness] = moduli;
                let pull = [inverse * theta * kappa, inverse * stiffness];
                let pulls = pulls.as_deref_mut();
                let squares = deviate::<S, D>(simd, &family, (point, theta), new, (pull, pulls));
                let sums = Sums { inverse, theta, squares };
                if share.is_none() {
                    share = left(point, sums);
                    if share.is_some() {
                        continue;
                    }
                }
                finish(point, sums, share.map(|left| [left, product]));
                break;
            }
        }
    }
}

/// Sets x of a point's bonds to e - p, and both to 0 where there is none; p is as it was, or with a share of x that is left
/// in flow the rest of x comes to it. Gives 1/m and theta, and sum w x dp V.
#[inline(always)]
fn elastic<S: Simd, const D: usize>(
    simd: S,
    family: &Family<'_>,
    (point, left): (usize, Option<f64>),
    old: &[Extensions],
    new: &mut [Extensions],
) -> ([f64; 2], f64) {
    let own = family.own(simd, point);
    let zero = simd.splat(0.0);
    let (mut weighted, mut sum, mut product) = (zero, zero, zero);
    let (start, end) = family.slots(point);
    for slot in (start..end).step_by(S::WIDTH) {
        let (block, lane) = ((slot - start) / LANES, slot % LANES);
        let [plastic_before, elastic_before] = &old[block];
        let [plastic, elastic] = &mut new[block];
        let bonds = family.bonds::<S, D>(simd, &own, slot);
        let lengths = bonds.lengths(simd);
        let mask = simd.mask(family.bits(slot));
        let at = lengths.stretches(simd, family, slot);
        let inverse = family.inverse_lengths(simd, slot, &bonds.reference);
        let length = lengths.squared * inverse;
        let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume);
        let mut kept = simd.load(&plastic_before[lane..]);
        if let Some(left) = left {
            let x = simd.load(&elastic[lane..]);
            let flowed = simd.splat(1.0 - left) * x;
            kept = kept + flowed;
            // By the trapezoid, as all work.
            let before = simd.load(&elastic_before[lane..]);
            let mean = simd.splat(0.5) * simd.splat(left).mul_add(x, before);
            product = product + (weight * mean * flowed).only(mask);
        }
        // A broken bond is forgotten.
        kept = kept.only(mask);
        let rest = length.mul_add(at.stretch, zero - kept).only(mask);
        kept.store(&mut plastic[lane..]);
        rest.store(&mut elastic[lane..]);
        weighted = weighted + (weight * lengths.squared).only(mask);
        sum = sum + (weight * length * rest).only(mask);
    }
    let weighted = weighted.total();
    let inverse = if weighted > 0.0 { 1.0 / weighted } else { 0.0 };
    ([inverse, D as f64 * inverse * sum.total()], product.total())
}

/// Takes theta L/D off x; gives sum w x^2 V, and w (a + b x/L) of `pull` where there is room for it.
#[inline(always)]
fn deviate<S: Simd, const D: usize>(
    simd: S,
    family: &Family<'_>,
    (point, theta): (usize, f64),
    extensions: &mut [Extensions],
    (pull, mut pulls): ([f64; 2], Option<&mut [f64]>),
) -> f64 {
    let own = family.own(simd, point);
    let mut squares = simd.splat(0.0);
    let [swollen, a, b] = [-theta / D as f64, pull[0], pull[1]].map(|number| simd.splat(number));
    let (start, end) = family.slots(point);
    for slot in (start..end).step_by(S::WIDTH) {
        let [_, elastic] = &mut extensions[(slot - start) / LANES];
        let elastic = &mut elastic[slot % LANES..];
        let AtRest { inverse, length, weight, volume } =
            AtRest::of::<S, D>(simd, family, &own, slot);
        let mask = simd.mask(family.bits(slot));
        let x = length.mul_add(swollen, simd.load(elastic)).only(mask);
        x.store(elastic);
        squares = squares + (weight * volume * x * x).only(mask);
        if let Some(pulls) = &mut pulls {
            let pull = weight * (x * inverse).mul_add(b, a);
            pull.only(mask).store(&mut pulls[slot - start..]);
        }
    }
    squares.total()
}

/// Bonds as they were, which are all masked where there is none.
struct AtRest<F> {
    /// 1/L
    inverse: F,
    length: F,
    weight: F,
    volume: F,
}

impl<F: Lanes> AtRest<F> {
    #[inline(always)]
    fn of<S: Simd<Lanes = F>, const D: usize>(
        simd: S,
        family: &Family<'_>,
        own: &[F; 8],
        slot: usize,
    ) -> Self {
        let (reference, volume) = family.references::<S, D>(simd, own, slot);
        let mut squared = reference[0] * reference[0];
        for x in &reference[1..] {
            squared = x.mul_add(*x, squared);
        }
        let inverse = family.inverse_lengths(simd, slot, &reference);
        let weight = family.weighted(simd, slot, &reference, simd.splat(1.0));
        Self { inverse, length: squared * inverse, weight, volume }
    }
}

/// Forces of bonds that pull along themselves. Gives the first point whose force is not finite.
pub(crate) struct PullAlong<'a, const D: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    /// |t_ij|/L of each lane, and the lane at the other end of each bond.
    pub(crate) pulls: &'a [f64],
    pub(crate) backs: &'a [u32],
    pub(crate) force: &'a mut [f64],
}

impl<const D: usize> Kernel for PullAlong<'_, D> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { family, range, pulls, backs, force } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let own = family.own(simd, point);
            let mut sum = [simd.splat(0.0); D];
            let (start, end) = family.slots(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let at = bonds.lengths(simd).stretches(simd, &family, slot);
                let both = both_ends(simd, pulls, backs, family.lane(slot));
                let pull = (both * bonds.volume * at.shrunk).only(simd.mask(family.bits(slot)));
                let deformed = bonds.deformed();
                for axis in 0..D {
                    sum[axis] = pull.mul_add(deformed[axis], sum[axis]);
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
