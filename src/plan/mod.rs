//! The plan: looks at the scene once and keeps what it needs, and nothing that it doesn't.
//!
//! One model and one horizon need no per-point constants; a body in which nothing can break needs no
//! rule, and no second bond mask.

use crate::damage::{BondState, BreakRule, Interface};
use crate::error::Result;
use crate::families::lattice::LatticeUse;
use crate::families::{self, Families, Place, Property, Rim, Wanted};
use crate::formulation::{Formulation, LimitsFollow, Materials, Scene, Skips};
use crate::kernel::simd::SimdLevel;
use crate::memory;
use crate::model::{Damage, Model};
use crate::points::Points;
use crate::workers::Workers;

/// All of a body that does not change while it moves.
pub(crate) struct Plan {
    pub(crate) dimension: usize,
    pub(crate) density: Property,
    pub(crate) families: Families,
    pub(crate) formulation: Box<dyn Formulation>,
    /// When bonds break; `None` when none can.
    pub(crate) rule: Option<BreakRule>,
    /// Points closer to the plane of a crack than this belong to its positive side, a length.
    pub(crate) crack_tolerance: f64,
    /// Instructions that the inner loops run on.
    pub(crate) simd: SimdLevel,
    /// What sweeps leave out where it changes nothing.
    pub(crate) skips: Skips,
    /// Whether bonds are computed several at a time.
    pub(crate) lanes: bool,
}

/// What the host has said of the body besides points and models.
pub(crate) struct SceneRequests {
    /// Whether lattices are looked for.
    pub(crate) lattices: bool,
    /// Whether bonds are computed several at a time.
    pub(crate) lanes: bool,
    pub(crate) skips: Skips,
    /// Sets that no bond of which may break, as flags by inner place.
    pub(crate) protected: Option<Vec<bool>>,
    /// Interfaces with an energy release rate of their own.
    pub(crate) interfaces: Vec<InterfaceRequest>,
}

impl Default for SceneRequests {
    fn default() -> Self {
        let (skips, interfaces) = (Skips::default(), Vec::new());
        Self { lattices: true, lanes: true, skips, protected: None, interfaces }
    }
}

/// Two sets, as bits 0 and 1 by inner place, and the energy release rate between them.
pub(crate) struct InterfaceRequest {
    pub(crate) sides: Vec<u8>,
    pub(crate) rate: f64,
}

impl Plan {
    pub(crate) fn new(
        workers: &Workers,
        simd: SimdLevel,
        points: &Points,
        models: &[Model],
        model_of: &[u16],
        requests: &SceneRequests,
    ) -> Result<Self> {
        let dimension = points.dimension();
        let horizons = horizons(points, models, model_of)?;
        let materials = Materials { dimension, models, model_of, horizons: &horizons };
        let density = materials.property(|model, _| Ok(number(model, "density")), "densities")?;
        let thickness =
            materials.property(|model, _| Ok(number(model, "thickness")), "thicknesses")?;
        let places = places(points, &thickness)?;
        let farthest = points.order().farthest;
        let rim = rim(points, &models[0], &horizons)?;
        let mut formulation = (models[0].formulation().prepare)(&materials)?;
        let limits = Limits::new(&materials, requests)?;
        formulation.know_limits(limits.any(), limits.follow());
        let kinds = models.len() > 1 && formulation.tells_models_apart();
        let families = families::find(Wanted {
            workers,
            simd,
            dimension,
            places,
            horizons: &horizons,
            rim,
            farthest,
            storage: models[0].storage(),
            lattice: if requests.lattices && requests.lanes {
                formulation.use_of_a_lattice()
            } else {
                LatticeUse::None
            },
            kinds: kinds.then_some(model_of),
            host: &points.order().host,
        })?;
        let Limits { ends, interfaces } = limits;
        let rule = BreakRule::new(&families, ends, &interfaces, requests.protected.as_deref())?;
        let crack_tolerance = crack_tolerance(points);
        Ok(Self {
            dimension,
            density,
            families,
            formulation,
            rule,
            crack_tolerance,
            simd,
            skips: requests.skips,
            lanes: requests.lanes,
        })
    }

    pub(crate) fn count(&self) -> usize {
        self.places().len()
    }

    /// Places relative to the body's centre with real volumes (in 2D area times thickness).
    pub(crate) fn places(&self) -> &[Place] {
        &self.families.places
    }

    /// Numbers that a sweep for forces writes aside; `graded`: bonds have an integrity of their own.
    pub(crate) fn scratch(&self, graded: bool) -> usize {
        let lattice = self.families.lattice.as_ref();
        if !graded && lattice.is_some_and(|lattice| lattice.count == self.count()) {
            return self.formulation.scratch_on_lattice(
                self.count(),
                self.dimension,
                self.breaks(),
            );
        }
        self.scratch_of_energies()
    }

    fn breaks(&self) -> bool {
        self.rule.is_some()
    }

    /// Numbers that a sweep for energies or fields writes aside.
    pub(crate) fn scratch_of_energies(&self) -> usize {
        let (points, blocks) = (self.count(), self.families.block_count());
        self.formulation.scratch(points, blocks, self.dimension, self.breaks())
    }

    /// Numbers that its laws remember.
    pub(crate) fn records(&self) -> usize {
        self.formulation.records(self.count(), self.families.block_count())
    }

    /// The body at a displacement.
    pub(crate) fn scene<'a>(
        &'a self,
        workers: &'a Workers,
        bonds: &'a BondState,
        displacement: &'a [f64],
    ) -> Scene<'a> {
        Scene {
            dimension: self.dimension,
            places: self.places(),
            families: &self.families,
            bonds: bonds.view(),
            displacement,
            workers,
            flows: true,
            simd: self.simd,
            skips: self.skips,
            lanes: self.lanes,
            asked: None,
        }
    }

    /// Heap bytes held for bonds.
    pub(crate) fn bond_bytes(&self) -> usize {
        self.families.bytes()
            + self.formulation.bytes()
            + self.rule.as_ref().map_or(0, BreakRule::bytes)
    }

    /// Heap bytes held for points.
    pub(crate) fn point_bytes(&self) -> usize {
        memory::bytes(&self.families.places) + self.density.bytes()
    }
}

/// 1e-9 of the edge of the mean point's cell, or what the rounding of coordinates may amount to.
fn crack_tolerance(points: &Points) -> f64 {
    let order = points.order();
    let measure: f64 = order.host.iter().map(|&point| points.volumes()[point as usize]).sum();
    let spacing = (measure / points.count() as f64).powf(1.0 / points.dimension() as f64);
    (1e-9 * spacing).max(8.0 * f64::EPSILON * order.farthest)
}

/// A number that has been checked to be set, or has a default.
fn number(model: &Model, key: &str) -> f64 {
    model.number(key).unwrap_or(f64::NAN)
}

fn horizons(points: &Points, models: &[Model], model_of: &[u16]) -> Result<Property> {
    let order = points.order();
    if let Some(own) = points.horizons() {
        let mut values = memory::reserved(own.len(), "horizons")?;
        values.extend(order.host.iter().map(|&point| own[point as usize]));
        let first = own[0];
        return Ok(if own.iter().all(|&horizon| horizon == first) {
            Property::Uniform(first)
        } else {
            Property::PerPoint(values)
        });
    }
    let first = number(&models[0], "horizon");
    if models.iter().all(|model| number(model, "horizon") == first) {
        return Ok(Property::Uniform(first));
    }
    let of = |&index: &u16| number(&models[index as usize], "horizon");
    Ok(Property::PerPoint(memory::collected(model_of.iter().map(of), "horizons")?))
}

/// Where neighbours at the rim of the horizon count in part: the horizons, and the edges of the points' cells.
fn rim(points: &Points, model: &Model, horizons: &Property) -> Result<Option<Rim>> {
    if !model.has_partial_volume() {
        return Ok(None);
    }
    let (volumes, dimension) = (points.volumes(), points.dimension() as f64);
    let edge = |volume: f64| volume.powf(1.0 / dimension);
    let edges = if volumes.iter().all(|&volume| volume == volumes[0]) {
        Property::Uniform(edge(volumes[0]))
    } else {
        let order = points.order();
        let each = order.host.iter().map(|&point| edge(volumes[point as usize]));
        Property::PerPoint(memory::collected(each, "cells")?)
    };
    Ok(Some(Rim { horizons: horizons.copied()?, edges }))
}

fn places(points: &Points, thickness: &Property) -> Result<Vec<Place>> {
    let (order, dimension) = (points.order(), points.dimension());
    let mut places = memory::reserved(points.count(), "places")?;
    for (inner, &point) in order.host.iter().enumerate() {
        let point = point as usize;
        let mut place = [0.0; 4];
        let host = &points.coordinates()[point * dimension..(point + 1) * dimension];
        for (axis, x) in host.iter().enumerate() {
            place[axis] = x - order.centre[axis];
        }
        place[3] = points.volumes()[point];
        if dimension == 2 {
            place[3] *= thickness.at(inner);
        }
        places.push(place);
    }
    Ok(places)
}

/// When bonds may break, before it is known which there are.
struct Limits<'a> {
    /// Critical stretch of each point's material, infinite where it does not break.
    ends: Property,
    interfaces: Vec<Interface<'a>>,
}

impl<'a> Limits<'a> {
    fn new(materials: &Materials<'_>, requests: &'a SceneRequests) -> Result<Self> {
        let by_rate = |model: &Model, horizon: f64, rate: f64| {
            (model.formulation().critical_stretch)(model, materials.dimension, horizon, rate)
        };
        let ends = materials.property(
            |model, horizon| match model.damage()? {
                Damage::None => Ok(f64::INFINITY),
                Damage::CriticalStretch(stretch) => Ok(stretch),
                Damage::EnergyRelease(rate) => by_rate(model, horizon, rate),
            },
            "critical stretches",
        )?;
        let mut interfaces = memory::reserved(requests.interfaces.len(), "interfaces")?;
        for request in &requests.interfaces {
            let critical = materials.property(
                |model, horizon| by_rate(model, horizon, request.rate),
                "critical stretches",
            )?;
            interfaces.push(Interface { sides: &request.sides, critical });
        }
        Ok(Self { ends, interfaces })
    }

    /// Whether there is a stretch at which bonds break.
    fn any(&self) -> bool {
        !self.interfaces.is_empty()
            || match &self.ends {
                Property::Uniform(critical) => critical.is_finite(),
                Property::PerPoint(critical) => critical.iter().any(|stretch| stretch.is_finite()),
            }
    }

    fn follow(&self) -> LimitsFollow {
        match (&self.interfaces[..], &self.ends) {
            ([], Property::Uniform(_)) => LimitsFollow::Nothing,
            ([], Property::PerPoint(_)) => LimitsFollow::Models,
            _ => LimitsFollow::Bonds,
        }
    }
}
