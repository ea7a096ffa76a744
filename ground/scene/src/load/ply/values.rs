//! The numbers of a PLY file's rows, one after the other, in text or in binary.

use super::super::text::parse;
use super::header::Encoding;

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    /// The type of that name, old or new.
    pub(super) fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Its size in binary.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The greatest whole number that a colour of this type reaches; none for fractions.
    pub(super) fn white(self) -> Option<f32> {
        match self {
            Self::I8 | Self::U8 => Some(255.0),
            Self::I16 | Self::U16 => Some(65_535.0),
            Self::I32 | Self::U32 => Some(255.0),
            Self::F32 | Self::F64 => None,
        }
    }
}

/// What is left of the rows.
pub(super) struct Values<'a> {
    rest: &'a [u8],
    encoding: Encoding,
}

impl<'a> Values<'a> {
    pub(super) fn new(rest: &'a [u8], encoding: Encoding) -> Self {
        Self { rest, encoding }
    }

    /// The next number, or none when there is none.
    pub(super) fn next(&mut self, kind: Number) -> Option<f64> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::Little => self.little(kind),
            Encoding::Big => self.big(kind),
        }
    }

    /// Whether `count` more numbers can follow, so that memory for them may be asked for.
    pub(super) fn can_hold(&self, count: u64, kind: Number) -> bool {
        let each = if self.encoding == Encoding::Ascii { 2 } else { kind.bytes() as u64 };
        count.saturating_mul(each) <= self.rest.len() as u64 + 1
    }

    fn word(&mut self) -> Option<f64> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = &self.rest[start..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(length);
        self.rest = rest;
        Some(parse(word).unwrap_or(f64::NAN))
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*bytes)
    }

    fn little(&mut self, kind: Number) -> Option<f64> {
        Some(match kind {
            Number::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Number::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Number::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Number::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Number::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Number::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Number::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Number::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn big(&mut self, kind: Number) -> Option<f64> {
        Some(match kind {
            Number::I8 => f64::from(i8::from_be_bytes(self.take()?)),
            Number::U8 => f64::from(u8::from_be_bytes(self.take()?)),
            Number::I16 => f64::from(i16::from_be_bytes(self.take()?)),
            Number::U16 => f64::from(u16::from_be_bytes(self.take()?)),
            Number::I32 => f64::from(i32::from_be_bytes(self.take()?)),
            Number::U32 => f64::from(u32::from_be_bytes(self.take()?)),
            Number::F32 => f64::from(f32::from_be_bytes(self.take()?)),
            Number::F64 => f64::from_be_bytes(self.take()?),
        })
    }
}
