//! The stable step of velocity Verlet: 2 over the largest frequency.
//!
//! The squares of the frequencies are the eigenvalues of A = -rho^-1 db/du at the current state. Where forces have a
//! potential A is symmetric in the inner product of the mass, and the largest eigenvalue is climbed to (`ascent`);
//! else it is that of the largest size in a Krylov space (`arnoldi`). What the residual leaves open is added to it.

mod arnoldi;
mod ascent;
mod dominant;
mod linearised;

use crate::damage::BondState;
use crate::error::{Error, Result};
use crate::families::Property;
use crate::plan::Plan;
use crate::workers::Workers;
use linearised::Linearised;

/// Forces that an estimate from the start may cost, and one that goes on from the last.
const FORCES: usize = 60;
const FORCES_AGAIN: usize = 10;

/// What is kept below the limit for what differences and residuals leave out.
const MARGIN: f64 = 0.98;

/// What an estimate that goes on from the last may leave open, over the eigenvalue.
const OPEN: f64 = 0.1;

/// Share of the bonds that are few.
const FEW: f64 = 0.05;

/// Eigenvalues further than this share of the largest from the real axis grow in any step.
const TURNING: f64 = 0.02;

const PURPOSE: &str = "the stable step";

const NOT_FINITE: &str =
    "the stable step cannot be found, since forces at the current displacement are not finite";

/// A stable step, and what the next estimate can go on from.
#[derive(Debug)]
pub(crate) struct StableStep {
    /// 2 over the largest frequency, less a margin; the largest number there is, where nothing vibrates.
    pub(crate) step: f64,
    /// Forces have a potential: at this step Verlet keeps what it keeps near the state at which it was found.
    pub(crate) is_guaranteed: bool,
    /// No step is stable, since the largest eigenvalue is not real and positive: its parts.
    pub(crate) unstable: Option<[f64; 2]>,
    /// The host has changed bonds since.
    pub(crate) is_stale: bool,
    /// Steps of the simulation when it was found.
    pub(crate) found_at: u64,
    /// Where the search has ended as soon as steps of so much were known to be stable: how much. Then `step` is an estimate.
    settled_for: Option<f64>,
    /// Bonds that were intact, each counted from both ends.
    intact: u64,
    /// The mode of the largest frequency, as far as it is known.
    mode: Vec<f64>,
}

/// The largest eigenvalue, as estimated.
struct Top {
    real: f64,
    imaginary: f64,
    /// How far from it an eigenvalue may be.
    residual: f64,
    mode: Vec<f64>,
    /// It has been looked for no longer than until it was known to be below a limit.
    is_settled: bool,
}

impl Top {
    fn size(&self) -> f64 {
        self.real.hypot(self.imaginary)
    }
}

impl StableStep {
    /// From the beginning, or from the mode of an estimate made before where that suits and leads far enough. `steps`: how many
    /// the simulation has made. With a step that is `wanted`, only until that is known to be stable.
    pub(crate) fn find(
        plan: &Plan,
        workers: &Workers,
        bonds: &BondState,
        displacement: &[f64],
        scratch: &mut [f64],
        (before, steps): (Option<&Self>, u64),
        wanted: Option<f64>,
    ) -> Result<Self> {
        let mut operator =
            Linearised::new(plan, workers, bonds, displacement, scratch, &plan.density)?;
        let is_guaranteed = plan.formulation.has_potential();
        let before = before.filter(|before| before.suits(wanted.unwrap_or(f64::INFINITY)));
        let again = match before {
            Some(before) => {
                Some(search(&mut operator, Some(&before.mode), FORCES_AGAIN - 1, None)?)
            }
            None => None,
        };
        let limit = wanted.map(|step| (2.0 * MARGIN / step).powi(2));
        // An estimate that suits the step that is wanted goes on as one.
        let is_estimate = before.is_some_and(|before| before.settled_for.is_some());
        let is_below = |top: &Top| limit.is_some_and(|limit| top.size() + top.residual <= limit);
        let leads_far_enough =
            |top: &Top| top.residual <= OPEN * top.size() && (!is_estimate || is_below(top));
        let (top, is_settled) = match again.filter(leads_far_enough) {
            Some(top) => (top, is_estimate),
            None => {
                let top = search(&mut operator, None, FORCES - 1, limit)?;
                let is_settled = top.is_settled;
                (top, is_settled)
            }
        };
        let settled_for = wanted.filter(|_| is_settled);
        let bound = top.size() + top.residual;
        if !bound.is_finite() {
            return Err(Error::Numeric(NOT_FINITE.into()));
        }
        let turns = top.imaginary.abs() > TURNING * top.size() + top.residual || top.real < 0.0;
        Ok(Self {
            step: if bound > 0.0 { (2.0 * MARGIN / bound.sqrt()).min(f64::MAX) } else { f64::MAX },
            is_guaranteed: is_guaranteed && settled_for.is_none(),
            settled_for,
            unstable: (!is_guaranteed && turns).then_some([top.real, top.imaginary]),
            is_stale: false,
            found_at: steps,
            intact: bonds.count(),
            mode: top.mode,
        })
    }

    /// Whether it tells enough for a step to be compared with it.
    pub(crate) fn suits(&self, time_step: f64) -> bool {
        self.settled_for.is_none_or(|most| time_step <= most)
    }

    /// Whether bonds have broken since.
    pub(crate) fn is_of_more_bonds(&self, bonds: &BondState) -> bool {
        bonds.count() < self.intact
    }

    /// Whether bonds have broken since, but not many.
    pub(crate) fn is_near(&self, bonds: &BondState) -> bool {
        let intact = bonds.count();
        intact < self.intact && (self.intact - intact) as f64 <= FEW * self.intact as f64
    }

    pub(crate) fn bytes(&self) -> usize {
        crate::memory::bytes(&self.mode)
    }
}

/// The largest eigenvalue by so many products, from a mode that is known or from the beginning; no farther than until it
/// is known to be below a limit, where forces have a potential.
fn search(
    operator: &mut Linearised<'_>,
    mode: Option<&[f64]>,
    products: usize,
    limit: Option<f64>,
) -> Result<Top> {
    let start = operator.start(mode)?;
    if operator.plan.formulation.has_potential() {
        ascent::top(operator, start, products, limit)
    } else {
        arnoldi::top(operator, start, products)
    }
}

/// A bound of the largest eigenvalue of the forces' slope where points have another density than the body's.
pub(crate) fn largest_eigenvalue(
    plan: &Plan,
    workers: &Workers,
    (bonds, displacement): (&BondState, &[f64]),
    scratch: &mut [f64],
    density: &Property,
    products: usize,
) -> Result<f64> {
    let mut operator = Linearised::new(plan, workers, bonds, displacement, scratch, density)?;
    let top = search(&mut operator, None, products, None)?;
    Ok(top.size() + top.residual)
}
