//! What is a lattice, and which points of a body are on it.

use super::*;
use crate::families::{Property, Storage, Wanted, find};
use crate::kernel::simd::SimdLevel;
use crate::workers::Workers;

fn block(counts: [usize; 3], spacing: [f64; 3]) -> Vec<Place> {
    let mut places = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                let [x, y, z] = [x, y, z].map(|k| k as f64 + 0.5);
                places.push([x * spacing[0], y * spacing[1], z * spacing[2], 2.0]);
            }
        }
    }
    places
}

fn lattice(places: &[Place], horizon: f64) -> (Families, Option<Lattice>) {
    let host: Vec<u32> = (0..places.len() as u32).collect();
    let families = find(Wanted {
        workers: &Workers::new(1).unwrap(),
        simd: SimdLevel::Baseline,
        dimension: 3,
        places: places.to_vec(),
        horizons: &Property::Uniform(horizon),
        rim: None,
        farthest: 1.0,
        storage: Storage::Fast,
        host: &host,
    })
    .unwrap();
    let lattice = Lattice::find(places, &families, 1.0).unwrap();
    (families, lattice)
}

/// Each bond of a member is a step of the stencil, to the cell of its other end.
fn check(places: &[Place], families: &Families, lattice: &Lattice) {
    for (point, &seat) in lattice.seat_of.iter().enumerate() {
        if seat == NOBODY {
            continue;
        }
        let cell = lattice.cell(seat as usize);
        assert_eq!(lattice.point_of[cell] as usize, point);
        for bond in families.bonds(point) {
            let step = lattice.stencil.iter().find(|step| {
                lattice.point_of[cell.wrapping_add_signed(step.cells)] as usize == bond.neighbor
            });
            let step = step.unwrap();
            for (axis, reference) in step.reference.iter().enumerate() {
                let xi = places[bond.neighbor][axis] - places[point][axis];
                assert!((xi - reference).abs() < 1e-13);
            }
            assert!((lattice.volume / places[point][3] - 1.0).abs() < 1e-13);
        }
    }
}

#[test]
fn a_block_is_a_lattice_whatever_its_spacings() {
    for spacing in [[0.1; 3], [0.1, 0.07, 0.13]] {
        let places = block([11, 16, 9], spacing);
        let (families, lattice) = lattice(&places, 0.301);
        let lattice = lattice.unwrap();
        assert_eq!(lattice.count, places.len());
        check(&places, &families, &lattice);
    }
}

#[test]
fn a_plate_one_point_thick_is_a_lattice() {
    let places = block([40, 30, 1], [0.1; 3]);
    let (families, lattice) = lattice(&places, 0.301);
    let lattice = lattice.unwrap();
    assert_eq!((lattice.count, lattice.stencil.len()), (1200, 28));
    check(&places, &families, &lattice);
}

#[test]
fn points_near_those_off_the_grid_are_not_members() {
    let mut places = block([16, 12, 12], [0.1; 3]);
    places[700][1] += 1e-6;
    places[20][3] *= 1.001;
    let (families, lattice) = lattice(&places, 0.301);
    let lattice = lattice.unwrap();
    let near = |point: usize| {
        [700, 20].contains(&point)
            || families.bonds(point).any(|bond| [700, 20].contains(&bond.neighbor))
    };
    for point in 0..places.len() {
        assert_eq!(lattice.seat_of[point] == NOBODY, near(point), "{point}");
    }
    check(&places, &families, &lattice);
}

#[test]
fn what_is_mostly_empty_or_jittered_is_none() {
    let row: Vec<Place> = (0..200).map(|k| [0.1 * k as f64, 0.1 * k as f64, 0.0, 1.0]).collect();
    assert!(lattice(&row, 0.301).1.is_none());
    let mut cloud = block([10, 10, 10], [0.1; 3]);
    for (k, place) in cloud.iter_mut().enumerate() {
        place[k % 3] += 1e-3 * (k as f64 * 0.7548776662).fract();
    }
    assert!(lattice(&cloud, 0.301).1.is_none());
}
