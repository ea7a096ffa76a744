//! Which strokes show the elements of a frame's lines ([`Strands`]): what identities remember from frame to frame.
//!
//! An element is a segment of a silhouette or of a further zero set, or an edge. Each is remembered in parts, since
//! long edges show in pieces.

use crate::extract::Lines;
use crate::feature::Features;
use crate::path::{Kind, Path};
use crate::surface::NONE;
use crate::track::Strands;
use crate::visibility::Run;

/// Parts of an element that remember on their own: long edges show in pieces.
const PARTS: usize = 6;

/// The elements of a frame's silhouettes, of its edge lines, and of each further zero set.
pub(crate) fn strands(lines: &Lines, features: Option<&Features>) -> Vec<Strands> {
    let starts = |counts: &mut dyn Iterator<Item = usize>| {
        let mut total = 0;
        let mut starts: Vec<u32> = counts
            .map(|n| {
                total += PARTS * n;
                (total - PARTS * n) as u32
            })
            .collect();
        starts.push(total as u32);
        starts
    };
    let chains = lines.slice.chains.iter();
    let silhouettes = Strands::empty(starts(&mut chains.map(|c| c.count as usize)));
    let edges = Strands::empty(starts(&mut features.into_iter().flat_map(Features::counts)));
    let mut families = vec![silhouettes, edges];
    for set in &lines.further {
        let chains = set.slice.chains.iter();
        families.push(Strands::empty(starts(&mut chains.map(|c| c.count as usize))));
    }
    for (i, path) in lines.paths.iter().enumerate() {
        let further = || lines.further.iter().position(|f| f.kind == path.kind).map(|i| i + 2);
        let family = match path.kind {
            Kind::Silhouette => Some(0),
            kind if kind.is_edge() => features.map(|_| 1),
            _ => further(),
        };
        if let Some(family) = family {
            cover(&mut families[family], path, i, lines);
        }
    }
    families
}

/// Writes down which strokes show the elements of a path.
fn cover(strands: &mut Strands, path: &Path, index: usize, lines: &Lines) {
    let start = strands.starts[path.chain as usize] as usize;
    let end = strands.starts[path.chain as usize + 1] as usize;
    let n = path.segments.len() as f64;
    let here = lines.parts.iter().filter(|p| p.1 == index);
    let shown: Vec<(u32, Run)> = here.map(|(stroke, _, run)| (*stroke as u32, *run)).collect();
    let stroke = |place: f64| {
        let covers = |r: &Run| (place >= r.start && place <= r.end) || place + n <= r.end;
        shown.iter().find(|(_, r)| covers(r)).map_or(NONE, |(s, _)| *s)
    };
    for k in 0..path.segments.len() {
        let (a, b) = (path.points[k].on_chain, path.points[k + 1].on_chain);
        let parts = PARTS as f64;
        let share = (path.length[k + 1] - path.length[k]) / ((b - a) * parts).max(1.0);
        let first = (a * parts - 0.5).ceil().max(0.0) as usize;
        let mut part = first;
        while (part as f64 + 0.5) / parts < b && start + part < end {
            let place = path.place_in_space(k, ((part as f64 + 0.5) / parts - a) / (b - a));
            strands.stroke[start + part] = stroke(place);
            strands.weight[start + part] = share as f32;
            part += 1;
        }
    }
    // What is shorter than a part of an element has the part that it is in.
    for (stroke, run) in &shown {
        let middle = 0.5 * (run.start + run.end);
        let k = (middle as usize) % path.segments.len();
        let (a, b) = (path.points[k].on_chain, path.points[k + 1].on_chain);
        let at = a + (b - a) * path.in_space(k, middle.fract());
        let part = start + (at * PARTS as f64) as usize;
        if part < end && strands.stroke[part] == NONE {
            strands.stroke[part] = *stroke;
            strands.weight[part] = path.run_length(*run) as f32;
        }
    }
}

/// The same correspondence for the parts of elements.
pub(crate) fn in_parts(forward: &[u32]) -> Vec<u32> {
    let part = |to: u32, p: usize| if to == NONE { NONE } else { to * PARTS as u32 + p as u32 };
    forward.iter().flat_map(|&to| (0..PARTS).map(move |p| part(to, p))).collect()
}
