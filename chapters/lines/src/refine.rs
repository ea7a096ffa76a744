//! How often each shape of a shot is refined: decided once, so that the surface is the same in every
//! frame.
//!
//! The error of a silhouette grows with the edges that it crosses. Their lengths in the picture are
//! gathered on a few frames; a shape is refined until those that are short enough make up four fifths of
//! their length: long edges carry most of a silhouette, and fine twigs beside a coarse crown are no
//! reason to leave that as it is. Where that makes many faces, they go to the shapes whose silhouettes
//! gain most by each.

use crate::film::{Ground, Reel};
use crate::knob::LinesKnobs;
use crate::posed::Posed;
use crate::slice::Slice;
use crate::surface::Detail;
use chiaro_scene::Frame;

/// Frames of the shot that are looked at.
const LOOKS: usize = 5;
/// Share of the length of crossed edges that must be of short ones.
const MOST: f64 = 0.8;
/// Faces that refinement may lead to, and those it may where it is worth it.
const FACES: [usize; 2] = [400_000, 2_000_000];
/// Faces of the surface by which visibility is checked, at most.
const FINEST: usize = 8_000_000;
/// What a face must take away to be worth it, square pixels.
const WORTH: f64 = 5.0;

/// How closely the lines of a shot follow each shape of its frames; `ground` is not refined.
pub(crate) fn details(reel: &Reel<'_>, ground: &Ground, knobs: &LinesKnobs) -> Vec<Detail> {
    let looks = LOOKS.min(reel.count);
    let mut lengths: Vec<Vec<f64>> = Vec::new();
    for i in 0..looks {
        let (frame, view) = (reel.at)(i * (reel.count - 1) / (looks - 1).max(1));
        lengths.resize(frame.shapes.len(), Vec::new());
        gather(&mut lengths, ground, &frame, &view, knobs);
    }
    let wanted: Vec<f64> = lengths.iter_mut().map(|l| halvings(l, knobs)).collect();
    let level = |wanted: &f64| wanted.clamp(0.0, f64::from(knobs.subdivide)) as u8;
    let faces = faces(&(reel.at)(0).0, ground);
    let error = |l: &Vec<f64>| l.iter().map(|l| l * l).sum();
    let errors: Vec<f64> = lengths.iter().map(error).collect();
    let levels = affordable(&wanted.iter().map(level).collect::<Vec<u8>>(), &faces, &errors);
    let detail = |(levels, wanted): (u8, &f64)| Detail { levels, facets: *wanted > 0.0 };
    levels.into_iter().zip(&wanted).map(detail).collect()
}

/// Refines shapes `more` times further where there may be faces for it.
pub(crate) fn finer(details: &mut [Detail], frame: &Frame, ground: &Ground, more: u8) {
    let mut levels: Vec<u8> = details.iter().map(|d| d.levels).collect();
    deepen(&mut levels, &faces(frame, ground), more);
    details.iter_mut().zip(levels).for_each(|(detail, levels)| detail.levels = levels);
}

/// `more` levels for each shape, those with the fewest faces first, as far as these faces suffice.
fn deepen(levels: &mut [u8], faces: &[usize], more: u8) {
    let cost = |shape: usize, levels: u8| faces[shape].saturating_mul(1 << (2 * levels));
    let mut all: usize = levels.iter().enumerate().map(|(i, l)| cost(i, *l)).sum();
    let mut order: Vec<usize> = (0..levels.len()).collect();
    order.sort_by_key(|i| cost(*i, levels[*i]));
    for _ in 0..more {
        for &i in &order {
            let gained = 3 * cost(i, levels[i]);
            if all.saturating_add(gained) <= FINEST {
                all += gained;
                levels[i] += 1;
            }
        }
    }
}

/// How many faces each shape of a frame has.
fn faces(frame: &Frame, ground: &Ground) -> Vec<usize> {
    let mut faces = vec![0usize; frame.shapes.len()];
    for source in &ground.surface.sources {
        faces[frame.objects[source.object as usize].shape] += 1;
    }
    faces
}

/// Adds the picture lengths of crossed edges to those of their shapes.
fn gather(
    lengths: &mut [Vec<f64>],
    ground: &Ground,
    frame: &Frame,
    view: &crate::view::View,
    knobs: &LinesKnobs,
) {
    let surface = &ground.surface;
    let posed = Posed::new(surface, frame, knobs.smooth_normals);
    for crossing in Slice::of(surface, &posed.facing(view)).crossings {
        let face = surface.half[crossing.edge as usize] as usize / 3;
        let Some(source) = surface.sources.get(face) else { continue };
        let ends = surface.ends(crossing.edge).map(|v| view.see(posed.positions[v as usize]));
        if let [Some(a), Some(b)] = ends
            && view.holds(a.at.lerp(b.at, crossing.at), 0.0)
        {
            let shape = frame.objects[source.object as usize].shape;
            lengths[shape].push(a.at.distance(b.at));
        }
    }
}

/// How often edges must be halved.
fn halvings(lengths: &mut [f64], knobs: &LinesKnobs) -> f64 {
    lengths.sort_by(f64::total_cmp);
    let all: f64 = lengths.iter().sum();
    let mut sum = 0.0;
    let long = lengths.iter().find(|l| {
        sum += **l;
        sum >= MOST * all
    });
    long.map_or(0.0, |long| (long / f64::from(knobs.subdivide_edge)).log2().ceil())
}

/// As many levels as there may be faces for, those first that take most error away for a face. A level leaves a
/// quarter of the error, which goes by the square of the length of crossed edges, and makes four faces of one.
fn affordable(wanted: &[u8], faces: &[usize], errors: &[f64]) -> Vec<u8> {
    let mut levels = vec![0u8; wanted.len()];
    let mut all: usize = faces.iter().sum();
    let cost = |shape: usize, level: u8| faces[shape].saturating_mul(3 << (2 * level));
    loop {
        let worth = |shape: usize| {
            errors[shape] / 4f64.powi(levels[shape].into()) / cost(shape, levels[shape]) as f64
        };
        let fits = |shape: &usize| {
            let total = all.saturating_add(cost(*shape, levels[*shape]));
            let most = FACES[usize::from(worth(*shape) >= WORTH)];
            levels[*shape] < wanted[*shape] && total <= most
        };
        let best = (0..wanted.len()).filter(fits).max_by(|a, b| worth(*a).total_cmp(&worth(*b)));
        let Some(best) = best else { return levels };
        all += cost(best, levels[best]);
        levels[best] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_edges_count_by_their_length() {
        let knobs = LinesKnobs { subdivide_edge: 8.0, ..LinesKnobs::default() };
        let mut twigs = vec![2.0; 90];
        assert!(halvings(&mut twigs, &knobs) <= 0.0);
        // A crown of few edges that are long.
        twigs.extend([30.0; 10]);
        assert_eq!(halvings(&mut twigs, &knobs), 2.0);
        // One long edge of many is not worth it.
        let mut fine = vec![4.0; 400];
        fine.push(100.0);
        assert!(halvings(&mut fine, &knobs) <= 0.0);
        assert_eq!(halvings(&mut [], &knobs), 0.0);
    }

    #[test]
    fn the_finest_surface_is_bounded() {
        let deepened = |levels: &[u8], faces: &[usize]| {
            let mut levels = levels.to_vec();
            deepen(&mut levels, faces, 2);
            levels
        };
        assert_eq!(deepened(&[1, 0], &[1000, 50_000]), [3, 2]);
        // 1.9 million make 7.6, and no more; what is small is refined all the same.
        assert_eq!(deepened(&[0, 1], &[1_900_000, 500]), [1, 3]);
        assert_eq!(deepened(&[0], &[3_000_000]), [0]);
    }

    #[test]
    fn faces_go_where_they_take_most_error_away() {
        // A crowd of fine stones, and a crown of few large leaves.
        let faces = [300_000, 10_000];
        assert_eq!(affordable(&[2, 2], &faces, &[1e4, 1e7]), [0, 2]);
        assert_eq!(affordable(&[2, 2], &faces, &[1e7, 1e6]), [1, 1]);
        // Few faces cost little.
        assert_eq!(affordable(&[1, 1], &[50_000, 20_000], &[1.0, 1.0]), [1, 1]);
        // More than there may be is left as it is.
        assert_eq!(affordable(&[2, 1], &[2_000_000, 10], &[1e9, 1.0]), [0, 0]);
    }
}
