//! Families: which points pull on which, in blocks of eight bonds.
//!
//! Needs places and horizons. Gives, for each point, the points within its own horizon or within
//! whose horizon it lies: each bond stands in the list of both its ends.

mod cells;
pub(crate) mod crack;
mod grid;
pub(crate) mod lattice;
mod search;

use std::ops::Range;

use crate::kernel::simd::Unit;
use crate::memory;
use lattice::{Lattice, NOBODY};
pub(crate) use search::{Wanted, find};

/// Bonds that stand, are masked and are computed together.
pub(crate) const LANES: usize = 8;

/// Where a point is, relative to the body's centre, and its volume: x, y, z, V.
pub(crate) type Place = [f64; 4];

/// A per-point constant, stored once where all points share it.
#[derive(Debug)]
pub(crate) enum Property {
    Uniform(f64),
    PerPoint(Vec<f64>),
}

impl Property {
    #[inline(always)]
    pub(crate) fn at(&self, point: usize) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::PerPoint(values) => values[point],
        }
    }

    /// The largest.
    fn largest(&self) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::PerPoint(values) => values.iter().copied().fold(0.0, f64::max),
        }
    }

    pub(crate) fn copied(&self) -> crate::error::Result<Self> {
        Ok(match self {
            Self::Uniform(value) => Self::Uniform(*value),
            Self::PerPoint(values) => {
                Self::PerPoint(memory::copied(values, "constants of points")?)
            }
        })
    }

    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::PerPoint(values) => memory::bytes(values),
        }
    }
}

/// How lengths of bonds are had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Storage {
    /// They are kept.
    Fast,
    /// They are computed from the places of both ends whenever they are needed.
    Lean,
}

/// All bonds of a body, each at both its ends.
///
/// The bonds of a point fill whole blocks of [`LANES`]. Members of a lattice have a lane for each step of the stencil, whether a
/// bond is there or not, and nothing else is kept of their bonds. Those of other points are listed; lanes of lists without a
/// bond name the point itself as their neighbour and have length 1, so that they can be computed along and masked.
#[derive(Debug)]
pub(crate) struct Families {
    /// First block of each point, and the end.
    pub(crate) offsets: Vec<u64>,
    /// First block of each point's list, and the end, where not all points have one; empty where they are the blocks
    /// themselves.
    list_offsets: Vec<u64>,
    /// Inner place of the other end of each listed bond.
    pub(crate) neighbors: Vec<u32>,
    /// 1/L of each listed bond, of its length in the reference configuration; `None` where storage is lean.
    pub(crate) inverse_lengths: Option<Vec<f64>>,
    /// The least length of the bonds that were searched for; infinite without any.
    pub(crate) shortest: f64,
    /// Where the points are.
    pub(crate) places: Vec<Place>,
    /// In which lengths are near 1.
    pub(crate) unit: Unit,
    pub(crate) reach: Reach,
    /// The lattice that points of the body stand on, where kernels have a use for it.
    pub(crate) lattice: Option<Lattice>,
}

/// How far families reach, and how much of a neighbour's volume belongs to one.
#[derive(Debug)]
pub(crate) struct Reach {
    /// Length up to which a neighbour belongs to a point's own family, where families end sharply.
    radii: Property,
    /// Where they do not.
    rim: Option<Rim>,
}

/// The rim of a family: a neighbour there belongs to it with a part of its volume. With h the mean edge of both
/// points' cells that part is (horizon + h/2 - L)/h, where it is between 0 and 1.
#[derive(Debug)]
pub(crate) struct Rim {
    pub(crate) horizons: Property,
    /// Edge of each point's cell, V^(1/D).
    pub(crate) edges: Property,
}

impl Reach {
    /// Whether all bonds reach equally far and count alike.
    pub(crate) fn is_sharp_and_uniform(&self) -> bool {
        self.rim.is_none() && matches!(self.radii, Property::Uniform(_))
    }

    /// The length up to which there are bonds, where all reach equally far and count alike.
    pub(crate) fn uniform_radius(&self) -> Option<f64> {
        match (&self.rim, &self.radii) {
            (None, Property::Uniform(radius)) => Some(*radius),
            _ => None,
        }
    }

    /// Part of a neighbour's volume in a point's own family.
    #[inline(always)]
    pub(crate) fn share(&self, point: usize, neighbor: usize, length: f64) -> f64 {
        let Some(Rim { horizons, edges }) = &self.rim else {
            return f64::from(u8::from(length <= self.radii.at(point)));
        };
        let width = 0.5 * (edges.at(point) + edges.at(neighbor));
        ((horizons.at(point) + 0.5 * width - length) / width).clamp(0.0, 1.0)
    }

    fn bytes(&self) -> usize {
        let rim = self.rim.as_ref().map_or(0, |rim| rim.horizons.bytes() + rim.edges.bytes());
        self.radii.bytes() + rim
    }
}

/// Where the lanes of a point lead.
enum Lanes<'a> {
    /// Along the steps of the stencil, from the point's first lane and from its cell.
    Steps { lattice: &'a Lattice, first: usize, cell: usize },
    /// Along its list, which is so far ahead.
    List { ahead: usize },
}

/// One bond as seen from one of its ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bond {
    /// Where it stands among all lanes.
    pub(crate) slot: usize,
    pub(crate) neighbor: usize,
    pub(crate) length: f64,
}

impl Families {
    /// The blocks of a point.
    #[inline(always)]
    pub(crate) fn blocks(&self, point: usize) -> Range<usize> {
        self.offsets[point] as usize..self.offsets[point + 1] as usize
    }

    /// Where the bonds of a point are to be looked up.
    #[inline(always)]
    fn lanes(&self, point: usize) -> Lanes<'_> {
        let first = self.offsets[point] as usize * LANES;
        if let Some(lattice) = &self.lattice
            && let Some(cell) = lattice.member(point)
        {
            return Lanes::Steps { lattice, first, cell };
        }
        Lanes::List { ahead: (self.lists()[point] as usize * LANES).wrapping_sub(first) }
    }

    /// The bonds of a point, broken or not.
    pub(crate) fn bonds(&self, point: usize) -> impl Iterator<Item = Bond> + '_ {
        let (blocks, lanes) = (self.blocks(point), self.lanes(point));
        let slots = blocks.start * LANES..blocks.end * LANES;
        slots.filter_map(move |slot| self.bond(point, &lanes, slot))
    }

    /// A length that no bond is below, and the shortest is next to; infinite without any.
    pub(crate) fn shortest_bond(&self) -> f64 {
        // Points are off their crossings by next to nothing.
        let steps = self.lattice.iter().flat_map(|lattice| &lattice.stencil);
        let lengths = steps
            .map(|step| (1.0 - 1e-6) * step.reference.map(|x| x * x).iter().sum::<f64>().sqrt());
        lengths.fold(self.shortest, f64::min)
    }

    /// How many bonds a point has, broken or not.
    pub(crate) fn bond_count(&self, point: usize) -> usize {
        match self.lanes(point) {
            Lanes::Steps { .. } => self.bonds(point).count(),
            Lanes::List { .. } if self.blocks(point).is_empty() => 0,
            Lanes::List { ahead } => {
                (self.blocks(point).len() - 1) * LANES + self.bonds_in_last_block(point, ahead)
            }
        }
    }

    /// Whether a point has no bonds.
    pub(crate) fn is_alone(&self, point: usize) -> bool {
        match self.lanes(point) {
            Lanes::Steps { .. } => self.bonds(point).next().is_none(),
            Lanes::List { .. } => self.blocks(point).is_empty(),
        }
    }

    /// Bonds in the last block of a list that is so far ahead; only there may lanes have none.
    fn bonds_in_last_block(&self, point: usize, ahead: usize) -> usize {
        let end = (self.blocks(point).end * LANES).wrapping_add(ahead);
        let lanes = &self.neighbors[end - LANES..end];
        lanes.iter().filter(|&&neighbor| neighbor as usize != point).count()
    }

    /// The bonds of a point in the lanes that `masks` gives of each of its blocks.
    pub(crate) fn bonds_in(
        &self,
        point: usize,
        masks: impl Fn(usize) -> u8,
    ) -> impl Iterator<Item = Bond> {
        let lanes = self.lanes(point);
        let slots = self.blocks(point).flat_map(move |block| {
            let mask = masks(block);
            (0..LANES)
                .filter(move |lane| mask >> lane & 1 == 1)
                .map(move |lane| block * LANES + lane)
        });
        slots.filter_map(move |slot| self.bond(point, &lanes, slot))
    }

    /// The bond of a member of the lattice along a step of the stencil, if there is one.
    pub(crate) fn bond_along(&self, point: usize, step: usize) -> Option<Bond> {
        self.bond_at(point, self.blocks(point).start * LANES + step)
    }

    /// The bond that stands in a lane of a point, if there is one.
    pub(crate) fn bond_at(&self, point: usize, slot: usize) -> Option<Bond> {
        self.bond(point, &self.lanes(point), slot)
    }

    /// The bond that stands in a lane of a point. Its length has the same bits from both ends and for any storage.
    #[inline(always)]
    fn bond(&self, point: usize, lanes: &Lanes<'_>, slot: usize) -> Option<Bond> {
        let (neighbor, inverse) = match *lanes {
            Lanes::Steps { lattice, first, cell } => {
                let (neighbor, squared) = lattice.neighbor(&self.places, cell, slot - first)?;
                (neighbor, inverse_length(squared))
            }
            Lanes::List { ahead } => {
                let place = slot.wrapping_add(ahead);
                let neighbor = self.neighbors[place] as usize;
                if neighbor == point {
                    return None;
                }
                let squared = || squared_length(&self.places[point], &self.places[neighbor]);
                let inverses = self.inverse_lengths.as_ref();
                let inverse = inverses.map_or_else(|| inverse_length(squared()), |of| of[place]);
                (neighbor, inverse)
            }
        };
        Some(Bond { slot, neighbor, length: inverse.recip() })
    }

    /// First block of each point's list, and the end.
    #[inline(always)]
    pub(crate) fn lists(&self) -> &[u64] {
        if self.list_offsets.is_empty() { &self.offsets } else { &self.list_offsets }
    }

    /// The other ends of the bonds in a point's lanes from a slot on; of lanes without a bond any point.
    pub(crate) fn name(&self, point: usize, slot: usize, names: &mut [u32]) {
        match self.lanes(point) {
            Lanes::Steps { lattice, first, cell } => lattice.name(cell, slot - first, names),
            Lanes::List { ahead } => {
                let first = slot.wrapping_add(ahead);
                names.copy_from_slice(&self.neighbors[first..first + names.len()]);
            }
        }
    }

    /// Whether all points have lists of their bonds.
    pub(crate) fn are_listed(&self) -> bool {
        self.lattice.is_none()
    }

    /// Whether a point has: members of a lattice have none.
    pub(crate) fn is_listed(&self, point: usize) -> bool {
        self.lattice.as_ref().is_none_or(|lattice| lattice.seat_of[point] == NOBODY)
    }

    /// The bond from `point` to `neighbor`, if there is one.
    pub(crate) fn between(&self, point: usize, neighbor: usize) -> Option<Bond> {
        if point == neighbor {
            return None;
        }
        let lanes = self.lanes(point);
        let slot = match lanes {
            Lanes::Steps { lattice, first, cell } => first + lattice.step_to(cell, neighbor)?,
            Lanes::List { ahead } => {
                let blocks = self.blocks(point);
                let first = (blocks.start * LANES).wrapping_add(ahead);
                let list = &self.neighbors[first..first + blocks.len() * LANES];
                blocks.start * LANES + position(list.as_chunks().0, neighbor as u32)?
            }
        };
        self.bond(point, &lanes, slot)
    }

    /// Writes the masks of a point's blocks, in which all its bonds are.
    pub(crate) fn mark_bonds(&self, point: usize, masks: &mut [u8]) {
        match self.lanes(point) {
            Lanes::Steps { lattice, cell, .. } => lattice.mark_bonds(&self.places, cell, masks),
            Lanes::List { ahead } => {
                let Some((last, whole)) = masks.split_last_mut() else { return };
                whole.fill(u8::MAX);
                let bonds = self.bonds_in_last_block(point, ahead);
                *last = u8::MAX >> (LANES - bonds);
            }
        }
    }

    /// Part of the volume of a bond's other end that belongs to the point's own family.
    #[inline(always)]
    pub(crate) fn share(&self, point: usize, bond: Bond) -> f64 {
        self.reach.share(point, bond.neighbor, bond.length)
    }

    /// Whether the bond's other end belongs to the point's own family.
    #[inline(always)]
    pub(crate) fn owns(&self, point: usize, bond: Bond) -> bool {
        self.share(point, bond) > 0.0
    }

    /// Blocks of all points.
    pub(crate) fn block_count(&self) -> usize {
        self.offsets.last().map_or(0, |&end| end as usize)
    }

    /// Where the bond from `point` to `neighbor` stands, if there is one.
    pub(crate) fn slot(&self, point: usize, neighbor: usize) -> Option<usize> {
        self.between(point, neighbor).map(|bond| bond.slot)
    }

    pub(crate) fn bytes(&self) -> usize {
        memory::bytes(&self.offsets)
            + memory::bytes(&self.list_offsets)
            + memory::bytes(&self.neighbors)
            + self.inverse_lengths.as_ref().map_or(0, memory::bytes)
            + self.reach.bytes()
            + self.lattice.as_ref().map_or(0, Lattice::bytes)
    }
}

/// Where a name stands in a list, looked for block by block.
fn position(list: &[[u32; LANES]], name: u32) -> Option<usize> {
    list.iter().enumerate().find_map(|(block, names)| {
        let found = names.iter().rev().fold(0, |found, &at| found << 1 | u32::from(at == name));
        (found != 0).then(|| block * LANES + found.trailing_zeros() as usize)
    })
}

/// The square of the reference length of a bond; the same bits from both ends.
#[inline(always)]
pub(crate) fn squared_length(from: &Place, to: &Place) -> f64 {
    let (x, y, z) = (to[0] - from[0], to[1] - from[1], to[2] - from[2]);
    x * x + y * y + z * z
}

/// 1/L of a bond.
#[inline(always)]
fn inverse_length(squared: f64) -> f64 {
    squared.sqrt().recip()
}
