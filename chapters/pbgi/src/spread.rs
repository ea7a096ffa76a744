//! [`Spread`]: the sites of a scene, not as a list but as a rule that makes any of them again.
//!
//! The same sites as [`sites`](crate::sites), which are evenly spaced along the running sum of the
//! triangles' areas; kept is a triangle's first number, 16 bytes a triangle that has any.

use crate::site::{self, Piece, Site};
use chiaro_basis::random;
use chiaro_scene::{Frame, Scene};

/// Where surfels lie, any number of them.
#[derive(Clone, Debug, Default)]
pub struct Spread {
    triangles: Vec<Triangle>,
    /// Sites in all.
    pub count: u64,
    /// Area of everything drawn, scene units squared.
    pub area: f64,
}

/// A triangle with sites.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    object: u32,
    face: u32,
    first: u64,
    share: f32,
}

impl Spread {
    /// About `count` sites, evenly over the area of everything drawn.
    pub fn of(scene: &Scene, frame: &Frame, count: u64) -> Self {
        let total: f64 = site::areas(scene, frame).map(|p| p.area).sum();
        if !(total > 0.0 && total.is_finite()) || count == 0 {
            return Self::default();
        }
        let spacing = total / count as f64;
        let mut all = Self { area: total, ..Self::default() };
        let mut before = 0.0;
        for Piece { object, face, area, triangle } in site::areas(scene, frame) {
            let first = all.count;
            before += area;
            all.count = ((before / spacing + 0.5).floor() as u64).min(count);
            if all.count > first {
                let share = (spacing / triangle) as f32;
                all.triangles.push(Triangle { object, face, first, share });
            }
        }
        all
    }

    /// Triangles that have sites.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// The object and face of such a triangle.
    pub fn triangle(&self, index: usize) -> (u32, u32) {
        (self.triangles[index].object, self.triangles[index].face)
    }

    /// The sites of such a triangle, with their numbers.
    pub fn sites(&self, index: usize) -> impl Iterator<Item = (u64, Site)> + '_ {
        let t = self.triangles[index];
        let end = self.triangles.get(index + 1).map_or(self.count, |next| next.first);
        (t.first..end).map(move |number| {
            let [u, v] = random::r2(number);
            let b = if u < v { [0.5 * u, v - 0.5 * u] } else { [u - 0.5 * v, 0.5 * v] };
            (number, Site { object: t.object, face: t.face, b, share: t.share })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_scene::{Poser, demo};

    #[test]
    fn a_spread_makes_the_sites_of_the_list() {
        let scene = demo::scene("cornell-box").unwrap();
        let (playback, _) = scene.playback(&Default::default()).unwrap();
        let frame = Poser::new(&scene).frame(0.0, &playback);
        for count in [7, 5000] {
            let spread = Spread::of(&scene, &frame, count);
            let all: Vec<Site> =
                (0..spread.triangles()).flat_map(|t| spread.sites(t).map(|s| s.1)).collect();
            assert_eq!(all, crate::sites(&scene, &frame, count as usize));
        }
        assert_eq!(Spread::of(&scene, &frame, 0).count, 0);
    }
}
