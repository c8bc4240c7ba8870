//! The bond-based sweep over blocks of bonds: forces, and which bonds break. [P 3.8-3.11]
//!
//! With xi the bond's reference vector, y = xi + du, L = |xi| and l = |y|, the force on i is the sum of
//! c d V_j (1/L - 1/l) y = c d V_j/L (1 - L/l) y, and of (l/L)^2 = 1 + z with z = du.(xi + y)/L^2 one root is enough. z is exactly
//! 0 where the ends move alike, and without the cancellation of l^2 - L^2. With the middle m = xi + du/2 of both states,
//! xi + y = 2 m and y = m + du/2. Where lengths are not stored, xi is read instead of m, and L^2 = xi.xi.
//!
//! The latency of a bond is some hundred cycles: while one part's root is taken, the next one's places are fetched.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::fields::{BondSums, Summand};
use super::simd::{Kernel, Lanes, Mask, Simd, prefetch, prefetch_rows};
use crate::families::lattice::NOBODY;
use crate::families::{Bond, Families, LANES};

/// A point in a line of the cache: x + u/2, V, 2 u and a number that does not matter; x instead of x + u/2 where lengths
/// are not stored.
pub(crate) type Record = [f64; 8];

/// What the sweep reads.
#[derive(Clone, Copy)]
pub(crate) struct Cloud<'a> {
    families: &'a Families,
    records: &'a [Record],
    /// One bit a lane.
    intact: &'a [u8],
    /// 1/L of each lane; none where lengths are not stored.
    inverses: &'a [f64],
}

impl<'a> Cloud<'a> {
    /// Panics when there is not a record a point and a mask a block.
    pub(crate) fn new(families: &'a Families, records: &'a [Record], intact: &'a [u8]) -> Self {
        let Families { offsets, neighbors, .. } = families;
        let inverses = families.inverse_lengths.as_deref();
        assert_eq!(records.len() + 1, offsets.len());
        assert_eq!(offsets[records.len()] as usize, intact.len());
        assert_eq!(families.lists().len(), offsets.len());
        assert!(inverses.is_none_or(|inverses| inverses.len() == neighbors.len()));
        Self { families, records, intact, inverses: inverses.unwrap_or_default() }
    }
}

/// Bonds of a point that are computed together.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) point: usize,
    /// Where the first of them stands among all lanes, if there is no lattice beside them.
    pub(crate) slot: usize,
    pub(crate) neighbors: &'a [u32],
}

/// How stiff bonds are and when they break, for one scene.
pub(crate) trait BondLaw: Copy + Sync {
    /// What all forces are multiplied with.
    fn factor(&self) -> f64;
    /// V_j/L of bonds with the inverse lengths and volumes given, each times what else its stiffness has: `BOTH` ends the
    /// mean of theirs, for forces, or the point's own, for its energy.
    fn weight<S: Simd, const BOTH: bool>(
        &self,
        simd: S,
        part: &Part<'_>,
        inverse: S::Lanes,
        volume: S::Lanes,
    ) -> S::Lanes;
    /// V_j times what bonds with these inverse lengths count in the deformation of their point.
    fn count<S: Simd>(
        &self,
        simd: S,
        part: &Part<'_>,
        inverse: S::Lanes,
        volume: S::Lanes,
    ) -> S::Lanes;
    /// (l/L)^2 - 1 beyond which a bond comes close to its limit.
    fn threshold<S: Simd>(&self, simd: S, part: &Part<'_>) -> S::Lanes;
    /// Whether a bond that comes close to its limit breaks.
    fn breaks(&self, point: usize, bond: Bond) -> bool;
}

/// Forces per volume on the points of a range. With `remaining`, which holds the masks of the range's blocks, bonds
/// that break leave it first. `LEAN`: lengths are not read but computed. `STEPS`: members of a lattice are computed, too,
/// and with them lengths; else they are left out. Gives the first point whose force is not finite.
pub(crate) struct ForceSweep<'a, L, const LEAN: bool, const STEPS: bool, const D: usize> {
    pub(crate) cloud: Cloud<'a>,
    pub(crate) law: L,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    /// Where bonds may break.
    pub(crate) remaining: Option<Remaining<'a>>,
    /// Whether points without bonds are left out.
    pub(crate) skips_bare: bool,
}

/// The masks of a range as they are, of which bonds that break are taken, and what is told when any do.
pub(crate) struct Remaining<'a> {
    pub(crate) masks: &'a mut [u8],
    pub(crate) broke: &'a AtomicBool,
}

impl<L: BondLaw, const LEAN: bool, const STEPS: bool, const D: usize> Kernel
    for ForceSweep<'_, L, LEAN, STEPS, D>
{
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { cloud, law, range, force, remaining, skips_bare } = self;
        let pulls = Pulls::<_, _, LEAN, STEPS>::new(simd, cloud, law, skips_bare);
        match remaining {
            Some(_) => pulls.sum_up::<true, D>(range, force, remaining),
            None => pulls.sum_up::<false, D>(range, force, None),
        }
    }
}

/// Energies per volume of the points of a range, 1/4 sum c d s^2 L V_j. Lengths are computed.
pub(crate) struct EnergySweep<'a, L, const STEPS: bool, const D: usize> {
    pub(crate) cloud: Cloud<'a>,
    pub(crate) law: L,
    pub(crate) range: Range<usize>,
    pub(crate) density: &'a mut [f64],
}

impl<L: BondLaw, const STEPS: bool, const D: usize> Kernel for EnergySweep<'_, L, STEPS, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { cloud, law, range, density } = self;
        // Lists have no bonds of members of a lattice, whose blocks are swept here.
        assert!(STEPS || cloud.families.lattice.is_none());
        let pulls = Pulls::<_, _, true, STEPS>::new(simd, cloud, law, false);
        for (density, point) in density.iter_mut().zip(range) {
            *density = 0.25 * law.factor() * pulls.energy::<D>(point);
        }
    }
}

/// Gives sums of which fields are made to `finish`, of the points of a range. Lengths are computed.
pub(crate) struct FieldSweep<'a, L, F, const STEPS: bool, const D: usize> {
    pub(crate) cloud: Cloud<'a>,
    pub(crate) law: L,
    pub(crate) range: Range<usize>,
    pub(crate) finish: F,
}

impl<L, F, const STEPS: bool, const D: usize> Kernel for FieldSweep<'_, L, F, STEPS, D>
where
    L: BondLaw,
    F: FnMut(usize, &BondSums<f64, D>),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { cloud, law, range, mut finish } = self;
        assert!(STEPS || cloud.families.lattice.is_none());
        let pulls = Pulls::<_, _, true, STEPS>::new(simd, cloud, law, false);
        for point in range {
            finish(point, &pulls.field_sums::<D>(point).totals());
        }
    }
}

/// What the loops over points and parts share.
#[derive(Clone, Copy)]
struct Pulls<'a, S, L, const LEAN: bool, const STEPS: bool> {
    simd: S,
    cloud: Cloud<'a>,
    law: L,
    /// Seats of members that are left out.
    seats: Option<&'a [u32]>,
    skips_bare: bool,
    /// First block of each point's bonds, where their other ends are looked up.
    lists: &'a [u64],
}

/// Bonds at a displacement.
#[derive(Clone, Copy)]
struct Pulled<F, const D: usize> {
    /// y
    bond: [F; D],
    /// (l/L)^2 - 1
    change: F,
    /// V_j/L, and what else their stiffness has.
    weight: F,
}

/// The same before a law has weighed them.
#[derive(Clone, Copy)]
struct Stretched<F, const D: usize> {
    bond: [F; D],
    change: F,
    /// 1/L
    inverse: F,
    /// V_j
    volume: F,
    /// What it is made of: xi where lengths are computed, and 2 du.
    place: [F; D],
    double: [F; D],
}

/// Takes the bonds of a point that break from its masks, and says whether there were any.
#[cold]
#[inline(never)]
fn judged(families: &Families, law: impl BondLaw, point: usize, masks: &mut [u8]) -> bool {
    let first = families.blocks(point).start;
    let mut broke = false;
    for bond in families.bonds(point) {
        let (mask, bit) = (&mut masks[bond.slot / LANES - first], 1 << (bond.slot % LANES));
        if *mask & bit != 0 && law.breaks(point, bond) {
            *mask &= !bit;
            broke = true;
        }
    }
    broke
}

/// Blocks that are asked for ahead of their turn.
const AHEAD: usize = 16;

impl<'a, S: Simd, L: BondLaw, const LEAN: bool, const STEPS: bool> Pulls<'a, S, L, LEAN, STEPS> {
    /// Panics when lists do not hold what is to be read.
    #[inline(always)]
    fn new(simd: S, cloud: Cloud<'a>, law: L, skips_bare: bool) -> Self {
        let families = cloud.families;
        assert!(LEAN || (!STEPS && families.inverse_lengths.is_some()));
        let lattice = families.lattice.as_ref().filter(|_| !STEPS);
        let lists = if STEPS { &families.offsets[..] } else { families.lists() };
        let listed = lists[cloud.records.len()] as usize * LANES;
        assert!(STEPS || listed == families.neighbors.len());
        let seats = lattice.map(|lattice| &lattice.seat_of[..]);
        Self { simd, cloud, law, seats, skips_bare, lists }
    }

    /// Forces on the points of a range. With `BREAK` the bonds that break leave `remaining`.
    #[inline(always)]
    fn sum_up<const BREAK: bool, const D: usize>(
        self,
        range: Range<usize>,
        force: &mut [f64],
        mut remaining: Option<Remaining<'_>>,
    ) -> Option<usize> {
        let Self { cloud, law, seats, .. } = self;
        let offsets = &cloud.families.offsets;
        let first = offsets[range.start] as usize;
        let (forces, _) = force.as_chunks_mut::<D>();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            if seats.is_some_and(|seats| seats[point] != NOBODY) {
                continue;
            }
            let blocks = offsets[point] as usize..offsets[point + 1] as usize;
            let masks = &cloud.intact[blocks.clone()];
            if self.skips_bare && masks.iter().all(|&mask| mask == 0) {
                *force = [0.0; D];
                continue;
            }
            let (mut sum, beyond) = self.sum_bonds::<BREAK, D>(point, masks);
            if BREAK
                && beyond
                && let Some(Remaining { masks, broke }) = &mut remaining
            {
                let remaining = &mut masks[blocks.start - first..blocks.end - first];
                if judged(cloud.families, law, point, remaining) {
                    broke.store(true, Ordering::Relaxed);
                    (sum, _) = self.sum_bonds::<false, D>(point, remaining);
                }
            }
            *force = sum.map(|sum| law.factor() * sum);
            if bad.is_none() && !force.iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }

    /// What the bonds of a point that are in its masks sum up to, and with `LOOK` whether any comes close to its limit.
    #[inline(always)]
    fn sum_bonds<const LOOK: bool, const D: usize>(
        &self,
        point: usize,
        masks: &[u8],
    ) -> ([f64; D], bool) {
        let simd = self.simd;
        let own = self.own(point);
        let mut sum = [simd.splat(0.0); D];
        let mut beyond = 0;
        if !masks.is_empty() {
            let first = self.lists[point] as usize * LANES;
            let mut pulled = self.stretch(point, first, &own);
            let lanes = masks.len() * LANES;
            for lane in (0..lanes - S::WIDTH).step_by(S::WIDTH) {
                let next = self.stretch(point, first + lane + S::WIDTH, &own);
                beyond |= self.pull::<LOOK, D>(point, first, lane, masks, pulled, &mut sum);
                pulled = next;
            }
            beyond |= self.pull::<LOOK, D>(point, first, lanes - S::WIDTH, masks, pulled, &mut sum);
        }
        (sum.map(|sum| sum.total()), beyond != 0)
    }

    /// Adds the forces of bonds to the sum, those from a lane on. With `LOOK`, gives those that come close to their limit.
    #[inline(always)]
    fn pull<const LOOK: bool, const D: usize>(
        &self,
        point: usize,
        first: usize,
        lane: usize,
        masks: &[u8],
        pulled: Pulled<S::Lanes, D>,
        sum: &mut [S::Lanes; D],
    ) -> u8 {
        let Self { simd, law, .. } = *self;
        let bits = masks[lane / LANES] >> (lane % LANES);
        let mut beyond = 0;
        if LOOK {
            let mut names = [0; LANES];
            let threshold = law.threshold(simd, &self.part(point, first + lane, &mut names));
            beyond = pulled.change.above(threshold).bits() & bits;
        }
        let weight = (pulled.weight * pulled.change.shortfall()).only(simd.mask(bits));
        for (sum, bond) in sum.iter_mut().zip(pulled.bond) {
            *sum = weight.mul_add(bond, *sum);
        }
        beyond
    }

    /// The bonds of a point from a slot on, among those of the lists; with `STEPS` among all, named aside.
    #[inline(always)]
    fn part<'b>(&self, point: usize, slot: usize, names: &'b mut [u32; LANES]) -> Part<'b>
    where
        'a: 'b,
    {
        if STEPS {
            let neighbors = &mut names[..S::WIDTH];
            self.cloud.families.name(point, slot, neighbors);
            return Part { point, slot, neighbors };
        }
        let (lanes, families) = (slot..slot + S::WIDTH, self.cloud.families);
        debug_assert!(lanes.end <= families.neighbors.len());
        // SAFETY: slots are those of a point's list, which has its blocks: lists are as long as all slots without a lattice, and
        // members of one are left out.
        let neighbors = unsafe { families.neighbors.get_unchecked(lanes) };
        Part { point, slot, neighbors }
    }

    /// 1/L of the bonds from a slot on, where it is stored.
    #[inline(always)]
    fn inverse(&self, slot: usize) -> S::Lanes {
        let Self { simd, cloud, .. } = *self;
        if LEAN {
            return simd.splat(1.0);
        }
        prefetch(cloud.inverses, slot + AHEAD * LANES);
        debug_assert!(slot + S::WIDTH <= cloud.inverses.len());
        // SAFETY: there are as many as lanes, and slots are as in `part`.
        simd.load(unsafe { cloud.inverses.get_unchecked(slot..slot + S::WIDTH) })
    }

    /// sum s^2 L V_j of the bonds of a point, times what else their stiffness has.
    #[inline(always)]
    fn energy<const D: usize>(&self, point: usize) -> f64 {
        let Self { simd, cloud, law, .. } = *self;
        let (own, blocks) = (self.own(point), cloud.families.blocks(point));
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let (first, mut sum) = (self.lists[point] as usize * LANES, zero);
        for lane in (0..blocks.len() * LANES).step_by(S::WIDTH) {
            let bits = cloud.intact[blocks.start + lane / LANES] >> (lane % LANES);
            let mut names = [0; LANES];
            let part = self.part(point, first + lane, &mut names);
            let Stretched { change, inverse, volume, .. } = self.stretched::<D>(&part, &own);
            // s = z/(1 + l/L)
            let stretch = change / (one + (one + change).max(zero).sqrt());
            let weight = law.weight::<S, false>(simd, &part, inverse, volume) / (inverse * inverse);
            sum = sum + (weight * (stretch * stretch)).only(simd.mask(bits));
        }
        sum.total()
    }

    #[inline(always)]
    fn field_sums<const D: usize>(&self, point: usize) -> BondSums<S::Lanes, D> {
        let Self { simd, cloud, law, .. } = *self;
        let (own, blocks) = (self.own(point), cloud.families.blocks(point));
        let (half, factor) = (simd.splat(0.5), simd.splat(law.factor()));
        let (first, mut sums) =
            (self.lists[point] as usize * LANES, BondSums::new(simd.splat(0.0)));
        for lane in (0..blocks.len() * LANES).step_by(S::WIDTH) {
            let bits = cloud.intact[blocks.start + lane / LANES] >> (lane % LANES);
            let mask = simd.mask(bits);
            let mut names = [0; LANES];
            let part = self.part(point, first + lane, &mut names);
            let bonds = self.stretched::<D>(&part, &own);
            let Stretched { bond, change, inverse, volume, place, double } = bonds;
            let weight = law.count(simd, &part, inverse, volume);
            let pull = law.weight::<S, true>(simd, &part, inverse, volume) * change.shortfall();
            let mut moved = double;
            for moved in &mut moved {
                *moved = *moved * half;
            }
            sums.add(&Summand {
                reference: place,
                moved,
                deformed: bond,
                weight: weight.only(mask),
                pull: (factor * pull).only(mask),
                flowed: None,
            });
        }
        sums
    }

    #[inline(always)]
    fn own(&self, point: usize) -> [S::Lanes; 8] {
        let mut own = [self.simd.splat(0.0); 8];
        for (own, number) in own.iter_mut().zip(self.cloud.records[point]) {
            *own = self.simd.splat(number);
        }
        own
    }

    #[inline(always)]
    fn stretch<const D: usize>(
        &self,
        point: usize,
        slot: usize,
        own: &[S::Lanes; 8],
    ) -> Pulled<S::Lanes, D> {
        let mut names = [0; LANES];
        let part = self.part(point, slot, &mut names);
        let Stretched { bond, change, inverse, volume, .. } = self.stretched(&part, own);
        Pulled {
            bond,
            change,
            weight: self.law.weight::<S, true>(self.simd, &part, inverse, volume),
        }
    }

    #[inline(always)]
    fn stretched<const D: usize>(
        &self,
        part: &Part<'_>,
        own: &[S::Lanes; 8],
    ) -> Stretched<S::Lanes, D> {
        let Self { simd, cloud, .. } = *self;
        let slot = part.slot;
        prefetch(&cloud.families.neighbors, slot + AHEAD * LANES);
        if !STEPS {
            prefetch_rows(cloud.records, &cloud.families.neighbors, slot, S::WIDTH);
        }
        let mut inverse = self.inverse(slot);
        // SAFETY: the search makes neighbours of points of the body alone, and each has a record.
        let places = unsafe { simd.columns(cloud.records, 0, part.neighbors) };
        // SAFETY: as above.
        let doubles = unsafe { simd.columns(cloud.records, 4, part.neighbors) };
        let (quarter, half) = (simd.splat(0.25), simd.splat(0.5));
        let (mut bond, mut product, mut squared) = ([quarter; D], quarter, quarter);
        let mut made_of = [[quarter; D]; 2];
        for axis in 0..D {
            let place = places[axis] - own[axis];
            let double = doubles[axis] - own[4 + axis];
            (made_of[0][axis], made_of[1][axis]) = (place, double);
            let mut middle = place;
            if LEAN {
                middle = double.mul_add(quarter, place);
                squared = if axis == 0 { place * place } else { place.mul_add(place, squared) };
            }
            bond[axis] = double.mul_add(if LEAN { half } else { quarter }, place);
            product = match axis {
                0 => double * middle,
                _ => double.mul_add(middle, product),
            };
        }
        if LEAN {
            inverse = cloud.families.unit.inverse_length(simd, squared);
        }
        let (change, volume, [place, double]) = (product * (inverse * inverse), places[3], made_of);
        Stretched { bond, change, inverse, volume, place, double }
    }
}
