//! Drawings against what another program makes of them: SVG rasterized by resvg.

#![allow(clippy::unwrap_used)]

use chiaro_basis::random;
use chiaro_image::{Plane, filter};
use chiaro_ink::{
    Drawing, Fit, Layer, Mark, NOTHING, Partition, Placement, SEAM_WIDTH, Sheet, Soft, seams,
};
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

fn fills(partition: &Partition, soft: &Soft, place: &Placement) -> Vec<Layer> {
    let beneath = seams(partition, soft.labels()).into_iter().map(|(label, path)| Mark::Stroke {
        path: path.map(|p| place.at(p)),
        width: SEAM_WIDTH * place.scale,
        colour: COLOURS[usize::from(label)],
    });
    let beneath = Layer { name: "beneath".into(), marks: beneath.collect() };
    let mut layers = vec![beneath];
    for (label, colour) in COLOURS.into_iter().enumerate() {
        let own = partition.regions.iter().filter(|r| usize::from(r.label) == label);
        let outline = |region| {
            partition.outline(region).iter().map(|path| path.map(|p| place.at(p))).collect()
        };
        let marks = own.map(|r| Mark::Fill { outline: outline(r), colour });
        layers.push(Layer { name: format!("regions {label}"), marks: marks.collect() });
    }
    layers
}

/// What resvg makes of a drawing in the middle of each pixel: drawn `FINE` times as large, without
/// antialiasing.
fn rasterized(drawing: &Drawing, size: (usize, usize)) -> Plane<[u8; 3]> {
    const FINE: usize = 3;
    let svg = drawing.to_svg().replace("<path", "<path shape-rendering=\"crispEdges\"");
    let fine = drawn(&svg, (size.0 * FINE, size.1 * FINE));
    Plane::from_fn(size.0, size.1, |x, y| fine[(x * FINE + 1, y * FINE + 1)])
}

fn drawn(svg: &str, (w, h): (usize, usize)) -> Plane<[u8; 3]> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).unwrap();
    let mut map = tiny_skia::Pixmap::new(w as u32, h as u32).unwrap();
    let scale = w as f32 / tree.size().width();
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut map.as_mut());
    let pixels = map.data().as_chunks::<4>().0.iter().map(|&[r, g, b, _]| [r, g, b]);
    Plane::from_pixels(w, h, pixels.collect())
}

fn nearest(colour: [u8; 3]) -> u8 {
    let apart = |c: [f32; 4]| -> f32 {
        (0..3).map(|i| (f32::from(colour[i]) / 255.0 - c[i]).powi(2)).sum()
    };
    let all = (0..4).map(|k| (apart(COLOURS[k]), k as u8)).chain([(apart(BACKGROUND), NOTHING)]);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

/// Smoothed blobs and their drawing.
fn drawing(size: (usize, usize), count: u8, grain: f32, sigma: f32) -> (Soft, Drawing) {
    let (labels, mask) = blobs(size.0, size.1, count, grain);
    let soft = Soft::new(&labels, &mask, count, sigma);
    let how = Fit { tolerance: 0.08, corner: 0.7, blur: f64::from(sigma.max(0.5)), rounds: 0 };
    let partition = Partition::trace(soft.labels(), |p, q| soft.crossing(p, q), &how);
    let place = Sheet::default().place(size).unwrap();
    let layers = fills(&partition, &soft, &place);
    let drawing =
        Drawing { page: place.page, background: Some(BACKGROUND), layers, ..Drawing::default() };
    (soft, drawing)
}

/// The share of pixels whose label the drawing does not show.
fn wrong_share(size: (usize, usize), count: u8, grain: f32, sigma: f32) -> f64 {
    let (soft, drawing) = drawing(size, count, grain, sigma);
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
fn the_page_does_not_shine_through_shared_borders() {
    let (soft, drawing) = drawing((320, 240), 4, 10.0, 1.5);
    let shown = drawn(&drawing.to_svg(), (320, 240));
    let inside = |x: usize, y: usize| {
        (y - 3..=y + 3).all(|v| (x - 3..=x + 3).all(|u| soft.labels()[(u, v)] != NOTHING))
    };
    let within =
        (3..237).flat_map(|y| (3..317).map(move |x| (x, y))).filter(|&(x, y)| inside(x, y));
    for (x, y) in within {
        let [r, _, b] = shown[(x, y)];
        assert!(b.abs_diff(r) < 8, "{:?} at {x}, {y}", shown[(x, y)]);
    }
}

#[test]
fn odd_sizes_are_drawn() {
    for size in [(1, 1), (1, 400), (333, 2), (17, 31)] {
        assert!(wrong_share(size, 2, 2.0, 1.1) < 0.05, "{size:?}");
    }
}
