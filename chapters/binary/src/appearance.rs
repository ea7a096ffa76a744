//! Appearance (section 3.5.1): the channels that a style mixes, and no others.

use crate::knob::{BinaryKnobs, Model};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_trace::channel::{self, Diffuse};
use chiaro_trace::{GBuffer, Lamps, Surfaces, Tracer, ambient_occlusion};

/// One appearance channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Diffuse light, half of it in shadow too.
    Half,
    /// Diffuse light with shadow.
    Lit,
    /// Diffuse light without shadow.
    Diffuse,
    /// n.v.
    Headlamp,
    /// Ambient occlusion.
    Occlusion,
    /// Beckmann highlights.
    Specular,
    /// Mirrored surroundings.
    Reflection,
    /// Base colour.
    Luminance,
    /// Light that surfaces send each other. It is not rendered here: who knows of it puts it in.
    Indirect,
}

impl Channel {
    /// All channels, in the order of [`Channels`].
    pub const ALL: [Self; 9] = [
        Self::Half,
        Self::Lit,
        Self::Diffuse,
        Self::Headlamp,
        Self::Occlusion,
        Self::Specular,
        Self::Reflection,
        Self::Luminance,
        Self::Indirect,
    ];

    /// The name, as in the knobs and in EXR layers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Half => "half",
            Self::Lit => "lit",
            Self::Diffuse => "diffuse",
            Self::Headlamp => "headlamp",
            Self::Occlusion => "occlusion",
            Self::Specular => "specular",
            Self::Reflection => "reflection",
            Self::Luminance => "luminance",
            Self::Indirect => "indirect",
        }
    }

    /// Whether it is made of diffuse light or of its shadows.
    fn needs_light(self) -> bool {
        matches!(self, Self::Half | Self::Lit | Self::Diffuse | Self::Specular)
    }

    /// Its share in the tone.
    pub fn share(self, knobs: &BinaryKnobs) -> f32 {
        match self {
            Self::Half => knobs.half,
            Self::Lit => knobs.lit,
            Self::Diffuse => knobs.diffuse,
            Self::Headlamp => knobs.headlamp,
            Self::Occlusion => knobs.occlusion,
            Self::Specular => knobs.specular,
            Self::Reflection => knobs.reflection,
            Self::Luminance => knobs.luminance,
            Self::Indirect => knobs.indirect,
        }
    }

    /// Its weights in the thesis's model: w, b, g and h; `None` for channels outside the thesis.
    pub fn thesis(self, k: &BinaryKnobs) -> Option<[f32; 4]> {
        match self {
            Self::Diffuse => Some([k.diffuse_w, k.diffuse_b, k.diffuse_g, k.diffuse_h]),
            Self::Headlamp => Some([k.headlamp_w, k.headlamp_b, k.headlamp_g, k.headlamp_h]),
            Self::Specular => Some([k.specular_w, k.specular_b, k.specular_g, k.specular_h]),
            Self::Occlusion => Some([k.occlusion_w, k.occlusion_b, k.occlusion_g, k.occlusion_h]),
            _ => None,
        }
    }

    /// Whether the knobs give it any influence.
    pub fn is_used(self, knobs: &BinaryKnobs) -> bool {
        match knobs.model {
            Model::Tone => self.share(knobs) > 0.0,
            Model::Thesis => self.thesis(knobs).is_some_and(|[w, b, ..]| w > 0.0 || b > 0.0),
        }
    }
}

/// Channels of one picture; those that were not asked for are `None`.
#[derive(Clone, Debug, Default)]
pub struct Channels {
    planes: [Option<Plane<f32>>; 9],
    /// The share of light that shadow rays let through; 1 where none were cast.
    pub reach: f32,
}

impl Channels {
    /// Renders the channels for which `wanted` holds, indirect light left out. With `shadows` off,
    /// nothing casts any.
    pub fn render(
        scene: &Lit<'_>,
        wanted: impl Fn(Channel) -> bool,
        knobs: &BinaryKnobs,
        shadows: bool,
        run: &Run,
    ) -> Result<Self> {
        let light = Light::render(scene, &wanted, shadows, run)?;
        let mut channels = Self { reach: light.reach(), ..Self::default() };
        // What needs the light comes first, so that large pictures need not hold it to the end.
        let (lit, others): (Vec<Channel>, Vec<Channel>) =
            Channel::ALL.into_iter().filter(|c| wanted(*c)).partition(|c| c.needs_light());
        for channel in lit {
            channels.planes[channel as usize] = scene.plane(channel, &light, knobs, run)?;
        }
        drop(light);
        for channel in others {
            channels.planes[channel as usize] = scene.plane(channel, &Light::None, knobs, run)?;
        }
        Ok(channels)
    }

    /// One channel.
    pub fn get(&self, channel: Channel) -> Option<&Plane<f32>> {
        self.planes[channel as usize].as_ref()
    }

    /// Puts a plane in a channel's place, for pictures made elsewhere.
    pub fn set(&mut self, channel: Channel, plane: Plane<f32>) {
        self.planes[channel as usize] = Some(plane);
    }

    /// A set of one channel, for tests and for pictures made elsewhere.
    pub fn single(channel: Channel, plane: Plane<f32>) -> Self {
        let mut channels = Self { reach: 1.0, ..Self::default() };
        channels.planes[channel as usize] = Some(plane);
        channels
    }
}

/// A scene in front of a camera, with its light.
#[derive(Clone, Copy)]
pub struct Lit<'a> {
    /// Rays into it.
    pub tracer: &'a Tracer<'a>,
    /// Its textures.
    pub surfaces: &'a Surfaces<'a>,
    /// What the camera sees.
    pub buffer: &'a GBuffer,
    /// Its lamps; at least one.
    pub lamps: &'a Lamps,
}

/// Diffuse light, if any channel needs it.
enum Light {
    None,
    Plain(Plane<f32>),
    Shadowed(Diffuse),
}

impl Light {
    fn render(
        scene: &Lit<'_>,
        wanted: &impl Fn(Channel) -> bool,
        shadows: bool,
        run: &Run,
    ) -> Result<Self> {
        let any_shadow = [Channel::Half, Channel::Lit].into_iter().any(wanted);
        if shadows && any_shadow {
            let light = channel::diffuse(scene.tracer, scene.buffer, scene.lamps, true, run)?;
            Ok(Self::Shadowed(light))
        } else if any_shadow || wanted(Channel::Diffuse) {
            let light = channel::diffuse(scene.tracer, scene.buffer, scene.lamps, false, run)?;
            Ok(Self::Plain(light.plain))
        } else {
            Ok(Self::None)
        }
    }

    fn reach(&self) -> f32 {
        match self {
            Self::Shadowed(light) => light.reach,
            _ => 1.0,
        }
    }

    /// The unshadowed light times `floor` plus the shadowed light times the rest.
    fn blend(&self, floor: f32) -> Plane<f32> {
        match self {
            Self::None => Plane::default(),
            Self::Plain(plain) => plain.clone(),
            Self::Shadowed(light) => light
                .plain
                .zip(&light.shadowed, |p, s| p * floor + s * (1.0 - floor))
                .expect("both have the picture's size"),
        }
    }
}

impl Lit<'_> {
    fn plane(
        &self,
        channel: Channel,
        light: &Light,
        knobs: &BinaryKnobs,
        run: &Run,
    ) -> Result<Option<Plane<f32>>> {
        let buffer = self.buffer;
        Ok(Some(match channel {
            Channel::Half => light.blend(0.5),
            Channel::Lit => light.blend(0.0),
            Channel::Diffuse => light.blend(1.0),
            Channel::Headlamp => channel::headlamp(buffer),
            Channel::Occlusion => {
                let radius = knobs.occlusion_radius * buffer.radius;
                ambient_occlusion(self.tracer, buffer, radius, knobs.occlusion_rays as usize, run)?
            }
            Channel::Specular => {
                let roughness = (knobs.gloss > 0.0).then_some(knobs.gloss);
                let shadow = match light {
                    Light::Shadowed(d) => Some(d),
                    _ => None,
                };
                channel::specular(buffer, self.lamps.all(), roughness, shadow)
            }
            Channel::Reflection => channel::reflection(self.tracer, self.surfaces, buffer, run)?,
            Channel::Luminance => channel::luminance(buffer),
            Channel::Indirect => return Ok(None),
        }))
    }
}
