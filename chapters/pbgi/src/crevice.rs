//! How open what is seen is within a few pixels, where surfaces meet in a concave edge.
//!
//! A crevice narrower than a pixel is dark where a pixel's centre falls into it and unseen where it does
//! not: along an edge that would be dashes. So the samples of such pixels do not take the irradiance of
//! the centres around as it is, but times the openness of the sample over that of the centres.

use crate::surfel::Lit;
use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_trace::{GBuffer, Sequence, Sides, Vertex};

/// How far short rays look, in pixels.
const REACH: f32 = 3.0;
/// Short rays of a pixel's centre and of a sample.
const CENTRE_RAYS: u32 = 16;
const SAMPLE_RAYS: u32 = 4;
/// Two pixels meet within so many footprints, one above the other's plane by this share of one at
/// least, and turned by more than this cosine.
const MEET: f32 = 4.0;
const ABOVE: f32 = 0.25;
const TURNED: f32 = 0.8;
/// The most by which a sample is more open than the centres around.
const MOST: f32 = 3.0;

/// Openness at the centres of pixels near concave edges.
pub(crate) struct Crevices {
    concave: Plane<bool>,
    open: Plane<f32>,
}

impl Crevices {
    /// Finds the concave edges of a buffer.
    pub(crate) fn find(lit: &Lit, buffer: &GBuffer) -> Self {
        let (width, height) = buffer.size();
        let concave = buffer.over_covered(|x, y| is_concave(buffer, (x, y)));
        let open = Plane::from_fn(width, height, |x, y| {
            let near = neighbours(x, y).any(|(u, v)| concave.at(u, v) == Some(&true));
            if !(near && buffer.covered[(x, y)]) {
                return 1.0;
            }
            let at = Vertex::of_pixel(lit.tracer, buffer, (x, y));
            let footprint = buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
            openness(lit, &at, footprint, 0..CENTRE_RAYS)
        });
        Self { concave, open }
    }

    /// The openness of sample `index` of a pixel over that of the centres around, whose weighted mean is
    /// `around`; 1 away from concave edges.
    pub(crate) fn ratio(
        &self,
        lit: &Lit,
        pixel: (usize, usize),
        at: &Vertex,
        footprint: f32,
        (index, around): (u32, f32),
    ) -> f32 {
        if !self.concave[pixel] {
            return 1.0;
        }
        let rays = index * SAMPLE_RAYS..(index + 1) * SAMPLE_RAYS;
        let own = openness(lit, at, footprint, rays);
        (own / around.max(1e-3)).min(MOST)
    }

    /// Openness at a pixel's centre.
    pub(crate) fn open(&self, pixel: (usize, usize)) -> f32 {
        self.open[pixel]
    }
}

fn neighbours(x: usize, y: usize) -> impl Iterator<Item = (isize, isize)> {
    (0..9).map(move |i| (x as isize + i % 3 - 1, y as isize + i / 3 - 1))
}

/// Whether a surface rises beside a pixel's own within a few footprints.
fn is_concave(buffer: &GBuffer, (x, y): (usize, usize)) -> bool {
    let place = |p: (usize, usize)| Vec3::from(buffer.position[p]);
    let normal = |p: (usize, usize)| Vec3::from(buffer.geometric_normal[p]);
    let (_, height) = buffer.size();
    let footprint = buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
    let (p, n) = (place((x, y)), normal((x, y)));
    neighbours(x, y).any(|(u, v)| {
        if buffer.covered.at(u, v) != Some(&true) {
            return false;
        }
        let at = (u as usize, v as usize);
        let (offset, other) = (place(at) - p, normal(at));
        let above = offset.dot(n).max(-offset.dot(other));
        n.dot(other) < TURNED && offset.length() < MEET * footprint && above > ABOVE * footprint
    })
}

/// The share of short rays of cosine density that meet nothing.
fn openness(lit: &Lit, at: &Vertex, footprint: f32, rays: std::ops::Range<u32>) -> f32 {
    let sequence = Sequence::new(0);
    let count = rays.len() as f32;
    let free = rays.filter(|&i| {
        let direction = at.cosine_direction(sequence.point(i, 0));
        direction.dot(at.side) > 0.0
            && lit.tracer.hit(&at.ray(direction, REACH * footprint), Sides::Both).is_none()
    });
    free.count() as f32 / count
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::Run;
    use chiaro_scene::{Poser, demo};
    use chiaro_trace::{Lights, Surfaces, Tracer};

    /// In the Cornell box: what is far from edges is left as it is, and where the floor meets a block
    /// samples deep in the corner are darker than those in front of it.
    #[test]
    fn samples_deep_in_a_corner_are_darker_than_centres_in_front_of_it() {
        let scene = demo::scene("cornell-box").unwrap();
        let (playback, _) = scene.playback(&Default::default()).unwrap();
        let frame = Poser::new(&scene).frame(0.0, &playback);
        let tracer = Tracer::new(&scene, &frame);
        let (surfaces, lights) = (Surfaces::new(&scene), Lights::default());
        let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
        let (w, h) = (64, 64);
        let run = Run::default();
        let buffer = GBuffer::trace(&tracer, &surfaces, &frame.cameras[0], (w, h), &run).unwrap();
        let crevices = Crevices::find(&lit, &buffer);
        let (mut found, mut halves) = (0, 0);
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            if !buffer.covered[(x, y)] {
                continue;
            }
            let at = Vertex::of_pixel(&tracer, &buffer, (x, y));
            let footprint = buffer.pose.pixel_size(buffer.depth[(x, y)], h as f32);
            if !crevices.concave[(x, y)] {
                assert_eq!(crevices.ratio(&lit, (x, y), &at, footprint, (0, 1.0)), 1.0);
                continue;
            }
            // To the foot of a wall that is at right angles and not just beside the centre.
            let inside = |(u, v): &(isize, isize)| buffer.covered.at(*u, *v) == Some(&true);
            let wall = neighbours(x, y)
                .filter(inside)
                .map(|(u, v)| (u as usize, v as usize))
                .map(|p| (Vec3::from(buffer.position[p]), Vec3::from(buffer.geometric_normal[p])))
                .find(|(_, normal)| normal.dot(at.side).abs() < 0.1);
            let Some((place, normal)) = wall else { continue };
            let away = (at.position - place).dot(normal);
            let step = normal * (0.02 * footprint - away);
            let foot = Vertex { position: at.position + step, lifted: at.lifted + step, ..at };
            let above = tracer.hit(&foot.ray(at.side, footprint), Sides::Both);
            if away < 0.5 * footprint || above.is_some() {
                continue;
            }
            let [before, deep] = [&at, &foot].map(|at| openness(&lit, at, footprint, 0..64));
            assert!(deep <= before, "{deep} {before}");
            found += 1;
            // A wall hides half; a bevelled one less.
            halves += usize::from((0.25..0.6).contains(&deep));
        }
        assert!(found > 20 && 2 * halves > found, "{halves} of {found}");
    }
}
