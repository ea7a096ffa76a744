//! Indirect light against the path-traced truth: each rule of the gather left out in turn, and error
//! over processor time beside plain path tracing.

use super::chapter4::{BLACK, Canvas, Colour, GREY, RED};
use crate::light::{Outcome, Truth, Way, trial};
use crate::project::{Options, Project};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::colour::{srgb_encode, to_byte};
use chiaro_image::sheet::Sheet;
use chiaro_ink::Polyline;
use chiaro_pbgi::{Division, LightKnobs, OwnSky, Sharing};
use serde_json::{Value, json};

/// Scenes when none is named.
pub(super) const SCENES: [&str; 1] = ["demo:cornell-box"];

/// Pixels along a side of pictures of rules, and of those that are timed.
const SMALL: usize = 160;
const TIMED: usize = 256;
/// Half of the reference's paths a pixel.
const PATHS: u32 = 128;
const PLOT: (usize, usize) = (480, 360);
/// Processor seconds and errors at the ends of the axes.
const SECONDS: [f64; 2] = [0.05, 100.0];
const ERRORS: [f64; 2] = [0.01, 1.0];
/// Error bounds of shared gathers.
const BOUNDS: [f32; 5] = [0.4, 0.2, 0.1, 0.05, 0.025];
const ORANGE: Colour = [0.95, 0.55, 0.1];
const BLUE: Colour = [0.1, 0.3, 0.8];
const GREEN: Colour = [0.1, 0.55, 0.2];

/// Pictures of one scene by every pixel's own gather, with all rules and with each left out, by
/// tiles, and by records; each beside ten times its difference from the truth.
pub(super) fn rules(sheet: &mut Sheet, scene: &str, run: &Run) -> Result<Vec<Value>> {
    let usual = LightKnobs { bounces: 1, sky: OwnSky::None, ..LightKnobs::default() };
    let all = LightKnobs { error_bound: 0.0, resolution: 8, solid_angle: 1.0, ..usual.clone() };
    let ways = [
        ("every rule", all.clone()),
        ("discs near, no rays", LightKnobs { near_field: false, ..all.clone() }),
        ("no flat nodes", LightKnobs { flat_nodes: false, ..all.clone() }),
        ("no dead sides", LightKnobs { side_rays: 0, ..all.clone() }),
        ("every rule, an octree", LightKnobs { hierarchy: Division::Octree, ..all }),
        ("shared by tiles", usual.clone()),
        ("the same without near rays", LightKnobs { near_field: false, ..usual.clone() }),
        ("records with gradients", LightKnobs { sharing: Sharing::Records, ..usual }),
    ];
    let ways = ways.map(|(name, knobs)| Way {
        name: name.into(),
        knobs,
        paths: None,
        pooled: false,
        shift: 0,
    });
    let (truth, found) = measured(scene, SMALL, &ways, run)?;
    for (way, outcome) in ways.iter().zip(&found) {
        let text = format!("{}: {:.1} %", way.name, 100.0 * outcome.error);
        sheet.add(shown(&truth, &outcome.irradiance), text);
        sheet.add(difference(&truth, &outcome.irradiance), "ten times the difference");
    }
    Ok(ways.iter().zip(&found).map(|(w, o)| value(scene, w, o)).collect())
}

/// Error over processor time of tiles and of records at several error bounds, of plain path tracing, and of
/// path tracing whose hits are pooled as those of tiles are.
pub(super) fn curves(sheet: &mut Sheet, scene: &str, run: &Run) -> Result<Vec<Value>> {
    let usual = LightKnobs { bounces: 1, sky: OwnSky::None, ..LightKnobs::default() };
    let shared = |(word, sharing): (&str, Sharing)| {
        BOUNDS.map(|error_bound| Way {
            name: format!("{word}, error_bound {error_bound}"),
            knobs: LightKnobs { error_bound, sharing, ..usual.clone() },
            paths: None,
            pooled: false,
            shift: 0,
        })
    };
    let paths = |name: &str, pooled: bool, n: u32| Way {
        name: format!("{n} {name}"),
        knobs: usual.clone(),
        paths: Some(n),
        pooled,
        shift: 0,
    };
    let plain = [2, 8, 32, 128, 512].map(|n| paths("paths", false, n));
    let pooled = [2, 8, 32, 128].map(|n| paths("pooled paths", true, n));
    let [tiles, records] = [("tiles", Sharing::Tiles), ("records", Sharing::Records)].map(shared);
    let lengths = [tiles.len(), records.len(), plain.len(), pooled.len()];
    let ways: Vec<Way> = tiles.into_iter().chain(records).chain(plain).chain(pooled).collect();
    let (_, found) = measured(scene, TIMED, &ways, run)?;
    let name = scene.rsplit(['/', ':']).next().unwrap_or(scene);
    let least =
        |some: &[Outcome]| some.iter().map(|o| 100.0 * o.error).fold(f64::INFINITY, f64::min);
    let mut rest = &found[..];
    let series = lengths.map(|n| {
        let (some, more) = rest.split_at(n);
        rest = more;
        some
    });
    let text = format!(
        "{name}: red tiles (least {:.1} %), orange records ({:.1} %), blue paths, green pooled paths; \
         1 to 100 % over 0.05 to 100 s",
        least(series[0]),
        least(series[1])
    );
    let [tiles, records, plain, pooled] = series;
    let drawn = plot(&[(tiles, RED), (records, ORANGE), (plain, BLUE), (pooled, GREEN)]);
    sheet.add(drawn.done(), text);
    Ok(ways.iter().zip(&found).map(|(w, o)| value(scene, w, o)).collect())
}

fn measured(scene: &str, side: usize, ways: &[Way], run: &Run) -> Result<(Truth, Vec<Outcome>)> {
    let options = Options { size: Some((side, side)), ..Options::default() };
    let project = Project::open(scene, options, run)?;
    trial(&project, ways, PATHS, None, run)
}

fn value(scene: &str, way: &Way, found: &Outcome) -> Value {
    json!({
        "scene": scene, "way": way.name, "rmse_relative": found.error, "bias": found.bias,
        "processor_seconds": found.seconds.iter().sum::<f64>(), "gathers": found.gathers,
    })
}

fn grey(c: &[f32; 3]) -> f32 {
    (c[0] + c[1] + c[2]) / 3.0
}

/// Display values over irradiance: the truth's mean is a middle grey.
fn scale(truth: &Truth) -> f32 {
    let covered = truth.covered.pixels().iter().filter(|c| **c).count().max(1);
    let sum: f32 = truth.mean().pixels().iter().map(grey).sum();
    0.3 * covered as f32 / sum.max(f32::MIN_POSITIVE)
}

fn shown(truth: &Truth, picture: &Plane<[f32; 3]>) -> Plane<[u8; 3]> {
    let scale = scale(truth);
    picture.map(|e| e.map(|v| to_byte(srgb_encode((scale * v).clamp(0.0, 1.0)))))
}

/// Middle grey where nothing differs.
fn difference(truth: &Truth, picture: &Plane<[f32; 3]>) -> Plane<[u8; 3]> {
    let (scale, mean) = (scale(truth), truth.mean());
    let (w, h) = mean.size();
    Plane::from_fn(w, h, |x, y| {
        let d = scale * (grey(&picture[(x, y)]) - grey(&mean[(x, y)]));
        [to_byte(0.5 + 5.0 * d); 3]
    })
}

/// Error upwards and seconds to the right, both logarithmic; lines at each power of ten.
fn plot(series: &[(&[Outcome], Colour)]) -> Canvas {
    let mut canvas = Canvas::new(PLOT);
    let line = |points: Vec<[f32; 2]>| Polyline { points, closed: false };
    let log = |v: f64, [low, high]: [f64; 2]| ((v / low).ln() / (high / low).ln()).clamp(0.0, 1.0);
    let at = |seconds: f64, error: f64| {
        let (w, h) = (PLOT.0 as f64 - 40.0, PLOT.1 as f64 - 40.0);
        let (x, y) = (log(seconds, SECONDS), 1.0 - log(error, ERRORS));
        [(20.0 + w * x) as f32, (20.0 + h * y) as f32]
    };
    let mut grid = Vec::new();
    for error in [0.01, 0.1, 1.0] {
        grid.push(line(vec![at(SECONDS[0], error), at(SECONDS[1], error)]));
    }
    for seconds in [0.1, 1.0, 10.0, 100.0] {
        grid.push(line(vec![at(seconds, ERRORS[0]), at(seconds, ERRORS[1])]));
    }
    canvas.lines(&grid, 0.6, GREY);
    for (some, colour) in series {
        let points: Vec<[f32; 2]> =
            some.iter().map(|o| at(o.seconds.iter().sum(), o.error.max(ERRORS[0]))).collect();
        for p in &points {
            canvas.lines(&[line(vec![*p, [p[0] + 0.01, p[1]]])], 6.0, BLACK);
        }
        canvas.lines(&[line(points)], 1.8, *colour);
    }
    canvas
}
