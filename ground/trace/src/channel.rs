//! Appearance channels (thesis, section 3.5.1): what the light does, as numbers in [0, 1].
//!
//! | channel | value |
//! |---|---|
//! | [`diffuse`] | Lambert's cosine, with or without shadow |
//! | [`specular`] | Beckmann's lobe, 1 at its peak |
//! | [`headlamp`] | n.v, darkest on the silhouette |
//! | [`reflection`] | the mirror image of a studio: bright above, dark below, the scene between |
//! | [`luminance`] | the base colour's lightness |
//!
//! Ambient occlusion has a file of its own. A pixel without geometry is 0 in every channel.

use crate::gbuffer::GBuffer;
use crate::lamps::Lamps;
use crate::light::{Arrival, Lamp};
use crate::panels::Panels;
use crate::penumbra::Penumbra;
use crate::shadow::Shadows;
use crate::surface::Surfaces;
use crate::tracer::{Ray, Sides, Tracer};
use chiaro_basis::math::{Vec3, smoothstep};
use chiaro_basis::{Result, Run};
use chiaro_image::{Plane, colour};

/// Light on every pixel, with and without shadow.
#[derive(Clone, Debug)]
pub struct Diffuse {
    /// Lambert's cosine, nothing being in the way.
    pub plain: Plane<f32>,
    /// The same where the lamp is seen, 0 where something is in the way.
    pub shadowed: Plane<f32>,
    /// The share of light that faces lamps and that reaches the surface; 1 when none faces them.
    pub reach: f32,
}

/// The diffuse channel. One parallel lamp gives the cosine itself; other lamps are summed by their
/// illuminance and tone-mapped by E / (E + median E), so that any wattage ends in [0, 1].
///
/// Without `shadows` no ray is cast, and both planes are the same. In large pictures rays are cast at
/// some of the pixels and wherever those differ.
pub fn diffuse(
    tracer: &Tracer,
    buffer: &GBuffer,
    lamps: &Lamps,
    shadows: bool,
    run: &Run,
) -> Result<Diffuse> {
    let shaded = match shadows {
        true => Some(Shadows::sample(tracer, buffer, lamps, run)?),
        false => None,
    };
    let panels = Panels::of(lamps.all());
    let penumbra = match &shaded {
        Some(shadows) if !panels.is_empty() => {
            Some(Penumbra::sample(buffer, &panels, shadows, shadows.step(), run)?)
        }
        _ => None,
    };
    let shade = shaded.as_ref().map(|s| (s, penumbra.as_ref()));
    let sums = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return [0.0; 2];
        }
        illuminance(buffer, (lamps, &panels), shade, (x, y))
    });
    run.check()?;
    let middle = match lamps.all() {
        [lamp] if lamp.kind == chiaro_scene::LightKind::Directional => None,
        _ => Some(median_of_lit(&sums, &buffer.covered)),
    };
    let strength = lamps.all().first().map_or(1.0, |l| l.strength);
    let tone = |e: f32| match middle {
        None => (e / strength).clamp(0.0, 1.0),
        Some(m) => e / (e + m),
    };
    Ok(Diffuse {
        plain: sums.map(|e| tone(e[0])),
        shadowed: sums.map(|e| tone(e[1])),
        reach: share_that_arrives(&sums),
    })
}

/// Illuminance without and with shadow, lux.
fn illuminance(
    buffer: &GBuffer,
    (lamps, panels): (&Lamps, &Panels),
    shade: Option<(&Shadows<'_>, Option<&Penumbra<'_>>)>,
    pixel: (usize, usize),
) -> [f32; 2] {
    let position = Vec3::from(buffer.position[pixel]);
    let normal = Vec3::from(buffer.normal[pixel]);
    // A surface that shines is as bright as a white one under pi times its radiance.
    let own = match lamps.glow().is_empty() {
        false => std::f32::consts::PI * colour::luminance(buffer.emissive[pixel]),
        true => 0.0,
    };
    let around = shade.map(|(shadows, _)| shadows.around(pixel));
    let arrives = |k: usize| !around.as_ref().is_some_and(|a| a.is_dark(k, position));
    let mut sum = [own; 2];
    let single = lamps.single().iter().enumerate();
    for (k, lamp) in single.filter(|(_, l)| l.is_before(position, normal)) {
        let Some(arrival) = lamp.arrival(position) else { continue };
        let e = arrival.strength * normal.dot(arrival.towards).max(0.0);
        if e > 0.0 {
            sum = [sum[0] + e, if arrives(k) { sum[1] + e } else { sum[1] }];
        }
    }
    let mut glow = [0.0; 2];
    let share = match shade {
        Some((_, penumbra)) => penumbra.and_then(|p| p.share(pixel)),
        None => Some(1.0),
    };
    match share {
        Some(share) => {
            panels.light(position, normal, |_, e| glow[0] += e);
            glow[1] = share * glow[0];
        }
        None => panels.light(position, normal, |k, e| {
            glow = [glow[0] + e, if arrives(k) { glow[1] + e } else { glow[1] }];
        }),
    }
    if let Some((open, share)) = lamps.beside(position, normal).filter(|_| glow[0] > 0.0) {
        let scale = 1.0 + share * (open / glow[0] - 1.0);
        glow = glow.map(|e| e * scale);
    }
    [sum[0] + glow[0], sum[1] + glow[1]]
}

/// The median over pixels that any lamp lights; 1 when there is none.
fn median_of_lit(sums: &Plane<[f32; 2]>, covered: &Plane<bool>) -> f32 {
    let lit = sums.pixels().iter().zip(covered.pixels()).filter(|(e, c)| **c && e[0] > 0.0);
    let mut values: Vec<f32> = lit.map(|(e, _)| e[0]).collect();
    if values.is_empty() {
        return 1.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

fn share_that_arrives(sums: &Plane<[f32; 2]>) -> f32 {
    let facing = sums.pixels().iter().filter(|e| e[0] > 0.0).count();
    let lit = sums.pixels().iter().filter(|e| e[1] > 0.0).count();
    if facing == 0 { 1.0 } else { lit as f32 / facing as f32 }
}

/// The specular channel: Beckmann's distribution of half vectors relative to its peak,
/// exp(-tan^2 / m^2) / cos^4, with m the square of `roughness` (the material's where `None`).
pub fn specular(
    buffer: &GBuffer,
    lamps: &[Lamp],
    roughness: Option<f32>,
    shadow: Option<&Diffuse>,
) -> Plane<f32> {
    buffer.over_covered(|x, y| {
        let position = Vec3::from(buffer.position[(x, y)]);
        let normal = Vec3::from(buffer.normal[(x, y)]);
        let eye = buffer.to_eye(position);
        let rough = roughness.unwrap_or(buffer.roughness[(x, y)]).clamp(0.15, 1.0);
        let seen = shadow.is_none_or(|d| d.shadowed[(x, y)] > 0.0);
        let lobe = |a: Arrival| match normal.dot(a.towards) > 0.0 && seen {
            true => beckmann(normal.dot((a.towards + eye).normalize_or(normal)), rough * rough),
            false => 0.0,
        };
        lamps.iter().filter_map(|l| l.arrival(position)).map(lobe).fold(0.0, f32::max)
    })
}

/// Beckmann's lobe relative to its peak, for the cosine between normal and half vector.
fn beckmann(cos: f32, m: f32) -> f32 {
    if cos <= 0.0 {
        return 0.0;
    }
    let cos2 = cos * cos;
    let tan2 = (1.0 - cos2).max(0.0) / cos2;
    ((-tan2 / (m * m)).exp() / (cos2 * cos2)).min(1.0)
}

/// The head-lamp channel: the cosine between normal and direction to the eye.
pub fn headlamp(buffer: &GBuffer) -> Plane<f32> {
    buffer.over_covered(|x, y| {
        let eye = buffer.to_eye(Vec3::from(buffer.position[(x, y)]));
        eye.dot(Vec3::from(buffer.normal[(x, y)])).clamp(0.0, 1.0)
    })
}

/// The luminance channel: sRGB-encoded luminance of base colour and emission.
pub fn luminance(buffer: &GBuffer) -> Plane<f32> {
    buffer.over_covered(|x, y| {
        let (c, e) = (buffer.base_colour[(x, y)], buffer.emissive[(x, y)]);
        let sum = std::array::from_fn(|i| c[i] + e[i]);
        colour::srgb_encode(colour::luminance(sum).clamp(0.0, 1.0))
    })
}

/// The reflection channel: what a mirror in the surface's place would show of a studio whose
/// softbox hangs above, whose floor is dark, and in which the scene itself stands, lit by a head
/// lamp.
pub fn reflection(
    tracer: &Tracer,
    surfaces: &Surfaces,
    buffer: &GBuffer,
    run: &Run,
) -> Result<Plane<f32>> {
    let plane = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return 0.0;
        }
        let position = Vec3::from(buffer.position[(x, y)]);
        let normal = Vec3::from(buffer.normal[(x, y)]);
        let eye = buffer.to_eye(position);
        let direction = (normal * (2.0 * normal.dot(eye)) - eye).normalize_or(normal);
        let side = Vec3::from(buffer.geometric_normal[(x, y)]);
        let origin = position + side * tracer.offset();
        let ray = Ray { origin, direction, t_max: f32::INFINITY };
        match tracer.hit(&ray, Sides::Both) {
            Some(hit) => {
                let seen = surfaces.at(tracer, &hit, direction, 0.0);
                0.5 * seen.normal.dot(-direction).clamp(0.0, 1.0)
            }
            None => studio(direction),
        }
    });
    run.check()?;
    Ok(plane)
}

/// The studio's luminance in a direction: a floor, a horizon, a softbox.
fn studio(direction: Vec3) -> f32 {
    let height = direction.y;
    0.1 + 0.35 * smoothstep([-0.1, 0.1], height) + 0.55 * smoothstep([0.45, 0.6], height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beckmann_peaks_at_one_and_narrows_with_smoothness() {
        assert_eq!(beckmann(1.0, 0.3), 1.0);
        assert!(beckmann(0.95, 0.1) < beckmann(0.95, 0.4));
        assert_eq!(beckmann(-0.2, 0.4), 0.0);
    }
}
