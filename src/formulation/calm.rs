//! What a sweep may leave out where nothing happens: the forces of points whose families move as one, and the stretch
//! test where no bond can have come close to its limit. Neither changes a bit of the result.
//!
//! Of each block of points the box of their displacements is known, and which blocks its bonds can lead to. Ends of a
//! bond differ by no more than the boxes of these blocks together are wide. Where forces come from families of families,
//! rings of blocks that rest are counted around each.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Scene;
use crate::error::Result;
use crate::families::lattice::{Lattice, NOBODY};
use crate::families::{Families, Place};
use crate::memory;
use crate::workers::{BLOCK, PerBlock, block_count};

const PURPOSE: &str = "blocks of points";

/// What sweeps leave out where it changes nothing. All by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Skips {
    /// Forces of points whose families have not moved, or have moved as one.
    pub at_rest: bool,
    /// The stretch test where displacements differ by too little for any bond to break.
    pub stretch_tests: bool,
    /// Points without bonds.
    pub without_bonds: bool,
}

impl Default for Skips {
    fn default() -> Self {
        Self { at_rest: true, stretch_tests: true, without_bonds: true }
    }
}

/// Lowest and highest of each component.
#[derive(Debug, Clone, Copy)]
struct Extent([[f64; 2]; 3]);

impl Extent {
    const NOTHING: Self = Self([[f64::INFINITY, f64::NEG_INFINITY]; 3]);

    fn add(&mut self, place: &[f64]) {
        for (ends, &x) in self.0.iter_mut().zip(place) {
            if !x.is_finite() {
                *ends = [f64::NEG_INFINITY, f64::INFINITY];
            }
            ends[0] = if x < ends[0] { x } else { ends[0] };
            ends[1] = if x > ends[1] { x } else { ends[1] };
        }
    }

    fn join(&mut self, other: &Self) {
        for (ends, other) in self.0.iter_mut().zip(&other.0) {
            *ends = [ends[0].min(other[0]), ends[1].max(other[1])];
        }
    }

    fn is_within(&self, reach: f64, other: &Self) -> bool {
        let mut axes = self.0.iter().zip(&other.0);
        axes.all(|(own, other)| own[0] - other[1] <= reach && other[0] - own[1] <= reach)
    }
}

/// Lists of blocks, one after the other.
#[derive(Debug, Default)]
struct Lists {
    ends: Vec<usize>,
    blocks: Vec<u32>,
}

impl Lists {
    fn of(&self, number: usize) -> &[u32] {
        let first = if number == 0 { 0 } else { self.ends[number - 1] };
        &self.blocks[first..self.ends[number]]
    }

    fn close(&mut self) -> Result<()> {
        memory::push(&mut self.ends, self.blocks.len(), PURPOSE)
    }

    fn bytes(&self) -> usize {
        memory::bytes(&self.ends) + memory::bytes(&self.blocks)
    }
}

/// Which blocks the bonds of blocks lead to, and how their points have moved.
#[derive(Debug)]
pub(super) struct Calm {
    /// Of each block of points, and of each block of seats on the lattice.
    points: Lists,
    seats: Lists,
    /// No bond that can break is shorter.
    shortest: f64,
    /// Rings that anyone asks for.
    most_rings: u8,
    seen: Mutex<Seen>,
}

/// Displacements, block by block.
#[derive(Debug)]
struct Seen {
    extents: Vec<Extent>,
    /// 0 where bonds do not rest, 1 where those of a block do, 2 where those of the blocks that they lead to do as well, and so
    /// on.
    rings: Vec<u8>,
}

impl Calm {
    /// `reach`: no bond is longer; `tests`: whether stretch tests may be left out; `most_rings`: what [`Look`] is asked for.
    pub(super) fn new(scene: &Scene<'_>, reach: f64, tests: bool, most_rings: u8) -> Result<Self> {
        let points = near(scene.places, reach)?;
        let seats = match &scene.families.lattice {
            Some(lattice) => near_seats(lattice, &points, scene.places.len())?,
            None => Lists::default(),
        };
        let blocks = block_count(scene.places.len());
        let shortest = if tests { shortest(scene.families) } else { 0.0 };
        let extents = memory::filled(Extent::NOTHING, blocks, PURPOSE)?;
        let seen = Mutex::new(Seen { extents, rings: memory::filled(0, blocks, PURPOSE)? });
        Ok(Self { points, seats, shortest, most_rings, seen })
    }

    pub(super) fn bytes(&self) -> usize {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let seen = memory::bytes(&seen.extents) + memory::bytes(&seen.rings);
        self.points.bytes() + self.seats.bytes() + seen
    }

    /// Looks at the displacements of a scene.
    pub(super) fn look(&self, scene: &Scene<'_>) -> Look<'_> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let (dimension, extents) = (scene.dimension, PerBlock(&mut seen.extents[..]));
        scene.workers.sweep(scene.places.len(), extents, |range, extents| {
            let mut extent = Extent::NOTHING;
            let own = &scene.displacement[range.start * dimension..range.end * dimension];
            for shift in own.chunks_exact(dimension) {
                extent.add(shift);
            }
            extents.0[0] = extent;
        });
        let mut look = Look { calm: self, skips: scene.skips, seen };
        look.count_rings();
        look
    }
}

/// What has been seen of a scene.
pub(super) struct Look<'a> {
    calm: &'a Calm,
    skips: Skips,
    seen: MutexGuard<'a, Seen>,
}

/// What can be said of the bonds of a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bonds {
    /// Both ends of each have moved alike.
    pub(super) rest: bool,
    /// None can have stretched so far that it is to be looked at.
    pub(super) are_short: bool,
}

impl Look<'_> {
    /// Of the block that begins with a point; `threshold`: (l/L)^2 - 1 from which bonds are looked at.
    pub(super) fn at_points(&self, first: usize, threshold: f64) -> Bonds {
        self.judge(self.calm.points.of(first / BLOCK), threshold)
    }

    /// Of the block that begins with a seat on the lattice.
    pub(super) fn at_seats(&self, first: usize, threshold: f64) -> Bonds {
        self.judge(self.calm.seats.of(first / BLOCK), threshold)
    }

    /// Whether so many rings, two at least, rest around all points of the block that begins with a point.
    pub(super) fn rest_around_points(&self, first: usize, rings: u8) -> bool {
        self.seen.rings[first / BLOCK] >= rings
    }

    /// The same of the block that begins with a seat on the lattice.
    pub(super) fn rest_around_seats(&self, first: usize, rings: u8) -> bool {
        let mut blocks = self.calm.seats.of(first / BLOCK).iter();
        blocks.all(|&block| self.seen.rings[block as usize] >= rings - 1)
    }

    fn count_rings(&mut self) {
        if self.calm.most_rings == 0 {
            return;
        }
        for block in 0..self.seen.rings.len() {
            let rest = self.judge(self.calm.points.of(block), 0.0).rest;
            self.seen.rings[block] = u8::from(rest);
        }
        let rings = &mut self.seen.rings;
        for ring in 2..=self.calm.most_rings {
            for block in 0..rings.len() {
                let mut near = self.calm.points.of(block).iter();
                if near.all(|&near| rings[near as usize] >= ring - 1) {
                    rings[block] = ring;
                }
            }
        }
    }

    fn judge(&self, blocks: &[u32], threshold: f64) -> Bonds {
        let mut all = Extent::NOTHING;
        for &block in blocks {
            all.join(&self.seen.extents[block as usize]);
        }
        let mut squared = 0.0;
        for [low, high] in all.0 {
            let width = if high >= low { high - low } else { 0.0 };
            squared += width * width;
        }
        // (l/L)^2 - 1 is no more than t (2 + t) at a relative displacement t of L; with room for rounding.
        let most = squared.sqrt() / self.calm.shortest;
        let Skips { at_rest, stretch_tests, .. } = self.skips;
        Bonds {
            rest: at_rest && squared == 0.0,
            are_short: stretch_tests && 1.001 * most * (2.0 + most) + 1e-12 < threshold,
        }
    }
}

/// The blocks within reach of each block, by the boxes around their points.
fn near(places: &[Place], reach: f64) -> Result<Lists> {
    let mut boxes = memory::filled(Extent::NOTHING, block_count(places.len()), PURPOSE)?;
    for (extent, places) in boxes.iter_mut().zip(places.chunks(BLOCK)) {
        places.iter().for_each(|place| extent.add(&place[..3]));
    }
    let mut whole = Extent::NOTHING;
    boxes.iter().for_each(|extent| whole.join(extent));
    let length = |axis: &usize| whole.0[*axis][1] - whole.0[*axis][0];
    let axis = (0..3).max_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(0);
    // Along the longest axis only those that begin before a block ends are looked at.
    let mut order = memory::collected(0..boxes.len() as u32, PURPOSE)?;
    let from = |block: u32| boxes[block as usize].0[axis][0];
    order.sort_unstable_by(|&a, &b| from(a).total_cmp(&from(b)).then(a.cmp(&b)));
    let widest = boxes.iter().map(|extent| extent.0[axis][1] - extent.0[axis][0]);
    let widest = widest.fold(0.0, f64::max);
    let reach = 1.001 * reach;
    let mut lists = Lists::default();
    for own in &boxes {
        let [low, high] = own.0[axis];
        let first = order.partition_point(|&block| from(block) < low - reach - widest);
        let candidates = order[first..].iter().take_while(|&&block| from(block) <= high + reach);
        for &block in candidates {
            if own.is_within(reach, &boxes[block as usize]) {
                memory::push(&mut lists.blocks, block, PURPOSE)?;
            }
        }
        lists.close()?;
    }
    Ok(lists)
}

/// The same of blocks of seats.
fn near_seats(lattice: &Lattice, points: &Lists, count: usize) -> Result<Lists> {
    let mut lists = Lists::default();
    let mut last = memory::filled(u32::MAX, block_count(count), PURPOSE)?;
    for (number, members) in lattice.members.chunks(BLOCK).enumerate() {
        for &member in members.iter().filter(|&&member| member != NOBODY) {
            for &block in points.of(member as usize / BLOCK) {
                if std::mem::replace(&mut last[block as usize], number as u32) != number as u32 {
                    memory::push(&mut lists.blocks, block, PURPOSE)?;
                }
            }
        }
        lists.close()?;
    }
    Ok(lists)
}

/// A length that no bond is below.
fn shortest(families: &Families) -> f64 {
    // Points are off their crossings by next to nothing.
    let steps = families.lattice.iter().flat_map(|lattice| &lattice.stencil);
    let steps =
        steps.map(|step| (1.0 - 1e-6) * step.reference.map(|x| x * x).iter().sum::<f64>().sqrt());
    steps.fold(families.shortest, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn calm(shortest: f64, moved: &[[f64; 2]]) -> Calm {
        // Blocks in a row, each with the next.
        let (mut points, last) = (Lists::default(), moved.len() - 1);
        for number in 0..moved.len() {
            points.blocks.extend(number.saturating_sub(1) as u32..=(number + 1).min(last) as u32);
            points.close().unwrap();
        }
        let extents = moved.iter().map(|&ends| Extent([ends, [0.0; 2], [0.0; 2]])).collect();
        let seen = Mutex::new(Seen { extents, rings: vec![0; moved.len()] });
        Calm { points, seats: Lists::default(), shortest, most_rings: 3, seen }
    }

    fn look(calm: &Calm) -> Look<'_> {
        let seen = calm.seen.lock().unwrap();
        let mut look = Look { calm, skips: Skips::default(), seen };
        look.count_rings();
        look
    }

    #[test]
    fn rings_are_counted_around_what_rests() {
        let mut moved = [[0.5; 2]; 8];
        moved[7] = [0.5, 0.6];
        let calm = calm(1.0, &moved);
        assert_eq!(look(&calm).seen.rings, [3, 3, 3, 3, 2, 1, 0, 0]);
        let rest = [2, 3].map(|rings| look(&calm).rest_around_points(4 * BLOCK, rings));
        assert_eq!(rest, [true, false]);
    }

    #[test]
    fn a_block_rests_where_all_it_leads_to_has_moved_alike() {
        let calm = calm(1.0, &[[0.5, 0.5], [0.5, 0.5], [0.5, 0.5], [0.5, 0.6], [0.0, 0.0]]);
        let look = look(&calm);
        let rests = [0, 1, 2, 3, 4].map(|block| look.at_points(block * BLOCK, 0.1).rest);
        assert_eq!(rests, [true, true, false, false, false]);
    }

    #[test]
    fn the_stretch_test_is_left_out_only_where_it_cannot_fire() {
        let calm = calm(2.0, &[[0.0, 0.1], [0.0, 0.02], [0.0, 0.02]]);
        let look = look(&calm);
        // A stretch of 0.05 in the first two, of 0.01 in the last.
        for (threshold, short) in [(0.1027, true), (0.1024, false), (0.0202, false)] {
            assert_eq!(look.at_points(0, threshold).are_short, short);
        }
        assert!(look.at_points(2 * BLOCK, 0.0202).are_short);
        assert!(!look.at_points(2 * BLOCK, 0.0200).are_short);
    }

    #[test]
    fn what_is_no_number_neither_rests_nor_is_short() {
        let mut extent = Extent::NOTHING;
        [[0.0, 0.0], [f64::NAN, 0.0]].iter().for_each(|shift| extent.add(shift));
        let calm = calm(1.0, &[extent.0[0]]);
        let bonds = look(&calm).at_points(0, f64::MAX);
        assert!(!bonds.rest && !bonds.are_short);
    }
}
