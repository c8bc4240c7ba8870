//! Conditions: who rules a component, with what value, and when functions are asked.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

use perion::{Error, Field, Quantity, Simulation};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use crate::random::{Random, cases};
use crate::scene::{Scene, small_bodies};

/// Where a condition's values come from.
#[derive(Debug, Clone)]
enum Source {
    Constant(f64),
    Values(Vec<f64>),
    Table([f64; 3], [f64; 3]),
    Function { size: f64, rate: f64 },
}

impl Source {
    fn random(random: &mut Random, size: f64, duration: f64, members: usize) -> Self {
        match random.below(4) {
            0 => Self::Constant(random.between(-size, size)),
            1 => Self::Values(random.around_zero(members, size)),
            2 => {
                let middle = random.between(0.1, 0.9) * duration;
                let values = [0, 1, 2].map(|_| random.between(-size, size));
                Self::Table([0.1 * middle, middle, duration], values)
            }
            _ => Self::Function { size, rate: 3.0 / duration },
        }
    }

    /// The value for a member of the set, at a place of the reference configuration.
    fn value(&self, time: f64, member: usize, place: &[f64]) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Values(values) => values[member],
            Self::Table(times, values) => {
                let [a, b, c] = *times;
                let (low, time) = (usize::from(time >= b), time.clamp(a, c));
                let share = (time - times[low]) / (times[low + 1] - times[low]);
                (1.0 - share) * values[low] + share * values[low + 1]
            }
            Self::Function { size, rate } => size * (rate * time + place[0] - place[1]).sin(),
        }
    }
}

/// A condition as the test knows it.
struct Known {
    set: &'static str,
    quantity: Quantity,
    axis: usize,
    source: Source,
    members: Vec<usize>,
    /// Which members it rules; motions lose points to later ones.
    rules: Vec<bool>,
}

/// What rules a component: quantity, place in the oracle's list, member of the set.
type Ruler = (Quantity, usize, usize);

/// The rules of conditions, told a second time.
struct Oracle<'a> {
    scene: &'a Scene,
    list: Vec<Known>,
    duration: f64,
}

impl Oracle<'_> {
    fn prescribe(&mut self, simulation: &mut Simulation, random: &mut Random) {
        let set = ["left", "right", "all", "some"][random.below(4)];
        let members = simulation.points().set(set).unwrap();
        let axis = random.below(self.scene.dimension);
        let reach = self.reach();
        let load = self.largest_load();
        let (quantity, size) = [
            (Quantity::Displacement, reach),
            (Quantity::Velocity, reach / self.duration),
            (Quantity::BodyForce, load),
        ][random.below(3)];
        let source = Source::random(random, size, self.duration, members.len());
        match source.clone() {
            Source::Constant(value) => simulation.prescribe(set, quantity, axis, value),
            Source::Values(values) => simulation.prescribe_values(set, quantity, axis, &values),
            Source::Table(times, values) => {
                simulation.prescribe_table(set, quantity, axis, &times, &values)
            }
            function => {
                let dimension = self.scene.dimension;
                let fill = move |time: f64, places: &[f64], values: &mut [f64]| {
                    for (member, place) in places.chunks_exact(dimension).enumerate() {
                        values[member] = function.value(time, member, place);
                    }
                    ControlFlow::Continue(())
                };
                simulation.prescribe_function(set, quantity, axis, Box::new(fill))
            }
        }
        .unwrap();
        self.list.retain(|k| (k.set, k.quantity, k.axis) != (set, quantity, axis));
        for known in self.list.iter_mut().filter(|known| {
            known.axis == axis
                && known.quantity != Quantity::BodyForce
                && quantity != Quantity::BodyForce
        }) {
            for (rules, member) in known.rules.iter_mut().zip(&known.members) {
                *rules &= !members.contains(member);
            }
        }
        let rules = vec![true; members.len()];
        self.list.push(Known { set, quantity, axis, source, members, rules });
    }

    fn reach(&self) -> f64 {
        1e-3 * self.scene.spacing
    }

    fn largest_load(&self) -> f64 {
        1e-3 * self.scene.bulk_modulus() / self.scene.spacing
    }

    /// Releases something that may or may not be prescribed.
    fn release(&mut self, simulation: &mut Simulation, random: &mut Random) -> bool {
        let set = ["left", "right", "all", "some"][random.below(4)];
        let axis = random.below(self.scene.dimension);
        let quantities = [Quantity::Displacement, Quantity::Velocity, Quantity::BodyForce];
        let quantity = quantities[random.below(3)];
        let found = self.list.iter().position(|known| {
            (known.set, known.quantity, known.axis) == (set, quantity, axis)
                && known.rules.contains(&true)
        });
        if let Some(place) = found {
            self.list.remove(place);
        }
        let outcome = simulation.release(set, quantity, axis);
        outcome.is_ok() == found.is_some()
    }

    /// Body force, and what rules each component.
    fn acting(&self, time: f64) -> (Vec<f64>, Vec<Option<Ruler>>) {
        let dimension = self.scene.dimension;
        let mut load = vec![0.0; self.scene.components()];
        let mut ruled = vec![None; self.scene.components()];
        for (number, known) in self.list.iter().enumerate() {
            for (member, &point) in known.members.iter().enumerate() {
                let component = point * dimension + known.axis;
                if known.quantity == Quantity::BodyForce {
                    load[component] += self.value(number, member, time);
                } else if known.rules[member] {
                    ruled[component] = Some((known.quantity, number, member));
                }
            }
        }
        (load, ruled)
    }

    fn value(&self, number: usize, member: usize, time: f64) -> f64 {
        let known = &self.list[number];
        let start = known.members[member] * self.scene.dimension;
        known.source.value(time, member, &self.scene.coordinates[start..])
    }

    /// Makes a step and checks every component against velocity Verlet as formulas.md has it.
    fn check_step(&self, simulation: &mut Simulation, step: f64) -> Result<(), TestCaseError> {
        let read = |simulation: &Simulation| {
            let fields = [
                Field::Displacement,
                Field::Velocity,
                Field::Acceleration,
                Field::InternalForce,
                Field::BodyForce,
                Field::Reaction,
            ];
            fields.map(|field| simulation.get(field).unwrap())
        };
        simulation.evaluate().unwrap();
        let (start, end) = (simulation.time(), simulation.time() + step);
        let [u, v, a, ..] = read(simulation);
        simulation.step(step, 1).unwrap();
        prop_assert_eq!(simulation.time(), end);
        let [u1, v1, a1, force, body, reaction] = read(simulation);
        let volumes = simulation.get(Field::Volume).unwrap();
        let densities = simulation.get(Field::Density).unwrap();
        let (load, ruled) = self.acting(end);
        // Tables and sums may be rounded in other ways; all else is the same bits.
        let small = |values: &[f64], least: f64| {
            1e-14 * values.iter().fold(least, |most, x| most.max(x.abs()))
        };
        let reach = self.reach();
        let (small_u, small_v) = (small(&u1, reach), small(&v1, reach / self.duration));
        let small_load = 1e-14 * self.largest_load();
        for component in 0..u.len() {
            let point = component / self.scene.dimension;
            prop_assert!((body[component] - load[component]).abs() <= small_load);
            let total = force[component] + body[component];
            let Some((quantity, number, member)) = ruled[component] else {
                prop_assert_eq!(reaction[component], 0.0);
                prop_assert_eq!(a1[component], total / densities[point]);
                let midway = v[component] + 0.5 * step * a[component];
                prop_assert!((u1[component] - u[component] - step * midway).abs() <= small_u);
                let after = midway + 0.5 * step * a1[component];
                prop_assert!((v1[component] - after).abs() <= small_v);
                continue;
            };
            prop_assert_eq!((a[component], a1[component]), (0.0, 0.0));
            prop_assert_eq!(reaction[component], -volumes[point] * total);
            let exact = !matches!(self.list[number].source, Source::Table(..));
            let value = |time: f64| self.value(number, member, time);
            let (expected_u, expected_v) = match quantity {
                Quantity::Displacement => (value(end), (u1[component] - u[component]) / step),
                _ => (u[component] + step * value(start + 0.5 * step), value(end)),
            };
            let (error_u, error_v) =
                ((u1[component] - expected_u).abs(), (v1[component] - expected_v).abs());
            prop_assert!(error_u <= if exact { 0.0 } else { small_u }, "{error_u:e}");
            prop_assert!(error_v <= if exact { 0.0 } else { small_v }, "{error_v:e}");
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn every_component_moves_as_its_last_condition_says(recipe in small_bodies()) {
        let scene = recipe.scene();
        let mut random = scene.random(40);
        let mut points = scene.points();
        let some = random.order(scene.count());
        points.add_set("some", &some[..scene.count().div_ceil(2)]).unwrap();
        let mut simulation = Simulation::new(&points, &scene.model(0, None)).unwrap();
        if !scene.second.is_empty() {
            simulation.assign_model("second", &scene.model(1, None)).unwrap();
        }
        let step = 0.7 * simulation.stable_time_step().unwrap();
        let mut oracle = Oracle { scene: &scene, list: Vec::new(), duration: 24.0 * step };
        for _ in 0..8 {
            for _ in 0..random.below(4) {
                oracle.prescribe(&mut simulation, &mut random);
                let unknown = simulation.get(Field::Reaction);
                prop_assert!(matches!(unknown, Err(Error::State(_))), "{unknown:?}");
            }
            for _ in 0..random.below(6) {
                prop_assert!(oracle.release(&mut simulation, &mut random));
            }
            for _ in 0..1 + random.below(3) {
                oracle.check_step(&mut simulation, step)?;
            }
        }
    }

    #[test]
    fn functions_are_asked_once_at_each_time_they_are_needed(
        recipe in small_bodies(), runs in prop::collection::vec(0..5_u64, 1..5),
    ) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        let step = 0.7 * simulation.stable_time_step().unwrap();
        let conditions = [
            ("left", Quantity::Displacement, 0),
            ("left", Quantity::Velocity, 1),
            ("right", Quantity::BodyForce, 0),
        ];
        let asked: [Arc<Mutex<Vec<f64>>>; 3] = Default::default();
        let thread = std::thread::current().id();
        simulation.set_threads(2).unwrap();
        for ((set, quantity, axis), log) in conditions.into_iter().zip(&asked) {
            let members = simulation.points().set(set).unwrap();
            let dimension = scene.dimension;
            let expected: Vec<f64> = members
                .iter()
                .flat_map(|&point| scene.coordinates[point * dimension..][..dimension].to_vec())
                .collect();
            let log = Arc::clone(log);
            let function = move |time: f64, places: &[f64], values: &mut [f64]| {
                assert_eq!(places, expected);
                assert_eq!(values.len() * dimension, places.len());
                assert_eq!(std::thread::current().id(), thread);
                log.lock().unwrap().push(time);
                values.fill(0.0);
                ControlFlow::Continue(())
            };
            simulation.prescribe_function(set, quantity, axis, Box::new(function)).unwrap();
        }
        let mut time = 3.0 * step;
        simulation.set_time(time).unwrap();
        let mut expected: [Vec<f64>; 3] = [vec![], vec![], vec![]];
        if runs.iter().sum::<u64>() > 0 {
            expected[2].push(time);
        }
        for steps in runs {
            simulation.step(step, steps).unwrap();
            for _ in 0..steps {
                expected[1].push(time + 0.5 * step);
                time += step;
                expected.iter_mut().for_each(|times| times.push(time));
            }
            // Looking changes nothing.
            simulation.energy().unwrap();
            simulation.stable_time_step().unwrap();
        }
        for (times, log) in expected.iter().zip(&asked) {
            prop_assert_eq!(times, &*log.lock().unwrap());
        }
    }
}
