//! Images, samplers and textures.
//!
//! An image is opened and decoded once, when a material first reads it, and shared by all textures
//! of it. One that is missing or cannot be decoded costs a note that names it; materials then choose
//! what stands in. External images that nothing reads are still looked for, so that a file's missing
//! parts are all named.

use super::accessor::Accessors;
use super::container::{decode_base64, inline_data};
use super::context::{Context, Place};
use super::json::Value;
use crate::{Filter, Texture, TextureId, Wrap};
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_image::codec::{Limits, read_picture};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pixels that any file may unpack to, and how many more for each of its bytes.
const PIXELS: u64 = 1 << 26;
const PIXELS_PER_BYTE: u64 = 64;

/// Where textures may name an image in a format of their own, and what that is.
const SOURCES: [(&str, &str); 4] = [
    ("KHR_texture_basisu", "KTX2"),
    ("EXT_texture_webp", "WebP"),
    ("EXT_texture_avif", "AVIF"),
    ("MSFT_texture_dds", "DDS"),
];

type Pixels = Arc<Plane<[u8; 4]>>;

/// What became of an image.
#[derive(Clone)]
enum Image {
    Unread,
    Wrong,
    Decoded(Pixels),
}

/// The textures that materials read so far.
pub(super) struct Textures<'t, 'r, 'b> {
    root: &'r Value<'r>,
    accessors: &'t Accessors<'r, 'b>,
    images: Vec<Image>,
    /// The id of each of the document's textures that was read.
    ids: BTreeMap<usize, Option<TextureId>>,
    textures: Vec<Texture>,
    grey: Option<TextureId>,
    pixels: u64,
}

impl<'t, 'r, 'b> Textures<'t, 'r, 'b> {
    /// Textures of a document in `bytes` bytes.
    pub(super) fn new(root: &'r Value<'r>, accessors: &'t Accessors<'r, 'b>, bytes: u64) -> Self {
        Self {
            root,
            accessors,
            images: vec![Image::Unread; root.list("images").len()],
            ids: BTreeMap::new(),
            textures: Vec::new(),
            grey: None,
            pixels: PIXELS.saturating_add(bytes.saturating_mul(PIXELS_PER_BYTE)),
        }
    }

    /// The texture with that index in the document; `None`, with a note, where there is none to see.
    pub(super) fn get(&mut self, index: usize, cx: &mut Context) -> Result<Option<TextureId>> {
        if let Some(known) = self.ids.get(&index) {
            return Ok(*known);
        }
        let item = &self.root.list("textures")[index];
        let id = match self.image_of(item, Place::new("texture", index), cx)? {
            None => None,
            Some((image, pixels)) => {
                let name = image_name(&self.root.list("images")[image], image);
                Some(self.push(Texture { name, pixels, ..self.sampled(item) }))
            }
        };
        self.ids.insert(index, id);
        Ok(id)
    }

    /// The flat mid-grey that stands in for colours that are missing.
    pub(super) fn grey(&mut self) -> TextureId {
        if let Some(grey) = self.grey {
            return grey;
        }
        // One half of the light, encoded.
        let pixels = Arc::new(Plane::filled(1, 1, [188, 188, 188, 255]));
        let name = "stand-in".into();
        let grey = Texture { name, pixels, wrap: [Wrap::Repeat; 2], filter: Filter::Nearest };
        let id = self.push(grey);
        self.grey = Some(id);
        id
    }

    /// All textures that were read, and the missing files of those that were not.
    pub(super) fn finish(self, cx: &mut Context) -> Result<Vec<Texture>> {
        for (i, item) in self.root.list("images").iter().enumerate() {
            let unread = matches!(self.images[i], Image::Unread);
            if let Some(uri) = item.text("uri").filter(|u| unread && inline_data(u).is_none()) {
                open(uri, "nothing that is drawn reads it", cx)?;
            }
        }
        Ok(self.textures)
    }

    fn push(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId::new(self.textures.len() - 1)
    }

    /// An empty texture with the wrap modes and the filter of a document's texture.
    fn sampled(&self, item: &Value) -> Texture {
        let samplers = self.root.list("samplers");
        let index = item.index("sampler", samplers.len()).ok().flatten();
        let sampler = index.map_or(&Value::Null, |i| &samplers[i]);
        let wrap = |key: &str| match sampler.get(key).as_whole() {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let nearest = sampler.get("magFilter").as_whole() == Some(9728);
        Texture {
            name: String::new(),
            pixels: Arc::default(),
            wrap: [wrap("wrapS"), wrap("wrapT")],
            filter: if nearest { Filter::Nearest } else { Filter::Linear },
        }
    }

    /// Which image a texture shows, and its pixels.
    fn image_of(
        &mut self,
        item: &Value,
        place: Place,
        cx: &mut Context,
    ) -> Result<Option<(usize, Pixels)>> {
        let count = self.images.len();
        let plain = item.index("source", count);
        let mut special = SOURCES.iter().filter_map(|(name, format)| {
            item.extension(name).index("source", count).ok().flatten().map(|i| (i, *format))
        });
        let index = match (plain, special.next()) {
            (Ok(Some(index)), _) => index,
            (_, Some((index, format))) => {
                cx.note(
                    Place::new("image", index),
                    format!("{format} is not read; export PNG or JPEG ({STAND_IN})"),
                );
                return Ok(None);
            }
            (plain, None) => {
                let why = plain.err().unwrap_or_else(|| "it names no image".into());
                cx.note(place, format!("{why} ({STAND_IN})"));
                return Ok(None);
            }
        };
        Ok(self.decoded(index, cx)?.map(|pixels| (index, pixels)))
    }

    fn decoded(&mut self, index: usize, cx: &mut Context) -> Result<Option<Pixels>> {
        let state = match self.images[index].clone() {
            Image::Unread => match self.decode(index, cx)? {
                Some(plane) => Image::Decoded(Arc::new(plane)),
                None => Image::Wrong,
            },
            read => read,
        };
        self.images[index] = state.clone();
        Ok(if let Image::Decoded(pixels) = state { Some(pixels) } else { None })
    }

    /// Opens and decodes an image; `None`, with a note, where that fails.
    fn decode(&mut self, index: usize, cx: &mut Context) -> Result<Option<Plane<[u8; 4]>>> {
        let item = &self.root.list("images")[index];
        let name = image_name(item, index);
        let opened;
        let bytes: &[u8] = match item.text("uri") {
            Some(uri) => {
                opened = match inline_data(uri) {
                    Some(data) => decode_base64(data).unwrap_or_default(),
                    None => match open(uri, STAND_IN, cx)? {
                        Some(bytes) => bytes,
                        None => return Ok(None),
                    },
                };
                &opened
            }
            None => match self.accessors.view_bytes(item, Place::new("image", index), cx) {
                Ok(bytes) => bytes,
                Err(Error::Input { why, .. }) => {
                    cx.remark(format!("{name}: {why} ({STAND_IN})"));
                    return Ok(None);
                }
                Err(other) => return Err(other),
            },
        };
        self.picture(&name, bytes, cx)
    }

    fn picture(
        &mut self,
        name: &str,
        bytes: &[u8],
        cx: &mut Context,
    ) -> Result<Option<Plane<[u8; 4]>>> {
        let pixels = cx.door.left.pixels.min(self.pixels);
        match read_picture(bytes, name, &Limits { pixels, ..Limits::default() }) {
            Ok(plane) => {
                self.pixels -= (plane.len() as u64).min(self.pixels);
                cx.spend("pixels", |b| &mut b.pixels, plane.len())?;
                Ok(Some(plane))
            }
            Err(Error::Input { path, why, .. }) => {
                cx.remark(format!("{path}: {why} ({STAND_IN})"));
                Ok(None)
            }
            Err(other) => Err(other),
        }
    }
}

/// What materials do without an image.
const STAND_IN: &str = "mid-grey stands in for its colours, a smooth surface for its relief";

/// The bytes of an external image; `None`, with a note, where it is missing.
fn open(uri: &str, instead: &str, cx: &mut Context) -> Result<Option<Vec<u8>>> {
    match cx.door.open(uri) {
        Ok(bytes) => {
            cx.has_read(bytes.len());
            Ok(Some(bytes))
        }
        Err(Error::Input { why, .. }) => {
            let shown: String = uri.chars().filter(|c| !c.is_control()).take(200).collect();
            cx.remark(format!("{shown}: {why} ({instead})"));
            if !cx.missing.contains(&shown) {
                cx.missing.push(shown);
            }
            Ok(None)
        }
        Err(other) => Err(other),
    }
}

/// What to call an image: its file, its name, or its place.
fn image_name(item: &Value, index: usize) -> String {
    let file = item.text("uri").filter(|u| inline_data(u).is_none());
    let name = file.map_or_else(|| item.name(), str::to_owned);
    let name: String = name.chars().filter(|c| !c.is_control()).take(200).collect();
    if name.is_empty() { Place::new("image", index).to_string() } else { name }
}
