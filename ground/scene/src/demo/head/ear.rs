//! The ear: a shell leaning away from the head, with helix, antihelix, bowl, tragus and lobe.

use super::super::shape::field::{carve, ellipsoid, merge};
use super::super::shape::{Bundle, strand};
use chiaro_basis::math::{Vec3, vec3};

/// The middle of the ear, on the side of the skull.
const MIDDLE: Vec3 = Vec3::new(0.685, 0.98, -0.10);
/// Where an earring hangs.
pub(super) const LOBE: Vec3 = Vec3::new(0.735, 0.655, -0.04);

/// The ear's folds; in its own axes x points backwards, y up, z outwards.
pub(super) struct Ear {
    folds: Bundle,
    furrow: Bundle,
}

impl Ear {
    /// The ear.
    pub(super) fn new() -> Self {
        let row = |points: &[[f32; 4]]| {
            let joints: Vec<_> = points.iter().map(|&[x, y, z, r]| (vec3(x, y, z), r)).collect();
            strand(&joints, 4)
        };
        let helix = row(&[
            [-0.06, -0.02, 0.045, 0.022],
            [-0.115, 0.10, 0.055, 0.030],
            [-0.085, 0.235, 0.07, 0.033],
            [0.03, 0.305, 0.085, 0.035],
            [0.145, 0.26, 0.09, 0.034],
            [0.200, 0.13, 0.085, 0.032],
            [0.195, -0.03, 0.07, 0.028],
            [0.140, -0.17, 0.05, 0.026],
        ]);
        let antihelix = row(&[
            [0.00, 0.17, 0.055, 0.022],
            [0.07, 0.11, 0.07, 0.030],
            [0.095, 0.0, 0.075, 0.032],
            [0.07, -0.12, 0.065, 0.030],
            [0.02, -0.165, 0.06, 0.026],
        ]);
        let furrow = row(&[
            [0.02, 0.25, 0.09, 0.016],
            [0.12, 0.20, 0.095, 0.018],
            [0.158, 0.07, 0.095, 0.016],
            [0.145, -0.08, 0.09, 0.010],
        ]);
        Self { folds: Bundle::new(&[helix, antihelix], 0.05), furrow: Bundle::new(&[furrow], 0.05) }
    }

    /// The head with an ear; `p` has x >= 0, `head` is the head's field there.
    pub(super) fn on(&self, p: Vec3, head: f32) -> f32 {
        if p.distance(MIDDLE) > 0.62 {
            return head;
        }
        let e = local(p);
        let shell = ellipsoid(e, vec3(0.03, 0.02, 0.02), vec3(0.19, 0.31, 0.055));
        let root = ellipsoid(e, vec3(-0.06, -0.02, -0.08), vec3(0.10, 0.22, 0.12));
        let bowl = ellipsoid(e, vec3(-0.015, -0.05, 0.10), vec3(0.085, 0.115, 0.085));
        let tragus = ellipsoid(e, vec3(-0.115, -0.075, 0.055), vec3(0.035, 0.05, 0.035));
        let lobe = ellipsoid(e, vec3(-0.03, -0.265, 0.035), vec3(0.085, 0.095, 0.045));
        let ear = merge(shell, root, 0.10);
        let ear = -self.furrow.merged(e, -ear);
        let ear = merge(self.folds.merged(e, ear), lobe, 0.08);
        let ear = carve(ear, bowl, 0.035);
        merge(merge(head, ear, 0.05), tragus, 0.05)
    }
}

/// From the head's axes to the ear's: leaning back, turned out.
fn local(p: Vec3) -> Vec3 {
    let d = p - MIDDLE;
    let (back, out) = (Vec3::NEG_Z, Vec3::X);
    let (sin, cos) = 0.42f32.sin_cos();
    // The shell's back edge stands off the skull.
    let (across, outward) = (back * cos + out * sin, out * cos - back * sin);
    let (sin, cos) = 0.16f32.sin_cos();
    let (x, y) = (d.dot(across), d.y);
    vec3(x * cos - y * sin, x * sin + y * cos, d.dot(outward))
}
