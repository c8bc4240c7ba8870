//! Families in lanes: what the sweeps of state-based formulations read of their bonds.
//!
//! Where all points share horizon and influence function, both ends of a bond give it the same weight, and a family is
//! the whole list of a point.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::simd::{Kernel, Lanes, Mask, Simd, prefetch, prefetch_rows};
use crate::damage::{self, BreakRule, close_to};
use crate::families::{Bond, Families, LANES, Property};
use crate::model::Influence;

/// A point in a line of the cache: place, volume, displacement and a number that does not matter.
pub(crate) type Record = [f64; 8];

/// What the sweeps read. Slots are lanes of the points that can be swept, from the first of these on.
#[derive(Clone, Copy)]
pub(crate) struct Family<'a> {
    families: &'a Families,
    records: &'a [Record],
    /// The points that can be swept, from the first to before the last.
    points: (usize, usize),
    /// Where the first slot stands among all lanes.
    first: usize,
    /// The other ends of bonds.
    names: &'a [u32],
    /// 1/L; `None` where they are computed.
    inverses: Option<&'a [f64]>,
    /// One bit a slot.
    intact: &'a [u8],
    omega: Omega<'a>,
    /// Whether points without bonds are left out.
    skips_bare: bool,
}

/// omega(L), the same for all points, or what bonds count one by one.
#[derive(Clone, Copy)]
pub(crate) struct Omega<'a> {
    pub(crate) influence: Influence,
    pub(crate) dimension: usize,
    /// That of all points, where weights follow from lengths.
    pub(crate) horizon: f64,
    /// That of each point.
    pub(crate) horizons: &'a Property,
    pub(crate) each: Option<EachBond<'a>>,
}

/// What each bond counts in the family of its own end, and in that of the other, where that does not follow from its length;
/// and its integrity, where the host has set any.
#[derive(Clone, Copy)]
pub(crate) struct EachBond<'a> {
    pub(crate) own: Option<&'a [f64]>,
    pub(crate) back: Option<&'a [f64]>,
    pub(crate) integrity: Option<&'a [f64]>,
}

impl<'a> EachBond<'a> {
    fn map(self, of: impl Fn(&'a [f64]) -> &'a [f64]) -> Self {
        let Self { own, back, integrity } = self;
        Self { own: own.map(&of), back: back.map(&of), integrity: integrity.map(of) }
    }
}

impl Omega<'_> {
    /// w of a length where it follows from that; in the rim of the horizon that at the horizon.
    pub(crate) fn at(&self, length: f64) -> f64 {
        let Self { influence, dimension, horizon, .. } = *self;
        influence.value(dimension, length.min(horizon), horizon)
    }

    /// 1
    pub(crate) const EVEN: Self = Self {
        influence: Influence::Constant,
        dimension: 3,
        horizon: f64::INFINITY,
        horizons: &Property::Uniform(f64::INFINITY),
        each: None,
    };
}

/// Bonds that are computed together.
#[derive(Clone, Copy)]
pub(crate) struct Bonds<F, const D: usize> {
    /// xi
    pub(super) reference: [F; D],
    /// eta - xi
    pub(super) moved: [F; D],
    /// What the records have behind place and displacement.
    pub(super) volume: F,
    pub(super) last: F,
}

/// Lengths of bonds.
#[derive(Clone, Copy)]
pub(super) struct Lengths<F> {
    /// L^2
    pub(super) squared: F,
    /// l^2 - L^2, exactly 0 where the ends move alike; the same bits from both ends.
    pub(super) change: F,
}

/// How far bonds are stretched.
#[derive(Clone, Copy)]
pub(crate) struct Stretches<F> {
    /// L/l
    pub(super) shrunk: F,
    /// l/L - 1
    pub(super) stretch: F,
}

/// Blocks that are asked for ahead of their turn.
const AHEAD: usize = 24;

/// Least (l/L)^2 that a root is taken of.
const LEAST: f64 = 1e-15;

impl<'a> Family<'a> {
    /// Panics when there is not a record a point and a mask a block. Where there is a lattice, only parts can be swept:
    /// [listed](Self::listed) and [named](Self::named) ones.
    pub(crate) fn new(
        families: &'a Families,
        records: &'a [Record],
        intact: &'a [u8],
        omega: Omega<'a>,
        skips_bare: bool,
    ) -> Self {
        let Families { offsets, neighbors, inverse_lengths, .. } = families;
        let (count, lanes) = (records.len(), intact.len() * LANES);
        assert_eq!(count + 1, offsets.len());
        assert_eq!(offsets[count] as usize, intact.len());
        if let Some(EachBond { own, back, integrity }) = omega.each {
            assert!([own, back, integrity].into_iter().flatten().all(|of| of.len() == lanes));
        }
        let none = Self {
            families,
            records,
            points: (0, 0),
            names: &[],
            first: 0,
            inverses: None,
            intact,
            omega,
            skips_bare,
        };
        if !families.are_listed() {
            return none;
        }
        assert_eq!(neighbors.len(), lanes);
        let inverses = inverse_lengths.as_deref();
        assert!(inverses.is_none_or(|inverses| inverses.len() == lanes));
        Self { points: (0, count), names: neighbors, inverses, ..none }
    }

    /// Lanes of a point.
    pub(crate) fn lanes(&self, point: usize) -> usize {
        self.families.blocks(point).len() * LANES
    }

    /// Whether all points can be swept at once.
    pub(crate) fn is_whole(&self) -> bool {
        self.families.are_listed()
    }

    /// Where the first points of a range end that all have lists, or none, and whether they have.
    pub(crate) fn run(&self, points: Range<usize>) -> (usize, bool) {
        let listed = self.families.is_listed(points.start);
        let end = points.clone().find(|&point| self.families.is_listed(point) != listed);
        (end.unwrap_or(points.end), listed)
    }

    /// Of a range of points that all have lists.
    pub(crate) fn listed(&self, points: Range<usize>) -> Self {
        let Families { offsets, neighbors, inverse_lengths, .. } = self.families;
        assert!(points.clone().all(|point| self.families.is_listed(point)));
        let lists = self.families.lists();
        let [start, end] = [points.start, points.end].map(|point| lists[point] as usize * LANES);
        let names = &neighbors[start..end];
        assert_eq!(names.len(), (offsets[points.end] - offsets[points.start]) as usize * LANES);
        let inverses = inverse_lengths.as_ref().map(|inverses| &inverses[start..end]);
        self.of(points, names, inverses)
    }

    /// Of points whose bonds have these other ends. Not to be called of a part.
    fn of<'b>(
        &self,
        points: Range<usize>,
        names: &'b [u32],
        inverses: Option<&'b [f64]>,
    ) -> Family<'b>
    where
        'a: 'b,
    {
        let first = self.families.blocks(points.start).start * LANES;
        let lanes = first..first + names.len();
        let each = self.omega.each.map(|each| each.map(|of| &of[lanes.clone()]));
        Family {
            families: self.families,
            records: self.records,
            points: (points.start, points.end),
            first,
            names,
            inverses,
            intact: &self.intact[lanes.start / LANES..lanes.end / LANES],
            omega: Omega { each, ..self.omega },
            skips_bare: self.skips_bare,
        }
    }

    /// The first points of a range, as many as `names` has room for the lanes of, and where they end.
    pub(crate) fn named<'b>(
        &self,
        points: Range<usize>,
        names: &'b mut [u32],
    ) -> (Family<'b>, usize)
    where
        'a: 'b,
    {
        let (mut end, mut filled) = (points.start, 0);
        let first = points.start;
        for point in points {
            let blocks = self.families.blocks(point);
            let lanes = filled..filled + blocks.len() * LANES;
            let Some(own) = names.get_mut(lanes.clone()) else { break };
            self.families.name(point, blocks.start * LANES, own);
            (end, filled) = (point + 1, lanes.end);
        }
        (self.of(first..end, &names[..filled], None), end)
    }

    /// First slot of a point, and the end of its slots. Panics where the point cannot be swept.
    #[inline(always)]
    pub(super) fn slots(&self, point: usize) -> (usize, usize) {
        assert!(self.points.0 <= point && point < self.points.1);
        let slot = |end: usize| self.families.offsets[end] as usize * LANES - self.first;
        (slot(point), slot(point + 1))
    }

    /// The slots of a point that sweeps go through: all, or none where it has no bonds and such are left out.
    #[inline(always)]
    pub(super) fn swept(&self, point: usize) -> (usize, usize) {
        let (start, end) = self.slots(point);
        let bare = self.skips_bare && self.masks(point).iter().all(|&mask| mask == 0);
        (start, if bare { start } else { end })
    }

    /// Where a slot stands among all lanes.
    #[inline(always)]
    pub(super) fn lane(&self, slot: usize) -> usize {
        self.first + slot
    }

    #[inline(always)]
    pub(super) fn record(&self, point: usize) -> &'a Record {
        &self.records[point]
    }

    /// The record of a point in every lane.
    #[inline(always)]
    pub(super) fn own<S: Simd>(&self, simd: S, point: usize) -> [S::Lanes; 8] {
        // A loop, since calls of iterators may not be inlined into a level.
        let mut own = [simd.splat(0.0); 8];
        for (own, number) in own.iter_mut().zip(self.record(point)) {
            *own = simd.splat(*number);
        }
        own
    }

    /// Stretch of a bond of a point, of which and of whose neighbours there are records of places and displacements.
    fn stretch(&self, point: usize, bond: Bond) -> f64 {
        let (from, to) = (self.record(point), self.record(bond.neighbor));
        damage::stretch(bond.length, (0..3).map(|axis| [axis, 4 + axis].map(|k| to[k] - from[k])))
    }

    /// Masks of a point's blocks.
    #[inline(always)]
    pub(super) fn masks(&self, point: usize) -> &'a [u8] {
        let (start, end) = self.slots(point);
        &self.intact[start / LANES..end / LANES]
    }

    /// The other ends of a block of bonds.
    #[inline(always)]
    pub(super) fn block(&self, slot: usize) -> &'a [u32; LANES] {
        prefetch(self.names, slot + AHEAD * LANES);
        let (blocks, _) = self.names.as_chunks();
        &blocks[slot / LANES]
    }

    /// Which of the bonds from a slot on are there; what lies beyond the lanes does not matter.
    #[inline(always)]
    pub(super) fn bits(&self, slot: usize) -> u8 {
        debug_assert!(slot / LANES < self.intact.len());
        // SAFETY: slots are those of the blocks of a point that can be swept, and each block has a mask.
        unsafe { *self.intact.get_unchecked(slot / LANES) >> (slot % LANES) }
    }

    /// The other ends of the bonds from a slot on.
    #[inline(always)]
    pub(super) fn names<S: Simd>(&self, slot: usize) -> &'a [u32] {
        debug_assert!(slot + S::WIDTH <= self.names.len());
        // SAFETY: slots are those of the blocks of a point that can be swept, and each has a name.
        unsafe { self.names.get_unchecked(slot..slot + S::WIDTH) }
    }

    /// The bonds from a slot on, as seen from a point with the record given.
    #[inline(always)]
    pub(super) fn bonds<S: Simd, const D: usize>(
        &self,
        simd: S,
        own: &[S::Lanes; 8],
        slot: usize,
    ) -> Bonds<S::Lanes, D> {
        prefetch(self.names, slot + AHEAD * LANES);
        prefetch_rows(self.records, self.names, slot, S::WIDTH);
        let (reference, volume) = self.references(simd, own, slot);
        // SAFETY: as in `references`.
        let shifts = unsafe { simd.columns(self.records, 4, self.names::<S>(slot)) };
        let mut moved = [volume; D];
        for axis in 0..D {
            moved[axis] = shifts[axis] - own[4 + axis];
        }
        Bonds { reference, moved, volume, last: shifts[3] }
    }

    /// xi of the bonds from a slot on, as seen from a point with the record given, and what stands behind the places.
    #[inline(always)]
    pub(super) fn references<S: Simd, const D: usize>(
        &self,
        simd: S,
        own: &[S::Lanes; 8],
        slot: usize,
    ) -> ([S::Lanes; D], S::Lanes) {
        // SAFETY: names are of points of the body alone, and each has a record.
        let places = unsafe { simd.columns(self.records, 0, self.names::<S>(slot)) };
        let mut reference = [places[0]; D];
        for axis in 0..D {
            reference[axis] = places[axis] - own[axis];
        }
        (reference, places[3])
    }

    /// xi of the bonds from a slot on where weights need it, else other numbers.
    #[inline(always)]
    pub(super) fn reference_for_weight<S: Simd, const D: usize>(
        &self,
        simd: S,
        own: &[S::Lanes; 8],
        slot: usize,
    ) -> [S::Lanes; D] {
        if self.inverses.is_some() {
            return [own[0]; D];
        }
        self.references(simd, own, slot).0
    }

    /// What bonds count in the point's own family times another factor, of those from a slot on with their xi.
    #[inline(always)]
    pub(super) fn weighted<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
        factor: S::Lanes,
    ) -> S::Lanes {
        let kept = self.omega.each.and_then(|each| each.own);
        self.times(simd, slot, reference, factor, kept)
    }

    /// What they count in the families of the other ends times another factor.
    #[inline(always)]
    pub(super) fn weighted_back<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
        factor: S::Lanes,
    ) -> S::Lanes {
        let kept = self.omega.each.and_then(|each| each.back);
        self.times(simd, slot, reference, factor, kept)
    }

    /// What bonds count, of what is kept or by their length, and their integrity, times another factor.
    #[inline(always)]
    fn times<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
        factor: S::Lanes,
        kept: Option<&[f64]>,
    ) -> S::Lanes {
        let Some(EachBond { integrity, .. }) = self.omega.each else {
            return self.times_of_length(simd, slot, reference, factor);
        };
        let counted = match kept {
            Some(kept) => factor * from_slot(simd, kept, slot),
            None => self.times_of_length(simd, slot, reference, factor),
        };
        match integrity {
            Some(integrity) => counted * from_slot(simd, integrity, slot),
            None => counted,
        }
    }

    #[inline(always)]
    fn times_of_length<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
        factor: S::Lanes,
    ) -> S::Lanes {
        match self.omega.influence {
            Influence::Constant => factor,
            _ => factor * self.weights(simd, slot, reference),
        }
    }

    /// What they count in both, each times a factor of its own.
    #[inline(always)]
    pub(super) fn weighted_both<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
        own: S::Lanes,
        back: S::Lanes,
    ) -> S::Lanes {
        if self.omega.each.is_some() {
            let own = self.weighted(simd, slot, reference, own);
            return own + self.weighted_back(simd, slot, reference, back);
        }
        self.weighted(simd, slot, reference, own + back)
    }

    /// Whether the ends of a bond may count it differently.
    #[inline(always)]
    pub(super) fn ends_differ(&self) -> bool {
        let Some(EachBond { own, back, .. }) = self.omega.each else { return false };
        own.map(<[f64]>::as_ptr) != back.map(<[f64]>::as_ptr)
    }

    /// Whether bonds count other than 1.
    #[inline(always)]
    pub(super) fn is_weighted(&self) -> bool {
        self.omega.each.is_some() || self.omega.influence != Influence::Constant
    }

    /// 1/L of the bonds from a slot on with their xi; lanes without a bond may have no number.
    #[inline(always)]
    pub(super) fn inverse_lengths<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
    ) -> S::Lanes {
        let Some(inverses) = self.inverses else {
            let mut squared = reference[0] * reference[0];
            for x in &reference[1..] {
                squared = x.mul_add(*x, squared);
            }
            return self.families.unit.inverse_length(simd, squared);
        };
        from_slot(simd, inverses, slot)
    }

    /// 1/L^2 of the bonds from a slot on with these L^2; lanes without a bond may have no number.
    #[inline(always)]
    pub(super) fn inverse_squares<S: Simd>(
        &self,
        simd: S,
        slot: usize,
        squared: S::Lanes,
    ) -> S::Lanes {
        let Some(inverses) = self.inverses else { return squared.reciprocal() };
        let inverse = from_slot(simd, inverses, slot);
        inverse * inverse
    }

    /// omega of the bonds from a slot on with their xi; in the rim of the horizon that at the horizon.
    #[inline(always)]
    pub(super) fn weights<S: Simd, const D: usize>(
        &self,
        simd: S,
        slot: usize,
        reference: &[S::Lanes; D],
    ) -> S::Lanes {
        let Omega { influence, dimension, horizon, .. } = self.omega;
        let one = simd.splat(1.0);
        // horizon/L
        let closeness =
            (self.inverse_lengths(simd, slot, reference) * simd.splat(horizon)).max(one);
        match influence {
            Influence::Constant => one,
            Influence::Inverse => closeness,
            Influence::Conical => one - closeness.reciprocal(),
            Influence::CubicSpline => {
                let scale = simd.splat(influence.value(dimension, 0.0, horizon));
                let q = closeness.reciprocal();
                let rest = one - q;
                let near = (simd.splat(6.0) * q * q).mul_sub_from(rest, one);
                let far = simd.splat(2.0) * rest * rest * rest;
                scale * far.or(q.above(simd.splat(0.5)), near)
            }
        }
    }
}

/// The numbers of bonds from a slot on; there is one for each.
#[inline(always)]
fn from_slot<S: Simd>(simd: S, numbers: &[f64], slot: usize) -> S::Lanes {
    prefetch(numbers, slot + AHEAD * LANES);
    debug_assert!(slot + S::WIDTH <= numbers.len());
    // SAFETY: slots are those of the blocks of a point that can be swept, and there is a number for each.
    simd.load(unsafe { numbers.get_unchecked(slot..slot + S::WIDTH) })
}

impl<F: Lanes, const D: usize> Bonds<F, D> {
    #[inline(always)]
    pub(super) fn lengths<S: Simd<Lanes = F>>(&self, simd: S) -> Lengths<F> {
        let (mut squared, mut change) = (simd.splat(0.0), simd.splat(0.0));
        for axis in 0..D {
            let (x, moved) = (self.reference[axis], self.moved[axis]);
            let both = x + (x + moved);
            (squared, change) = match axis {
                0 => (x * x, moved * both),
                _ => (x.mul_add(x, squared), moved.mul_add(both, change)),
            };
        }
        Lengths { squared, change }
    }

    /// eta
    #[inline(always)]
    pub(super) fn deformed(&self) -> [F; D] {
        let mut deformed = self.reference;
        for (axis, moved) in self.moved.into_iter().enumerate() {
            deformed[axis] = deformed[axis] + moved;
        }
        deformed
    }
}

impl<F: Lanes> Lengths<F> {
    /// Of the bonds from a slot on; lanes without a bond may have no number. Right to some 3e-16 of the stretch; where bonds count one
    /// by one to the last bits of the stretch, as loops over single bonds are.
    #[inline(always)]
    pub(super) fn stretches<S: Simd<Lanes = F>>(
        &self,
        simd: S,
        family: &Family<'_>,
        slot: usize,
    ) -> Stretches<F> {
        let one = simd.splat(1.0);
        let change = self.change * family.inverse_squares(simd, slot, self.squared);
        if family.omega.each.is_some() {
            let root = (one + change).max(simd.splat(LEAST)).sqrt();
            return Stretches { shrunk: one / root, stretch: change / (one + root) };
        }
        let shortfall = change.shortfall();
        let shrunk = one - shortfall;
        let ratio = (one + change).max(simd.splat(LEAST));
        Stretches { shrunk, stretch: shortfall * (ratio * shrunk) }
    }
}

/// Rows of numbers, one a point.
#[derive(Clone, Copy)]
pub(crate) struct Table<'a, const C: usize>(&'a [[f64; C]]);

impl<'a, const C: usize> Table<'a, C> {
    /// Panics when there is not a row a point of the family.
    pub(crate) fn new(family: &Family<'_>, rows: &'a [[f64; C]]) -> Self {
        assert_eq!(family.records.len(), rows.len());
        Self(rows)
    }

    #[inline(always)]
    pub(super) fn row(&self, point: usize) -> &'a [f64; C] {
        &self.0[point]
    }

    /// Asks for the rows of other ends that will be read after those from a slot on.
    #[inline(always)]
    pub(super) fn ask_ahead(&self, family: &Family<'_>, slot: usize, count: usize) {
        prefetch_rows(self.0, family.names, slot, count);
    }

    /// # Safety
    /// All of `at` name points.
    #[inline(always)]
    pub(super) unsafe fn columns<S: Simd>(
        &self,
        simd: S,
        first: usize,
        at: &[u32],
    ) -> [S::Lanes; 4] {
        // SAFETY: as the caller has promised.
        unsafe { simd.columns(self.0, first, at) }
    }

    /// # Safety
    /// It names a point.
    #[inline(always)]
    pub(super) unsafe fn row_of(&self, name: u32) -> &'a [f64; C] {
        debug_assert!((name as usize) < self.0.len());
        // SAFETY: as the caller has promised.
        unsafe { self.0.get_unchecked(name as usize) }
    }
}

/// When bonds break.
#[derive(Clone, Copy)]
pub(crate) struct Limits<'a> {
    rule: &'a BreakRule,
    /// (l/L)^2 - 1 from which they come close to it, if all share it.
    uniform: Option<f64>,
}

impl<'a> Limits<'a> {
    pub(crate) fn new(rule: &'a BreakRule) -> Self {
        Self { rule, uniform: rule.uniform().map(close_to) }
    }

    /// (l/L)^2 - 1 from which bonds come close to their limit, if all share it.
    pub(crate) fn uniform(&self) -> Option<f64> {
        self.uniform
    }

    /// Which of the bonds from a slot on, of those in `bits`, come close to their limit.
    #[inline(always)]
    pub(super) fn close<S: Simd>(
        &self,
        simd: S,
        family: &Family<'_>,
        (point, slot): (usize, usize),
        lengths: &Lengths<S::Lanes>,
        bits: u8,
    ) -> u8 {
        let threshold = match self.uniform {
            Some(threshold) => simd.splat(threshold),
            None => self.various(simd, family, point, slot),
        };
        lengths.change.above(threshold * lengths.squared).bits() & bits
    }

    #[inline(always)]
    fn various<S: Simd>(
        &self,
        simd: S,
        family: &Family<'_>,
        point: usize,
        slot: usize,
    ) -> S::Lanes {
        let neighbors = family.names::<S>(slot);
        simd.each(|lane| {
            let slot = family.lane(slot + lane);
            close_to(self.rule.threshold(slot, point, neighbors[lane] as usize))
        })
    }
}

/// Bonds that break in a sweep: the rule, and the masks of the sweep's blocks.
pub(crate) struct BreakHere<'a> {
    pub(crate) limits: Limits<'a>,
    /// The masks as they are, of which bonds that break are taken.
    pub(crate) remaining: &'a mut [u8],
    /// Told when any break.
    pub(crate) broke: &'a AtomicBool,
    /// First block of the sweep.
    pub(crate) first: usize,
}

/// Masks of a point's blocks, where bonds break as they are by now.
#[inline(always)]
pub(super) fn remaining<'b>(
    family: &Family<'b>,
    breaking: &'b Option<BreakHere<'_>>,
    point: usize,
) -> &'b [u8] {
    let Some(BreakHere { remaining, first, .. }) = breaking else { return family.masks(point) };
    let blocks = family.families.blocks(point);
    &remaining[blocks.start - first..blocks.end - first]
}

impl BreakHere<'_> {
    /// Takes the bonds of a point that are to break out of the masks, and says whether there were any. What lanes compute depends
    /// on the sweep: bonds are judged one by one, so that both ends come to the same.
    #[cold]
    #[inline(never)]
    pub(super) fn judged(&mut self, family: Family<'_>, point: usize) -> bool {
        let Self { limits: Limits { rule, .. }, remaining, first, .. } = self;
        let mut any = false;
        for bond in family.families.bonds(point) {
            let (block, bit) = (bond.slot / LANES, 1 << (bond.slot % LANES));
            let mask = &mut remaining[block - *first];
            if *mask & rule.breakable(block) & bit == 0 {
                continue;
            }
            let stretch = family.stretch(point, bond);
            // What is beyond all numbers shall be noticed, and not break.
            if stretch > rule.threshold(bond.slot, point, bond.neighbor) && stretch.is_finite() {
                *mask &= !bit;
                any = true;
            }
        }
        if any {
            self.broke.store(true, Ordering::Relaxed);
        }
        any
    }
}

/// Takes the bonds that are to break out of the masks of a range, and does nothing else.
pub(crate) struct BreakSweep<'a, const D: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    pub(crate) breaking: BreakHere<'a>,
}

impl<const D: usize> Kernel for BreakSweep<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, range, mut breaking } = self;
        let limits = breaking.limits;
        for point in range {
            let own = family.own(simd, point);
            let (start, end) = family.swept(point);
            let mut close = 0;
            for slot in (start..end).step_by(S::WIDTH) {
                let lengths = family.bonds::<S, D>(simd, &own, slot).lengths(simd);
                close |= limits.close(simd, &family, (point, slot), &lengths, family.bits(slot));
            }
            if close != 0 {
                breaking.judged(family, point);
            }
        }
    }
}
