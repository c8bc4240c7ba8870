//! Damage: the integrity of bonds, what breaks them, and what of a point's family is lost. What materials remember
//! stands beside it.

mod critical_stretch;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::Result;
use crate::families::{Families, LANES, Place};
use crate::memory;
use crate::workers::{PerPoint, Ragged, Workers};
pub(crate) use critical_stretch::{BreakRule, Interface, close_to, stretch};

const PURPOSE: &str = "bond state";

/// The integrity of every bond: 1 intact, 0 broken, between for bonds that the host has weakened.
///
/// A bond keeps its place; a broken one is masked. Both its ends hold the same integrity.
#[derive(Debug)]
pub(crate) struct BondState {
    /// One bit a lane: the bond exists and is not broken.
    pub(crate) intact: Vec<u8>,
    /// The name of the masks: others have other names.
    edition: u64,
    /// Integrity of each lane, where the host has set any.
    pub(crate) integrity: Option<Vec<f64>>,
    /// The name of the integrities: others have other names, and none have 0.
    grades: u64,
    /// Records of the laws with memory, of the last committed state; empty where no law has one.
    pub(crate) records: Vec<f64>,
}

/// A name that no masks have had.
fn next_edition() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

/// What a request has changed and may have to give back.
type Kept = (Vec<u8>, Option<Vec<f64>>);

impl BondState {
    /// All bonds intact, and nothing in so many numbers of records.
    pub(crate) fn new(workers: &Workers, families: &Families, records: usize) -> Result<Self> {
        let mut intact = workers.filled(0, families.block_count(), PURPOSE)?;
        let offsets = &families.offsets;
        let masks = Ragged { values: &mut intact[..], offsets, width: 1 };
        workers.sweep(families.places.len(), masks, |range, masks| {
            let first = families.blocks(range.start).start;
            for point in range {
                let blocks = families.blocks(point);
                let masks = &mut masks.values[blocks.start - first..blocks.end - first];
                families.mark_bonds(point, masks);
            }
        });
        let records = workers.filled(0.0, records, "the memory of materials")?;
        Ok(Self { intact, edition: next_edition(), integrity: None, grades: 0, records })
    }

    pub(crate) fn try_clone(&self) -> Result<Self> {
        Ok(Self {
            intact: memory::copied(&self.intact, PURPOSE)?,
            edition: self.edition,
            grades: self.grades,
            integrity: match &self.integrity {
                Some(values) => Some(memory::copied(values, PURPOSE)?),
                None => None,
            },
            records: memory::copied(&self.records, "the memory of materials")?,
        })
    }

    /// Bits and integrities, where a law may stop the call that changes them.
    pub(crate) fn kept_for_a_stop(&self) -> Result<Option<Kept>> {
        if self.records.is_empty() {
            return Ok(None);
        }
        let mut intact = memory::reserved(self.intact.len(), PURPOSE)?;
        intact.extend_from_slice(&self.intact);
        let mut integrity = None;
        if let Some(values) = &self.integrity {
            let mut copy = memory::reserved(values.len(), PURPOSE)?;
            copy.extend_from_slice(values);
            integrity = Some(copy);
        }
        Ok(Some((intact, integrity)))
    }

    /// Is again as it was kept.
    pub(crate) fn take_back(&mut self, kept: Option<Kept>) {
        if let Some((intact, integrity)) = kept {
            self.edition = next_edition();
            self.grades = if integrity.is_some() { next_edition() } else { 0 };
            (self.intact, self.integrity) = (intact, integrity);
        }
    }

    pub(crate) fn is_intact(&self, slot: usize) -> bool {
        self.view().is_intact(slot)
    }

    pub(crate) fn break_bond(&mut self, slot: usize) {
        self.intact[slot / LANES] &= !(1 << (slot % LANES));
        self.edition = next_edition();
    }

    /// Ends of bonds that are not broken.
    pub(crate) fn count(&self) -> u64 {
        self.intact.iter().map(|mask| u64::from(mask.count_ones())).sum()
    }

    /// Integrity of a bond, 0 where it is broken.
    pub(crate) fn integrity(&self, slot: usize) -> f64 {
        if !self.is_intact(slot) {
            return 0.0;
        }
        self.integrity.as_ref().map_or(1.0, |values| values[slot])
    }

    /// Whether bonds have an integrity of their own.
    pub(crate) fn is_graded(&self) -> bool {
        self.integrity.is_some()
    }

    /// Makes room for integrities between 0 and 1.
    pub(crate) fn grade(&mut self) -> Result<()> {
        if self.integrity.is_none() {
            let lanes = self.intact.len() * LANES;
            self.integrity = Some(memory::filled(1.0, lanes, PURPOSE)?);
            self.grades = next_edition();
        }
        Ok(())
    }

    /// Sets a bond's integrity. Needs [`BondState::grade`] for values between 0 and 1.
    pub(crate) fn weaken(&mut self, slot: usize, value: f64) {
        if value == 0.0 {
            self.break_bond(slot);
        } else {
            self.intact[slot / LANES] |= 1 << (slot % LANES);
            self.edition = next_edition();
            if let Some(values) = &mut self.integrity {
                values[slot] = value;
                self.grades = next_edition();
            }
        }
    }

    /// Takes over what materials remember after a sweep for forces, which leaves it in front of its scratch.
    pub(crate) fn keep_records(&mut self, scratch: &[f64]) {
        let count = self.records.len();
        self.records.copy_from_slice(&scratch[..count]);
    }

    /// The state as it is, to read from.
    pub(crate) fn view(&self) -> BondsView<'_> {
        let Self { intact, edition, integrity, grades, records } = self;
        let (edition, grades) = (*edition, *grades);
        BondsView { intact, edition, integrity: integrity.as_deref(), grades, records }
    }

    pub(crate) fn bytes(&self) -> usize {
        memory::bytes(&self.intact)
            + self.integrity.as_ref().map_or(0, memory::bytes)
            + memory::bytes(&self.records)
    }
}

/// Integrity of all bonds, to read from.
#[derive(Clone, Copy)]
pub(crate) struct BondsView<'a> {
    pub(crate) intact: &'a [u8],
    /// Masks of the same edition are the same.
    pub(crate) edition: u64,
    pub(crate) integrity: Option<&'a [f64]>,
    /// Integrities of the same name are the same.
    pub(crate) grades: u64,
    pub(crate) records: &'a [f64],
}

impl BondsView<'_> {
    pub(crate) fn is_intact(&self, slot: usize) -> bool {
        self.intact[slot / LANES] >> (slot % LANES) & 1 == 1
    }
}

const _: () = assert!(LANES == u8::BITS as usize, "a mask holds one bit a lane");

/// What a sweep needs to break bonds: the rule, and where it writes what it found.
pub(crate) struct Breaking<'a> {
    pub(crate) rule: &'a BreakRule,
    /// The masks as they are, of which the sweep takes the bonds that break.
    pub(crate) intact: &'a mut [u8],
    /// The name of these masks, should any bond break.
    pub(crate) edition: u64,
    /// Whether any has broken.
    pub(crate) broke: &'a AtomicBool,
    /// Energy per volume that each point has lost by breaking bonds so far; added to.
    pub(crate) dissipated: &'a mut [f64],
    /// Displacement at the beginning of the step, where there is one: a bond that breaks has pulled last
    /// then, and so has given E s_n/s_{n+1} of what it would hold now.
    pub(crate) before: Option<&'a [f64]>,
}

impl Breaking<'_> {
    pub(crate) fn has_broken(&self) -> bool {
        self.broke.load(Ordering::Relaxed)
    }

    /// The masks, to be shared out, and what is told when any bond breaks.
    pub(crate) fn shared<'a>(
        &'a mut self,
        families: &'a Families,
    ) -> (Ragged<'a, u8>, &'a AtomicBool) {
        (Ragged { values: self.intact, offsets: &families.offsets, width: 1 }, self.broke)
    }

    /// The bonds that are left of those before the sweep.
    pub(crate) fn left_of<'a>(&'a self, bonds: BondsView<'a>) -> BondsView<'a> {
        let edition = if self.has_broken() { self.edition } else { bonds.edition };
        BondsView { intact: self.intact, edition, ..bonds }
    }
}

/// Masks and losses aside, in which a sweep breaks bonds. While none break they are those of the state, and nothing is to
/// be copied or compared.
#[derive(Debug)]
pub(crate) struct Aside {
    intact: Vec<u8>,
    dissipated: Vec<f64>,
    /// Of the masks, and of the losses that go with them.
    edition: u64,
    broke: AtomicBool,
}

impl Aside {
    /// With room for the masks of the bonds and the losses of so many points.
    pub(crate) fn new(workers: &Workers, masks: usize, points: usize) -> Result<Self> {
        Ok(Self {
            intact: workers.filled(0, masks, PURPOSE)?,
            dissipated: workers.filled(0.0, points, PURPOSE)?,
            edition: next_edition(),
            broke: AtomicBool::new(false),
        })
    }

    /// What a sweep needs in which the rule breaks some of these bonds, from what points have lost so far.
    pub(crate) fn breaking<'a>(
        &'a mut self,
        workers: &Workers,
        rule: &'a BreakRule,
        (bonds, dissipated): (&BondState, &[f64]),
        before: Option<&'a [f64]>,
    ) -> Breaking<'a> {
        if self.edition != bonds.edition {
            workers.copy(&bonds.intact, &mut self.intact);
            workers.copy(dissipated, &mut self.dissipated);
        }
        // Until the sweep is over it is not known what is held.
        self.edition = next_edition();
        *self.broke.get_mut() = false;
        let Self { intact, dissipated, edition, broke } = self;
        Breaking { rule, intact, edition: *edition, broke, dissipated, before }
    }

    /// After a sweep: makes what it has left the state, and tells whether any bond has broken.
    pub(crate) fn accept(&mut self, bonds: &mut BondState, dissipated: &mut Vec<f64>) -> bool {
        let broke = *self.broke.get_mut();
        if broke {
            std::mem::swap(&mut bonds.intact, &mut self.intact);
            std::mem::swap(&mut bonds.edition, &mut self.edition);
            std::mem::swap(dissipated, &mut self.dissipated);
        } else {
            self.edition = bonds.edition;
        }
        broke
    }

    /// Has the next sweep copy the state, whose losses have changed.
    pub(crate) fn forget(&mut self) {
        self.edition = next_edition();
    }

    pub(crate) fn bytes_of_masks(&self) -> usize {
        memory::bytes(&self.intact)
    }

    pub(crate) fn bytes_of_losses(&self) -> usize {
        memory::bytes(&self.dissipated)
    }
}

/// D_i = 1 - sum d_ij V_j / sum V_j over each point's own family; 0 for a point without one.
pub(crate) fn point_damage(
    workers: &Workers,
    families: &Families,
    places: &[Place],
    bonds: &BondState,
    damage: &mut [f64],
) {
    workers.sweep(places.len(), PerPoint(damage, 1), |range, damage| {
        for (value, point) in damage.0.iter_mut().zip(range) {
            let (mut held, mut whole) = (0.0, 0.0);
            for bond in families.bonds(point).filter(|bond| families.owns(point, *bond)) {
                let volume = families.share(point, bond) * places[bond.neighbor][3];
                whole += volume;
                held += bonds.integrity(bond.slot) * volume;
            }
            *value = if whole > 0.0 { 1.0 - held / whole } else { 0.0 };
        }
    });
}
