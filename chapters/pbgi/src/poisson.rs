//! Surfels at a least distance from each other (thesis, 6.3.2, Sampling): a Poisson-disk set on the surface.
//!
//! 1. Several times as many candidates are spread evenly, as ever ([`sites`]).
//! 2. In an order that is random but fixed, a candidate is kept unless one that was kept before lies
//!    within the distance, on a side that faces likewise: sheets of a thin wall do not see each other.
//! 3. Every candidate gives its area to the kept one nearest to it: areas sum up to the surface's.
//!
//! Guaranteed: a candidate that is not kept lies within the distance of one that is, so that no area is
//! lost. About `count` surfels come out, as many as random packing lets in: within a tenth on surfaces that are wide
//! against the distance.

use crate::site::{Site, sites};
use chiaro_basis::math::{Mat3, Vec3};
use chiaro_basis::random;
use chiaro_scene::{Frame, Scene};
use std::collections::HashMap;

/// Candidates for each surfel.
const CANDIDATES: usize = 8;
/// The share of a surface that discs of half the distance cover when no more fit in at random.
const PACKED: f32 = 0.5;
/// The least cosine between normals of points that keep their distance.
const ALIKE: f32 = 0.5;

/// A candidate in the scene.
struct Candidate {
    position: Vec3,
    normal: Vec3,
    area: f32,
    triangle: f32,
}

/// About `count` sites at a least distance from each other.
pub fn poisson_sites(scene: &Scene, frame: &Frame, count: usize) -> Vec<Site> {
    let all = sites(scene, frame, CANDIDATES * count);
    let places: Vec<Candidate> = all.iter().map(|s| Candidate::of(scene, frame, s)).collect();
    let area: f64 = places.iter().map(|p| f64::from(p.area)).sum();
    let distance =
        (4.0 * PACKED * area as f32 / (std::f32::consts::PI * count.max(1) as f32)).sqrt();
    if !(distance > 0.0 && distance.is_finite()) {
        return Vec::new();
    }
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    order.sort_by_key(|&i| random::hash(0x9015, i.into()));
    let mut kept = Kept { cell: distance, cells: HashMap::new() };
    for i in order {
        if kept.nearest(&places, &places[i as usize], distance).is_none() {
            kept.add(&places, i);
        }
    }
    let mut areas: HashMap<u32, f32> = HashMap::new();
    for place in &places {
        if let Some(k) = kept.nearest(&places, place, distance) {
            *areas.entry(k).or_default() += place.area;
        }
    }
    let mut chosen: Vec<(u32, f32)> = areas.into_iter().collect();
    chosen.sort_unstable_by_key(|(i, _)| *i);
    let site = |(i, area): (u32, f32)| Site {
        share: area / places[i as usize].triangle,
        ..all[i as usize]
    };
    chosen.into_iter().map(site).collect()
}

impl Candidate {
    fn of(scene: &Scene, frame: &Frame, site: &Site) -> Self {
        let object = &frame.objects[site.object as usize];
        let shape = &frame.shapes[object.shape];
        let m = &object.world_from_shape;
        let [a, b, c] = shape.mesh_in(scene).triangles[site.face as usize]
            .map(|v| m.transform_point3(shape.positions[v as usize]));
        let [u, v] = site.b;
        let position = Mat3::from_cols(a, b, c) * Vec3::new(1.0 - u - v, u, v);
        let cross = (b - a).cross(c - a);
        let triangle = 0.5 * cross.length();
        Self {
            position,
            normal: cross.normalize_or(Vec3::Y),
            area: site.share * triangle,
            triangle,
        }
    }
}

/// What was kept, by place.
struct Kept {
    cell: f32,
    cells: HashMap<[i32; 3], Vec<u32>>,
}

impl Kept {
    fn key(&self, p: Vec3) -> [i32; 3] {
        (p / self.cell).floor().as_ivec3().to_array()
    }

    fn add(&mut self, places: &[Candidate], index: u32) {
        let key = self.key(places[index as usize].position);
        self.cells.entry(key).or_default().push(index);
    }

    /// The one nearest to a candidate within a distance.
    fn nearest(&self, places: &[Candidate], to: &Candidate, within: f32) -> Option<u32> {
        let reach = (within / self.cell).ceil() as i32;
        let [x, y, z] = self.key(to.position);
        let mut best = (within * within, None);
        for dz in -reach..=reach {
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let cell = [x.saturating_add(dx), y.saturating_add(dy), z.saturating_add(dz)];
                    for &k in self.cells.get(&cell).into_iter().flatten() {
                        let p = &places[k as usize];
                        let d = (p.position - to.position).length_squared();
                        let alike = p.normal.dot(to.normal) > ALIKE;
                        if alike && (d < best.0 || d == best.0 && best.1.is_none_or(|b| k < b)) {
                            best = (d, Some(k));
                        }
                    }
                }
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::areas;
    use chiaro_scene::{Poser, demo};

    #[test]
    fn sites_keep_their_distance_and_stand_for_all_of_the_area() {
        let scene = demo::scene("cornell-box").unwrap();
        let (playback, _) = scene.playback(&Default::default()).unwrap();
        let frame = Poser::new(&scene).frame(0.0, &playback);
        let found = poisson_sites(&scene, &frame, 3000);
        assert!((2600..3400).contains(&found.len()), "{}", found.len());
        let places: Vec<Candidate> =
            found.iter().map(|s| Candidate::of(&scene, &frame, s)).collect();
        let total: f64 = areas(&scene, &frame).map(|p| p.area).sum();
        let sum: f64 = places.iter().map(|p| f64::from(p.area)).sum();
        assert!((sum / total - 1.0).abs() < 0.01, "{sum} {total}");
        let distance = (4.0 * PACKED * total as f32 / (std::f32::consts::PI * 3000.0)).sqrt();
        for (i, p) in places.iter().enumerate() {
            let near = places[i + 1..].iter().filter(|q| p.normal.dot(q.normal) > ALIKE);
            let nearest =
                near.map(|q| p.position.distance(q.position)).fold(f32::INFINITY, f32::min);
            assert!(nearest > 0.99 * distance, "{nearest} {distance}");
        }
        assert!(poisson_sites(&scene, &frame, 0).is_empty());
    }
}
