//! The container: `.glb` chunks (glTF 2.0, section 4) or plain JSON, and data URIs.

use crate::load::Door;
use base64::Engine;
use base64::alphabet::{STANDARD, URL_SAFE};
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use chiaro_basis::Result;
use std::borrow::Cow;

const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// A file's two parts, borrowed from its bytes.
pub(super) struct Container<'b> {
    /// The JSON document; bytes that are no UTF-8 are replaced.
    pub(super) text: Cow<'b, str>,
    /// The binary chunk of a `.glb`.
    pub(super) binary: Option<&'b [u8]>,
}

/// Whether the bytes are those of a `.glb`.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Splits a file into its parts. [`chiaro_basis::Error::Input`] when a `.glb` is cut short or is of
/// another version.
pub(super) fn split<'b>(bytes: &'b [u8], door: &Door) -> Result<Container<'b>> {
    if !is_binary(bytes) {
        return Ok(Container { text: text(bytes), binary: None });
    }
    let number = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        four.map(u32::from_le_bytes).ok_or_else(|| cut_short(door, at))
    };
    match number(4)? {
        2 => {}
        version => return Err(door.error("header", other_version(version))),
    }
    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    while at < bytes.len() && binary.is_none() {
        let (length, kind) = (number(at)? as usize, number(at + 4)?);
        let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..length));
        let chunk = chunk.ok_or_else(|| cut_short(door, at));
        match kind {
            JSON if json.is_none() => json = Some(chunk?),
            BIN => binary = Some(chunk?),
            _ => drop(chunk?),
        }
        at += 8 + length;
    }
    let json = json.ok_or_else(|| {
        door.error("header", "this .glb has no JSON chunk; export the scene again")
    })?;
    Ok(Container { text: text(json), binary })
}

fn other_version(version: u32) -> String {
    format!(
        "this is a .glb of version {version}, and only version 2 is read; open it in Blender or \
         another tool and export it as glTF 2.0"
    )
}

fn cut_short(door: &Door, at: usize) -> chiaro_basis::Error {
    door.error(
        format!("byte {at}"),
        "the file ends in the midst of a chunk; copy or export it again",
    )
}

/// JSON text without a byte order mark and without the padding of chunks.
fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    String::from_utf8_lossy(&bytes[..end])
}

/// The base64 data of a data URI; `None` when the URI is of another kind.
pub(super) fn inline_data(uri: &str) -> Option<&str> {
    let start = uri.get(..5)?;
    start.eq_ignore_ascii_case("data:").then(|| uri.split_once(',').map_or("", |(_, data)| data))
}

/// The bytes of base64 data, in either alphabet, padded or not, line breaks left out.
pub(super) fn decode_base64(data: &str) -> Option<Vec<u8>> {
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    let decode = |data: &[u8]| {
        let standard = GeneralPurpose::new(&STANDARD, config).decode(data);
        standard.or_else(|_| GeneralPurpose::new(&URL_SAFE, config).decode(data)).ok()
    };
    decode(data.as_bytes()).or_else(|| {
        let without_breaks = |b: &u8| !b.is_ascii_whitespace();
        decode(&data.bytes().filter(without_breaks).collect::<Vec<u8>>())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door() -> Door<'static> {
        Door::new("a.glb", &(), crate::load::Budget::default())
    }

    fn glb(chunks: &[(&[u8], &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*data);
        }
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((body.len() as u32 + 12).to_le_bytes());
        bytes.extend(body);
        bytes
    }

    #[test]
    fn chunks_are_found_and_unknown_ones_passed_over() {
        let bytes = glb(&[(b"JSON", b"{} \0"), (b"ODD!", b"1234"), (b"BIN\0", b"data")]);
        let parts = split(&bytes, &door()).unwrap();
        assert_eq!((parts.text.as_ref(), parts.binary), ("{} ", Some(&b"data"[..])));
        let plain = split(b"\xEF\xBB\xBF{}", &door()).unwrap();
        assert_eq!((plain.text.as_ref(), plain.binary), ("{}", None));
    }

    #[test]
    fn every_cut_is_an_error_or_a_whole_file() {
        let bytes = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"data")]);
        for end in 4..bytes.len() {
            let parts = split(&bytes[..end], &door());
            // After the JSON chunk the file may end.
            assert_eq!(parts.is_ok(), end == 24, "{end}");
        }
        let old = [b"glTF\x01\0\0\0".as_slice(), &[0; 12]].concat();
        assert!(split(&old, &door()).err().unwrap().to_string().contains("version 1"));
    }

    #[test]
    fn base64_comes_in_many_dresses() {
        for data in ["AP+/", "AP-_", "AP+/\n", "A P +\r\n/"] {
            assert_eq!(decode_base64(data).unwrap(), [0, 255, 191], "{data:?}");
        }
        for data in ["AA==", "AA", "AA="] {
            assert_eq!(decode_base64(data).unwrap(), [0]);
        }
        assert!(decode_base64("A*A=").is_none());
        assert_eq!(inline_data("data:;base64,AA=="), Some("AA=="));
        assert_eq!(inline_data("Data:x"), Some(""));
        assert_eq!(inline_data("date.bin"), None);
    }
}
