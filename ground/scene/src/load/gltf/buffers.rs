//! Buffers and their views: where a document's bytes are.
//!
//! Every buffer is read when the document is; one that is missing or may not be read is an error,
//! for geometry without its data is none. A view that does not fit its buffer is an error where it
//! is used.

use super::container::{decode_base64, inline_data};
use super::context::{Context, Place};
use super::json::Value;
use super::requirements::unsupported;
use chiaro_basis::{Error, Result};
use std::borrow::Cow;

/// The names under which views are compressed by meshopt.
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// All buffers.
pub(super) struct Buffers<'b> {
    buffers: Vec<Buffer<'b>>,
}

enum Buffer<'b> {
    Bytes(Cow<'b, [u8]>),
    /// Has no bytes, and says it only stands for data that this extension unpacks.
    Unpacked(&'static str),
    /// Has no bytes.
    Nowhere,
}

/// Part of a buffer.
#[derive(Clone, Copy)]
pub(super) struct View<'b> {
    pub(super) bytes: &'b [u8],
    /// Bytes from one element to the next, if the view says so.
    pub(super) stride: Option<usize>,
}

impl<'b> Buffers<'b> {
    /// Reads all buffers; `binary` is the chunk of a `.glb`.
    pub(super) fn read(root: &Value, binary: Option<&'b [u8]>, cx: &mut Context) -> Result<Self> {
        let mut buffers = Vec::new();
        for (i, item) in root.list("buffers").iter().enumerate() {
            buffers.push(match item.text("uri") {
                Some(uri) => Buffer::Bytes(Cow::Owned(open(uri, Place::new("buffer", i), cx)?)),
                None => match (i, binary, stand_in(item)) {
                    (0, Some(chunk), _) => Buffer::Bytes(Cow::Borrowed(chunk)),
                    (_, _, Some(name)) => Buffer::Unpacked(name),
                    _ => Buffer::Nowhere,
                },
            });
        }
        if root.list("bufferViews").iter().any(is_compressed) {
            cx.remark("meshopt data is passed over for the uncompressed data beside it");
        }
        Ok(Self { buffers })
    }

    /// The bytes of view `index`, whose object is one of `views`.
    pub(super) fn view(&self, views: &[Value], index: usize, cx: &Context) -> Result<View<'_>> {
        let item = &views[index];
        let place = Place::new("bufferView", index);
        let wrong = |why: String| cx.wrong(place, why);
        let buffer = item.get("buffer").as_index("buffer", self.buffers.len()).map_err(wrong)?;
        let bytes: &[u8] = match &self.buffers[buffer] {
            Buffer::Bytes(bytes) => bytes,
            Buffer::Unpacked(name) => return Err(unsupported(cx, name)),
            Buffer::Nowhere => return Err(cx.wrong(Place::new("buffer", buffer), "it has no uri")),
        };
        let start = item.whole("byteOffset", 0).map_err(wrong)?;
        let length = item.get("byteLength").as_whole().unwrap_or(0);
        let part = start.checked_add(length).and_then(|end| bytes.get(start..end));
        let part = part.ok_or_else(|| too_long(place, start, length, buffer, bytes.len(), cx))?;
        let stride = item.whole("byteStride", 0).map_err(wrong)?;
        Ok(View { bytes: part, stride: (stride > 0).then_some(stride) })
    }
}

fn too_long(
    place: Place,
    start: usize,
    length: usize,
    buffer: usize,
    has: usize,
    cx: &Context,
) -> Error {
    let why =
        format!("it takes {length} bytes from byte {start} of buffer {buffer}, which has {has}");
    cx.wrong(place, why)
}

/// The extension for whose unpacked data a buffer without bytes stands.
fn stand_in(item: &Value) -> Option<&'static str> {
    MESHOPT.into_iter().find(|name| item.extension(name).is_object())
}

/// Whether a view is compressed; its own bytes, if any, are not.
fn is_compressed(view: &Value) -> bool {
    MESHOPT.iter().any(|name| view.extension(name).is_object())
}

/// The bytes at a URI: inline or beside the scene.
fn open(uri: &str, place: Place, cx: &mut Context) -> Result<Vec<u8>> {
    let bytes = match inline_data(uri) {
        Some(data) => {
            decode_base64(data).ok_or_else(|| cx.wrong(place, "its data URI is no base64"))?
        }
        None => match cx.door.open(uri) {
            Ok(bytes) => bytes,
            Err(Error::Input { why, .. }) => {
                let place = format!("{place} {uri:?}");
                let why = format!("{why}, or export as .glb");
                return Err(cx.door.error(place, why));
            }
            Err(other) => return Err(other),
        },
    };
    cx.has_read(bytes.len());
    Ok(bytes)
}
