//! `--check path`: how far a picture is from the path-traced truth; `--check exact`: from that of
//! the same tree before it was coded.

use super::shot::Shot;
use chiaro_basis::{Result, Run};
use chiaro_image::colour::srgb_encode;
use chiaro_image::tone::Tone;
use chiaro_image::{Plane, metric};
use chiaro_pbgi::LightKnobs;
use chiaro_pbgi::resolve::{Irradiance, Seen, centre};
use chiaro_pbgi::surfel::Lit;
use chiaro_trace::GBuffer;
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use serde_json::{Map, Value, json};

/// Paths a pixel of the reference, at most, and in a batch.
const MOST_SAMPLES: u32 = 8192;
const BATCH: u32 = 64;
/// The reference's own error over the error that is measured, at most.
const SURE: f64 = 0.4;

/// Errors of irradiance at pixel centres against a path-traced reference, which goes on until its own error is two
/// fifths of what is measured; a warning where it does not get there. The relative error is
/// without the reference's own, whose mean square is known from the spread of its batches and is taken away.
pub(super) fn against_paths(
    shot: &Shot,
    lit: &Lit,
    buffer: &GBuffer,
    irradiance: &Irradiance,
    knobs: &LightKnobs,
    run: &Run,
) -> Result<Map<String, Value>> {
    let (width, height) = buffer.size();
    let own = Plane::from_fn(width, height, |x, y| centre(lit, buffer, irradiance, (x, y)));
    let paths = PathTracer {
        tracer: lit.tracer,
        surfaces: lit.surfaces,
        lights: lit.lights,
        bounces: knobs.bounces,
        glossy: knobs.glossy,
    };
    let mut reference = PathImage::new(width, height);
    let (error, reference_error) = loop {
        run.stage("check", (width * height) as u64, || {
            paths.add(&mut reference, &buffer.pose, BATCH, Aim::Centre, run)
        })?;
        let indirect = own.map(|s| s.indirect);
        let both = metric::rmse_relative(&indirect, &reference.indirect(), &buffer.covered)?;
        let sure = reference.relative_error(&buffer.covered);
        let error = both.map(|b| (b * b - sure.map_or(0.0, |s| s * s)).max(0.0).sqrt());
        let enough = match (error, sure) {
            (Some(e), Some(s)) => s <= SURE * e,
            (None, _) => reference.samples() >= 2 * BATCH,
            _ => false,
        };
        if enough || reference.samples() + BATCH > MOST_SAMPLES {
            break (error, sure);
        }
    };
    if let (Some(e), Some(own)) = (error, reference_error)
        && own > SURE * e
    {
        run.warn(format!(
            "after {MOST_SAMPLES} paths a pixel, the most there are, reference_error {own:.4} is still over two fifths \
             of rmse_relative {e:.4}, from which it is taken away; the error is known less surely"
        ));
    }
    let (direct, indirect) = (reference.direct(), reference.indirect());
    let specular = reference.specular();
    let truth = Plane::from_fn(width, height, |x, y| Seen {
        direct: direct[(x, y)],
        indirect: indirect[(x, y)],
        specular: specular[(x, y)],
        ..own[(x, y)]
    });
    let shown = |p: &Plane<Seen>| displayed(p, shot.exposure, knobs.tone);
    let (a, b) = (shown(&own), shown(&truth));
    let mut counts = Map::new();
    counts.insert("psnr_db".into(), json!(metric::psnr_db(&a, &b)?));
    counts.insert("flip".into(), json!(metric::flip(&b, &a)?));
    counts.insert("rmse_relative".into(), json!(error));
    if knobs.glossy {
        let shining = own.map(|s| s.specular);
        let apart = metric::rmse_relative(&shining, &specular, &buffer.covered)?;
        counts.insert("specular_rmse_relative".into(), json!(apart));
    }
    counts.insert("reference_error".into(), json!(reference_error));
    counts.insert("reference_samples".into(), json!(reference.samples()));
    Ok(counts)
}

/// Differences of the displayed pictures of a coded tree and of the same tree as it was.
pub(super) fn against_exact(
    shot: &Shot,
    coded: &Plane<Seen>,
    exact: &Plane<Seen>,
    knobs: &LightKnobs,
) -> Result<Map<String, Value>> {
    let shown = |p: &Plane<Seen>| displayed(p, shot.exposure, knobs.tone);
    let (a, b) = (shown(coded), shown(exact));
    let grey = |p: &Plane<Seen>| p.map(|s| s.indirect);
    let covered = exact.map(|s| s.coverage > 0.0);
    let mut counts = Map::new();
    for (name, value) in [
        ("psnr_db", json!(metric::psnr_db(&a, &b)?)),
        ("different_pixels", json!(metric::different_pixels(&a, &b)?)),
        ("flip", json!(metric::flip(&b, &a)?)),
        ("rmse_relative", json!(metric::rmse_relative(&grey(coded), &grey(exact), &covered)?)),
        ("max_difference", json!(metric::max_difference(&a, &b)?)),
    ] {
        counts.insert(name.into(), value);
    }
    Ok(counts)
}

/// A picture as displayed, sRGB-encoded.
pub(super) fn displayed(seen: &Plane<Seen>, exposure: f32, tone: Tone) -> Plane<[f32; 3]> {
    seen.map(|s| {
        let all = std::array::from_fn(|c| {
            exposure * (s.direct[c] + s.indirect[c] + s.specular[c] + s.beyond[c])
        });
        tone.map(all).map(srgb_encode)
    })
}
