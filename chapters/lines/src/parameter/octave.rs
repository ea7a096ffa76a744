//! The octave switch: patterns that grow and shrink with the camera's zoom.
//!
//! In a zoom a pattern of fixed size must slide or stretch. With the switch on, u follows the zoom:
//! `pixels_per_u` of a frame is the pattern's length times how much lines have grown since the
//! first frame. Whoever draws picks the power of two that brings the pattern back nearest to its size,
//! and blends the two around it (self-similar line artmaps, Bénard et al. 2010).

use super::net::Net;
use crate::film::Film;

/// How much lines have grown at each frame: the median over links, in octaves, summed over time.
pub(crate) fn zoom(film: &Film, net: &Net) -> Vec<f64> {
    let mut growth: Vec<Vec<f64>> = vec![Vec::new(); film.frames.len()];
    for pair in net.links.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if a.lines != b.lines || b.from != a.from + 1 {
            continue;
        }
        let [from, to] = a.lines.map(|l| &net.lines[l as usize]);
        let k = (a.from - from.first) as usize;
        let before = from.length[k + 1] - from.length[k];
        let at = |l: &super::net::Link| {
            let k = (l.to[0] - to.first) as usize;
            to.length[k] + (to.length[k + 1] - to.length[k]) * l.share
        };
        let after = at(b) - at(a);
        if before > 1e-3 && after > 1e-3 {
            growth[from.frame as usize + 1].push((after / before).log2());
        }
    }
    let mut sum = 0.0;
    growth
        .into_iter()
        .map(|mut g| {
            g.sort_unstable_by(f64::total_cmp);
            sum += g.get(g.len() / 2).copied().unwrap_or(0.0);
            sum.exp2()
        })
        .collect()
}
