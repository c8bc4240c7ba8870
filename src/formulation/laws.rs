//! How passes ask the laws of their points: those without memory at once, those with memory from the records that
//! a sweep before has made.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::body::{Body, ByModel};
use super::breaking::Near;
use super::kinematics::Kinematics;
use super::passes::Passes;
use super::{Materials, Scene};
use crate::error::Result;
use crate::families::LANES;
use crate::kernel::elastic::{ElasticLaw, SaintVenantKirchhoff};
use crate::material::{
    Across, Answer, Deformation, HostLaw, Law, MEMORY, Record, Room, Settle, record_width,
};
use crate::tensor::zero;
use crate::workers::{PerPoint, Ragged};

/// Where a formulation asks its laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sites {
    Points,
    /// At each end of each bond.
    Lanes,
}

/// A law, and what it is in lanes.
struct Known {
    law: Law,
    elastic: Option<ElasticLaw>,
}

pub(super) struct Laws {
    of: ByModel<Known>,
    pub(super) sites: Sites,
    remember: bool,
    /// Numbers of a record.
    width: usize,
    /// Laws of the host's, by model, and where they are asked: one at a time.
    host: ByModel<Option<HostLaw>>,
    room: Mutex<Room>,
    stopped: AtomicBool,
}

impl Laws {
    pub(super) fn new(materials: &Materials<'_>, sites: Sites) -> Result<Self> {
        let of = ByModel::new(materials, |model| {
            let law = Law::new(model, materials.dimension)?;
            Ok(Known { elastic: law.in_lanes(materials.dimension), law })
        })?;
        let remember = of.any(|known| known.law.has_memory());
        let host = ByModel::new(materials, |model| Ok(model.host_law().cloned()))?;
        let state = host.iter().flatten().map(|law| law.state_size).max();
        let width = record_width(state);
        let room = match state {
            Some(state) => Room::new(materials.dimension, width, state)?,
            None => Room::new(0, 0, 0)?,
        };
        let (room, stopped) = (Mutex::new(room), AtomicBool::new(false));
        Ok(Self { of, sites, remember, width, host, room, stopped })
    }

    pub(super) fn at(&self, point: usize) -> &Law {
        &self.of.at(point).law
    }

    fn elastic(&self, point: usize) -> Option<ElasticLaw> {
        self.of.at(point).elastic
    }

    /// Whether all points have one law, of one model.
    pub(super) fn is_one(&self) -> bool {
        self.of.iter().count() == 1
    }

    /// Whether all points share one law for lanes.
    pub(super) fn are_common(&self) -> bool {
        let first = self.elastic(0);
        first.is_some() && !self.of.any(|known| known.elastic != first)
    }

    /// Whether all points have laws for lanes.
    pub(super) fn are_elastic(&self) -> bool {
        !self.of.any(|known| known.elastic.is_none())
    }

    /// The law of Saint Venant-Kirchhoff, if all points share it.
    pub(super) fn quadratic(&self) -> Option<SaintVenantKirchhoff> {
        self.elastic(0).filter(|_| self.are_common()).and_then(ElasticLaw::quadratic)
    }

    /// Those of points, if all have Saint Venant-Kirchhoff's.
    pub(super) fn quadratics(
        &self,
    ) -> Option<impl Fn(usize) -> SaintVenantKirchhoff + Copy + Sync> {
        let quadratic = |law: Option<ElasticLaw>| law.and_then(ElasticLaw::quadratic);
        let of = move |point: usize| {
            let none = SaintVenantKirchhoff { lambda: f64::NAN, mu: f64::NAN };
            quadratic(self.elastic(point)).unwrap_or(none)
        };
        (!self.of.any(|known| quadratic(known.elastic).is_none())).then_some(of)
    }

    /// Laws for lanes of points, if all have.
    pub(super) fn of_points(&self) -> Option<impl Fn(usize) -> ElasticLaw + Copy + Sync> {
        let of = |point: usize| self.elastic(point).unwrap_or(ElasticLaw::NONE);
        self.are_elastic().then_some(of)
    }

    /// Whether a body that has not been deformed has no stress at all, to the last bit.
    pub(super) fn rest_without_stress(&self, dimension: usize) -> bool {
        self.of.iter().all(|Known { law, .. }| match dimension {
            _ if law.has_memory() => false,
            3 => law.answer(&Deformation::<3>::whole(&zero())).stress == zero(),
            _ => law.answer(&Deformation::<2>::whole(&zero())).stress == zero(),
        })
    }

    /// Whether any of them has a memory.
    pub(super) fn remember(&self) -> bool {
        self.remember
    }

    /// Numbers of a record.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// Numbers of records of a body.
    pub(super) fn records(&self, points: usize, blocks: usize) -> usize {
        match (self.remember, self.sites) {
            (false, _) => 0,
            (_, Sites::Points) => points * self.width,
            (_, Sites::Lanes) => blocks * LANES * self.width,
        }
    }

    /// Energy and stress of a point's law at a site.
    #[inline(always)]
    pub(super) fn answer<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        site: usize,
        deformation: &Deformation<D>,
    ) -> Answer<D> {
        match body.scene.asked {
            Some(asked) => Record::at(asked.records, self.width, site)
                .answer(&deformation.span, asked.dissipated),
            None => self.at(point).answer(deformation),
        }
    }

    /// What the law of a point whose family spans the body has answered, of laws that have been asked.
    pub(super) fn asked<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> Answer<D> {
        self.answer(body, point, point, &Deformation::whole(&zero()))
    }

    /// What the law has across a deformation at a site.
    pub(super) fn across<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        site: usize,
        deformation: &Deformation<D>,
    ) -> Across {
        let law = self.at(point);
        match body.scene.asked {
            Some(asked) if law.knows_across() => {
                Record::at(asked.records, self.width, site).across(deformation)
            }
            _ => law.across(deformation),
        }
    }

    /// Plastic strain at a site, and its equivalent.
    pub(super) fn plastic<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        site: usize,
    ) -> ([[f64; 3]; 3], f64) {
        match body.scene.asked {
            Some(asked) if self.at(point).knows_across() => {
                Record::at(asked.records, self.width, site).plastic_strain()
            }
            _ => (zero(), 0.0),
        }
    }

    /// Deformation and stress of a point whose law is asked at it.
    pub(super) fn kinematics<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        deformation: &Deformation<D>,
        answer: &Answer<D>,
    ) -> Kinematics {
        let across = self.across(body, point, point, deformation);
        let plastic = self.plastic(body, point, point);
        Kinematics::new(deformation, &answer.stress, across).with_plastic(plastic)
    }

    /// Makes the record of a site from the committed one.
    pub(super) fn remember_at<const D: usize>(
        &self,
        scene: &Scene<'_>,
        (point, site): (usize, usize),
        deformation: &Deformation<D>,
        new: &mut [f64],
    ) {
        let old = &scene.bonds.records[site * self.width..(site + 1) * self.width];
        new.copy_from_slice(old);
        self.at(point).remember(deformation, old, new, scene.flows);
    }

    /// The same, or leaves it to [`Laws::settle`].
    pub(super) fn defer_at<const D: usize>(
        &self,
        scene: &Scene<'_>,
        (point, site): (usize, usize),
        deformation: &Deformation<D>,
        new: &mut [f64],
    ) {
        if !self.at(point).defer(deformation, new) {
            self.remember_at(scene, (point, site), deformation, new);
        }
    }

    /// Asks what waits in the records of sites, in lanes; `point`: that of each, counted from the first of them.
    pub(super) fn settle(
        &self,
        scene: &Scene<'_>,
        sites: Range<usize>,
        point: &dyn Fn(usize) -> usize,
        new: &mut [f64],
    ) {
        let width = self.width;
        let old = &scene.bonds.records[sites.start * width..sites.end * width];
        let law = &|site: usize| self.at(point(site));
        scene.simd.run(Settle { law, old, new, width, flows: scene.flows });
    }

    /// Asks all laws, those near broken bonds if `near` says so: records of all sites, from the committed ones.
    pub(super) fn ask<const D: usize>(
        &self,
        body: &Body<'_, D>,
        passes: &impl Passes,
        left: &[f64],
        near: Option<&Near<'_>>,
        records: &mut [f64],
    ) {
        let (scene, count) = (body.scene, body.scene.places.len());
        let (width, all) = (self.width, &mut *records);
        let point_at = |point: usize, first: usize, new: &mut [f64]| {
            let old = &scene.bonds.records[first..first + new.len()];
            new.copy_from_slice(old);
            if near.is_some_and(|near| !near.wants_pass(point)) {
                return;
            }
            passes.each_site(body, point, left, &mut |site, deformation| {
                let own = site * width - first..(site + 1) * width - first;
                self.remember_at(scene, (point, site), deformation, &mut new[own]);
            });
        };
        match self.sites {
            Sites::Points => scene.workers.sweep(count, PerPoint(all, width), |range, new| {
                for (new, point) in new.0.chunks_exact_mut(width).zip(range) {
                    point_at(point, point * width, new);
                }
            }),
            Sites::Lanes => {
                let (offsets, width) = (&scene.families.offsets, LANES * width);
                let new = Ragged { values: all, offsets, width };
                scene.workers.sweep(count, new, |range, new| {
                    let start = offsets[range.start] as usize;
                    for point in range {
                        let blocks = scene.families.blocks(point);
                        let own = (blocks.start - start) * width..(blocks.end - start) * width;
                        point_at(point, blocks.start * width, &mut new.values[own]);
                    }
                });
            }
        }
        self.ask_host(scene, records);
    }

    /// Asks the host's laws what waits for them, law after law, on this thread.
    pub(super) fn ask_host(&self, scene: &Scene<'_>, records: &mut [f64]) {
        if !self.host.any(Option::is_some) {
            return;
        }
        // A panic of a host's function has left nothing that is not made anew.
        let mut room = self.room.lock().unwrap_or_else(PoisonError::into_inner);
        for law in self.host.iter().flatten() {
            // A call asks in several sweeps: after a stop the others ask no more.
            if self.stopped.load(Ordering::Relaxed) {
                break;
            }
            room.clear();
            let belongs = |point: usize| {
                self.host.at(point).as_ref().is_some_and(|own| std::ptr::eq(own, law))
            };
            let points = (0..scene.places.len()).filter(|&point| belongs(point));
            let sites = points.flat_map(|point| match self.sites {
                Sites::Points => point..point + 1,
                Sites::Lanes => {
                    let blocks = scene.families.blocks(point);
                    blocks.start * LANES..blocks.end * LANES
                }
            });
            if room.ask(law, sites, scene.bonds.records, records).is_break() {
                self.stopped.store(true, Ordering::Relaxed);
            }
        }
        if self.stopped.load(Ordering::Relaxed) {
            for record in records.chunks_exact_mut(self.width) {
                record[..MEMORY].fill(f64::NAN);
            }
        }
    }

    /// Whether a function of the host's has asked to stop since this was last asked. Each call that asks laws asks this
    /// at its end, so that the next one starts anew.
    pub(super) fn was_stopped(&self) -> bool {
        self.stopped.swap(false, Ordering::Relaxed)
    }

    pub(super) fn bytes(&self) -> usize {
        self.of.bytes()
    }
}
