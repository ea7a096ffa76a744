//! Surfels and their tree, kept from frame to frame while nothing but the eye moves.
//!
//! Where something moves, the points keep their places on their triangles and the tree is built anew: that is
//! one part in thirty of a frame at most, so that a refit, whose spheres only grow, would gain nothing.
//!
//! Guaranteed: a picture has the same bits whether its points were kept or made anew.

use chiaro_basis::{Result, Run};
use chiaro_pbgi::surfel::Lit;
use chiaro_pbgi::{Focus, LightKnobs, Points, Prepared, Site, prepare, sites_by};
use chiaro_scene::{Frame, Shape};
use std::sync::{Arc, Mutex, PoisonError};

/// The points of the frame before, if there was one.
#[derive(Default)]
pub(crate) struct Kept {
    last: Mutex<Option<(Frame, Points)>>,
}

impl Kept {
    /// The points of a frame: those of the frame before where nothing has changed, else new ones at
    /// `sites`. Where meshes are made anew at each time, sites are chosen anew too.
    pub(crate) fn prepare<'a>(
        &self,
        lit: Lit<'a>,
        (places, focus): (&[Site], &Focus),
        knobs: &LightKnobs,
        run: &Run,
    ) -> Result<Prepared<'a>> {
        let frame = lit.tracer.frame;
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).take();
        match last {
            Some((before, points)) if stands_still(&before, frame) => Ok(points.again(lit, knobs)),
            _ if frame.shapes.iter().any(|s| s.remade.is_some()) => {
                let own = sites_by(knobs, lit.tracer.scene, frame, focus);
                prepare(lit, &own, knobs, run)
            }
            _ => prepare(lit, places, knobs, run),
        }
    }

    /// Keeps the points of a frame for the next.
    pub(crate) fn keep(&self, scene: Prepared<'_>) {
        let frame = scene.lit.tracer.frame.clone();
        let points = scene.into_points();
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some((frame, points));
    }
}

/// Whether surfaces and lamps are the same in two frames of a scene.
fn stands_still(a: &Frame, b: &Frame) -> bool {
    let objects = a.objects.iter().zip(&b.objects).all(|(a, b)| {
        a.shape == b.shape && a.world_from_shape == b.world_from_shape && a.mirrored == b.mirrored
    });
    objects
        && a.objects.len() == b.objects.len()
        && a.shapes.len() == b.shapes.len()
        && a.shapes.iter().zip(&b.shapes).all(|(a, b)| is_same(a, b))
        && format!("{:?}", a.lights) == format!("{:?}", b.lights)
}

fn is_same(a: &Shape, b: &Shape) -> bool {
    let remade = match (&a.remade, &b.remade) {
        (None, None) => true,
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        _ => false,
    };
    remade && a.positions == b.positions && a.normals == b.normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_scene::{Poser, demo};

    #[test]
    fn a_scene_stands_still_until_something_moves() {
        let scene = demo::scene("cornell-box").expect("the scene is there");
        let (playback, _) = scene.playback(&Default::default()).expect("nothing clashes");
        let poser = Poser::new(&scene);
        let (a, mut b) = (poser.frame(0.0, &playback), poser.frame(1.0, &playback));
        assert!(stands_still(&a, &b));
        b.objects[0].mirrored ^= true;
        assert!(!stands_still(&a, &b));
    }
}
