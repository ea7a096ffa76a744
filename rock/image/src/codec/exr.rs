//! OpenEXR: any number of named channels of floats or whole numbers, in and out.
//!
//! The container (headers, chunk table, chunks) is read and written here, so that every size is
//! checked before memory is asked for, chunks go through the ambient thread pool, and equal images
//! give equal bytes. Only the compression of a chunk is the `exr` library's.
//!
//! Written: one part of scan lines, ZIP compression in blocks of 16 lines, 32-bit floats and whole
//! numbers, channels and attributes sorted by name. Read: single and multi-part files, scan lines
//! and tiles (of mip maps the largest level), half and single floats and whole numbers, every
//! compression but HTJ2K. Not read: deep data, channels at a lower resolution than the picture.
//!
//! Format: *OpenEXR File Layout*, Academy Software Foundation.

mod compression;
mod cursor;
mod header;
mod layout;
mod read;
mod write;

pub use read::read_exr;
pub use write::write_exr;

use crate::Plane;
use std::collections::BTreeMap;

/// A file's worth of channels, all of one size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrImage {
    /// Width and height in pixels.
    pub size: (usize, usize),
    /// Channels by their full names: `R`, `depth.Z`, `ViewLayer.Combined.R`.
    pub layers: Vec<(String, ExrChannel)>,
    /// Attributes that are text; the recipe goes here under `chiaro`.
    pub attributes: BTreeMap<String, String>,
}

/// One channel of an [`ExrImage`].
#[derive(Clone, Debug, PartialEq)]
pub enum ExrChannel {
    /// Floats, as light, depth and directions are.
    F32(Plane<f32>),
    /// Whole numbers, as identifiers are.
    U32(Plane<u32>),
}

impl ExrImage {
    /// The channel of this name, if it is one of floats.
    pub fn f32(&self, name: &str) -> Option<&Plane<f32>> {
        self.layers.iter().find(|(n, _)| n == name).and_then(|(_, channel)| match channel {
            ExrChannel::F32(plane) => Some(plane),
            ExrChannel::U32(_) => None,
        })
    }

    /// The channel of this name, if it is one of whole numbers.
    pub fn u32(&self, name: &str) -> Option<&Plane<u32>> {
        self.layers.iter().find(|(n, _)| n == name).and_then(|(_, channel)| match channel {
            ExrChannel::U32(plane) => Some(plane),
            ExrChannel::F32(_) => None,
        })
    }

    /// The picture in the file: linear red, green, blue and alpha, the colours multiplied by alpha
    /// as the format has it. It is `R G B A`; else the layer called `Combined`, which is Blender's;
    /// else the first layer that has the three; else grey from `Y`. Without an alpha it is opaque.
    pub fn colour(&self) -> Option<Plane<[f32; 4]>> {
        let [r, g, b] = self.colour_names()?.map(|name| self.f32(&name));
        let (red, green, blue) = (r?.pixels(), g?.pixels(), b?.pixels());
        let alpha = self.alpha_name().and_then(|name| self.f32(&name)).map(Plane::pixels);
        let (width, height) = self.size;
        Some(Plane::from_fn(width, height, |x, y| {
            let i = y * width + x;
            [red[i], green[i], blue[i], alpha.map_or(1.0, |a| a[i])]
        }))
    }

    fn colour_names(&self) -> Option<[String; 3]> {
        if let Some(prefix) = self.colour_prefix() {
            return Some(["R", "G", "B"].map(|c| format!("{prefix}{c}")));
        }
        self.f32("Y").map(|_| ["Y", "Y", "Y"].map(String::from))
    }

    fn alpha_name(&self) -> Option<String> {
        Some(format!("{}A", self.colour_prefix().unwrap_or_default()))
    }

    /// What stands before `R`, `G` and `B` in the names of the picture's channels.
    fn colour_prefix(&self) -> Option<&str> {
        let complete = |prefix: &&str| {
            ["R", "G", "B"].iter().all(|c| self.f32(&format!("{prefix}{c}")).is_some())
        };
        let names = self.layers.iter().map(|(name, _)| name.as_str());
        let prefixes: Vec<&str> =
            names.filter_map(|name| name.strip_suffix('R')).filter(complete).collect();
        let plain = |p: &&&str| p.is_empty();
        let combined = |p: &&&str| p.ends_with("Combined.");
        let best = prefixes.iter().find(plain).or_else(|| prefixes.iter().find(combined));
        best.or(prefixes.first()).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(names: &[&str]) -> ExrImage {
        let layer = |(i, name): (usize, &&str)| {
            (name.to_string(), ExrChannel::F32(Plane::filled(2, 1, i as f32)))
        };
        let layers = names.iter().enumerate().map(layer).collect();
        ExrImage { size: (2, 1), layers, attributes: BTreeMap::new() }
    }

    #[test]
    fn the_picture_is_found_among_the_layers() {
        let colour = |names: &[&str]| image(names).colour().map(|p| p[(1, 0)]);
        assert_eq!(colour(&["A", "B", "G", "R", "d.Z"]), Some([3.0, 2.0, 1.0, 0.0]));
        let blender =
            ["V.AO.R", "V.AO.G", "V.AO.B", "V.Combined.R", "V.Combined.G", "V.Combined.B"];
        assert_eq!(colour(&blender), Some([3.0, 4.0, 5.0, 1.0]));
        assert_eq!(colour(&["x.R", "x.B", "y.R", "y.G", "y.B"]), Some([2.0, 3.0, 4.0, 1.0]));
        assert_eq!(colour(&["Y"]), Some([0.0, 0.0, 0.0, 1.0]));
        assert_eq!(colour(&["depth.Z", "R"]), None);
    }
}
