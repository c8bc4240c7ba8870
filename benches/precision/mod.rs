//! Problems with known answers, and what the formulations make of them: shared by the bench `work_precision` and the test of
//! the same name.
#![allow(dead_code)]

#[path = "../../tests/statics/bars.rs"]
pub mod bars;
mod field;
mod loaded_bars;
pub mod manufactured;
mod wave;

use std::time::Instant;

use perion::{Model, Result, Simulation, SolveOptions};

/// A formulation, with its usual influence, and with or without the correction of its surface.
#[derive(Clone, Copy, PartialEq)]
pub struct Method {
    pub formulation: &'static str,
    pub correction: Option<&'static str>,
}

const fn plain(formulation: &'static str) -> Method {
    Method { formulation, correction: None }
}

const fn corrected(formulation: &'static str, correction: &'static str) -> Method {
    Method { formulation, correction: Some(correction) }
}

/// All formulations, those of bonds with both corrections too.
pub const METHODS: [Method; 14] = [
    plain("bond_based"),
    corrected("bond_based", "energy"),
    corrected("bond_based", "stiffness_tensor"),
    plain("ordinary_state_based"),
    corrected("ordinary_state_based", "energy"),
    corrected("ordinary_state_based", "stiffness_tensor"),
    plain("correspondence"),
    plain("bond_associated_quadrature"),
    plain("bond_associated"),
    plain("correspondence_wan"),
    plain("correspondence_silling"),
    plain("madenci_oterkus"),
    plain("total_lagrangian"),
    plain("updated_lagrangian"),
];

impl Method {
    pub fn name(&self) -> String {
        match self.correction {
            None => self.formulation.into(),
            Some(correction) => format!("{} + {correction}", self.formulation),
        }
    }

    /// Whether it knows small strains alone.
    fn is_linear(&self) -> bool {
        bars::is_linear(self.formulation)
    }

    /// A solid of these numbers.
    fn model(&self, numbers: &[(&str, f64)]) -> Result<Model> {
        let mut model = Model::new(self.formulation)?;
        for (key, value) in numbers {
            model.set(key, *value)?;
        }
        self.choose(&mut model)?;
        Ok(model)
    }

    fn choose(&self, model: &mut Model) -> Result<()> {
        bars::choose_usual_influence(model, self.formulation)?;
        self.correction.map_or(Ok(()), |correction| model.choose("surface_correction", correction))
    }
}

/// One load step of at most 6000 products, so that what has soft modes ends.
pub fn budget() -> SolveOptions {
    SolveOptions {
        smallest_load_step: 1.0,
        iterations: 10,
        products: 600,
        ..SolveOptions::default()
    }
}

/// Points across a body, and in a horizon.
#[derive(Clone, Copy)]
pub struct Resolution {
    pub across: usize,
    pub ratio: usize,
}

/// A problem with a known answer.
pub struct Problem {
    pub name: &'static str,
    pub title: &'static str,
    /// What its error is an error of, and what it is relative to.
    pub error_of: &'static str,
    /// Points across, from coarse to fine.
    pub across: &'static [usize],
    run: fn(Method, Resolution) -> Result<Answer>,
}

pub const PROBLEMS: [Problem; 5] = [
    loaded_bars::TRACTION,
    loaded_bars::HYPERELASTIC,
    wave::PLANE_WAVE,
    manufactured::STATIC,
    manufactured::DYNAMIC,
];

/// What a run of a problem has found.
struct Answer {
    error: f64,
    /// Of forces, those that the stable step is found by left out.
    evaluations: u64,
    body: Simulation,
}

/// An answer and what it cost.
pub struct Outcome {
    /// Relative.
    pub error: f64,
    /// Of the processor, with everything that is made ready before the first force.
    pub seconds: f64,
    pub evaluations: u64,
    pub bytes: usize,
}

impl Problem {
    /// Runs it on one thread.
    ///
    /// # Errors
    /// What the formulation refuses, and that no equilibrium was found.
    pub fn run(&self, method: Method, resolution: Resolution) -> Result<Outcome> {
        let started = Clock::start();
        let Answer { error, evaluations, body } = (self.run)(method, resolution)?;
        let seconds = started.seconds();
        Ok(Outcome { error, seconds, evaluations, bytes: body.memory().total() })
    }
}

/// Time that this thread has had of a processor where the system tells, else time that has passed: what others do on the
/// machine then counts too.
struct Clock {
    start: Instant,
    ran: Option<f64>,
}

impl Clock {
    fn start() -> Self {
        Self { start: Instant::now(), ran: Self::ran() }
    }

    fn seconds(&self) -> f64 {
        match (self.ran, Self::ran()) {
            (Some(before), Some(now)) => now - before,
            _ => self.start.elapsed().as_secs_f64(),
        }
    }

    fn ran() -> Option<f64> {
        // The system counts when a thread gives way.
        std::thread::yield_now();
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
        Some(1e-9 * nanoseconds)
    }
}

/// Root of the sum of squares of what two fields differ by, over that of the second.
fn relative_difference(found: impl Iterator<Item = [f64; 2]>) -> f64 {
    let [apart, size] = found.fold([0.0, 0.0], |[apart, size], [found, exact]| {
        [apart + (found - exact) * (found - exact), size + exact * exact]
    });
    (apart / size).sqrt()
}
