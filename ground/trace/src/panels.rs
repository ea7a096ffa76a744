//! [`Panels`]: lamps that stand for pieces of shining surfaces, eight side by side.
//!
//! A room has some two dozen of them before every pixel. Their illuminance is E = I (n.o)+ (a d.-o + b |d.o| +
//! c |o|)+ / (o.o (o.o + s)), o the offset to the lamp, a, b, c what it shows of itself, and s its softening.

use crate::light::Lamp;
use chiaro_basis::math::Vec3;

/// Lamps that are looked at together.
const LANES: usize = 8;

/// The pieces among some lamps.
pub(crate) struct Panels {
    eights: Vec<Eight>,
}

/// Eight lamps; places that are free have no strength.
#[derive(Clone, Copy, Default)]
struct Eight {
    /// Which lamps they are.
    lamp: [usize; LANES],
    position: [[f32; LANES]; 3],
    direction: [[f32; LANES]; 3],
    strength: [f32; LANES],
    softening: [f32; LANES],
    /// Squares of their ranges.
    reach: [f32; LANES],
    /// What they show of themselves ([`crate::light::Shown`]).
    lean: [f32; LANES],
    flat: [f32; LANES],
    round: [f32; LANES],
}

impl Panels {
    /// Takes up those of the lamps that are pieces of surfaces.
    pub(crate) fn of(lamps: &[Lamp]) -> Self {
        let pieces: Vec<usize> = (0..lamps.len()).filter(|k| lamps[*k].patch.is_some()).collect();
        let eight = |some: &[usize]| {
            let mut eight = Eight::default();
            some.iter().enumerate().for_each(|(i, k)| eight.put(i, *k, &lamps[*k]));
            eight
        };
        Self { eights: pieces.chunks(LANES).map(eight).collect() }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.eights.is_empty()
    }

    /// Calls `each` with every lamp that lights a point of this normal, and its illuminance in lux.
    #[inline]
    pub(crate) fn light(&self, point: Vec3, normal: Vec3, mut each: impl FnMut(usize, f32)) {
        for eight in &self.eights {
            let light = eight.illuminance(point, normal);
            for (k, e) in eight.lamp.into_iter().zip(light).filter(|(_, e)| *e > 0.0) {
                each(k, e);
            }
        }
    }
}

impl Eight {
    fn put(&mut self, i: usize, k: usize, lamp: &Lamp) {
        let Some(patch) = lamp.patch else { return };
        self.lamp[i] = k;
        for axis in 0..3 {
            self.position[axis][i] = lamp.position[axis];
            self.direction[axis][i] = lamp.direction[axis];
        }
        self.strength[i] = lamp.strength;
        self.softening[i] = patch.softening();
        self.reach[i] = lamp.range * lamp.range;
        (self.lean[i], self.flat[i], self.round[i]) =
            (patch.shown.lean, patch.shown.flat, patch.shown.round);
    }

    fn illuminance(&self, point: Vec3, normal: Vec3) -> [f32; LANES] {
        let ([x, y, z], [u, v, w]) = (&self.position, &self.direction);
        let mut light = [0.0; LANES];
        for i in 0..LANES {
            let (dx, dy, dz) = (x[i] - point.x, y[i] - point.y, z[i] - point.z);
            let square = dx * dx + dy * dy + dz * dz;
            let here = (normal.x * dx + normal.y * dy + normal.z * dz).max(0.0);
            let there = -(u[i] * dx + v[i] * dy + w[i] * dz);
            let shown = self.lean[i] * there + self.flat[i] * there.abs();
            let there = (shown + self.round[i] * square.sqrt()).max(0.0);
            let e = self.strength[i] * here * there / (square * (square + self.softening[i]));
            light[i] = if square <= self.reach[i] { e } else { 0.0 };
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Patch, Shown};
    use chiaro_basis::random::unit;
    use chiaro_scene::LightKind;

    #[test]
    fn panels_light_as_their_lamps_do() {
        let vector = |i: u64| Vec3::from(std::array::from_fn(|c| unit(7, 3 * i + c as u64) - 0.5));
        let lamp = |i: u64| Lamp {
            position: 4.0 * vector(i),
            kind: LightKind::Point,
            strength: 1.0 + i as f32,
            range: if i % 4 == 1 { 2.0 } else { f32::INFINITY },
            patch: (i % 5 != 3).then_some(Patch {
                area: 0.3,
                shown: [Shown::FRONT, Shown::BOTH, Shown::of_normals(0.2, 0.4)][i as usize % 3],
                object: 0,
            }),
            ..Lamp::sun(vector(100 + i))
        };
        let lamps: Vec<Lamp> = (0..21).map(lamp).collect();
        let panels = Panels::of(&lamps);
        let mut lit = 0;
        for i in 0..200 {
            let (point, normal) = (2.0 * vector(1000 + i), vector(2000 + i).normalize());
            let mut found = [0.0; 21];
            panels.light(point, normal, |k, e| found[k] = e);
            for (k, lamp) in lamps.iter().enumerate() {
                let arrives = lamp.patch.and(lamp.arrival(point));
                let e = arrives.map_or(0.0, |a| a.strength * normal.dot(a.towards).max(0.0));
                let rounding = 1e-5 * e + 1e-6 * lamp.strength;
                assert!((found[k] - e).abs() <= rounding, "{k}: {} {e}", found[k]);
                lit += u32::from(e > 0.0);
            }
        }
        assert!(lit > 500);
    }
}
