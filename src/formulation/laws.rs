//! How passes ask the laws of their points: those without memory at once, those with memory from the records that
//! a sweep before has made.

use super::Materials;
use super::body::{Body, ByModel};
use super::kinematics::Kinematics;
use super::state_based::{Near, Passes};
use crate::error::Result;
use crate::families::LANES;
use crate::material::{Across, Answer, Deformation, Law, RECORD, Record};
use crate::tensor::zero;
use crate::workers::{PerPoint, Ragged};

/// Where a formulation asks its laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sites {
    Points,
    /// At each end of each bond.
    Lanes,
}

pub(super) struct Laws {
    of: ByModel<Law>,
    pub(super) sites: Sites,
    remember: bool,
}

impl Laws {
    pub(super) fn new(materials: &Materials<'_>, sites: Sites) -> Result<Self> {
        let of = ByModel::new(materials, |model| Law::new(model, materials.dimension))?;
        let remember = of.any(Law::has_memory);
        Ok(Self { of, sites, remember })
    }

    pub(super) fn at(&self, point: usize) -> &Law {
        self.of.at(point)
    }

    /// Whether any of them has a memory.
    pub(super) fn remember(&self) -> bool {
        self.remember
    }

    /// Numbers of records of a body.
    pub(super) fn records(&self, points: usize, blocks: usize) -> usize {
        match (self.remember, self.sites) {
            (false, _) => 0,
            (_, Sites::Points) => points * RECORD,
            (_, Sites::Lanes) => blocks * LANES * RECORD,
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
        let law = self.at(point);
        match body.scene.asked {
            Some(asked) if law.has_memory() => {
                Record::at(asked.records, site).answer(&deformation.span, asked.dissipated)
            }
            _ => law.answer(deformation),
        }
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
            Some(asked) if law.has_memory() => Record::at(asked.records, site).across(deformation),
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
            Some(asked) if self.at(point).has_memory() => {
                Record::at(asked.records, site).plastic_strain()
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

    /// Asks all laws with memory, those near broken bonds if `near` says so: records of all sites, from the
    /// committed ones.
    pub(super) fn ask<const D: usize>(
        &self,
        body: &Body<'_, D>,
        passes: &impl Passes,
        left: &[f64],
        near: Option<&Near<'_>>,
        records: &mut [f64],
    ) {
        let (scene, count) = (body.scene, body.scene.places.len());
        let point_at = |point: usize, first: usize, new: &mut [f64]| {
            let old = &scene.bonds.records[first..first + new.len()];
            new.copy_from_slice(old);
            if near.is_some_and(|near| !near.wants_pass(point)) || !self.at(point).has_memory() {
                return;
            }
            passes.each_site(body, point, left, &mut |site, deformation| {
                let own = site * RECORD - first..(site + 1) * RECORD - first;
                let old = &scene.bonds.records[site * RECORD..(site + 1) * RECORD];
                self.at(point).remember(deformation, old, &mut new[own]);
            });
        };
        match self.sites {
            Sites::Points => scene.workers.sweep(count, PerPoint(records, RECORD), |range, new| {
                for (new, point) in new.0.chunks_exact_mut(RECORD).zip(range) {
                    point_at(point, point * RECORD, new);
                }
            }),
            Sites::Lanes => {
                let (offsets, width) = (&scene.families.offsets, LANES * RECORD);
                let new = Ragged { values: records, offsets, width };
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
    }

    pub(super) fn bytes(&self) -> usize {
        self.of.bytes()
    }
}
