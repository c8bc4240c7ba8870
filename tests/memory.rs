//! Memory: running out of it is an error that leaves everything as it was, and a step asks for none.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

use perion::{Error, FORMULATIONS, Field, Model, Points, Quantity, Result, Simulation};

/// Requests that may grow with the input; smaller ones are outside the promise.
const LARGE: usize = 4096;

/// An allocator that counts large requests, and refuses all from a given one on.
struct Watched;

static LARGE_REQUESTS: AtomicU64 = AtomicU64::new(0);
static GRANTED: AtomicI64 = AtomicI64::new(i64::MAX);

fn granted(size: usize) -> bool {
    if size < LARGE {
        return true;
    }
    LARGE_REQUESTS.fetch_add(1, Ordering::Relaxed);
    GRANTED.fetch_sub(1, Ordering::Relaxed) > 0
}

// SAFETY: what is granted is the system allocator's own; a refusal is a null pointer, as allowed.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        if granted(layout.size()) { unsafe { System.alloc(layout) } } else { std::ptr::null_mut() }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if granted(size) {
            // SAFETY: the caller's promise.
            unsafe { System.realloc(pointer, layout, size) }
        } else {
            std::ptr::null_mut()
        }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

/// The allocator's counters are for one test at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(|poison| poison.into_inner())
}

/// Points of the plate.
const COUNT: usize = 32 * 24 * 8;

fn plate() -> Result<Points> {
    let mut points = Points::block(3, &[0.0; 3], &[32.0, 24.0, 8.0], 1.0)?;
    points.add_set_box("left", &[0.0; 3], &[1.0, 24.0, 8.0])?;
    points.add_set_box("right", &[31.0, 0.0, 0.0], &[32.0, 24.0, 8.0])?;
    points.set_horizons(&[3.015; COUNT])?;
    Ok(points)
}

fn model() -> Model {
    let mut model = Model::new("bond_based").unwrap();
    model.set("density", 1.0).unwrap();
    model.set("youngs_modulus", 1.0).unwrap();
    model.set("critical_stretch", 0.05).unwrap();
    model
}

/// Prepares a scene that uses everything whose memory grows with the input.
fn prepare(points: &Points) -> Result<Simulation> {
    let mut simulation = Simulation::new(points, &model())?;
    simulation.set_threads(1)?;
    simulation.assign_model("right", &model())?;
    simulation.set_interface("left", "right", 1.0)?;
    simulation.forbid_failure("left")?;
    simulation.break_crossing(&[8.0, 0.0, 0.0, 8.0, 6.0, 0.0, 8.0, 6.0, 6.0, 8.0, 0.0, 6.0])?;
    simulation.set_bond_integrity(&[[0, 1]], &[0.5])?;
    simulation.prescribe("left", Quantity::Velocity, 0, 0.0)?;
    let pull = |time: f64, _: &[f64], values: &mut [f64]| {
        values.fill(1e-3 * time);
        std::ops::ControlFlow::Continue(())
    };
    simulation.prescribe_function("right", Quantity::BodyForce, 0, Box::new(pull))?;
    simulation.set(Field::BodyForce, &[1e-5; 3 * COUNT])?;
    Ok(simulation)
}

fn run(simulation: &mut Simulation) -> Result<Vec<f64>> {
    let time_step = simulation.stable_time_step()?;
    simulation.step(time_step, 3)?;
    simulation.energy()?;
    simulation.health()?;
    simulation.sum(Field::Reaction, Some("left"))?;
    simulation.get(Field::Damage)?;
    simulation.break_bonds(&[[100, 101]])?;
    simulation.commit(0.0)?;
    simulation.get(Field::Displacement)
}

/// Runs `attempt` with ever more memory granted until it succeeds. Every failure is `Error::Memory`.
fn with_ever_more_memory<T>(mut attempt: impl FnMut() -> Result<T>) -> (T, i64) {
    for granted in 0.. {
        GRANTED.store(granted, Ordering::Relaxed);
        let result = attempt();
        GRANTED.store(i64::MAX, Ordering::Relaxed);
        match result {
            Ok(value) => return (value, granted),
            Err(Error::Memory { bytes, .. }) => assert!(bytes > 0),
            Err(error) => panic!("with {granted} requests granted: {error}"),
        }
    }
    unreachable!()
}

#[test]
fn every_request_for_memory_may_fail_and_the_next_try_succeeds_with_the_same_bits() {
    let _alone = alone();
    let (points, tries) = with_ever_more_memory(plate);
    assert!(tries > 5, "{tries}");
    let (_, tries) = with_ever_more_memory(|| prepare(&points));
    assert!(tries > 20, "{tries}");
    let expected = run(&mut prepare(&points).unwrap()).unwrap();
    // The same simulation goes on after each failure: what it did so far, it has done.
    let mut simulation = prepare(&points).unwrap();
    let (_, tries) = with_ever_more_memory(|| simulation.stable_time_step());
    assert!(tries > 10, "{tries}");
    assert_eq!(run(&mut simulation).unwrap(), expected);
}

#[test]
fn every_request_of_a_reader_may_fail() {
    let _alone = alone();
    for name in [
        "cloud.txt",
        "tetrahedron.inp",
        "tetrahedron_4.1_text.msh",
        "tetrahedron_2.2_binary.msh",
        "vertices_wide.vtu",
    ] {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/meshes/");
        let (points, tries) = with_ever_more_memory(|| Points::read(format!("{path}{name}")));
        assert!(points.count() >= 20 && (tries > 1 || name == "cloud.txt"), "{name}: {tries}");
    }
}

#[test]
fn a_failed_request_leaves_the_state_as_it_was() {
    let _alone = alone();
    let points = plate().unwrap();
    let pairs: Vec<[usize; 2]> = (0..800).map(|point| [point, point + 1]).collect();
    let (_, tries) = with_ever_more_memory(|| {
        let granted = GRANTED.swap(i64::MAX, Ordering::Relaxed);
        let mut simulation = prepare(&points).unwrap();
        let time_step = simulation.stable_time_step().unwrap();
        simulation.step(time_step, 2).unwrap();
        let before = simulation.get(Field::Displacement).unwrap();
        let energy = simulation.energy().unwrap();
        GRANTED.store(granted, Ordering::Relaxed);
        let result = simulation.set_bond_integrity(&pairs, &[0.25; 800]);
        GRANTED.store(i64::MAX, Ordering::Relaxed);
        let after = simulation.energy().unwrap();
        assert_eq!(simulation.get(Field::Displacement).unwrap(), before);
        if result.is_err() {
            assert_eq!(after, energy);
        } else {
            assert!(after.elastic < energy.elastic && after.dissipated > energy.dissipated);
        }
        result
    });
    assert!(tries > 4, "{tries}");
}

#[test]
fn a_step_asks_for_no_memory() {
    let _alone = alone();
    let points = plate().unwrap();
    for threads in [1, 2] {
        let mut simulation = prepare(&points).unwrap();
        simulation.set_threads(threads).unwrap();
        let time_step = simulation.stable_time_step().unwrap();
        simulation.step(time_step, 1).unwrap();
        let before = LARGE_REQUESTS.load(Ordering::Relaxed);
        simulation.step(time_step, 50).unwrap();
        assert_eq!(LARGE_REQUESTS.load(Ordering::Relaxed), before, "{threads} threads");
    }
}

#[test]
fn a_step_of_any_formulation_asks_for_no_memory() {
    let _alone = alone();
    let points = Points::block(3, &[0.0; 3], &[12.0, 10.0, 6.0], 1.0).unwrap();
    for formulation in &FORMULATIONS {
        let mut model = Model::new(formulation.name).unwrap();
        for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015)] {
            model.set(key, value).unwrap();
        }
        if formulation.name != "bond_based" {
            model.set("poissons_ratio", 0.2).unwrap();
        }
        model.set("critical_stretch", 0.01).unwrap();
        for (threads, weakened) in [(1, false), (2, false), (2, true)] {
            let mut simulation = Simulation::new(&points, &model).unwrap();
            simulation.set_threads(threads).unwrap();
            if weakened {
                simulation.set_bond_integrity(&[[0, 1]], &[0.5]).unwrap();
            }
            // Some bonds break under way.
            let stretched = points.coordinates().iter().map(|x| 2e-4 * x * x);
            let displacement: Vec<f64> = stretched.collect();
            simulation.set(Field::Displacement, &displacement).unwrap();
            simulation.step(1e-3, 1).unwrap();
            let before = LARGE_REQUESTS.load(Ordering::Relaxed);
            simulation.step(1e-3, 5).unwrap();
            let requests = LARGE_REQUESTS.load(Ordering::Relaxed) - before;
            assert_eq!(requests, 0, "{}, {threads} threads, {weakened}", formulation.name);
        }
    }
}

#[test]
fn a_bond_of_a_cloud_that_can_break_takes_less_than_13_bytes_at_each_end_and_5_if_lean() {
    let _alone = alone();
    let lattice = Points::block(3, &[0.0; 3], &[40.0; 3], 1.0).unwrap();
    let jitter = |k: usize| 0.4 * ((k as f64 * 0.7548776662).fract() - 0.5);
    let places: Vec<f64> =
        lattice.coordinates().iter().enumerate().map(|(k, x)| x + jitter(k)).collect();
    let points = Points::new(3, &places, lattice.volumes()).unwrap();
    let mut model = model();
    model.set("horizon", 3.015).unwrap();
    // With what fills families up to whole blocks of eight: 12 and two bits, without the lengths 4.
    for (storage, allowed) in [("fast", 12.25..13.0), ("lean", 4.25..5.0)] {
        model.choose("storage", storage).unwrap();
        let simulation = Simulation::new(&points, &model).unwrap();
        let ends = 2.0 * simulation.bond_count().unwrap() as f64;
        let bytes = simulation.memory().bonds as f64 / ends;
        assert!(allowed.contains(&bytes), "{storage}: {bytes}");
    }
}

#[test]
fn a_lattice_keeps_no_bonds() {
    let _alone = alone();
    let points = Points::block(3, &[0.0; 3], &[64.0; 3], 1.0).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015)] {
        model.set(key, value).unwrap();
    }
    let mut simulation = Simulation::new(&points, &model).unwrap();
    let bonds = |simulation: &Simulation| {
        simulation.bond_count().unwrap();
        simulation.memory().bonds as f64 / points.count() as f64
    };
    // A bit a bond at points and in groups, 32; displacements of cells and forces of groups 48; where points and groups stand in
    // each other, 30.
    let bytes = bonds(&simulation);
    assert!((100.0..124.0).contains(&bytes), "{bytes}");
    assert!((simulation.memory().total() as f64) < 391.0 * points.count() as f64);
    // With the masks of the next step.
    model.set("critical_stretch", 0.1).unwrap();
    simulation = Simulation::new(&points, &model).unwrap();
    assert!((bytes + 15.0..bytes + 17.0).contains(&bonds(&simulation)));
}

/// In two sweeps and three, and what energies of bonds that break need.
#[test]
fn lattices_of_other_formulations_keep_none_either() {
    let _alone = alone();
    let points = Points::block(3, &[0.0; 3], &[48.0; 3], 1.0).unwrap();
    for (formulation, most, breaking) in [
        ("ordinary_state_based", 400.0, 146.0),
        ("correspondence", 765.0, 146.0),
        ("bond_associated_quadrature", 880.0, 243.0),
    ] {
        let mut model = Model::new(formulation).unwrap();
        let keys = [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015)];
        for (key, value) in keys.into_iter().chain([("poissons_ratio", 0.2)]) {
            model.set(key, value).unwrap();
        }
        let bytes = |model: &Model| {
            let simulation = Simulation::new(&points, model).unwrap();
            simulation.bond_count().unwrap();
            simulation.memory().total() as f64 / points.count() as f64
        };
        let whole = bytes(&model);
        assert!((0.95 * most..most).contains(&whole), "{formulation}: {whole}");
        model.set("critical_stretch", 0.1).unwrap();
        let more = bytes(&model) - whole;
        assert!((0.95 * breaking..breaking).contains(&more), "{formulation}: {more}");
    }
}

#[test]
fn the_bytes_told_are_the_bytes_held() {
    let _alone = alone();
    let points = Points::block(3, &[0.0; 3], &[20.0; 3], 1.0).unwrap();
    let mut model = model();
    model.set("horizon", 3.015).unwrap();
    let mut simulation = Simulation::new(&points, &model).unwrap();
    // As a cloud: a lattice keeps its stencil and masks beside it.
    simulation.set_lattices(false).unwrap();
    simulation.stable_time_step().unwrap();
    let memory = simulation.memory();
    let count = points.count();
    // Per lane a neighbour (4) and a length (8), per eight lanes two masks; per point an offset.
    let ends = 2 * simulation.bond_count().unwrap() as usize;
    let least = ends * 12 + ends / 8 * 2 + 8 * count;
    assert!(memory.bonds >= least, "{} {least}", memory.bonds);
    // Families are filled up to whole blocks of eight.
    assert!(memory.bonds <= least + count * 8 * 13 + 64, "{} {least}", memory.bonds);
    // Displacement, velocity, acceleration and force twice, dissipated energy twice; the mode of the stable step.
    let mode = 3 * 8 * count;
    let fields = count * (2 * 4 * 3 + 2) * 8 + 8 * count.div_ceil(256) + mode;
    // A line of 64 bytes a point for the sweep, laid where lines begin.
    let lines = memory.state - fields;
    assert!((64 * count..64 * count + 64).contains(&lines), "{lines}");
    assert!(memory.total() > memory.bonds);
}
