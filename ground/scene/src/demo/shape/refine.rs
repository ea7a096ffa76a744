//! Finer triangles where they are wanted, without T-junctions.

use super::form::Form;
use chiaro_basis::math::Vec3;
use std::collections::BTreeMap;

impl Form {
    /// Every edge longer than `longest` (of its middle) cut in two, once; triangles follow with
    /// one, two or three cuts. Normals must be made anew.
    pub(crate) fn refined(self, longest: impl Fn(Vec3) -> f32) -> Self {
        let Self { mut positions, triangles, .. } = self;
        let mut middles: BTreeMap<(u32, u32), Option<u32>> = BTreeMap::new();
        let mut fine = Vec::with_capacity(2 * triangles.len());
        for t in triangles {
            let cut = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (p, q) = (positions[a as usize], positions[b as usize]);
                    let middle = 0.5 * (p + q);
                    (p.distance(q) > longest(middle)).then(|| {
                        positions.push(middle);
                        positions.len() as u32 - 1
                    })
                })
            };
            divide(t, cut, &mut fine);
        }
        Self { positions, normals: Vec::new(), triangles: fine }
    }
}

/// A triangle cut at the middles that its edges have.
fn divide(t: [u32; 3], mut cut: impl FnMut(u32, u32) -> Option<u32>, out: &mut Vec<[u32; 3]>) {
    let [a, b, c] = t;
    let cuts = [cut(a, b), cut(b, c), cut(c, a)];
    // Turned so that the cuts stand at the same edges in every case of one kind.
    let turned = |k: usize| (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
    match cuts {
        [None, None, None] => out.push(t),
        [Some(ab), Some(bc), Some(ca)] => {
            out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        _ => {
            let first = (0..3).find(|&k| cuts[k].is_some() && cuts[(k + 2) % 3].is_none());
            let k = first.expect("one or two edges of three are cut");
            let (a, b, c) = turned(k);
            match (cuts[k], cuts[(k + 1) % 3]) {
                (Some(ab), Some(bc)) => out.extend([[a, ab, c], [ab, bc, c], [ab, b, bc]]),
                (Some(ab), None) => out.extend([[a, ab, c], [ab, b, c]]),
                (None, _) => out.push([a, b, c]),
            }
        }
    }
}
