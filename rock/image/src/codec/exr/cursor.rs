//! A walk over bytes that may end anywhere.

use crate::codec::limits::one_line;
use chiaro_basis::{Error, Result};

/// The bytes of one file, read from the front, and the file's name for error messages.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    pub(super) rest: &'a [u8],
    name: &'a str,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8], name: &'a str) -> Self {
        Self { rest: bytes, name }
    }

    /// The same file's name over other bytes of it.
    pub(super) fn over(&self, bytes: &'a [u8]) -> Self {
        Self { rest: bytes, name: self.name }
    }

    /// An [`Error::Input`] about this file.
    pub(super) fn wrong(&self, why: impl std::fmt::Display) -> Error {
        let why = one_line(why);
        Error::input(self.name, "", why + "; export the OpenEXR file again")
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let cut = self.rest.split_at_checked(count);
        let (taken, rest) = cut.ok_or_else(|| self.wrong("the file is cut short"))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        self.take(N).map(|bytes| bytes.try_into().expect("as many bytes as taken"))
    }

    pub(super) fn u8(&mut self) -> Result<u8> {
        self.array().map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Result<i32> {
        self.array().map(i32::from_le_bytes)
    }

    /// A count or size: not negative.
    pub(super) fn count(&mut self) -> Result<usize> {
        let count = self.i32()?;
        usize::try_from(count)
            .map_err(|_| self.wrong(format!("the file is damaged: a size is negative ({count})")))
    }

    /// Text up to its zero byte, at most 255 bytes long. Bytes that are not UTF-8 are replaced.
    pub(super) fn text(&mut self) -> Result<String> {
        let end = self.rest.iter().take(256).position(|&b| b == 0);
        let end =
            end.ok_or_else(|| self.wrong("the file is damaged or cut short: a name does not end"))?;
        let text = self.take(end + 1)?;
        Ok(String::from_utf8_lossy(&text[..end]).into_owned())
    }
}
