//! Bodies that are loaded at an end.

use perion::{Field, Model, Points, Quantity, Result, Simulation};

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

    /// With the influence that serves a formulation best.
    pub fn usual_model(&self, formulation: &str) -> Model {
        let mut model = self.model(formulation);
        choose_usual_influence(&mut model, formulation).unwrap();
        model
    }

    /// Clamped in all directions, with the load as body force on the last layer.
    pub fn simulation(&self, model: &Model) -> Result<Simulation> {
        let points = self.points();
        let mut bar = Simulation::new(&points, model)?;
        for axis in 0..3 {
            bar.prescribe("clamp", Quantity::Displacement, axis, 0.0)?;
        }
        let volume = points.set_size("end")? as f64 * self.spacing().powi(3);
        bar.prescribe("end", Quantity::BodyForce, 0, FORCE / volume)?;
        Ok(bar)
    }

    /// Of the length change, in percent.
    pub fn error(bar: &Simulation, formulation: &str) -> f64 {
        let strain = bar_strain(formulation, FORCE / (0.01 * LENGTH * LENGTH), MODULUS);
        100.0 * (mean_along(bar, "end") / (LENGTH * strain) - 1.0)
    }
}

/// The influence that serves a formulation best.
pub fn choose_usual_influence(model: &mut Model, formulation: &str) -> Result<()> {
    match formulation {
        "bond_based" | "madenci_oterkus" => Ok(()),
        "bond_associated_quadrature" => model.choose("influence", "cubic_spline"),
        _ => model.choose("influence", "inverse"),
    }
}

/// A bar of so many points across, along (an odd number) and in a horizon, of spacing 1, with tractions on both ends and
/// held along its axis in the middle alone: the one-dimensional solution is exact.
pub struct PulledBar {
    pub across: usize,
    pub along: usize,
    pub ratio: usize,
}

impl PulledBar {
    fn points(&self) -> Points {
        assert!(self.along % 2 == 1, "a bar of {} points has no middle layer", self.along);
        let [along, across] = [self.along as f64, self.across as f64];
        let mut points = Points::block(3, &[0.0; 3], &[along, across, across], 1.0).unwrap();
        let middle = 0.5 * (along - 1.0);
        let mut layer = |name: &str, from: f64| {
            points.add_set_box(name, &[from, 0.0, 0.0], &[from + 1.0, across, across]).unwrap();
        };
        layer("near", 0.0);
        layer("middle", middle);
        layer("far", along - 1.0);
        points.add_set_box("pin", &[middle, 0.0, 0.0], &[middle + 1.0, 1.0, 1.0]).unwrap();
        points
            .add_set_box("guide", &[middle, across - 1.0, 0.0], &[middle + 1.0, across, 1.0])
            .unwrap();
        points
    }

    pub fn horizon(&self) -> f64 {
        1.005 * self.ratio as f64
    }

    /// Of a model with that horizon, under a force per reference area.
    pub fn simulation(&self, model: &Model, stress: f64) -> Result<Simulation> {
        let mut bar = Simulation::new(&self.points(), model)?;
        bar.prescribe("middle", Quantity::Displacement, 0, 0.0)?;
        for (set, axis) in [("pin", 1), ("pin", 2), ("guide", 2)] {
            bar.prescribe(set, Quantity::Displacement, axis, 0.0)?;
        }
        bar.prescribe("near", Quantity::Traction, 0, -stress)?;
        bar.prescribe("far", Quantity::Traction, 0, stress)?;
        Ok(bar)
    }

    /// What it has grown by, over its length between the points at its ends.
    pub fn strain(&self, bar: &Simulation) -> f64 {
        (mean_along(bar, "far") - mean_along(bar, "near")) / (self.along - 1) as f64
    }
}

/// The mean displacement of a set along the bar.
pub fn mean_along(bar: &Simulation, set: &str) -> f64 {
    let count = bar.points().set_size(set).unwrap();
    bar.sum(Field::Displacement, Some(set)).unwrap()[0] / count as f64
}

/// Whether a formulation knows small strains alone: no law, but linear bonds.
pub fn is_linear(formulation: &str) -> bool {
    matches!(formulation, "bond_based" | "ordinary_state_based" | "madenci_oterkus")
}

/// Length change over the length of a bar under a force per reference area, by what a formulation takes a solid for.
pub fn bar_strain(formulation: &str, stress: f64, modulus: f64) -> f64 {
    if is_linear(formulation) { stress / modulus } else { svk_strain(stress, modulus) }
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
