//! What benches of coded trees share: a scene's first frame, ready for light.

use chiaro_basis::Result;
use chiaro_basis::math::Vec3;
use chiaro_pbgi::Lit;
use chiaro_scene::{Frame, Poser, Scene};
use chiaro_trace::{Glow, Lamp, Lights, Surfaces, Tracer, daylight};

/// Hands on the first frame of a scene under its own light, or under a sun where it has none.
pub(crate) fn lit<R>(scene: &Scene, use_it: impl FnOnce(&Frame, Lit) -> Result<R>) -> Result<R> {
    let (playback, _) = scene.playback(&Default::default())?;
    let frame = Poser::new(scene).frame(0.0, &playback);
    let tracer = Tracer::new(scene, &frame);
    let surfaces = Surfaces::new(scene);
    let mut lights = Lights {
        lamps: Lamp::of_frame(&frame),
        glow: Glow::of(&tracer, &surfaces),
        ..Lights::default()
    };
    if lights.is_empty() {
        lights.lamps = vec![daylight(Vec3::new(0.4, 0.8, 0.3).normalize()).0];
    }
    use_it(&frame, Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights })
}
