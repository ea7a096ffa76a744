//! Direct light: the scene's lamps, or a key light that flatters the shape.

use crate::sky::SkySample;
use chiaro_basis::math::Vec3;
use chiaro_image::colour::luminance;
use chiaro_scene::{Frame, LightKind, Pose};

/// One lamp in world space.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    /// Its place; unused by parallel light.
    pub position: Vec3,
    /// Unit vector along which it shines; unused by point lights.
    pub direction: Vec3,
    /// What shines.
    pub kind: LightKind,
    /// Luminous strength: lux for parallel light, candela for the others.
    pub strength: f32,
    /// Linear RGB of luminance 1.
    pub colour: [f32; 3],
    /// Beyond this distance it is dark.
    pub range: f32,
    /// Of a lamp that stands for a piece of a shining surface: that piece. It shines with the
    /// cosine of the angle to `direction`.
    pub patch: Option<Patch>,
}

/// A piece of a shining surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// In scene units squared.
    pub area: f32,
    /// What it shows of itself.
    pub shown: Shown,
    /// Index into [`chiaro_scene::Frame::objects`].
    pub object: u32,
}

impl Patch {
    /// What is added to the square of distances: half of what a disc on its axis asks for, so that what
    /// touches it is not burnt.
    pub(crate) fn softening(self) -> f32 {
        0.5 * self.area * std::f32::consts::FRAC_1_PI
    }
}

/// The area that a surface shows to places at an angle from its direction, over its whole area: `lean` c +
/// `flat` |c| + `round`, c the cosine of the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// What it shows to one side more than to the other.
    pub lean: f32,
    /// What a flat one shows to both.
    pub flat: f32,
    /// What it shows to all sides alike.
    pub round: f32,
}

impl Shown {
    /// A flat piece's one side.
    pub const FRONT: Self = Self { lean: 0.5, flat: 0.5, round: 0.0 };
    /// A flat piece's two sides.
    pub const BOTH: Self = Self { lean: 0.0, flat: 1.0, round: 0.0 };

    /// By the mean of the cosines between a surface's normals and its direction, and the mean of their squares,
    /// of one side that shines: a ball's 0 and 1/3, a hemisphere's 1/2 and 1/3.
    pub(crate) fn of_normals(cosine: f32, square: f32) -> Self {
        // (c + |c|) / 2 is what a small piece shows; of |c| the mean is 1/2 where pieces face all ways.
        let round = (1.5 * (1.0 - square)).clamp(0.0, 1.0);
        Self { lean: 0.5 * cosine, flat: 0.5 * (1.0 - round), round: 0.25 * round }
    }

    /// The same of two sides, whatever their mean.
    pub(crate) fn of_both(square: f32) -> Self {
        let one = Self::of_normals(0.0, square);
        Self { lean: 0.0, flat: 2.0 * one.flat, round: 2.0 * one.round }
    }

    /// At a cosine.
    pub(crate) fn at(self, cosine: f32) -> f32 {
        (self.lean * cosine + self.flat * cosine.abs() + self.round).max(0.0)
    }
}

/// Light that arrives at a point.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Unit vector to the lamp.
    pub towards: Vec3,
    /// Distance to the lamp, infinite for parallel light.
    pub distance: f32,
    /// Illuminance on a surface that faces the lamp, lux.
    pub strength: f32,
    /// Whether a surface shines there, which a ray would meet at its end.
    pub from_surface: bool,
}

/// The key light of scenes that have none, in the axes of the camera: from above, on the left, on
/// the viewer's side (x right, y up, z to the viewer).
pub const KEY_FROM: [f32; 3] = [-0.55, 0.65, 0.52];

impl Lamp {
    /// The frame's lamps, those of no strength left out.
    pub fn of_frame(frame: &Frame) -> Vec<Self> {
        let lamps = frame.lights.iter().map(|(light, world)| Self {
            position: world.translation.into(),
            direction: world.transform_vector3(-Vec3::Z).normalize_or(-Vec3::Y),
            kind: light.kind,
            strength: light.intensity * luminance(light.colour),
            colour: light.colour.map(|c| c / luminance(light.colour)),
            range: light.range,
            patch: None,
        });
        lamps.filter(|l| l.strength > 0.0 && l.strength.is_finite()).collect()
    }

    /// The key light for a camera.
    pub fn key(pose: &Pose) -> Self {
        let [x, y, z] = KEY_FROM;
        let from = pose.right * x + pose.up * y - pose.forward * z;
        Self::sun(-from.normalize())
    }

    /// Parallel light of unit strength along `direction`.
    pub fn sun(direction: Vec3) -> Self {
        Self {
            position: Vec3::ZERO,
            direction: direction.normalize_or(-Vec3::Y),
            kind: LightKind::Directional,
            strength: 1.0,
            colour: [1.0; 3],
            range: f32::INFINITY,
            patch: None,
        }
    }

    /// The parallel light of a direction drawn from a sky, one of so many.
    pub fn of_sky(sample: &SkySample, count: f32) -> Self {
        let y = luminance(sample.radiance);
        let strength = y / sample.density / count;
        let colour = sample.radiance.map(|c| c / y);
        Self { strength, colour, ..Self::sun(-sample.towards) }
    }

    /// The light that arrives at `point` if nothing is in the way; `None` where it is dark.
    pub fn arrival(&self, point: Vec3) -> Option<Arrival> {
        if self.kind == LightKind::Directional {
            let towards = -self.direction;
            let (distance, strength) = (f32::INFINITY, self.strength);
            return Some(Arrival { towards, distance, strength, from_surface: false });
        }
        let offset = self.position - point;
        let distance = offset.length();
        if distance == 0.0 || distance > self.range {
            return None;
        }
        let towards = offset / distance;
        let strength = self.strength / self.square(distance) * self.cone(-towards);
        let from_surface = self.patch.is_some();
        (strength > 0.0).then_some(Arrival { towards, distance, strength, from_surface })
    }

    /// Whether it stands before a surface and shines to its side: elsewhere no light arrives.
    pub(crate) fn is_before(&self, point: Vec3, normal: Vec3) -> bool {
        if self.kind == LightKind::Directional {
            return normal.dot(self.direction) < 0.0;
        }
        let offset = self.position - point;
        let shines = |p: Patch| p.shown.at(-self.direction.dot(offset.normalize_or_zero())) > 0.0;
        normal.dot(offset) > 0.0 && self.patch.is_none_or(shines)
    }

    /// What strength is divided by: the square of the distance, and a little more near a patch.
    fn square(&self, distance: f32) -> f32 {
        distance * distance + self.patch.map_or(0.0, Patch::softening)
    }

    /// The spot's angular falloff (KHR_lights_punctual), a patch's cosine, 1 for point lights.
    fn cone(&self, outward: Vec3) -> f32 {
        if let Some(patch) = self.patch {
            return patch.shown.at(self.direction.dot(outward));
        }
        let LightKind::Spot { inner, outer } = self.kind else { return 1.0 };
        let (full, dark) = (inner.cos(), outer.cos());
        let t = (self.direction.dot(outward) - dark) / (full - dark).max(1e-4);
        t.clamp(0.0, 1.0).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;

    #[test]
    fn strength_falls_with_the_square_of_the_distance_inside_the_range() {
        let lamp = Lamp { kind: LightKind::Point, strength: 8.0, range: 3.0, ..Lamp::sun(Vec3::X) };
        assert_eq!(lamp.arrival(vec3(0.0, 2.0, 0.0)).unwrap().strength, 2.0);
        assert!(lamp.arrival(vec3(0.0, 3.5, 0.0)).is_none());
    }

    #[test]
    fn light_arrives_from_lamps_before_the_surface_alone() {
        let patch = |shown| Some(Patch { area: 1.0, shown, object: 0 });
        let sun = Lamp::sun(-Vec3::Y);
        let point = Lamp { kind: LightKind::Point, position: vec3(0.3, 2.0, 0.1), ..sun };
        let lamps = [
            sun,
            point,
            Lamp { patch: patch(Shown::FRONT), ..point },
            Lamp { patch: patch(Shown::BOTH), ..point },
        ];
        for lamp in lamps {
            for (place, normal) in
                [(0.0, Vec3::Y), (3.0, Vec3::Y), (0.0, -Vec3::Y), (3.0, -Vec3::Y)]
            {
                let at = vec3(0.0, place, 0.0);
                let arrives = lamp.arrival(at).is_some_and(|a| normal.dot(a.towards) > 0.0);
                assert_eq!(lamp.is_before(at, normal), arrives, "{lamp:?} {place} {normal}");
            }
        }
    }

    #[test]
    fn what_balls_and_halves_show_is_exact() {
        let close = |shown: Shown, cosine: f32, exact: f32| {
            assert!((shown.at(cosine) - exact).abs() < 1e-6, "{shown:?} {cosine}");
        };
        for i in 0..=20 {
            let c = i as f32 / 10.0 - 1.0;
            close(Shown::of_normals(1.0, 1.0), c, c.max(0.0));
            close(Shown::of_both(1.0), c, c.abs());
            close(Shown::of_normals(0.0, 1.0 / 3.0), c, 0.25);
            close(Shown::of_both(1.0 / 3.0), c, 0.5);
            // Half a ball seen at an angle: half a disc, and as much of its rim's half as the cosine says.
            close(Shown::of_normals(0.5, 1.0 / 3.0), c, 0.25 * (1.0 + c));
        }
    }

    #[test]
    fn spots_are_full_inside_and_dark_outside() {
        let kind = LightKind::Spot { inner: 0.3, outer: 0.6 };
        let lamp = Lamp { kind, ..Lamp::sun(-Vec3::Y) };
        let at =
            |angle: f32| lamp.arrival(vec3(angle.tan(), -1.0, 0.0)).map_or(0.0, |a| a.strength);
        assert_eq!(at(0.0), 1.0);
        assert!(at(0.45) < at(0.3) && at(0.45) > 0.0);
        assert_eq!(at(0.7), 0.0);
    }
}
