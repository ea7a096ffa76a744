//! The header of a PLY file: what its rows hold, checked against the file's size.

use super::super::text::{parse, text, words};
use super::values::Number;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// As text.
    Ascii,
    /// In binary, the least byte first.
    Little,
    /// In binary, the greatest byte first.
    Big,
}

/// A table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) rows: u64,
    pub(super) properties: Vec<Property>,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// How the length of a list is written; none for single numbers.
    pub(super) length: Option<Number>,
    pub(super) kind: Number,
}

/// Everything before the rows.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) comments: Vec<String>,
    /// Bytes of the header, its last line break included.
    pub(super) bytes: usize,
}

/// What is wrong, and in which line.
pub(super) type Wrong = (u64, String);

impl Header {
    /// Reads the header; every table is known to fit the bytes that follow.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Wrong> {
        let mut header = Self {
            encoding: Encoding::Ascii,
            elements: Vec::new(),
            comments: Vec::new(),
            bytes: 0,
        };
        let mut lines = Lines::new(bytes);
        let mut encoding = None;
        lines.next();
        while let Some(line) = lines.next() {
            let number = lines.number;
            let wrong = |why: &str| (number, format!("{:?} {why}", text(line)));
            let mut parts = words(line);
            match parts.next() {
                None | Some(b"obj_info") => {}
                Some(b"comment") => {
                    header.comments.push(text(line.get(7..).unwrap_or_default()));
                }
                Some(b"format") => {
                    let known = parts.next().and_then(encoding_of);
                    encoding = Some(known.ok_or_else(|| wrong("names no format of PLY 1.0"))?);
                }
                Some(b"element") => header.elements.push(
                    element(parts).ok_or_else(|| wrong("has no name and count of an element"))?,
                ),
                Some(b"property") => {
                    let property = property(parts).ok_or_else(|| wrong("is no property"))?;
                    let element = header.elements.last_mut();
                    element
                        .ok_or_else(|| wrong("comes before any element"))?
                        .properties
                        .push(property);
                }
                Some(b"end_header") => {
                    header.bytes = lines.read;
                    header.encoding =
                        encoding.ok_or((number, "the header names no format".to_owned()))?;
                    header.check(bytes.len() - header.bytes)?;
                    return Ok(header);
                }
                Some(_) => return Err(wrong("belongs in no PLY header")),
            }
        }
        Err((lines.number, "the header has no end_header".into()))
    }

    /// Whether `left` bytes can hold all rows.
    fn check(&self, left: usize) -> Result<(), Wrong> {
        let mut left = left as u64;
        for element in &self.elements {
            let least = element.least_bytes(self.encoding).saturating_mul(element.rows);
            // The last number of a text file needs nothing after it.
            if least > left + u64::from(self.encoding == Encoding::Ascii) {
                let why = format!(
                    "{} rows of {:?} do not fit the {left} bytes left; the file is cut off, or its \
                     header is wrong",
                    element.rows, element.name
                );
                return Err((0, why));
            }
            left = left.saturating_sub(least);
        }
        Ok(())
    }
}

impl Element {
    /// Bytes of the shortest row.
    fn least_bytes(&self, encoding: Encoding) -> u64 {
        let least = |p: &Property| match encoding {
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.kind).bytes() as u64,
        };
        self.properties.iter().map(least).sum()
    }
}

fn encoding_of(word: &[u8]) -> Option<Encoding> {
    match word {
        b"ascii" => Some(Encoding::Ascii),
        b"binary_little_endian" => Some(Encoding::Little),
        b"binary_big_endian" => Some(Encoding::Big),
        _ => None,
    }
}

fn element<'a>(mut parts: impl Iterator<Item = &'a [u8]>) -> Option<Element> {
    let name = text(parts.next()?);
    Some(Element { name, rows: parse(parts.next()?)?, properties: Vec::new() })
}

fn property<'a>(mut parts: impl Iterator<Item = &'a [u8]>) -> Option<Property> {
    let first = parts.next()?;
    let (length, kind) = if first == b"list" {
        (Some(Number::named(parts.next()?)?), Number::named(parts.next()?)?)
    } else {
        (None, Number::named(first)?)
    };
    Some(Property { name: text(parts.next()?).to_ascii_lowercase(), length, kind })
}

/// Lines that end as the first one does: in LF, CR LF or CR.
struct Lines<'a> {
    bytes: &'a [u8],
    end: u8,
    /// Bytes of the lines so far.
    read: usize,
    /// The number of the last line, from 1.
    number: u64,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let first = bytes.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(0);
        let only_cr = bytes.get(first) == Some(&b'\r') && bytes.get(first + 1) != Some(&b'\n');
        Self { bytes, end: if only_cr { b'\r' } else { b'\n' }, read: 0, number: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    /// The next line, if it has an end.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.read..];
        let length = rest.iter().position(|b| *b == self.end)?;
        self.read += length + 1;
        self.number += 1;
        Some(rest[..length].trim_ascii())
    }
}
