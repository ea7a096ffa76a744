//! Mouldings: a closed outline drawn along a row of frames, and ribbons between two lines.

use super::form::Form;
use super::loft::{Join, Ring, loft, loft_with_normals};
use super::profile::Profile;
use chiaro_basis::math::{Vec2, Vec3};

/// A place along a moulding: the outline's origin, its x and its y direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// Where the outline's origin lies.
    pub(crate) at: Vec3,
    /// Unit direction of the outline's x.
    pub(crate) x: Vec3,
    /// Unit direction of the outline's y.
    pub(crate) y: Vec3,
}

impl Placed {
    fn point(&self, p: Vec2) -> Vec3 {
        self.at + self.direction(p)
    }

    fn direction(&self, v: Vec2) -> Vec3 {
        self.x * v.x + self.y * v.y
    }
}

/// A closed outline, counter-clockwise, drawn along `path`, with flat ends. All of the outline can be seen from
/// `heart`, a point inside it.
pub(crate) fn swept(outline: &Profile, heart: Vec2, path: &[Placed]) -> Form {
    let ring = |f: &Placed| -> Ring { outline.points.iter().map(|(p, _)| f.point(*p)).collect() };
    let normal =
        |f: &Placed| -> Ring { outline.points.iter().map(|(_, n)| f.direction(*n)).collect() };
    let rings: Vec<Ring> = path.iter().map(ring).collect();
    let normals: Vec<Ring> = path.iter().map(normal).collect();
    let side = loft_with_normals(&rings, &normals, Join { around: true, along: false });
    let last = path.len() - 1;
    let cap = |end: usize, inwards: usize| {
        let n = path[end].x.cross(path[end].y);
        let way = path[end].at - path[inwards].at;
        let normal = if n.dot(way) < 0.0 { -n } else { n };
        let edge = rings[end].clone();
        let fan = [vec![path[end].point(heart)], edge];
        let same = [vec![normal], vec![normal; fan[1].len()]];
        loft_with_normals(&fan, &same, Join { around: true, along: false })
    };
    side.with(cap(0, 1)).with(cap(last, last - 1))
}

/// A strip between two lines of equally many points; its front is where `a` turns to `b`
/// counter-clockwise.
pub(crate) fn ribbon(a: Vec<Vec3>, b: Vec<Vec3>) -> Form {
    loft(&[a, b], Join { around: false, along: false })
}

/// A thick wall between two lines in space: from `a` to `b` on the front, and `depth` behind it,
/// with all its narrow sides.
pub(crate) fn slab(a: &[Vec3], b: &[Vec3], depth: Vec3) -> Form {
    let behind = |line: &[Vec3]| line.iter().map(|p| *p + depth).collect::<Vec<_>>();
    let (c, d) = (behind(a), behind(b));
    let ends = |k: usize| [a[k], b[k], d[k], c[k]];
    let [s0, s1, s2, s3] = ends(0);
    let [e0, e1, e2, e3] = ends(a.len() - 1);
    Form::joined([
        ribbon(a.to_vec(), b.to_vec()),
        ribbon(d.clone(), c.clone()),
        ribbon(c, a.to_vec()),
        ribbon(b.to_vec(), d),
        ribbon(vec![s0, s1], vec![s3, s2]),
        ribbon(vec![e3, e2], vec![e0, e1]),
    ])
}
