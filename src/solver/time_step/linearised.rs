//! The operator whose eigenvalues are the squares of a body's frequencies.

use super::{NOT_FINITE, PURPOSE};
use crate::damage::BondState;
use crate::error::{Error, Result};
use crate::families::Property;
use crate::memory;
use crate::plan::Plan;
use crate::solver::space::{Space, largest};
use crate::workers::{PerPoint, Workers};

/// Differences move points by this share of the shortest bond.
const MOVE: f64 = 1e-6;

/// How much of a start is without order, beside a mode that is known: everywhere, and where bonds are broken.
const ANYWHERE: f64 = 0.05;
const AT_DAMAGE: f64 = 0.3;

/// A v = -(b(u + h v) - b(u))/(h rho): bonds as they are, and nothing flows.
pub(super) struct Linearised<'a> {
    pub(super) plan: &'a Plan,
    workers: &'a Workers,
    bonds: &'a BondState,
    displacement: &'a [f64],
    scratch: &'a mut [f64],
    /// Mass per volume.
    density: &'a Property,
    shortest: f64,
    base: Vec<f64>,
    moved: Vec<f64>,
    space: Space<'a>,
}

impl<'a> Linearised<'a> {
    pub(super) fn new(
        plan: &'a Plan,
        workers: &'a Workers,
        bonds: &'a BondState,
        displacement: &'a [f64],
        scratch: &'a mut [f64],
        density: &'a Property,
    ) -> Result<Self> {
        let shortest = plan.families.shortest_bond();
        let mut operator = Self {
            plan,
            workers,
            bonds,
            displacement,
            scratch,
            density,
            shortest,
            base: memory::filled(0.0, displacement.len(), PURPOSE)?,
            moved: memory::copied(displacement, PURPOSE)?,
            space: Space::new(workers, plan.count(), plan.dimension, PURPOSE)?,
        };
        let mut base = std::mem::take(&mut operator.base);
        operator.force(&mut base)?;
        operator.base = base;
        Ok(operator)
    }

    fn force(&mut self, force: &mut [f64]) -> Result<()> {
        let scene = self.plan.scene(self.workers, self.bonds, &self.moved);
        let scene = crate::formulation::Scene { flows: false, ..scene };
        match self.plan.formulation.force(&scene, self.scratch, force, None) {
            None => Ok(()),
            Some(_) => Err(Error::Numeric(NOT_FINITE.into())),
        }
    }

    pub(super) fn empty(&self) -> Result<Vec<f64>> {
        memory::filled(0.0, self.displacement.len(), PURPOSE)
    }

    /// v^T M w, over the mass of the first point: then units that are powers of two change no bit.
    pub(super) fn dot(&mut self, v: &[f64], w: &[f64]) -> f64 {
        let (plan, density) = (self.plan, self.density);
        let mass = |point: usize| density.at(point) * plan.places()[point][3];
        self.space.weighted_dot(v, w, mass) / mass(0)
    }

    /// Makes v of size 1, if it has any.
    pub(super) fn normalise(&mut self, v: &mut [f64]) {
        let size = self.dot(v, v).sqrt();
        if size > 0.0 {
            v.iter_mut().for_each(|value| *value /= size);
        }
    }

    /// v = own v + factor w
    pub(super) fn combine(&self, v: &mut [f64], own: f64, factor: f64, w: &[f64]) {
        self.space.combine(v, own, factor, w);
    }

    /// A v
    pub(super) fn multiply(&mut self, v: &[f64], product: &mut [f64]) -> Result<()> {
        let reach = largest(v);
        let step = MOVE * self.shortest / reach;
        if !step.is_finite() {
            product.fill(0.0);
            return Ok(());
        }
        let mut moved = std::mem::take(&mut self.moved);
        moved.copy_from_slice(self.displacement);
        self.combine(&mut moved, 1.0, step, v);
        self.moved = moved;
        self.force(product)?;
        let (plan, base, density) = (self.plan, &self.base, self.density);
        let dimension = plan.dimension;
        self.workers.sweep(plan.count(), PerPoint(product, dimension), |range, product| {
            for (place, point) in range.clone().enumerate() {
                let scale = -1.0 / (step * density.at(point));
                for axis in 0..dimension {
                    let value = &mut product.0[place * dimension + axis];
                    *value = (*value - base[point * dimension + axis]) * scale;
                }
            }
        });
        Ok(())
    }

    /// Where to start from: the mode where one is known, and numbers without order, that follow from the inner order
    /// alone; most of them where bonds are broken, since modes that were not there before are there.
    pub(super) fn start(&mut self, mode: Option<&[f64]>) -> Result<Vec<f64>> {
        let mut anywhere = self.empty()?;
        for (component, value) in anywhere.iter_mut().enumerate() {
            let word = (component as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (word ^ word >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
            *value = mixed as f64 / (1_u64 << 53) as f64 - 0.5;
        }
        let Some(mode) = mode else {
            self.normalise(&mut anywhere);
            return Ok(anywhere);
        };
        let (plan, dimension) = (self.plan, self.plan.dimension);
        let mut at_damage = memory::copied(&anywhere, PURPOSE)?;
        for (point, value) in at_damage.chunks_exact_mut(dimension).enumerate() {
            let lost = plan.families.bonds(point).any(|bond| !self.bonds.is_intact(bond.slot));
            if !lost {
                value.fill(0.0);
            }
        }
        let mut start = memory::copied(mode, PURPOSE)?;
        self.normalise(&mut anywhere);
        self.normalise(&mut at_damage);
        self.combine(&mut start, 1.0, ANYWHERE, &anywhere);
        self.combine(&mut start, 1.0, AT_DAMAGE, &at_damage);
        self.normalise(&mut start);
        Ok(start)
    }
}
