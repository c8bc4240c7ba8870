//! The XML of a `.vtu` file: which arrays there are and where their numbers stand.

use std::borrow::Cow;
use std::fmt::Display;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::error::Result;
use crate::memory;
use crate::points::read::source::{Source, integer, shown};

/// What the file says of itself.
pub(super) struct Document<'a> {
    pub(super) big_endian: bool,
    /// Bytes of the numbers that lead each binary array.
    pub(super) header_bytes: usize,
    pub(super) compressed: bool,
    pub(super) pieces: Vec<Piece<'a>>,
    pub(super) appended: Option<Appended<'a>>,
}

/// The arrays behind the XML.
pub(super) struct Appended<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) base64: bool,
}

/// A part of the grid.
pub(super) struct Piece<'a> {
    pub(super) points: u64,
    pub(super) cells: u64,
    pub(super) arrays: Vec<Array<'a>>,
    start: usize,
}

/// Where an array belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Points,
    Cells,
    PointData,
    CellData,
}

/// An array of numbers.
pub(super) struct Array<'a> {
    pub(super) place: Place,
    pub(super) name: String,
    pub(super) kind: Number,
    pub(super) components: u64,
    pub(super) data: Data<'a>,
    start: usize,
}

/// Where the numbers of an array stand.
pub(super) enum Data<'a> {
    Text(Cow<'a, [u8]>),
    Base64(Cow<'a, [u8]>),
    Appended(u64),
}

/// A kind of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Number {
    /// By VTK's name.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::Signed(1),
            "Int16" => Self::Signed(2),
            "Int32" => Self::Signed(4),
            "Int64" => Self::Signed(8),
            "UInt8" => Self::Unsigned(1),
            "UInt16" => Self::Unsigned(2),
            "UInt32" => Self::Unsigned(4),
            "UInt64" => Self::Unsigned(8),
            "Float32" => Self::Float(4),
            "Float64" => Self::Float(8),
            _ => return None,
        })
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Signed(bytes) | Self::Unsigned(bytes) | Self::Float(bytes) => bytes,
        }
    }
}

impl<'a> Piece<'a> {
    /// The array of a name, in whatever case.
    pub(super) fn named(&self, place: Place, name: &str) -> Option<&Array<'a>> {
        let fits = |array: &&Array| array.place == place && array.name.eq_ignore_ascii_case(name);
        self.arrays.iter().find(fits)
    }

    pub(super) fn flaw<T>(&self, source: &Source, text: impl Display) -> Result<T> {
        source.flaw(source.line_of(self.start), text)
    }

    pub(super) fn unsupported<T>(&self, source: &Source, text: impl Display) -> Result<T> {
        source.unsupported(source.line_of(self.start), text)
    }
}

impl Array<'_> {
    pub(super) fn is_whole(&self) -> bool {
        !matches!(self.kind, Number::Float(_))
    }

    pub(super) fn flaw<T>(&self, source: &Source, text: impl Display) -> Result<T> {
        let name = if self.name.is_empty() {
            format!("of {:?}", self.place)
        } else {
            shown(self.name.as_bytes())
        };
        let text = format!("array {name}: {text}");
        source.flaw(source.line_of(self.start), text)
    }
}

pub(super) fn parse(source: &Source) -> Result<Document<'_>> {
    let mut xml = Xml::new(source);
    let mut document = xml.root()?;
    let mut place = None;
    let mut at_top = true;
    loop {
        match xml.next()? {
            Event::Start(tag) => match tag.name().as_ref() {
                "UnstructuredGrid" => at_top = false,
                "Piece" => {
                    let piece = xml.piece(&tag)?;
                    memory::push(&mut document.pieces, piece, "pieces")?;
                }
                "Points" => place = Some(Place::Points),
                "Cells" => place = Some(Place::Cells),
                "PointData" => place = Some(Place::PointData),
                "CellData" => place = Some(Place::CellData),
                "DataArray" => {
                    let array = xml.array(&tag, place, false)?;
                    keep(&mut document, array)?;
                }
                "AppendedData" => {
                    document.appended = Some(xml.appended(&tag)?);
                    return Ok(document);
                }
                _ => {}
            },
            Event::Empty(tag) => match tag.name().as_ref() {
                "DataArray" => {
                    let array = xml.array(&tag, place, true)?;
                    keep(&mut document, array)?;
                }
                "Piece" => {
                    let piece = xml.piece(&tag)?;
                    memory::push(&mut document.pieces, piece, "pieces")?;
                }
                _ => {}
            },
            Event::End(tag) => match tag.name().as_ref() {
                "Points" | "Cells" | "PointData" | "CellData" => place = None,
                _ => {}
            },
            Event::Eof => break,
            _ => {}
        }
    }
    if at_top {
        return source.flaw_of_all("expected an UnstructuredGrid, found none");
    }
    Ok(document)
}

/// Adds an array to the piece it is in.
fn keep<'a>(document: &mut Document<'a>, array: Option<Array<'a>>) -> Result<()> {
    match (array, document.pieces.last_mut()) {
        (Some(array), Some(piece)) => memory::push(&mut piece.arrays, array, "arrays"),
        _ => Ok(()),
    }
}

struct Xml<'a> {
    source: &'a Source,
    reader: Reader<&'a [u8]>,
    /// Where the latest tag began.
    start: usize,
}

impl<'a> Xml<'a> {
    fn new(source: &'a Source) -> Self {
        Self { source, reader: Reader::from_reader(&source.bytes[..]), start: 0 }
    }

    fn next(&mut self) -> Result<Event<'a>> {
        self.start = self.reader.buffer_position() as usize;
        match self.reader.read_event() {
            Ok(event) => Ok(event),
            Err(reason) => {
                let line = self.source.line_of(self.reader.error_position() as usize);
                let reason = shown(reason.to_string().as_bytes());
                self.source.flaw(line, format_args!("expected XML, found a fault: {reason}"))
            }
        }
    }

    fn flaw<T>(&self, text: impl Display) -> Result<T> {
        self.source.flaw(self.source.line_of(self.start), text)
    }

    fn unsupported<T>(&self, text: impl Display) -> Result<T> {
        self.source.unsupported(self.source.line_of(self.start), text)
    }

    /// The value of an attribute.
    fn attribute(&self, tag: &BytesStart, name: &str) -> Result<Option<String>> {
        match tag.try_get_attribute(name) {
            Ok(None) => Ok(None),
            Ok(Some(found)) => Ok(Some(found.value.into_owned())),
            Err(reason) => {
                let reason = shown(reason.to_string().as_bytes());
                self.flaw(format_args!("expected attributes, found a fault: {reason}"))
            }
        }
    }

    fn required(&self, tag: &BytesStart, name: &str) -> Result<String> {
        match self.attribute(tag, name)? {
            Some(value) => Ok(value),
            None => self.flaw(format_args!("expected an attribute '{name}', found none")),
        }
    }

    fn count(&self, value: &str, name: &str) -> Result<u64> {
        match integer(value.trim().as_bytes()).and_then(|count| u64::try_from(count).ok()) {
            Some(count) => Ok(count),
            None => self.flaw(format_args!(
                "expected a count as {name}, found {}",
                shown(value.as_bytes())
            )),
        }
    }

    /// The tag that everything stands in.
    fn root(&mut self) -> Result<Document<'a>> {
        let tag = loop {
            match self.next()? {
                Event::Start(tag) => break tag,
                Event::Eof => return self.flaw("expected VTKFile, found the end of the file"),
                _ => {}
            }
        };
        if tag.name().as_ref() != "VTKFile" {
            return self.flaw(format_args!(
                "expected VTKFile, found {}",
                shown(tag.name().as_ref().as_bytes())
            ));
        }
        let of = self.required(&tag, "type")?;
        if of != "UnstructuredGrid" {
            let text = format!("expected an UnstructuredGrid, found {}", shown(of.as_bytes()));
            return self.unsupported(text);
        }
        let big_endian = match self.attribute(&tag, "byte_order")?.as_deref() {
            None | Some("LittleEndian") => false,
            Some("BigEndian") => true,
            Some(other) => {
                return self.flaw(format_args!(
                    "expected a byte_order, found {}",
                    shown(other.as_bytes())
                ));
            }
        };
        let header_bytes = match self.attribute(&tag, "header_type")?.as_deref() {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => {
                return self.flaw(format_args!(
                    "expected a header_type, found {}",
                    shown(other.as_bytes())
                ));
            }
        };
        let compressed = match self.attribute(&tag, "compressor")?.as_deref() {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return self.unsupported(format_args!(
                    "arrays packed by {} are not read; save it with ZLib or without compression",
                    shown(other.as_bytes())
                ));
            }
        };
        Ok(Document { big_endian, header_bytes, compressed, pieces: Vec::new(), appended: None })
    }

    fn piece(&self, tag: &BytesStart) -> Result<Piece<'a>> {
        let count = |name| self.count(&self.required(tag, name)?, name);
        let (points, cells) = (count("NumberOfPoints")?, count("NumberOfCells")?);
        Ok(Piece { points, cells, arrays: Vec::new(), start: self.start })
    }

    /// An array that belongs somewhere, with its numbers.
    fn array(
        &mut self,
        tag: &BytesStart,
        place: Option<Place>,
        empty: bool,
    ) -> Result<Option<Array<'a>>> {
        let start = self.start;
        let Some(place) = place else { return Ok(None) };
        let of = self.required(tag, "type")?;
        // Texts and bits belong to nothing that is read here.
        let Some(kind) = Number::named(&of) else { return Ok(None) };
        let name = self.attribute(tag, "Name")?.unwrap_or_default();
        let components = match self.attribute(tag, "NumberOfComponents")? {
            Some(value) => self.count(&value, "NumberOfComponents")?,
            None => 1,
        };
        let data = match self.attribute(tag, "format")?.as_deref() {
            Some("appended") => {
                let offset = self.required(tag, "offset")?;
                Data::Appended(self.count(&offset, "offset")?)
            }
            Some("binary") => Data::Base64(self.text(empty)?),
            None | Some("ascii") => Data::Text(self.text(empty)?),
            Some(other) => {
                return self
                    .flaw(format_args!("expected a format, found {}", shown(other.as_bytes())));
            }
        };
        Ok(Some(Array { place, name, kind, components, data, start }))
    }

    /// The text of the tag that has just begun, up to its end; what else stands within is passed over.
    fn text(&mut self, empty: bool) -> Result<Cow<'a, [u8]>> {
        let mut text: Cow<'a, [u8]> = Cow::Borrowed(&[]);
        let (mut depth, start) = (usize::from(!empty), self.start);
        while depth > 0 {
            let from = self.reader.buffer_position() as usize;
            let event = self.next()?;
            let to = self.reader.buffer_position() as usize;
            let piece: &[u8] = match event {
                Event::Start(_) => {
                    depth += 1;
                    continue;
                }
                Event::End(_) => {
                    depth -= 1;
                    continue;
                }
                Event::Text(_) if depth == 1 => self.source.bytes.get(from..to).unwrap_or(&[]),
                Event::CData(_) if depth == 1 => {
                    let piece = self.source.bytes.get(from..to).unwrap_or(&[]);
                    let piece = piece.strip_prefix(b"<![CDATA[").unwrap_or(piece);
                    piece.strip_suffix(b"]]>").unwrap_or(piece)
                }
                Event::Eof => {
                    self.start = start;
                    return self.flaw("expected the end of the array, found the end of the file");
                }
                _ => continue,
            };
            if text.trim_ascii().is_empty() {
                text = Cow::Borrowed(piece);
            } else if !piece.trim_ascii().is_empty() {
                let mut joined = memory::reserved(text.len() + piece.len() + 1, "an array")?;
                joined.extend_from_slice(&text);
                joined.push(b' ');
                joined.extend_from_slice(piece);
                text = Cow::Owned(joined);
            }
        }
        Ok(text)
    }

    /// What follows the XML.
    fn appended(&self, tag: &BytesStart) -> Result<Appended<'a>> {
        let base64 = match self.required(tag, "encoding")?.as_str() {
            "raw" => false,
            "base64" => true,
            other => {
                let text = format!(
                    "expected raw or base64 as encoding, found {}",
                    shown(other.as_bytes())
                );
                return self.flaw(text);
            }
        };
        let from = self.reader.buffer_position() as usize;
        let rest = &self.source.bytes[from.min(self.source.bytes.len())..];
        match rest.trim_ascii_start().strip_prefix(b"_") {
            Some(bytes) => Ok(Appended { bytes, base64 }),
            None => self.flaw("expected _ before the appended data, found none"),
        }
    }
}
