//! Further line types as zero sets: suggestive contours, apparent ridges, ridges and valleys,
//! terminators.
//!
//! | type | zero of | kept where |
//! |---|---|---|
//! | suggestive contour (DeCarlo et al. 2003) | radial curvature k_r = II(w, w) / w.w, w the view vector in the tangent plane | D_w k_r > 0 by enough, front faces |
//! | terminator | n . l | front faces |
//! | ridge, valley (Ohtake et al. 2004) | D_t k, k the curvature greatest in magnitude, t its direction | k > 0 or k < 0 by enough, k extreme there |
//! | apparent ridge (Judd et al. 2007) | D_t q, q the greatest view-dependent curvature | q enough, q greatest there |
//!
//! The first two are functions on the surface; a direction has no sign, so the others are found edge
//! by edge, the direction at one end turned towards that at the other. Strengths are measured in
//! units of the object's radius R, so that a scene may have any scale.

use crate::contour::Scenery;
use crate::curvature::{Form, forms, gradient, outer, principal};
use crate::further::Further;
use crate::knob::LinesKnobs;
use crate::path::Kind;
use crate::posed::Posed;
use crate::slice::Slice;
use crate::surface::{NONE, Surface, next};
use crate::view::View;
use chiaro_basis::math::{DMat3, DVec3};

/// A zero set with the part of it that is a line.
pub(crate) struct ZeroSet {
    /// What kind of line.
    pub(crate) kind: Kind,
    /// The whole zero set.
    pub(crate) slice: Slice,
    /// For each crossing, whether what follows is kept.
    pub(crate) keep: Vec<bool>,
    /// The function at the vertices, if there is one.
    pub(crate) values: Vec<f64>,
}

impl ZeroSet {
    /// Without what is kept of it.
    pub(crate) fn further(self) -> Further {
        let Self { kind, slice, values, .. } = self;
        Further { kind, slice, forward: Vec::new(), values }
    }
}

/// Lines this close to edge-on belong to the silhouette: cosine.
const EDGE_ON: f64 = 0.08;

/// The zero sets that the knobs ask for.
pub(crate) fn zero_sets(scenery: &Scenery<'_>, g: &[f64], knobs: &LinesKnobs) -> Vec<ZeroSet> {
    let mut sets = Vec::new();
    if knobs.terminator {
        sets.push(terminator(scenery, g, knobs));
    }
    let directed = [
        (knobs.ridge, Kind::Ridge),
        (knobs.valley, Kind::Valley),
        (knobs.apparent_ridge, Kind::ApparentRidge),
    ];
    if !knobs.suggestive && directed.iter().all(|d| !d.0) {
        return sets;
    }
    let bent = Bent::of(scenery, knobs.smooth_curvature);
    if knobs.suggestive {
        sets.push(bent.suggestive(g, f64::from(knobs.suggestive_strength)));
    }
    for (_, kind) in directed.into_iter().filter(|d| d.0) {
        sets.push(bent.extremal(kind, g, knobs));
    }
    sets
}

fn terminator(scenery: &Scenery<'_>, g: &[f64], knobs: &LinesKnobs) -> ZeroSet {
    let (azimuth, elevation) = (
        f64::from(knobs.light_azimuth).to_radians(),
        f64::from(knobs.light_elevation).to_radians(),
    );
    let pose = &scenery.view.pose;
    let axis = |v: chiaro_basis::math::Vec3| v.as_dvec3();
    let to_light = axis(pose.right) * (elevation.cos() * azimuth.sin())
        + axis(pose.up) * elevation.sin()
        - axis(pose.forward) * (elevation.cos() * azimuth.cos());
    let values: Vec<f64> = scenery.posed.normals.iter().map(|n| n.dot(to_light)).collect();
    let slice = Slice::of(scenery.surface, &values);
    let keep = kept(&slice, scenery.surface, |face| {
        scenery.surface.faces[face].iter().all(|v| g[*v as usize] > 0.0)
    });
    ZeroSet { kind: Kind::Terminator, slice, keep, values }
}

/// For each crossing, whether the face that follows is real and satisfies `fits`.
fn kept(slice: &Slice, surface: &Surface, fits: impl Fn(usize) -> bool) -> Vec<bool> {
    let keep = |face: u32| face != NONE && !surface.is_strip(face as usize) && fits(face as usize);
    slice.crossings.iter().map(|c| keep(c.face)).collect()
}

/// A surface with its curvature.
struct Bent<'a> {
    surface: &'a Surface,
    posed: &'a Posed,
    view: &'a View,
    forms: Vec<Form>,
    /// Half the diagonal of everything.
    radius: f64,
}

impl<'a> Bent<'a> {
    fn of(scenery: &Scenery<'a>, passes: u32) -> Self {
        let (surface, posed) = (scenery.surface, scenery.posed);
        let mut forms = forms(surface, posed);
        for _ in 0..passes {
            forms = smoothed(surface, posed, &forms);
        }
        let bounds = posed
            .positions
            .iter()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |b, p| [b[0].min(*p), b[1].max(*p)]);
        let radius = (0.5 * (bounds[1] - bounds[0]).length()).max(1e-300);
        Self { surface, posed, view: scenery.view, forms, radius }
    }

    /// The view vector in a vertex's tangent plane, and the cosine against the normal.
    fn view_at(&self, vertex: usize) -> (DVec3, f64) {
        let to_eye = self.view.to_eye(self.posed.positions[vertex]).normalize_or_zero();
        let n = self.posed.normals[vertex];
        let cosine = n.dot(to_eye);
        (to_eye - n * cosine, cosine)
    }

    fn suggestive(&self, g: &[f64], strength: f64) -> ZeroSet {
        let radial = |v: usize| {
            let (w, _) = self.view_at(v);
            w.dot(self.forms[v] * w) / w.length_squared().max(1e-12)
        };
        let values: Vec<f64> = (0..self.forms.len()).map(radial).collect();
        let slice = Slice::of(self.surface, &values);
        let least = strength / (self.radius * self.radius);
        let keep = kept(&slice, self.surface, |face| {
            let corners = self.surface.faces[face];
            let views = corners.map(|v| self.view_at(v as usize));
            let w: DVec3 = views.iter().map(|v| v.0).sum::<DVec3>() / 3.0;
            corners.iter().all(|v| g[*v as usize] > 0.0)
                && views.iter().all(|v| v.1 > EDGE_ON)
                && gradient(self.surface, self.posed, &values, face).dot(w) > least
        });
        ZeroSet { kind: Kind::Suggestive, slice, keep, values }
    }

    /// Ridges, valleys or apparent ridges.
    fn extremal(&self, kind: Kind, g: &[f64], knobs: &LinesKnobs) -> ZeroSet {
        let count = self.forms.len();
        let found: Vec<(f64, DVec3)> = (0..count).map(|v| self.greatest(kind, v)).collect();
        let size: Vec<f64> = found.iter().map(|f| f.0).collect();
        let slope = self.slopes(&size);
        // Positive where the curvature rises along the direction.
        let rise: Vec<f64> = (0..count).map(|v| slope[v].dot(found[v].1)).collect();
        let at = |edge: u32| {
            let [a, b] = self.surface.ends(edge).map(|v| v as usize);
            let sign = if found[a].1.dot(found[b].1) < 0.0 { -1.0 } else { 1.0 };
            let (ra, rb) = (rise[a], sign * rise[b]);
            let along = self.posed.positions[b] - self.posed.positions[a];
            // At a maximum both ends look up towards each other.
            let up = (found[a].1 * ra).dot(along) > 0.0 && (found[a].1 * rb).dot(along) < 0.0;
            (up && (ra > 0.0) != (rb > 0.0)).then(|| ra / (ra - rb))
        };
        let slice = Slice::of_edges(self.surface, at);
        let strength = match kind {
            Kind::ApparentRidge => knobs.apparent_strength,
            _ => knobs.ridge_strength,
        };
        let least = f64::from(strength) / self.radius;
        let keep = kept(&slice, self.surface, |face| {
            let corners = self.surface.faces[face].map(|v| v as usize);
            let mean = corners.iter().map(|&v| size[v]).sum::<f64>() / 3.0;
            corners.iter().all(|&v| g[v] > 0.0 && self.view_at(v).1 > EDGE_ON) && mean > least
        });
        ZeroSet { kind, slice, keep, values: Vec::new() }
    }

    /// The curvature whose maxima are sought, and its direction.
    fn greatest(&self, kind: Kind, vertex: usize) -> (f64, DVec3) {
        let normal = self.posed.normals[vertex];
        let form = &self.forms[vertex];
        match kind {
            Kind::ApparentRidge => self.apparent(vertex),
            _ => {
                let (k, t) = principal(form, normal)[0];
                (if kind == Kind::Valley { -k } else { k }, t)
            }
        }
    }

    /// The greatest singular value of II P^-1, P the projection into the picture, and the direction
    /// on the surface that shows it.
    fn apparent(&self, vertex: usize) -> (f64, DVec3) {
        let (w, cosine) = self.view_at(vertex);
        let normal = self.posed.normals[vertex];
        let u = w.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        let v = normal.cross(u);
        let stretch = 1.0 / cosine.abs().max(EDGE_ON);
        let form = &self.forms[vertex];
        // Columns: the turn of the normal for a step of one picture unit along u and along v.
        let (a, b) = (*form * u * stretch, *form * v);
        let (e, f, h) = (a.dot(a), a.dot(b), b.dot(b));
        let (mean, half) = (0.5 * (e + h), 0.5 * (e - h));
        let root = half.hypot(f);
        let angle = 0.5 * f.atan2(half);
        let direction = u * (angle.cos() * stretch) + v * angle.sin();
        ((mean + root).max(0.0).sqrt(), direction.normalize_or_zero())
    }

    /// Gradients at vertices: means of their faces', weighted by area.
    fn slopes(&self, values: &[f64]) -> Vec<DVec3> {
        let mut sums = vec![(DVec3::ZERO, 0.0); values.len()];
        for face in 0..self.surface.real_faces {
            let corners = self.surface.faces[face];
            let [a, b, c] = corners.map(|v| self.posed.positions[v as usize]);
            let area = (b - a).cross(c - a).length();
            let slope = gradient(self.surface, self.posed, values, face);
            for v in corners {
                sums[v as usize].0 += slope * area;
                sums[v as usize].1 += area;
            }
        }
        sums.iter().map(|(s, a)| if *a > 0.0 { *s / *a } else { DVec3::ZERO }).collect()
    }
}

/// One-ring means of forms, back in the tangent planes.
fn smoothed(surface: &Surface, posed: &Posed, forms: &[Form]) -> Vec<Form> {
    let mut sums: Vec<(DMat3, f64)> = forms.iter().map(|f| (*f, 1.0)).collect();
    for half in 0..3 * surface.real_faces as u32 {
        let (a, b) = (surface.from(half) as usize, surface.from(next(half)) as usize);
        sums[a].0 += forms[b];
        sums[a].1 += 1.0;
    }
    let back = |((sum, count), n): (&(DMat3, f64), &DVec3)| {
        let plane = DMat3::IDENTITY - outer(*n, *n);
        plane * (*sum * count.recip()) * plane
    };
    sums.iter().zip(&posed.normals).map(back).collect()
}
