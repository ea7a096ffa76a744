//! Dead sides: the lit backs of walls and the insides of closed bodies must not enter the lobes, or
//! they shine through, and darken what they are mixed with.
//!
//! A few rays of cosine density leave the side. It is dead when it gets no direct light and
//! - nearly all rays meet backs of faces (the inside of a body), or
//! - none meets the front of a face (the outside of a room), or
//! - all end within a few spacings of surfels (a slab under a floor).
//!
//! Half of the rays are tried first; the others only when those disagree. Sides that get direct
//! light live: faces of a double-sided model may wind either way.

use crate::surfel::Surfel;
use chiaro_basis::math::Vec3;
use chiaro_trace::{Ray, Sequence, Sides, Tracer, cosine_direction};

/// Spacings within which all rays must end for a side to be buried.
const BURIED: f32 = 4.0;

/// What rays from a side met.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    rays: u32,
    fronts: u32,
    backs: u32,
    near: u32,
}

impl Met {
    fn is_dead(&self) -> bool {
        let nearly_all = self.rays - self.rays / 8;
        self.backs >= nearly_all || self.fronts == 0 || self.near == self.rays
    }

    fn is_sure(&self) -> bool {
        let clear = |n: u32| n == 0 || n == self.rays;
        clear(self.fronts) && clear(self.backs) && clear(self.near)
    }
}

/// Finds the dead sides of a lit surfel with at most `rays` rays a side.
pub fn test(tracer: &Tracer, surfel: &mut Surfel, spacing: f32, rays: u32, seed: u64) {
    let sequence = Sequence::new(!seed);
    for side in 0..2 {
        if surfel.radiance[side] != [0.0; 3] {
            continue;
        }
        let normal = if side == 0 { surfel.normal } else { -surfel.normal };
        let mut met = Met::default();
        for k in 0..rays {
            if k == rays.div_ceil(2) && met.is_sure() {
                break;
            }
            let direction = cosine_direction(normal, sequence.point(k, side as u32));
            meet(tracer, surfel.position, normal, direction, spacing, &mut met);
        }
        surfel.alive[side] = !met.is_dead();
    }
}

fn meet(
    tracer: &Tracer,
    position: Vec3,
    normal: Vec3,
    direction: Vec3,
    spacing: f32,
    met: &mut Met,
) {
    met.rays += 1;
    let origin = position + normal * tracer.offset();
    let ray = Ray { origin, direction, t_max: f32::INFINITY };
    let Some(hit) = tracer.hit(&ray, Sides::Both) else { return };
    if tracer.meets_front(&hit, direction) {
        met.fronts += 1;
    } else {
        met.backs += 1;
    }
    if hit.t < BURIED * spacing {
        met.near += 1;
    }
}
