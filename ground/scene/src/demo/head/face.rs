//! The skin of the bust as one implicit shape.
//!
//! Built as sculptors do: masses of skull and jaw first, then planes, then features. The figure is
//! symmetric, so that everything is said once, for x >= 0.

use super::super::shape::field::{carve, chain, common, ellipsoid, limb, merge, sphere};
use super::super::shape::{Bundle, strand};
use super::ear::Ear;
use super::eye::Lids;
use chiaro_basis::math::{Vec3, vec3};

/// The bust: head, neck and shoulders, cut off round below.
pub(super) struct Bust {
    ear: Ear,
    lids: Lids,
    mouth: Mouth,
}

impl Bust {
    /// The bust.
    pub(super) fn new() -> Self {
        Self { ear: Ear::new(), lids: Lids::new(), mouth: Mouth::new() }
    }

    /// Its field.
    pub(super) fn at(&self, p: Vec3) -> f32 {
        let p = vec3(p.x.abs(), p.y, p.z);
        let head = self.ear.on(p, self.features(p, head_mass(p)));
        if p.y > 0.9 { head } else { merge(head, trunk(p), 0.12) }
    }

    /// Brow, eyes, nose and mouth on the mass of the head.
    fn features(&self, p: Vec3, d: f32) -> f32 {
        if p.z < 0.1 || p.y < -0.1 || p.y > 1.75 {
            return d;
        }
        self.mouth.on(p, nose(p, self.lids.on(p, sockets(p, d))))
    }
}

/// Skull, jaw and cheeks.
fn head_mass(p: Vec3) -> f32 {
    let cranium = ellipsoid(p, vec3(0.0, 1.45, -0.12), vec3(0.72, 0.83, 0.94));
    let forehead = ellipsoid(p, vec3(0.0, 1.46, 0.20), vec3(0.60, 0.62, 0.64));
    let middle = ellipsoid(p, vec3(0.0, 0.95, 0.16), vec3(0.60, 0.60, 0.62));
    let lower = limb(p, vec3(0.0, 0.74, 0.20), vec3(0.0, 0.30, 0.38), 0.48, 0.27);
    let jaw = chain(
        p,
        &[
            (vec3(0.50, 0.74, -0.06), 0.10),
            (vec3(0.43, 0.50, 0.04), 0.11),
            (vec3(0.22, 0.235, 0.38), 0.10),
            (vec3(0.0, 0.14, 0.545), 0.11),
        ],
        0.16,
    );
    let chin = ellipsoid(p, vec3(0.0, 0.17, 0.615), vec3(0.135, 0.115, 0.125));
    let cheekbone = ellipsoid(p, vec3(0.370, 0.90, 0.50), vec3(0.20, 0.15, 0.215));
    let arch = limb(p, vec3(0.50, 0.93, 0.36), vec3(0.62, 1.0, 0.02), 0.09, 0.08);
    let d = merge(merge(cranium, forehead, 0.28), middle, 0.25);
    let d = merge(merge(d, lower, 0.22), jaw, 0.22);
    let d = merge(d, chin, 0.13);
    let cheek = ellipsoid(p, vec3(0.27, 0.57, 0.43), vec3(0.255, 0.34, 0.265));
    merge(merge(merge(d, cheekbone, 0.22), arch, 0.2), cheek, 0.2)
}

/// The ridge of the brow, and the hollows below it.
fn sockets(p: Vec3, d: f32) -> f32 {
    let brow = chain(
        p,
        &[
            (vec3(0.06, 1.285, 0.775), 0.055),
            (vec3(0.25, 1.325, 0.730), 0.065),
            (vec3(0.46, 1.285, 0.555), 0.060),
        ],
        0.08,
    );
    let socket = ellipsoid(p, vec3(0.30, 1.15, 0.84), vec3(0.165, 0.100, 0.155));
    let corner = sphere(p, vec3(0.135, 1.14, 0.86), 0.085);
    carve(carve(merge(d, brow, 0.14), socket, 0.14), corner, 0.12)
}

fn nose(p: Vec3, d: f32) -> f32 {
    if p.distance(vec3(0.0, 0.95, 0.95)) > 0.6 {
        return d;
    }
    let bridge = chain(
        p,
        &[
            (vec3(0.0, 1.28, 0.765), 0.065),
            (vec3(0.0, 1.15, 0.785), 0.050),
            (vec3(0.0, 1.00, 0.868), 0.054),
            (vec3(0.0, 0.85, 0.965), 0.062),
        ],
        0.06,
    );
    let flank = limb(p, vec3(0.030, 1.12, 0.735), vec3(0.058, 0.83, 0.865), 0.045, 0.066);
    let tip = ellipsoid(p, vec3(0.0, 0.818, 0.992), vec3(0.070, 0.060, 0.072));
    let wing = ellipsoid(p, vec3(0.088, 0.790, 0.878), vec3(0.044, 0.048, 0.078));
    let septum = limb(p, vec3(0.0, 0.790, 0.985), vec3(0.0, 0.758, 0.87), 0.026, 0.036);
    let nostril = limb(p, vec3(0.040, 0.748, 0.952), vec3(0.066, 0.750, 0.880), 0.016, 0.024);
    let groove = limb(p, vec3(0.138, 0.850, 0.835), vec3(0.152, 0.765, 0.805), 0.006, 0.010);
    let d = merge(merge(d, bridge, 0.10), flank, 0.11);
    let d = merge(merge(d, tip, 0.08), septum, 0.05);
    let d = merge(carve(d, groove, 0.06), wing, 0.045);
    carve(d, nostril, 0.028)
}

/// What the mouth is made of.
struct Mouth {
    lips: Bundle,
    seam: Bundle,
}

impl Mouth {
    fn new() -> Self {
        let row = |points: &[[f32; 4]]| {
            let right = points.iter().skip(1).rev().map(|&[x, y, z, r]| (vec3(-x, y, z), r));
            let left = points.iter().map(|&[x, y, z, r]| (vec3(x, y, z), r));
            strand(&right.chain(left).collect::<Vec<_>>(), 6)
        };
        let upper = row(&[
            [0.0, 0.540, 0.826, 0.026],
            [0.052, 0.552, 0.822, 0.029],
            [0.120, 0.536, 0.788, 0.026],
            [0.205, 0.507, 0.720, 0.012],
        ]);
        let lower = row(&[
            [0.0, 0.460, 0.806, 0.043],
            [0.070, 0.461, 0.798, 0.041],
            [0.140, 0.474, 0.760, 0.030],
            [0.205, 0.497, 0.716, 0.012],
        ]);
        let seam = row(&[
            [0.0, 0.503, 0.864, 0.008],
            [0.055, 0.510, 0.857, 0.008],
            [0.130, 0.504, 0.816, 0.007],
            [0.205, 0.503, 0.752, 0.005],
            [0.228, 0.508, 0.735, 0.003],
        ]);
        Self { lips: Bundle::new(&[upper, lower], 0.04), seam: Bundle::new(&[seam], 0.024) }
    }

    fn on(&self, p: Vec3, d: f32) -> f32 {
        if p.distance(vec3(0.0, 0.48, 0.8)) > 0.62 {
            return d;
        }
        let muzzle = ellipsoid(p, vec3(0.0, 0.52, 0.56), vec3(0.27, 0.25, 0.275));
        let below = limb(p, vec3(0.0, 0.335, 0.880), vec3(0.11, 0.335, 0.845), 0.045, 0.035);
        let philtrum = limb(p, vec3(0.0, 0.70, 0.885), vec3(0.0, 0.605, 0.893), 0.012, 0.018);
        let d = carve(merge(d, muzzle, 0.18), below, 0.13);
        let d = self.lips.merged(p, carve(d, philtrum, 0.05));
        -self.seam.merged(p, -d)
    }
}

/// Neck and shoulders, rounded off below.
fn trunk(p: Vec3) -> f32 {
    let neck = limb(p, vec3(0.0, 0.60, -0.26), vec3(0.0, -0.85, -0.42), 0.43, 0.46);
    let strap = limb(p, vec3(0.42, 0.58, -0.26), vec3(0.08, -0.88, 0.02), 0.08, 0.055);
    let throat = limb(p, vec3(0.0, 0.10, 0.16), vec3(0.0, -0.75, -0.04), 0.10, 0.12);
    let slope = limb(p, vec3(0.14, 0.05, -0.56), vec3(1.10, -1.02, -0.46), 0.22, 0.24);
    let shoulder = limb(p, vec3(0.35, -1.25, -0.40), vec3(1.25, -1.27, -0.42), 0.40, 0.37);
    let chest = ellipsoid(p, vec3(0.0, -1.50, -0.30), vec3(1.05, 0.76, 0.60));
    let collar = chain(
        p,
        &[
            (vec3(0.10, -0.925, 0.12), 0.060),
            (vec3(0.45, -0.865, 0.07), 0.045),
            (vec3(0.95, -0.865, -0.26), 0.050),
        ],
        0.05,
    );
    let pit = sphere(p, vec3(0.0, -0.89, 0.17), 0.06);
    let d = merge(merge(neck, strap, 0.12), throat, 0.18);
    let d = merge(d, slope, 0.28);
    let d = merge(d, merge(shoulder, chest, 0.3), 0.26);
    let d = carve(merge(d, collar, 0.12), pit, 0.12);
    let cut = ellipsoid(p, vec3(0.0, -0.35, -0.30), vec3(1.20, 1.42, 0.92));
    common(d, cut, 0.06)
}

/// The left eyebrow: a thin layer on the skin.
pub(super) fn brow(bust: &Bust, p: Vec3) -> f32 {
    let skin = bust.at(p);
    let outline = chain(
        vec3(p.x, p.y, 0.0),
        &[
            (vec3(0.100, 1.300, 0.0), 0.020),
            (vec3(0.130, 1.322, 0.0), 0.036),
            (vec3(0.250, 1.372, 0.0), 0.036),
            (vec3(0.380, 1.392, 0.0), 0.028),
            (vec3(0.520, 1.335, 0.0), 0.008),
        ],
        0.02,
    );
    common(common(skin - 0.016, outline, 0.02), -(skin + 0.03), 0.01)
}
