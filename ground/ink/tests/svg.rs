//! Drawings against what another program makes of them: SVG rasterized by resvg.

#![allow(clippy::unwrap_used)]

use chiaro_basis::random;
use chiaro_image::{Plane, filter};
use chiaro_ink::{Drawing, Fit, Layer, Mark, NOTHING, Partition, Placement, Sheet, Soft};
use resvg::{tiny_skia, usvg};

const COLOURS: [[f32; 4]; 4] =
    [[0.0, 0.0, 0.0, 1.0], [1.0; 4], [0.4, 0.4, 0.4, 1.0], [0.8, 0.8, 0.8, 1.0]];
const BACKGROUND: [f32; 4] = [0.0, 0.0, 1.0, 1.0];

/// Soft blobs of `count` labels on a disc.
fn blobs(width: usize, height: usize, count: u8, grain: f32) -> (Plane<u8>, Plane<bool>) {
    let noise = Plane::from_fn(width, height, |x, y| random::unit(7, (y * width + x) as u64));
    let everywhere = noise.map(|_| true);
    let smooth = filter::gaussian_masked(&noise, &everywhere, grain);
    let spread = 0.9 / grain;
    let label = |v: f32| {
        let level = ((v - 0.5) / spread + 0.5) * f32::from(count);
        (level.floor() as i32).clamp(0, i32::from(count) - 1) as u8
    };
    let (cx, cy) = (0.5 * width as f32, 0.55 * height as f32);
    let mask = Plane::from_fn(width, height, |x, y| {
        (x as f32 - cx).hypot(y as f32 - cy) < 0.55 * width as f32
    });
    (smooth.map(|v| label(*v)), mask)
}

fn fills(partition: &Partition, place: &Placement) -> Vec<Layer> {
    let marks = partition.regions.iter().filter(|r| r.label != NOTHING).map(|region| Mark::Fill {
        outline: partition.outline(region).iter().map(|path| path.map(|p| place.at(p))).collect(),
        colour: COLOURS[region.label as usize],
    });
    vec![Layer { name: "regions".into(), marks: marks.collect() }]
}

/// What resvg makes of a drawing in the middle of each pixel: drawn `FINE` times as large, without
/// antialiasing.
fn rasterized(drawing: &Drawing, size: (usize, usize)) -> Plane<[u8; 3]> {
    const FINE: usize = 3;
    let svg = drawing.to_svg().replace("<path", "<path shape-rendering=\"crispEdges\"");
    let tree = usvg::Tree::from_str(&svg, &usvg::Options::default()).unwrap();
    let (w, h) = (size.0 * FINE, size.1 * FINE);
    let mut map = tiny_skia::Pixmap::new(w as u32, h as u32).unwrap();
    let scale = w as f32 / tree.size().width();
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut map.as_mut());
    let data = map.data();
    Plane::from_fn(size.0, size.1, |x, y| {
        let i = 4 * ((y * FINE + 1) * w + x * FINE + 1);
        [data[i], data[i + 1], data[i + 2]]
    })
}

fn nearest(colour: [u8; 3]) -> u8 {
    let apart = |c: [f32; 4]| -> f32 {
        (0..3).map(|i| (f32::from(colour[i]) / 255.0 - c[i]).powi(2)).sum()
    };
    let all = (0..4).map(|k| (apart(COLOURS[k]), k as u8)).chain([(apart(BACKGROUND), NOTHING)]);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

/// The share of pixels whose label the drawing does not show.
fn wrong_share(size: (usize, usize), count: u8, grain: f32, sigma: f32) -> f64 {
    let (labels, mask) = blobs(size.0, size.1, count, grain);
    let soft = Soft::new(&labels, &mask, count, sigma);
    let how = Fit { tolerance: 0.08, corner: 0.7, blur: f64::from(sigma.max(0.5)) };
    let partition = Partition::trace(soft.labels(), |p, q| soft.crossing(p, q), &how);
    let place = Sheet::default().place(size).unwrap();
    let layers = fills(&partition, &place);
    let drawing =
        Drawing { page: place.page, background: Some(BACKGROUND), layers, ..Drawing::default() };
    let shown = rasterized(&drawing, size);
    let pairs = shown.pixels().iter().zip(soft.labels().pixels());
    pairs.filter(|(c, l)| nearest(**c) != **l).count() as f64 / shown.len() as f64
}

#[test]
fn regions_cover_the_pixels_of_their_labels() {
    for (count, grain, sigma) in [(2, 8.0, 1.1), (4, 10.0, 1.5), (3, 6.0, 0.0)] {
        let wrong = wrong_share((320, 240), count, grain, sigma);
        assert!(wrong < 0.002, "{count} labels, grain {grain}: {:.3} % differ", 100.0 * wrong);
    }
}

#[test]
fn odd_sizes_are_drawn() {
    for size in [(1, 1), (1, 400), (333, 2), (17, 31)] {
        assert!(wrong_share(size, 2, 2.0, 1.1) < 0.05, "{size:?}");
    }
}
