//! What a sweep may leave out where nothing happens: the forces of points whose families move as one, and the stretch
//! test where no bond can have come close to its limit. Neither changes a bit of the result.
//!
//! Of each block of points the box of their displacements is known, and which blocks its bonds can lead to. Ends of a
//! bond differ by no more than the boxes of these blocks together are wide. Where forces come from families of families,
//! rings of blocks that rest are counted around each.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Scene;
use crate::error::Result;
use crate::families::Place;
use crate::families::lattice::NOBODY;
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
    const EVERYTHING: Self = Self([[f64::NEG_INFINITY, f64::INFINITY]; 3]);

    fn add(&mut self, place: &[f64]) {
        for (ends, &x) in self.0.iter_mut().zip(place) {
            ends[0] = if x < ends[0] { x } else { ends[0] };
            ends[1] = if x > ends[1] { x } else { ends[1] };
        }
    }

    /// Of vectors of `D` components, taken two at a time; of everything where one is not finite.
    fn of<const D: usize, const BOTH: usize>(vectors: &[f64]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; BOTH], [f64::NEG_INFINITY; BOTH]);
        let mut odd = [0.0; BOTH];
        let (pairs, last) = vectors.as_chunks::<BOTH>();
        let mut add = |numbers: &[f64; BOTH]| {
            for (place, &x) in numbers.iter().enumerate() {
                low[place] = if x < low[place] { x } else { low[place] };
                high[place] = if x > high[place] { x } else { high[place] };
                // Not a number unless all are finite.
                odd[place] += 0.0 * x;
            }
        };
        pairs.iter().for_each(&mut add);
        if !last.is_empty() {
            add(&std::array::from_fn(|place| last[place % D]));
        }
        let mut extent = Self::NOTHING;
        for place in 0..BOTH {
            let ends = &mut extent.0[place % D];
            *ends = [ends[0].min(low[place]), ends[1].max(high[place])];
        }
        if odd == [0.0; BOTH] { extent } else { Self::EVERYTHING }
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
    near: Lists,
    /// No bond that can break is shorter.
    shortest: f64,
    /// Rings that anyone asks for.
    most_rings: u8,
    seen: Mutex<Seen>,
}

/// Of each block.
#[derive(Debug)]
struct Seen {
    /// Of its displacements.
    extents: Vec<Extent>,
    /// How far the ends of one of its bonds can have moved apart.
    widths: Vec<f64>,
    /// 0 where its bonds do not rest, 1 where they do, 2 where those of the blocks that they lead to do as well, and so on.
    rings: Vec<u8>,
}

impl Calm {
    /// `reach`: no bond is longer; `tests`: whether stretch tests may be left out; `most_rings`: what [`Look`] is asked for.
    pub(super) fn new(scene: &Scene<'_>, reach: f64, tests: bool, most_rings: u8) -> Result<Self> {
        let near = near(scene.places, reach)?;
        let shortest = if tests { scene.families.shortest_bond() } else { 0.0 };
        let blocks = block_count(scene.places.len());
        let seen = Mutex::new(Seen {
            extents: memory::filled(Extent::NOTHING, blocks, PURPOSE)?,
            widths: memory::filled(0.0, blocks, PURPOSE)?,
            rings: memory::filled(0, blocks, PURPOSE)?,
        });
        Ok(Self { near, shortest, most_rings, seen })
    }

    pub(super) fn bytes(&self) -> usize {
        let Seen { extents, widths, rings } =
            &*self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        self.near.bytes() + memory::bytes(extents) + memory::bytes(widths) + memory::bytes(rings)
    }

    /// Looks at the displacements of a scene.
    pub(super) fn look(&self, scene: &Scene<'_>) -> Look<'_> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, dimension) = (scene.places.len(), scene.dimension);
        let extents = PerBlock(&mut seen.extents[..]);
        scene.workers.sweep(count, extents, |range, extents| {
            let own = &scene.displacement[range.start * dimension..range.end * dimension];
            extents.0[0] = match dimension {
                3 => Extent::of::<3, 6>(own),
                _ => Extent::of::<2, 4>(own),
            };
        });
        let Seen { extents, widths, .. } = &mut *seen;
        scene.workers.sweep(count, PerBlock(&mut widths[..]), |range, widths| {
            widths.0[0] = width(extents, self.near.of(range.start / BLOCK));
        });
        self.judge(scene.skips, seen)
    }

    fn judge<'a>(&'a self, skips: Skips, mut seen: MutexGuard<'a, Seen>) -> Look<'a> {
        let Seen { widths, rings, .. } = &mut *seen;
        for (rings, width) in rings.iter_mut().zip(&*widths) {
            *rings = u8::from(skips.at_rest && *width == 0.0);
        }
        let any_rests = rings.contains(&1);
        for ring in 2..=if any_rests { self.most_rings } else { 0 } {
            for block in 0..rings.len() {
                let mut near = self.near.of(block).iter();
                if near.all(|&near| rings[near as usize] >= ring - 1) {
                    rings[block] = ring;
                }
            }
        }
        let widest = widths.iter().fold(0.0, |widest, width| f64::max(widest, *width));
        Look { calm: self, skips, seen, any_rests, widest }
    }
}

/// What has been seen of a scene.
pub(super) struct Look<'a> {
    calm: &'a Calm,
    skips: Skips,
    seen: MutexGuard<'a, Seen>,
    any_rests: bool,
    widest: f64,
}

impl Look<'_> {
    /// Whether no bond of the block that begins with a point can have stretched so far that it is to be looked at; `threshold`:
    /// (l/L)^2 - 1 from which it is.
    fn block_is_short(&self, first: usize, threshold: f64) -> bool {
        self.is_short(self.seen.widths[first / BLOCK], threshold)
    }

    /// The same of the bonds of the members of a group.
    fn group_is_short(&self, members: &[u32], threshold: f64) -> bool {
        self.is_short(self.widest, threshold)
            || blocks_of(members).all(|block| self.is_short(self.seen.widths[block], threshold))
    }

    /// Whether so many rings rest around all points of the block that begins with a point.
    fn block_rests(&self, first: usize, rings: u8) -> bool {
        self.seen.rings[first / BLOCK] >= rings
    }

    /// The same around the members of a group.
    fn group_rests(&self, members: &[u32], rings: u8) -> bool {
        self.any_rests && blocks_of(members).all(|block| self.seen.rings[block] >= rings)
    }

    /// Whether no bond is to be looked at whose ends have moved apart by no more than that.
    fn is_short(&self, width: f64, threshold: f64) -> bool {
        // (l/L)^2 - 1 is no more than t (2 + t) at a relative displacement t of L; with room for rounding.
        let most = width / self.calm.shortest;
        self.skips.stretch_tests && 1.001 * most * (2.0 + most) + 1e-12 < threshold
    }
}

/// What a look tells of the points of a sweep, if one was taken: the force on a point is 0 where so many rings around it rest.
#[derive(Clone, Copy)]
pub(super) struct Resting<'a> {
    look: Option<&'a Look<'a>>,
    /// `None` where a body at rest may have forces.
    rings: Option<u8>,
}

impl<'a> Resting<'a> {
    /// Nothing.
    pub(super) const NEVER: Self = Self { look: None, rings: None };

    pub(super) fn new(look: Option<&'a Look<'a>>, rings: Option<u8>) -> Self {
        Self { look, rings }
    }

    /// What it tells, and how many rings are to rest where so many sweeps come after one that has nothing to do.
    fn asked(&self, sweeps: u8) -> Option<(&'a Look<'a>, u8)> {
        Some((self.look?, self.rings? + sweeps))
    }

    /// Whether a sweep with so many sweeps after it has nothing to do for the block that begins with a point.
    pub(super) fn block(&self, first: usize, sweeps: u8) -> bool {
        self.asked(sweeps).is_some_and(|(look, rings)| look.block_rests(first, rings))
    }

    /// The same for the members of a group.
    pub(super) fn group(&self, members: &[u32], sweeps: u8) -> bool {
        self.asked(sweeps).is_some_and(|(look, rings)| look.group_rests(members, rings))
    }

    /// Whether no bond of the block that begins with a point can have come to a limit that all share.
    pub(super) fn is_short(&self, first: usize, threshold: Option<f64>) -> bool {
        let (Some(look), Some(threshold)) = (self.look, threshold) else { return false };
        look.block_is_short(first, threshold)
    }

    /// The same of the bonds of the members of a group.
    pub(super) fn group_is_short(&self, members: &[u32], threshold: f64) -> bool {
        self.look.is_some_and(|look| look.group_is_short(members, threshold))
    }
}

/// The blocks of a group's members: most are of the same block as the one before.
fn blocks_of(members: &[u32]) -> impl Iterator<Item = usize> {
    let mut last = usize::MAX;
    let blocks = members.iter().filter(|&&member| member != NOBODY);
    let blocks = blocks.map(|&member| member as usize / BLOCK);
    blocks.filter(move |&block| std::mem::replace(&mut last, block) != block)
}

/// How far points of these blocks can have moved apart.
fn width(extents: &[Extent], blocks: &[u32]) -> f64 {
    let mut all = Extent::NOTHING;
    blocks.iter().for_each(|&block| all.join(&extents[block as usize]));
    let sides = all.0.map(|[low, high]| if high >= low { high - low } else { 0.0 });
    let longest = sides.iter().fold(0.0, |longest, side| f64::max(longest, *side));
    if longest == 0.0 || longest == f64::INFINITY {
        return longest;
    }
    // Squares of the least numbers are 0.
    longest * sides.iter().map(|side| (side / longest).powi(2)).sum::<f64>().sqrt()
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

#[cfg(test)]
mod tests {
    use super::*;

    fn calm(shortest: f64, moved: &[[f64; 2]]) -> Calm {
        // Blocks in a row, each with the next.
        let (mut near, last) = (Lists::default(), moved.len() - 1);
        for number in 0..moved.len() {
            near.blocks.extend(number.saturating_sub(1) as u32..=(number + 1).min(last) as u32);
            near.close().unwrap();
        }
        let extents: Vec<_> =
            moved.iter().map(|&ends| Extent([ends, [0.0; 2], [0.0; 2]])).collect();
        let widths = (0..moved.len()).map(|number| width(&extents, near.of(number))).collect();
        let seen = Mutex::new(Seen { extents, widths, rings: vec![0; moved.len()] });
        Calm { near, shortest, most_rings: 3, seen }
    }

    fn look(calm: &Calm) -> Look<'_> {
        calm.judge(Skips::default(), calm.seen.lock().unwrap())
    }

    #[test]
    fn rings_are_counted_around_what_rests() {
        let mut moved = [[0.5; 2]; 8];
        moved[7] = [0.5, 0.6];
        let calm = calm(1.0, &moved);
        assert_eq!(look(&calm).seen.rings, [3, 3, 3, 3, 2, 1, 0, 0]);
        let rest = [2, 3].map(|rings| look(&calm).block_rests(4 * BLOCK, rings));
        assert_eq!(rest, [true, false]);
        let members = |blocks: [u32; 2]| blocks.map(|block| block * BLOCK as u32 + 3);
        let group = |blocks, rings| look(&calm).group_rests(&members(blocks), rings);
        assert_eq!([group([3, 4], 2), group([3, 4], 3), group([4, 6], 1)], [true, false, false]);
        assert!(look(&calm).group_rests(&[NOBODY, 0], 3));
    }

    #[test]
    fn a_block_rests_where_all_it_leads_to_has_moved_alike() {
        let calm = calm(1.0, &[[0.5, 0.5], [0.5, 0.5], [0.5, 0.5], [0.5, 0.6], [0.0, 0.0]]);
        let look = look(&calm);
        let rests = [0, 1, 2, 3, 4].map(|block| look.block_rests(block * BLOCK, 1));
        assert_eq!(rests, [true, true, false, false, false]);
    }

    #[test]
    fn the_stretch_test_is_left_out_only_where_it_cannot_fire() {
        let calm = calm(2.0, &[[0.0, 0.1], [0.0, 0.02], [0.0, 0.02]]);
        let look = look(&calm);
        // A stretch of 0.05 in the first two, of 0.01 in the last.
        for (threshold, short) in [(0.1027, true), (0.1024, false), (0.0202, false)] {
            assert_eq!(look.block_is_short(0, threshold), short);
        }
        assert!(look.block_is_short(2 * BLOCK, 0.0202));
        assert!(!look.block_is_short(2 * BLOCK, 0.0200));
    }

    #[test]
    fn what_is_no_number_neither_rests_nor_is_short() {
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in 0..6 {
                let mut vectors = [0.0; 6];
                vectors[place] = odd;
                let extent = Extent::of::<2, 4>(&vectors);
                let calm = calm(1.0, &[extent.0[0]]);
                let look = look(&calm);
                assert!(!look.block_rests(0, 1) && !look.block_is_short(0, f64::MAX));
            }
        }
        let extent = Extent::of::<2, 4>(&[1.0, 2.0, 4.0, 1.0, -1.0, 3.0]);
        assert_eq!(extent.0[..2], [[-1.0, 4.0], [1.0, 3.0]]);
    }
}
