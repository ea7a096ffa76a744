//! The lines of one frame: from a surface, a pose and a camera to strokes.

use crate::contour::Scenery;
use crate::feature::Features;
use crate::intersect::intersections;
use crate::knob::{Hidden, LinesKnobs};
use crate::mask::Masks;
use crate::path::{Kind, Path};
use crate::posed::Posed;
use crate::sight::Sight;
use crate::slice::Slice;
use crate::stroke::{Owner, Stroke};
use crate::surface::Surface;
use crate::view::View;
use crate::visibility::{Limits, Run, Visible, hidden, visible};
use crate::zeroset::zero_sets;
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
    pub further: Vec<(Kind, Slice)>,
    /// All lines of all kinds, hidden ones too.
    pub paths: Vec<Path>,
    /// What is seen of them.
    pub visible: Visible,
    /// The visible runs as strokes.
    pub strokes: Vec<Stroke>,
    /// The hidden parts as strokes, if they are wanted; no part of `runs`.
    pub hidden: Vec<Stroke>,
    /// For each stroke, its path and its run.
    pub runs: Vec<(usize, Run)>,
}

impl Lines {
    /// Finds the lines of a frame.
    pub fn find(stage: &Stage<'_>, moment: &Moment<'_>) -> Self {
        let Stage { surface, features, masks, knobs } = *stage;
        let view = moment.view;
        let scenery = Scenery {
            surface,
            posed: moment.posed,
            next: moment.next.map(|n| n.0),
            view,
            passes: knobs.smooth_normals,
            margin: f64::from(knobs.margin),
        };
        let g = moment.posed.facing(view);
        let slice = Slice::of(surface, &g);
        let mut paths = features.paths(&scenery, &g);
        paths.extend(scenery.silhouettes(&slice, &g));
        let sets = zero_sets(&scenery, &g, knobs);
        paths.extend(sets.iter().flat_map(|set| scenery.trimmed(set)));
        let sight = Sight::new(surface, moment.posed, view, |face, front| {
            let source = &surface.sources[face];
            source.opaque && (source.two_sided || front != source.turned)
        })
        .with_masks(masks);
        if knobs.intersection {
            paths.extend(intersections(&scenery, &sight));
        }
        let further = sets.into_iter().map(|s| (s.kind, s.slice)).collect();
        paths.retain(|p| p.total() > 0.0);
        let limits = Limits { gap: f64::from(knobs.bridge), run: f64::from(knobs.shortest) };
        let visible = visible(&paths, &sight, view, &limits);
        let (strokes, runs) = strokes(&paths, &visible, stage, moment);
        let hidden = hidden_strokes(&paths, &visible, stage, moment);
        Self { g, slice, further, paths, visible, strokes, hidden, runs }
    }
}

/// The strokes of all runs that are drawn, each with its path and its run.
fn strokes(
    paths: &[Path],
    visible: &Visible,
    stage: &Stage<'_>,
    moment: &Moment<'_>,
) -> (Vec<Stroke>, Vec<(usize, Run)>) {
    let next_view = moment.next.map(|n| n.1);
    let knobs = stage.knobs;
    let step = f64::from(knobs.step);
    let drawn = paths.iter().enumerate().filter(|(_, p)| is_drawn(p.kind, knobs));
    drawn
        .flat_map(|(i, path)| visible.runs[i].iter().map(move |&run| (i, path, run)))
        .map(|(i, path, run)| {
            let stroke = Stroke::of(path, run, step, moment.view, next_view);
            (Stroke { owner: owner(path, run, stage.surface), ..stroke }, (i, run))
        })
        .filter(|(stroke, _)| stroke.samples.len() > 1)
        .unzip()
}

/// The strokes of what is hidden, where that is drawn.
fn hidden_strokes(
    paths: &[Path],
    visible: &Visible,
    stage: &Stage<'_>,
    moment: &Moment<'_>,
) -> Vec<Stroke> {
    let knobs = stage.knobs;
    if knobs.hidden == Hidden::Drop {
        return Vec::new();
    }
    let next_view = moment.next.map(|n| n.1);
    let (step, shortest) = (f64::from(knobs.step), f64::from(knobs.shortest));
    let drawn = paths.iter().zip(&visible.runs).filter(|(p, _)| is_drawn(p.kind, knobs));
    drawn
        .flat_map(|(path, runs)| {
            hidden(path, runs, shortest).into_iter().map(move |run| (path, run))
        })
        .map(|(path, run)| Stroke {
            visible: false,
            owner: owner(path, run, stage.surface),
            ..Stroke::of(path, run, step, moment.view, next_view)
        })
        .filter(|stroke| stroke.samples.len() > 1)
        .collect()
}

/// What most segments of a run belong to.
fn owner(path: &Path, run: Run, surface: &Surface) -> Option<Owner> {
    let n = path.segments.len();
    let mut votes: BTreeMap<Owner, usize> = BTreeMap::new();
    for k in run.start.floor() as usize..run.end.ceil() as usize {
        let own = path.segments[k % n].own;
        if let Some(source) = own.iter().find_map(|f| surface.sources.get(*f as usize)) {
            *votes
                .entry(Owner { object: source.object, material: source.material })
                .or_default() += 1;
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
