//! Preconditioners: what is cheap and close to the inverse of the stiffness.
//!
//! Made from springs along the bonds as they are now (`bond_stiffness`): its blocks of each point, or a cycle over
//! several levels (`multilevel`).

mod aggregates;
mod bond_stiffness;
mod coarse;
mod factor;
mod multilevel;

use crate::damage::BondState;
use crate::error::Result;
use crate::memory;
use crate::plan::Plan;
use crate::solver::balance::PURPOSE;
use crate::workers::Workers;
use bond_stiffness::BondStiffness;
use multilevel::Multilevel;

/// How [`Simulation::solve`](crate::Simulation::solve) preconditions its linear systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preconditioning {
    /// By a cycle over several levels of a stiffness of springs: few iterations, at any size of the body.
    #[default]
    Global,
    /// By the stiffness of each point alone: no set-up, many iterations.
    BlockDiagonal,
    /// Not at all.
    None,
}

/// A preconditioner made ready for a body.
pub(crate) struct Preconditioner {
    of: Of,
    /// What it was made from; bonds by the name of their masks.
    edition: u64,
    displacement: Vec<f64>,
    held: Vec<bool>,
}

enum Of {
    Nothing,
    PlaneBlocks(BondStiffness<2>),
    SolidBlocks(BondStiffness<3>),
    Plane(Box<Multilevel<2, 3>>),
    Solid(Box<Multilevel<3, 6>>),
}

/// Points may move by this share of the shortest bond before springs are laid anew.
const NEAR: f64 = 0.3;

impl Preconditioner {
    pub(crate) fn new(
        choice: Preconditioning,
        plan: &Plan,
        workers: &Workers,
        bonds: &BondState,
        displacement: &[f64],
        held: &[bool],
    ) -> Result<Self> {
        let of = match (choice, plan.dimension) {
            (Preconditioning::None, _) => Of::Nothing,
            (Preconditioning::BlockDiagonal, 3) => {
                Of::SolidBlocks(BondStiffness::new(plan, workers, bonds, displacement, held)?)
            }
            (Preconditioning::BlockDiagonal, _) => {
                Of::PlaneBlocks(BondStiffness::new(plan, workers, bonds, displacement, held)?)
            }
            (Preconditioning::Global, 3) => {
                let springs = BondStiffness::new(plan, workers, bonds, displacement, held)?;
                Of::Solid(Box::new(Multilevel::new(plan, workers, springs)?))
            }
            (Preconditioning::Global, _) => {
                let springs = BondStiffness::new(plan, workers, bonds, displacement, held)?;
                Of::Plane(Box::new(Multilevel::new(plan, workers, springs)?))
            }
        };
        Ok(Self {
            of,
            edition: bonds.view().edition,
            displacement: memory::copied(displacement, PURPOSE)?,
            held: memory::copied(held, PURPOSE)?,
        })
    }

    /// Whether it is still close to the body as it is.
    pub(crate) fn fits(
        &self,
        plan: &Plan,
        bonds: &BondState,
        displacement: &[f64],
        held: &[bool],
    ) -> bool {
        let most = NEAR * plan.families.shortest_bond();
        let moved = self.displacement.iter().zip(displacement).map(|(was, is)| (was - is).abs());
        let edition = bonds.view().edition;
        self.edition == edition && self.held == held && moved.fold(0.0, f64::max) <= most
    }

    /// z = M^-1 r
    pub(crate) fn apply(&mut self, plan: &Plan, workers: &Workers, r: &[f64], z: &mut [f64]) {
        match &mut self.of {
            Of::Nothing => z.copy_from_slice(r),
            Of::PlaneBlocks(springs) => springs.divide(workers, 1.0, r, z),
            Of::SolidBlocks(springs) => springs.divide(workers, 1.0, r, z),
            Of::Plane(levels) => levels.apply(plan, workers, r, z),
            Of::Solid(levels) => levels.apply(plan, workers, r, z),
        }
    }
}
