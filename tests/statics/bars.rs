//! Bodies that are loaded at an end.

use perion::{Field, Model, Points, Quantity, Simulation};

/// A bar of `across` points a side and ten times as many along, 100 x 10 x 10 mm, with a horizon of layers outside its
/// length that are clamped, under F0 = 200 kN on its last layer. [P] 5.1
pub struct TractionBar {
    pub across: usize,
    pub ratio: usize,
}

pub const LENGTH: f64 = 0.1;
pub const MODULUS: f64 = 210e9;
pub const FORCE: f64 = 200e3;

impl TractionBar {
    pub fn spacing(&self) -> f64 {
        0.1 * LENGTH / self.across as f64
    }

    pub fn points(&self) -> Points {
        let (h, side) = (self.spacing(), 0.1 * LENGTH);
        let mut points =
            Points::block(3, &[-h * self.ratio as f64, 0.0, 0.0], &[LENGTH, side, side], h)
                .unwrap();
        points.add_set_box("clamp", &[-LENGTH, 0.0, 0.0], &[0.0, side, side]).unwrap();
        points.add_set_box("end", &[LENGTH - h, 0.0, 0.0], &[LENGTH, side, side]).unwrap();
        points
    }

    pub fn model(&self, formulation: &str) -> Model {
        let mut model = Model::new(formulation).unwrap();
        model.set("density", 7850.0).unwrap();
        model.set("youngs_modulus", MODULUS).unwrap();
        model.set("poissons_ratio", 0.25).unwrap();
        model.set("horizon", 1.005 * self.ratio as f64 * self.spacing()).unwrap();
        model
    }

    /// Clamped in all directions, with the load as body force on the last layer.
    pub fn simulation(&self, model: &Model) -> Simulation {
        let points = self.points();
        let mut bar = Simulation::new(&points, model).unwrap();
        for axis in 0..3 {
            bar.prescribe("clamp", Quantity::Displacement, axis, 0.0).unwrap();
        }
        let volume = points.set_size("end").unwrap() as f64 * self.spacing().powi(3);
        bar.prescribe("end", Quantity::BodyForce, 0, FORCE / volume).unwrap();
        bar
    }
}

/// The mean displacement of a set along the bar.
pub fn mean_along(bar: &Simulation, set: &str) -> f64 {
    let count = bar.points().set_size(set).unwrap();
    bar.sum(Field::Displacement, Some(set)).unwrap()[0] / count as f64
}

/// Length change over the length of a Saint Venant-Kirchhoff bar of this modulus under a force per reference area:
/// P = E s (1 + s)(1 + s/2), one-dimensional.
pub fn svk_strain(stress: f64, modulus: f64) -> f64 {
    let mut s = stress / modulus;
    for _ in 0..50 {
        let value = modulus * s * (1.0 + s) * (1.0 + 0.5 * s) - stress;
        s -= value / (modulus * (1.0 + 3.0 * s + 1.5 * s * s));
    }
    s
}
