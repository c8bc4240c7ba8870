//! Correspondence on the part of a body that is a lattice: gradients and pulls of eight points at once, laws asked between.

use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::Body;
use super::correspondence::Correspondence;
use super::kept_rows::{Sweep, pull};
use super::lattice_rows::{self as on_lattice, Gradients, LatticeRows, Seat};
use super::on_lattice::{Columns, OnLattice, Parts};
use super::passes::ForceSweep;
use super::{Scene, in_lanes};
use crate::families::LANES;
use crate::families::lattice::{Lattice, NOBODY};
use crate::kernel::elastic::{AskEach, ElasticLaw};
use crate::kernel::lattice::Stresses;
use crate::material::Answer;
use crate::tensor::{Tensor, product, scaled};

impl Correspondence {
    /// Whether its sweeps are faster on a lattice.
    pub(super) fn fits_lattice(&self) -> bool {
        let elastic = !(self.laws.remember() || self.is_stabilised());
        !self.strong && elastic && self.order == 1 && self.weights.are_shared()
    }

    /// `N` = `D` x `D`, `C` = 4 (`D` + 1).
    pub(super) fn forces_on_lattice<const D: usize, const N: usize, const C: usize>(
        &self,
        (lattice, rows): (&Lattice, &LatticeRows),
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, room, force, breaking, resting } = sweep;
        let (omega, count) = (self.kept.omega(scene, &self.weights)?, scene.places.len());
        let mut failed = None;
        let mut beyond = rows.state.seam.as_ref().map(|seam| {
            let (records, rest) = seam.record::<D>(scene, room.tables);
            let (left, _) = in_lanes::table::<C>(rest, count);
            let sweep = Sweep::new(scene, omega, records).resting(resting, 1);
            failed = self.pulls_beyond::<D, C>(sweep, breaking, (&mut *force, &mut *left));
            (seam, sweep, left)
        });
        let rule = breaking.as_ref().map(|breaking| breaking.rule);
        let on = OnLattice::breaking(scene, (lattice, &rows.state), rule, resting);
        let bad = AtomicUsize::new(usize::MAX);
        let noted = |point: usize, answer: Answer<D>| {
            if !answer.energy.is_finite() {
                bad.fetch_min(point, Ordering::Relaxed);
            }
            answer.stress
        };
        let (quadratics, of_points) = (self.laws.quadratics(), self.laws.of_points()?);
        let ask = |group: usize, lanes: Range<usize>, gradients: &mut [[[f64; LANES]; D]; D]| {
            let members = &lattice.members[group * LANES..(group + 1) * LANES];
            let law = |lane: usize| match members[lane] {
                NOBODY => ElasticLaw::NONE,
                member => of_points(member as usize),
            };
            let (laws, energies) = (&[std::array::from_fn(law)], &mut [0.0; LANES]);
            scene.simd.run(AskEach { laws, lanes, gradients, energies });
        };
        let any_odd = Cell::new(false);
        let first = |parts: &mut Parts<'_, D, N>| {
            let take = |force: &mut [f64], left: Columns<'_, N>, gradients: Gradients<'_, D>| {
                let mut stresses =
                    Stresses { laws: quadratics, ask, force, left: left.values, bad: None };
                gradients.give(&mut stresses);
                bad.fetch_min(stresses.bad.unwrap_or(usize::MAX), Ordering::Relaxed);
            };
            let order = (self.order(), omega.horizon);
            any_odd.set(rows.sweep(&on, scene, order, parts, 1, take));
        };
        let second = |mut parts: Parts<'_, D, N>, scene: &Scene<'_>, _: &mut [f64]| {
            let unit = parts.unit;
            if any_odd.get() {
                let body = &Body::<D>::new(scene, &self.weights);
                let outputs = (parts.forces.again(), parts.left.again());
                rows.kept().each_seat(scene, lattice, outputs, |mut seat: Seat<'_, '_, D, N>| {
                    if !seat.is_odd() {
                        return;
                    }
                    let own = self.own(body, seat.point);
                    let stress = noted(seat.point, own.answer);
                    let rows = &own.gradient.rows;
                    let rows: Tensor<D> = rows.map(|row| std::array::from_fn(|k| row[k]));
                    let tensor = scaled(&product(&stress, &rows), lattice.volume * unit * unit);
                    seat.pull(&tensor, &[0.0; D]);
                });
            }
            let Parts { groups, masks, forces, mut left, .. } = parts;
            if let Some((seam, sweep, rows)) = &mut beyond {
                seam.exchange_tensors::<D, N, C>(*sweep, unit, &mut left, rows);
            }
            on_lattice::pull((&on, scene), groups, (forces, masks), left);
            unit.recip()
        };
        let influence = |length: f64| omega.at(length);
        let found = on.sweep(scene, influence, first, second, force, breaking);
        // The point whose material has failed is to be named, and not one that it pulls on.
        let failed = in_lanes::first(bad).into_iter().chain(failed).min();
        let found = (found != usize::MAX).then_some(found);
        let Some((_, sweep, left)) = beyond else { return failed.or(found) };
        let sweep = Sweep { scene: &in_lanes::remaining(scene, breaking), ..sweep };
        let other = pull::<D, C>(sweep, left, force);
        failed.or_else(|| found.into_iter().chain(other).min())
    }
}
