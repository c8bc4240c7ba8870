//! Set-up: materials by set, interfaces, pre-cracks and integrity, and the building of the families.

use super::drive::stopped_by_law;
use super::{LogLevel, Simulation, refuse_after_setup};
use crate::damage::{Aside, BondState};
use crate::error::{Error, Result, argument};
use crate::families::crack::Crack;
use crate::formulation::{EnergyPart, Scene};
use crate::memory;
use crate::model::Model;
use crate::plan::{InterfaceRequest, Plan};
use crate::solver::time_step::StableStep;
use crate::workers::{Workers, block_count};

/// What is built once, when set-up ends.
pub(crate) struct Built {
    pub(crate) workers: Workers,
    pub(crate) plan: Plan,
    pub(crate) bonds: BondState,
    /// Energy per volume that each point has lost by broken bonds; empty when nothing can break and nothing was broken.
    pub(crate) dissipated: Vec<f64>,
    /// Where the next step breaks bonds; empty when nothing can break.
    pub(crate) aside: Aside,
    /// What a sweep for forces writes aside.
    pub(crate) scratch: Vec<f64>,
    /// Room for sums, one value a block of points.
    pub(crate) partial: Vec<f64>,
    /// The stable step as it was last found.
    pub(crate) stable_step: Option<StableStep>,
}

/// A change of bonds that the host asked for.
pub(crate) enum BondRequest {
    Break(Vec<[u32; 2]>),
    Cross(Crack),
    Weaken(Vec<[u32; 2]>, Vec<f64>),
}

impl Simulation {
    /// Gives the points of a set another material. All models of a simulation share formulation and
    /// plane state.
    ///
    /// # Errors
    /// `Argument` for an unknown set or a model that does not stand alone; `Unsupported` for another
    /// formulation, plane state, gradient order or divergence; `State` after set-up.
    pub fn assign_model(&mut self, set: &str, model: &Model) -> Result<()> {
        if self.built.get().is_some() {
            return refuse_after_setup("assigning a model");
        }
        model.check(self.points.dimension(), self.points.horizons().is_some())?;
        let first = &self.models[0];
        if !std::ptr::eq(first.formulation(), model.formulation()) {
            return Err(Error::Unsupported(format!(
                "the model's formulation is {}, that of the simulation {}; all models share one",
                model.formulation().name,
                first.formulation().name
            )));
        }
        if self.points.dimension() == 2 && first.plane() != model.plane() {
            return Err(Error::Unsupported(
                "the model's plane state differs from that of the simulation; all models share one"
                    .into(),
            ));
        }
        if let Some(key) = first.differs_from(model) {
            return Err(Error::Unsupported(format!(
                "the model's '{key}' differs from that of the simulation; all models share it"
            )));
        }
        self.points.set_size(set)?;
        if self.models.len() > u16::MAX as usize {
            return argument(format!("'model': {} models are too many", self.models.len()));
        }
        if self.model_of.is_empty() {
            self.model_of = memory::filled(0, self.points.count(), "materials")?;
        }
        let number = self.models.len() as u16;
        memory::push(&mut self.models, model.clone(), "models")?;
        let (points, model_of) = (&self.points, &mut self.model_of);
        points.for_each_in_set(set, |point| model_of[points.order().place(point)] = number)
    }

    /// Gives the bonds between two sets an energy release rate of their own (energy per area).
    ///
    /// # Errors
    /// `Argument` for unknown sets or a rate that is not positive and finite; `State` after set-up.
    pub fn set_interface(&mut self, set_a: &str, set_b: &str, rate: f64) -> Result<()> {
        if self.built.get().is_some() {
            return refuse_after_setup("an interface");
        }
        if !(rate > 0.0 && rate.is_finite()) {
            return argument(format!(
                "'critical_energy_release_rate' is {rate}; it must be positive and finite"
            ));
        }
        let mut sides = memory::filled(0_u8, self.points.count(), "interfaces")?;
        for (argument, set, bit) in [("set_a", set_a, 1), ("set_b", set_b, 2)] {
            let order = self.points.order();
            self.points
                .for_each_in_set(set, |point| sides[order.place(point)] |= bit)
                .map_err(|error| Error::Argument(format!("'{argument}': {error}")))?;
        }
        let request = InterfaceRequest { sides, rate };
        memory::push(&mut self.scene_requests.interfaces, request, "interfaces")
    }

    /// Breaks the bonds of these pairs of points for good. Pairs without a bond are passed over.
    ///
    /// # Errors
    /// `Argument` for an index out of range or a point paired with itself.
    pub fn break_bonds(&mut self, pairs: &[[usize; 2]]) -> Result<()> {
        let pairs = self.inner_pairs(pairs)?;
        self.request(BondRequest::Break(pairs))
    }

    /// Breaks every bond that crosses a planar polygon (3D) or a segment (2D) for good; `vertices`
    /// holds as many numbers a vertex as there are axes. Points within 1e-9 spacings of the plane
    /// belong to its positive side, and the rim belongs to the crack.
    ///
    /// # Errors
    /// `Argument` for too few vertices, ones that are not finite or not in a plane, or a crack
    /// without extent.
    pub fn break_crossing(&mut self, vertices: &[f64]) -> Result<()> {
        let dimension = self.points.dimension();
        if !vertices.len().is_multiple_of(dimension) {
            return argument(format!(
                "'vertices' has {} numbers; each vertex has {dimension}",
                vertices.len()
            ));
        }
        self.request(BondRequest::Cross(Crack::new(dimension, vertices)?))
    }

    /// Sets the integrity of the bonds of these pairs of points: 1 is intact, 0 broken. A broken bond
    /// stays broken. Pairs without a bond are passed over.
    ///
    /// # Errors
    /// `Argument` for an index out of range, a point paired with itself, as many values as pairs not
    /// given, or a value outside 0 to 1.
    pub fn set_bond_integrity(&mut self, pairs: &[[usize; 2]], values: &[f64]) -> Result<()> {
        if pairs.len() != values.len() {
            return argument(format!(
                "there are {} pairs and {} values; each pair has one",
                pairs.len(),
                values.len()
            ));
        }
        if let Some(place) = values.iter().position(|value| !(0.0..=1.0).contains(value)) {
            return argument(format!(
                "'values'[{place}] is {}; an integrity lies between 0 and 1",
                values[place]
            ));
        }
        let values = memory::copied(values, "integrities")?;
        let pairs = self.inner_pairs(pairs)?;
        self.request(BondRequest::Weaken(pairs, values))
    }

    /// Lets no bond break that has an end in the set. Bonds can still be broken by hand.
    ///
    /// # Errors
    /// `Argument` for an unknown set.
    pub fn forbid_failure(&mut self, set: &str) -> Result<()> {
        self.points.set_size(set)?;
        let count = self.points.count();
        let mut protected = match &self.scene_requests.protected {
            Some(known) => memory::copied(known, "protected points")?,
            None => memory::filled(false, count, "protected points")?,
        };
        let order = self.points.order();
        self.points.for_each_in_set(set, |point| protected[order.place(point)] = true)?;
        if let Some(Built { plan: Plan { rule: Some(rule), families, .. }, .. }) =
            self.built.get_mut()
        {
            rule.protect(families, &protected)?;
        }
        self.scene_requests.protected = Some(protected);
        Ok(())
    }

    fn inner_pairs(&self, pairs: &[[usize; 2]]) -> Result<Vec<[u32; 2]>> {
        let (count, order) = (self.points.count(), self.points.order());
        let mut inner = memory::reserved(pairs.len(), "pairs")?;
        for (number, pair) in pairs.iter().enumerate() {
            if let Some(point) = pair.iter().find(|&&point| point >= count) {
                return argument(format!(
                    "'pairs'[{number}] names point {point}; it must be below the number of points, \
                     {count}"
                ));
            }
            if pair[0] == pair[1] {
                return argument(format!("'pairs'[{number}] pairs point {} with itself", pair[0]));
            }
            inner.push(pair.map(|point| order.place(point) as u32));
        }
        Ok(inner)
    }

    /// Keeps a request until the families are built, or carries it out.
    fn request(&mut self, request: BondRequest) -> Result<()> {
        if self.built.get().is_none() {
            return memory::push(&mut self.bond_requests, request, "requests");
        }
        self.close_ledger()?;
        let (built, displacement) = (self.built()?, &self.state.current.displacement);
        let before = built.elastic_energy_density(displacement)?;
        // What flow has dissipated at a bond stays dissipated when the bond goes.
        let remembers = !built.bonds.records.is_empty();
        let flowed_before = match remembers {
            true => built.energy_density(displacement, EnergyPart::Plastic)?,
            false => Vec::new(),
        };
        if let Some(place) = before.iter().position(|energy| !energy.is_finite()) {
            return Err(Error::Numeric(format!(
                "the strain energy of point {} is not finite, so that breaking its bonds cannot be \
                 accounted for; set another displacement first",
                self.points.order().host[place]
            )));
        }
        let Self { state, built, points, .. } = self;
        let Some(built) = built.get_mut() else { return Ok(()) };
        // Asked for before anything changes: the memory that is needed afterwards.
        let mut after = memory::filled(0.0, before.len(), "energy")?;
        let mut penalty = memory::filled(0.0, before.len(), "energy")?;
        let mut flowed = memory::filled(0.0, flowed_before.len(), "energy")?;
        let mut scratch = memory::filled(0.0, built.plan.scratch_of_energies(), "energy")?;
        let kept = built.bonds.kept_for_a_stop()?;
        if built.dissipated.is_empty() {
            built.dissipated = built.workers.filled(0.0, before.len(), "dissipated energy")?;
        }
        let warning = built.carry_out(&request, &points.order().centre)?;
        // What the bonds held is dissipated; what the host adds by raising an integrity is given.
        let Built { workers, plan, bonds, .. } = &mut *built;
        let scene = plan.scene(workers, bonds, &state.current.displacement);
        for (density, part) in
            [(&mut after, EnergyPart::Strain), (&mut penalty, EnergyPart::Stabilization)]
        {
            plan.formulation.energy_density(&scene, &mut scratch, density, part);
        }
        if remembers {
            plan.formulation.energy_density(&scene, &mut scratch, &mut flowed, EnergyPart::Plastic);
        }
        if let Some(error) = stopped_by_law(plan) {
            bonds.take_back(kept);
            return Err(error);
        }
        if let Some(known) = &mut built.stable_step {
            known.is_stale = true;
        }
        state.force_fresh = false;
        after.iter_mut().zip(&penalty).for_each(|(density, penalty)| *density += penalty);
        built.aside.forget();
        for (point, dissipated) in built.dissipated.iter_mut().enumerate() {
            *dissipated += (before[point] - after[point]).max(0.0);
        }
        for (dissipated, (was, is)) in
            built.dissipated.iter_mut().zip(flowed_before.iter().zip(&flowed))
        {
            *dissipated += was - is;
        }
        if let Some(text) = warning {
            self.tell(LogLevel::Warning, &text);
        }
        Ok(())
    }

    /// What set-up leads to; built when first asked for.
    pub(super) fn built(&self) -> Result<&Built> {
        if let Some(built) = self.built.get() {
            return Ok(built);
        }
        let building = self.building.lock().unwrap_or_else(|poison| poison.into_inner());
        if let Some(built) = self.built.get() {
            return Ok(built);
        }
        let (built, warnings) = self.build()?;
        let built = self.built.get_or_init(|| built);
        // A log that calls back against its contract must not wait for itself.
        drop(building);
        for text in warnings {
            self.tell(LogLevel::Warning, &text);
        }
        Ok(built)
    }

    /// As [`Simulation::built`], to change it.
    pub(super) fn built_mut(&mut self) -> Result<&mut Built> {
        self.built()?;
        self.built.get_mut().ok_or_else(|| Error::Internal("set-up was lost".into()))
    }

    /// Builds what set-up leads to; also gives what the host should be told of it.
    fn build(&self) -> Result<(Built, Vec<String>)> {
        let workers = self.start_workers(self.threads)?;
        let requests = &self.scene_requests;
        let (points, models) = (&self.points, &self.models);
        let plan = Plan::new(&workers, self.simd, points, models, &self.model_of, requests)?;
        let bonds = BondState::new(&workers, &plan.families, plan.records())?;
        let count = plan.count();
        let masks = if plan.rule.is_some() { plan.families.block_count() } else { 0 };
        let breakable = if plan.rule.is_some() { count } else { 0 };
        let mut built = Built {
            dissipated: workers.filled(0.0, breakable, "dissipated energy")?,
            aside: Aside::new(&workers, masks, breakable)?,
            scratch: workers.filled(0.0, plan.scratch(false), "forces")?,
            partial: memory::filled(0.0, block_count(count), "sums")?,
            stable_step: None,
            workers,
            plan,
            bonds,
        };
        let mut warnings = Vec::new();
        if let Some(text) = isolated_points(&built.plan) {
            memory::push(&mut warnings, text, "messages")?;
        }
        // What is broken before the first step is a notch, to which the body refers; what is weakened is
        // damage.
        let is_notch = |request: &&BondRequest| !matches!(request, BondRequest::Weaken(..));
        let centre = &self.points.order().centre;
        let (notches, damage) =
            (self.bond_requests.iter().filter(is_notch), self.bond_requests.iter());
        for request in notches {
            if let Some(text) = built.carry_out(request, centre)? {
                memory::push(&mut warnings, text, "messages")?;
            }
        }
        let Built { plan, workers, bonds, .. } = &mut built;
        let Plan { dimension, families, formulation, simd, skips, lanes, .. } = plan;
        formulation.refer_to(&Scene {
            dimension: *dimension,
            places: &families.places,
            families,
            bonds: bonds.view(),
            displacement: &[],
            workers,
            flows: true,
            simd: *simd,
            skips: *skips,
            lanes: *lanes,
            asked: None,
        })?;
        for request in damage.filter(|request| !is_notch(request)) {
            if let Some(text) = built.carry_out(request, centre)? {
                memory::push(&mut warnings, text, "messages")?;
            }
        }
        Ok((built, warnings))
    }

    /// Threads for this body: no more than there are blocks of points to share out.
    pub(super) fn start_workers(&self, threads: usize) -> Result<Workers> {
        Workers::new(threads.min(block_count(self.points.count())))
    }
}

impl Built {
    /// A part of the energy per volume of all points at a displacement, in the inner order.
    pub(super) fn energy_density(
        &self,
        displacement: &[f64],
        part: EnergyPart,
    ) -> Result<Vec<f64>> {
        let scene = self.plan.scene(&self.workers, &self.bonds, displacement);
        let mut density = memory::filled(0.0, self.plan.count(), "energy")?;
        let mut scratch = memory::filled(0.0, self.plan.scratch_of_energies(), "energy")?;
        self.plan.formulation.energy_density(&scene, &mut scratch, &mut density, part);
        stopped_by_law(&self.plan).map_or(Ok(density), Err)
    }

    /// Elastic energy per volume, both parts.
    pub(super) fn elastic_energy_density(&self, displacement: &[f64]) -> Result<Vec<f64>> {
        // A body as it was given holds nothing, unless its materials remember.
        if self.bonds.records.is_empty() && displacement.iter().all(|&u| u == 0.0) {
            return memory::filled(0.0, self.plan.count(), "energy");
        }
        let mut density = self.energy_density(displacement, EnergyPart::Strain)?;
        let penalty = self.energy_density(displacement, EnergyPart::Stabilization)?;
        density.iter_mut().zip(&penalty).for_each(|(density, penalty)| *density += penalty);
        Ok(density)
    }

    /// Energy per volume that is not given back: that of broken bonds, and of plastic flow up to a displacement.
    pub(super) fn dissipated_density(&self, displacement: &[f64]) -> Result<Vec<f64>> {
        let mut density = match self.bonds.records.is_empty() {
            true => memory::filled(0.0, self.plan.count(), "energy")?,
            false => self.energy_density(displacement, EnergyPart::Plastic)?,
        };
        density.iter_mut().zip(&self.dissipated).for_each(|(density, broken)| *density += broken);
        Ok(density)
    }

    /// Changes bonds as the host asked; a failure comes before any change. Gives what the host should be
    /// told of a request that met no bond.
    fn carry_out(&mut self, request: &BondRequest, centre: &[f64; 3]) -> Result<Option<String>> {
        let Self { plan, bonds, workers, scratch, .. } = self;
        match request {
            BondRequest::Break(pairs) => {
                let met = for_each_end(plan, pairs, |_, slot| bonds.break_bond(slot));
                Ok(missed("break_bonds", pairs.len(), met))
            }
            BondRequest::Cross(crack) => {
                let mut met = 0;
                let cut = |_, _, slot| {
                    bonds.break_bond(slot);
                    met += 1;
                };
                let tolerance = plan.crack_tolerance;
                crack.for_each_crossing(&plan.families, plan.places(), centre, tolerance, cut);
                Ok((met == 0).then(|| {
                    "break_crossing: no bond crosses the crack; are its vertices in the units of the \
                     points?"
                        .to_owned()
                }))
            }
            BondRequest::Weaken(pairs, values) => {
                if values.iter().any(|&value| value != 0.0 && value != 1.0)
                    || bonds.integrity.is_some()
                {
                    let needed = plan.scratch(true);
                    if scratch.len() < needed {
                        *scratch = workers.filled(0.0, needed, "forces")?;
                    }
                    bonds.grade()?;
                }
                let met = for_each_end(plan, pairs, |number, slot| {
                    if bonds.is_intact(slot) {
                        bonds.weaken(slot, values[number]);
                    }
                });
                Ok(missed("set_bond_integrity", pairs.len(), met))
            }
        }
    }
}

fn missed(call: &str, pairs: usize, met: usize) -> Option<String> {
    (met < pairs)
        .then(|| format!("{call}: {} of {pairs} pairs have no bond between them", pairs - met))
}

fn isolated_points(plan: &Plan) -> Option<String> {
    let isolated = (0..plan.count()).filter(|&point| plan.families.is_alone(point)).count();
    (isolated > 0)
        .then(|| format!("{isolated} points have no neighbour within the horizon; they fly free"))
}

/// Calls `visit` with the number of a pair and the place of its bond, from both ends. Gives the number
/// of pairs that have a bond.
fn for_each_end(plan: &Plan, pairs: &[[u32; 2]], mut visit: impl FnMut(usize, usize)) -> usize {
    let mut met = 0;
    for (number, &[from, to]) in pairs.iter().enumerate() {
        let [from, to] = [from as usize, to as usize];
        let ends = [plan.families.slot(from, to), plan.families.slot(to, from)];
        met += usize::from(ends[0].is_some());
        ends.into_iter().flatten().for_each(|slot| visit(number, slot));
    }
    met
}
