//! [`check`]: how often visibility errs, against the same lines on a surface sixteen times finer, or as fine as eight
//! million faces make it.
//!
//! 1. The shot's silhouettes are found twice with nothing bridged or dropped, hidden parts too: on
//!    the surface as it is, and on that surface refined twice more.
//! 2. A sample is *wrongly shown* when it is visible, no visible silhouette of the fine surface is
//!    within `NEAR` pixels, and a hidden one is; *wrongly hidden* when a visible sample of the fine
//!    surface has near it a hidden silhouette of the coarse one and no visible one. What is nearer
//!    than `NEAR` to the end of a visible stretch is so never counted.
//!    A visible line where pieces meet will do as well: which of the two is drawn where a silhouette runs
//!    into another piece is decided by less than a pixel, and a line is drawn either way.
//! 3. A sample with no line of the other surface near it at all is *apart*: the shapes differ there,
//!    not their visibility.
//! 4. A *flicker* is a visible sample whose material point has a visible line near it two frames
//!    later, but none in the frame between.

use crate::film::{Film, FilmFrame, Reel};
use crate::knob::{Hidden, LinesKnobs};
use crate::path::Kind;
use crate::stroke::{Sample, Stroke};
use chiaro_basis::math::DVec2;
use chiaro_basis::{Result, Run};
use std::collections::HashMap;

/// Lines within this of each other are the same, pixels.
const NEAR: f64 = 2.0;
/// Depths that differ by more than this do not belong to one line, in parts of the depth.
const DEPTH: f64 = 0.02;
/// How often the fine surface is refined once more: each time to four times the faces.
const LEVELS: u8 = 2;

/// Errors of visibility over a shot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Length of visible silhouettes on the fine surface, pixels.
    pub visible: f64,
    /// Share of it that is hidden on the coarse one.
    pub hidden: f64,
    /// Length that is shown though the fine surface hides it, over the same.
    pub shown: f64,
    /// Visible length, of both, with no line of the other near, over the same.
    pub apart: f64,
    /// Flickers a 1000 pixels of visible line, and those of the fine surface.
    pub flickers: [f64; 2],
    /// Faces of the surface, and of the fine one.
    pub faces: [usize; 2],
}

impl Errors {
    /// Names and values for records.
    pub fn named(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("visible_px", self.visible),
            ("wrongly_hidden_share", self.hidden),
            ("wrongly_shown_share", self.shown),
            ("apart_share", self.apart),
            ("flickers_per_1000px", self.flickers[0]),
            ("flickers_of_fine_per_1000px", self.flickers[1]),
            ("faces", self.faces[0] as f64),
            ("faces_of_fine", self.faces[1] as f64),
        ]
    }
}

/// Compares the visibility of a shot's silhouettes with that on a finer surface; all zero where
/// meshes are made anew in every frame.
pub fn check(reel: &Reel<'_>, knobs: &LinesKnobs, run: &Run) -> Result<Errors> {
    let bare = LinesKnobs {
        crease: false,
        border: false,
        material: false,
        bridge: 0.0,
        shortest: 0.0,
        prune: 0.0,
        beside: 0.0,
        step: 1.0,
        hidden: Hidden::Dashed,
        ..*knobs
    };
    let [Some(coarse), Some(fine)] = [0, LEVELS].map(|more| reel.ground(&bare, more, run)) else {
        return Ok(Errors::default());
    };
    let faces = [&coarse, &fine].map(|ground| ground.surface.real_faces);
    let coarse = Film::on(reel, Some(coarse), &bare, run)?;
    let fine = Film::on(reel, Some(fine), &bare, run)?;
    Ok(Errors { faces, ..compare(&coarse, &fine) })
}

/// Compares two films of the same shot.
fn compare(coarse: &Film, fine: &Film) -> Errors {
    let mut errors = Errors::default();
    for (c, f) in coarse.frames.iter().zip(&fine.frames) {
        let (near_c, near_f) = (Near::of(c), Near::of(f));
        errors.visible += silhouettes(&f.strokes).map(Stroke::total).sum::<f64>();
        let [wrong, apart] = unmatched(&f.strokes, &near_c);
        errors.hidden += wrong;
        errors.apart += apart;
        let [wrong, apart] = unmatched(&c.strokes, &near_f);
        errors.shown += wrong;
        errors.apart += apart;
    }
    let visible = errors.visible.max(f64::MIN_POSITIVE);
    Errors {
        hidden: errors.hidden / visible,
        shown: errors.shown / visible,
        apart: errors.apart / visible,
        flickers: [flickers(coarse), flickers(fine)],
        ..errors
    }
}

/// Those strokes that are compared: lines where pieces meet hide silhouettes, and so are found too.
fn silhouettes(strokes: &[Stroke]) -> impl Iterator<Item = &Stroke> {
    strokes.iter().filter(|s| s.kind == Kind::Silhouette)
}

/// Length of silhouettes that have near them only hidden lines of the other surface, and none at all.
fn unmatched(strokes: &[Stroke], other: &Near) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for stroke in silhouettes(strokes) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        for s in &stroke.samples {
            match other.at(s.at, s.depth) {
                [true, _] => {}
                [false, true] => sums[0] += weight,
                [false, false] => sums[1] += weight,
            }
        }
    }
    sums
}

/// Flickers a 1000 pixels.
fn flickers(film: &Film) -> f64 {
    let (mut count, mut length) = (0.0, 0.0);
    let near: Vec<Near> = film.frames.iter().map(Near::of).collect();
    for (i, three) in film.frames.windows(3).enumerate() {
        if three[1].begins || three[2].begins {
            continue;
        }
        for stroke in silhouettes(&three[0].strokes) {
            let weight = stroke.total() / stroke.samples.len() as f64;
            for s in &stroke.samples {
                length += weight;
                let later = step(s, &three[1]).map(|(at, depth)| {
                    let seen = near[i + 1].at(at, depth)[0];
                    // Steps are small: the same once more.
                    let further = at + (at - s.at);
                    !seen && near[i + 2].at(further, 2.0 * depth - s.depth)[0]
                });
                count += if later == Some(true) { weight } else { 0.0 };
            }
        }
    }
    if length > 0.0 { 1000.0 * count / length } else { 0.0 }
}

/// Where a sample's material point is in the next frame.
fn step(sample: &Sample, next: &FilmFrame) -> Option<(DVec2, f64)> {
    let seen = next.view.see(sample.next_world?)?;
    Some((seen.at, seen.depth))
}

/// The samples of a frame's silhouettes by cells of the picture.
struct Near {
    cells: HashMap<[i32; 2], Vec<(DVec2, f64, bool)>>,
}

impl Near {
    fn of(frame: &FilmFrame) -> Self {
        let mut cells: HashMap<[i32; 2], Vec<(DVec2, f64, bool)>> = HashMap::new();
        let seen = frame.strokes.iter().filter(|s| s.kind == Kind::Intersection);
        let outlines = [&frame.strokes, &frame.hidden].into_iter().flat_map(|s| silhouettes(s));
        for stroke in outlines.chain(seen) {
            for s in &stroke.samples {
                cells.entry(cell(s.at)).or_default().push((s.at, s.depth, stroke.visible));
            }
        }
        Self { cells }
    }

    /// Whether a visible line is near, and whether a hidden one is.
    fn at(&self, at: DVec2, depth: f64) -> [bool; 2] {
        let [x, y] = cell(at);
        let mut found = [false; 2];
        for dy in -1..=1 {
            for dx in -1..=1 {
                for (p, z, visible) in self.cells.get(&[x + dx, y + dy]).into_iter().flatten() {
                    if p.distance(at) < NEAR && (z - depth).abs() < DEPTH * depth {
                        found[usize::from(!visible)] = true;
                    }
                }
            }
        }
        found
    }
}

fn cell(at: DVec2) -> [i32; 2] {
    let c = (at / NEAR).floor();
    [c.x as i32, c.y as i32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slice::Slice;
    use crate::surface::NONE;
    use crate::track::Interval;
    use crate::view::View;
    use chiaro_basis::math::{DVec3, Vec3};

    /// A level line across the picture.
    fn level(kind: Kind, y: f64, visible: bool) -> Stroke {
        let sample = |k: u32| Sample {
            at: DVec2::new(f64::from(k), y),
            depth: 1.0,
            world: DVec3::ZERO,
            next_world: None,
            next_at: None,
            chain: 0,
            on_chain: f64::from(k),
            normal: DVec3::Z,
            faces: [NONE; 2],
        };
        let line = Stroke::through(kind, false, (0..101).map(sample).collect());
        Stroke { visible, ..line }
    }

    fn film(strokes: Vec<Stroke>) -> Film {
        let projection = chiaro_scene::Projection::Orthographic { half_height: 1.0 };
        let pose = chiaro_scene::Pose::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, projection);
        let (strokes, hidden) = strokes.into_iter().partition(|s| s.visible);
        let frame = FilmFrame {
            view: View::new(pose, (100, 100)),
            slice: Slice::default(),
            labels: Vec::new(),
            interval: Interval::default(),
            begins: true,
            further: Vec::new(),
            strokes,
            hidden,
            gaps: Vec::new(),
            stretches: [0; 2],
        };
        Film { frames: vec![frame], ..Film::default() }
    }

    #[test]
    fn silhouettes_alone_are_compared() {
        let seen = level(Kind::Silhouette, 20.0, true);
        // Something meets something beside a silhouette that is hidden on both surfaces.
        let meeting = level(Kind::Intersection, 40.0, true);
        let behind = level(Kind::Silhouette, 40.5, false);
        let both = film(vec![seen.clone(), meeting, behind.clone()]);
        let errors = compare(&both, &both);
        assert_eq!((errors.visible, errors.hidden, errors.shown), (100.0, 0.0, 0.0));
        assert_eq!(errors.apart, 0.0);
        // It stands in for a silhouette, but not far away, nor hidden.
        let outline = film(vec![seen.clone(), level(Kind::Silhouette, 40.5, true)]);
        assert_eq!((compare(&outline, &both).shown, compare(&both, &outline).hidden), (0.0, 0.0));
        let gone = Stroke { visible: false, ..level(Kind::Intersection, 40.0, true) };
        for other in [gone, level(Kind::Intersection, 44.0, true)] {
            let other = film(vec![seen.clone(), other, behind.clone()]);
            assert!(compare(&outline, &other).shown > 0.99);
        }
        // What is shown on one of them alone is an error.
        let shown = Stroke { visible: true, ..behind.clone() };
        let errors = compare(&film(vec![seen.clone(), shown]), &film(vec![seen, behind]));
        assert!(errors.hidden == 0.0 && (errors.shown - 1.0).abs() < 1e-9, "{errors:?}");
    }
}
