//! [`Growth`]: how much lines grow from frame to frame, and what that does to textures that are nearly rigid.

use super::net::{Link, Net};
use std::collections::BTreeMap;

/// Steps along a line that grow by more than this are no growth, but another part of the other line.
const STEP: f64 = 3.0;
/// Shortest step that tells of growth, pixels.
const SHORT: f64 = 1e-3;

/// The bundles of links from one line to another, and how much what they join grows.
pub(crate) struct Growth {
    bundles: Vec<Bundle>,
}

/// Links from one line to another.
struct Bundle {
    links: Vec<u32>,
    /// Where each is on the line before, pixels.
    places: Vec<f64>,
    /// By how much a pixel of the line grows, or shrinks.
    most: f64,
}

impl Growth {
    pub(crate) fn of(net: &Net) -> Self {
        let mut bundles: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (i, link) in net.links.iter().enumerate() {
            bundles.entry(link.lines).or_default().push(i as u32);
        }
        let bundle = |links: Vec<u32>| {
            let ends: Vec<[f64; 2]> =
                links.iter().map(|i| ends(net, &net.links[*i as usize])).collect();
            let places = ends.iter().map(|e| e[0]).collect();
            Bundle { most: (growth(&ends) - 1.0).abs(), links, places }
        };
        Self { bundles: bundles.into_values().map(bundle).collect() }
    }

    /// Residuals of links, in pixels, without what growth alone makes of them: their slope along each
    /// bundle, about its middle, as far as it is no steeper than the growth.
    pub(crate) fn left_out(&self, mut residual: Vec<f64>) -> Vec<f64> {
        for Bundle { links, places, most } in &self.bundles {
            let count = links.len() as f64;
            let middle = places.iter().sum::<f64>() / count;
            let mean = links.iter().map(|i| residual[*i as usize]).sum::<f64>() / count;
            let (mut up, mut across) = (0.0, 0.0);
            for (i, place) in links.iter().zip(places) {
                up += (place - middle) * (residual[*i as usize] - mean);
                across += (place - middle).powi(2);
            }
            let slope = if across > 0.0 { (up / across).clamp(-most, *most) } else { 0.0 };
            for (i, place) in links.iter().zip(places) {
                residual[*i as usize] -= slope * (place - middle);
            }
        }
        residual
    }
}

/// Where a link is on its two lines, pixels from their starts.
fn ends(net: &Net, link: &Link) -> [f64; 2] {
    let [a, b] = link.lines.map(|l| &net.lines[l as usize]);
    let k = (link.to[0] - b.first) as usize;
    let after = b.length[k] + (b.length[k + 1] - b.length[k]) * link.share;
    [a.length[(link.from - a.first) as usize], after]
}

/// How many times as long a line becomes, by the places of its links before and after.
fn growth(ends: &[[f64; 2]]) -> f64 {
    let steps = ends.windows(2).map(|p| [p[1][0] - p[0][0], p[1][1] - p[0][1]]);
    let fits =
        |s: &[f64; 2]| s.iter().all(|d| *d > SHORT) && s[1] < STEP * s[0] && s[0] < STEP * s[1];
    let sums = steps.filter(fits).fold([0.0; 2], |a, s| [a[0] + s[0], a[1] + s[1]]);
    if sums[0] > 0.0 { sums[1] / sums[0] } else { 1.0 }
}
