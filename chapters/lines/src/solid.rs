//! [`Solids`]: which folds of a surface nothing can see, piece by piece.
//!
//! At a silhouette the view grazes the surface: on its front side where the surface bends away from
//! the viewer (convex), on its back where it bends towards it (concave). How often a closed piece winds
//! around a point there and around the eye tells whether it must be crossed between them: a point
//! inside of a solid is not seen from outside, and the other way round. Windings are those of the
//! piece as its faces wind, so that a ball that is wound inwards, and a room, are seen as they are.

use crate::contour::Scenery;
use crate::surface::{NONE, Surface};
use chiaro_basis::math::DVec3;

/// The least volume of what winds inwards, in parts of the cube of its extent: what is thinner has no
/// inside to speak of.
const THIN: f64 = 1e-6;

/// What closed pieces of a surface are, in one frame.
pub(crate) struct Solids {
    /// For each piece that is closed, how often it winds around what is just behind its faces, around
    /// what is just before them, and around the eye.
    windings: Vec<Option<[i32; 3]>>,
}

/// What is gathered of a piece.
#[derive(Clone, Copy)]
struct Piece {
    open: bool,
    first: DVec3,
    low: DVec3,
    high: DVec3,
    /// Six times its volume.
    volume: f64,
}

impl Solids {
    pub(crate) fn of(scenery: &Scenery<'_>) -> Self {
        let Scenery { surface, posed, view, .. } = *scenery;
        let pieces = gathered(surface, &posed.positions);
        let eye = view.perspective().then(|| view.to_eye(DVec3::ZERO));
        let within =
            |p: &Piece| eye.filter(|e| !p.open && e.cmpge(p.low).all() && e.cmple(p.high).all());
        let around: Vec<i32> = (pieces.iter().enumerate())
            .map(|(i, p)| within(p).map_or(0, |eye| winding(surface, &posed.positions, i, eye)))
            .collect();
        let windings = pieces.iter().zip(around).map(|(p, around)| {
            let inwards = p.volume < -THIN * p.low.distance(p.high).powi(3);
            (!p.open).then_some(if inwards { [0, -1, around] } else { [1, 0, around] })
        });
        Self { windings: windings.collect() }
    }

    /// Whether a piece is a solid with the eye outside: its fronts hide its backs.
    pub(crate) fn is_outside(&self, piece: u32) -> bool {
        self.windings.get(piece as usize) == Some(&Some([1, 0, 0]))
    }

    /// Whether a fold of a piece surely lies beyond another part of it; of what is not closed nothing is sure.
    pub(crate) fn buries(&self, piece: u32, convex: bool, two_sided: bool) -> bool {
        match self.windings.get(piece as usize) {
            Some(Some([back, front, eye])) => {
                let there = if convex { *front } else { *back };
                // Fronts are crossed on the way to where it winds more often, backs to where less.
                there > *eye || (two_sided && there < *eye)
            }
            _ => false,
        }
    }
}

fn gathered(surface: &Surface, positions: &[DVec3]) -> Vec<Piece> {
    let count = surface.pieces.iter().max().map_or(0, |p| *p as usize + 1);
    let mut pieces: Vec<Option<Piece>> = vec![None; count];
    for (f, face) in surface.faces[..surface.real_faces].iter().enumerate() {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        let new = Piece { open: false, first: a, low: a, high: a, volume: 0.0 };
        let piece = pieces[surface.pieces[f] as usize].get_or_insert(new);
        piece.low = piece.low.min(a).min(b).min(c);
        piece.high = piece.high.max(a).max(b).max(c);
        let [a, b, c] = [a, b, c].map(|p| p - piece.first);
        piece.volume += a.dot(b.cross(c));
        piece.open |= surface.mate[3 * f..3 * f + 3].contains(&NONE);
    }
    pieces.into_iter().flatten().collect()
}

/// How often a closed piece winds around a point: the sum of the solid angles of its faces (van Oosterom
/// and Strackee 1983) over that of the sphere.
fn winding(surface: &Surface, positions: &[DVec3], piece: usize, at: DVec3) -> i32 {
    let of_piece = |f: &usize| surface.pieces[*f] as usize == piece;
    let angle = |f: usize| {
        let [a, b, c] = surface.faces[f].map(|v| positions[v as usize] - at);
        let [x, y, z] = [a.length(), b.length(), c.length()];
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    let sum: f64 = (0..surface.real_faces).filter(of_piece).map(angle).sum();
    (sum / (4.0 * std::f64::consts::PI)).round() as i32
}
