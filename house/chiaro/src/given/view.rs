//! Layers to a view: the geometry buffer and the channels that a style mixes.

use super::camera;
use super::layers::Layers;
use chiaro_basis::math::Vec3;
use chiaro_binary::{BinaryKnobs, Channel, Channels, View};
use chiaro_image::{Plane, colour, statistics};
use chiaro_scene::{Pose, Projection};
use chiaro_trace::{GBuffer, Lamp, channel};

/// A view of what the layers show.
pub(super) fn view(layers: &Layers, knobs: &BinaryKnobs) -> View {
    let covered = layers.covered();
    let seen = Seen::new(layers, &covered);
    let mut buffer = GBuffer::empty(&seen.pose, seen.radius, layers.size);
    buffer.geometric_normal = facets(&seen.position, &covered, &seen.pose);
    buffer.normal = normals(layers, &seen, &buffer.geometric_normal, &covered);
    buffer.smooth_normal = buffer.normal.clone();
    buffer.depth = seen.position.map(|p| seen.pose.view(Vec3::from(*p)).z);
    buffer.position = seen.position;
    buffer.object = ids(layers.object.as_ref(), &covered);
    buffer.material = ids(layers.material.as_ref(), &covered);
    let white = || Plane::filled(layers.size.0, layers.size.1, [1.0; 3]);
    buffer.base_colour = layers.albedo.clone().unwrap_or_else(white);
    buffer.roughness = covered.map(|_| 0.5);
    buffer.covered = covered;
    let channels = channels(layers, &buffer, knobs);
    View { buffer, channels }
}

/// The camera, positions, and the object's radius.
struct Seen {
    pose: Pose,
    position: Plane<[f32; 3]>,
    radius: f32,
    /// Whether normals are in the world's axes, not the camera's.
    world: bool,
}

impl Seen {
    fn new(layers: &Layers, covered: &Plane<bool>) -> Self {
        match (&layers.position, &layers.depth) {
            (Some(position), Some(depth)) => match camera::fitted(position, depth, covered) {
                Some(pose) => Self::in_space(pose, position.clone(), covered),
                None => Self::flat(layers, Some(depth), covered),
            },
            (None, Some(depth)) if layers.normal.is_some() && !faces_viewer(layers, covered) => {
                Self::through_usual_lens(layers, depth, covered)
            }
            (_, depth) => Self::flat(layers, depth.as_ref(), covered),
        }
    }

    fn in_space(pose: Pose, position: Plane<[f32; 3]>, covered: &Plane<bool>) -> Self {
        let radius = half_diagonal(&position, covered);
        Self { pose, position, radius, world: true }
    }

    /// Depths of a 50 mm lens; the camera turned so that world normals meet the depths' own.
    fn through_usual_lens(layers: &Layers, depth: &Plane<f32>, covered: &Plane<bool>) -> Self {
        let lens = camera::usual_lens(layers.size);
        let axes = camera::axes(lens);
        let position = unprojected(&axes, depth, covered);
        let facets = facets(&position, covered, &axes);
        let given = layers.normal.as_ref().expect("asked for before");
        let pairs = facets.pixels().iter().zip(given.pixels()).zip(covered.pixels());
        let pairs = pairs
            .filter(|(_, c)| **c)
            .map(|((seen, given), _)| (Vec3::from(*given).normalize_or_zero(), Vec3::from(*seen)));
        let pose = camera::turned(pairs, lens);
        let position = unprojected(&pose, depth, covered);
        Self::in_space(pose, position, covered)
    }

    /// Seen in parallel: pixels are units, depth is scaled to half the covered box's diagonal.
    fn flat(layers: &Layers, depth: Option<&Plane<f32>>, covered: &Plane<bool>) -> Self {
        let (w, h) = layers.size;
        let mut pose = camera::axes(Projection::Orthographic { half_height: 0.5 * h as f32 });
        let centre =
            |x: usize, y: usize| [x as f32 + 0.5 - 0.5 * w as f32, 0.5 * h as f32 - y as f32 - 0.5];
        let across = Plane::from_fn(w, h, |x, y| {
            let [u, v] = centre(x, y);
            [u, v, 0.0]
        });
        let radius = half_diagonal(&across, covered);
        let range = depth.and_then(|d| {
            let at = |p| statistics::percentile(d, covered, p);
            let (near, far) = (at(0.0)?, at(100.0)?);
            (far > near).then_some((d, near, radius / (far - near)))
        });
        pose.position = Vec3::new(0.0, 0.0, radius);
        let position = match range {
            Some((d, near, scale)) => Plane::from_fn(w, h, |x, y| {
                let [u, v] = centre(x, y);
                [u, v, if covered[(x, y)] { (near - d[(x, y)]) * scale } else { 0.0 }]
            }),
            None => across,
        };
        Self { pose, position, radius, world: false }
    }
}

/// Whether nearly all normals look at the viewer along z: then they are in the camera's axes.
fn faces_viewer(layers: &Layers, covered: &Plane<bool>) -> bool {
    let Some(normal) = &layers.normal else { return true };
    let pairs = || normal.pixels().iter().zip(covered.pixels()).filter(|(_, c)| **c);
    let all = pairs().count();
    let facing = pairs().filter(|(n, _)| n[2] > -0.05).count();
    facing as f64 >= 0.98 * all as f64
}

fn unprojected(pose: &Pose, depth: &Plane<f32>, covered: &Plane<bool>) -> Plane<[f32; 3]> {
    let (w, h) = depth.size();
    Plane::from_fn(w, h, |x, y| {
        if !covered[(x, y)] {
            return [0.0; 3];
        }
        let (o, d) = pose.ray(x as f32 + 0.5, y as f32 + 0.5, w as f32, h as f32);
        (o + d * (depth[(x, y)] / d.dot(pose.forward))).to_array()
    })
}

/// Half the diagonal of the box around the covered positions.
fn half_diagonal(position: &Plane<[f32; 3]>, covered: &Plane<bool>) -> f32 {
    let seen = position.pixels().iter().zip(covered.pixels()).filter(|(_, c)| **c);
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) =
        seen.fold(start, |(low, high), (p, _)| (low.min(Vec3::from(*p)), high.max(Vec3::from(*p))));
    let half = 0.5 * (high - low).length();
    if half.is_finite() && half > 0.0 { half } else { 1.0 }
}

/// Unit normals of the surface through the positions: on each axis the neighbour that is nearer
/// belongs to the same surface.
fn facets(position: &Plane<[f32; 3]>, covered: &Plane<bool>, pose: &Pose) -> Plane<[f32; 3]> {
    let (w, h) = position.size();
    let at = |x: isize, y: isize| {
        (covered.at(x, y) == Some(&true)).then(|| Vec3::from(position[(x as usize, y as usize)]))
    };
    Plane::from_fn(w, h, |x, y| {
        let (x, y) = (x as isize, y as isize);
        let Some(p) = at(x, y) else { return [0.0; 3] };
        let along = |dx: isize, dy: isize| {
            let steps = [at(x + dx, y + dy).map(|q| q - p), at(x - dx, y - dy).map(|q| p - q)];
            let shortest = |a: &Vec3, b: &Vec3| a.length_squared().total_cmp(&b.length_squared());
            steps.into_iter().flatten().min_by(shortest).unwrap_or_default()
        };
        let normal = along(0, -1).cross(along(1, 0)).try_normalize();
        // Right times up looks away from the viewer in their order here.
        let normal = normal.map_or(-pose.forward, |n| -n);
        let away = normal.dot(pose.forward) > 0.0;
        (if away { -normal } else { normal }).to_array()
    })
}

/// The given normals in the axes of the view, or those of the positions.
fn normals(
    layers: &Layers,
    seen: &Seen,
    facets: &Plane<[f32; 3]>,
    covered: &Plane<bool>,
) -> Plane<[f32; 3]> {
    let Some(given) = &layers.normal else { return facets.clone() };
    let pose = &seen.pose;
    let camera_axes = seen.world && faces_viewer(layers, covered) && !agrees(given, facets);
    given.map(|n| {
        let n = Vec3::from(*n).normalize_or_zero();
        let turned = pose.right * n.x + pose.up * n.y - pose.forward * n.z;
        (if camera_axes { turned } else { n }).to_array()
    })
}

/// Whether normals are mostly the facets' own.
fn agrees(given: &Plane<[f32; 3]>, facets: &Plane<[f32; 3]>) -> bool {
    let dots = given
        .pixels()
        .iter()
        .zip(facets.pixels())
        .map(|(a, b)| f64::from(Vec3::from(*a).normalize_or_zero().dot(Vec3::from(*b))));
    let (mut sum, mut count) = (0.0, 0);
    for dot in dots.filter(|d| *d != 0.0) {
        sum += dot;
        count += 1;
    }
    sum > 0.7 * f64::from(count)
}

fn ids(plane: Option<&Plane<u32>>, covered: &Plane<bool>) -> Plane<u32> {
    match plane {
        Some(plane) => plane.zip(covered, |id, c| if *c { *id } else { 0 }).expect("one size"),
        None => covered.map(|c| u32::from(*c)),
    }
}

/// What the picture brings, and else: its own light for what is lit, the key light for what is lit
/// without shadow, the mean of both for what is half lit, the head lamp from the normals.
fn channels(layers: &Layers, buffer: &GBuffer, knobs: &BinaryKnobs) -> Channels {
    let mut channels = Channels::default();
    channels.reach = 1.0;
    for (kind, plane) in &layers.channels {
        channels.set(*kind, plane.clone());
    }
    let key = Lamp::key(&buffer.pose);
    let diffuse = buffer.over_covered(|x, y| {
        let n = Vec3::from(buffer.normal[(x, y)]);
        (-key.direction).dot(n).clamp(0.0, 1.0)
    });
    let beauty = layers.colour.as_ref().map(|plane| {
        plane.map(|c| {
            let light = colour::luminance([c[0], c[1], c[2]]) / c[3].max(1e-3);
            colour::srgb_encode(light.clamp(0.0, 1.0))
        })
    });
    let lit = beauty.clone().unwrap_or_else(|| diffuse.clone());
    // Half the picture's own light, half a light that shows the relief of the normals.
    let shaped = layers.normal.is_some() || layers.depth.is_some();
    let half = match (&beauty, shaped) {
        (Some(light), true) => light.zip(&diffuse, |a, b| 0.5 * (a + b)).expect("one size"),
        _ => lit.clone(),
    };
    let mut otherwise = |kind: Channel, plane: &dyn Fn() -> Plane<f32>| {
        if channels.get(kind).is_none() && kind.is_used(knobs) {
            channels.set(kind, plane());
        }
    };
    otherwise(Channel::Half, &|| half.clone());
    otherwise(Channel::Lit, &|| lit.clone());
    otherwise(Channel::Diffuse, &|| diffuse.clone());
    otherwise(Channel::Luminance, &|| beauty.clone().unwrap_or_else(|| channel::luminance(buffer)));
    if layers.normal.is_some() || layers.depth.is_some() {
        otherwise(Channel::Headlamp, &|| channel::headlamp(buffer));
        let gloss = (knobs.gloss > 0.0).then_some(knobs.gloss);
        otherwise(Channel::Specular, &|| channel::specular(buffer, &[key], gloss, None));
    }
    channels
}
