//! Weighted families: what the passes of the state-based formulations go over.

use super::surface::Correction;
use super::{Materials, Scene};
use crate::error::Result;
use crate::families::{Bond, LANES, Property};
use crate::memory;
use crate::model::Influence;
use crate::tensor::Vector;
use crate::workers::Ragged;

/// What follows from each point's model.
pub(super) struct ByModel<T> {
    values: Vec<T>,
    /// Number of each point's model; empty when there is only one.
    model_of: Vec<u16>,
}

impl<T> ByModel<T> {
    pub(super) fn new(
        materials: &Materials<'_>,
        value: impl Fn(&crate::model::Model) -> Result<T>,
    ) -> Result<Self> {
        let mut values = memory::reserved(materials.models.len(), "materials")?;
        for model in materials.models {
            values.push(value(model)?);
        }
        Ok(Self { values, model_of: memory::copied(materials.model_of, "materials")? })
    }

    #[inline(always)]
    pub(super) fn at(&self, point: usize) -> &T {
        &self.values[self.model_of.get(point).map_or(0, |&number| number as usize)]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        self.values.iter()
    }

    pub(super) fn any(&self, is: impl Fn(&T) -> bool) -> bool {
        self.values.iter().any(is)
    }

    /// Whether there are several.
    pub(super) fn differ(&self) -> bool
    where
        T: PartialEq,
    {
        self.values.iter().any(|value| *value != self.values[0])
    }

    pub(super) fn bytes(&self) -> usize {
        memory::bytes(&self.values) + memory::bytes(&self.model_of)
    }
}

/// How much bonds count in the families of their ends: w = omega(L) d, and with it beta where the surface
/// is corrected.
pub(crate) struct Weights {
    influence: ByModel<Influence>,
    /// That of all points, if they share it.
    common: Option<Influence>,
    pub(crate) horizons: Property,
    pub(super) correction: Option<Correction>,
    dimension: usize,
    /// w_ij and w_ji of each lane, the latter where they differ; kept for sweeps in lanes where they do not follow from
    /// lengths.
    own: Vec<f64>,
    other: Vec<f64>,
}

impl Weights {
    /// Weights of the models' own influence functions.
    pub(super) fn new(materials: &Materials<'_>) -> Result<Self> {
        Self::with(materials, |model| Ok(model.influence()))
    }

    pub(super) fn with(
        materials: &Materials<'_>,
        influence: impl Fn(&crate::model::Model) -> Result<Influence>,
    ) -> Result<Self> {
        let influence = ByModel::new(materials, influence)?;
        let first = *influence.at(0);
        Ok(Self {
            common: (!influence.differ()).then_some(first),
            influence,
            horizons: materials.horizons.copied()?,
            correction: None,
            dimension: materials.dimension,
            own: Vec::new(),
            other: Vec::new(),
        })
    }

    /// Keeps what bonds count one by one, unless it follows from their length.
    pub(super) fn keep(&mut self, scene: &Scene<'_>) -> Result<()> {
        if self.follow_length(scene).is_some() {
            return Ok(());
        }
        let (lanes, purpose) = (scene.families.block_count() * LANES, "weights of bonds");
        let mut own = memory::filled(0.0, lanes, purpose)?;
        let both = if self.are_shared() { 0 } else { lanes };
        let mut other = memory::filled(0.0, both, purpose)?;
        let offsets = &scene.families.offsets;
        let lanes = |values| Ragged { values, offsets, width: LANES };
        let outputs = (lanes(&mut own[..]), (both > 0).then(|| lanes(&mut other[..])));
        scene.workers.sweep(scene.places.len(), outputs, |range, (own, mut other)| {
            let first = offsets[range.start] as usize * LANES;
            for bond in
                range.flat_map(|point| scene.families.bonds(point).map(move |bond| (point, bond)))
            {
                let (point, bond) = bond;
                let (_, [of_point, of_neighbor]) = self.of(scene, point, bond);
                own.values[bond.slot - first] = of_point;
                if let Some(other) = &mut other {
                    other.values[bond.slot - first] = of_neighbor;
                }
            }
        });
        (self.own, self.other) = (own, other);
        Ok(())
    }

    /// What is kept of bonds, w_ij and w_ji.
    pub(super) fn each(&self) -> Option<[&[f64]; 2]> {
        let back = if self.other.is_empty() { &self.own } else { &self.other };
        (!self.own.is_empty()).then_some([&self.own, back])
    }

    /// The influence function, where weights follow from the lengths of bonds.
    pub(super) fn follow_length(&self, scene: &Scene<'_>) -> Option<Influence> {
        let alike = scene.families.reach.is_sharp_and_uniform() && self.correction.is_none();
        if alike && self.are_shared() { self.common } else { None }
    }

    /// The part of the volume of a bond's other end in a point's family, and w_ij and w_ji but for its integrity.
    #[inline(always)]
    fn of(&self, scene: &Scene<'_>, point: usize, bond: Bond) -> (f64, [f64; 2]) {
        let factors = self.correction.as_ref().map_or([1.0; 2], |factors| factors.at(bond.slot));
        let weight = |point: usize, factor: f64, share: f64| {
            if share > 0.0 { self.value(point, bond.length) * factor * share } else { 0.0 }
        };
        let reach = &scene.families.reach;
        let share = reach.share(point, bond.neighbor, bond.length);
        let own = weight(point, factors[0], share);
        if self.are_shared() {
            return (share, [own; 2]);
        }
        let back = reach.share(bond.neighbor, point, bond.length);
        (share, [own, weight(bond.neighbor, factors[1], back)])
    }

    /// w_ij but for its integrity.
    pub(super) fn own(&self, scene: &Scene<'_>, point: usize, bond: Bond) -> f64 {
        self.of(scene, point, bond).1[0]
    }

    /// omega of a point's family at a length; in the rim of the horizon that at the horizon.
    #[inline(always)]
    pub(crate) fn value(&self, point: usize, length: f64) -> f64 {
        let horizon = self.horizons.at(point);
        self.influence.at(point).value(self.dimension, length.min(horizon), horizon)
    }

    /// Whether both ends give a bond the same weight.
    pub(super) fn are_shared(&self) -> bool {
        self.common.is_some()
            && matches!(self.horizons, Property::Uniform(_))
            && self.correction.as_ref().is_none_or(Correction::is_shared)
    }

    pub(super) fn bytes(&self) -> usize {
        self.influence.bytes()
            + self.horizons.bytes()
            + self.correction.as_ref().map_or(0, Correction::bytes)
            + memory::bytes(&self.own)
            + memory::bytes(&self.other)
    }
}

/// A bond that is not broken, as seen from one of its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link<const D: usize> {
    pub(super) slot: usize,
    pub(super) neighbor: usize,
    pub(super) length: f64,
    /// xi
    pub(super) reference: Vector<D>,
    /// eta - xi
    pub(super) moved: Vector<D>,
    /// V_j
    pub(super) volume: f64,
    /// Part of V_j in the point's own family.
    pub(super) share: f64,
    /// w_ij times that part, 0 where j is beyond the point's own horizon.
    pub(super) own: f64,
    /// w_ji times the part of V_i in the neighbour's family.
    pub(super) other: f64,
}

impl<const D: usize> Link<D> {
    pub(super) fn bond(&self) -> Bond {
        Bond { slot: self.slot, neighbor: self.neighbor, length: self.length }
    }

    /// eta
    #[inline(always)]
    pub(super) fn deformed(&self) -> Vector<D> {
        std::array::from_fn(|axis| self.reference[axis] + self.moved[axis])
    }
}

/// A scene with its weights.
#[derive(Clone, Copy)]
pub(super) struct Body<'a, const D: usize> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) weights: &'a Weights,
    shifts: &'a [Vector<D>],
}

impl<'a, const D: usize> Body<'a, D> {
    pub(super) fn new(scene: &'a Scene<'a>, weights: &'a Weights) -> Self {
        let (shifts, _) = scene.displacement.as_chunks();
        Self { scene, weights, shifts }
    }

    /// The bonds of a point that are not broken.
    #[inline(always)]
    pub(super) fn links(&self, point: usize) -> impl Iterator<Item = Link<D>> + use<'a, D> {
        let Self { scene, weights, shifts } = *self;
        let (place, shift) = (&scene.places[point], &shifts[point]);
        let intact = move |slot| scene.bonds.is_intact(slot);
        scene.families.bonds(point).filter(move |bond| intact(bond.slot)).map(move |bond| {
            let (there, moved) = (&scene.places[bond.neighbor], &shifts[bond.neighbor]);
            let integrity = scene.bonds.integrity.map_or(1.0, |values| values[bond.slot]);
            let (share, [own, other]) = weights.of(scene, point, bond);
            Link {
                slot: bond.slot,
                neighbor: bond.neighbor,
                length: bond.length,
                reference: std::array::from_fn(|axis| there[axis] - place[axis]),
                moved: std::array::from_fn(|axis| moved[axis] - shift[axis]),
                volume: there[3],
                share,
                own: own * integrity,
                other: other * integrity,
            }
        })
    }
}
