//! A lit frame's layers, and how they become files.

use chiaro_basis::Result;
use chiaro_image::Plane;
use chiaro_image::codec::{self, ExrChannel, ExrImage};
use chiaro_image::colour::{srgb_encode, to_byte};
use chiaro_image::tone::Tone;
use chiaro_pbgi::Openings;
use chiaro_pbgi::resolve::Seen;
use chiaro_trace::GBuffer;

/// A lit frame; light is multiplied by the exposure, so that 1 is display white.
pub(crate) struct Layers {
    /// The light of each pixel.
    pub(crate) seen: Plane<Seen>,
    /// Ambient occlusion: the open share of the hemisphere.
    pub(crate) openness: Plane<f32>,
    /// Directional occlusion, where it was asked for.
    pub(crate) openings: Option<Openings>,
    /// Geometry, through pixel centres.
    pub(crate) buffer: GBuffer,
}

/// What stands behind the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Backdrop {
    /// The sky, black where there is none.
    Sky,
    /// A colour, sRGB-encoded RGBA; may be transparent.
    Colour([f32; 4]),
}

impl Layers {
    /// Linear light of the picture and its opacity, before tone mapping.
    fn beauty(&self, seen: &Seen) -> [f32; 3] {
        std::array::from_fn(|c| seen.direct[c] + seen.indirect[c] + seen.specular[c])
    }

    /// The picture as displayed: sRGB-encoded RGBA.
    pub(crate) fn displayed(&self, tone: Tone, backdrop: Backdrop) -> Plane<[u8; 4]> {
        self.seen.map(|s| {
            let own = self.beauty(s);
            match backdrop {
                Backdrop::Sky => {
                    let all = std::array::from_fn(|c| own[c] + s.beyond[c]);
                    let [r, g, b] = tone.map(all).map(|c| to_byte(srgb_encode(c)));
                    [r, g, b, 255]
                }
                Backdrop::Colour(back) => over(own, s.coverage, tone, back),
            }
        })
    }

    /// All layers under their standard names.
    pub(crate) fn exr(&self, recipe: &str) -> Result<Vec<u8>> {
        let b = &self.buffer;
        let mut layers: Vec<(String, ExrChannel)> = Vec::new();
        let mut push =
            |name: String, plane: Plane<f32>| layers.push((name, ExrChannel::F32(plane)));
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            push(name.into(), self.seen.map(|s| self.beauty(s)[c] + s.beyond[c]));
            push(format!("direct.{name}"), self.seen.map(|s| s.direct[c]));
            push(format!("indirect.{name}"), self.seen.map(|s| s.indirect[c]));
            push(format!("specular.{name}"), self.seen.map(|s| s.specular[c]));
            push(format!("albedo.{name}"), b.base_colour.map(|v| v[c]));
        }
        push("A".into(), self.seen.map(|s| s.coverage));
        push("ao.A".into(), self.openness.clone());
        let depth = b.depth.zip(&b.covered, |d, c| if *c { *d } else { f32::INFINITY });
        push("depth.Z".into(), depth?);
        for (c, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            push(format!("normal.{axis}"), b.normal.map(|v| v[c]));
        }
        if let Some(Openings { bent, dome }) = &self.openings {
            for (c, (axis, name)) in [("X", "R"), ("Y", "G"), ("Z", "B")].into_iter().enumerate() {
                push(format!("bent.{axis}"), bent.map(|v| v[c]));
                push(format!("dome.{name}"), dome.map(|v| v[c]));
            }
        }
        let attributes = [("chiaro".to_owned(), recipe.to_owned())].into();
        codec::write_exr(&ExrImage { size: b.size(), layers, attributes })
    }
}

/// Light over a colour, by coverage, both as displayed.
fn over(own: [f32; 3], coverage: f32, tone: Tone, back: [f32; 4]) -> [u8; 4] {
    let share = coverage.clamp(0.0, 1.0);
    let alone = own.map(|c| if share > 0.0 { c / share } else { 0.0 });
    let front = tone.map(alone).map(srgb_encode);
    let alpha = share + back[3] * (1.0 - share);
    let channel = |c: usize| {
        let sum = front[c] * share + back[c] * back[3] * (1.0 - share);
        to_byte(if alpha > 0.0 { sum / alpha } else { 0.0 })
    };
    [channel(0), channel(1), channel(2), to_byte(alpha)]
}
