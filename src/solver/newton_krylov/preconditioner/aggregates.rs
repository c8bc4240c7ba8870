//! Points taken together: each group moves as a rigid body on the next coarser level.

use crate::error::Result;
use crate::memory;
use crate::solver::balance::PURPOSE;
use crate::tensor::{Vector, dot};

use super::bond_stiffness::apart;

const NONE: u32 = u32::MAX;

pub(super) struct Aggregates<const D: usize> {
    /// Group of each member.
    pub(super) of: Vec<u32>,
    pub(super) centres: Vec<Vector<D>>,
    /// Members by group: those of group a are `members[starts[a]..starts[a + 1]]`.
    pub(super) members: Vec<u32>,
    pub(super) starts: Vec<usize>,
}

impl<const D: usize> Aggregates<D> {
    /// Goes over the places in order: one around which nothing is grouped yet takes in what `near` shows; the others
    /// then join a group near to them.
    pub(super) fn new(
        places: &[Vector<D>],
        near: impl Fn(usize, &mut dyn FnMut(usize)),
    ) -> Result<Self> {
        let mut of = memory::filled(NONE, places.len(), PURPOSE)?;
        let mut count = 0;
        for root in 0..places.len() {
            let mut alone = of[root] == NONE;
            near(root, &mut |other| alone &= of[other] == NONE);
            if alone {
                of[root] = count;
                near(root, &mut |other| of[other] = count);
                count += 1;
            }
        }
        let roots = memory::copied(&of, PURPOSE)?;
        for place in 0..places.len() {
            if of[place] == NONE {
                let mut closest = f64::INFINITY;
                near(place, &mut |other| {
                    let apart = apart(&places[place], &places[other]);
                    let squared = dot(&apart, &apart);
                    if roots[other] != NONE && squared < closest {
                        (closest, of[place]) = (squared, roots[other]);
                    }
                });
                if of[place] == NONE {
                    of[place] = count;
                    count += 1;
                }
            }
        }
        let groups = count as usize;
        let mut starts = memory::filled(0, groups + 1, PURPOSE)?;
        let mut centres = memory::filled([0.0; D], groups, PURPOSE)?;
        for (place, &group) in places.iter().zip(&of) {
            starts[group as usize + 1] += 1;
            for axis in 0..D {
                centres[group as usize][axis] += place[axis];
            }
        }
        for group in 0..groups {
            let size = starts[group + 1] as f64;
            centres[group].iter_mut().for_each(|value| *value /= size);
            starts[group + 1] += starts[group];
        }
        let mut filled = memory::copied(&starts, PURPOSE)?;
        let mut members = memory::filled(0, places.len(), PURPOSE)?;
        for (member, &group) in of.iter().enumerate() {
            let place = &mut filled[group as usize];
            members[*place] = member as u32;
            *place += 1;
        }
        Ok(Self { of, centres, members, starts })
    }

    pub(super) fn count(&self) -> usize {
        self.centres.len()
    }

    pub(super) fn members(&self, group: usize) -> &[u32] {
        &self.members[self.starts[group]..self.starts[group + 1]]
    }
}

/// What a place at an offset from the centre of its group does in each of the rigid modes, translations first. `scale`,
/// a length, makes turns comparable with them.
#[inline(always)]
pub(super) fn modes<const D: usize, const B: usize>(
    offset: &Vector<D>,
    scale: f64,
) -> [Vector<D>; B] {
    let mut modes = [[0.0; D]; B];
    for (axis, mode) in modes.iter_mut().take(D).enumerate() {
        mode[axis] = 1.0;
    }
    if D == 2 {
        modes[2][0] = -offset[1] / scale;
        modes[2][1] = offset[0] / scale;
    } else {
        for turn in 0..3 {
            let (next, last) = ((turn + 1) % 3, (turn + 2) % 3);
            modes[3 + turn][next] = -offset[last] / scale;
            modes[3 + turn][last] = offset[next] / scale;
        }
    }
    modes
}
