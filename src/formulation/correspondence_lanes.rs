//! Correspondence in lanes: the gradient of each point, its law, and what bonds pull by the stress and the penalty.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::Body;
use super::breaking::Near;
use super::correspondence::{Correspondence, deformation_at, gradient_at};
use super::gradient::Gradient;
use super::in_lanes::Which;
use super::kept_rows::{
    Order, Point, Points, Sweep, collocate, leave, leave_penalty, pull, pull_with_penalty,
};
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::{Asked, EnergyPart, Scene, in_lanes};
use crate::damage::Breaking;
use crate::kernel::family::Record;
use crate::kernel::gradient::UnseenSweep;
use crate::material::{Answer, Deformation};
use crate::tensor::{self, Tensor, Vector, contracted, difference, product, read, zero};
use crate::workers::{Outputs, PerPoint, PointByPoint};

/// Numbers of a row that other ends of bonds read where there is a penalty.
pub(super) const PENALTY_ROW: usize = 32;

/// Where forces of a sweep come from.
struct Pulls<'a> {
    correspondence: &'a Correspondence,
    records: &'a [Record],
    /// The first point whose material has failed.
    bad: AtomicUsize,
}

/// The force on a point, and the row that it leaves.
type ForceAndRow<'a, const C: usize> = (PerPoint<'a, f64>, PerPoint<'a, [f64; C]>);

impl Pulls<'_> {
    /// What a point pulls by itself, and what it leaves for others, from the answer of its law and from C and H of
    /// the penalty.
    #[inline(always)]
    fn give<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        point: usize,
        answer: &Answer<D>,
        rows: &[[f64; SIZE]],
        penalty: Option<[Tensor<D>; 2]>,
        kept: Point<'_, D, SIZE>,
        (force, left): ForceAndRow<'_, C>,
    ) {
        if !answer.energy.is_finite() {
            self.bad.fetch_min(point, Ordering::Relaxed);
        }
        let (record, left) = (&self.records[point], &mut left.0[0]);
        let own: Vector<D> = match penalty {
            None if self.correspondence.strong => {
                left[..D * D].copy_from_slice(answer.stress.as_flattened());
                [0.0; D]
            }
            None => {
                let kept = (self.correspondence.weights.horizons.at(point), kept);
                leave(record, &answer.stress, rows, kept, left)
            }
            Some([penalty, seen]) => {
                let pulled = product(&answer.stress, &read(rows.as_flattened()));
                let operator = difference(&pulled, &product(&penalty, &seen));
                leave_penalty(record, &operator, &penalty, kept, left)
            }
        };
        force.0.copy_from_slice(&own);
    }

    /// Of a point whose family spans the body.
    #[inline(always)]
    fn give_even<const D: usize, const SIZE: usize, const C: usize, const PENALTY: bool>(
        &self,
        point: usize,
        answer: &Answer<D>,
        gradient: &Tensor<D>,
        kept: Point<'_, D, SIZE>,
        outputs: ForceAndRow<'_, C>,
    ) {
        let penalty = PENALTY.then(|| [self.correspondence.kept_penalty(point, kept), *gradient]);
        self.give(point, answer, kept.rows(), penalty, kept, outputs);
    }

    /// Of a point whose family does not.
    fn give_odd<const D: usize, const SIZE: usize, const C: usize, const PENALTY: bool>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        kept: Point<'_, D, SIZE>,
        outputs: ForceAndRow<'_, C>,
    ) {
        let own = self.correspondence.own(body, point);
        let penalty = PENALTY.then(|| self.correspondence.penalty_of(body, point, &own));
        let rows = rows_of::<D, SIZE>(&own.gradient);
        self.give(point, &own.answer, &rows, penalty, kept, outputs);
    }
}

fn rows_of<const D: usize, const SIZE: usize>(gradient: &Gradient<D>) -> [[f64; SIZE]; D] {
    let mut rows = [[0.0; SIZE]; D];
    for (row, own) in rows.iter_mut().zip(&gradient.rows) {
        row.copy_from_slice(&own[..SIZE]);
    }
    rows
}

impl Correspondence {
    /// Rows of a point whose family may span the body or not.
    fn swept_rows<const D: usize, const SIZE: usize>(
        &self,
        body: &Body<'_, D>,
        kept: &Points<'_>,
        point: usize,
    ) -> [[f64; SIZE]; D] {
        let kept = kept.at::<D, SIZE>(point);
        match kept.rows().try_into() {
            Ok(rows) if kept.spans() => rows,
            _ => rows_of(&gradient_at(body, point, self.order).0),
        }
    }

    pub(super) fn order(&self) -> Order {
        let counts_volumes = self.is_stabilised();
        Order { order: self.order, counts_volumes }
    }

    /// C of a point whose family spans the body.
    fn kept_penalty<const D: usize, const SIZE: usize>(
        &self,
        point: usize,
        kept: Point<'_, D, SIZE>,
    ) -> Tensor<D> {
        let ratio = kept.volume() * kept.inverse_weight();
        self.penalty(point, &read(kept.rows().as_flattened()), ratio)
    }

    pub(super) fn swept_forces<
        const D: usize,
        const SIZE: usize,
        const C: usize,
        const PENALTY: bool,
    >(
        &self,
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, room, force, breaking, resting } = sweep;
        let (omega, count) = (self.kept.omega(scene, &self.weights)?, scene.places.len());
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let (left, _) = in_lanes::table::<C>(rest, count);
        let sweep = Sweep::new(scene, omega, records).resting(resting, 1);
        let pulls = Pulls { correspondence: self, records, bad: AtomicUsize::new(usize::MAX) };
        let kept = if self.laws.remember() {
            let outputs = (PerPoint(&mut *force, D), PerPoint(&mut *left, 1));
            let left = PerPoint(&mut *outputs.1.0, 1);
            let kept = self.asked_in_lanes::<D, SIZE, _>(
                sweep,
                room.records,
                None,
                left,
                |gradient, left| left.0[0][..D * D].copy_from_slice(gradient.as_flattened()),
            );
            let asked = Some(Asked { records: room.records, dissipated: false });
            let scene = &Scene { asked, ..*scene };
            let body = &Body::new(scene, &self.weights);
            scene.workers.sweep(count, outputs, |range, outputs| {
                let mut outputs = PointByPoint::new(outputs, range.start);
                for point in range {
                    let kept = kept.at::<D, SIZE>(point);
                    outputs.give(point, |outputs| {
                        if !kept.spans() {
                            return pulls
                                .give_odd::<D, SIZE, C, PENALTY>(body, point, kept, outputs);
                        }
                        let answer = self.laws.asked(body, point);
                        let gradient = read(&outputs.1.0[0]);
                        pulls.give_even::<D, SIZE, C, PENALTY>(
                            point, &answer, &gradient, kept, outputs,
                        );
                    });
                }
            });
            kept
        } else {
            self.elastic_pulls::<D, SIZE, C, PENALTY>(sweep, breaking, &pulls, (force, left))
        };
        // The point whose material has failed is to be named, and not one that it pulls on.
        let scene = &in_lanes::remaining(scene, breaking);
        let sweep = Sweep { scene, ..sweep };
        if let Some(point) = in_lanes::first(pulls.bad) {
            return Some(point);
        }
        if self.strong {
            let body = &Body::new(scene, &self.weights);
            let operators = |point| (self.swept_rows::<D, SIZE>(body, &kept, point), zero());
            return collocate(sweep, left, 0, operators, force);
        }
        match PENALTY {
            true => pull_with_penalty::<D, C>(sweep, left, force),
            false => pull::<D, C>(sweep, left, force),
        }
    }

    /// The first sweep for laws without memory: what points pull by themselves, and rows for others.
    fn elastic_pulls<const D: usize, const SIZE: usize, const C: usize, const PENALTY: bool>(
        &self,
        sweep: Sweep<'_>,
        breaking: &mut Option<Breaking<'_>>,
        pulls: &Pulls<'_>,
        (force, left): (&mut [f64], &mut [[f64; C]]),
    ) -> Points<'_> {
        let kept = self.kept.sweep::<D, SIZE, _>(
            self.order(),
            sweep,
            breaking,
            (PerPoint(&mut *force, D), PerPoint(&mut *left, 1)),
            |_| true,
            |point, kept, gradient, outputs| {
                let answer = self.laws.at(point).answer(&Deformation::whole(gradient));
                pulls.give_even::<D, SIZE, C, PENALTY>(point, &answer, gradient, kept, outputs);
            },
        );
        let scene = &in_lanes::remaining(sweep.scene, breaking);
        let body = &Body::new(scene, &self.weights);
        let outputs = (PerPoint(force, D), PerPoint(left, 1));
        kept.odd::<D, SIZE, _>(scene, outputs, |point, kept, outputs| {
            pulls.give_odd::<D, SIZE, C, PENALTY>(body, point, kept, outputs);
        });
        kept
    }

    /// The same of points without a seat on the lattice that a body has. Gives the first whose material has failed.
    pub(super) fn pulls_beyond<const D: usize, const C: usize>(
        &self,
        sweep: Sweep<'_>,
        breaking: &mut Option<Breaking<'_>>,
        outputs: (&mut [f64], &mut [[f64; C]]),
    ) -> Option<usize> {
        let (sweep, bad) = (Sweep { which: Which::Listed, ..sweep }, AtomicUsize::new(usize::MAX));
        let pulls = Pulls { correspondence: self, records: sweep.records, bad };
        drop(self.elastic_pulls::<D, D, C, false>(sweep, breaking, &pulls, outputs));
        in_lanes::first(pulls.bad)
    }

    /// Makes the records of laws, near broken bonds only if `near` says so, and puts gradients where they are wanted.
    fn asked_in_lanes<const D: usize, const SIZE: usize, O: Outputs>(
        &self,
        sweep: Sweep<'_>,
        records: &mut [f64],
        near: Option<&Near<'_>>,
        gradients: O,
        put: impl Fn(&Tensor<D>, O) + Sync,
    ) -> Points<'_> {
        let (laws, scene) = (&self.laws, sweep.scene);
        if near.is_some() {
            records.copy_from_slice(scene.bonds.records);
        }
        let wanted = |point| near.is_none_or(|near| near.wants_energy(point));
        let outputs = (PerPoint(&mut *records, laws.width()), gradients);
        let kept = self.kept.sweep::<D, SIZE, _>(
            self.order(),
            sweep,
            &mut None,
            outputs,
            wanted,
            |point, _, gradient, (record, to)| {
                put(gradient, to);
                laws.defer_at(scene, (point, point), &Deformation::whole(gradient), record.0);
            },
        );
        let body = &Body::<D>::new(scene, &self.weights);
        let outputs = PerPoint(&mut *records, laws.width());
        kept.odd::<D, SIZE, _>(scene, outputs, |point, _, record| {
            if wanted(point) {
                let deformation = deformation_at(body, point, self.order);
                laws.remember_at(scene, (point, point), &deformation, record.0);
            }
        });
        let outputs = PerPoint(&mut *records, laws.width());
        scene.workers.sweep(scene.places.len(), outputs, |range, new| {
            laws.settle(scene, range.clone(), &|site| range.start + site, new.0);
        });
        laws.ask_host(scene, records);
        kept
    }

    pub(super) fn swept_energy<const D: usize, const SIZE: usize>(
        &self,
        sweep: EnergySweep<'_>,
    ) -> bool {
        let EnergySweep { scene, room, density, part, near } = sweep;
        let Some(omega) = self.kept.omega(scene, &self.weights) else { return false };
        let count = scene.places.len();
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let sweep = Sweep::new(scene, omega, records);
        let wanted = |point| near.is_none_or(|near| near.wants_energy(point));
        density.fill(0.0);
        if part == EnergyPart::Stabilization {
            let (gradients, _) = in_lanes::table::<PENALTY_ROW>(rest, count);
            self.penalty_energy::<D, SIZE>(sweep, gradients, density, wanted);
            return true;
        }
        if self.laws.remember() {
            drop(self.asked_in_lanes::<D, SIZE, _>(sweep, room.records, near, (), |_, ()| ()));
            let dissipated = part == EnergyPart::Plastic;
            let asked = Some(Asked { records: room.records, dissipated });
            let asked = &Scene { asked, ..*scene };
            let body = &Body::<D>::new(asked, &self.weights);
            scene.workers.sweep(count, PerPoint(density, 1), |range, density| {
                for (density, point) in density.0.iter_mut().zip(range) {
                    if wanted(point) {
                        *density = self.laws.asked(body, point).energy;
                    }
                }
            });
            return true;
        }
        let energy = |point: usize, gradient: &_| {
            self.laws.at(point).answer(&Deformation::<D>::whole(gradient)).energy
        };
        let kept = self.kept.sweep::<D, SIZE, _>(
            self.order(),
            sweep,
            &mut None,
            PerPoint(&mut *density, 1),
            wanted,
            |point, _, gradient, density| density.0[0] = energy(point, gradient),
        );
        let body = &Body::<D>::new(scene, &self.weights);
        kept.odd::<D, SIZE, _>(scene, PerPoint(density, 1), |point, _, density| {
            if wanted(point) {
                density.0[0] = self.own(body, point).answer.energy;
            }
        });
        true
    }

    pub(super) fn swept_fields<const D: usize, const SIZE: usize>(
        &self,
        sweep: FieldSweep<'_>,
    ) -> bool {
        let FieldSweep { scene, room, values, width, read } = sweep;
        let Some(omega) = self.kept.omega(scene, &self.weights) else { return false };
        let count = scene.places.len();
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let sweep = Sweep::new(scene, omega, records);
        let shown = |body: &Body<'_, D>, point: usize, gradient: &Tensor<D>, values: &mut [f64]| {
            let deformation = Deformation::whole(gradient);
            let answer = self.laws.answer(body, point, point, &deformation);
            read(&self.laws.kinematics(body, point, &deformation, &answer), values);
        };
        let outputs = PerPoint(&mut *values, width);
        let (kept, asked) = if self.laws.remember() {
            let (gradients, _) = in_lanes::table::<9>(rest, count);
            let kept = self.asked_in_lanes::<D, SIZE, _>(
                sweep,
                room.records,
                None,
                PerPoint(&mut *gradients, 1),
                |gradient, row| row.0[0][..D * D].copy_from_slice(gradient.as_flattened()),
            );
            let asked = Some(Asked { records: room.records, dissipated: false });
            let asked = Scene { asked, ..*scene };
            let body = &Body::new(&asked, &self.weights);
            scene.workers.sweep(count, outputs, |range, values| {
                for (values, point) in values.0.chunks_exact_mut(width).zip(range) {
                    if kept.at::<D, SIZE>(point).spans() {
                        shown(body, point, &tensor::read(&gradients[point]), values);
                    }
                }
            });
            (kept, asked)
        } else {
            let body = &Body::new(scene, &self.weights);
            let kept = self.kept.sweep::<D, SIZE, _>(
                self.order(),
                sweep,
                &mut None,
                outputs,
                |_| true,
                |point, _, gradient, values| shown(body, point, gradient, values.0),
            );
            (kept, *scene)
        };
        let body = &Body::<D>::new(&asked, &self.weights);
        kept.odd::<D, SIZE, _>(scene, PerPoint(values, width), |point, _, values| {
            read(&self.kinematics_at(body, point, &[]), values.0);
        });
        true
    }

    /// sum 1/2 z.C z w V
    fn penalty_energy<const D: usize, const SIZE: usize>(
        &self,
        sweep: Sweep<'_>,
        gradients: &mut [[f64; PENALTY_ROW]],
        density: &mut [f64],
        wanted: impl Fn(usize) -> bool + Sync,
    ) {
        let scene = sweep.scene;
        let kept = self.kept.sweep::<D, SIZE, _>(
            self.order(),
            sweep,
            &mut None,
            PerPoint(&mut *gradients, 1),
            &wanted,
            |_, _, gradient, row| row.0[0][..D * D].copy_from_slice(gradient.as_flattened()),
        );
        let family = in_lanes::family(scene, sweep.records, sweep.omega);
        let even = |point: usize| wanted(point) && kept.at::<D, SIZE>(point).spans();
        scene.workers.sweep(density.len(), PerPoint(&mut *density, 1), |range, density| {
            let first = range.start;
            scene.simd.run(UnseenSweep {
                family,
                range,
                gradient: |point: usize| even(point).then(|| read::<D>(&gradients[point])),
                finish: |point: usize, unseen: &Tensor<D>| {
                    let penalty = self.kept_penalty(point, kept.at::<D, SIZE>(point));
                    density.0[point - first] = 0.5 * contracted(&penalty, unseen);
                },
            });
        });
        let body = &Body::<D>::new(scene, &self.weights);
        kept.odd::<D, SIZE, _>(scene, PerPoint(density, 1), |point, _, density| {
            if wanted(point) {
                density.0[0] = self.stabilisation_at(body, point);
            }
        });
    }
}
