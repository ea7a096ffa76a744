//! [`Gloss`]: how a visible point reflects, by the metallic-roughness model (glTF 2.0, appendix B).
//!
//! ```text
//! f = kd / pi + F D V        F = F0 + (F90 - F0) (1 - v.h)^5        alpha = roughness^2
//! D = alpha^2 / (pi (|n x h|^2 + alpha^2 (n.h)^2)^2)                GGX
//! V = 1 / (2 (n.l L(n.v) + n.v L(n.l))), L(c)^2 = alpha^2 + (1 - alpha^2) c^2     Smith, correlated
//! F0 = mix(0.04 s, base, metallic)        kd = base (1 - metallic) (1 - E(n.v))
//! ```
//!
//! s is [`chiaro_scene::Material::specular`]. E is what a dielectric coat reflects in all, F averaged
//! over its lobe: appendix B has 1 - F in its place, and leaves the choice open; so diffuse light is
//! irradiance times a colour, and a white dielectric reflects all that it receives. A metal loses what
//! scatters more than once between its facets (head-on ln 2, 69 %, at roughness 1).
//!
//! Directions are drawn by the normals that are visible (Heitz 2018), so that a sample weighs F G2 / G1, at most
//! 1. A shading normal that would reflect the eye's ray into the surface is turned towards the face's.

mod albedo;

use crate::gbuffer::GBuffer;
use crate::surface::Surface;
use crate::tracer::Tracer;
use crate::vertex;
use chiaro_basis::math::Vec3;
use chiaro_scene::Material;
use std::f32::consts::{PI, TAU};

/// Reflection towards the eye at a visible point.
#[derive(Clone, Copy, Debug)]
pub struct Gloss {
    /// Unit shading normal, on the side that is seen.
    pub normal: Vec3,
    /// Unit vector to the eye.
    pub to_eye: Vec3,
    /// The distribution's width: roughness squared.
    pub alpha: f32,
    /// Reflectance head-on, linear RGB.
    pub f0: [f32; 3],
    /// The same at grazing angles.
    pub f90: f32,
    /// The albedo of diffuse reflection.
    pub diffuse: [f32; 3],
}

/// Mirrors are this rough.
const LEAST_ALPHA: f32 = 0.002;
/// The least cosine to the eye.
const LEAST_COSINE: f32 = 1e-3;
/// Of a dielectric head-on.
const DIELECTRIC: f32 = 0.04;

impl Gloss {
    /// The reflection of a material with these values at a place, seen from `to_eye`.
    fn new(
        (side, normal, to_eye): (Vec3, Vec3, Vec3),
        (base, roughness, metallic): ([f32; 3], f32, f32),
        specular: f32,
    ) -> Self {
        let base = vertex::albedo(base);
        let metallic = metallic.clamp(0.0, 1.0);
        let normal = reflecting(normal, side, to_eye);
        let alpha = roughness.clamp(0.0, 1.0).powi(2).max(LEAST_ALPHA);
        let coat = DIELECTRIC * specular;
        let f90 = specular.min(1.0) * (1.0 - metallic) + metallic;
        let kept = (1.0 - metallic)
            * (1.0 - albedo::reflected(normal.dot(to_eye), alpha, coat, specular.min(1.0)));
        Self {
            normal,
            to_eye,
            alpha,
            f0: base.map(|b| coat * (1.0 - metallic) + b * metallic),
            f90,
            diffuse: base.map(|b| b * kept),
        }
    }

    /// The reflection at a covered pixel of a buffer.
    pub fn of_pixel(tracer: &Tracer, buffer: &GBuffer, pixel: (usize, usize)) -> Self {
        let material = &tracer.scene.materials[buffer.material[pixel].saturating_sub(1) as usize];
        let side = Vec3::from(buffer.geometric_normal[pixel]);
        let place =
            (side, buffer.normal[pixel].into(), buffer.to_eye(buffer.position[pixel].into()));
        let values = (buffer.base_colour[pixel], buffer.roughness[pixel], buffer.metallic[pixel]);
        Self::new(place, values, specular(material))
    }

    /// The reflection of a surface that a ray along `direction` met.
    pub fn of_surface(tracer: &Tracer, surface: &Surface, direction: Vec3) -> Self {
        let material = &tracer.scene.materials[surface.material.index()];
        let place = (surface.geometric_normal, surface.normal, -direction);
        let values = (surface.base_colour, surface.roughness, surface.metallic);
        Self::new(place, values, specular(material))
    }

    /// Whether it only reflects diffusely.
    pub fn is_dull(&self) -> bool {
        self.f90 == 0.0 && self.f0 == [0.0; 3]
    }

    /// The same with its lobe as wide as if the normal varied by so much (the mean square of half-vectors' slopes).
    pub fn widened(self, variance: f32) -> Self {
        Self { alpha: (self.alpha * self.alpha + variance).sqrt().min(1.0), ..self }
    }

    /// How much of its lobe may be taken for diffuse: all where it is wide and faint, as of a dull dielectric,
    /// nothing where it is sharp or strong.
    pub fn matt_share(&self) -> f32 {
        let most = self.reflectance().into_iter().fold(0.0, f32::max);
        let ramp = |t: f32| t.clamp(0.0, 1.0);
        ramp((self.alpha - 0.25) / 0.25) * ramp((0.25 - most) / 0.13)
    }

    /// The share of light from everywhere that it reflects specularly.
    pub fn reflectance(&self) -> [f32; 3] {
        let c = self.normal.dot(self.to_eye);
        self.f0.map(|f0| albedo::reflected(c, self.alpha, f0, self.f90))
    }

    /// Specular reflection of light from `towards`, times cosine.
    pub fn value(&self, towards: Vec3) -> [f32; 3] {
        let (nl, nv) = (self.normal.dot(towards), self.normal.dot(self.to_eye));
        if nl <= 0.0 || nv <= 0.0 {
            return [0.0; 3];
        }
        let half = (towards + self.to_eye).normalize_or(self.normal);
        let visible = 0.5 / (nl * self.slope(nv) + nv * self.slope(nl)).max(f32::MIN_POSITIVE);
        let grazing = (1.0 - half.dot(self.to_eye)).clamp(0.0, 1.0).powi(5);
        let scale = self.distribution(half) * visible * nl;
        self.f0.map(|f0| (f0 + (self.f90 - f0) * grazing) * scale)
    }

    /// The density, per solid angle, with which [`Gloss::sample`] finds a direction.
    pub fn density(&self, towards: Vec3) -> f32 {
        let nv = self.normal.dot(self.to_eye);
        if self.normal.dot(towards) <= 0.0 || nv <= 0.0 {
            return 0.0;
        }
        let half = (towards + self.to_eye).normalize_or(self.normal);
        0.5 * self.distribution(half) / (nv + self.slope(nv))
    }

    /// A direction for two numbers in [0, 1), perhaps below the surface.
    pub fn sample(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (right, up) = self.normal.any_orthonormal_pair();
        let eye = Vec3::new(
            self.to_eye.dot(right),
            self.to_eye.dot(up),
            self.to_eye.dot(self.normal).max(LEAST_COSINE),
        );
        let half = visible_normal(eye, self.alpha, [u, v]);
        let half = right * half.x + up * half.y + self.normal * half.z;
        (half * (2.0 * half.dot(self.to_eye)) - self.to_eye).normalize_or(self.normal)
    }

    fn distribution(&self, half: Vec3) -> f32 {
        let square = self.alpha * self.alpha;
        let across = self.normal.cross(half).length_squared();
        let along = self.normal.dot(half).max(0.0);
        let d = across + square * along * along;
        square / (PI * d * d).max(f32::MIN_POSITIVE)
    }

    fn slope(&self, cosine: f32) -> f32 {
        let square = self.alpha * self.alpha;
        (square + (1.0 - square) * cosine * cosine).sqrt()
    }
}

fn specular(material: &Material) -> f32 {
    if material.unlit { 0.0 } else { material.specular }
}

/// The normal, turned towards `side` until the eye's ray is reflected to the outside.
fn reflecting(normal: Vec3, side: Vec3, to_eye: Vec3) -> Vec3 {
    let is_fine = |n: Vec3| {
        let c = n.dot(to_eye);
        c > LEAST_COSINE && (n * (2.0 * c) - to_eye).dot(side) > LEAST_COSINE
    };
    if is_fine(normal) {
        return normal;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..8 {
        let t = 0.5 * (low + high);
        if is_fine(normal.lerp(side, t).normalize_or(side)) { high = t } else { low = t }
    }
    normal.lerp(side, high).normalize_or(side)
}

/// A normal in proportion to how much of it `eye` sees; both in the frame of the surface (Heitz 2018).
fn visible_normal(eye: Vec3, alpha: f32, [u, v]: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(alpha * eye.x, alpha * eye.y, eye.z).normalize();
    let across = Vec3::new(-stretched.y, stretched.x, 0.0).try_normalize().unwrap_or(Vec3::X);
    let other = stretched.cross(across);
    let (r, (sin, cos)) = (u.sqrt(), (TAU * v).sin_cos());
    let s = 0.5 * (1.0 + stretched.z);
    let x = r * cos;
    let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * r * sin;
    let n = across * x + other * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
    Vec3::new(alpha * n.x, alpha * n.y, n.z.max(1e-6)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::r2;

    fn gloss(roughness: f32, metallic: f32, cosine: f32) -> Gloss {
        let eye = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        Gloss::new((Vec3::Z, Vec3::Z, eye), ([1.0; 3], roughness, metallic), 1.0)
    }

    /// The integral of f over the hemisphere, by a fine even grid.
    fn integral(f: impl Fn(Vec3) -> f32) -> f32 {
        let n = 600;
        let mut sum = 0.0f64;
        for i in 0..n * n {
            let (z, a) =
                (((i / n) as f32 + 0.5) / n as f32, TAU * ((i % n) as f32 + 0.5) / n as f32);
            let r = (1.0 - z * z).sqrt();
            sum += f64::from(f(Vec3::new(r * a.cos(), r * a.sin(), z)));
        }
        (sum * f64::from(TAU) / (n * n) as f64) as f32
    }

    #[test]
    fn samples_in_a_white_furnace_reflect_what_quadrature_finds() {
        for (roughness, cosine) in [(0.4, 0.9), (0.6, 0.3), (1.0, 0.7)] {
            let g = gloss(roughness, 1.0, cosine);
            let exact = integral(|l| g.value(l)[0]);
            let n = 4096;
            let sampled: f32 = (0..n)
                .map(|i| g.sample(r2(i)))
                .filter(|l| g.density(*l) > 0.0)
                .map(|l| g.value(l)[0] / g.density(l) / n as f32)
                .sum();
            assert!((sampled / exact - 1.0).abs() < 0.01, "{roughness}: {sampled} {exact}");
            assert!((g.reflectance()[0] / exact - 1.0).abs() < 0.02, "{roughness} {exact}");
            let above = (0..n).filter(|i| g.density(g.sample(r2(*i))) > 0.0).count() as f32;
            let density = integral(|l| g.density(l));
            assert!((density - above / n as f32).abs() < 0.01, "{roughness}: {density}");
        }
        // Head-on at alpha 1, D is 1 / pi and V is 1 / (2 (1 + n.l)): the integral is 1 - ln 2.
        let head_on = gloss(1.0, 1.0, 0.9999).reflectance()[0];
        assert!((head_on - (1.0 - std::f32::consts::LN_2)).abs() < 0.005, "{head_on}");
    }

    #[test]
    fn a_white_dielectric_reflects_all() {
        for (roughness, cosine) in [(0.3, 0.8), (0.7, 0.2), (1.0, 0.5)] {
            let g = gloss(roughness, 0.0, cosine);
            let all = g.diffuse[0] + integral(|l| g.value(l)[0]);
            assert!((all - 1.0).abs() < 0.01, "{roughness} {cosine}: {all}");
        }
    }

    #[test]
    fn reflection_is_the_same_both_ways() {
        let (a, b) = (gloss(0.5, 0.0, 0.9), Vec3::new(0.0, 0.8, 0.6));
        let back = Gloss { to_eye: b, ..a };
        let (there, here) = (a.value(b)[0] / b.z, back.value(a.to_eye)[0] / a.to_eye.z);
        assert!((there / here - 1.0).abs() < 1e-4, "{there} {here}");
    }

    #[test]
    fn normals_that_would_reflect_inwards_are_turned() {
        let eye = Vec3::new(0.95, 0.0, 0.31).normalize();
        let n = reflecting(Vec3::new(-0.6, 0.0, 0.8), Vec3::Z, eye);
        assert!(n.dot(eye) > 0.0 && (n * (2.0 * n.dot(eye)) - eye).z > 0.0, "{n}");
    }
}
