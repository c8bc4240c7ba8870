//! Bond-based sweeps: forces with or without breaking, and the energy of the bonds. [P 3.8-3.11]
//!
//! With xi the bond's reference vector, y = xi + u_j - u_i, L = |xi| and l = |y|, the stretch is
//! s = (l - L)/L = du.(xi + y) / (L (L + l)): exactly zero where the ends move alike, and without
//! the cancellation of l - L. The force on i is the sum of c d s V_j y/l.

use std::ops::Range;

use crate::damage::{BondsView, BreakRule};
use crate::families::{Families, LANES, Place};

/// What every bond-based sweep reads.
#[derive(Clone, Copy)]
pub(crate) struct Cloud<'a> {
    pub(crate) places: &'a [Place],
    pub(crate) families: &'a Families,
    /// `D` numbers a point.
    pub(crate) displacement: &'a [f64],
    pub(crate) bonds: BondsView<'a>,
}

/// How stiff bonds are and when they break, for one scene.
pub(crate) trait BondLaw: Copy {
    /// Bond constant times integrity that acts between both ends.
    fn stiffness(&self, slot: usize, point: usize, neighbor: usize, length: f64) -> f64;
    /// Bond constant times integrity of the point's own material; 0 outside its own horizon.
    fn own_stiffness(&self, slot: usize, point: usize, length: f64) -> f64;
    /// Stretch beyond which a bond breaks.
    fn threshold(&self, slot: usize, point: usize, neighbor: usize) -> f64;
    /// Lanes of a block that may break.
    fn breakable(&self, block: usize) -> u8;
}

/// The deformed bonds of one block.
struct Deformed<const D: usize> {
    bond: [[f64; LANES]; D],
    volume: [f64; LANES],
    neighbor: [usize; LANES],
    /// s/l, 0 where the ends coincide and a direction is not defined.
    stretch_by_length: [f64; LANES],
    stretch: [f64; LANES],
}

impl<'a> Cloud<'a> {
    #[inline(always)]
    fn deform<const D: usize>(
        &self,
        block: usize,
        own: &Place,
        own_shift: &[f64; D],
    ) -> Deformed<D> {
        let (shifts, _) = self.displacement.as_chunks::<D>();
        let slots = block * LANES..(block + 1) * LANES;
        let neighbors = &self.families.neighbors[slots.clone()];
        let lengths = &self.families.lengths[slots];
        let mut reference = [[0.0; LANES]; D];
        let mut shift = [[0.0; LANES]; D];
        let mut out = Deformed {
            bond: [[0.0; LANES]; D],
            volume: [0.0; LANES],
            neighbor: [0; LANES],
            stretch_by_length: [0.0; LANES],
            stretch: [0.0; LANES],
        };
        for lane in 0..LANES {
            let neighbor = neighbors[lane] as usize;
            let (place, moved) = (&self.places[neighbor], &shifts[neighbor]);
            for axis in 0..D {
                reference[axis][lane] = place[axis] - own[axis];
                shift[axis][lane] = moved[axis] - own_shift[axis];
            }
            out.volume[lane] = place[3];
            out.neighbor[lane] = neighbor;
        }
        for lane in 0..LANES {
            let (mut squared, mut change) = (0.0, 0.0);
            for axis in 0..D {
                let y = reference[axis][lane] + shift[axis][lane];
                change += shift[axis][lane] * (reference[axis][lane] + y);
                squared += y * y;
                out.bond[axis][lane] = y;
            }
            let (length, now) = (lengths[lane], squared.sqrt());
            let product = length * (length + now);
            let scale = product * now;
            let quotient = change / scale;
            let by_length = if scale > 0.0 { quotient } else { 0.0 };
            out.stretch_by_length[lane] = by_length;
            out.stretch[lane] = if scale > 0.0 { by_length * now } else { -1.0 };
        }
        out
    }

    /// Forces per volume on the points of `range`; with `breaking`, bonds beyond their threshold
    /// break first: the new masks, and the energy per volume that each point loses by it.
    /// Gives the first point whose force is not finite.
    #[inline(always)]
    pub(crate) fn force<const D: usize>(
        &self,
        law: impl BondLaw,
        range: Range<usize>,
        force: &mut [f64],
        mut breaking: Option<(&mut [u8], &mut [f64])>,
    ) -> Option<usize> {
        let (shifts, _) = self.displacement.as_chunks::<D>();
        let (forces, _) = force.as_chunks_mut::<D>();
        let first_block = self.families.offsets[range.start] as usize;
        let mut bad = None;
        for (place, point) in range.clone().enumerate() {
            let own = &self.places[point];
            let mut sum = [[0.0; LANES]; D];
            for block in self.families.blocks(point) {
                let mut mask = self.bonds.intact[block];
                if mask == 0 {
                    if let Some((masks, _)) = &mut breaking {
                        masks[block - first_block] = 0;
                    }
                    continue;
                }
                let deformed = self.deform::<D>(block, own, &shifts[point]);
                if let Some((masks, dissipated)) = &mut breaking {
                    let beyond = self.beyond(law, block, point, &deformed) & mask;
                    if beyond != 0 {
                        mask &= !beyond;
                        dissipated[place] += self.lost(law, block, point, &deformed, beyond);
                    }
                    masks[block - first_block] = mask;
                }
                let mut weight = [0.0; LANES];
                for lane in 0..LANES {
                    let slot = block * LANES + lane;
                    let length = self.families.lengths[slot];
                    let stiffness = law.stiffness(slot, point, deformed.neighbor[lane], length);
                    weight[lane] =
                        stiffness * deformed.volume[lane] * deformed.stretch_by_length[lane];
                }
                if mask != u8::MAX {
                    for (lane, weight) in weight.iter_mut().enumerate() {
                        if mask >> lane & 1 == 0 {
                            *weight = 0.0;
                        }
                    }
                }
                for axis in 0..D {
                    for lane in 0..LANES {
                        sum[axis][lane] += weight[lane] * deformed.bond[axis][lane];
                    }
                }
            }
            for axis in 0..D {
                forces[place][axis] = total(&sum[axis]);
            }
            if bad.is_none() && !forces[place].iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }

    /// Lanes whose stretch is beyond their threshold and that may break.
    #[inline(always)]
    fn beyond<const D: usize>(
        &self,
        law: impl BondLaw,
        block: usize,
        point: usize,
        deformed: &Deformed<D>,
    ) -> u8 {
        let mut beyond = 0;
        for lane in 0..LANES {
            let threshold = law.threshold(block * LANES + lane, point, deformed.neighbor[lane]);
            beyond |= u8::from(deformed.stretch[lane] > threshold) << lane;
        }
        if beyond == 0 { 0 } else { beyond & law.breakable(block) }
    }

    /// Energy per volume of the point in the given lanes: 1/4 c d s^2 L V_j each.
    #[inline(always)]
    fn lost<const D: usize>(
        &self,
        law: impl BondLaw,
        block: usize,
        point: usize,
        deformed: &Deformed<D>,
        lanes: u8,
    ) -> f64 {
        let mut energy = 0.0;
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let slot = block * LANES + lane;
            let length = self.families.lengths[slot];
            let stretch = deformed.stretch[lane];
            let stiffness = law.own_stiffness(slot, point, length);
            energy += 0.25 * stiffness * stretch * stretch * length * deformed.volume[lane];
        }
        energy
    }

    /// W_i = 1/4 sum c d s^2 L V_j of the points of `range`, over each point's own family.
    #[inline(always)]
    pub(crate) fn energy_density<const D: usize>(
        &self,
        law: impl BondLaw,
        range: Range<usize>,
        density: &mut [f64],
    ) {
        let (shifts, _) = self.displacement.as_chunks::<D>();
        for (value, point) in density.iter_mut().zip(range) {
            *value = 0.0;
            for block in self.families.blocks(point) {
                let mask = self.bonds.intact[block];
                if mask != 0 {
                    let deformed = self.deform::<D>(block, &self.places[point], &shifts[point]);
                    *value += self.lost(law, block, point, &deformed, mask);
                }
            }
        }
    }
}

/// The lanes added up, always in the same order.
#[inline(always)]
fn total(lanes: &[f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// All bonds alike: one material, one horizon, no integrity set by hand.
#[derive(Clone, Copy)]
pub(crate) struct Alike<'a> {
    pub(crate) bond_constant: f64,
    pub(crate) critical: f64,
    pub(crate) rule: Option<&'a BreakRule>,
}

impl BondLaw for Alike<'_> {
    #[inline(always)]
    fn stiffness(&self, _: usize, _: usize, _: usize, _: f64) -> f64 {
        self.bond_constant
    }
    #[inline(always)]
    fn own_stiffness(&self, _: usize, _: usize, _: f64) -> f64 {
        self.bond_constant
    }
    #[inline(always)]
    fn threshold(&self, _: usize, _: usize, _: usize) -> f64 {
        self.critical
    }
    #[inline(always)]
    fn breakable(&self, block: usize) -> u8 {
        self.rule.map_or(0, |rule| rule.breakable(block))
    }
}

/// Bonds that differ by their ends or one by one.
#[derive(Clone, Copy)]
pub(crate) struct Various<'a> {
    pub(crate) bond_constants: &'a crate::families::Property,
    pub(crate) families: &'a Families,
    pub(crate) integrity: Option<&'a [f64]>,
    pub(crate) rule: Option<&'a BreakRule>,
}

impl Various<'_> {
    #[inline(always)]
    fn of(&self, point: usize, length: f64) -> f64 {
        if self.families.owns(point, length) { self.bond_constants.at(point) } else { 0.0 }
    }

    #[inline(always)]
    fn integrity(&self, slot: usize) -> f64 {
        self.integrity.map_or(1.0, |values| values[slot])
    }
}

impl BondLaw for Various<'_> {
    #[inline(always)]
    fn stiffness(&self, slot: usize, point: usize, neighbor: usize, length: f64) -> f64 {
        0.5 * (self.of(point, length) + self.of(neighbor, length)) * self.integrity(slot)
    }
    #[inline(always)]
    fn own_stiffness(&self, slot: usize, point: usize, length: f64) -> f64 {
        self.of(point, length) * self.integrity(slot)
    }
    #[inline(always)]
    fn threshold(&self, slot: usize, point: usize, neighbor: usize) -> f64 {
        self.rule.map_or(f64::INFINITY, |rule| rule.threshold(slot, point, neighbor))
    }
    #[inline(always)]
    fn breakable(&self, block: usize) -> u8 {
        self.rule.map_or(0, |rule| rule.breakable(block))
    }
}
