//! Bond-associated quadrature points in lanes: gradients of points, laws at the middles of bonds, and what bonds pull
//! by themselves and through the gradients of their ends.
//!
//! Elastic laws, of one material or several, are asked in lanes; what laws with memory have answered is read in lanes where there is one material, and bond
//! by bond where there are several. Points with an end of a bond that does
//! not span the body are computed by single bonds.

use std::cell::RefCell;
use std::ops::Range;

use super::body::Body;
use super::bond_associated_quadrature::{Baqp, MOST_LEFT, before_rows};
use super::calm::Resting;
use super::correspondence::gradient_at;
use super::in_lanes::Which;
use super::kept_rows::{Order, Point, Points, Sweep, leave, pull};
use super::kinematics::Kinematics;
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::{Asked, EnergyPart, Read, Scene, in_lanes};
use crate::damage::Breaking;
use crate::families::LANES;
use crate::kernel::family::{Record, Table};
use crate::kernel::quadrature::{
    Answered, BondByBond, BondLaw, BondMeans, BondStresses, Middles, odd_place, weight_place,
};
use crate::material::{Across, Answer, Deformation, Record as Remembered};
use crate::tensor::{self, Tensor, Vector, identity, zero};
use crate::workers::{Outputs, PerPoint, Ragged};

/// Numbers of a row of the table of gradients.
pub(super) const GRADIENT: usize = 12;

fn gradient_row<const D: usize, const SIZE: usize>(
    gradient: &Tensor<D>,
    kept: Point<'_, D, SIZE>,
    odd: f64,
) -> [f64; GRADIENT] {
    let mut row = [0.0; GRADIENT];
    row[..D * D].copy_from_slice(gradient.as_flattened());
    row[weight_place(D)] = kept.inverse_weight();
    row[odd_place(D)] = odd;
    row
}

/// The row of a point with these halves, of its gradient and of 1/sum w V, which is none where its family does not span the body.
pub(super) fn row_of_halves<const D: usize>(halves: &[f64]) -> [f64; GRADIENT] {
    let (gradient, weight) = halves.split_at(D * D);
    let mut row = [0.0; GRADIENT];
    row.iter_mut().zip(gradient).for_each(|(value, half)| *value = 2.0 * half);
    row[weight_place(D)] = 2.0 * weight[0];
    row[odd_place(D)] = f64::from(u8::from(weight[0].is_nan()));
    row
}

/// The halves of a row.
pub(super) fn halves_of_row<const D: usize, const A: usize>(row: &[f64; GRADIENT]) -> [f64; A] {
    let weight = if row[odd_place(D)] == 0.0 { row[weight_place(D)] } else { f64::NAN };
    std::array::from_fn(|k| 0.5 * if k < D * D { row[k] } else { weight })
}

/// What the first pass would leave of a point whose family spans the body, from 1/sum w V, its gradient and its rows.
pub(super) fn left_of<const D: usize>(
    inverse_weight: f64,
    gradient: &[f64],
    rows: &[f64],
) -> [f64; MOST_LEFT] {
    let mut numbers = [0.0; MOST_LEFT];
    (numbers[0], numbers[1]) = (inverse_weight, D as f64);
    numbers[2..2 + D * D].copy_from_slice(gradient);
    let whole: Tensor<D> = identity();
    numbers[2 + D * D..before_rows(D)].copy_from_slice(whole.as_flattened());
    numbers[before_rows(D)..][..rows.len()].copy_from_slice(rows);
    numbers
}

/// Gradients of points that have been swept in lanes, and what is kept of their families.
struct Swept<'a, const D: usize, const SIZE: usize> {
    baqp: &'a Baqp,
    body: Body<'a, D>,
    middles: Middles<'a, GRADIENT>,
    records: &'a [Record],
    gradients: &'a [[f64; GRADIENT]],
    kept: &'a Points<'a>,
    /// Where nothing happens.
    resting: Resting<'a>,
}

impl<const D: usize, const SIZE: usize> Swept<'_, D, SIZE> {
    /// What the first pass would leave of a point.
    fn left(&self, point: usize) -> [f64; MOST_LEFT] {
        let kept: Point<'_, D, SIZE> = self.kept.at(point);
        let scene = self.body.scene;
        let swept = scene.lattice().is_none() || scene.families.is_listed(point);
        if !(swept && kept.spans()) {
            // Of members of a lattice other sweeps keep the rows.
            return self.baqp.prepared(&self.body, point);
        }
        let gradient = &self.gradients[point][..D * D];
        left_of::<D>(kept.inverse_weight(), gradient, kept.rows().as_flattened())
    }

    /// Calls `leaf` for parts of all points, with the middles of their bonds.
    fn sweep<O: Outputs>(
        &self,
        outputs: O,
        leaf: impl Fn(Middles<'_, GRADIENT>, Range<usize>, O) + Sync,
    ) {
        let Middles { family, table } = self.middles;
        in_lanes::sweep(self.body.scene, family, Which::All, outputs, |family, range, outputs| {
            leaf(Middles { family, table }, range, outputs);
        });
    }

    /// Makes the records of laws, of the points that are wanted.
    fn ask(&self, records: &mut [f64], wanted: impl Fn(usize) -> bool + Sync) {
        let (laws, scene) = (&self.baqp.laws, self.body.scene);
        let (offsets, width) = (&scene.families.offsets, laws.width());
        let outputs = Ragged { values: &mut *records, offsets, width: LANES * width };
        scene.workers.sweep(scene.places.len(), outputs, |range, new| {
            let first = offsets[range.start] as usize * LANES;
            let new = RefCell::new(new.values);
            let of =
                |sites: Range<usize>| (sites.start - first) * width..(sites.end - first) * width;
            let sites = |point: usize| {
                let blocks = scene.families.blocks(point);
                blocks.start * LANES..blocks.end * LANES
            };
            // Read in their order, committed records are at hand when laws are asked.
            let begin = |point: usize| {
                let Range { start, end } = sites(point);
                let old = &scene.bonds.records[start * width..end * width];
                new.borrow_mut()[of(start..end)].copy_from_slice(old);
            };
            let settle = |point: usize| {
                let own = &mut new.borrow_mut()[of(sites(point))];
                laws.settle(scene, sites(point), &|_| point, own);
            };
            scene.simd.run(BondStresses {
                middles: self.middles,
                law: BondByBond(|point, site, _, gradient: &Tensor<D>| {
                    let (deformation, new) = (Deformation::whole(gradient), &mut *new.borrow_mut());
                    let own = &mut new[of(site..site + 1)];
                    laws.defer_at(scene, (point, site), &deformation, own);
                    (0.0, zero())
                }),
                range,
                wanted: |point| {
                    begin(point);
                    wanted(point)
                },
                finish: |point, _: &_, _: &_, odd| {
                    let left = |point| self.left(point);
                    if odd {
                        begin(point);
                        Baqp::each_quadrature(&self.body, point, left, |link, at| {
                            let own = &mut new.borrow_mut()[of(link.slot..link.slot + 1)];
                            laws.remember_at(scene, (point, link.slot), &at.deformation, own);
                        });
                    }
                    settle(point);
                },
            });
        });
        laws.ask_host(scene, records);
    }

    /// What a point pulls by itself goes to the forces, and what others pull of it is left.
    fn forces<const C: usize>(
        &self,
        law: impl BondLaw<D> + Copy + Sync,
        force: &mut [f64],
        left: &mut [[f64; C]],
    ) {
        let (scene, Middles { family, table }) = (self.body.scene, self.middles);
        let outputs = (PerPoint(force, D), PerPoint(left, 1));
        in_lanes::sweep(scene, family, Which::Listed, outputs, |family, range, (force, left)| {
            if self.resting.block(range.start, 1) {
                return;
            }
            let (forces, _) = force.0.as_chunks_mut::<D>();
            let first = range.start;
            let finish = |point: usize, through: &Tensor<D>, straight: &Vector<D>, odd: bool| {
                let (at, kept) = (point - first, self.kept.at::<D, SIZE>(point));
                let (record, left) = (&self.records[point], &mut left.0[at]);
                let own = if odd {
                    self.odd(point, kept, left)
                } else {
                    let kept = (self.baqp.weights.horizons.at(point), kept);
                    let own = leave(record, through, kept.1.rows(), kept, left);
                    std::array::from_fn(|axis| straight[axis] + own[axis])
                };
                forces[at] = own;
            };
            let (middles, wanted) = (Middles { family, table }, |_| true);
            scene.simd.run(BondStresses { middles, law, range, wanted, finish });
        });
    }

    /// The same of a point with an end of a bond that does not span the body.
    fn odd<const C: usize>(
        &self,
        point: usize,
        kept: Point<'_, D, SIZE>,
        left: &mut [f64; C],
    ) -> Vector<D> {
        let (straight, through) =
            self.baqp.single_bonds(&self.body, point, |point| self.left(point));
        let numbers = self.left(point);
        let (rows, _) = numbers[before_rows(D)..].as_chunks();
        let kept = (self.baqp.weights.horizons.at(point), kept);
        let pulled = leave(&self.records[point], &through, rows, kept, left);
        std::array::from_fn(|axis| straight[axis] + pulled[axis])
    }

    fn energies(
        &self,
        law: impl BondLaw<D> + Copy + Sync,
        density: &mut [f64],
        wanted: impl Fn(usize) -> bool + Sync,
    ) {
        let scene = self.body.scene;
        self.sweep(PerPoint(density, 1), |middles, range, density| {
            let first = range.start;
            let finish = |point: usize, energy: f64, _: &_, odd: bool| {
                let own = || {
                    let weight = self.kept.at::<D, SIZE>(point).inverse_weight();
                    weight * self.baqp.held(&self.body, point, |point| self.left(point))
                };
                density.0[point - first] = if odd { own() } else { energy };
            };
            let wanted = &wanted;
            scene.simd.run(BondMeans::<_, _, _, false, D, _> {
                middles,
                law,
                range,
                wanted,
                finish,
            });
        });
    }

    /// Deformation and stress; `law` gives the stress across in the place of the energy.
    fn fields(
        &self,
        law: impl BondLaw<D> + Copy + Sync,
        PerPoint(values, width): PerPoint<'_, f64>,
        read: &Read<'_>,
    ) {
        let scene = self.body.scene;
        self.sweep(PerPoint(values, width), |middles, range, values| {
            let first = range.start;
            let finish = |point: usize, held: f64, stress: &Tensor<D>, odd: bool| {
                let shown = if odd {
                    self.baqp.shown_by_bonds(&self.body, point, |point| self.left(point))
                } else {
                    let deformation = Deformation::whole(&tensor::read(&self.gradients[point]));
                    let across = self.baqp.laws.at(point).across(&deformation);
                    Kinematics::new(&deformation, stress, Across { held, ..across })
                };
                read(&shown, &mut values.0[(point - first) * width..][..width]);
            };
            let wanted = |_| true;
            scene.simd.run(BondMeans::<_, _, _, true, D, _> {
                middles,
                law,
                range,
                wanted,
                finish,
            });
        });
    }
}

impl Baqp {
    /// What the first pass leaves of a point.
    pub(super) fn prepared<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
    ) -> [f64; MOST_LEFT] {
        let mut numbers = [0.0; MOST_LEFT];
        self.prepare_point(body, point, &mut numbers[..Passes::width(self, D)]);
        numbers
    }

    /// The second sweep of points without a seat on the lattice that a body has, for elastic laws.
    pub(super) fn stresses_beyond<const D: usize, const C: usize>(
        &self,
        sweep: Sweep<'_>,
        gradients: &[[f64; GRADIENT]],
        kept: &Points<'_>,
        (force, left): (&mut [f64], &mut [[f64; C]]),
    ) {
        let then = |swept: &Swept<'_, D, D>| self.forces_by_laws(swept, force, left);
        self.with_answers(sweep, gradients, kept, (&mut [], false), |_| true, then);
    }

    /// Gradients of the points that are wanted.
    pub(super) fn swept_gradients<const D: usize, const SIZE: usize>(
        &self,
        sweep: Sweep<'_>,
        gradients: &mut [[f64; GRADIENT]],
        breaking: &mut Option<Breaking<'_>>,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Points<'_> {
        let kept = self.kept.sweep::<D, SIZE, _>(
            Order { order: self.order, counts_volumes: false },
            sweep,
            breaking,
            PerPoint(&mut *gradients, 1),
            &wanted,
            |_, kept, gradient, row| row.0[0] = gradient_row(gradient, kept, 0.0),
        );
        let remaining = &in_lanes::remaining(sweep.scene, breaking);
        let body = &Body::<D>::new(remaining, &self.weights);
        kept.odd::<D, SIZE, _>(remaining, PerPoint(gradients, 1), |point, kept, row| {
            if wanted(point) {
                let (_, gradient, ..) = gradient_at(body, point, self.order);
                row.0[0] = gradient_row(&gradient, kept, 1.0);
            }
        });
        kept
    }

    /// The second sweep, by the law of all points, those of points, or what laws have answered.
    fn forces_by_laws<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        swept: &Swept<'_, D, SIZE>,
        force: &mut [f64],
        left: &mut [[f64; C]],
    ) {
        let scene = swept.body.scene;
        let laws = self.laws_of_points(scene.simd);
        match (self.laws.quadratic(), laws, self.answered(scene)) {
            (Some(law), ..) => swept.forces(law, force, left),
            (None, Some(law), _) => swept.forces(law, force, left),
            (None, None, Some(law)) => swept.forces(law, force, left),
            (None, None, None) => swept.forces(self.bond_law(swept.body), force, left),
        }
    }

    /// What laws with memory have answered, if all points have one.
    fn answered<'a>(&self, scene: &Scene<'a>) -> Option<Answered<'a>> {
        let Asked { records, dissipated } = scene.asked?;
        let answered = Answered::new(records, self.laws.width(), Remembered::energy_at(dissipated));
        self.laws.is_one().then_some(answered)
    }

    /// The law of bonds one after the other; of laws with memory what they have answered.
    fn bond_law<const D: usize>(&self, body: Body<'_, D>) -> impl BondLaw<D> + Copy + Sync {
        BondByBond(move |point, slot, neighbor, gradient: &Tensor<D>| {
            let deformation = Deformation::whole(gradient);
            let Answer { energy, stress } =
                self.answer(&body, (point, slot), neighbor, &deformation);
            (energy, stress)
        })
    }

    pub(super) fn swept_forces<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, room, force, breaking, resting } = sweep;
        let (omega, count) = (self.kept.omega(scene, &self.weights)?, scene.places.len());
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let (gradients, rest) = in_lanes::table(rest, count);
        let (left, _) = in_lanes::table::<C>(rest, count);
        let sweep = Sweep::new(scene, omega, records).resting(resting, 2);
        let kept = &self.swept_gradients::<D, SIZE>(sweep, gradients, breaking, |_| true);
        let scene = &in_lanes::remaining(scene, breaking);
        let sweep = Sweep { scene, ..sweep };
        let then = |swept: &Swept<'_, D, SIZE>| self.forces_by_laws(swept, force, left);
        self.with_answers(sweep, gradients, kept, (room.records, false), |_| true, then);
        pull::<D, C>(sweep, left, force)
    }

    pub(super) fn swept_energy<const D: usize, const SIZE: usize>(
        &self,
        sweep: EnergySweep<'_>,
    ) -> bool {
        let EnergySweep { scene, room, density, part, near } = sweep;
        let Some(omega) = self.kept.omega(scene, &self.weights) else { return false };
        let count = scene.places.len();
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let (gradients, _) = in_lanes::table(rest, count);
        let sweep = Sweep::new(scene, omega, records);
        let passed = |point| near.is_none_or(|near| near.wants_pass(point));
        let wanted = |point| near.is_none_or(|near| near.wants_energy(point));
        density.fill(0.0);
        if near.is_some() {
            // Laws are asked at bonds that lead out of what is near.
            gradients.fill([0.0; GRADIENT]);
        }
        let kept = &self.swept_gradients::<D, SIZE>(sweep, gradients, &mut None, passed);
        let dissipated = part == EnergyPart::Plastic;
        let then = |swept: &Swept<'_, D, SIZE>| match (
            self.laws_of_points(scene.simd),
            self.answered(swept.body.scene),
        ) {
            (Some(law), _) => swept.energies(law, density, wanted),
            (None, Some(law)) => swept.energies(law, density, wanted),
            (None, None) => swept.energies(self.bond_law(swept.body), density, wanted),
        };
        self.with_answers(sweep, gradients, kept, (room.records, dissipated), passed, then);
        true
    }

    pub(super) fn swept_fields<const D: usize, const SIZE: usize>(
        &self,
        sweep: FieldSweep<'_>,
    ) -> bool {
        let FieldSweep { scene, room, values, width, read } = sweep;
        let Some(omega) = self.kept.omega(scene, &self.weights) else { return false };
        // What laws with memory have across and of plastic strain is asked bond by bond.
        if self.laws.remember() {
            return false;
        }
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let (gradients, _) = in_lanes::table(rest, scene.places.len());
        let sweep = Sweep::new(scene, omega, records);
        let kept = &self.swept_gradients::<D, SIZE>(sweep, gradients, &mut None, |_| true);
        let values = PerPoint(values, width);
        let then = |swept: &Swept<'_, D, SIZE>| {
            // Nothing lies across a body in space.
            match self.laws_of_points(scene.simd).filter(|_| D == 3) {
                Some(law) => swept.fields(law, values, read),
                None => swept.fields(self.bond_law_across(swept.body), values, read),
            }
        };
        self.with_answers(sweep, gradients, kept, (room.records, false), |_| true, then);
        true
    }

    /// As [`Baqp::bond_law`] of laws without memory, with the stress across in the place of the energy.
    fn bond_law_across<const D: usize>(&self, body: Body<'_, D>) -> impl BondLaw<D> + Copy + Sync {
        BondByBond(move |point, slot, neighbor, gradient: &Tensor<D>| {
            let deformation = Deformation::whole(gradient);
            let Answer { stress, .. } = self.answer(&body, (point, slot), neighbor, &deformation);
            let [own, other] =
                [point, neighbor].map(|end| self.laws.at(end).across(&deformation).held);
            (0.5 * (own + other), stress)
        })
    }

    /// Calls `then` when the laws of the points that are wanted have been asked, if they have a memory.
    fn with_answers<const D: usize, const SIZE: usize>(
        &self,
        sweep: Sweep<'_>,
        gradients: &[[f64; GRADIENT]],
        kept: &Points<'_>,
        (laws, dissipated): (&mut [f64], bool),
        wanted: impl Fn(usize) -> bool + Sync,
        then: impl FnOnce(&Swept<'_, D, SIZE>),
    ) {
        let Sweep { scene, records, resting, .. } = sweep;
        let family = sweep.family();
        let middles = Middles { family, table: Table::new(&family, gradients) };
        let body = Body::new(scene, &self.weights);
        let swept = Swept { baqp: self, body, middles, records, gradients, kept, resting };
        if !self.laws.remember() {
            return then(&swept);
        }
        swept.ask(laws, wanted);
        let scene = &Scene { asked: Some(Asked { records: laws, dissipated }), ..*scene };
        then(&Swept { body: Body::new(scene, &self.weights), ..swept });
    }
}
