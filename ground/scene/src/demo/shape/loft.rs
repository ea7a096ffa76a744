//! Surfaces over grids: rings of points joined by quads.
//!
//! [`loft`] joins any rings; [`wrapped`] (a torus), [`pointed`] (a sphere) and [`sheet`] (a piece of
//! cloth) sample a parametric surface. A ring of one point is a pole; a fan joins it to the next.

use super::form::Form;
use chiaro_basis::math::Vec3;

/// One ring: points, or a single one for a pole.
pub(crate) type Ring = Vec<Vec3>;

/// How a grid is joined.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Join {
    /// Each ring closes on itself.
    pub(crate) around: bool,
    /// The last ring joins the first.
    pub(crate) along: bool,
}

/// Triangles between consecutive rings, all rings having the same number of points or just one,
/// with angle-weighted normals.
pub(crate) fn loft(rings: &[Ring], join: Join) -> Form {
    Form::smooth(rings.concat(), grid_triangles(rings, join))
}

/// As [`loft`], with the normals given in rings of the same shape; triangles face as they do.
pub(crate) fn loft_with_normals(rings: &[Ring], normals: &[Ring], join: Join) -> Form {
    let triangles = grid_triangles(rings, join);
    let form = Form { positions: rings.concat(), normals: normals.concat(), triangles };
    form.facing_its_normals()
}

fn grid_triangles(rings: &[Ring], join: Join) -> Vec<[u32; 3]> {
    let mut starts = Vec::with_capacity(rings.len());
    let mut count = 0;
    for ring in rings {
        starts.push(count);
        count += ring.len() as u32;
    }
    let steps = if join.along { rings.len() } else { rings.len() - 1 };
    let mut triangles = Vec::new();
    for i in 0..steps {
        let j = (i + 1) % rings.len();
        band((&rings[i], starts[i]), (&rings[j], starts[j]), join.around, &mut triangles);
    }
    triangles
}

/// The triangles between two rings, each given with its first vertex index.
fn band(low: (&Ring, u32), high: (&Ring, u32), around: bool, triangles: &mut Vec<[u32; 3]>) {
    let n = low.0.len().max(high.0.len());
    let index = |ring: (&Ring, u32), i: usize| ring.1 + (i % n).min(ring.0.len() - 1) as u32;
    let point = |ring: (&Ring, u32), i: usize| ring.0[(i % n).min(ring.0.len() - 1)];
    for i in 0..if around { n } else { n - 1 } {
        let [a, b] = [i, i + 1].map(|k| index(low, k));
        let [d, c] = [i, i + 1].map(|k| index(high, k));
        if a == b {
            triangles.push([a, c, d]);
        } else if c == d {
            triangles.push([a, b, c]);
        } else {
            let one = point(low, i).distance_squared(point(high, i + 1));
            let other = point(low, i + 1).distance_squared(point(high, i));
            let cut =
                if one <= other * 1.0001 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            triangles.extend(cut);
        }
    }
}

/// A parametric surface that closes in both directions, u and v in [0, 1).
pub(crate) fn wrapped(nu: usize, nv: usize, f: impl Fn(f32, f32) -> Vec3) -> Form {
    let ring = |j: usize| (0..nu).map(|i| f(share(i, nu), share(j, nv))).collect();
    let rings: Vec<Ring> = (0..nv).map(ring).collect();
    loft(&rings, Join { around: true, along: true }).outward()
}

/// A parametric surface that closes in u and ends in poles at v = 0 and v = 1.
pub(crate) fn pointed(nu: usize, nv: usize, f: impl Fn(f32, f32) -> Vec3) -> Form {
    let ring = |j: usize| {
        let n = if j == 0 || j == nv { 1 } else { nu };
        (0..n).map(|i| f(share(i, nu), share(j, nv))).collect()
    };
    let rings: Vec<Ring> = (0..=nv).map(ring).collect();
    loft(&rings, Join { around: true, along: false }).outward()
}

/// An open parametric surface, u and v in [0, 1]; its front is where u turns to v
/// counter-clockwise.
pub(crate) fn sheet(nu: usize, nv: usize, f: impl Fn(f32, f32) -> Vec3) -> Form {
    let ring = |j: usize| (0..=nu).map(|i| f(share(i, nu), share(j, nv))).collect();
    let rings: Vec<Ring> = (0..=nv).map(ring).collect();
    loft(&rings, Join { around: false, along: false })
}

fn share(i: usize, n: usize) -> f32 {
    i as f32 / n as f32
}
