//! [`SurfelGrid`]: the surfel nearest to a point of a surface.
//!
//! Space is cut into cells three spacings wide, kept in a hash table; a query looks into the eight
//! cells around its point, its own first, so that whatever lies within one and a half spacings is found. Cells
//! farther than what was found are left out. What a query reads lies cell by cell.

use crate::surfel::Surfels;
use chiaro_basis::math::{Vec3, vec3};

/// Surfels by place.
pub struct SurfelGrid {
    cell: f32,
    /// Where each bucket begins; one entry more than buckets.
    starts: Vec<u32>,
    /// Surfels, bucket by bucket.
    entries: Vec<Entry>,
}

/// A surfel in a cell.
#[derive(Clone, Copy, Default)]
struct Entry {
    position: Vec3,
    normal: Vec3,
    index: u32,
}

/// Distances to cells are taken for that much less, against rounding.
const ROUNDED: f32 = 0.999;

/// How much a wrong normal counts: spacings squared for a right angle.
const TURN: f32 = 4.0;

impl SurfelGrid {
    /// The grid of surfels.
    pub fn new(surfels: &Surfels) -> Self {
        let cell = (3.0 * surfels.spacing).max(f32::MIN_POSITIVE);
        let buckets = (surfels.all.len() / 2).next_power_of_two().max(16);
        let bucket = |p: Vec3| bucket((p / cell).floor(), buckets);
        let mut starts = vec![0u32; buckets + 1];
        for s in &surfels.all {
            starts[bucket(s.position) + 1] += 1;
        }
        for i in 0..buckets {
            starts[i + 1] += starts[i];
        }
        let mut fill = starts.clone();
        let mut entries = vec![Entry::default(); surfels.all.len()];
        for (i, s) in surfels.all.iter().enumerate() {
            let b = bucket(s.position);
            entries[fill[b] as usize] =
                Entry { position: s.position, normal: s.normal, index: i as u32 };
            fill[b] += 1;
        }
        Self { cell, starts, entries }
    }

    /// The surfel nearest to a point on a surface seen from the side of `normal`, and which of its
    /// sides that is; `None` when none is near.
    pub fn nearest(&self, surfels: &Surfels, point: Vec3, normal: Vec3) -> Option<(u32, usize)> {
        self.nearest_where(surfels, point, normal, |s, side| surfels.all[s as usize].alive[side])
    }

    /// The surfel nearest to a point on a surface, whether its sides live or not.
    pub fn nearest_of_any(&self, surfels: &Surfels, point: Vec3, normal: Vec3) -> Option<u32> {
        self.nearest_where(surfels, point, normal, |_, _| true).map(|(k, _)| k)
    }

    fn nearest_where(
        &self,
        surfels: &Surfels,
        point: Vec3,
        normal: Vec3,
        counts: impl Fn(u32, usize) -> bool,
    ) -> Option<(u32, usize)> {
        let spacing2 = surfels.spacing * surfels.spacing;
        // A point a little farther than the cells reach may be found; it would depend on hashing.
        let mut best = (self.reach().powi(2), None);
        for (cell, distance2) in self.cells(point) {
            if ROUNDED * distance2 > best.0 {
                continue;
            }
            for s in self.bucket_of(cell) {
                let cosine = s.normal.dot(normal);
                let cost =
                    (s.position - point).length_squared() + TURN * spacing2 * (1.0 - cosine.abs());
                let side = usize::from(cosine < 0.0);
                if cost < best.0 && counts(s.index, side) {
                    best = (cost, Some((s.index, side)));
                }
            }
        }
        best.1
    }

    /// Calls `take` with every surfel within [`reach`](Self::reach) of a point, and its squared distance.
    pub fn each_near(&self, point: Vec3, mut take: impl FnMut(usize, f32)) {
        let reach2 = self.reach().powi(2);
        for (cell, _) in self.cells(point) {
            for s in self.bucket_of(cell) {
                let distance2 = (s.position - point).length_squared();
                // Other cells may share the bucket.
                if distance2 < reach2 && (s.position / self.cell).floor() == cell {
                    take(s.index as usize, distance2);
                }
            }
        }
    }

    /// One and a half spacings, scene units: everything nearer to a point is found.
    pub fn reach(&self) -> f32 {
        0.5 * self.cell
    }

    /// The cell of a point and the neighbours that are nearer, with their squared distances.
    fn cells(&self, point: Vec3) -> impl Iterator<Item = (Vec3, f32)> {
        let own = (point / self.cell).floor();
        let within = point / self.cell - own;
        let beside = Vec3::select(within.cmplt(Vec3::splat(0.5)), Vec3::NEG_ONE, Vec3::ONE);
        let away = self.cell * within.min(1.0 - within);
        (0..8).map(move |i| {
            let step = vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
            (own + step * beside, (step * away).length_squared())
        })
    }

    /// What lies in a cell, and in others of its bucket.
    fn bucket_of(&self, cell: Vec3) -> &[Entry] {
        let b = bucket(cell, self.starts.len() - 1);
        &self.entries[self.starts[b] as usize..self.starts[b + 1] as usize]
    }
}

fn bucket(cell: Vec3, buckets: usize) -> usize {
    let [x, y, z] = cell.to_array().map(|c| c as i64 as u64);
    let h = x.wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ y.wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ z.wrapping_mul(0x1656_67B1_9E37_79F9);
    ((h ^ h >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 32) as usize & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfel::Surfel;
    use chiaro_basis::random::{r2, unit};

    #[test]
    fn the_nearest_is_that_of_all() {
        let surfel = |i: u64| {
            let [u, v] = r2(i);
            // A floor and a wall.
            let (position, normal) = match i % 2 {
                0 => (vec3(u, 0.0, v), Vec3::Y),
                _ => (vec3(u, v, 0.0), Vec3::Z),
            };
            Surfel { position, normal, alive: [!i.is_multiple_of(5), true], ..Surfel::default() }
        };
        let all: Vec<Surfel> = (0..2000).map(surfel).collect();
        let surfels =
            Surfels { all, spacing: (2.0f32 / 2000.0).sqrt(), uneven: false, covered: Vec::new() };
        let grid = SurfelGrid::new(&surfels);
        let reach = (1.5 * surfels.spacing).powi(2);
        for i in 0..400 {
            let point = vec3(unit(1, i), 0.03 * unit(2, i), unit(3, i));
            let normal = vec3(0.0, 1.0, unit(4, i)).normalize();
            let cost = |s: &Surfel| {
                let turn = 1.0 - s.normal.dot(normal).abs();
                (s.position - point).length_squared() + TURN * surfels.spacing.powi(2) * turn
            };
            let lives = |s: &&Surfel| s.alive[usize::from(s.normal.dot(normal) < 0.0)];
            let least = surfels.all.iter().filter(lives).map(cost).fold(reach, f32::min);
            let found = grid.nearest(&surfels, point, normal);
            let found = found.map_or(reach, |(k, _)| cost(&surfels.all[k as usize]));
            assert!((found - least).abs() <= 1e-6 * reach, "{i}: {found} {least}");
        }
    }

    #[test]
    fn every_surfel_near_a_point_is_found_once() {
        let place = |i: u64| vec3(unit(1, i), 0.2 * unit(2, i), unit(3, i)) - 0.5;
        let surfel = |i| Surfel { position: place(i), normal: Vec3::Y, ..Surfel::default() };
        let surfels = Surfels {
            all: (0..3000).map(surfel).collect(),
            spacing: 0.05,
            uneven: false,
            covered: Vec::new(),
        };
        let grid = SurfelGrid::new(&surfels);
        for i in 5000..5200 {
            let near = |k: &usize| {
                (surfels.all[*k].position - place(i)).length_squared() < grid.reach().powi(2)
            };
            let all: Vec<usize> = (0..3000).filter(near).collect();
            let mut found = Vec::new();
            grid.each_near(place(i), |k, _| found.push(k));
            found.sort_unstable();
            assert_eq!(found, all);
        }
    }
}
