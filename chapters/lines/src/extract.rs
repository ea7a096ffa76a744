//! The lines of one frame: from a surface, a pose and a camera to strokes.

use crate::contour::Scenery;
use crate::feature::Features;
use crate::further::Further;
use crate::gap::{Gap, Shown, gaps};
use crate::intersect::intersections;
use crate::join::Line;
use crate::knob::{Hidden, LinesKnobs};
use crate::mask::Masks;
use crate::path::{Kind, Path};
use crate::posed::Posed;
use crate::sight::Sight;
use crate::slice::Slice;
use crate::solid::Solids;
use crate::stroke::{Owner, Stroke};
use crate::surface::Surface;
use crate::view::View;
use crate::visibility::{Limits, Run, Visible, hidden, visible};
use crate::whole::whole;
use crate::zeroset::{ZeroSet, zero_sets};
use chiaro_basis::math::DVec3;
use std::collections::BTreeMap;

/// What the frames of a shot share.
pub struct Stage<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its edge lines.
    pub features: &'a Features,
    /// Its faces with holes.
    pub masks: &'a Masks,
    /// The knobs.
    pub knobs: &'a LinesKnobs,
}

/// A frame in the course of a film.
pub struct Moment<'a> {
    /// The surface's pose.
    pub posed: &'a Posed,
    /// The camera.
    pub view: &'a View,
    /// Positions and camera one frame later.
    pub next: Option<(&'a [DVec3], &'a View)>,
}

/// The lines of one frame, with everything on the way to them.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    /// g at the vertices.
    pub g: Vec<f64>,
    /// Its zero set: all silhouettes, hidden ones too.
    pub slice: Slice,
    /// Zero sets of further line types.
    pub further: Vec<Further>,
    /// All lines of all kinds, hidden ones too.
    pub paths: Vec<Path>,
    /// Whether each of them goes round all of a small object.
    pub whole: Vec<bool>,
    /// What is seen of them.
    pub visible: Visible,
    /// The visible runs as strokes.
    pub strokes: Vec<Stroke>,
    /// The hidden parts as strokes, if they are wanted; no part of `parts`.
    pub hidden: Vec<Stroke>,
    /// What lies between strokes of one line.
    pub gaps: Vec<Gap>,
    /// What strokes are made of: stroke, path, run.
    pub parts: Vec<(usize, usize, Run)>,
}

impl<'a> Stage<'a> {
    /// What the paths of a frame are made from.
    pub(crate) fn scenery(&self, moment: &Moment<'a>) -> Scenery<'a> {
        Scenery {
            surface: self.surface,
            posed: moment.posed,
            next: moment.next.map(|n| n.0),
            view: moment.view,
            passes: self.knobs.smooth_normals,
            margin: f64::from(self.knobs.margin),
        }
    }
}

impl Lines {
    /// Finds the lines of a frame.
    pub fn find(stage: &Stage<'_>, moment: &Moment<'_>) -> Self {
        let Stage { surface, features, masks, knobs } = *stage;
        let view = moment.view;
        let scenery = stage.scenery(moment);
        let g = moment.posed.facing(view);
        let slice = Slice::of(surface, &g);
        let mut paths = features.paths(&scenery, &g);
        let solids = Solids::of(&scenery);
        paths.extend(scenery.silhouettes_of(&slice, &g, &solids));
        let sets = zero_sets(&scenery, &g, knobs);
        paths.extend(sets.iter().flat_map(|set| scenery.trimmed(set)));
        let sight = Sight::new(&scenery, masks, &solids);
        if knobs.intersection {
            paths.extend(intersections(&scenery, &sight));
        }
        let further = sets.into_iter().map(ZeroSet::further).collect();
        paths.retain(|p| p.total() > 0.0);
        let limits = Limits {
            gap: f64::from(knobs.bridge),
            run: f64::from(knobs.shortest),
            beside: f64::from(knobs.beside),
        };
        let drawn = |kind: Kind| is_drawn(kind, knobs);
        let visible = visible(&paths, &sight, view, &limits, &drawn);
        let (strokes, hidden, gaps, parts) = strokes_of(&paths, &visible, stage, moment);
        let place = (moment.posed.positions.as_slice(), view);
        let whole = whole(&paths, surface, place, f64::from(knobs.prune));
        Self { g, slice, further, paths, whole, visible, strokes, hidden, gaps, parts }
    }
}

/// What strokes are made of: stroke, path, run.
type Parts = Vec<(usize, usize, Run)>;

/// Strokes of what is seen and of what is hidden, what lies between them, and what the former are made of.
pub(crate) fn strokes_of(
    paths: &[Path],
    visible: &Visible,
    stage: &Stage<'_>,
    moment: &Moment<'_>,
) -> (Vec<Stroke>, Vec<Stroke>, Vec<Gap>, Parts) {
    let (seen, parts) = strokes(paths, visible, stage, moment);
    let (hidden, unseen) = hidden_strokes(paths, visible, stage, moment);
    let gaps = gaps(paths, shown(&parts).chain(unseen).collect());
    (seen, hidden, gaps, parts)
}

/// The strokes of all lines that are drawn, and what each is made of.
fn strokes(
    paths: &[Path],
    visible: &Visible,
    stage: &Stage<'_>,
    moment: &Moment<'_>,
) -> (Vec<Stroke>, Parts) {
    let next_view = moment.next.map(|n| n.1);
    let step = f64::from(stage.knobs.step);
    let (mut strokes, mut parts) = (Vec::new(), Vec::new());
    for line in visible.lines.iter().filter(|l| is_drawn(paths[l.parts[0].0].kind, stage.knobs)) {
        let stroke = Stroke::of_line(paths, line, step, moment.view, next_view);
        if stroke.samples.len() > 1 {
            parts.extend(line.parts.iter().map(|(path, run)| (strokes.len(), *path, *run)));
            strokes.push(Stroke { owner: owner(paths, line, stage.surface), ..stroke });
        }
    }
    (strokes, parts)
}

/// The runs that strokes are made of.
fn shown(parts: &Parts) -> impl Iterator<Item = Shown> + '_ {
    (0..parts.len()).map(|k| {
        let (stroke, path, run) = parts[k];
        let other = |k: usize| parts.get(k).is_none_or(|p| p.0 != stroke);
        Shown { path, run, is_end: [k == 0 || other(k - 1), other(k + 1)] }
    })
}

/// The strokes of what is hidden, where that is drawn, and the runs that they are.
fn hidden_strokes(
    paths: &[Path],
    visible: &Visible,
    stage: &Stage<'_>,
    moment: &Moment<'_>,
) -> (Vec<Stroke>, Vec<Shown>) {
    let knobs = stage.knobs;
    if knobs.hidden == Hidden::Drop {
        return (Vec::new(), Vec::new());
    }
    let next_view = moment.next.map(|n| n.1);
    let (step, shortest) = (f64::from(knobs.step), f64::from(knobs.shortest));
    let drawn = (0..paths.len()).filter(|&i| is_drawn(paths[i].kind, knobs));
    drawn
        .flat_map(|i| {
            let covered = visible.runs[i].iter().chain(&visible.beside[i]);
            hidden(&paths[i], covered, shortest).into_iter().map(move |run| (i, run))
        })
        .map(|(i, run)| {
            let stroke = Stroke {
                visible: false,
                owner: owner(paths, &Line::single(i, run), stage.surface),
                ..Stroke::of(&paths[i], run, step, moment.view, next_view)
            };
            (stroke, Shown { path: i, run, is_end: [true; 2] })
        })
        .filter(|(stroke, _)| stroke.samples.len() > 1)
        .unzip()
}

/// What most segments of a line belong to.
fn owner(paths: &[Path], line: &Line, surface: &Surface) -> Option<Owner> {
    let mut votes: BTreeMap<Owner, usize> = BTreeMap::new();
    for (path, run) in &line.parts {
        let segments = &paths[*path].segments;
        for k in run.start.floor() as usize..run.end.ceil() as usize {
            if let Some(owner) = surface.owner(segments[k % segments.len()].own) {
                *votes.entry(owner).or_default() += 1;
            }
        }
    }
    votes.into_iter().max_by_key(|(owner, count)| (*count, std::cmp::Reverse(*owner))).map(|v| v.0)
}

fn is_drawn(kind: Kind, knobs: &LinesKnobs) -> bool {
    match kind {
        Kind::Silhouette => knobs.silhouette,
        Kind::Crease => knobs.crease,
        Kind::Border => knobs.border,
        Kind::Material => knobs.material,
        Kind::Intersection => knobs.intersection,
        // The others are not even looked for unless they are drawn.
        _ => true,
    }
}
