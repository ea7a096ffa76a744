//! [`Cel`]: a frame of a film as its cut needs it.
//!
//! In two colours it is labelled by its graph. A palette of tones gives it a layer for every step
//! between two of them, labelled as films of their own: their cuts are nested. Spot colours are one
//! layer of as many labels. All layers share the bonds of the graph and the links of the frame.

use crate::cut::{Graph, Labels};
use crate::knob::BinaryKnobs;
use crate::mend::Costs;
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_mincut::{Distance, LabelError, LabelGrid, Labelling, expand};
use chiaro_trace::UNLINKED;

/// A frame of a film as its cut needs it.
#[derive(Clone)]
pub struct Cel {
    /// The frame's own graph in two colours.
    pub graph: Graph,
    /// For each pixel the pixel of the frame before that shows the same material point, or
    /// [`UNLINKED`](chiaro_trace::UNLINKED).
    pub links: Plane<u32>,
    /// The minimal cut of the frame's own graph.
    pub alone: Labels,
    /// What is labelled instead of the graph, if the film has a palette.
    pub layers: Vec<Layer>,
    /// The labels that are painted, if any: black or white.
    pub painted: Option<Plane<Option<bool>>>,
    /// The labels of `alone`.
    own: Plane<u8>,
}

/// Labels of a frame that are found together.
#[derive(Clone)]
pub struct Layer {
    /// How many labels there are.
    pub count: usize,
    /// What each pixel pays for each label, in units of the graph's capacities.
    pub prices: Vec<i32>,
    /// The labels of the frame by itself.
    pub alone: Plane<u8>,
    /// Their energy.
    pub energy: i64,
    /// The labels that black and white paint mean.
    pub paint: [u8; 2],
}

impl Layer {
    /// A layer of two labels: black and white with other terminals than the graph's.
    pub fn step(graph: &Graph, terminal: Plane<[i32; 2]>) -> Result<Self> {
        let graph = Graph { terminal, ..graph.clone() };
        let labels = graph.solve()?;
        Ok(Self {
            count: 2,
            prices: graph.terminal.into_pixels().into_iter().flatten().collect(),
            alone: labels.white.map(|w| u8::from(*w)),
            energy: labels.cut,
            paint: [0, 1],
        })
    }

    /// A layer of labels without an order, each as far from any other; `paint` says which ones black
    /// and white paint mean.
    pub fn unordered(
        graph: &Graph,
        prices: Vec<i32>,
        count: usize,
        paint: [u8; 2],
    ) -> Result<Self> {
        let (width, height) = graph.mask.size();
        let found = expanded(graph, &prices, count)?;
        let alone = Plane::from_pixels(width, height, found.labels);
        Ok(Self { count, prices, alone, energy: found.energy, paint })
    }
}

impl Cel {
    /// A frame in two colours with its own cut.
    pub fn new(graph: Graph, links: Plane<u32>) -> Result<Self> {
        let alone = graph.solve()?;
        let own = alone.white.map(|w| u8::from(*w));
        Ok(Self { graph, links, alone, layers: Vec::new(), painted: None, own })
    }

    /// Links to itself: a frame as it would follow if all stood still.
    pub(crate) fn staying(&self) -> Plane<u32> {
        let mask = &self.graph.mask;
        let own = |x: usize, y: usize| (y * mask.width() + x) as u32;
        Plane::from_fn(mask.width(), mask.height(), |x, y| match mask[(x, y)] {
            true => own(x, y),
            false => UNLINKED,
        })
    }

    /// The frame that follows if all stands still.
    pub(crate) fn stayed(&self) -> Self {
        Self { links: self.staying(), ..self.clone() }
    }

    /// How many layers are labelled.
    pub fn depth(&self) -> usize {
        self.layers.len().max(1)
    }

    /// How many labels a layer has.
    pub fn count(&self, layer: usize) -> usize {
        self.layers.get(layer).map_or(2, |l| l.count)
    }

    /// What each pixel of a layer pays for each label.
    pub fn prices(&self, layer: usize) -> &[i32] {
        let two = || self.graph.terminal.pixels().as_flattened();
        self.layers.get(layer).map_or_else(two, |l| &l.prices)
    }

    /// The labels of a layer by itself, and their energy.
    pub fn own(&self, layer: usize) -> (&Plane<u8>, i64) {
        self.layers.get(layer).map_or((&self.own, self.alone.cut), |l| (&l.alone, l.energy))
    }

    /// The energy of any labels of a layer, links left out.
    pub fn energy(&self, layer: usize, labels: &Plane<u8>) -> i64 {
        self.costs(self.prices(layer), layer).of(labels)
    }

    /// The label that each pixel of a layer would have without its neighbours.
    pub fn wanted(&self, layer: usize) -> Plane<u8> {
        let (w, h) = self.graph.mask.size();
        Plane::from_pixels(w, h, cheapest(self.prices(layer), self.count(layer)))
    }

    /// A layer's own labels as a picture by itself shows them: with round borders, without small
    /// pieces.
    pub fn finished(&self, layer: usize, knobs: &BinaryKnobs) -> Result<Plane<u8>> {
        self.costs(self.prices(layer), layer).finished(self.own(layer).0, knobs)
    }

    /// What labels of a layer cost by these prices.
    pub(crate) fn costs<'a>(&'a self, prices: &'a [i32], layer: usize) -> Costs<'a> {
        self.graph.costs(prices, self.count(layer))
    }

    /// Labels of a layer with what is painted as it is painted.
    pub(crate) fn kept(&self, layer: usize, labels: Plane<u8>) -> Plane<u8> {
        let Some(painted) = &self.painted else { return labels };
        let paint = self.layers.get(layer).map_or([0, 1], |l| l.paint);
        let (w, h) = labels.size();
        Plane::from_fn(w, h, |x, y| match painted[(x, y)].filter(|_| self.graph.mask[(x, y)]) {
            Some(white) => paint[usize::from(white)],
            None => labels[(x, y)],
        })
    }
}

/// Distances between labels without an order.
pub(crate) fn all_apart(count: usize) -> Vec<i32> {
    (0..count * count).map(|i| i32::from(i / count != i % count)).collect()
}

/// The label of the least price at each pixel.
pub(crate) fn cheapest(prices: &[i32], count: usize) -> Vec<u8> {
    let best = |prices: &[i32]| (0..count).min_by_key(|l| prices[*l]).unwrap_or(0) as u8;
    prices.chunks_exact(count.max(1)).map(best).collect()
}

/// The best labels without an order, each as far from any other, that expansions find.
pub(crate) fn expanded(graph: &Graph, data: &[i32], count: usize) -> Result<Labelling> {
    let apart = all_apart(count);
    let grid = label_grid(graph, data, count, Distance::Metric(&apart));
    Ok(expand(&grid, &cheapest(data, count)).map_err(too_large)?.labelling)
}

/// The pixels of a graph as a problem of labels.
pub(crate) fn label_grid<'a>(
    graph: &'a Graph,
    data: &'a [i32],
    count: usize,
    distance: Distance<'a>,
) -> LabelGrid<'a> {
    let (width, height) = graph.mask.size();
    let (mask, neighbour) = (graph.mask.pixels(), graph.neighbour.pixels());
    LabelGrid { width, height, labels: count, mask, data, neighbour, distance }
}

/// The sentence for prices that the cut cannot add up.
pub(crate) fn too_large(error: LabelError) -> Error {
    Error::setting("palette", error, "weights that the cut can add up")
}
