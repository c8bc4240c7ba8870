//! The order in which the host hands over its points changes no bit of a result.

use crate::data::{PLATES, Reference, SOLIDS};
use perion::{Field, Points, Simulation};

/// A shuffle of `count` indices that is the same on every machine.
fn shuffled(count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    for last in (1..count).rev() {
        // Knuth's MMIX generator; its upper bits are the good ones.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(last, ((state >> 33) % (last as u64 + 1)) as usize);
    }
    order
}

/// Values of the points in another order: first those of point `order[0]`.
fn reordered(values: &[f64], order: &[usize]) -> Vec<f64> {
    let components = values.len() / order.len();
    let of = |&point: &usize| values[point * components..(point + 1) * components].iter();
    order.iter().flat_map(of).copied().collect()
}

fn reordered_points(reference: &Reference, order: &[usize]) -> Points {
    let positions = reordered(&reference.numbers("positions"), order);
    let volumes = reordered(&reference.numbers("volumes"), order);
    Points::new(reference.dimension(), &positions, &volumes).unwrap()
}

#[test]
fn shuffled_points_get_the_same_bits_of_every_field() {
    for name in SOLIDS.into_iter().chain(PLATES) {
        let reference = Reference::load(name);
        let order = shuffled(reference.points().count());
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(new, &old)| place[old] = new);
        let points = reordered_points(&reference, &order);
        let mut other = Simulation::new(&points, &reference.model()).unwrap();
        let mut pairs = reference.broken_pairs();
        pairs.iter_mut().for_each(|pair| *pair = pair.map(|point| place[point]));
        other.break_bonds(&pairs).unwrap();
        other.set(Field::Position, &reordered(&reference.numbers("current"), &order)).unwrap();
        let mut body = reference.body();
        body.evaluate().unwrap();
        other.evaluate().unwrap();
        for field in Field::ALL.into_iter().filter(|it| it.is_defined(reference.dimension())) {
            let expected = reordered(&body.get(field).unwrap(), &order);
            assert_eq!(other.get(field).unwrap(), expected, "{name}: {}", field.name());
            let (one, two) = (body.sum(field, None), other.sum(field, None));
            assert_eq!(one.unwrap(), two.unwrap(), "{name}: sum of {}", field.name());
        }
        assert_eq!(body.energy().unwrap(), other.energy().unwrap(), "{name}");
        assert_eq!(body.stable_time_step().unwrap(), other.stable_time_step().unwrap(), "{name}");
    }
}

#[test]
fn shuffled_points_break_and_move_the_same() {
    let reference = Reference::load("verlet_bb_fracture");
    let order = shuffled(reference.points().count());
    let unchanged: Vec<usize> = (0..order.len()).collect();
    let run = |order: &[usize]| {
        let model = crate::motion::model(&reference);
        let points = reordered_points(&reference, order);
        let mut body = Simulation::new(&points, &model).unwrap();
        let velocity = reordered(&reference.numbers("initial_velocity"), order);
        body.set(Field::Velocity, &velocity).unwrap();
        body.step(reference.number("time_step"), 60).unwrap();
        body
    };
    let (body, other) = (run(&unchanged), run(&order));
    for field in Field::ALL.into_iter().filter(|it| it.is_defined(reference.dimension())) {
        let expected = reordered(&body.get(field).unwrap(), &order);
        assert_eq!(other.get(field).unwrap(), expected, "{}", field.name());
    }
    assert_eq!(body.energy().unwrap(), other.energy().unwrap());
}
