//! How stiff the bonds of bond_based are, and when they break: all alike, or one by one.

use super::Scene;
use super::breaking::stretch;
use super::surface::Correction;
use crate::damage::{BreakRule, close_to};
use crate::families::{Bond, Families, LANES, Property};
use crate::kernel::bond_based::{BondLaw, Part};
use crate::kernel::lattice::Judge;
use crate::kernel::simd::{Lanes, Simd};

/// All bonds alike: one material, one horizon, no integrity set by hand.
#[derive(Clone, Copy)]
pub(super) struct Alike<'a> {
    pub(super) bond_constant: f64,
    pub(super) critical: f64,
    pub(super) limits: Limits<'a>,
}

/// Bonds that differ by their ends or one by one.
#[derive(Clone, Copy)]
pub(super) struct Various<'a> {
    /// What all have in common.
    pub(super) common: Common,
    pub(super) bond_constants: &'a Property,
    pub(super) families: &'a Families,
    pub(super) integrity: Option<&'a [f64]>,
    /// By how much bonds near a surface are stiffer.
    pub(super) correction: Option<&'a Correction>,
    pub(super) limits: Limits<'a>,
}

/// What bonds that differ have in common nevertheless.
#[derive(Clone, Copy)]
pub(super) struct Common {
    /// The bond constant but for integrity and correction.
    pub(super) bond_constant: Option<f64>,
    /// The stretch at which they break.
    pub(super) critical: Option<f64>,
}

/// Which bonds break at a displacement. Kernels ask of those that come close to their limit: what they compute
/// themselves depends on the kernel, and both ends of a bond shall come to the same.
#[derive(Clone, Copy)]
pub(super) struct Limits<'a> {
    pub(super) scene: &'a Scene<'a>,
    /// `None` where none is to break.
    pub(super) rule: Option<&'a BreakRule>,
}

impl Limits<'_> {
    /// Whether a bond is to break, be it broken already or not.
    pub(super) fn breaks_bond(&self, point: usize, bond: Bond) -> bool {
        let Self { scene, rule: Some(rule) } = self else { return false };
        let bit = 1 << (bond.slot % LANES);
        rule.breakable(bond.slot / LANES) & bit != 0
            && stretch(scene, point, bond.neighbor, bond.length)
                > rule.threshold(bond.slot, point, bond.neighbor)
    }
}

impl Judge for Limits<'_> {
    fn breaks(&self, point: usize, step: usize) -> bool {
        let bond = self.scene.families.bond_along(point, step);
        bond.is_some_and(|bond| self.breaks_bond(point, bond))
    }
}

impl BondLaw for Alike<'_> {
    #[inline(always)]
    fn factor(&self) -> f64 {
        self.bond_constant
    }
    #[inline(always)]
    fn weight<S: Simd, const BOTH: bool>(
        &self,
        _: S,
        _: &Part<'_>,
        inverse: S::Lanes,
        volume: S::Lanes,
    ) -> S::Lanes {
        inverse * volume
    }
    #[inline(always)]
    fn count<S: Simd>(&self, _: S, _: &Part<'_>, _: S::Lanes, volume: S::Lanes) -> S::Lanes {
        volume
    }
    #[inline(always)]
    fn threshold<S: Simd>(&self, simd: S, _: &Part<'_>) -> S::Lanes {
        simd.splat(close_to(self.critical))
    }
    fn breaks(&self, point: usize, bond: Bond) -> bool {
        self.limits.breaks_bond(point, bond)
    }
}

impl Various<'_> {
    #[inline(always)]
    fn constant(&self, point: usize, neighbor: usize, length: f64) -> f64 {
        self.families.reach.share(point, neighbor, length) * self.bond_constants.at(point)
    }

    /// Integrity of a bond, and with it what the surface adds, to the constants of both its ends.
    #[inline(always)]
    fn integrity(&self, slot: usize) -> [f64; 2] {
        let factors = self.correction.map_or([1.0; 2], |factors| factors.at(slot));
        let integrity = self.integrity.map_or(1.0, |values| values[slot]);
        factors.map(|factor| factor * integrity)
    }

    /// Bond constant times integrity that acts between both ends of one bond.
    pub(super) fn stiffness(&self, point: usize, bond: Bond) -> f64 {
        let Bond { slot, neighbor, length } = bond;
        let (own, other) =
            (self.constant(point, neighbor, length), self.constant(neighbor, point, length));
        let [of_own, of_other] = self.integrity(slot);
        0.5 * (own * of_own + other * of_other)
    }

    /// Bond constant of the point's own material, whatever the bond's integrity; less in the rim of its
    /// horizon, 0 outside.
    pub(super) fn own_constant(&self, point: usize, bond: Bond) -> f64 {
        self.constant(point, bond.neighbor, bond.length)
    }

    /// Whether a neighbour counts with all of its volume, at both ends.
    fn is_sharp(&self) -> bool {
        self.families.reach.is_sharp_and_uniform()
    }

    /// Bond constants times integrities, the mean of `BOTH` ends or those of the point; `each`: of bonds that are to be asked
    /// one by one.
    #[inline(always)]
    fn stiffnesses<S: Simd, const BOTH: bool>(
        &self,
        simd: S,
        part: &Part<'_>,
        inverse: S::Lanes,
        each: impl Fn(Bond) -> f64,
    ) -> S::Lanes {
        let constant_of = |point: u32| self.bond_constants.at(point as usize);
        let mut stiffness = match self.common.bond_constant {
            Some(constant) => simd.splat(constant),
            None if self.is_sharp() && self.correction.is_none() => {
                let own = simd.splat(constant_of(part.point as u32));
                if BOTH {
                    let others = simd.each(|lane| constant_of(part.neighbors[lane]));
                    simd.splat(0.5) * (own + others)
                } else {
                    own
                }
            }
            None => return one_by_one(simd, part, inverse, each),
        };
        if let Some(correction) = self.correction {
            let mut factor = simd.load(&correction.own[part.slot..]);
            if BOTH && !correction.is_shared() {
                factor = simd.splat(0.5) * (factor + simd.load(&correction.other[part.slot..]));
            }
            stiffness = stiffness * factor;
        }
        if let Some(integrity) = self.integrity {
            stiffness = stiffness * simd.load(&integrity[part.slot..]);
        }
        stiffness
    }

    /// Energy per volume that a point has in a bond: 1/4 c d s r L V_j at the stretches s and r.
    pub(super) fn energy(
        &self,
        scene: &Scene<'_>,
        point: usize,
        bond: Bond,
        stretches: [f64; 2],
    ) -> f64 {
        let stiffness = self.own_constant(point, bond) * self.integrity(bond.slot)[0];
        let [now, pulled] = stretches;
        0.25 * stiffness * now * scene.places[bond.neighbor][3] * pulled * bond.length
    }

    /// Energy per volume that the point loses by the bonds that are not in the masks `remaining` of its blocks any
    /// more: with the stretch at which the bond pulled last, where it pulled; as it is where nothing was before.
    pub(super) fn lost(
        &self,
        scene: &Scene<'_>,
        point: usize,
        remaining: &[u8],
        before: Option<&[f64]>,
    ) -> f64 {
        let first = scene.families.blocks(point).start;
        let broken = |block: usize| scene.bonds.intact[block] & !remaining[block - first];
        let each = scene.families.bonds_in(point, broken).map(|bond| {
            let stretch = |displacement| {
                let scene = Scene { displacement, ..*scene };
                stretch(&scene, point, bond.neighbor, bond.length)
            };
            let now = stretch(scene.displacement);
            let pulled = before.map_or(now, |before| stretch(before).max(0.0));
            self.energy(scene, point, bond, [now, pulled])
        });
        each.sum()
    }
}

/// What `each` gives of bonds with these inverse lengths.
#[inline(always)]
fn one_by_one<S: Simd>(
    simd: S,
    part: &Part<'_>,
    inverse: S::Lanes,
    each: impl Fn(Bond) -> f64,
) -> S::Lanes {
    let mut inverses = [1.0; LANES];
    inverse.store(&mut inverses);
    simd.each(|lane| {
        let neighbor = part.neighbors[lane] as usize;
        each(Bond { slot: part.slot + lane, neighbor, length: inverses[lane].recip() })
    })
}

impl BondLaw for Various<'_> {
    #[inline(always)]
    fn factor(&self) -> f64 {
        1.0
    }
    #[inline(always)]
    fn weight<S: Simd, const BOTH: bool>(
        &self,
        simd: S,
        part: &Part<'_>,
        inverse: S::Lanes,
        volume: S::Lanes,
    ) -> S::Lanes {
        let each = |bond| match BOTH {
            true => self.stiffness(part.point, bond),
            false => self.own_constant(part.point, bond) * self.integrity(bond.slot)[0],
        };
        let stiffness = self.stiffnesses::<S, BOTH>(simd, part, inverse, each);
        inverse * volume * stiffness
    }
    #[inline(always)]
    fn count<S: Simd>(
        &self,
        simd: S,
        part: &Part<'_>,
        inverse: S::Lanes,
        volume: S::Lanes,
    ) -> S::Lanes {
        let share = |bond: Bond| self.families.reach.share(part.point, bond.neighbor, bond.length);
        let count = match self.is_sharp() {
            true => volume,
            false => volume * one_by_one(simd, part, inverse, share),
        };
        match self.integrity {
            Some(integrity) => count * simd.load(&integrity[part.slot..]),
            None => count,
        }
    }
    #[inline(always)]
    fn threshold<S: Simd>(&self, simd: S, part: &Part<'_>) -> S::Lanes {
        let Some(rule) = self.limits.rule else { return simd.splat(f64::INFINITY) };
        if let Some(critical) = self.common.critical {
            return simd.splat(close_to(critical));
        }
        simd.each(|lane| {
            let neighbor = part.neighbors[lane] as usize;
            close_to(rule.threshold(part.slot + lane, part.point, neighbor))
        })
    }
    fn breaks(&self, point: usize, bond: Bond) -> bool {
        self.limits.breaks_bond(point, bond)
    }
}
