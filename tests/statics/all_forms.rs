//! Every formulation comes to rest, with the same bits for any number of threads.

use perion::{Error, FORMULATIONS, Field, Model, Points, Quantity, Simulation, SolveOptions};

/// A block that is sheared and pulled at its end; points are off the lattice.
fn block(dimension: usize, model: &Model, threads: usize) -> Simulation {
    let size = [10.0, 4.0, 4.0];
    let regular =
        Points::block(dimension, &[0.0; 3][..dimension], &size[..dimension], 1.0).unwrap();
    let mut coordinates = regular.coordinates().to_vec();
    for (number, value) in coordinates.iter_mut().enumerate() {
        *value += 0.05 * (number as f64 * 2.3).sin();
    }
    let mut points = Points::new(dimension, &coordinates, regular.volumes()).unwrap();
    let far = [9.0, -1.0, -1.0];
    points.add_set_box("left", &[-1.0; 3][..dimension], &[1.0, 5.0, 5.0][..dimension]).unwrap();
    points.add_set_box("right", &far[..dimension], &[11.0, 5.0, 5.0][..dimension]).unwrap();
    let mut body = Simulation::new(&points, model).unwrap();
    body.set_threads(threads).unwrap();
    for axis in 0..dimension {
        body.prescribe("left", Quantity::Displacement, axis, 0.0).unwrap();
    }
    body.prescribe("right", Quantity::Displacement, 0, 0.05).unwrap();
    body.prescribe("right", Quantity::BodyForce, 1, 1e-4).unwrap();
    body
}

fn model(formulation: &str) -> Model {
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 2.51)] {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.3).unwrap();
    }
    model
}

/// Forces out of balance, over reactions.
fn out_of_balance(body: &mut Simulation) -> f64 {
    body.evaluate().unwrap();
    let of = |field| body.get(field).unwrap();
    let (force, load, held) = (of(Field::InternalForce), of(Field::BodyForce), of(Field::Reaction));
    let volume = of(Field::Volume);
    let dimension = body.points().dimension();
    let (mut left, mut whole) = (0.0, 0.0);
    for component in 0..force.len() {
        if held[component] == 0.0 {
            left += (volume[component / dimension] * (force[component] + load[component])).powi(2);
        }
        whole += held[component].powi(2);
    }
    (left / whole).sqrt()
}

#[test]
fn every_formulation_is_solved_with_the_same_bits_for_any_number_of_threads() {
    for formulation in FORMULATIONS.iter().map(|known| known.name) {
        for dimension in [2, 3] {
            if (dimension, formulation) == (2, "madenci_oterkus") {
                continue;
            }
            let solved = |threads| {
                let mut body = block(dimension, &model(formulation), threads);
                let report = body.solve(&SolveOptions::default()).unwrap();
                (body, report)
            };
            let (mut one, report) = solved(1);
            let left = out_of_balance(&mut one);
            println!("{formulation} in {dimension}D: {} forces", report.evaluations);
            assert!(left <= 2e-8, "{formulation}: {left}");
            let (two, again) = solved(2);
            assert_eq!(report, again, "{formulation}");
            let bits = |body: &Simulation| -> Vec<u64> {
                body.get(Field::Displacement).unwrap().iter().map(|u| u.to_bits()).collect()
            };
            assert_eq!(bits(&one), bits(&two), "{formulation}");
        }
    }
}

#[test]
fn what_flows_is_solved_and_remembers_each_load_step() {
    let mut model = model("bond_associated_quadrature");
    model.choose("material", "j2_plastic").unwrap();
    model.set("yield_stress", 2e-3).unwrap();
    model.set("hardening_modulus", 0.1).unwrap();
    let mut body = block(3, &model, 2);
    let report = body.solve(&SolveOptions { load_steps: 4, ..SolveOptions::default() }).unwrap();
    assert!(report.steps >= 3 && report.share == 1.0);
    let flowed = body.get(Field::EquivalentPlasticStrain).unwrap();
    assert!(flowed.iter().any(|&strain| strain > 1e-4), "nothing has flowed");
    let energy = body.energy().unwrap();
    assert!(energy.plastic > 0.0);
    let balance = energy.closure_error / energy.external_work;
    println!("{} forces, closure {balance:.1e} of the work", report.evaluations);
    assert!(balance.abs() < 0.05, "{balance}");
    assert!(out_of_balance(&mut body) < 2e-8);
}

/// The layers in the middle of both halves: over what lies between, each is stretched by its own modulus.
#[test]
fn two_materials_bear_a_load_each_with_its_own_stiffness() {
    let stiff = model("bond_associated_quadrature");
    let mut soft = stiff.clone();
    soft.set("youngs_modulus", 0.25).unwrap();
    let mut points = Points::block(3, &[0.0; 3], &[40.0, 3.0, 3.0], 1.0).unwrap();
    let mut layer = |name: &str, from: f64, to: f64| {
        points.add_set_box(name, &[from, 0.0, 0.0], &[to, 3.0, 3.0]).unwrap();
    };
    layer("left", 0.0, 1.0);
    layer("soft", 20.0, 40.0);
    layer("right", 39.0, 40.0);
    for (name, from) in [("a", 8.0), ("b", 12.0), ("c", 28.0), ("d", 32.0)] {
        layer(name, from, from + 1.0);
    }
    let mut body = Simulation::new(&points, &stiff).unwrap();
    body.assign_model("soft", &soft).unwrap();
    for axis in 0..3 {
        body.prescribe("left", Quantity::Displacement, axis, 0.0).unwrap();
    }
    body.prescribe("right", Quantity::Traction, 0, 1e-4).unwrap();
    body.solve(&SolveOptions::default()).unwrap();
    let at = |set| body.sum(Field::Displacement, Some(set)).unwrap()[0] / 9.0;
    let [first, second] = [(at("b") - at("a")) / 4.0, (at("d") - at("c")) / 4.0];
    assert!((first / 1e-4 - 1.0).abs() < 5e-3, "{first}");
    assert!((second / 4e-4 - 1.0).abs() < 5e-3, "{second}");
}

#[test]
fn a_body_that_is_not_held_is_told_and_stays_where_it_was() {
    let mut body = block(3, &model("ordinary_state_based"), 1);
    for axis in 0..3 {
        body.release("left", Quantity::Displacement, axis).unwrap();
    }
    body.release("right", Quantity::Displacement, 0).unwrap();
    let mut run = body.start_solving(&SolveOptions::default()).unwrap();
    let error = body.continue_solving(&mut run).unwrap_err();
    assert!(matches!(error, Error::Convergence(_)), "{error}");
    println!("{error}");
    assert!(run.report().cuts > 3 && !run.report().residuals.is_empty());
    assert_eq!(body.step_count(), 0);
    assert!(body.get(Field::Displacement).unwrap().iter().all(|&u| u == 0.0));
}
