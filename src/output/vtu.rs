//! One state of a cloud of points as a VTK XML unstructured grid (`.vtu`), one vertex cell a point.
//!
//! Values follow the XML header as raw little-endian 64-bit numbers, so they come back bit by bit. Nothing is copied: the file is
//! streamed from the caller's slices, and replaces an older one only when it is complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process;

use crate::error::{Error, Result, argument};

/// `VTK_VERTEX`, the cell type of a single point.
const VERTEX: u8 = 1;
/// Each appended array is preceded by its length in bytes, as a `UInt64`.
const LENGTH_BYTES: usize = size_of::<u64>();

/// A named quantity at the points: `components` values a point, point by point.
pub(crate) struct PointArray<'a> {
    pub name: &'a str,
    pub components: usize,
    pub values: &'a [f64],
}

/// Writes the points at `positions` (three coordinates each) with `arrays` to `path`.
///
/// # Errors
/// [`Error::Argument`] if a name cannot stand in XML, [`Error::Internal`] if an array does not fit the number of points, and
/// [`Error::Io`] if the file could not be written; an older file at `path` is then untouched.
pub(crate) fn write(
    path: &Path,
    time: f64,
    positions: &[f64],
    arrays: &[PointArray<'_>],
) -> Result<()> {
    let points = positions.len() / 3;
    if !positions.len().is_multiple_of(3) {
        return Err(Error::Internal(format!(
            "{} coordinates are not three a point, writing '{}'",
            positions.len(),
            path.display()
        )));
    }
    for array in arrays {
        escaped(array.name)?;
        if array.components == 0 || array.components.checked_mul(points) != Some(array.values.len())
        {
            return Err(Error::Internal(format!(
                "array '{}' has {} values, not {} for each of {points} points, writing '{}'",
                array.name,
                array.values.len(),
                array.components,
                path.display()
            )));
        }
    }
    replace_file(path, |out| {
        write_header(out, points, arrays)?;
        write_payload(out, time, positions, arrays)?;
        out.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
    })
}

fn write_header(out: &mut impl Write, points: usize, arrays: &[PointArray<'_>]) -> io::Result<()> {
    let mut header = Header { out, offset: 0 };
    header.text("<?xml version=\"1.0\"?>\n")?;
    header.text("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" ")?;
    header.text("byte_order=\"LittleEndian\" header_type=\"UInt64\">\n")?;
    header.text("  <UnstructuredGrid>\n    <FieldData>\n")?;
    header.array("Float64", "TimeValue", "NumberOfTuples=\"1\"", size_of::<f64>())?;
    header.text("    </FieldData>\n")?;
    header.text(&format!(
        "    <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{points}\">\n      <Points>\n"
    ))?;
    header.array("Float64", "Points", &components(3), points * 3 * size_of::<f64>())?;
    header.text("      </Points>\n      <Cells>\n")?;
    header.array("Int64", "connectivity", &components(1), points * size_of::<i64>())?;
    header.array("Int64", "offsets", &components(1), points * size_of::<i64>())?;
    header.array("UInt8", "types", &components(1), points)?;
    header.text("      </Cells>\n      <PointData>\n")?;
    for array in arrays {
        let name = escaped(array.name).map_err(io::Error::other)?;
        header.array("Float64", &name, &components(array.components), size_of_val(array.values))?;
    }
    header.text("      </PointData>\n    </Piece>\n  </UnstructuredGrid>\n")?;
    header.text("  <AppendedData encoding=\"raw\">\n_")
}

/// The part before the raw data: it says of each array where that will stand.
struct Header<'a, W> {
    out: &'a mut W,
    /// Bytes of raw data announced so far.
    offset: usize,
}

impl<W: Write> Header<'_, W> {
    fn text(&mut self, text: &str) -> io::Result<()> {
        self.out.write_all(text.as_bytes())
    }

    fn array(&mut self, kind: &str, name: &str, shape: &str, bytes: usize) -> io::Result<()> {
        let offset = self.offset;
        self.offset += LENGTH_BYTES + bytes;
        writeln!(
            self.out,
            "        <DataArray type=\"{kind}\" Name=\"{name}\" {shape} format=\"appended\" offset=\"{offset}\"/>"
        )
    }
}

fn components(count: usize) -> String {
    format!("NumberOfComponents=\"{count}\"")
}

/// The arrays in the order in which the header announced them.
fn write_payload(
    out: &mut impl Write,
    time: f64,
    positions: &[f64],
    arrays: &[PointArray<'_>],
) -> io::Result<()> {
    let points = positions.len() / 3;
    write_reals(out, &[time])?;
    write_reals(out, positions)?;
    write_numbers(out, 0..points)?;
    write_numbers(out, 1..points + 1)?;
    write_length(out, points)?;
    for _ in 0..points {
        out.write_all(&[VERTEX])?;
    }
    arrays.iter().try_for_each(|array| write_reals(out, array.values))
}

fn write_length(out: &mut impl Write, bytes: usize) -> io::Result<()> {
    out.write_all(&(bytes as u64).to_le_bytes())
}

fn write_reals(out: &mut impl Write, values: &[f64]) -> io::Result<()> {
    write_length(out, size_of_val(values))?;
    values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
}

fn write_numbers(out: &mut impl Write, numbers: std::ops::Range<usize>) -> io::Result<()> {
    write_length(out, numbers.len() * size_of::<i64>())?;
    for number in numbers {
        out.write_all(&(number as i64).to_le_bytes())?;
    }
    Ok(())
}

/// `text` as it may stand between quotes in XML 1.0.
pub(super) fn escaped(text: &str) -> Result<String> {
    let mut safe = String::new();
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&apos;"),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => {
                return argument(format!(
                    "the name {text:?} contains {character:?}, which cannot stand in a VTK file; leave it out"
                ));
            }
            _ => safe.push(character),
        }
    }
    Ok(safe)
}

/// Gives `path` the content that `fill` writes, in one step: until it is complete, and on any failure, what was there stays.
pub(super) fn replace_file(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    let failed = |tried: &str, reason: io::Error| {
        Error::Io(format!("cannot write '{}': {tried} failed: {reason}", path.display()))
    };
    if path.file_name().is_none() {
        return argument(format!(
            "'path' is '{}', which does not name a file to write",
            path.display()
        ));
    }
    let place = destination(path).map_err(|reason| failed("looking at what is there", reason))?;
    let (temporary, file) = Temporary::beside(&place)
        .map_err(|reason| failed("creating a temporary file beside it", reason))?;
    let mut out = BufWriter::new(file);
    fill(&mut out)
        .and_then(|()| out.into_inner().map_err(io::IntoInnerError::into_error))
        // A full disk may show only when the data leave the cache: before the rename, so that the older file outlives it.
        .and_then(|file| file.sync_all())
        .map_err(|reason| failed("writing a temporary file beside it", reason))?;
    fs::rename(&temporary.path, &place)
        .map_err(|reason| failed("moving the complete file into place", reason))?;
    temporary.keep();
    Ok(())
}

/// The file to replace: where a link leads, and never a device, a pipe or a directory.
fn destination(path: &Path) -> io::Result<PathBuf> {
    let place = match fs::symlink_metadata(path) {
        Ok(there) if there.is_symlink() => fs::canonicalize(path)?,
        Ok(_) => path.to_owned(),
        Err(reason) if reason.kind() == ErrorKind::NotFound => return Ok(path.to_owned()),
        Err(reason) => return Err(reason),
    };
    if fs::metadata(&place)?.is_file() {
        return Ok(place);
    }
    Err(io::Error::other("it is there already and not a regular file"))
}

/// A file that is removed when dropped, unless kept.
struct Temporary {
    path: PathBuf,
    moved: bool,
}

impl Temporary {
    /// A new file in the directory of `target`: a rename cannot cross file systems.
    fn beside(target: &Path) -> io::Result<(Self, File)> {
        let mut attempt = 0_u32;
        loop {
            let path = target.with_file_name(format!(".perion-{}-{attempt}.tmp", process::id()));
            match File::create_new(&path) {
                Ok(file) => return Ok((Self { path, moved: false }, file)),
                // Left by a process that was killed, or in use by another thread or host.
                Err(reason) if reason.kind() == ErrorKind::AlreadyExists && attempt < 9999 => {
                    attempt += 1;
                }
                Err(reason) => return Err(reason),
            }
        }
    }

    fn keep(mut self) {
        self.moved = true;
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.moved {
            // Nothing more can be done about a temporary that cannot be removed; the failure itself is already reported.
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// An empty directory of the test's own.
    pub(in crate::output) fn scratch(test: &str) -> PathBuf {
        let directory = std::env::temp_dir().join(format!("perion-{}-{test}", process::id()));
        let _ = fs::remove_dir_all(&directory);
        fs::create_dir_all(&directory).unwrap();
        directory
    }

    fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
        element.split_once(&format!(" {name}=\"")).unwrap().1.split_once('"').unwrap().0
    }

    /// The raw bytes of the array called `name`, found as a reader finds them: by its offset and its length.
    fn payload<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
        let marker: &[u8] = b"<AppendedData encoding=\"raw\">\n_";
        let start = file.windows(marker.len()).position(|bytes| bytes == marker).unwrap();
        let header = std::str::from_utf8(&file[..start]).unwrap();
        let mut elements = header.split("<DataArray").skip(1);
        let element = elements.find(|element| attribute(element, "Name") == name).unwrap();
        let offset: usize = attribute(element, "offset").parse().unwrap();
        let data = &file[start + marker.len() + offset..];
        let length = u64::from_le_bytes(data[..8].try_into().unwrap()) as usize;
        &data[8..8 + length]
    }

    fn words(bytes: &[u8]) -> impl Iterator<Item = u64> {
        bytes.chunks(8).map(|word| u64::from_le_bytes(word.try_into().unwrap()))
    }

    fn bits(values: &[f64]) -> impl Iterator<Item = u64> {
        values.iter().map(|value| value.to_bits())
    }

    #[test]
    fn every_value_comes_back_bit_by_bit() {
        let path = scratch("bits").join("state.vtu");
        let time = 0.1 + 0.2;
        let positions = [0.0, -0.0, 1e-310, f64::MAX, f64::MIN_POSITIVE, 1.0 / 3.0];
        let damage = [f64::NAN, f64::NEG_INFINITY];
        let shear = [1.0, 2.0, 3.0, 4.0];
        write(
            &path,
            time,
            &positions,
            &[
                PointArray { name: "damage", components: 1, values: &damage },
                PointArray { name: "a<b & \"c\"", components: 2, values: &shear },
            ],
        )
        .unwrap();
        let file = fs::read(&path).unwrap();
        assert!(words(payload(&file, "TimeValue")).eq(bits(&[time])));
        assert!(words(payload(&file, "Points")).eq(bits(&positions)));
        assert!(words(payload(&file, "damage")).eq(bits(&damage)));
        assert!(words(payload(&file, "a&lt;b &amp; &quot;c&quot;")).eq(bits(&shear)));
        assert!(file.ends_with(b"\n  </AppendedData>\n</VTKFile>\n"));
    }

    #[test]
    fn each_point_is_one_vertex_cell() {
        let path = scratch("cells").join("state.vtu");
        write(&path, 0.0, &[0.0; 9], &[]).unwrap();
        let file = fs::read(&path).unwrap();
        assert!(words(payload(&file, "connectivity")).eq([0, 1, 2]));
        assert!(words(payload(&file, "offsets")).eq([1, 2, 3]));
        assert_eq!(payload(&file, "types"), [1; 3]);
        let header = String::from_utf8_lossy(&file);
        assert_eq!(attribute(&header, "type"), "UnstructuredGrid");
        assert_eq!(attribute(&header, "byte_order"), "LittleEndian");
        assert_eq!(attribute(&header, "header_type"), "UInt64");
        assert_eq!(attribute(&header, "NumberOfPoints"), "3");
        assert_eq!(attribute(&header, "NumberOfCells"), "3");
    }

    #[test]
    fn an_array_that_does_not_fit_the_points_is_refused_before_any_file_exists() {
        let directory = scratch("shape");
        let array = PointArray { name: "damage", components: 2, values: &[0.0; 3] };
        let refused = write(&directory.join("state.vtu"), 0.0, &[0.0; 6], &[array]);
        assert!(matches!(refused, Err(Error::Internal(text)) if text.contains("'damage'")));
        let array = PointArray { name: "bell\x07", components: 1, values: &[0.0; 2] };
        let refused = write(&directory.join("state.vtu"), 0.0, &[0.0; 6], &[array]);
        assert!(matches!(refused, Err(Error::Argument(_))));
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 0);
    }

    #[test]
    fn a_failure_leaves_the_older_file_and_no_temporary() {
        let directory = scratch("failure");
        let path = directory.join("state.vtu");
        write(&path, 1.0, &[0.0; 3], &[]).unwrap();
        let older = fs::read(&path).unwrap();
        let failure = replace_file(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::from(ErrorKind::StorageFull))
        });
        let Err(Error::Io(text)) = failure else { panic!("{failure:?}") };
        assert!(text.contains("state.vtu") && text.contains("no storage space"), "{text}");
        assert_eq!(fs::read(&path).unwrap(), older);
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
    }

    #[test]
    fn a_target_that_cannot_be_replaced_is_reported_with_the_reason_of_the_system() {
        let directory = scratch("target");
        let occupied = directory.join("directory.vtu");
        fs::create_dir(&occupied).unwrap();
        let absent = directory.join("no/file.vtu");
        for (path, reason) in [(&occupied, "not a regular file"), (&absent, "os error")] {
            let failure = write(path, 0.0, &[], &[]);
            let Err(Error::Io(text)) = failure else { panic!("{failure:?}") };
            assert!(text.contains(reason), "{text}");
            assert!(text.contains(&path.display().to_string()), "{text}");
        }
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        assert!(matches!(write(Path::new(""), 0.0, &[], &[]), Err(Error::Argument(_))));
    }
}
