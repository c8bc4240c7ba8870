//! Views in C: the host works in the library's own arrays, without a copy.

use std::sync::{Mutex, MutexGuard};

use super::fields::{field_of, perion_field};
use super::setup::{Hosted, perion_simulation};
use crate::error::argument;
use crate::ffi::guard::{Failure, guard};
use crate::ffi::handle;
use crate::ffi::sized::{self, Sized64};
use crate::ffi::status::perion_status;
use crate::memory;
use crate::simulation::{Field, Simulation};

/// A field in the library's own memory and inner order. Component c of the host's point p is
/// data[place * point_stride + c * component_stride], place = slot ? slot[p] : p. Valid until returned.
/// Let perion_view_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_view {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// the values
    pub data: *mut f64,
    /// inner place of each of the host's points; NULL when the orders are the same
    pub slot: *const i64,
    /// number of points
    pub count: i64,
    /// numbers a point
    pub components: i64,
    /// doubles from one point to the next
    pub point_stride: i64,
    /// doubles from one component to the next
    pub component_stride: i64,
    /// which borrowing this is
    pub generation: i64,
}

// SAFETY: plain numbers and pointers behind struct_size.
unsafe impl Sized64 for perion_view {}

/// What a host has borrowed of a simulation and not yet returned.
#[derive(Default)]
pub(crate) struct Loans(Mutex<Ledger>);

#[derive(Clone, Copy)]
struct Loan {
    generation: i64,
    /// Address of the values: a view of another simulation has another one.
    data: usize,
    field: Field,
    writable: bool,
}

#[derive(Default)]
struct Ledger {
    out: Vec<Loan>,
    generation: i64,
    /// The inner order as C takes it, made when first needed.
    slots: Vec<i64>,
}

impl Loans {
    pub(super) fn count(&self) -> usize {
        self.lock().out.len()
    }

    fn lock(&self) -> MutexGuard<'_, Ledger> {
        self.0.lock().unwrap_or_else(|poison| poison.into_inner())
    }

    /// The loan that a view stands for.
    fn find(&self, view: &perion_view) -> Result<Loan, Failure> {
        let same =
            |loan: &&Loan| loan.generation == view.generation && loan.data == view.data.addr();
        let refused = || {
            crate::Error::Argument(format!(
                "'view' of generation {} is not on loan from this simulation",
                view.generation
            ))
        };
        Ok(self.lock().out.iter().find(same).copied().ok_or_else(refused)?)
    }

    fn settle(&self, loan: Loan) {
        self.lock().out.retain(|known| known.generation != loan.generation);
    }

    /// Notes a loan and fills the view.
    fn lend(
        &self,
        simulation: &Simulation,
        field: Field,
        writable: bool,
        data: *mut f64,
    ) -> Result<perion_view, Failure> {
        let mut ledger = self.lock();
        let points = simulation.points();
        if let (Some(places), true) = (&points.order().place, ledger.slots.is_empty()) {
            ledger.slots =
                memory::collected(places.iter().map(|&place| i64::from(place)), "a view")?;
        }
        let generation = ledger.generation + 1;
        let loan = Loan { generation, data: data.addr(), field, writable };
        memory::push(&mut ledger.out, loan, "a view")?;
        ledger.generation = generation;
        let slots = &ledger.slots;
        let components = field.components(points.dimension()) as i64;
        Ok(perion_view {
            struct_size: 0,
            data,
            slot: if slots.is_empty() { std::ptr::null() } else { slots.as_ptr() },
            count: points.count() as i64,
            components,
            point_stride: components,
            component_stride: 1,
            generation,
        })
    }
}

/// Clears the struct and sets its struct_size; struct_size: sizeof(perion_view) as the host was
/// compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_view_init(view: *mut perion_view, struct_size: i64) {
    // SAFETY: the header's contract.
    unsafe { sized::init(view, struct_size) }
}

/// Lends the host DISPLACEMENT, VELOCITY or its own BODY_FORCE to read and write. Until all views are
/// returned, calls that change the simulation give ERROR_STATE.
///
/// ERROR_ARGUMENT: struct_size not set or too small for a view, unknown field. ERROR_UNSUPPORTED: a field
/// that cannot be lent. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_borrow(
    simulation: *mut perion_simulation,
    field: perion_field,
    view: *mut perion_view,
) -> perion_status {
    guard("perion_simulation_borrow", || {
        let field = field_of(field)?;
        // SAFETY: the header's contract.
        unsafe {
            check_view(view)?;
            let lent = handle::exclusive(simulation, |hosted| {
                let Hosted { simulation, loans, .. } = hosted;
                let data = simulation.lend(field)?.as_mut_ptr();
                loans.lend(simulation, field, true, data)
            })?;
            sized::write(view, &lent, "view")
        }
    })
}

/// Lends the host DISPLACEMENT, VELOCITY, ACCELERATION or INTERNAL_FORCE to read only: `data` must not be
/// written to. A run of steps
/// ends with ERROR_STATE when its progress callback has borrowed a view and not returned it.
///
/// ERROR_ARGUMENT: as perion_simulation_borrow. ERROR_STATE: ACCELERATION or INTERNAL_FORCE after a change;
/// evaluate first. ERROR_UNSUPPORTED: a field that is computed when asked for; get it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_borrow_const(
    simulation: *const perion_simulation,
    field: perion_field,
    view: *mut perion_view,
) -> perion_status {
    guard("perion_simulation_borrow_const", || {
        let field = field_of(field)?;
        // SAFETY: the header's contract.
        unsafe {
            check_view(view)?;
            let lent = handle::shared(simulation, |hosted| {
                let data = hosted.simulation.show(field)?.as_ptr().cast_mut();
                hosted.loans.lend(&hosted.simulation, field, false, data)
            })?;
            sized::write(view, &lent, "view")
        }
    })
}

/// Returns a borrowed view and clears it. One that was lent to read only can be returned in a progress
/// callback too.
///
/// ERROR_ARGUMENT: not a view that this simulation has lent and not yet got back. ERROR_NUMERIC: the host
/// has written a value that is not finite (the message names the point); the view stays borrowed, mend
/// it and return it again. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_return(
    simulation: *mut perion_simulation,
    view: *mut perion_view,
) -> perion_status {
    guard("perion_simulation_return", || {
        // SAFETY: the header's contract.
        unsafe {
            check_view(view)?;
            let cleared: perion_view = std::mem::zeroed();
            let given = sized::read(view, cleared, "view")?;
            let loan = handle::shared(simulation.cast_const(), |hosted| hosted.loans.find(&given))?;
            if loan.writable {
                handle::exclusive(simulation, |hosted| {
                    hosted.simulation.take_back(loan.field)?;
                    hosted.loans.settle(loan);
                    Ok(())
                })?;
            } else {
                handle::shared(simulation.cast_const(), |hosted| {
                    // What must not have been written to may have been.
                    hosted.simulation.take_back(loan.field)?;
                    hosted.loans.settle(loan);
                    Ok(())
                })?;
            }
            sized::write(view, &cleared, "view")
        }
    })
}

/// A view that the host cannot see whole is of no use.
///
/// # Safety
/// As for [`sized::size_of_host`].
unsafe fn check_view(view: *mut perion_view) -> Result<(), Failure> {
    // SAFETY: the caller's promise.
    let bytes = unsafe { sized::size_of_host(view, "view") }?;
    if bytes < size_of::<perion_view>() {
        return Ok(argument(format!(
            "the struct_size of 'view' is {bytes}, too small for a view; let perion_view_init set it"
        ))?);
    }
    Ok(())
}
