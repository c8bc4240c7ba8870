//! What a state-based formulation says of itself: its passes over the families, and what it keeps.

use super::body::{Body, ByModel, Weights};
use super::breaking::Near;
use super::calm::Resting;
use super::laws::Laws;
use super::surface::Surface;
use super::{EnergyPart, Kinematics, Read, Scene};
use crate::damage::Breaking;
use crate::error::Result;
use crate::families::lattice::LatticeUse;
use crate::material::Deformation;
use crate::tensor::Vector;

/// What sweeps in lanes write aside.
pub(super) struct Room<'a> {
    /// Records of the laws.
    pub(super) records: &'a mut [f64],
    pub(super) tables: &'a mut [f64],
}

/// A sweep in lanes for forces. With `breaking`, bonds that the rule condemns break in its masks first.
pub(super) struct ForceSweep<'a, 'b> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) room: Room<'a>,
    pub(super) force: &'a mut [f64],
    pub(super) breaking: &'a mut Option<Breaking<'b>>,
    /// What may be left out.
    pub(super) resting: Resting<'a>,
}

/// A sweep in lanes for a part of the energy per volume, near broken bonds only if `near` says so.
pub(super) struct EnergySweep<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) room: Room<'a>,
    pub(super) density: &'a mut [f64],
    pub(super) part: EnergyPart,
    pub(super) near: Option<&'a Near<'a>>,
}

/// A sweep in lanes for deformation and stress, of which `read` makes so many numbers a point.
pub(super) struct FieldSweep<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) room: Room<'a>,
    pub(super) values: &'a mut [f64],
    pub(super) width: usize,
    pub(super) read: &'a Read<'a>,
}

/// The passes of a formulation.
pub(super) trait Passes: Sized + Send + Sync {
    fn weights(&self) -> &Weights;

    fn weights_mut(&mut self) -> &mut Weights;

    /// Whether forces are the slope of an energy where laws have one.
    fn has_potential(&self) -> bool {
        true
    }

    /// Where the surface is to be corrected.
    fn surface(&self) -> Option<&Surface<ByModel<f64>>> {
        None
    }

    /// Its laws, where it asks any.
    fn laws(&self) -> Option<&Laws> {
        None
    }

    /// The deformations at which the law of a point is asked, and the site of each. `left`: what the first pass has
    /// left of all points, where there is a pass between.
    fn each_site<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _left: &[f64],
        _ask: &mut dyn FnMut(usize, &Deformation<D>),
    ) {
    }

    /// Numbers of records that it keeps from step to step, those of its laws.
    fn records(&self, points: usize, blocks: usize) -> usize {
        self.laws().map_or(0, |laws| laws.records(points, blocks))
    }

    /// Makes the records of a displacement from the committed ones, near broken bonds only if `near` says so.
    fn ask<const D: usize>(
        &self,
        body: &Body<'_, D>,
        left: &[f64],
        near: Option<&Near<'_>>,
        records: &mut [f64],
    ) {
        if let Some(laws) = self.laws() {
            laws.ask(body, self, left, near, records);
        }
    }

    /// What its sweeps make of a lattice.
    fn use_of_a_lattice(&self) -> LatticeUse {
        LatticeUse::None
    }

    /// Whether models differ in what its sweeps over groups of a lattice take of one; `None` where no sweep tells groups of
    /// several kinds apart.
    fn models_differ(&self) -> Option<bool> {
        None
    }

    /// Takes the body as it is before the first step.
    fn refer_to(&mut self, _scene: &Scene<'_>) -> Result<()> {
        Ok(())
    }

    /// Numbers of the tables that its sweeps in lanes write aside; 0 where it has none.
    fn room_of_lanes(&self, _points: usize, _blocks: usize, _dimension: usize) -> usize {
        0
    }

    /// Numbers of the tables of its energies on a lattice, those of [`Self::room_of_lanes`] that they need.
    fn room_of_energies(&self, _points: usize, _dimension: usize) -> usize {
        0
    }

    /// Whether the forces of a scene can be swept in lanes.
    fn runs_in_lanes(&self, _scene: &Scene<'_>) -> bool {
        false
    }

    /// How far the force on a point reaches, in families: 2 where that of a neighbour counts, too. `None` where a body at rest
    /// may have forces.
    fn rings(&self, _dimension: usize) -> Option<u8> {
        None
    }

    /// Order of the gradients of its sweeps in lanes.
    fn gradient_order(&self) -> usize {
        1
    }

    /// All forces of such a scene, and the records of its laws. What breaking dissipates is not its concern. Gives the first
    /// point whose force is not finite.
    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        _sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        None
    }

    /// Energies of such a scene; points that are not asked for have 0. False, and nothing done, where they are not swept
    /// in lanes.
    fn energy_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        _sweep: EnergySweep<'_>,
    ) -> bool {
        false
    }

    /// Deformation and stress of such a scene. False, and nothing done, where they are not swept in lanes.
    fn kinematics_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        _sweep: FieldSweep<'_>,
    ) -> bool {
        false
    }

    /// Numbers a point that the first pass leaves for the second.
    fn width(&self, dimension: usize) -> usize;

    /// The first pass at a point; false where what it leaves is not to be used.
    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool;

    /// A pass between the first and the last, which may read what the first has left of all points and
    /// changes that of its own; false where there is none.
    fn has_second(&self) -> bool {
        false
    }

    /// What the pass between makes of a point.
    fn second_at<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _scratch: &[f64],
        _result: &mut [f64],
    ) {
    }

    /// Numbers a bond that a first pass leaves, in place of numbers a point; 0 where it leaves none.
    fn lane_width(&self, _dimension: usize) -> usize {
        0
    }

    /// The first pass at a point for its bonds' lanes; false where what it leaves is not to be used.
    fn prepare_lanes<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _lanes: &mut [f64],
    ) -> bool {
        true
    }

    /// Force per volume on a point, from what the first pass has left of all lanes.
    fn force_from_lanes<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _lanes: &[f64],
    ) -> Vector<D> {
        [0.0; D]
    }

    /// Force per volume on a point, from what the passes have left of all points.
    fn force_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Vector<D>;

    /// Whether energies need what the first pass leaves.
    fn energy_needs_pass(&self) -> bool {
        false
    }

    /// Whether deformation and stress need what the first pass leaves.
    fn kinematics_need_pass(&self) -> bool {
        self.energy_needs_pass()
    }

    /// Strain energy per volume of a point; `scratch`: what the first pass has left of all points, where
    /// energies need it.
    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, scratch: &[f64]) -> f64;

    /// Whether there is a penalty on modes that the material does not see.
    fn has_penalty(&self) -> bool {
        false
    }

    /// Energy per volume of that penalty.
    fn stabilisation_at<const D: usize>(&self, _body: &Body<'_, D>, _point: usize) -> f64 {
        0.0
    }

    /// Whether a point's family does not span the body, or does not bear the order of gradient asked for: what
    /// is done then says `gradient`.
    fn is_degenerate<const D: usize>(&self, _body: &Body<'_, D>, _point: usize) -> bool {
        false
    }

    /// Deformation and stress of a point; `scratch`: what the first pass has left of all points, where they need
    /// it.
    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Kinematics;

    fn bytes(&self) -> usize;
}
