//! Points in C.

use std::ffi::c_char;

use super::arguments::{convert, index, length, output, slice, slice_mut, text};
use super::guard::guard;
use super::handle::{self, Handle, Opaque};
use super::status::perion_status;
use crate::error::argument;
use crate::memory;
use crate::points::Points;

/// A cloud of points with volumes, optional horizons and named sets.
#[allow(non_camel_case_types)]
pub struct perion_points(Handle<Points>);

impl Opaque for perion_points {
    type Value = Points;
    const NAME: &'static str = "points";
    const MAGIC: u64 = 0x7065_7269_6f6e_0001;
    fn wrap(handle: Handle<Points>) -> Self {
        Self(handle)
    }
    fn handle(&self) -> &Handle<Points> {
        &self.0
    }
}

/// Makes points from the host's arrays, which are copied.
///
/// coordinates: lengths, `dimension` of them a point, `stride` doubles from one point to the next.
/// volumes: `count` of them; in 2D areas. Points may come in any order.
///
/// ERROR_ARGUMENT: dimension not 2 or 3, count below 1, stride below dimension, a coordinate that is
/// not finite, a volume that is not positive, two points in one place. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_create(
    dimension: i32,
    count: i64,
    coordinates: *const f64,
    stride: i64,
    volumes: *const f64,
    points: *mut *mut perion_points,
) -> perion_status {
    guard("perion_points_create", || {
        let axes = convert(dimension.into(), "dimension")?;
        let number = convert(count, "count")?;
        let step = convert(stride, "stride")?;
        // What is refused anyway is not read: the host's array may be shorter than it says.
        let sound = matches!(axes, 2 | 3) && step >= axes;
        let reach = if sound { length(number, step, axes, "coordinates")? } else { 0 };
        // SAFETY: the header's contract.
        unsafe {
            let coordinates = slice(coordinates, reach, "coordinates")?;
            let volumes = slice(volumes, count, "volumes")?;
            let make = || Ok(Points::from_strided(axes, coordinates, step, volumes)?);
            handle::create(points, make)
        }
    })
}

/// Makes a block of points: a lattice of cells of edge `spacing` between the corners `lower` and
/// `upper` (`dimension` lengths each), a point in the middle of each cell, x fastest. Counts per axis
/// are rounded; each point has the volume spacing^dimension.
///
/// ERROR_ARGUMENT: dimension not 2 or 3, limits not finite or upside down, spacing not positive or
/// too large, too many points. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_create_block(
    dimension: i32,
    lower: *const f64,
    upper: *const f64,
    spacing: f64,
    points: *mut *mut perion_points,
) -> perion_status {
    guard("perion_points_create_block", || {
        let axes = convert(dimension.into(), "dimension")?;
        // Another dimension is refused before its corners are read.
        let corner = if matches!(dimension, 2 | 3) { i64::from(dimension) } else { 0 };
        // SAFETY: the header's contract.
        unsafe {
            let (lower, upper) = (slice(lower, corner, "lower")?, slice(upper, corner, "upper")?);
            handle::create(points, || Ok(Points::block(axes, lower, upper, spacing)?))
        }
    })
}

/// Reads points from a file, whose name tells what it is: .inp (Abaqus), .msh (Gmsh 4.1 or 2.2, text or
/// binary), .vtu (VTK), anything else text.
///
/// Text: a point a line, "x y z volume", "x y z block volume", or "x y area" in 2D, with blanks or commas between;
/// #, ! and % begin comments. A first line may name the columns, in any order and with others beside
/// them. Blocks become sets block_1 and so on.
///
/// Mesh: each cell of the highest dimension becomes a point in its centroid with its volume (plane cells: its
/// area), in the file's order. Groups of such cells (*ELSET, physical groups) become sets; a group of nodes
/// (*NSET), or of cells of lower dimension such as the faces of a boundary, becomes the set of the
/// points whose cells have one of its nodes. A name that other points have already gets "_2"; a group
/// without points is left out. perion_points_get_set_name lists what came of them.
///
/// A .vtu without cells, or with vertices only, is a cloud with a point array "volume"; it is 2D if all z are
/// 0. An integer array "block" gives sets.
///
/// ERROR_IO: it cannot be read. ERROR_FORMAT: it is not what it should be; the text says file and line (where
/// a line is at fault), what was expected and what was found. ERROR_UNSUPPORTED: what points cannot express, such as includes and
/// instances of Abaqus, or curved shells. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_read(
    path: *const c_char,
    points: *mut *mut perion_points,
) -> perion_status {
    guard("perion_points_read", || {
        // SAFETY: the header's contract.
        unsafe {
            let path = text(path, "path")?;
            handle::create(points, || Ok(Points::read(path)?))
        }
    })
}

/// Gives each point its own horizon (a length, `count` of them) in place of the model's.
///
/// ERROR_ARGUMENT: count is not the number of points, a horizon that is not positive. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_set_horizons(
    points: *mut perion_points,
    count: i64,
    horizons: *const f64,
) -> perion_status {
    guard("perion_points_set_horizons", || {
        // SAFETY: the header's contract.
        unsafe {
            let horizons = slice(horizons, count, "horizons")?;
            handle::exclusive(points, |points| Ok(points.set_horizons(horizons)?))
        }
    })
}

/// Names a set of points by their indices (from 0, `count` of them), whose order it keeps. The set
/// "all" exists from the start.
///
/// ERROR_ARGUMENT: name empty, taken, longer than 255 bytes, with blanks around it or control characters, count below 1, an index out of range
/// or given twice. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_add_set(
    points: *mut perion_points,
    name: *const c_char,
    count: i64,
    indices: *const i64,
) -> perion_status {
    guard("perion_points_add_set", || {
        // SAFETY: the header's contract.
        unsafe {
            let name = text(name, "name")?;
            let size = convert(count, "count")?;
            handle::exclusive(points, |points| {
                if size > points.count() {
                    return Ok(points.refuse_set_of(size)?);
                }
                let given = slice(indices, count, "indices")?;
                let mut indices = memory::reserved(given.len(), "a set")?;
                for (place, &value) in given.iter().enumerate() {
                    indices.push(index(value, "indices", place)?);
                }
                Ok(points.add_set(name, &indices)?)
            })
        }
    })
}

/// Names the set of the points within a box, its faces included, in the order of the points. lower and
/// upper: one length an axis; infinite ones leave a side open.
///
/// ERROR_ARGUMENT: as perion_points_add_set; a box upside down or without points. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_add_set_box(
    points: *mut perion_points,
    name: *const c_char,
    lower: *const f64,
    upper: *const f64,
) -> perion_status {
    guard("perion_points_add_set_box", || {
        // SAFETY: the header's contract.
        unsafe {
            let name = text(name, "name")?;
            handle::exclusive(points, |points| {
                let axes = points.dimension() as i64;
                let (lower, upper) = (slice(lower, axes, "lower")?, slice(upper, axes, "upper")?);
                Ok(points.add_set_box(name, lower, upper)?)
            })
        }
    })
}

/// Number of points. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_count(
    points: *const perion_points,
    count: *mut i64,
) -> perion_status {
    guard("perion_points_count", || {
        // SAFETY: the header's contract.
        unsafe {
            let count = output(count, "count")?;
            handle::shared(points, |points| {
                count.write(points.count() as i64);
                Ok(())
            })
        }
    })
}

/// Number of axes, 2 or 3. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_dimension(
    points: *const perion_points,
    dimension: *mut i32,
) -> perion_status {
    guard("perion_points_dimension", || {
        // SAFETY: the header's contract.
        unsafe {
            let dimension = output(dimension, "dimension")?;
            handle::shared(points, |points| {
                dimension.write(points.dimension() as i32);
                Ok(())
            })
        }
    })
}

/// Number of points of a set. ERROR_ARGUMENT: no such set. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_set_size(
    points: *const perion_points,
    name: *const c_char,
    count: *mut i64,
) -> perion_status {
    guard("perion_points_set_size", || {
        // SAFETY: the header's contract.
        unsafe {
            let (name, count) = (text(name, "name")?, output(count, "count")?);
            handle::shared(points, |points| {
                count.write(points.set_size(name)? as i64);
                Ok(())
            })
        }
    })
}

/// Room that the name of any set needs, the NUL at its end included.
pub const PERION_NAME_CAPACITY: i64 = 256;

/// Number of named sets; "all", which always exists, is not among them. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_set_count(
    points: *const perion_points,
    count: *mut i64,
) -> perion_status {
    guard("perion_points_set_count", || {
        // SAFETY: the header's contract.
        unsafe {
            let count = output(count, "count")?;
            handle::shared(points, |points| {
                count.write(points.set_names().len() as i64);
                Ok(())
            })
        }
    })
}

/// Copies the name of a set to the host, its NUL included; index: from 0, in alphabetical order. capacity: bytes
/// of `name`, of which PERION_NAME_CAPACITY are always enough.
///
/// ERROR_ARGUMENT: index out of range, capacity too small. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_get_set_name(
    points: *const perion_points,
    index: i64,
    name: *mut c_char,
    capacity: i64,
) -> perion_status {
    guard("perion_points_get_set_name", || {
        let (place, room) = (convert(index, "index")?, convert(capacity, "capacity")?);
        // SAFETY: the header's contract.
        unsafe {
            handle::shared(points, |points| {
                let count = points.set_names().len();
                let Some(known) = points.set_names().nth(place) else {
                    return Ok(argument(format!(
                        "'index' is {index}; it must be below the number of sets, {count}"
                    ))?);
                };
                if known.len() >= room {
                    return Ok(argument(format!(
                        "'capacity' is {capacity}, but the name and its NUL have {} bytes",
                        known.len() + 1
                    ))?);
                }
                let length = known.len() as i64 + 1;
                let name = slice_mut(name.cast::<u8>(), length, "name")?;
                let (letters, end) = name.split_at_mut(known.len());
                letters.copy_from_slice(known.as_bytes());
                end.fill(0);
                Ok(())
            })
        }
    })
}

/// The indices of a set, from 0, in the set's order. count: the set's size.
///
/// ERROR_ARGUMENT: no such set, or another count than its size. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_get_set(
    points: *const perion_points,
    name: *const c_char,
    count: i64,
    indices: *mut i64,
) -> perion_status {
    guard("perion_points_get_set", || {
        // SAFETY: the header's contract.
        unsafe {
            let name = text(name, "name")?;
            handle::shared(points, |points| {
                super::arguments::expect_count(count, points.set_size(name)?, "count")?;
                let mut indices = slice_mut(indices, count, "indices")?.iter_mut();
                points.for_each_in_set(name, |point| {
                    if let Some(index) = indices.next() {
                        *index = point as i64;
                    }
                })?;
                Ok(())
            })
        }
    })
}

/// The positions of all points (lengths), point after point. length: count x dimension.
///
/// ERROR_ARGUMENT: another length. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_get_coordinates(
    points: *const perion_points,
    coordinates: *mut f64,
    length: i64,
) -> perion_status {
    guard("perion_points_get_coordinates", || {
        // SAFETY: the header's contract.
        unsafe {
            handle::shared(points, |points| {
                let known = points.coordinates();
                super::arguments::expect_count(length, known.len(), "length")?;
                slice_mut(coordinates, length, "coordinates")?.copy_from_slice(known);
                Ok(())
            })
        }
    })
}

/// The volumes of all points; in 2D areas. length: the number of points.
///
/// ERROR_ARGUMENT: another length. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_get_volumes(
    points: *const perion_points,
    volumes: *mut f64,
    length: i64,
) -> perion_status {
    guard("perion_points_get_volumes", || {
        // SAFETY: the header's contract.
        unsafe {
            handle::shared(points, |points| {
                super::arguments::expect_count(length, points.count(), "length")?;
                slice_mut(volumes, length, "volumes")?.copy_from_slice(points.volumes());
                Ok(())
            })
        }
    })
}

/// Frees the points and sets the pointer to NULL; NULL, or the address of NULL, is fine. Simulations
/// made of them keep their own copy. ERROR_STATE: another call is using them. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_points_destroy(points: *mut *mut perion_points) -> perion_status {
    // SAFETY: the header's contract.
    guard("perion_points_destroy", || unsafe { handle::destroy(points) })
}
