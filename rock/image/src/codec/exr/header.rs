//! The headers of an OpenEXR file: parsed with every number checked, and written sorted.

use super::cursor::Cursor;
use super::layout::{Channel, Part, Tiles, Window};
use chiaro_basis::Result;
use exr::meta::attribute::{Compression, LevelMode, SampleType};

/// The first four bytes of every file.
const MAGIC: u32 = 20_000_630;

const VERSION: u32 = 2;
const TILED: u32 = 0x200;
const LONG_NAMES: u32 = 0x400;
const DEEP: u32 = 0x800;
const MULTI_PART: u32 = 0x1000;

/// The longest side that is believed, in pixels.
const LONGEST_SIDE: i64 = 1 << 24;

/// The headers of a file, and what lies behind them: the tables of chunks, then the chunks.
pub(super) struct Headers<'a> {
    pub(super) parts: Vec<Part>,
    pub(super) multi_part: bool,
    pub(super) behind: Cursor<'a>,
}

/// Parses the headers of all parts. What it allocates is bounded by the headers' own length.
pub(super) fn parse<'a>(bytes: &'a [u8], name: &'a str) -> Result<Headers<'a>> {
    let mut cursor = Cursor::new(bytes, name);
    if cursor.u32().ok() != Some(MAGIC) {
        return Err(cursor.wrong("this is not an OpenEXR file"));
    }
    let flags = cursor.u32()?;
    if flags & 0xFF > VERSION {
        return Err(cursor.wrong(format!("version {} of the format is not known", flags & 0xFF)));
    }
    if flags & DEEP != 0 {
        return Err(deep(&cursor));
    }
    let multi_part = flags & MULTI_PART != 0;
    let mut parts = Vec::new();
    while let Some(attributes) = attributes(&mut cursor)? {
        parts.push(part(&cursor, &attributes, flags & TILED != 0 && !multi_part)?);
        if !multi_part {
            break;
        }
    }
    if parts.is_empty() {
        return Err(cursor.wrong("the file has no part"));
    }
    Ok(Headers { parts, multi_part, behind: cursor })
}

fn deep(cursor: &Cursor) -> chiaro_basis::Error {
    cursor.wrong("deep data (several samples in a pixel) is not read: flatten it first")
}

/// An attribute as it lies in the file.
struct Attribute<'a> {
    name: String,
    kind: String,
    value: Cursor<'a>,
}

/// The attributes of one header, or `None` where the list of headers ends.
fn attributes<'a>(cursor: &mut Cursor<'a>) -> Result<Option<Vec<Attribute<'a>>>> {
    let mut found = Vec::new();
    loop {
        let name = cursor.text()?;
        if name.is_empty() {
            return Ok(Some(found).filter(|list| !list.is_empty()));
        }
        let kind = cursor.text()?;
        let size = cursor.count()?;
        let value = cursor.take(size)?;
        found.push(Attribute { name, kind, value: cursor.over(value) });
    }
}

/// A part from its attributes.
fn part(cursor: &Cursor, attributes: &[Attribute], tiled: bool) -> Result<Part> {
    let optional = |name: &str, kind: &str| {
        attributes.iter().find(|a| a.name == name && a.kind == kind).map(|a| a.value)
    };
    let required = |name: &str, kind: &str| {
        optional(name, kind).ok_or_else(|| cursor.wrong(format!("the header has no {name}")))
    };
    let kind = optional("type", "string").map(|value| string(&value));
    if kind.as_deref().is_some_and(|kind| kind.starts_with("deep")) {
        return Err(deep(cursor));
    }
    let window = window(required("dataWindow", "box2i")?)?;
    let tiled = kind.map_or(tiled, |kind| kind == "tiledimage");
    let part = Part {
        name: optional("name", "string").map(|value| string(&value)),
        window,
        display: optional("displayWindow", "box2i").map_or(Ok(window), self::window)?,
        channels: channels(required("channels", "chlist")?)?,
        compression: compression(required("compression", "compression")?)?,
        tiles: if tiled { Some(tiles(required("tiles", "tiledesc")?)?) } else { None },
        attributes: texts(attributes),
    };
    Ok(part)
}

fn string(value: &Cursor) -> String {
    String::from_utf8_lossy(value.rest).trim_end_matches('\0').to_owned()
}

/// The attributes that are text and that no reader needs for the pixels.
fn texts(attributes: &[Attribute]) -> Vec<(String, String)> {
    let text = |a: &&Attribute| a.kind == "string" && a.name != "type" && a.name != "name";
    attributes.iter().filter(text).map(|a| (a.name.clone(), string(&a.value))).collect()
}

fn window(mut value: Cursor) -> Result<Window> {
    let [left, top, right, bottom] =
        [value.i32()?, value.i32()?, value.i32()?, value.i32()?].map(i64::from);
    let (width, height) = (right - left + 1, bottom - top + 1);
    if !(1..=LONGEST_SIDE).contains(&width) || !(1..=LONGEST_SIDE).contains(&height) {
        return Err(value.wrong(format!("a window of {width} x {height} pixels makes no sense")));
    }
    Ok(Window { x: left, y: top, width: width as usize, height: height as usize })
}

fn channels(mut value: Cursor) -> Result<Vec<Channel>> {
    let mut list = Vec::new();
    loop {
        let name = value.text()?;
        if name.is_empty() {
            break;
        }
        let sample = match value.u32()? {
            0 => SampleType::U32,
            1 => SampleType::F16,
            2 => SampleType::F32,
            other => return Err(value.wrong(format!("channel {name} has samples of kind {other}"))),
        };
        let linear = value.take(4)?[0] != 0;
        if (value.u32()?, value.u32()?) != (1, 1) {
            let why = format!("channel {name} has a lower resolution: it must be saved as RGB");
            return Err(value.wrong(why));
        }
        list.push(Channel { name, sample, linear });
    }
    if list.is_empty() { Err(value.wrong("the file has no channel")) } else { Ok(list) }
}

fn compression(mut value: Cursor) -> Result<Compression> {
    use Compression::*;
    let known = [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, B44, B44A, DWAA(None), DWAB(None)];
    let number = usize::from(value.u8()?);
    let unknown = || value.wrong(format!("compression {number} is not read: choose ZIP"));
    known.get(number).copied().ok_or_else(unknown)
}

fn tiles(mut value: Cursor) -> Result<Tiles> {
    let (width, height, mode) = (value.u32()?, value.u32()?, value.u8()?);
    let levels = match mode & 0x0F {
        0 => LevelMode::Singular,
        1 => LevelMode::MipMap,
        2 => LevelMode::RipMap,
        other => return Err(value.wrong(format!("tiles have levels of kind {other}"))),
    };
    let sides = 1..=LONGEST_SIDE as u32;
    if !sides.contains(&width) || !sides.contains(&height) {
        return Err(value.wrong(format!("tiles of {width} x {height} pixels make no sense")));
    }
    let (width, height) = (width as usize, height as usize);
    Ok(Tiles { width, height, levels, round_up: mode >> 4 == 1 })
}

/// The magic number, version and header of a file with this one part.
pub(super) fn write(part: &Part) -> Vec<u8> {
    let window = window_bytes(&part.window);
    let mut attributes = vec![
        ("channels", "chlist", channel_bytes(&part.channels)),
        ("compression", "compression", vec![3]),
        ("dataWindow", "box2i", window.clone()),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", vec![0]),
        ("pixelAspectRatio", "float", 1.0f32.to_le_bytes().to_vec()),
        ("screenWindowCenter", "v2f", vec![0; 8]),
        ("screenWindowWidth", "float", 1.0f32.to_le_bytes().to_vec()),
    ];
    let texts = part.attributes.iter();
    attributes
        .extend(texts.map(|(name, text)| (name.as_str(), "string", text.clone().into_bytes())));
    attributes.sort();
    let names = attributes.iter().map(|(name, ..)| *name);
    let names = names.chain(part.channels.iter().map(|c| c.name.as_str()));
    let long = names.map(str::len).any(|length| length > 31);
    let mut bytes = MAGIC.to_le_bytes().to_vec();
    bytes.extend((if long { VERSION | LONG_NAMES } else { VERSION }).to_le_bytes());
    for (name, kind, value) in &attributes {
        bytes.extend(zero_ended(name));
        bytes.extend(zero_ended(kind));
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    }
    bytes.push(0);
    bytes
}

/// The names of the attributes that [`write`] makes, which no text may take.
pub(super) const RESERVED: [&str; 10] = [
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "type",
];

fn zero_ended(text: &str) -> impl Iterator<Item = u8> {
    text.bytes().chain([0])
}

fn window_bytes(window: &Window) -> Vec<u8> {
    let (right, bottom) = (window.width as i32 - 1, window.height as i32 - 1);
    [0, 0, right, bottom].iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn channel_bytes(channels: &[Channel]) -> Vec<u8> {
    let entry = |channel: &Channel| {
        let sample: u32 = match channel.sample {
            SampleType::U32 => 0,
            SampleType::F16 => 1,
            SampleType::F32 => 2,
        };
        let numbers =
            [sample, u32::from(channel.linear), 1, 1].into_iter().flat_map(u32::to_le_bytes);
        zero_ended(&channel.name).chain(numbers).collect::<Vec<u8>>()
    };
    channels.iter().flat_map(entry).chain([0]).collect()
}
