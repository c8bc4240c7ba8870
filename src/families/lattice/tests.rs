//! What is a lattice, and which points of a body are on it.

use super::*;
use crate::families::{Families, Property, Storage, Wanted, find};
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

fn found(places: &[Place], horizon: f64, lattice: LatticeUse) -> Families {
    found_of_kinds(places, horizon, lattice, None)
}

fn found_of_kinds(
    places: &[Place],
    horizon: f64,
    lattice: LatticeUse,
    kinds: Option<&[u16]>,
) -> Families {
    let host: Vec<u32> = (0..places.len() as u32).collect();
    find(Wanted {
        workers: &Workers::new(1).unwrap(),
        simd: SimdLevel::Baseline,
        dimension: 3,
        places: places.to_vec(),
        horizons: &Property::Uniform(horizon),
        rim: None,
        farthest: 1.0,
        storage: Storage::Fast,
        lattice,
        kinds,
        host: &host,
    })
    .unwrap()
}

/// The families as lists, and on a lattice.
fn lattice(places: &[Place], horizon: f64) -> (Families, Option<Families>) {
    let on_lattice = found(places, horizon, LatticeUse::Groups);
    let found = found(places, horizon, LatticeUse::None);
    (found, on_lattice.lattice.is_some().then_some(on_lattice))
}

/// All bonds are those of the lists, by the same bits, and from both ends; those of members are steps of the stencil.
fn check(places: &[Place], listed: &Families, families: &Families) {
    let lattice = families.lattice.as_ref().unwrap();
    for point in 0..places.len() {
        let sorted = |families: &Families| {
            let bonds = families.bonds(point).map(|bond| (bond.neighbor, bond.length.to_bits()));
            let mut bonds: Vec<_> = bonds.collect();
            bonds.sort_unstable();
            bonds
        };
        assert_eq!(sorted(listed), sorted(families));
        for bond in families.bonds(point) {
            let there = families.between(point, bond.neighbor).unwrap();
            assert_eq!((there.slot, there.neighbor), (bond.slot, bond.neighbor));
            let back = families.between(bond.neighbor, point).unwrap();
            assert_eq!(back.length.to_bits(), bond.length.to_bits());
        }
        assert!(families.between(point, point).is_none());
        // The next ones may stand in the next row.
        for other in [point * 7 + 3, point + 1, point + 3].map(|other| other % places.len()) {
            let bonded = |families: &Families| families.between(point, other).is_some();
            assert_eq!(bonded(listed), bonded(families));
        }
        let mut masks = vec![0; families.blocks(point).len()];
        families.mark_bonds(point, &mut masks);
        let ends = masks.iter().map(|mask| mask.count_ones() as usize);
        assert_eq!(ends.sum::<usize>(), listed.bonds(point).count());
        let Some(cell) = lattice.member(point) else { continue };
        assert_eq!(lattice.cell(lattice.seat_of[point] as usize), cell);
        assert_eq!(lattice.point_of[cell] as usize, point);
        let first = families.blocks(point).start * LANES;
        for bond in families.bonds(point) {
            let step = &lattice.stencil[bond.slot - first];
            for (axis, reference) in step.reference.iter().enumerate() {
                let xi = places[bond.neighbor][axis] - places[point][axis];
                assert!((xi - reference).abs() < 1e-13);
            }
            assert!((lattice.volume / places[point][3] - 1.0).abs() < 1e-13);
        }
    }
}

#[test]
fn lanes_are_named_by_the_bonds_of_lists() {
    let places = block([21, 13, 11], [0.1; 3]);
    let listed = found(&places, 0.3015, LatticeUse::None);
    for lattice_use in [LatticeUse::Groups, LatticeUse::Pairs] {
        let families = found(&places, 0.3015, lattice_use);
        assert!(families.lattice.is_some() && families.neighbors.is_empty());
        for point in 0..places.len() {
            let blocks = families.blocks(point);
            let (mut masks, first) = (vec![0; blocks.len()], blocks.start * LANES);
            families.mark_bonds(point, &mut masks);
            let mut names = vec![u32::MAX; blocks.len() * LANES];
            let (front, back) = names.split_at_mut(3 * LANES);
            families.name(point, first, front);
            families.name(point, first + front.len(), back);
            let named = names.iter().enumerate().filter_map(|(lane, &name)| {
                assert!((name as usize) < places.len());
                (masks[lane / LANES] >> (lane % LANES) & 1 == 1).then_some(name as usize)
            });
            let mut named: Vec<_> = named.collect();
            named.sort_unstable();
            let mut bonds: Vec<_> = listed.bonds(point).map(|bond| bond.neighbor).collect();
            bonds.sort_unstable();
            assert_eq!(named, bonds);
        }
        check(&places, &listed, &families);
    }
}

#[test]
fn rows_stand_without_gaps_where_no_pairs_are_wanted() {
    // Rows as long as the stencil, longer, and shorter: gaps are needed where two steps would lead to one cell.
    let dense = [0.3, 0.02, 0.3];
    for (counts, spacing, row) in
        [([9, 31, 9], dense, 31), ([9, 12, 10], [0.1; 3], 12), ([9, 30, 9], dense, 48)]
    {
        let places = block(counts, spacing);
        let listed = found(&places, 0.3015, LatticeUse::None);
        let [packed, pairs] = [LatticeUse::Groups, LatticeUse::Pairs].map(|lattice_use| {
            let families = found(&places, 0.3015, lattice_use);
            check(&places, &listed, &families);
            families.lattice.unwrap()
        });
        assert_eq!(packed.next_row, row, "{counts:?}");
        assert_eq!(pairs.next_row % LANES, 0, "{counts:?}");
        let groups = [&packed, &pairs].map(|lattice| lattice.groups.len());
        assert!(groups[0] < groups[1] || row == pairs.next_row, "{counts:?}: {groups:?}");
    }
}

#[test]
fn a_block_is_a_lattice_whatever_its_spacings() {
    for spacing in [[0.1; 3], [0.1, 0.07, 0.13]] {
        let places = block([11, 16, 9], spacing);
        let (listed, families) = lattice(&places, 0.301);
        let families = families.unwrap();
        let lattice = families.lattice.as_ref().unwrap();
        assert_eq!(lattice.count, places.len());
        check(&places, &listed, &families);
    }
}

#[test]
fn a_plate_one_point_thick_is_a_lattice() {
    let places = block([40, 30, 1], [0.1; 3]);
    let (listed, families) = lattice(&places, 0.301);
    let families = families.unwrap();
    let lattice = families.lattice.as_ref().unwrap();
    assert_eq!((lattice.count, lattice.stencil.len()), (1200, 28));
    check(&places, &listed, &families);
}

#[test]
fn points_near_those_off_the_grid_are_not_members() {
    let mut places = block([16, 12, 12], [0.1; 3]);
    places[700][1] += 1e-6;
    places[20][3] *= 1.001;
    let (listed, families) = lattice(&places, 0.301);
    let families = families.unwrap();
    let lattice = families.lattice.as_ref().unwrap();
    let near = |point: usize| {
        [700, 20].contains(&point)
            || listed.bonds(point).any(|bond| [700, 20].contains(&bond.neighbor))
    };
    for point in 0..places.len() {
        assert_eq!(lattice.seat_of[point] == NOBODY, near(point), "{point}");
    }
    check(&places, &listed, &families);
}

#[test]
fn bonds_of_members_lead_to_their_own_kind() {
    let counts = [40, 9, 8];
    let places = block(counts, [0.1; 3]);
    // Layers across rows, of which the third is like the first, and a point.
    let kind_of = |point: usize| match point % counts[0] {
        0..12 => 5,
        12..20 => 2,
        20..32 if point == 40 * (9 * 4 + 4) + 29 => 7,
        20..32 => 5,
        _ => 0,
    };
    let kinds: Vec<u16> = (0..places.len()).map(kind_of).collect();
    let listed = found(&places, 0.301, LatticeUse::None);
    for lattice_use in [LatticeUse::Groups, LatticeUse::Pairs] {
        let families = found_of_kinds(&places, 0.301, lattice_use, Some(&kinds));
        let lattice = families.lattice.as_ref().unwrap();
        check(&places, &listed, &families);
        let seats = lattice.members.iter().enumerate().filter(|(_, point)| **point != NOBODY);
        for (seat, &point) in seats.clone() {
            let sample = lattice.sample(lattice.kind(seat / LANES));
            assert_eq!(kinds[sample], kinds[point as usize]);
            let mut near = listed.bonds(point as usize);
            assert!(near.all(|bond| kinds[bond.neighbor] == kinds[point as usize]));
        }
        assert_eq!(lattice.count, seats.count());
        let alike =
            |point: &usize| listed.bonds(*point).all(|bond| kinds[bond.neighbor] == kinds[*point]);
        let most = (0..places.len()).filter(alike).count();
        assert!(lattice.count > most * 9 / 10 && lattice.count < most, "{} {most}", lattice.count);
        assert_eq!(lattice.kinds(), 3);
    }
}

#[test]
fn holes_and_points_off_the_grid_at_the_ends_of_rows_are_seen() {
    let (counts, ends) = ([16, 12, 12], [0, 15, 16, 700 - 700 % 16, 16 * 12 * 5 + 15]);
    let mut places = block(counts, [0.1; 3]);
    places[ends[3]][2] += 1e-6;
    for hole in [ends[4], ends[2], ends[1], ends[0]] {
        places.remove(hole);
    }
    let (listed, families) = lattice(&places, 0.301);
    let families = families.unwrap();
    assert!(families.lattice.as_ref().is_some_and(|lattice| lattice.count < places.len()));
    check(&places, &listed, &families);
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

/// Rounding decides about each bond that is as long as the horizon, and both ends must come to the same.
#[test]
fn bonds_as_long_as_the_horizon_are_those_of_the_lists() {
    let mut places = block([14, 12, 10], [0.1; 3]);
    for (k, place) in places.iter_mut().enumerate() {
        for (axis, x) in place[..3].iter_mut().enumerate() {
            *x += 4e-15 * (((k + 7 * axis) as f64 * 0.7548776662).fract() - 0.5);
        }
    }
    // The tolerance of horizons is taken off, so that the radius falls on the shell itself.
    for horizon in [0.3, 0.2 * 2.0_f64.sqrt()] {
        let (listed, families) = lattice(&places, horizon / (1.0 + 1e-10));
        let families = families.unwrap();
        let counts: Vec<usize> = (0..places.len()).map(|k| listed.bonds(k).count()).collect();
        let inner = |k: &usize| (3..11).contains(&(k % 14)) && (3..9).contains(&(k / 14 % 12));
        let inside: Vec<usize> = (4 * 168..5 * 168).filter(inner).map(|k| counts[k]).collect();
        assert!(inside.iter().min() < inside.iter().max(), "rounding has decided nothing");
        check(&places, &listed, &families);
    }
}

#[test]
fn bits_are_turned_about_the_diagonal() {
    let bytes = [0x9e, 0x37, 0x79, 0xb9, 0x7f, 0x4a, 0x7c, 0x15];
    let turned = transposed(bytes);
    for (n, byte) in bytes.iter().enumerate() {
        for (k, other) in turned.iter().enumerate() {
            assert_eq!(byte >> k & 1, other >> n & 1);
        }
    }
}
