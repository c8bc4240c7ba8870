//! Bond-based sweeps: forces with or without breaking, and the energy of the bonds. [P 3.8-3.11]
//!
//! With xi the bond's reference vector, y = xi + u_j - u_i, L = |xi| and l = |y|, the stretch is
//! s = (l - L)/L = du.(xi + y) / (L (L + l)): exactly zero where the ends move alike, and without
//! the cancellation of l - L. The force on i is the sum of c d s V_j y/l.

use std::ops::Range;

use super::lanes::{Lanes, WIDTH};
use crate::damage::{BondsView, BreakRule};
use crate::families::{Bond, Families, LANES, Place, Property};

/// What every bond-based sweep reads.
#[derive(Clone, Copy)]
pub(crate) struct Cloud<'a> {
    pub(crate) places: &'a [Place],
    pub(crate) families: &'a Families,
    /// `D` numbers a point.
    pub(crate) displacement: &'a [f64],
    pub(crate) bonds: BondsView<'a>,
}

/// [`WIDTH`] bonds of a point that are computed together.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    point: usize,
    /// Where the first of them stands among all lanes.
    slot: usize,
    neighbors: &'a [u32; WIDTH],
    lengths: &'a [f64; WIDTH],
}

impl Part<'_> {
    fn bond(&self, lane: usize) -> Bond {
        Bond {
            slot: self.slot + lane,
            neighbor: self.neighbors[lane] as usize,
            length: self.lengths[lane],
        }
    }

    /// What a block's mask says of these lanes.
    #[inline(always)]
    fn bits(&self, mask: u8) -> u8 {
        mask >> (self.slot % LANES) & ALL_BITS
    }

    /// Bits of these lanes as a block's mask has them.
    #[inline(always)]
    fn in_block(&self, bits: u8) -> u8 {
        bits << (self.slot % LANES)
    }
}

const ALL_BITS: u8 = (1 << WIDTH) - 1;

/// How stiff bonds are and when they break, for one scene.
pub(crate) trait BondLaw: Copy {
    /// Bond constant times integrity that acts between both ends.
    fn stiffness(&self, part: &Part<'_>) -> Lanes;
    /// Bond constant times integrity of the point's own material; 0 outside its own horizon.
    fn own_stiffness(&self, part: &Part<'_>) -> Lanes;
    /// Stretch beyond which a bond breaks.
    fn threshold(&self, part: &Part<'_>) -> Lanes;
    /// Lanes of a block that may break.
    fn breakable(&self, block: usize) -> u8;
}

/// Deformed bonds.
struct Deformed<const D: usize> {
    bond: [Lanes; D],
    volume: Lanes,
    /// s/l, 0 where the ends coincide and a direction is not defined.
    stretch_by_length: Lanes,
    /// Length now.
    now: Lanes,
    /// s L (L + l).
    change: Lanes,
    /// L (L + l).
    product: Lanes,
}

impl<const D: usize> Deformed<D> {
    #[inline(always)]
    fn stretch(&self) -> Lanes {
        self.change / self.product
    }
}

/// What a sweep over a range of points writes as it breaks bonds.
pub(crate) struct BlockBreaking<'a> {
    /// Masks of the range's blocks after breaking.
    pub(crate) intact: &'a mut [u8],
    /// Energy per volume that each point of the range has lost; added to.
    pub(crate) dissipated: &'a mut [f64],
    /// Displacement of all points at the beginning of the step, where there is one.
    pub(crate) before: Option<&'a [f64]>,
}

impl<'a> Cloud<'a> {
    /// The parts of a block.
    #[inline(always)]
    fn parts(&self, block: usize, point: usize) -> impl Iterator<Item = Part<'a>> {
        let (first, end) = (block * LANES, (block + 1) * LANES);
        let (neighbors, _) = self.families.neighbors[first..end].as_chunks::<WIDTH>();
        let (lengths, _) = self.families.lengths[first..end].as_chunks::<WIDTH>();
        let each = neighbors.iter().zip(lengths).enumerate();
        each.map(move |(number, (neighbors, lengths))| Part {
            point,
            slot: first + number * WIDTH,
            neighbors,
            lengths,
        })
    }

    #[inline(always)]
    fn deform<const D: usize>(&self, part: &Part<'_>) -> Deformed<D> {
        let (shifts, _) = self.displacement.as_chunks::<D>();
        let (own, own_shift) = (&self.places[part.point], &shifts[part.point]);
        // SAFETY: the search makes neighbours of points of the body alone, and whoever makes a cloud
        // has seen that the displacement has as many points as there are places.
        let places = part.neighbors.map(|j| unsafe { self.places.get_unchecked(j as usize) });
        // SAFETY: as above.
        let moved = part.neighbors.map(|j| unsafe { shifts.get_unchecked(j as usize) });
        let zero = Lanes::splat(0.0);
        let (mut squared, mut change, mut bond) = (zero, zero, [zero; D]);
        for (axis, y) in bond.iter_mut().enumerate() {
            let reference = Lanes::from_fn(|k| places[k][axis]) - Lanes::splat(own[axis]);
            let shift = Lanes::from_fn(|k| moved[k][axis]) - Lanes::splat(own_shift[axis]);
            *y = reference + shift;
            change = change + shift * (reference + *y);
            squared = squared + *y * *y;
        }
        let (length, now) = (Lanes::load(part.lengths), squared.sqrt());
        let product = length * (length + now);
        let scale = product * now;
        Deformed {
            bond,
            volume: Lanes::from_fn(|k| places[k][3]),
            stretch_by_length: (change / scale).where_positive(scale),
            now,
            change,
            product,
        }
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
        mut breaking: Option<BlockBreaking<'a>>,
    ) -> Option<usize> {
        let (forces, _) = force.as_chunks_mut::<D>();
        let first_block = self.families.offsets[range.start] as usize;
        let mut bad = None;
        for (place, point) in range.enumerate() {
            let mut sum = [Lanes::splat(0.0); D];
            let mut broke = false;
            for block in self.families.blocks(point) {
                let mut mask = self.bonds.intact[block];
                if mask != 0 {
                    for part in self.parts(block, point) {
                        let deformed = self.deform::<D>(&part);
                        let mut intact = part.bits(mask);
                        if breaking.is_some() {
                            let stretch = deformed.stretch_by_length * deformed.now;
                            let beyond = stretch.above(law.threshold(&part)) & intact;
                            if beyond != 0 {
                                let broken = beyond & part.bits(law.breakable(block));
                                intact &= !broken;
                                mask &= !part.in_block(broken);
                                broke |= broken != 0;
                            }
                        }
                        let mut weight =
                            law.stiffness(&part) * deformed.volume * deformed.stretch_by_length;
                        if intact != ALL_BITS {
                            weight = weight.only(intact);
                        }
                        for (sum, bond) in sum.iter_mut().zip(&deformed.bond) {
                            *sum = *sum + weight * *bond;
                        }
                    }
                }
                if let Some(BlockBreaking { intact, .. }) = &mut breaking {
                    intact[block - first_block] = mask;
                }
            }
            if let (true, Some(breaking)) = (broke, &mut breaking) {
                let first = self.families.offsets[point] as usize - first_block;
                let intact = &breaking.intact[first..];
                breaking.dissipated[place] += self.lost::<D>(law, point, intact, breaking.before);
            }
            forces[place] = sum.map(Lanes::total);
            if bad.is_none() && !forces[place].iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }

    /// Energy per volume of the point in the given lanes: 1/4 c d s^2 L V_j each.
    #[inline(always)]
    fn held<const D: usize>(
        &self,
        law: impl BondLaw,
        part: &Part<'_>,
        deformed: &Deformed<D>,
        bits: u8,
    ) -> f64 {
        let stretch = deformed.stretch();
        let force = law.own_stiffness(part) * stretch * deformed.volume;
        0.25 * (force * stretch * Lanes::load(part.lengths)).only(bits).total()
    }

    /// Energy per volume that the point loses by the bonds that are not in the masks `intact` any more:
    /// 1/4 c d s s_before L V_j each, with the stretch at which the bond pulled last, where it pulled;
    /// s_before = s where nothing was before. Bonds break once: this deforms them anew, and leaves the
    /// registers to the sweep.
    #[cold]
    #[inline(never)]
    fn lost<const D: usize>(
        &self,
        law: impl BondLaw,
        point: usize,
        intact: &[u8],
        before: Option<&'a [f64]>,
    ) -> f64 {
        let mut energy = 0.0;
        for (block, intact) in self.families.blocks(point).zip(intact) {
            let broken = self.bonds.intact[block] & !intact;
            for part in self.parts(block, point).filter(|part| part.bits(broken) != 0) {
                let bits = part.bits(broken);
                let deformed = self.deform::<D>(&part);
                let Some(displacement) = before else {
                    energy += self.held(law, &part, &deformed, bits);
                    continue;
                };
                let earlier = Self { displacement, ..*self }.deform::<D>(&part).stretch();
                let pulled = earlier.where_positive(earlier);
                let force = law.own_stiffness(&part) * deformed.stretch() * deformed.volume;
                energy += 0.25 * (force * pulled * Lanes::load(part.lengths)).only(bits).total();
            }
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
        for (value, point) in density.iter_mut().zip(range) {
            *value = 0.0;
            for block in self.families.blocks(point) {
                let mask = self.bonds.intact[block];
                for part in self.parts(block, point).filter(|part| part.bits(mask) != 0) {
                    *value += self.held(law, &part, &self.deform::<D>(&part), part.bits(mask));
                }
            }
        }
    }
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
    fn stiffness(&self, _: &Part<'_>) -> Lanes {
        Lanes::splat(self.bond_constant)
    }
    #[inline(always)]
    fn own_stiffness(&self, _: &Part<'_>) -> Lanes {
        Lanes::splat(self.bond_constant)
    }
    #[inline(always)]
    fn threshold(&self, _: &Part<'_>) -> Lanes {
        Lanes::splat(self.critical)
    }
    #[inline(always)]
    fn breakable(&self, block: usize) -> u8 {
        self.rule.map_or(0, |rule| rule.breakable(block))
    }
}

/// Bonds that differ by their ends or one by one.
#[derive(Clone, Copy)]
pub(crate) struct Various<'a> {
    pub(crate) bond_constants: &'a Property,
    pub(crate) families: &'a Families,
    pub(crate) integrity: Option<&'a [f64]>,
    /// Factor of each lane by which bonds near a surface are stiffer.
    pub(crate) correction: Option<&'a [f64]>,
    pub(crate) rule: Option<&'a BreakRule>,
}

impl Various<'_> {
    #[inline(always)]
    fn constant(&self, point: usize, neighbor: usize, length: f64) -> f64 {
        self.families.reach.share(point, neighbor, length) * self.bond_constants.at(point)
    }

    /// Integrity of a bond, and with it what the surface adds.
    #[inline(always)]
    fn integrity(&self, slot: usize) -> f64 {
        let correction = self.correction.map_or(1.0, |values| values[slot]);
        correction * self.integrity.map_or(1.0, |values| values[slot])
    }

    /// Bond constant times integrity that acts between both ends of one bond.
    pub(crate) fn stiffness_of(&self, point: usize, bond: Bond) -> f64 {
        let Bond { slot, neighbor, length } = bond;
        let (own, other) =
            (self.constant(point, neighbor, length), self.constant(neighbor, point, length));
        let mean = 0.5 * (own + other);
        mean * self.integrity(slot)
    }

    /// Bond constant of the point's own material, whatever the bond's integrity; less in the rim of its
    /// horizon, 0 outside.
    pub(crate) fn own_constant(&self, point: usize, bond: Bond) -> f64 {
        self.constant(point, bond.neighbor, bond.length)
    }
}

impl BondLaw for Various<'_> {
    #[inline(always)]
    fn stiffness(&self, part: &Part<'_>) -> Lanes {
        Lanes::from_fn(|lane| self.stiffness_of(part.point, part.bond(lane)))
    }
    #[inline(always)]
    fn own_stiffness(&self, part: &Part<'_>) -> Lanes {
        Lanes::from_fn(|lane| {
            let bond = part.bond(lane);
            self.own_constant(part.point, bond) * self.integrity(bond.slot)
        })
    }
    #[inline(always)]
    fn threshold(&self, part: &Part<'_>) -> Lanes {
        let Some(rule) = self.rule else { return Lanes::splat(f64::INFINITY) };
        Lanes::from_fn(|lane| {
            let bond = part.bond(lane);
            rule.threshold(bond.slot, part.point, bond.neighbor)
        })
    }
    #[inline(always)]
    fn breakable(&self, block: usize) -> u8 {
        self.rule.map_or(0, |rule| rule.breakable(block))
    }
}

const _: () = assert!(LANES.is_multiple_of(WIDTH), "a block holds whole parts");
