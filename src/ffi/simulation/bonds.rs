//! Bonds in C: breaking, weakening and listing them.

use super::setup::{change, look, perion_simulation};
use crate::error::{Error, argument};
use crate::ffi::arguments::{convert, index, output, slice, slice_mut};
use crate::ffi::guard::{Failure, guard};
use crate::ffi::status::perion_status;
use crate::memory;

/// Pairs of the host, each [2], as the library takes them.
///
/// # Safety
/// As for [`slice`], with twice as many values.
unsafe fn read_pairs(pairs: *const i64, count: i64) -> Result<Vec<[usize; 2]>, Failure> {
    convert(count, "count")?;
    let numbers = count.checked_mul(2).ok_or_else(|| {
        Error::Argument(format!("'count' is {count}; memory cannot hold so many pairs"))
    })?;
    // SAFETY: the caller's promise.
    let given = unsafe { slice(pairs, numbers, "pairs") }?;
    let mut read = memory::reserved(given.len() / 2, "pairs")?;
    for (place, pair) in given.as_chunks::<2>().0.iter().enumerate() {
        read.push([index(pair[0], "pairs", place)?, index(pair[1], "pairs", place)?]);
    }
    Ok(read)
}

/// Breaks the bonds of `count` pairs of points for good; pairs: [count][2] indices from 0. Pairs
/// without a bond are passed over, and told to the log. Allowed at any time; what the bonds held is
/// dissipated.
///
/// ERROR_ARGUMENT: an index out of range, a point paired with itself. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_break_bonds(
    simulation: *mut perion_simulation,
    count: i64,
    pairs: *const i64,
) -> perion_status {
    guard("perion_simulation_break_bonds", || {
        // SAFETY: the header's contract.
        unsafe {
            let pairs = read_pairs(pairs, count)?;
            change(simulation, |simulation| Ok(simulation.break_bonds(&pairs)?))
        }
    })
}

/// Breaks every bond that crosses a planar polygon (3D, at least 3 vertices) or a segment (2D, 2
/// vertices) for good. vertices: [vertex_count][dimension] lengths in the reference configuration.
/// Points within 1e-9 spacings of the plane (or what the rounding of large coordinates amounts to) belong
/// to its positive side: where the vertices are seen to run counter-clockwise, in 2D to the left of the
/// segment. The rim belongs to the crack; bonds within the plane stay. A crack that no bond crosses is
/// told to the log.
///
/// ERROR_ARGUMENT: too few or too many vertices, ones not finite or not in a plane, no extent. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_break_crossing(
    simulation: *mut perion_simulation,
    vertex_count: i64,
    vertices: *const f64,
) -> perion_status {
    guard("perion_simulation_break_crossing", || {
        convert(vertex_count, "vertex_count")?;
        // SAFETY: the header's contract.
        unsafe {
            change(simulation, |simulation| {
                let dimension = simulation.points().dimension() as i64;
                let Some(numbers) = vertex_count.checked_mul(dimension) else {
                    return Ok(argument(format!("'vertex_count' is {vertex_count}"))?);
                };
                let vertices = slice(vertices, numbers, "vertices")?;
                Ok(simulation.break_crossing(vertices)?)
            })
        }
    })
}

/// Sets the integrity of the bonds of `count` pairs of points: 1 intact, 0 broken. pairs: [count][2]
/// indices from 0; values: [count]. A broken bond stays broken; pairs without a bond are passed over, and
/// told to the log. Allowed at any time: what bonds lose is dissipated, what they gain given by the host.
///
/// ERROR_ARGUMENT: an index out of range, a point paired with itself, a value outside 0 to 1. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_bond_integrity(
    simulation: *mut perion_simulation,
    count: i64,
    pairs: *const i64,
    values: *const f64,
) -> perion_status {
    guard("perion_simulation_set_bond_integrity", || {
        // SAFETY: the header's contract.
        unsafe {
            let pairs = read_pairs(pairs, count)?;
            let values = slice(values, count, "values")?;
            change(simulation, |simulation| Ok(simulation.set_bond_integrity(&pairs, values)?))
        }
    })
}

/// Lists all bonds, broken ones too, each once: pairs [count][2] indices from 0, stretch [count] at the
/// current displacement, integrity [count] (1 intact, 0 broken). An array that is NULL is left out;
/// capacity: how many bonds the arrays have room for; call with 0 first, to learn the count alone.
///
/// ERROR_ARGUMENT: capacity below the count and not 0. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_get_bonds(
    simulation: *const perion_simulation,
    capacity: i64,
    pairs_or_null: *mut i64,
    stretch_or_null: *mut f64,
    integrity_or_null: *mut f64,
    count: *mut i64,
) -> perion_status {
    guard("perion_simulation_get_bonds", || {
        let room = convert(capacity, "capacity")?;
        // SAFETY: the header's contract.
        unsafe {
            let count = output(count, "count")?;
            look(simulation, |simulation| {
                let bonds = simulation.bond_count()? as usize;
                if room != 0 {
                    if room < bonds {
                        return Ok(argument(format!(
                            "'capacity' is {room}, but there are {bonds} bonds"
                        ))?);
                    }
                    let number = bonds as i64;
                    let mut pairs = lent(pairs_or_null, 2 * number, "pairs")?;
                    let mut stretches = lent(stretch_or_null, number, "stretch")?;
                    let mut integrities = lent(integrity_or_null, number, "integrity")?;
                    let mut place = 0;
                    simulation.for_each_bond(|pair, stretch, integrity| {
                        if let Some(pairs) = &mut pairs {
                            pairs[2 * place] = pair[0] as i64;
                            pairs[2 * place + 1] = pair[1] as i64;
                        }
                        if let Some(stretches) = &mut stretches {
                            stretches[place] = stretch;
                        }
                        if let Some(integrities) = &mut integrities {
                            integrities[place] = integrity;
                        }
                        place += 1;
                    })?;
                }
                count.write(bonds as i64);
                Ok(())
            })
        }
    })
}

/// Number of bonds, broken or not, each counted once. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_bond_count(
    simulation: *const perion_simulation,
    count: *mut i64,
) -> perion_status {
    guard("perion_simulation_bond_count", || {
        // SAFETY: the header's contract.
        unsafe {
            let count = output(count, "count")?;
            look(simulation, |simulation| {
                count.write(simulation.bond_count()? as i64);
                Ok(())
            })
        }
    })
}

/// An array that the host may leave out.
///
/// # Safety
/// As for [`slice_mut`].
unsafe fn lent<'a, T: Copy>(
    pointer: *mut T,
    count: i64,
    name: &'static str,
) -> Result<Option<&'a mut [T]>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    unsafe { slice_mut(pointer, count, name) }.map(Some)
}
