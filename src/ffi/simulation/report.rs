//! What a run has done, in C.

use crate::error::argument;
use crate::ffi::guard::Failure;
use crate::ffi::sized::{self, Sized64};

/// What a run has done: advance, solve or relax. Members that do not belong to it are 0. Let perion_report_init set
/// struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_report {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// steps completed; of solve load steps, of relax 1
    pub steps: i64,
    /// how often the stable step was found
    pub estimates: i64,
    /// the smallest time step, 0 when none was made
    pub smallest_time_step: f64,
    /// the largest time step
    pub largest_time_step: f64,
    /// the stable step as it was last found
    pub stable_time_step: f64,
    /// time of the last completed step
    pub time: f64,
    /// of solve: load steps that failed and were cut
    pub cuts: i64,
    /// of solve: linear systems solved; of relax: its steps
    pub iterations: i64,
    /// of solve and relax: forces evaluated
    pub evaluations: i64,
    /// of solve and relax: bonds broken
    pub broken_bonds: i64,
    /// of solve and relax: share of the way to the conditions that was gone, 1 when complete
    pub share: f64,
    /// of solve and relax: relative residual of the last iteration
    pub residual: f64,
    /// of solve and relax: elastic energy at the end of a run that succeeded
    pub elastic: f64,
    /// of solve and relax: work of loads and constraints
    pub external_work: f64,
    /// given by the host: room for relative residuals, one an iteration, and how many numbers it has; NULL for none
    pub residuals_or_null: *mut f64,
    /// see above
    pub residual_capacity: i64,
    /// how many residuals there are; the first residual_capacity are written
    pub residual_count: i64,
    /// given by the host: room for as many energies of the motion of relax, over the largest that it had, one a step; NULL
    /// for none
    pub energies_or_null: *mut f64,
}

// SAFETY: plain numbers and pointers behind struct_size.
unsafe impl Sized64 for perion_report {}

const EMPTY: perion_report = perion_report {
    struct_size: 0,
    steps: 0,
    estimates: 0,
    smallest_time_step: 0.0,
    largest_time_step: 0.0,
    stable_time_step: 0.0,
    time: 0.0,
    cuts: 0,
    iterations: 0,
    evaluations: 0,
    broken_bonds: 0,
    share: 0.0,
    residual: 0.0,
    elastic: 0.0,
    external_work: 0.0,
    residuals_or_null: std::ptr::null_mut(),
    residual_capacity: 0,
    residual_count: 0,
    energies_or_null: std::ptr::null_mut(),
};

/// Clears the struct and sets its struct_size; struct_size: sizeof(perion_report) as the host was
/// compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_report_init(report: *mut perion_report, struct_size: i64) {
    // SAFETY: the header's contract.
    unsafe { sized::init(report, struct_size) }
}

/// The report that the host wants, if any.
pub(super) struct HostReport {
    pointer: *mut perion_report,
    /// For residuals and energies.
    rooms: [*mut f64; 2],
    capacity: i64,
}

impl HostReport {
    /// Checked before anything is done. Only runs that have residuals look at the room for them.
    ///
    /// # Safety
    /// The pointer is NULL or leads to a struct whose first member says how many bytes it has.
    pub(super) unsafe fn of(
        pointer: *mut perion_report,
        has_residuals: bool,
    ) -> Result<Self, Failure> {
        if pointer.is_null() {
            return Ok(Self { pointer, rooms: [std::ptr::null_mut(); 2], capacity: 0 });
        }
        // SAFETY: the caller's promise.
        let given = unsafe { sized::read(pointer, EMPTY, "report") }?;
        let rooms = [given.residuals_or_null, given.energies_or_null];
        let capacity = given.residual_capacity;
        let is_bad = |room: &*mut f64| !room.is_null() && (capacity < 0 || !room.is_aligned());
        if has_residuals && rooms.iter().any(is_bad) {
            return Ok(argument(format!(
                "'residual_capacity' is {capacity}; it must not be negative, and residuals_or_null and \
                 energies_or_null must lead to doubles"
            ))?);
        }
        Ok(Self { pointer, rooms, capacity })
    }

    /// Fills the host's struct.
    ///
    /// # Safety
    /// As for [`HostReport::of`], still.
    pub(super) unsafe fn tell(&self, fill: impl FnOnce(&mut perion_report)) -> Result<(), Failure> {
        if self.pointer.is_null() {
            return Ok(());
        }
        let [residuals_or_null, energies_or_null] = self.rooms;
        let residual_capacity = self.capacity;
        let mut told =
            perion_report { residuals_or_null, residual_capacity, energies_or_null, ..EMPTY };
        fill(&mut told);
        // SAFETY: the caller's promise.
        unsafe { sized::write(self.pointer, &told, "report") }
    }

    /// Fills the host's rooms for residuals and energies.
    ///
    /// # Safety
    /// As for [`HostReport::of`], still; the rooms have what their capacity says.
    pub(super) unsafe fn list(&self, residuals: &[f64], energies: &[f64]) {
        for (room, numbers) in self.rooms.into_iter().zip([residuals, energies]) {
            if room.is_null() {
                continue;
            }
            let count = numbers.len().min(self.capacity as usize);
            // SAFETY: the caller's promise.
            unsafe { std::ptr::copy_nonoverlapping(numbers.as_ptr(), room, count) };
        }
    }
}
