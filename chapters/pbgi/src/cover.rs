//! Covered sides show what covers them.
//!
//! A wall behind a door, or the back of that door, is seen by nothing but what is close by, and near rays look there. But
//! nodes hold it beside what covers it, which would look darker. Without it, surfaces would be thinner, and light
//! would come through their cracks. So a covered side sends what the outermost surface over it sends.

use crate::grid::SurfelGrid;
use crate::side::NARROW;
use crate::surfel::{Lit, Surfels};
use chiaro_basis::math::Vec3;
use chiaro_trace::{Ray, Sides};
use rayon::prelude::*;

/// Surfaces over a side, at most.
const MOST: usize = 8;

/// A covered side and what it sends: the index of its surfel, the side, radiance.
pub(crate) type Shown = (usize, usize, [f32; 3]);

/// What covered sides of `some` send, by the light of surfels of the same frame.
pub(crate) fn shown(
    lit: &Lit,
    some: &Surfels,
    (lit_up, grid): (&Surfels, &SurfelGrid),
) -> Vec<Shown> {
    let gap = NARROW * some.spacing;
    let one = |(index, covered): (usize, &[bool; 2])| {
        let surfel = some.all[index];
        (0..2).zip(*covered).filter(|(_, covered)| *covered).filter_map(move |(side, _)| {
            let normal = if side == 0 { surfel.normal } else { -surfel.normal };
            let at = outermost(lit, surfel.position, normal, gap)?;
            let (k, its) = grid.nearest(lit_up, at, normal)?;
            Some((index, side, lit_up.all[k as usize].radiance[its]))
        })
    };
    some.covered.par_iter().enumerate().flat_map_iter(one).collect()
}

/// Covered sides send that from now on.
pub(crate) fn show(surfels: &mut Surfels, shown: &[Shown]) {
    for (index, side, radiance) in shown {
        surfels.all[*index].radiance[*side] = *radiance;
    }
}

/// The last of the surfaces over a place along a normal, none farther from the one before than `gap`.
fn outermost(lit: &Lit, place: Vec3, normal: Vec3, gap: f32) -> Option<Vec3> {
    let mut at = None;
    for _ in 0..MOST {
        let origin = at.unwrap_or(place) + normal * lit.tracer.offset();
        let ray = Ray { origin, direction: normal, t_max: gap };
        let Some(hit) = lit.tracer.hit(&ray, Sides::Both) else { break };
        at = Some(origin + normal * hit.t);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::indirect::prepare;
    use crate::knob::LightKnobs;
    use crate::site::sites;
    use crate::surfel::Surfel;
    use crate::veil::tests::sheets;
    use chiaro_basis::Run;
    use chiaro_basis::math::vec3;
    use chiaro_scene::{Playback, Poser};
    use chiaro_trace::{Lamp, Lights, Surfaces, Tracer};

    #[test]
    fn a_wall_behind_a_door_shows_the_door_and_beside_it_stays_dark() {
        // A door of two sheets that the sun meets, a wall behind it, farther than what is buried, and what sees the door.
        let scene = sheets(1.0, &[(0.0, false), (0.02, true), (0.3, false), (-9.0, false)]);
        let frame = Poser::new(&scene).frame(0.0, &Playback::default());
        let tracer = Tracer::new(&scene, &frame);
        let surfaces = Surfaces::new(&scene);
        let lights = Lights { lamps: vec![Lamp::sun(vec3(1.0, 0.5, 0.0))], ..Lights::default() };
        let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
        let knobs = LightKnobs { bounces: 1, ..LightKnobs::default() };
        let all = sites(&scene, &frame, 5000);
        let found = prepare(lit, &all, &knobs, &Run::default()).unwrap().surfels;
        let door = found.all.iter().find(|s| s.position.x == 0.0).unwrap().radiance[0];
        assert!(door[0] > 0.1, "{door:?}");
        let (mut shown, mut inside, mut outside, mut border) = (0, 0, 0, 0);
        let in_shade = |s: &&Surfel| s.position.x > 0.2 && s.position.y > -0.8 && s.alive[0];
        for s in found.all.iter().filter(in_shade) {
            assert!(s.radiance[0] == door || s.radiance[0] == [0.0; 3], "{:?}", s.radiance[0]);
            let far = s.position.y.abs().max(s.position.z.abs());
            shown += usize::from(far < 0.5 && s.radiance[0] == door);
            inside += usize::from(far < 0.5);
            outside += usize::from(far > 0.98 && s.radiance[0] == door);
            border += usize::from(far > 0.98);
        }
        assert!(inside > 200 && 2 * shown > inside, "{shown} of {inside}");
        assert!(border > 20 && 10 * outside < border, "{outside} of {border}");
    }
}
