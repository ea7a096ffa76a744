//! What any labelling of a picture with a palette costs, for those who change one afterwards.

use crate::cel::Cel;
use crate::cut::Graph;
use crate::geometry::EDGES;
use chiaro_image::Plane;

/// The prices of a palette's labels; bonds are those of the picture's [`Graph`].
#[derive(Clone, Debug)]
pub struct Tariff {
    /// What each pixel pays for each label, in units of capacity.
    prices: Vec<i32>,
    count: usize,
    /// Whether a border costs its bond for each step from one label to the other, as between tones, or
    /// once.
    by_step: bool,
}

impl Tariff {
    pub(crate) fn new(prices: Vec<i32>, count: usize, by_step: bool) -> Self {
        Self { prices, count, by_step }
    }

    /// That of a film's frame: spot colours are one layer, tones a layer for each step.
    pub(crate) fn of(cel: &Cel, by_step: bool) -> Self {
        if !by_step {
            return Self::new(cel.prices(0).to_vec(), cel.count(0), false);
        }
        let (steps, pixels) = (cel.layers.len(), cel.graph.mask.len());
        let mut prices = Vec::with_capacity((steps + 1) * pixels);
        for p in 0..pixels {
            let at = |layer: usize, white: bool| cel.prices(layer)[2 * p + usize::from(white)];
            let tone = |l: usize| (0..steps).map(|layer| at(layer, layer < l)).sum::<i32>();
            prices.extend((0..=steps).map(tone));
        }
        Self::new(prices, steps + 1, true)
    }

    /// The energy of labels, in units of capacity.
    pub fn energy(&self, labels: &Plane<u8>, graph: &Graph) -> i64 {
        let mask = &graph.mask;
        let (w, h) = mask.size();
        let mut energy = 0;
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|p| mask[*p]) {
            let own = labels[(x, y)];
            energy += i64::from(self.prices[(y * w + x) * self.count + usize::from(own)]);
            for (e, (dx, dy)) in EDGES.into_iter().enumerate() {
                let q = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                if q.0 < w && q.1 < h && mask[q] {
                    let bond = i64::from(graph.neighbour[(x, y)][e]);
                    energy += bond * self.distance(own, labels[q]);
                }
            }
        }
        energy
    }

    fn distance(&self, a: u8, b: u8) -> i64 {
        let steps = i64::from(a.abs_diff(b));
        if self.by_step { steps } else { steps.min(1) }
    }
}
