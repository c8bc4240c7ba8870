//! The balance of forces of a body at rest: r = V (b(u) + b_ext), a force, 0 where displacements are prescribed.

use super::space::Space;
use crate::damage::BondState;
use crate::error::{Error, Result};
use crate::memory;
use crate::plan::Plan;
use crate::workers::{PerPoint, Workers};

pub(crate) const PURPOSE: &str = "equilibrium";

/// Differences move points by at least this share of the shortest bond.
const MOVE: f64 = 2e-7;

/// A body under loads, some components of which are held.
pub(crate) struct Balance<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) space: Space<'a>,
    pub(crate) bonds: &'a BondState,
    pub(crate) scratch: &'a mut [f64],
    /// Components whose displacement is prescribed.
    pub(crate) held: &'a [bool],
    /// Body force per volume.
    pub(crate) load: &'a [f64],
    /// Length of the shortest bond.
    shortest: f64,
    /// Forces evaluated so far.
    pub(crate) evaluations: u64,
    moved: Vec<f64>,
    other: Vec<f64>,
    /// V b of the last residual.
    pub(crate) forces: Vec<f64>,
}

/// What can end an evaluation besides its result.
pub(crate) enum Stop {
    /// The force on a point, by its inner place, is not finite.
    NotFinite(usize),
    /// The call is over.
    Error(Error),
}

/// The result of what evaluates forces.
pub(crate) type Trial<T> = std::result::Result<T, Stop>;

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

/// What stands in a balance.
pub(crate) struct Under<'a> {
    pub(crate) held: &'a [bool],
    pub(crate) load: &'a [f64],
}

impl<'a> Balance<'a> {
    pub(crate) fn new(
        plan: &'a Plan,
        workers: &'a Workers,
        bonds: &'a BondState,
        scratch: &'a mut [f64],
        under: &Under<'a>,
    ) -> Result<Self> {
        let space = Space::new(workers, plan.count(), plan.dimension, PURPOSE)?;
        let Under { held, load } = *under;
        let (shortest, components) = (plan.families.shortest_bond(), held.len());
        let moved = memory::filled(0.0, components, PURPOSE)?;
        let other = memory::filled(0.0, components, PURPOSE)?;
        let forces = memory::filled(0.0, components, PURPOSE)?;
        Ok(Self {
            plan,
            space,
            bonds,
            scratch,
            held,
            load,
            shortest,
            evaluations: 0,
            moved,
            other,
            forces,
        })
    }

    /// b(u)
    fn pull(&mut self, displacement: &[f64], force: &mut [f64]) -> Trial<()> {
        let scene = self.plan.scene(self.space.workers, self.bonds, displacement);
        self.evaluations += 1;
        let failed = self.plan.formulation.force(&scene, self.scratch, force, None);
        if self.plan.formulation.was_stopped() {
            let text = "the material's function asked to stop";
            return Err(Stop::Error(Error::Interrupted(text.into())));
        }
        match failed {
            Some(place) => Err(Stop::NotFinite(place)),
            None => Ok(()),
        }
    }

    /// The residual r, and the size of what holds the held components; V b stays in `forces`.
    pub(crate) fn residual(&mut self, displacement: &[f64], residual: &mut [f64]) -> Trial<f64> {
        self.pull(displacement, residual)?;
        let (plan, held, load, dimension) = (self.plan, self.held, self.load, self.plan.dimension);
        let (forces, reaction) =
            (PerPoint(&mut self.forces, dimension), PerPoint(&mut self.other, dimension));
        let outputs = (PerPoint(residual, dimension), reaction, forces);
        self.space.workers.sweep(plan.count(), outputs, |range, (residual, reaction, forces)| {
            for (place, value) in residual.0.iter_mut().enumerate() {
                let component = range.start * dimension + place;
                let volume = plan.places()[component / dimension][3];
                forces.0[place] = volume * *value;
                let force = volume * (*value + load[component]);
                let (free, holding) = if held[component] { (0.0, force) } else { (force, 0.0) };
                (*value, reaction.0[place]) = (free, holding);
            }
        });
        Ok(self.space.norm(&self.other))
    }

    /// The size of the loads on what is free.
    pub(crate) fn load_size(&mut self, load: &[f64]) -> f64 {
        let (plan, held, dimension) = (self.plan, self.held, self.plan.dimension);
        for (component, value) in self.other.iter_mut().enumerate() {
            let volume = plan.places()[component / dimension][3];
            *value = if held[component] { 0.0 } else { volume * load[component] };
        }
        self.space.norm(&self.other)
    }

    /// K v = -(dr/du) v at a displacement, by the difference of V b from `base`, that at the displacement; 0 at held
    /// components, whose part of v counts.
    ///
    /// Points are moved by a share of the scale on which forces bend, the shortest bond, and by more where they have gone
    /// far: rounding of displacements follows them.
    pub(crate) fn stiffness(
        &mut self,
        (displacement, base): (&[f64], &[f64]),
        v: &[f64],
        product: &mut [f64],
    ) -> Trial<()> {
        let reach = super::space::largest(v);
        if reach == 0.0 {
            product.fill(0.0);
            return Ok(());
        }
        let far = (super::space::largest(displacement) / self.shortest).sqrt().max(1.0);
        let step = MOVE * far * self.shortest / reach;
        let mut moved = std::mem::take(&mut self.moved);
        moved.copy_from_slice(displacement);
        self.space.combine(&mut moved, 1.0, step, v);
        let done = self.pull(&moved, product);
        self.moved = moved;
        done?;
        let (plan, held, dimension) = (self.plan, self.held, self.plan.dimension);
        self.space.workers.sweep(plan.count(), PerPoint(product, dimension), |range, product| {
            for (place, value) in product.0.iter_mut().enumerate() {
                let component = range.start * dimension + place;
                let volume = plan.places()[component / dimension][3];
                let slope = (base[component] - volume * *value) / step;
                *value = if held[component] { 0.0 } else { slope };
            }
        });
        Ok(())
    }
}
