//! A smooth displacement in a cube that a body force keeps there, at rest and swinging. Around the cube lie two horizons
//! of points that are moved as the solution says, so that no family is cut that matters.

use std::ops::ControlFlow;

use perion::{ConditionFunction, Field, Model, Points, Quantity, Result, Simulation};

use super::field::{divergence, powers, shape};
use super::loaded_bars::solved;
use super::{Answer, Method, Problem, Resolution, relative_difference};

pub const STATIC: Problem = Problem {
    name: "smooth_static",
    title: "smooth displacement of a cube, at rest",
    error_of: "displacement, root mean square over the cube; exact: what its body force was made for",
    across: ACROSS,
    run: at_rest,
};

pub const DYNAMIC: Problem = Problem {
    name: "smooth_dynamic",
    title: "smooth displacement of a cube, swinging",
    error_of: "displacement, root mean square over the cube, at the end, over that at the start; exact: as above",
    across: ACROSS,
    run: swinging,
};

const ACROSS: &[usize] = &[4, 6, 9, 13, 19, 28];

/// Angular frequency, and the time of the end: a third of a period.
const FREQUENCY: f64 = 2.0;
const END: f64 = 1.0;

/// The cube of edge 1, its points and what moves them.
pub struct Cube {
    points: Points,
    amplitude: f64,
    horizon: f64,
}

impl Cube {
    fn new(amplitude: f64, Resolution { across, ratio }: Resolution) -> Result<Self> {
        let spacing = 1.0 / across as f64;
        let rim = 2.0 * ratio as f64 * spacing;
        let mut points = Points::block(3, &[-rim; 3], &[1.0 + rim; 3], spacing)?;
        points.add_set_box("inside", &[0.0; 3], &[1.0; 3])?;
        let inside = points.set("inside")?;
        let mut is_inside = vec![false; points.count()];
        inside.iter().for_each(|&point| is_inside[point] = true);
        let outside: Vec<usize> = (0..points.count()).filter(|&point| !is_inside[point]).collect();
        points.add_set("outside", &outside)?;
        Ok(Self { points, amplitude, horizon: 1.005 * ratio as f64 * spacing })
    }

    pub fn of(method: Method, resolution: Resolution) -> Result<(Self, Model)> {
        // Strains of five hundredths where a solid has large strains, else none to speak of.
        let cube = Self::new(if method.is_linear() { 1e-6 } else { 0.02 }, resolution)?;
        let model = method.model(&[
            ("density", 1.0),
            ("youngs_modulus", 1.0),
            ("poissons_ratio", 0.25),
            ("horizon", cube.horizon),
        ])?;
        Ok((cube, model))
    }

    /// A value a point of a set.
    fn values<T>(&self, set: &str, value: impl Fn(&[f64]) -> T) -> Result<Vec<T>> {
        let places = self.points.coordinates().as_chunks::<3>().0;
        Ok(self.points.set(set)?.iter().map(|&point| value(&places[point])).collect())
    }

    /// Swings as cos(omega t) from the start on, at rest first.
    pub fn swinging(&self, model: &Model) -> Result<Simulation> {
        let mut body = Simulation::new(&self.points, model)?;
        body.set_threads(1)?;
        let scale = self.amplitude;
        let start = self.points.coordinates().as_chunks::<3>().0.iter();
        let start: Vec<f64> = start.flat_map(|place| shape(place).map(|s| scale * s)).collect();
        body.set(Field::Displacement, &start)?;
        for axis in 0..3 {
            let values = self.values("outside", |place| scale * shape(place)[axis])?;
            let moved: ConditionFunction = Box::new(move |time, _, displacement| {
                let share = (FREQUENCY * time).cos();
                displacement.iter_mut().zip(&values).for_each(|(u, value)| *u = share * value);
                ControlFlow::Continue(())
            });
            body.prescribe_function("outside", Quantity::Displacement, axis, moved)?;
            let terms = self.values("inside", |place| {
                let [first, second, third] = powers(scale, place).map(|term| term[axis]);
                [FREQUENCY * FREQUENCY * scale * shape(place)[axis] + first, second, third]
            })?;
            // rho a - Div P
            let pushed: ConditionFunction = Box::new(move |time, _, force| {
                let share = (FREQUENCY * time).cos();
                for (force, [first, second, third]) in force.iter_mut().zip(&terms) {
                    *force = -share * (first + share * (second + share * third));
                }
                ControlFlow::Continue(())
            });
            body.prescribe_function("inside", Quantity::BodyForce, axis, pushed)?;
        }
        Ok(body)
    }

    /// How far the cube is off `share` of the displacement, over the whole displacement.
    fn error(&self, body: &Simulation, share: f64) -> f64 {
        let found = body.get(Field::Displacement).unwrap();
        let places = self.points.coordinates().as_chunks::<3>().0;
        let inside = self.points.set("inside").unwrap();
        relative_difference(inside.iter().flat_map(|&point| {
            let exact = shape(&places[point]).map(|s| self.amplitude * s);
            [0, 1, 2]
                .map(|axis| [found[3 * point + axis] + (1.0 - share) * exact[axis], exact[axis]])
        }))
    }
}

fn at_rest(method: Method, resolution: Resolution) -> Result<Answer> {
    let (cube, model) = Cube::of(method, resolution)?;
    let mut body = Simulation::new(&cube.points, &model)?;
    for axis in 0..3 {
        let moved = cube.values("outside", |place| cube.amplitude * shape(place)[axis])?;
        body.prescribe_values("outside", Quantity::Displacement, axis, &moved)?;
        let pushed = cube.values("inside", |place| -divergence(cube.amplitude, place)[axis])?;
        body.prescribe_values("inside", Quantity::BodyForce, axis, &pushed)?;
    }
    solved(body, |body| cube.error(body, 1.0))
}

fn swinging(method: Method, resolution: Resolution) -> Result<Answer> {
    let (cube, model) = Cube::of(method, resolution)?;
    let mut body = cube.swinging(&model)?;
    let steps = (END / (0.5 * body.stable_time_step()?)).ceil();
    body.step(END / steps, steps as u64)?;
    let error = cube.error(&body, (FREQUENCY * END).cos());
    Ok(Answer { error, evaluations: steps as u64 + 1, body })
}
