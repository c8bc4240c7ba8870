//! What formulations share whose forces are swept in lanes: scenes in which bonds count alike but for their length,
//! tables of points in the scratch, and bonds that break on the way.

use super::Scene;
use super::body::Weights;
use super::calm::Resting;
use crate::damage::Breaking;
use crate::families::Property;
use crate::families::lattice::MOST_LANES;
use crate::kernel::family::{BreakHere, EachBond, Family, Limits, Omega, Record};
use crate::model::Influence;
use crate::workers::{Outputs, PerPoint, Ragged};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize};

/// Numbers beyond those of tables that let the first of them begin a line of the cache.
pub(super) const SLACK: usize = 7;

/// Calls a method with the sizes of a gradient: of the body's dimension, its monomials, and the numbers of a row that
/// other ends of bonds read.
macro_rules! of_size {
    ($dimension:expr, $passes:ident.$method:ident($($argument:expr),*)) => {
        match ($dimension, $passes.gradient_order()) {
            (3, 1) => $passes.$method::<3, 3, 16>($($argument),*),
            (3, _) => $passes.$method::<3, 9, 40>($($argument),*),
            (_, 1) => $passes.$method::<2, 2, 12>($($argument),*),
            _ => $passes.$method::<2, 5, 24>($($argument),*),
        }
    };
}
pub(super) use of_size;

/// What bonds count in a scene: by their length where all points share horizon and influence function and no bond counts in
/// part, else as the weights have kept it; `None` where they have not, or single bonds are wanted.
pub(super) fn omega<'a>(scene: &Scene<'a>, weights: &'a Weights) -> Option<Omega<'a>> {
    if !scene.lanes {
        return None;
    }
    let dimension = scene.dimension;
    let horizon = match weights.horizons {
        Property::Uniform(horizon) => horizon,
        Property::PerPoint(_) => f64::INFINITY,
    };
    let (kept, integrity) = (weights.each(), scene.bonds.integrity);
    let influence = match (kept, weights.follow_length(scene)) {
        (Some(_), _) => Influence::Constant,
        (None, influence) => influence?,
    };
    let [own, back] = [0, 1].map(|end| kept.map(|of| of[end]));
    let each = (own.is_some() || integrity.is_some()).then_some(EachBond { own, back, integrity });
    Some(Omega { influence, dimension, horizon, horizons: &weights.horizons, each })
}

/// The numbers from the first that begins a line of the cache.
pub(super) fn from_a_line(numbers: &mut [f64]) -> &mut [f64] {
    let ahead = numbers.as_ptr().align_offset(64).min(SLACK);
    &mut numbers[ahead..]
}

/// A table of so many rows from the front of the scratch, and the rest of it.
pub(super) fn table<const C: usize>(
    scratch: &mut [f64],
    rows: usize,
) -> (&mut [[f64; C]], &mut [f64]) {
    let (table, rest) = from_a_line(scratch).split_at_mut(rows * C);
    (table.as_chunks_mut().0, rest)
}

/// Numbers of records of points.
pub(super) fn room_of_records(points: usize) -> usize {
    points * size_of::<Record>() / size_of::<f64>() + SLACK
}

/// Records of all points from the front of the scratch, and the rest of it.
pub(super) fn record<'a, const D: usize>(
    scene: &Scene<'_>,
    scratch: &'a mut [f64],
) -> (&'a [Record], &'a mut [f64]) {
    record_some::<D>(scene, scratch, |_| true)
}

/// The same, but for blocks of points that are not wanted, by the first of each.
pub(super) fn record_some<'a, const D: usize>(
    scene: &Scene<'_>,
    scratch: &'a mut [f64],
    wanted: impl Fn(usize) -> bool + Sync,
) -> (&'a [Record], &'a mut [f64]) {
    let (records, rest) = table(scratch, scene.places.len());
    let (shifts, _) = scene.displacement.as_chunks::<D>();
    scene.workers.sweep(scene.places.len(), PerPoint(&mut *records, 1), |range, records| {
        if !wanted(range.start) {
            return;
        }
        for (record, point) in records.0.iter_mut().zip(range) {
            *record = [0.0; 8];
            record[..4].copy_from_slice(&scene.places[point]);
            record[4..4 + D].copy_from_slice(&shifts[point]);
        }
    });
    (records, rest)
}

/// The families of a scene with records of its points, and bonds as they are.
pub(super) fn family<'a>(scene: &Scene<'a>, records: &'a [Record], omega: Omega<'a>) -> Family<'a> {
    Family::new(scene.families, records, scene.bonds.intact, omega, scene.skips.without_bonds)
}

/// Lanes whose other ends are looked up at once where bonds are not listed.
const NAMED: usize = 2048;

/// Which points of a body are swept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    All,
    /// Those that no sweep over groups of a lattice does: points that have lists of their bonds, and all where
    /// there is no such sweep.
    Listed,
}

/// Calls `leaf` for parts of the points, each with a family that it can sweep.
pub(super) fn sweep<O: Outputs>(
    scene: &Scene<'_>,
    family: Family<'_>,
    which: Which,
    outputs: O,
    leaf: impl Fn(Family<'_>, Range<usize>, O) + Sync,
) {
    scene.workers.sweep(scene.places.len(), outputs, |range, outputs| {
        if family.is_whole() {
            leaf(family, range, outputs);
        } else if which == Which::All || scene.lattice().is_none() {
            by_runs(family, range, outputs, &mut [0; MOST_LANES], &leaf);
        } else {
            by_runs(family, range, outputs, &mut [], &leaf);
        }
    });
}

/// What a sweep does with a part of a family.
type Part<'a, O> = &'a (dyn Fn(Family<'_>, Range<usize>, O) + Sync);

/// Calls `leaf` for runs of points that have lists, and if there is room for names for members: for a few at a time, with the
/// names of their lanes.
#[inline(never)]
fn by_runs<O: Outputs>(
    family: Family<'_>,
    range: Range<usize>,
    outputs: O,
    names: &mut [u32],
    leaf: Part<'_, O>,
) {
    let (mut start, mut outputs) = (range.start, outputs);
    while start < range.end {
        let (mut end, listed) = family.run(start..range.end);
        let part = if listed {
            Some(family.listed(start..end))
        } else if names.is_empty() {
            None
        } else {
            let room = &mut names[..NAMED.max(family.lanes(start))];
            let (part, last) = family.named(start..end, room);
            end = last;
            Some(part)
        };
        let (own, others) = outputs.split(start, end);
        if let Some(part) = part {
            leaf(part, start..end, own);
        }
        (start, outputs) = (end, others);
    }
}

/// How bonds break in a sweep.
#[derive(Clone, Copy)]
pub(super) struct HowTheyBreak<'a> {
    limits: Limits<'a>,
    broke: &'a AtomicBool,
    offsets: &'a [u64],
    resting: Resting<'a>,
}

impl<'a> HowTheyBreak<'a> {
    /// And the masks that they break in, to be shared out.
    pub(super) fn of(
        scene: &Scene<'a>,
        breaking: &'a mut Breaking<'_>,
        resting: Resting<'a>,
    ) -> (Ragged<'a, u8>, Self) {
        let limits = Limits::new(breaking.rule);
        let (masks, broke) = breaking.shared(scene.families);
        let how = Self { limits, broke, offsets: masks.offsets, resting };
        (masks, how)
    }

    /// The same where there may be no rule.
    pub(super) fn if_any(
        scene: &Scene<'a>,
        breaking: &'a mut Option<Breaking<'_>>,
        resting: Resting<'a>,
    ) -> (Option<Ragged<'a, u8>>, Option<Self>) {
        breaking.as_mut().map(|breaking| Self::of(scene, breaking, resting)).unzip()
    }

    /// In a part that begins with a point, if any can.
    pub(super) fn here<'b>(self, first: usize, masks: Ragged<'b, u8>) -> Option<BreakHere<'b>>
    where
        'a: 'b,
    {
        let Self { limits, broke, offsets, resting } = self;
        if resting.is_short(first, limits.uniform()) {
            return None;
        }
        Some(BreakHere { limits, broke, remaining: masks.values, first: offsets[first] as usize })
    }
}

/// The scene with the bonds that remain.
pub(super) fn remaining<'a>(scene: &Scene<'a>, breaking: &'a Option<Breaking<'_>>) -> Scene<'a> {
    let bonds = breaking.as_ref().map_or(scene.bonds, |breaking| breaking.left_of(scene.bonds));
    Scene { bonds, ..*scene }
}

/// The first point that was noted, if any was.
pub(super) fn first(noted: AtomicUsize) -> Option<usize> {
    let found = noted.into_inner();
    (found != usize::MAX).then_some(found)
}
