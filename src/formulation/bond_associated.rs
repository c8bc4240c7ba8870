//! Bond-associated correspondence: a deformation gradient of its own for each bond, from the part of the
//! family near its other end. [P 4.15-4.20; D]
//!
//! Family of bond ij: h = { k in H_i : |X_k - X_j| <= bond_horizon }, j included. F_b and K_b over h as for
//! correspondence, phi_b = V(h_b)/sum V(h), W_i = sum_b phi_b W(F_b),
//! t_ik = sum_{b: k in h_b} phi_b w_k P_b K_b^-1 xi_k. With force_form = literal the force of [P 4.20] as
//! printed, t_ib = V(h_b)/V(H_i) w_b P_b K_b^-1 xi_b, which is not the slope of an energy.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::body::{Body, Link, Weights};
use super::constants;
use super::correspondence::add;
use super::gradient::Shape;
use super::kinematics::{Kinematics, Mean};
use super::laws::{Laws, Sites};
use super::passes::Passes;
use super::state_based::StateBased;
use super::{Formulation, FormulationEntry, Materials, Scene};
use crate::error::Result;
use crate::families::{LANES, Property};
use crate::kernel::associated::{FamilySweep, Member, Members, Near};
use crate::material::{Answer, Deformation};
use crate::memory;
use crate::tensor::{Tensor, Vector, applied, product, scaled};
use crate::workers::most_parts;

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "bond_associated",
    description: "bond-associated correspondence: a deformation gradient of its own for each bond",
    refused_keys: &[
        "silling_coefficient",
        "surface_correction",
        "gradient_order",
        "divergence",
        "operator_bonds",
    ],
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare,
};

/// Whole multiples of the spacing are within reach in spite of rounding.
const REACH: f64 = 1.0 + 1e-10;

struct BondAssociated {
    weights: Weights,
    laws: Laws,
    /// Square of the bonds' own horizon.
    reach: Property,
    literal: bool,
    rooms: Rooms,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let reach = materials.property(
        |model, horizon| Ok((model.number("bond_horizon").unwrap_or(horizon) * REACH).powi(2)),
        "horizons of bonds",
    )?;
    let bond_associated = BondAssociated {
        weights: Weights::new(materials)?,
        laws: Laws::new(materials, Sites::Lanes)?,
        reach,
        literal: materials.models[0].is_literal(),
        rooms: Rooms::default(),
    };
    Ok(Box::new(StateBased::new(materials, bond_associated)?))
}

/// What is known of the family of a bond.
struct Associated<const D: usize> {
    bond: Listed,
    shape: Shape<D>,
    deformation: Deformation<D>,
    /// V(h)
    volume: f64,
}

/// The bonds of one point at a time.
struct Room {
    members: Members,
    links: Vec<Listed>,
}

/// A bond in a room.
#[derive(Debug, Clone, Copy)]
struct Listed {
    slot: usize,
    /// w
    own: f64,
    /// The part of V_j in the family.
    volume: f64,
    /// xi
    reference: [f64; 3],
}

/// Rooms for all parts of a sweep.
#[derive(Default)]
struct Rooms {
    free: Mutex<Vec<Room>>,
    bytes: usize,
}

impl Rooms {
    fn new(count: usize, bonds: usize) -> Result<Self> {
        let purpose = "families of bonds";
        let mut rooms = memory::reserved(count, purpose)?;
        for _ in 0..count {
            let members = Members::with_room(memory::filled(0.0, Members::room(bonds), purpose)?);
            rooms.push(Room { members, links: memory::reserved(bonds, purpose)? });
        }
        let each = |room: &Room| room.members.bytes() + memory::bytes(&room.links);
        let bytes = memory::bytes(&rooms) + rooms.iter().map(each).sum::<usize>();
        Ok(Self { free: Mutex::new(rooms), bytes })
    }

    fn free(&self) -> MutexGuard<'_, Vec<Room>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lends a room to `work`.
    fn lend<T>(&self, work: impl FnOnce(&mut Room) -> T) -> T {
        let mut lent = Lent { rooms: self, room: None };
        loop {
            let room = self.free().pop();
            match room {
                Some(room) => return work(lent.room.insert(room)),
                // There are as many as parts of a sweep: only sweeps of several threads that read one simulation wait for each
                // other, and who holds a room asks for no other.
                None => std::thread::yield_now(),
            }
        }
    }
}

/// Comes back, whatever becomes of the work.
struct Lent<'a> {
    rooms: &'a Rooms,
    room: Option<Room>,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        if let Some(room) = self.room.take() {
            self.rooms.free().push(room);
        }
    }
}

impl BondAssociated {
    /// The bonds of a point's own family that are not broken.
    fn own<'a, const D: usize>(
        body: &Body<'a, D>,
        point: usize,
    ) -> impl Iterator<Item = Link<D>> + use<'a, D> {
        let families = body.scene.families;
        body.links(point).filter(move |link| families.owns(point, link.bond()))
    }

    /// Calls `each` for the bonds of a point; a tensor A that it gives adds A xi to the sums of the bonds in the family.
    fn each_family<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        room: &mut Room,
        mut each: impl FnMut(&Associated<D>) -> Option<Tensor<D>>,
    ) {
        let Room { members, links } = room;
        members.clear(body.scene.families.blocks(point).len() * LANES);
        links.clear();
        for link in Self::own(body, point) {
            let Link { slot, own, reference, moved, .. } = link;
            let (weight, volume) = (own * link.volume, link.share * link.volume);
            members.add(&Member { reference, moved, weight, volume });
            let reference = std::array::from_fn(|axis| *reference.get(axis).unwrap_or(&0.0));
            links.push(Listed { slot, own, volume, reference });
        }
        let mut each = |number: usize, near: &Near<D>| {
            let shape = Shape::new(&near.shape);
            let gradient = product(&near.moved, &shape.inverse);
            let deformation = Deformation { gradient, span: shape.span, rank: shape.rank };
            each(&Associated { bond: links[number], shape, deformation, volume: near.volume })
        };
        body.scene.simd.run(FamilySweep { members, reach: self.reach.at(point), each: &mut each });
    }

    fn answer<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        at: &Associated<D>,
    ) -> Answer<D> {
        self.laws.answer(body, point, at.bond.slot, &at.deformation)
    }
}

impl Passes for BondAssociated {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn has_potential(&self) -> bool {
        !self.literal
    }

    fn laws(&self) -> Option<&Laws> {
        Some(&self.laws)
    }

    fn each_site<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
        ask: &mut dyn FnMut(usize, &Deformation<D>),
    ) {
        self.rooms.lend(|room| {
            self.each_family(body, point, room, |at| {
                ask(at.bond.slot, &at.deformation);
                None
            });
        });
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        let points = scene.places.len();
        let most = (0..points).map(|point| scene.families.blocks(point).len() * LANES).max();
        self.rooms = Rooms::new(most_parts(points), most.unwrap_or(0))?;
        Ok(())
    }

    fn width(&self, _: usize) -> usize {
        0
    }

    fn prepare_point<const D: usize>(&self, _: &Body<'_, D>, _: usize, _: &mut [f64]) -> bool {
        true
    }

    fn force_at<const D: usize>(&self, _: &Body<'_, D>, _: usize, _: &[f64]) -> Vector<D> {
        [0.0; D]
    }

    /// The force state of each bond.
    fn lane_width(&self, dimension: usize) -> usize {
        dimension
    }

    fn prepare_lanes<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        lanes: &mut [f64],
    ) -> bool {
        lanes.fill(0.0);
        let (states, _) = lanes.as_chunks_mut::<D>();
        let first = body.scene.families.blocks(point).start * LANES;
        let (mut whole, mut sound) = (0.0, true);
        self.rooms.lend(|room| {
            self.each_family(body, point, room, |at| {
                let answer = self.answer(body, point, at);
                sound &= answer.energy.is_finite();
                let pull = scaled(&product(&answer.stress, &at.shape.inverse), at.volume);
                let Listed { slot, own, volume, reference } = at.bond;
                if self.literal {
                    whole += volume;
                    let reference = std::array::from_fn(|axis| reference[axis]);
                    states[slot - first] = applied(&pull, &reference).map(|pull| own * pull);
                    return None;
                }
                whole += at.volume;
                Some(pull)
            });
            for (number, &Listed { slot, own, .. }) in room.links.iter().enumerate() {
                let state = &mut states[slot - first];
                if !self.literal {
                    *state = room.members.sum(number).map(|sum: f64| own * sum);
                }
                *state = state.map(|state| state / whole);
            }
        });
        sound
    }

    fn force_from_lanes<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        lanes: &[f64],
    ) -> Vector<D> {
        let (states, _) = lanes.as_chunks::<D>();
        let mut force = [0.0; D];
        for link in body.links(point) {
            add(&mut force, link.volume, &states[link.slot]);
            if let Some(back) = body.scene.families.slot(link.neighbor, point) {
                add(&mut force, -link.volume, &states[back]);
            }
        }
        force
    }

    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> f64 {
        let (mut whole, mut sum) = (0.0, 0.0);
        self.rooms.lend(|room| {
            self.each_family(body, point, room, |at| {
                whole += at.volume;
                sum += at.volume * self.answer(body, point, at).energy;
                None
            });
        });
        if whole > 0.0 { sum / whole } else { 0.0 }
    }

    /// The mean over the bonds, by the volumes of their families.
    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
    ) -> Kinematics {
        let mut mean = Mean::new();
        self.rooms.lend(|room| {
            self.each_family(body, point, room, |at| {
                let answer = self.answer(body, point, at);
                let across = self.laws.across(body, point, at.bond.slot, &at.deformation);
                let plastic = self.laws.plastic(body, point, at.bond.slot);
                let made = Kinematics::new(&at.deformation, &answer.stress, across);
                mean.add(at.volume, &made.with_plastic(plastic));
                None
            });
        });
        mean.made()
    }

    /// Where the family of one of its bonds does not span the body.
    fn is_degenerate<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> bool {
        let mut found = false;
        self.rooms.lend(|room| {
            self.each_family(body, point, room, |at| {
                found |= at.shape.rank < D;
                None
            });
        });
        found
    }

    fn bytes(&self) -> usize {
        self.laws.bytes() + self.reach.bytes() + self.rooms.bytes
    }
}
