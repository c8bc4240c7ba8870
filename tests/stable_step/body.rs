//! Bodies of unit spacing, density and stiffness, and the true limit of their time step.

use perion::{Field, Model, Points, Simulation};

/// A formulation with its choices, on a lattice.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub formulation: &'static str,
    pub texts: &'static [(&'static str, &'static str)],
    pub numbers: &'static [(&'static str, f64)],
}

pub const fn case(
    formulation: &'static str,
    texts: &'static [(&'static str, &'static str)],
    numbers: &'static [(&'static str, f64)],
) -> Case {
    Case { formulation, texts, numbers }
}

pub const INVERSE: &[(&str, &str)] = &[("influence", "inverse")];
pub const CONSTANT: &[(&str, &str)] = &[("influence", "constant")];
pub const SPLINE: &[(&str, &str)] = &[("influence", "cubic_spline")];

/// Each formulation whose forces have a potential.
pub const VARIATIONAL: [Case; 13] = [
    case("bond_based", &[], &[]),
    case("ordinary_state_based", SPLINE, &[]),
    case("ordinary_state_based", INVERSE, &[("yield_stress", 0.01)]),
    case("madenci_oterkus", &[], &[]),
    case("correspondence", SPLINE, &[]),
    case("correspondence", CONSTANT, &[("gradient_order", 2.0)]),
    case("correspondence", &[("material", "neo_hookean")], &[]),
    case("correspondence_silling", SPLINE, &[]),
    case("correspondence_wan", INVERSE, &[]),
    case("bond_associated", CONSTANT, &[]),
    case("bond_associated_quadrature", SPLINE, &[]),
    case("bond_associated_quadrature", INVERSE, &[]),
    case("total_lagrangian", SPLINE, &[]),
];

/// Others, of which steps are stable.
pub const WITHOUT_POTENTIAL: [Case; 6] = [
    case("total_lagrangian", &[("influence", "cubic_spline"), ("operator_bonds", "deformed")], &[]),
    case("updated_lagrangian", CONSTANT, &[]),
    case("bond_associated", &[("force_form", "literal")], &[]),
    case("correspondence", &[("material", "hypoelastic")], &[]),
    case("correspondence_wan", &[("material", "j2_plastic")], &[("yield_stress", 0.01)]),
    case("bond_associated_quadrature", &[("material", "j2_plastic")], &[("yield_stress", 0.01)]),
];

impl Case {
    /// Points of a block that is not too slow to try.
    pub fn block(&self) -> [usize; 3] {
        if self.formulation == "bond_associated" { [4; 3] } else { [7, 6, 5] }
    }

    pub fn flows(&self) -> bool {
        self.numbers.iter().any(|(key, _)| *key == "yield_stress")
    }

    pub fn model(&self, horizon: f64) -> Model {
        let mut model = Model::new(self.formulation).unwrap();
        model.set("density", 1.0).unwrap();
        model.set("youngs_modulus", 1.0).unwrap();
        model.set("horizon", horizon).unwrap();
        if self.formulation != "bond_based" {
            model.set("poissons_ratio", 0.25).unwrap();
        }
        for (key, value) in self.texts {
            model.choose(key, value).unwrap();
        }
        for (key, value) in self.numbers {
            model.set(key, *value).unwrap();
        }
        model
    }

    pub fn body(&self, counts: [usize; 3], horizon: f64) -> Simulation {
        Simulation::new(&lattice(counts), &self.model(horizon)).unwrap()
    }
}

pub fn lattice(counts: [usize; 3]) -> Points {
    let edges = counts.map(|count| count as f64);
    Points::block(3, &[0.0; 3], &edges, 1.0).unwrap()
}

/// Numbers without order between -1/2 and 1/2.
pub fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..count).map(|_| next()).collect()
}

/// The limit of the time step at the current displacement: 2 over the root of the largest eigenvalue of the slope of the
/// forces, by Lanczos's method with full orthogonalisation on forces asked for by the public calls. All points have the
/// same mass.
pub fn limit(simulation: &mut Simulation, turns: usize) -> f64 {
    let at = simulation.get(Field::Displacement).unwrap();
    let density = simulation.get(Field::Density).unwrap()[0];
    let mut force_at = |displacement: &[f64]| {
        simulation.set(Field::Displacement, displacement).unwrap();
        simulation.evaluate().unwrap();
        simulation.get(Field::InternalForce).unwrap()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut next = noise(at.len(), 77);
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    while diagonal.len() < turns.min(at.len()) {
        let size = dot(&next, &next).sqrt();
        if size < 1e-9 {
            break;
        }
        next.iter_mut().for_each(|value| *value /= size);
        off.push(size);
        let reach = next.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let step = 1e-6 / reach;
        let moved = |sign: f64| -> Vec<f64> {
            at.iter().zip(&next).map(|(u, v)| u + sign * step * v).collect()
        };
        let (forth, back) = (force_at(&moved(1.0)), force_at(&moved(-1.0)));
        let mut product: Vec<f64> = forth
            .iter()
            .zip(&back)
            .map(|(forth, back)| -(forth - back) / (2.0 * step * density))
            .collect();
        diagonal.push(dot(&next, &product));
        basis.push(next);
        for _ in 0..2 {
            for vector in &basis {
                let along = dot(vector, &product);
                product.iter_mut().zip(vector).for_each(|(value, v)| *value -= along * v);
            }
        }
        next = product;
    }
    force_at(&at);
    2.0 / largest(&diagonal, &off[1..]).sqrt()
}

/// The largest eigenvalue of a tridiagonal matrix, by counting signs of pivots.
fn largest(diagonal: &[f64], off: &[f64]) -> f64 {
    let mut low = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut high = low.abs() + 2.0 * off.iter().copied().fold(0.0, f64::max);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let mut pivot = middle - diagonal[0];
        let mut is_above = pivot > 0.0;
        for k in 1..diagonal.len() {
            pivot = middle - diagonal[k] - off[k - 1] * off[k - 1] / pivot;
            is_above &= pivot > 0.0;
        }
        if is_above {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// The least of what [P 3.58] gives.
pub fn conventional(simulation: &Simulation) -> f64 {
    let steps = simulation.get(Field::TimeStepEstimate).unwrap();
    steps.into_iter().fold(f64::INFINITY, f64::min)
}

/// Pairs of neighbours of a lattice body, some share of all, without order.
pub fn some_bonds(simulation: &Simulation, share: f64, seed: u64) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    simulation.for_each_bond(|pair, _, _| pairs.push(pair)).unwrap();
    let lots = noise(pairs.len(), seed);
    pairs.into_iter().zip(lots).filter(|(_, lot)| lot + 0.5 < share).map(|(pair, _)| pair).collect()
}
