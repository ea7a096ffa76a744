//! Pixels in groups that are close in position, whichever way they face.

use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;
use chiaro_trace::GBuffer;

/// Place of a pixel.
pub(crate) type Pixel = (usize, usize);

/// Covered pixels of a tile in groups that are close in position: a group much wider than its tile
/// of `side` pixels is cut at its widest gap.
pub(crate) fn clusters(buffer: &GBuffer, pixels: Vec<Pixel>, side: usize) -> Vec<Vec<Pixel>> {
    let (_, height) = buffer.size();
    let mut done = Vec::new();
    let mut open = vec![pixels];
    while let Some(group) = open.pop().filter(|g| !g.is_empty()) {
        let depth = group.iter().map(|p| buffer.depth[*p]).fold(f32::INFINITY, f32::min);
        let size = side as f32 * buffer.pose.pixel_size(depth, height as f32);
        let place = |p: &Pixel| Vec3::from(buffer.position[*p]);
        match halves(group, place, size) {
            Ok(group) => done.push(group),
            Err([first, second]) => open.extend([second, first]),
        }
    }
    done.iter_mut().for_each(|group| group.sort_by_key(|&(x, y)| (y, x)));
    done
}

/// The group as it was, or in two halves.
fn halves(
    group: Vec<Pixel>,
    place: impl Fn(&Pixel) -> Vec3,
    size: f32,
) -> Result<Vec<Pixel>, [Vec<Pixel>; 2]> {
    let bounds = Bounds::of(group.iter().map(&place));
    if bounds.radius() <= 1.5 * size || group.len() < 2 {
        return Ok(group);
    }
    let axis = (bounds.max - bounds.min).max_position();
    let mut sorted = group;
    sorted.sort_by(|a, b| place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(b)));
    let gap = |i: &usize| place(&sorted[*i])[axis] - place(&sorted[*i - 1])[axis];
    let widest = (1..sorted.len()).max_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(1);
    // Slanted surfaces have no gap: they are halved, and only when they are very long.
    let at = match gap(&widest) > 0.25 * (bounds.max - bounds.min)[axis] {
        true => widest,
        false if bounds.radius() > 4.0 * size => sorted.len() / 2,
        false => return Ok(sorted),
    };
    let rest = sorted.split_off(at);
    Err([sorted, rest])
}
