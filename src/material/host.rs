//! The host's own law: a function that is asked in batches, on the thread that drives the simulation.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::{ENERGY, MEMORY, PENDING};
use crate::error::Result;
use crate::memory;

/// Deformations that a law of the host's is asked, and where it answers. Tensors have D x D numbers, row after row; D is
/// the dimension of the body.
#[derive(Debug)]
pub struct MaterialBatch<'a> {
    /// Number of deformations.
    pub count: usize,
    /// Deformation gradients of the last committed state, F_ij = dx_i/dX_j.
    pub before: &'a [f64],
    /// Deformation gradients to answer.
    pub now: &'a [f64],
    /// What the material remembers of the committed state; all 0 at first.
    pub state_before: &'a [f64],
    /// What it will remember if `now` is committed.
    pub state: &'a mut [f64],
    /// First Piola-Kirchhoff stress of each.
    pub stress: &'a mut [f64],
    /// Stored energy per reference volume of each.
    pub energy: &'a mut [f64],
}

type Function = dyn Fn(&mut MaterialBatch<'_>) -> ControlFlow<()> + Send + Sync;

/// A law of the host's with the numbers it remembers at a place.
#[derive(Clone)]
pub(crate) struct HostLaw {
    pub(crate) state_size: usize,
    pub(crate) function: Arc<Function>,
}

impl std::fmt::Debug for HostLaw {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "a function with {} numbers of state", self.state_size)
    }
}

/// Most deformations in a batch.
const BATCH: usize = 256;

/// What a batch is made in.
pub(crate) struct Room {
    dimension: usize,
    /// Numbers of a record: behind F - I it keeps the state.
    width: usize,
    before: Vec<f64>,
    now: Vec<f64>,
    state_before: Vec<f64>,
    state: Vec<f64>,
    stress: Vec<f64>,
    energy: Vec<f64>,
    /// Where each goes.
    sites: Vec<usize>,
}

impl Room {
    pub(crate) fn new(dimension: usize, width: usize, state_size: usize) -> Result<Self> {
        let (tensors, states) = (BATCH * dimension * dimension, BATCH * state_size);
        let room = |count| memory::filled(0.0, count, "the material's function");
        Ok(Self {
            dimension,
            width,
            before: room(tensors)?,
            now: room(tensors)?,
            state_before: room(states)?,
            state: room(states)?,
            stress: room(tensors)?,
            energy: room(BATCH)?,
            sites: memory::reserved(BATCH, "the material's function")?,
        })
    }

    /// Asks `law` all records that wait for it. `old`: those of the committed state.
    pub(crate) fn ask(
        &mut self,
        law: &HostLaw,
        sites: impl Iterator<Item = usize>,
        old: &[f64],
        new: &mut [f64],
    ) -> ControlFlow<()> {
        for site in sites {
            let from = site * self.width;
            if new[from + PENDING] == 0.0 {
                continue;
            }
            self.take(law, site, &old[from..], &new[from..]);
            if self.sites.len() == BATCH {
                self.answer(law, new)?;
            }
        }
        self.answer(law, new)
    }

    fn take(&mut self, law: &HostLaw, site: usize, old: &[f64], new: &[f64]) {
        let (place, square) = (self.sites.len(), self.dimension * self.dimension);
        self.sites.push(site);
        for (gradients, record) in [(&mut self.before, old), (&mut self.now, new)] {
            let moved = &record[MEMORY..MEMORY + square];
            let gradients = &mut gradients[place * square..(place + 1) * square];
            gradients.copy_from_slice(moved);
            for axis in 0..self.dimension {
                gradients[axis * (self.dimension + 1)] += 1.0;
            }
        }
        let state = MEMORY + 9..MEMORY + 9 + law.state_size;
        let own = place * law.state_size..(place + 1) * law.state_size;
        self.state_before[own].copy_from_slice(&old[state]);
    }

    /// Lets the function answer what has been taken.
    fn answer(&mut self, law: &HostLaw, new: &mut [f64]) -> ControlFlow<()> {
        let count = self.sites.len();
        if count == 0 {
            return ControlFlow::Continue(());
        }
        let (dimension, size) = (self.dimension, law.state_size);
        let square = dimension * dimension;
        // What it leaves out is not a number.
        self.stress[..count * square].fill(f64::NAN);
        self.energy[..count].fill(f64::NAN);
        self.state[..count * size].copy_from_slice(&self.state_before[..count * size]);
        (law.function)(&mut MaterialBatch {
            count,
            before: &self.before[..count * square],
            now: &self.now[..count * square],
            state_before: &self.state_before[..count * size],
            state: &mut self.state[..count * size],
            stress: &mut self.stress[..count * square],
            energy: &mut self.energy[..count],
        })?;
        for (place, site) in self.sites.drain(..).enumerate() {
            let record = &mut new[site * self.width..(site + 1) * self.width];
            for row in 0..dimension {
                let from = place * square + row * dimension;
                let stress = &self.stress[from..from + dimension];
                record[3 * row..3 * row + dimension].copy_from_slice(stress);
            }
            record[ENERGY] = self.energy[place];
            record[PENDING] = 0.0;
            let state = MEMORY + 9;
            record[state..state + size]
                .copy_from_slice(&self.state[place * size..(place + 1) * size]);
        }
        ControlFlow::Continue(())
    }

    /// Forgets what was taken and not answered.
    pub(crate) fn clear(&mut self) {
        self.sites.clear();
    }
}
