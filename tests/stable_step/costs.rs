//! What the stable step costs, and that it leaves no trace.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use perion::{Field, MaterialBatch, Simulation};

use crate::body::{VARIATIONAL, case, lattice, limit, noise, some_bonds};

/// A body whose law counts how often it is asked: forces, where a sweep asks each point once.
fn counting(formulation: &'static str) -> (Simulation, Arc<AtomicUsize>) {
    let mut model = case(formulation, &[], &[]).model(2.01);
    let asked = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&asked);
    let law = move |batch: &mut MaterialBatch<'_>| {
        count.fetch_add(batch.count, Ordering::Relaxed);
        for place in 0..batch.count {
            let own = place * 9..place * 9 + 9;
            let (now, stress) = (&batch.now[own.clone()], &mut batch.stress[own]);
            let mut energy = 0.0;
            for (row, column) in (0..9).map(|k| (k / 3, k % 3)) {
                let one = f64::from(u8::from(row == column));
                stress[3 * row + column] = now[3 * row + column] - one;
                energy += 0.5 * (now[3 * row + column] - one).powi(2);
            }
            batch.energy[place] = energy;
        }
        ControlFlow::Continue(())
    };
    model.set_material_function(0, law).unwrap();
    (Simulation::new(&lattice([7; 3]), &model).unwrap(), asked)
}

#[test]
fn sixty_forces_and_ten_after_small_damage() {
    let (mut block, asked) = counting("correspondence");
    let points = block.points().count();
    let forces = |asked: &AtomicUsize| asked.swap(0, Ordering::Relaxed).div_ceil(points);
    block.evaluate().unwrap();
    assert_eq!(forces(&asked), 1);
    block.stable_time_step().unwrap();
    let first = forces(&asked);
    assert!(first <= 60, "{first}");
    for seed in 0..5 {
        block.break_bonds(&some_bonds(&block, 0.01, seed)).unwrap();
        forces(&asked);
        let step = block.stable_time_step().unwrap();
        let again = forces(&asked);
        let share = step / limit(&mut block, 80);
        eprintln!("{first}, {again}: {share:.4}");
        assert!(again <= 10 && (0.9..=1.0).contains(&share), "{again} {share}");
        forces(&asked);
    }
}

/// Also where the damage is all in one place, and changes the mode.
#[test]
fn estimates_that_go_on_from_the_last_are_below_the_limit() {
    let mut worst = [1.0_f64, 0.0];
    for case in VARIATIONAL {
        let mut block = case.body(case.block(), 3.015);
        block.stable_time_step().unwrap();
        let middle = block.points().count() / 2;
        for round in 0..4_u32 {
            let own = |pair: &[usize; 2]| pair.contains(&middle) || pair.contains(&(middle + 1));
            let some = some_bonds(&block, 0.3 + 0.1 * f64::from(round), u64::from(round) + 9);
            let some: Vec<_> = some.into_iter().filter(own).collect();
            block.break_bonds(&some).unwrap();
            let share = block.stable_time_step().unwrap() / limit(&mut block, 80);
            eprintln!("{} {:?} {round}: {share:.4}", case.formulation, case.texts);
            worst = [worst[0].min(share), worst[1].max(share)];
        }
    }
    assert!(worst[0] >= 0.9 && worst[1] <= 1.0, "{worst:?}");
}

#[test]
fn the_state_is_bitwise_as_it_was() {
    for case in VARIATIONAL {
        let run = |asks: bool| {
            let mut block = case.body([4; 3], 3.015);
            let velocity = noise(3 * 64, 4);
            block.set(Field::Velocity, &velocity).unwrap();
            for _ in 0..3 {
                block.step(1e-3, 2).unwrap();
                if asks {
                    block.stable_time_step().unwrap();
                }
            }
            let bits = |field| -> Vec<u64> {
                block.get(field).unwrap().into_iter().map(f64::to_bits).collect()
            };
            (bits(Field::Displacement), bits(Field::InternalForce), block.energy().unwrap())
        };
        assert_eq!(run(true), run(false), "{case:?}");
    }
}

#[test]
fn it_does_not_depend_on_threads() {
    for case in VARIATIONAL {
        let step = |threads: usize| {
            let mut block = case
                .body(if case.formulation == "bond_associated" { [4; 3] } else { [9; 3] }, 2.01);
            block.set_threads(threads).unwrap();
            let first = block.stable_time_step().unwrap();
            block.break_bonds(&some_bonds(&block, 0.02, 1)).unwrap();
            [first.to_bits(), block.stable_time_step().unwrap().to_bits()]
        };
        assert_eq!(step(1), step(2), "{case:?}");
    }
}
