//! Reads the `.vtu` files that Perion writes: one piece, appended raw 64-bit reals.

use std::fs;

#[derive(Clone, Copy, PartialEq)]
enum Section {
    Field,
    Points,
    PointData,
    Other,
}

/// An array as the header announces it.
struct Announced {
    section: Section,
    name: String,
    kind: String,
    components: usize,
    /// Where its length stands in the appended data.
    offset: Option<usize>,
}

/// A quantity at the points, `components` values a point.
pub struct Field {
    pub components: usize,
    pub values: Vec<f64>,
}

pub struct VtuFile {
    arrays: Vec<Announced>,
    points: usize,
    bytes: Vec<u8>,
    /// Index in `bytes` of the byte that has offset 0.
    start: usize,
}

impl VtuFile {
    pub fn read(path: &str) -> Result<Self, String> {
        let bytes = fs::read(path).map_err(|reason| format!("cannot be read: {reason}"))?;
        Self::parse(bytes)
    }

    fn parse(bytes: Vec<u8>) -> Result<Self, String> {
        let marker = find(&bytes, b"<AppendedData")
            .ok_or("has no <AppendedData>, so it is no .vtu file of Perion")?;
        let header = str::from_utf8(&bytes[..marker]).map_err(|_| "its header is not UTF-8")?;
        let start = find(&bytes[marker..], b"_").ok_or("has no appended data")? + marker + 1;
        let encoding = String::from_utf8_lossy(&bytes[marker..start]);
        if attribute(&encoding, "encoding") != Some("raw") {
            return Err("its appended data are not raw".into());
        }
        let (arrays, points) = parse_header(header)?;
        Ok(Self { arrays, points, bytes, start })
    }

    /// The time of the state, if the file tells it.
    pub fn time(&self) -> Result<Option<f64>, String> {
        match self.find(Section::Field, "TimeValue") {
            Some(array) => Ok(self.reals(array)?.first().copied()),
            None => Ok(None),
        }
    }

    pub fn positions(&self) -> Result<Vec<[f64; 3]>, String> {
        let mut arrays = self.arrays.iter().filter(|array| array.section == Section::Points);
        let array = arrays.next().ok_or("has no <Points>")?;
        if array.components != 3 {
            return Err(format!("its points have {} coordinates, not 3", array.components));
        }
        let coordinates = self.reals(array)?;
        self.check_count(array, coordinates.len())?;
        Ok(coordinates.chunks_exact(3).map(|point| [point[0], point[1], point[2]]).collect())
    }

    /// The field called `name`; `None` if there is none.
    pub fn field(&self, name: &str) -> Result<Option<Field>, String> {
        let Some(array) = self.find(Section::PointData, name) else { return Ok(None) };
        let values = self.reals(array)?;
        self.check_count(array, values.len())?;
        Ok(Some(Field { components: array.components, values }))
    }

    pub fn field_names(&self) -> String {
        let fields = self.arrays.iter().filter(|array| array.section == Section::PointData);
        let names: Vec<&str> = fields.map(|array| array.name.as_str()).collect();
        if names.is_empty() { "no fields".into() } else { names.join(", ") }
    }

    fn find(&self, section: Section, name: &str) -> Option<&Announced> {
        self.arrays.iter().find(|array| array.section == section && array.name == name)
    }

    fn check_count(&self, array: &Announced, values: usize) -> Result<(), String> {
        if self.points.checked_mul(array.components) == Some(values) {
            return Ok(());
        }
        Err(format!(
            "array '{}' has {values} values, not {} for each of {} points",
            array.name, array.components, self.points
        ))
    }

    fn reals(&self, array: &Announced) -> Result<Vec<f64>, String> {
        if array.kind != "Float64" {
            return Err(format!("array '{}' is {}, not Float64", array.name, array.kind));
        }
        let offset =
            array.offset.ok_or(format!("array '{}' has no valid appended offset", array.name))?;
        let payload = self.payload(offset).ok_or(format!(
            "array '{}' reaches beyond the end of the file, which may be cut short",
            array.name
        ))?;
        let (words, rest) = payload.as_chunks::<8>();
        if !rest.is_empty() {
            return Err(format!("array '{}' is not made of 64-bit values", array.name));
        }
        Ok(words.iter().map(|word| f64::from_le_bytes(*word)).collect())
    }

    fn payload(&self, offset: usize) -> Option<&[u8]> {
        let data = self.bytes.get(self.start.checked_add(offset)?..)?;
        let (length, data) = data.split_first_chunk::<8>()?;
        data.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)
    }
}

/// The arrays announced, and the number of points.
fn parse_header(header: &str) -> Result<(Vec<Announced>, usize), String> {
    let mut arrays = Vec::new();
    let mut points = None;
    let mut section = Section::Other;
    let mut is_vtk = false;
    for element in header.split('<').skip(1) {
        let name = element.split([' ', '>', '/', '\t', '\r', '\n']).next().unwrap_or_default();
        match name {
            "VTKFile" => {
                is_vtk = true;
                check_format(element)?;
            }
            "Piece" if points.is_some() => return Err("has more than one piece".into()),
            "Piece" => {
                let count = attribute(element, "NumberOfPoints").and_then(|text| text.parse().ok());
                points = Some(count.ok_or("does not tell its number of points")?);
            }
            "FieldData" => section = Section::Field,
            "Points" => section = Section::Points,
            "PointData" => section = Section::PointData,
            "Cells" | "CellData" => section = Section::Other,
            "DataArray" => arrays.push(announced(element, section)?),
            _ => {}
        }
    }
    if !is_vtk {
        return Err("is not a VTK XML file".into());
    }
    Ok((arrays, points.ok_or("has no <Piece>")?))
}

fn check_format(element: &str) -> Result<(), String> {
    for (name, supported) in
        [("type", "UnstructuredGrid"), ("byte_order", "LittleEndian"), ("header_type", "UInt64")]
    {
        let given = attribute(element, name).unwrap_or("not given");
        if given != supported {
            return Err(format!("its {name} is {given}; only {supported} is supported"));
        }
    }
    if attribute(element, "compressor").is_some() {
        return Err("is compressed; only raw data are supported".into());
    }
    Ok(())
}

fn announced(element: &str, section: Section) -> Result<Announced, String> {
    let text = |name| attribute(element, name).unwrap_or_default();
    let components = attribute(element, "NumberOfComponents").unwrap_or("1");
    let offset = if text("format") == "appended" { text("offset").parse().ok() } else { None };
    Ok(Announced {
        section,
        name: unescaped(text("Name")),
        kind: text("type").into(),
        components: components
            .parse()
            .ok()
            .filter(|&count| count > 0)
            .ok_or(format!("an array has '{components}' components"))?,
        offset,
    })
}

fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = element.split_once(&format!(" {name}=\""))?;
    rest.split_once('"').map(|(value, _)| value)
}

fn unescaped(text: &str) -> String {
    let entities =
        [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    entities
        .iter()
        .fold(text.to_string(), |text, (entity, character)| text.replace(entity, character))
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}
