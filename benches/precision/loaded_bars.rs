//! Bars in tension: that of [P] 5.1, and example II of [B].

use perion::{Result, Simulation};

use super::bars::{FORCE, LENGTH, MODULUS, PulledBar, TractionBar, bar_strain, mean_along};
use super::{Answer, Method, Problem, Resolution, budget};

pub const TRACTION: Problem = Problem {
    name: "traction_bar",
    title: "traction bar, clamped in all directions",
    error_of: "length change; exact: the one-dimensional bar, less 0.203 % that finite elements give the clamp",
    across: &[5, 7, 10, 14],
    run: traction,
};

pub const HYPERELASTIC: Problem = Problem {
    name: "hyperelastic_bar",
    title: "hyperelastic bar under surface tractions, nu = 0.4545",
    error_of: "length change; exact: the one-dimensional bar",
    across: &[3, 5, 7, 9],
    run: hyperelastic,
};

/// Length change that the clamp takes, over the one-dimensional one: it keeps the bar from growing thin. Three-dimensional
/// finite elements say 0.0203 widths of the bar, of its ten.
const CLAMPED: f64 = -0.00203;

fn traction(method: Method, Resolution { across, ratio }: Resolution) -> Result<Answer> {
    let scene = TractionBar { across, ratio };
    let mut model = scene.model(method.formulation);
    method.choose(&mut model)?;
    let stress = FORCE / (0.01 * LENGTH * LENGTH);
    let exact = LENGTH * (1.0 + CLAMPED) * bar_strain(method.formulation, stress, MODULUS);
    solved(scene.simulation(&model)?, |bar| mean_along(bar, "end") / exact - 1.0)
}

/// [B] gives lambda, mu and tau; bonds are linear in small strains, where the bar is as long by a hundredth.
fn hyperelastic(method: Method, Resolution { across, ratio }: Resolution) -> Result<Answer> {
    let (lambda, mu, tau) = (200.0, 20.0, 0.590575);
    let bar = PulledBar { across, along: 10 * across + 1, ratio };
    let model = method.model(&[
        ("density", 1.4),
        ("lame_lambda", lambda),
        ("shear_modulus", mu),
        ("horizon", bar.horizon()),
    ])?;
    let modulus = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
    let exact = bar_strain(method.formulation, tau, modulus);
    solved(bar.simulation(&model, tau)?, |body| bar.strain(body) / exact - 1.0)
}

/// Solves a body on one thread, and asks it for its error.
pub fn solved(mut body: Simulation, error: impl FnOnce(&Simulation) -> f64) -> Result<Answer> {
    body.set_threads(1)?;
    let evaluations = body.solve(&budget())?.evaluations;
    Ok(Answer { error: error(&body).abs(), evaluations, body })
}
