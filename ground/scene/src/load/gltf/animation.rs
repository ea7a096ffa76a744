//! Animations: clips of tracks that move nodes and morph weights.
//!
//! Keys whose time falls back, or that are not finite, are dropped; channels without a node, or
//! whose data is broken, are left out with a note.

use super::accessor::{Accessor, Accessors, named};
use super::context::{Context, Place};
use super::json::Value;
use super::primitive::survive;
use super::tree::Tree;
use crate::{Channel, Clip, Interpolation, Node, Property, Track, Transform};
use chiaro_basis::Result;
use chiaro_basis::math::Quat;

/// All clips, as many as the document has animations. Nodes with a matrix that tracks move get it
/// taken apart.
pub(super) fn read(
    root: &Value,
    tree: &Tree,
    accessors: &Accessors,
    nodes: &mut [Node],
    cx: &mut Context,
) -> Result<Vec<Clip>> {
    let mut clips = Vec::new();
    for (i, item) in root.list("animations").iter().enumerate() {
        let mut clip = Clip { name: item.name(), channels: Vec::new() };
        for (k, channel) in item.list("channels").iter().enumerate() {
            let place = Place::new("animation", i).part("channel", k);
            let Some((node, property)) = target(channel, tree, place, cx) else { continue };
            let node = tree.id(node);
            let width = match property {
                Property::Rotation => 4,
                Property::Weights => nodes[node.index()].weights.len(),
                Property::Translation | Property::Scale => 3,
            };
            let Some(track) = track(item, channel, property, width, place, accessors, cx)? else {
                continue;
            };
            if property != Property::Weights {
                take_apart(&mut nodes[node.index()].transform);
            }
            clip.channels.push(Channel { node, property, track });
        }
        clips.push(clip);
    }
    Ok(clips)
}

/// The document's node and its property that a channel moves.
fn target(
    channel: &Value,
    tree: &Tree,
    place: Place,
    cx: &mut Context,
) -> Option<(usize, Property)> {
    let target = channel.get("target");
    let property = match target.text("path") {
        Some("translation") => Property::Translation,
        Some("rotation") => Property::Rotation,
        Some("scale") => Property::Scale,
        Some("weights") => Property::Weights,
        Some("pointer") => {
            cx.note(place, "KHR_animation_pointer is not supported; what it moves stands still");
            return None;
        }
        _ => {
            cx.note(place, "it moves nothing known and is left out");
            return None;
        }
    };
    match target.index("node", tree.items.len()) {
        // A target without a node is for extensions.
        Ok(node) => node.map(|n| (n, property)),
        Err(why) => {
            cx.note(place, format!("{why}; it is left out"));
            None
        }
    }
}

/// The track of a channel, `width` numbers a value; `None` where there is none.
fn track(
    animation: &Value,
    channel: &Value,
    property: Property,
    width: usize,
    place: Place,
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Option<Track>> {
    let samplers = animation.list("samplers");
    let sampler = match channel.get("sampler").as_index("sampler", samplers.len()) {
        Ok(index) => &samplers[index],
        Err(why) => {
            cx.note(place, format!("{why}; it is left out"));
            return Ok(None);
        }
    };
    let interpolation = match sampler.text("interpolation") {
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        _ => Interpolation::Linear,
    };
    let mut column = |key: &str| -> Result<Option<(Accessor, Vec<f32>)>> {
        let accessor = named(sampler, key, place, accessors, cx);
        let Some(accessor) = survive(accessor, key, place, cx)?.flatten() else { return Ok(None) };
        let numbers = accessor.flat(cx)?;
        Ok(Some((accessor, numbers)))
    };
    let (input, output) = (column("input")?, column("output")?);
    let (Some((_, times)), Some((accessor, values))) = (input, output) else {
        cx.note(place, "it has no keys and is left out");
        return Ok(None);
    };
    let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let stored = if property == Property::Weights {
        // Weights come one a target and key; how many is known from the keys alone.
        values.len() / (times.len() * parts).max(1)
    } else {
        accessor.width()
    };
    let fits = property == Property::Weights || stored == width;
    if width == 0 || stored == 0 || !fits {
        cx.note(place, "its values do not fit what it moves, and it is left out");
        return Ok(None);
    }
    let raw = Raw { times, values, stored, parts };
    let mut track = raw.track(width, interpolation, place, cx)?;
    if property == Property::Rotation && parts == 1 {
        track.values.chunks_exact_mut(4).for_each(normalize);
    }
    Ok((!track.times.is_empty()).then_some(track))
}

/// Keys as stored: `stored` numbers a value, `parts` values a key.
struct Raw {
    times: Vec<f32>,
    values: Vec<f32>,
    stored: usize,
    parts: usize,
}

impl Raw {
    /// The sound keys, with values of `width` numbers: cut off, or filled with zeros.
    fn track(
        &self,
        width: usize,
        interpolation: Interpolation,
        place: Place,
        cx: &mut Context,
    ) -> Result<Track> {
        let keys = self.times.len();
        cx.hold::<f32>(place, keys.saturating_mul(1 + width * self.parts))?;
        let mut track = Track { times: Vec::new(), values: Vec::new(), width, interpolation };
        for (time, key) in self.times.iter().zip(self.values.chunks_exact(self.stored * self.parts))
        {
            let rises = track.times.last().is_none_or(|last| last <= time);
            if !(time.is_finite() && rises && key.iter().all(|v| v.is_finite())) {
                continue;
            }
            track.times.push(*time);
            for value in key.chunks_exact(self.stored) {
                let filled = value.iter().copied().chain(std::iter::repeat(0.0));
                track.values.extend(filled.take(width));
            }
        }
        if track.times.len() < keys {
            let gone = keys - track.times.len();
            cx.note(
                place,
                format!("{gone} of its keys are out of order, not finite or without value"),
            );
        }
        Ok(track)
    }
}

fn normalize(q: &mut [f32]) {
    let unit = Quat::from_slice(q);
    let length = unit.length();
    let unit = if length > 1e-12 && length.is_finite() { unit / length } else { Quat::IDENTITY };
    q.copy_from_slice(&unit.to_array());
}

/// Makes a matrix translation, rotation and scale, which tracks can move.
fn take_apart(transform: &mut Transform) {
    if let Transform::Matrix(m) = *transform {
        let (scale, rotation, translation) = m.to_scale_rotation_translation();
        if scale.is_finite() && rotation.is_finite() {
            *transform = Transform::Parts { translation, rotation, scale };
        }
    }
}
