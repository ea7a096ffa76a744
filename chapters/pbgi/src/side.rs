//! Dead sides: the lit backs of walls and the insides of closed bodies must not enter the lobes, or
//! they shine through, and darken what they are mixed with.
//!
//! A few rays of cosine density leave the side. It is dead when it gets no direct light and
//! - nearly all rays meet backs of faces (the inside of a body), or
//! - none meets the front of a face (the outside of a room), or
//! - all end within a few spacings of surfels (a slab under a floor).
//!
//! Whatever light it gets, a side is dead too when everything drawn lies on or behind its plane: no surface
//! sees it. Under a sky that is the underside of a ground and the outside of a room. And when little but a
//! lamp within a spacing is before it: what a double-sided one lights between itself and a ceiling is as bright as itself,
//! and rays that end above a surfel (`bright`) would end above the lamp.
//!
//! A dark side lives but is covered where nearly all rays end a few spacings above its plane: what it sends is told by `cover`.
//!
//! Half of the rays are tried first; the others only when those disagree. Sides that get direct
//! light live: faces of a double-sided model may wind either way. So do those that a ray leaves into a sky that
//! shines: the few samples of their light may have missed it, and were the dark ones among many to die, the others
//! would stand for them, too bright.

use crate::surfel::{Lit, Surfel};
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;
use chiaro_trace::{Ray, Sequence, Sides, cosine_direction};

/// Spacings within which all rays must end for a side to be buried.
const BURIED: f32 = 4.0;
/// Spacings above a side's plane, and from its place, within which nearly all rays must end for it to be covered.
pub(crate) const NARROW: f32 = 8.0;
const LONG: f32 = 16.0;

/// The share of rays from a side behind a lamp that go farther than a spacing, at most; the share that meets the lamp, at
/// least; how many times as many rays tell, where some do; and the most of such a lamp, the root of its area in radii
/// of the bounds.
const PASS: f32 = 0.4;
const MEET: f32 = 0.25;
const SURER: u32 = 4;
const LAMP: f32 = 0.5;

/// What rays from a side met.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    rays: u32,
    fronts: u32,
    backs: u32,
    near: u32,
    low: u32,
    /// Whether one left into a sky that shines there.
    sky: bool,
}

impl Met {
    fn is_dead(&self) -> bool {
        self.backs >= self.nearly_all() || self.fronts == 0 || self.near == self.rays
    }

    fn is_covered(&self) -> bool {
        !self.sky && !self.is_dead() && self.low >= self.nearly_all()
    }

    fn nearly_all(&self) -> u32 {
        self.rays - self.rays / 8
    }

    fn is_sure(&self) -> bool {
        let clear = |n: u32| n == 0 || n == self.rays;
        clear(self.fronts) && clear(self.backs) && clear(self.near) && self.low == 0
    }
}

/// How near what shines hides a side, scene units; 0 where it is no lamp in the scene but what lies over all of it.
pub fn close(lit: &Lit, bounds: &Bounds, spacing: f32) -> f32 {
    let area: f32 = lit.lights.glow.triangles().iter().map(|t| t.area).sum();
    let is_lamp = area > 0.0 && area.sqrt() < LAMP * bounds.radius();
    if is_lamp { spacing } else { 0.0 }
}

/// Finds the dead sides of a lit surfel with at most `rays` rays a side, told which the sky lights; `bounds` hold everything
/// drawn, `spacing` is that of surfels, and `close` where lamps hide sides. Which sides are covered.
pub fn test(
    (lit, by_sky): (&Lit, [bool; 2]),
    bounds: &Bounds,
    surfel: &mut Surfel,
    (spacing, close): (f32, f32),
    (rays, seed): (u32, u64),
) -> [bool; 2] {
    let mut covered = [false; 2];
    let sequence = Sequence::new(!seed);
    for (side, by_sky) in by_sky.into_iter().enumerate() {
        let normal = if side == 0 { surfel.normal } else { -surfel.normal };
        if above(bounds, surfel.position, normal) <= lit.tracer.offset() {
            surfel.alive[side] = false;
            continue;
        }
        if by_sky || surfel.radiance[side] != [0.0; 3] {
            let point = |k: u32| sequence.point(k, side as u32);
            surfel.alive[side] = close == 0.0
                || !is_behind_a_lamp(lit, (surfel.position, normal), close, rays, point);
            continue;
        }
        let mut met = Met::default();
        for k in 0..rays {
            if k == rays.div_ceil(2) && met.is_sure() {
                break;
            }
            let direction = cosine_direction(normal, sequence.point(k, side as u32));
            meet(lit, surfel.position, normal, direction, spacing, &mut met);
            if met.sky {
                break;
            }
        }
        surfel.alive[side] = met.sky || !met.is_dead();
        covered[side] = met.is_covered();
    }
    covered
}

/// How far bounds reach above a plane.
fn above(bounds: &Bounds, position: Vec3, normal: Vec3) -> f32 {
    let farthest = Vec3::select(normal.cmpgt(Vec3::ZERO), bounds.max, bounds.min);
    (farthest - position).dot(normal)
}

/// Whether little but a lamp is before a side: few of some rays go farther than a distance, and many meet what shines
/// within it. The first of them tell whether there is a lamp at all.
fn is_behind_a_lamp(
    lit: &Lit,
    (position, normal): (Vec3, Vec3),
    close: f32,
    rays: u32,
    point: impl Fn(u32) -> [f32; 2],
) -> bool {
    let (mut passed, mut lamps) = (0, 0);
    for k in 0..SURER * rays {
        if k == rays && lamps == 0 {
            return false;
        }
        let ray = ray(lit, position, normal, cosine_direction(normal, point(k)), close);
        match lit.tracer.hit(&ray, Sides::Both) {
            Some(hit) => lamps += u32::from(lit.lights.glow.find(&hit).is_some()),
            None => passed += 1,
        }
    }
    let all = (SURER * rays) as f32;
    (passed as f32) < PASS * all && lamps as f32 >= MEET * all
}

fn ray(lit: &Lit, position: Vec3, normal: Vec3, direction: Vec3, t_max: f32) -> Ray {
    Ray { origin: position + normal * lit.tracer.offset(), direction, t_max }
}

fn meet(lit: &Lit, position: Vec3, normal: Vec3, direction: Vec3, spacing: f32, met: &mut Met) {
    met.rays += 1;
    let ray = ray(lit, position, normal, direction, f32::INFINITY);
    let Some(hit) = lit.tracer.hit(&ray, Sides::Both) else {
        let sky = lit.lights.sky.as_deref();
        met.sky = sky.is_some_and(|s| s.radiance(direction) != [0.0; 3]);
        return;
    };
    if lit.tracer.meets_front(&hit, direction) {
        met.fronts += 1;
    } else {
        met.backs += 1;
    }
    let height = hit.t * direction.dot(normal);
    met.low += u32::from(height < NARROW * spacing && hit.t < LONG * spacing);
    if hit.t < BURIED * spacing {
        met.near += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_reach_above_planes_inside_them_and_not_above_their_own() {
        let bounds = Bounds { min: Vec3::NEG_ONE, max: Vec3::new(1.0, 3.0, 1.0) };
        let low = Vec3::new(0.3, -1.0, 0.2);
        assert_eq!(above(&bounds, low, Vec3::NEG_Y), 0.0);
        assert_eq!(above(&bounds, low, Vec3::Y), 4.0);
        assert!(above(&bounds, low, Vec3::new(0.01, -1.0, 0.0).normalize()) > 0.0);
    }
}
