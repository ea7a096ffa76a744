//! The layers of a picture by another renderer, found by the names that renderers give them.
//!
//! | layer | names | |
//! |---|---|---|
//! | normal | `Normal`, `normal`, `N`, `normals`, `NX NY NZ` | Blender, chiaro, Arnold, V-Ray, 3ds Max |
//! | depth | `Depth.Z`, `depth.Z`, `Z`, `ZDepth` | 1e9 and more is nothing |
//! | position | `Position`, `position`, `P` | world space |
//! | object | `object.ID`, `IndexOB`, `Object Index`, `CryptoObject00` | the first id of a Cryptomatte, bit by bit |
//! | material | `material.ID`, `IndexMA`, `Material Index`, `CryptoMaterial00` | |
//! | albedo | `albedo`, `DiffCol`, `Diffuse Color`, `Denoising Albedo` | linear |
//! | occlusion | `ao.A`, `AO`, `Ambient Occlusion` | |
//! | motion | `motion.X/.Y`, `Vector.X/.Y/.Z/.W` | chiaro; Blender, whose y points up and whose second pair is this frame's place minus the next one's |
//!
//! In front of a name there may be a view layer's (`ViewLayer.Normal.X`); large and small letters
//! count alike.

use chiaro_basis::math::Vec3;
use chiaro_binary::Channel;
use chiaro_image::Plane;
use chiaro_image::codec::{ExrChannel, ExrImage};

/// What a picture brings along. Planes have its size.
#[derive(Clone, Debug, Default)]
pub(super) struct Layers {
    /// Width and height.
    pub(super) size: (usize, usize),
    /// Linear colour, multiplied by alpha, and alpha.
    pub(super) colour: Option<Plane<[f32; 4]>>,
    /// Normals; of no length where there are none.
    pub(super) normal: Option<Plane<[f32; 3]>>,
    /// Depth, growing with distance; infinite where there is nothing.
    pub(super) depth: Option<Plane<f32>>,
    /// World positions.
    pub(super) position: Option<Plane<[f32; 3]>>,
    /// Ids of objects.
    pub(super) object: Option<Plane<u32>>,
    /// Ids of materials.
    pub(super) material: Option<Plane<u32>>,
    /// Linear base colour.
    pub(super) albedo: Option<Plane<[f32; 3]>>,
    /// Appearance channels, in [0, 1].
    pub(super) channels: Vec<(Channel, Plane<f32>)>,
    /// Where the discontinuity map draws lines.
    pub(super) lines: Option<Plane<bool>>,
    /// Motion from frame to frame.
    pub(super) motion: Option<Motion>,
}

/// Where what is seen was and will be, in pixels, x right, y down.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// The place in the frame before minus that in this one.
    pub(super) back: Plane<[f32; 2]>,
    /// The place in the next frame minus that in this one, if known.
    pub(super) forth: Option<Plane<[f32; 2]>>,
}

/// From this depth on there is nothing: renderers write 1e10 or infinity.
const NOTHING: f32 = 1e9;

const NORMAL: [&str; 6] =
    ["normal", "normals", "n", "shadingnormal", "denoisingnormal", "world_normal"];
const DEPTH: [&str; 4] = ["depth", "z", "zdepth", "depth_z"];
const POSITION: [&str; 5] = ["position", "p", "worldposition", "world_position", "pworld"];
const OBJECT: [&str; 5] = ["object", "indexob", "objectindex", "cryptoobject00", "crypto_object00"];
const MATERIAL: [&str; 5] =
    ["material", "indexma", "materialindex", "cryptomaterial00", "crypto_material00"];
const ALBEDO: [&str; 5] =
    ["albedo", "diffcol", "diffusecolor", "denoisingalbedo", "diffuse_albedo"];
const OCCLUSION: [&str; 3] = ["ao", "ambientocclusion", "ambient_occlusion"];

impl Layers {
    /// Finds the layers of an EXR file.
    pub(super) fn of_exr(image: &ExrImage) -> Self {
        let finder = Finder::new(image);
        let channels = Channel::ALL.into_iter().filter_map(|c| {
            let names = if c == Channel::Occlusion { &OCCLUSION[..] } else { &[c.name()][..] };
            let plane = finder.scalar(names)?;
            Some((c, plane.map(|v| if v.is_finite() { v.clamp(0.0, 1.0) } else { 0.0 })))
        });
        Self {
            size: image.size,
            colour: image.colour().map(|plane| plane.map(finite)),
            normal: finder.vector(&NORMAL).or_else(|| finder.split_normal()),
            depth: finder.scalar(&DEPTH).map(|plane| plane.map(|d| real_depth(*d))),
            position: finder.vector(&POSITION),
            object: finder.ids(&OBJECT),
            material: finder.ids(&MATERIAL),
            albedo: finder.vector(&ALBEDO),
            channels: channels.collect(),
            lines: None,
            motion: finder.motion(),
        }
    }

    /// Every `step`th pixel, for surveys.
    pub(super) fn thinned(&self, step: usize) -> Self {
        Self {
            size: (self.size.0.div_ceil(step), self.size.1.div_ceil(step)),
            colour: self.colour.as_ref().map(|p| thin(p, step)),
            normal: self.normal.as_ref().map(|p| thin(p, step)),
            depth: self.depth.as_ref().map(|p| thin(p, step)),
            position: self.position.as_ref().map(|p| thin(p, step)),
            object: self.object.as_ref().map(|p| thin(p, step)),
            material: self.material.as_ref().map(|p| thin(p, step)),
            albedo: self.albedo.as_ref().map(|p| thin(p, step)),
            channels: self.channels.iter().map(|(c, p)| (*c, thin(p, step))).collect(),
            lines: None,
            motion: None,
        }
    }

    /// Where there is something: alpha, depth and normals agree on it as far as they are there.
    pub(super) fn covered(&self) -> Plane<bool> {
        let (w, h) = self.size;
        Plane::from_fn(w, h, |x, y| {
            let at = (x, y);
            self.colour.as_ref().is_none_or(|p| p[at][3] >= 0.5)
                && self.depth.as_ref().is_none_or(|p| p[at].is_finite())
                && self.position.as_ref().is_none_or(|p| p[at].iter().all(|v| v.is_finite()))
                && self.normal.as_ref().is_none_or(|p| is_direction(p[at]))
        })
    }
}

/// Normals from a picture of them: n = 2 c - 1. Black and middle grey are no direction.
pub(super) fn decode_normals(picture: &Plane<[f32; 4]>, y_up: bool) -> Plane<[f32; 3]> {
    picture.map(|&[r, g, b, a]| {
        let n = [r, g, b].map(|c| 2.0 * c - 1.0);
        let none = a < 0.5 || r.max(g).max(b) < 0.02 || !is_direction(n);
        if none { [0.0; 3] } else { [n[0], if y_up { n[1] } else { -n[1] }, n[2]] }
    })
}

fn is_direction(n: [f32; 3]) -> bool {
    let length = Vec3::from(n).length();
    length.is_finite() && length > 0.1
}

fn real_depth(d: f32) -> f32 {
    if d.is_finite() && d < NOTHING { d } else { f32::INFINITY }
}

fn finite(pixel: &[f32; 4]) -> [f32; 4] {
    pixel.map(|v| if v.is_finite() { v } else { 0.0 })
}

fn thin<T: Clone + Send + Sync>(plane: &Plane<T>, step: usize) -> Plane<T> {
    let (w, h) = plane.size();
    Plane::from_fn(w.div_ceil(step), h.div_ceil(step), |x, y| plane[(x * step, y * step)].clone())
}

/// Channels by their layer's last name and their own, in small letters.
struct Finder<'a> {
    named: Vec<(String, String, &'a ExrChannel)>,
}

impl<'a> Finder<'a> {
    fn new(image: &'a ExrImage) -> Self {
        let split = |(name, channel): &'a (String, ExrChannel)| {
            let name = name.to_lowercase().replace(' ', "");
            let (layer, own) = name.rsplit_once('.').unwrap_or(("", &name));
            let layer = layer.rsplit('.').next().unwrap_or_default();
            (layer.to_owned(), own.to_owned(), channel)
        };
        Self { named: image.layers.iter().map(split).collect() }
    }

    fn channel(&self, layer: &str, owns: &[&str]) -> Option<&'a ExrChannel> {
        let is = |(l, o, _): &&(String, String, _)| l == layer && owns.contains(&o.as_str());
        self.named.iter().find(is).map(|(_, _, channel)| *channel)
    }

    fn floats(&self, layer: &str, owns: &[&str]) -> Option<&'a Plane<f32>> {
        match self.channel(layer, owns)? {
            ExrChannel::F32(plane) => Some(plane),
            ExrChannel::U32(_) => None,
        }
    }

    fn vector(&self, layers: &[&str]) -> Option<Plane<[f32; 3]>> {
        layers.iter().find_map(|layer| {
            let x = self.floats(layer, &["x", "r"])?;
            let y = self.floats(layer, &["y", "g"])?;
            let z = self.floats(layer, &["z", "b"])?;
            Some(Plane::from_fn(x.width(), x.height(), |u, v| [x[(u, v)], y[(u, v)], z[(u, v)]]))
        })
    }

    fn motion(&self) -> Option<Motion> {
        let pair = |layer: &str, names: [&str; 2], sign: [f32; 2]| {
            let [x, y] = [self.floats(layer, &names[..1])?, self.floats(layer, &names[1..])?];
            let at = |u, v| [sign[0] * x[(u, v)], sign[1] * y[(u, v)]];
            Some(Plane::from_fn(x.width(), x.height(), at))
        };
        if let Some(back) = pair("motion", ["x", "y"], [1.0, 1.0]) {
            return Some(Motion { back, forth: None });
        }
        let back = pair("vector", ["x", "y"], [1.0, -1.0])?;
        Some(Motion { back, forth: pair("vector", ["z", "w"], [-1.0, 1.0]) })
    }

    /// `NX NY NZ`, as 3ds Max has them.
    fn split_normal(&self) -> Option<Plane<[f32; 3]>> {
        let [x, y, z] =
            [self.floats("", &["nx"])?, self.floats("", &["ny"])?, self.floats("", &["nz"])?];
        Some(Plane::from_fn(x.width(), x.height(), |u, v| [x[(u, v)], y[(u, v)], z[(u, v)]]))
    }

    fn scalar(&self, layers: &[&str]) -> Option<Plane<f32>> {
        let own = ["z", "a", "y", "v", "x", "r"];
        let layer = |name: &&str| own.iter().find_map(|o| self.floats(name, &[o]));
        let bare = |name: &&str| self.floats("", &[name]);
        layers.iter().find_map(bare).or_else(|| layers.iter().find_map(layer)).cloned()
    }

    /// The first of the layers that tells anything apart: indices that nobody set are all 0.
    fn ids(&self, layers: &[&str]) -> Option<Plane<u32>> {
        let plane = |layer: &&str| {
            Some(match self.channel(layer, &["id", "x", "r", "v"])? {
                ExrChannel::U32(plane) => plane.clone(),
                ExrChannel::F32(plane) if layer.starts_with("crypto") => plane.map(|v| v.to_bits()),
                ExrChannel::F32(plane) => plane.map(|v| v.round().max(0.0) as u32),
            })
        };
        let tells = |ids: &Plane<u32>| {
            let mut all = ids.pixels().iter().filter(|id| **id != 0);
            all.next().is_some_and(|first| all.any(|id| id != first))
        };
        let is_set = |ids: &Plane<u32>| ids.pixels().iter().any(|id| *id != 0);
        let found = || layers.iter().filter_map(plane);
        found().find(tells).or_else(|| found().find(is_set)).or_else(|| found().next())
    }
}
