//! Nonlocal operators in C.

use super::setup::{look_back, perion_simulation};
use crate::error::{Error, Result as Outcome, argument};
use crate::ffi::arguments::{convert, length, present, slice};
use crate::ffi::guard::{Failure, guard};
use crate::ffi::status::perion_status;
use crate::formulation::Operator;
use crate::simulation::Simulation;

/// What a field is differentiated by, and with which bonds (Bergel and Li, Table 1). With xi the bond in the
/// reference body, eta the same deformed and sums over the family, K = sum w xi xi^T V,
/// N = sum w eta xi^T V and M = sum w eta eta^T V.
#[allow(non_camel_case_types)]
pub type perion_operator = i32;
/// By reference coordinates with bonds of the reference body: h = K^-1 xi.
pub const PERION_OPERATOR_REFERENCE_UNDEFORMED: perion_operator = 1;
/// By reference coordinates with deformed bonds: h = N^-1 eta.
pub const PERION_OPERATOR_REFERENCE_DEFORMED: perion_operator = 2;
/// By current coordinates with bonds of the reference body: h = N^-T xi.
pub const PERION_OPERATOR_CURRENT_UNDEFORMED: perion_operator = 3;
/// By current coordinates with deformed bonds: h = M^-1 eta.
pub const PERION_OPERATOR_CURRENT_DEFORMED: perion_operator = 4;

/// A derivative of a field.
type Take = fn(&Simulation, Operator, usize, &[f64]) -> Outcome<Vec<f64>>;

fn operator_of(operator: perion_operator) -> Result<Operator, Failure> {
    match operator {
        PERION_OPERATOR_REFERENCE_UNDEFORMED => Ok(Operator::ReferenceUndeformed),
        PERION_OPERATOR_REFERENCE_DEFORMED => Ok(Operator::ReferenceDeformed),
        PERION_OPERATOR_CURRENT_UNDEFORMED => Ok(Operator::CurrentUndeformed),
        PERION_OPERATOR_CURRENT_DEFORMED => Ok(Operator::CurrentDeformed),
        _ => Ok(argument(format!(
            "'operator' is {operator}; it must be one of the PERION_OPERATOR_ constants, 1 to 4"
        ))?),
    }
}

/// The gradient of a field of the host's, field[count][components], over the families of the simulation at
/// its current displacement: result[count][components][dimension] = sum w (g_j - g_i) h^T V, w the influence
/// function, broken bonds left out. count is the number of points, in the host's order; field and result may
/// be anything, one in the other too. A point without bonds has 0; where the bonds of a point do not span the
/// body, the derivative is that along what they span. Ends set-up.
///
/// ERROR_ARGUMENT: unknown operator, components below 1, a number that is not finite. ERROR_NUMERIC: a
/// derivative that is not finite. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_gradient(
    simulation: *const perion_simulation,
    operator: perion_operator,
    components: i32,
    field: *const f64,
    result: *mut f64,
) -> perion_status {
    guard("perion_simulation_gradient", || {
        // SAFETY: the header's contract.
        unsafe { derivative(simulation, operator, components, field, result, Simulation::gradient) }
    })
}

/// The divergence of a field of the host's of vectors or tensors, field[count][components / dimension][dimension],
/// as perion_simulation_gradient: result[count][components / dimension] = sum w (T_j - T_i) h V.
///
/// ERROR_ARGUMENT: also components no multiple of the dimension. Otherwise as perion_simulation_gradient. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_divergence(
    simulation: *const perion_simulation,
    operator: perion_operator,
    components: i32,
    field: *const f64,
    result: *mut f64,
) -> perion_status {
    guard("perion_simulation_divergence", || {
        // SAFETY: the header's contract.
        unsafe {
            derivative(simulation, operator, components, field, result, Simulation::divergence)
        }
    })
}

/// # Safety
/// `field` leads to `components` numbers a point, `result` to room for the derivative of all points.
unsafe fn derivative(
    simulation: *const perion_simulation,
    operator: perion_operator,
    components: i32,
    field: *const f64,
    result: *mut f64,
    take: Take,
) -> Result<(), Failure> {
    let operator = operator_of(operator)?;
    let components = convert(i64::from(components), "components")?;
    if components == 0 {
        return Err(Error::Argument("'components' is 0; it must be at least 1".into()).into());
    }
    let result = present(result, "result")?;
    // SAFETY: the caller's promise. The field is read to its end before a number is written.
    unsafe {
        look_back(simulation, |simulation| {
            let numbers = length(simulation.points().count(), components, components, "field")?;
            let values = take(simulation, operator, components, slice(field, numbers, "field")?)?;
            std::ptr::copy_nonoverlapping(values.as_ptr(), result, values.len());
            Ok(())
        })
    }
}
