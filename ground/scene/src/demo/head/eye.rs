//! The eyes: lids in the skin, and balls with carved pupils that look about.

use super::super::motion::turning;
use super::super::shape::field::{carve, common, merge, sphere};
use super::super::shape::{Bundle, Form, Profile, lathe, strand};
use super::super::stage::{Stage, placed};
use crate::NodeId;
use chiaro_basis::math::{DQuat, Vec2, Vec3, dvec3, vec2, vec3};

/// The middle of the left eyeball.
const MIDDLE: Vec3 = Vec3::new(0.305, 1.12, 0.612);
/// The eyeball's radius.
const BALL: f32 = 0.135;

/// The lids of one eye.
pub(super) struct Lids {
    fold: Bundle,
}

impl Lids {
    /// The lids.
    pub(super) fn new() -> Self {
        let fold = [
            (vec3(-0.150, 0.030, 0.150), 0.004),
            (vec3(-0.070, 0.098, 0.146), 0.008),
            (vec3(0.030, 0.108, 0.140), 0.008),
            (vec3(0.120, 0.062, 0.100), 0.008),
            (vec3(0.180, -0.005, 0.075), 0.004),
        ];
        Self { fold: Bundle::new(&[strand(&fold, 5)], 0.045) }
    }

    /// The head with eyelids; `p` has x >= 0.
    pub(super) fn on(&self, p: Vec3, head: f32) -> f32 {
        let e = p - MIDDLE;
        if e.length() > 0.45 {
            return head;
        }
        let lids = sphere(e, Vec3::ZERO, BALL + 0.030);
        let d = merge(head, lids, 0.075);
        let d = -self.fold.merged(e, -d);
        carve(d, opening(e), 0.018)
    }
}

/// The almond between the lids, a distance across the view, in front of the ball's middle.
fn opening(e: Vec3) -> f32 {
    let tilted = vec2(e.x, e.y - 0.12 * e.x);
    let disc = |c: Vec2, r: f32| tilted.distance(c) - r;
    let upper = disc(vec2(-0.008, -0.112), 0.174);
    let lower = disc(vec2(0.012, 0.132), 0.190);
    common(common(upper, lower, 0.03), 0.072 - e.z, 0.02)
}

/// Both eyeballs; they look where the head will turn.
pub(super) fn put_eyes(stage: &mut Stage, bust: NodeId, yaw: impl Fn(f64) -> f64) {
    let white = stage.material("eye white", 0xf1ece4, 0.2, 0.0);
    let iris = stage.material("iris", 0x4c6b57, 0.3, 0.0);
    let pupil = stage.material("pupil", 0x0c0b0a, 0.2, 0.0);
    let [inner, ring, outer] = split(eyeball());
    let mesh = stage.mesh("eyeball", [(outer, white), (ring, iris), (inner, pupil)]);
    for (name, sign) in [("left eye", 1.0), ("right eye", -1.0)] {
        let at = MIDDLE.as_dvec3() * dvec3(sign, 1.0, 1.0);
        let node = stage.show(name, Some(bust), placed(at, DQuat::IDENTITY, 1.0), mesh);
        let gaze = |t: f64| 0.8 * (yaw(t + 0.08) - yaw(t));
        let rest = DQuat::from_rotation_y(0.03 * sign) * DQuat::from_rotation_x(0.03);
        stage.animate(node, turning(|t| DQuat::from_rotation_y(gaze(t)) * rest));
    }
}

/// A ball about the z axis whose iris is a shallow dish and whose pupil is a pit.
fn eyeball() -> Form {
    let arc = |degrees: f32| {
        let (s, c) = degrees.to_radians().sin_cos();
        (BALL * s, BALL * c, 0.0)
    };
    let mut corners = vec![(0.0, -BALL, 0.0)];
    corners.extend((0..27).map(|k| arc(177.8 - 5.68 * k as f32)));
    corners.extend([(BALL * 0.48, BALL * 0.905, 0.012), (BALL * 0.20, BALL * 0.875, 0.006)]);
    corners.extend([(BALL * 0.13, BALL * 0.78, 0.008), (0.0, BALL * 0.78, 0.0)]);
    lathe(&Profile::open(&corners), 64).turned_x(90.0)
}

/// Pupil, iris and the rest, by the distance from the axis.
fn split(ball: Form) -> [Form; 3] {
    let region = |t: &[u32; 3]| {
        let middle = t.iter().map(|&i| ball.positions[i as usize]).sum::<Vec3>() / 3.0;
        let out = middle.truncate().length() / BALL;
        if middle.z < 0.0 || out > 0.50 { 2 } else { usize::from(out > 0.175) }
    };
    std::array::from_fn(|k| ball.part(|t| region(t) == k))
}
