//! [`Surface`]: all that is drawn as one oriented manifold with the same ids in every frame.
//!
//! 1. Each object's triangles are welded ([`chiaro_scene::topology`]) and wound alike; edges where
//!    more than two triangles meet, or where no winding agrees, are cut; coarse shapes are refined
//!    (`build`, `refine`).
//! 2. Creases are opened and closed again with a strip of no width (`bevel`): on both sides of a
//!    crease the vertices have normals of their own, and the strip turns from one to the other. The
//!    surface stays closed, and a silhouette runs along a sharp edge as along a round one. So are
//!    edges between flat-shaded faces, however little they bend, where a shape is coarse: its outline is that of
//!    its facets.
//! 3. Half-edge 3 f + c runs from corner c of face f to the next; `mate` is the one across.
//!
//! Guaranteed: every edge has one or two faces, neighbours wind alike, every vertex has one fan.
//! Ids depend on the scene and on the pose in which creases were found, never on threads.

mod bevel;
mod build;
mod fold;
mod refine;
mod ring;

pub use build::CreaseRule;
pub use refine::Refinement;
pub use ring::Ring;

pub(crate) use fold::Fold;

use crate::stroke::Owner;
use chiaro_scene::{Frame, MaterialId, Scene};

/// No half-edge, no face.
pub const NONE: u32 = u32::MAX;

/// Where a vertex's position comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Anchor {
    /// Index into [`Frame::objects`].
    pub object: u32,
    /// Index into the shape's positions; where the shape is refined, into its points.
    pub vertex: u32,
}

/// Which triangle of the scene a face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Index into [`Frame::objects`].
    pub object: u32,
    /// Index into the mesh's triangles.
    pub face: u32,
    /// Which part of a refined triangle: one base-four digit a level, after a leading 1.
    pub part: u16,
    /// Whether it was turned over to agree with its neighbours.
    pub turned: bool,
    /// Whether its object mirrors.
    pub mirrored: bool,
    /// Its material.
    pub material: MaterialId,
    /// Whether it is seen from its back.
    pub two_sided: bool,
    /// Whether it hides what is behind it: it is not see-through all over.
    pub opaque: bool,
}

/// How closely a shape is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Detail {
    /// How often it is refined.
    pub levels: u8,
    /// Whether edges that the file shades hard are opened however little they bend, so that
    /// silhouettes run along the facets that are seen.
    pub facets: bool,
}

/// A crease: two half-edges of real faces with a strip between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crease {
    /// The half-edge on one side.
    pub left: u32,
    /// The half-edge on the other; it runs the other way.
    pub right: u32,
    /// Whether it bends enough to be a line of its own; silhouettes run along others too.
    pub sharp: bool,
}

/// An oriented manifold made of everything that is drawn.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Where each vertex is.
    pub anchors: Vec<Anchor>,
    /// Vertices of each face, counter-clockwise seen from the front. Real faces come first, then
    /// the strips'.
    pub faces: Vec<[u32; 3]>,
    /// How many faces are real.
    pub real_faces: usize,
    /// The triangle behind each real face.
    pub sources: Vec<Source>,
    /// The half-edge across each half-edge, or [`NONE`] on borders.
    pub mate: Vec<u32>,
    /// The edge under each half-edge.
    pub edge: Vec<u32>,
    /// One half-edge of each edge: the lower.
    pub half: Vec<u32>,
    /// A half-edge out of each vertex; on borders the one from which the whole fan can be walked.
    pub out: Vec<u32>,
    /// The creases.
    pub creases: Vec<Crease>,
    /// The crease of each face of a strip, or [`NONE`] for those that fill corners.
    pub strips: Vec<u32>,
    /// What had to be cut or turned over, in sentences.
    pub notes: Vec<String>,
    /// Which connected piece each real face is a part of.
    pub pieces: Vec<u32>,
    /// How the points of each shape of the frame are found, where it is refined.
    pub refinements: Vec<Option<Refinement>>,
}

impl Surface {
    /// What a line on some faces belongs to.
    pub fn owner(&self, faces: [u32; 2]) -> Option<Owner> {
        let source = faces.iter().find_map(|f| self.sources.get(*f as usize))?;
        Some(Owner { object: source.object, material: source.material })
    }

    /// Whether a face that shows its front or its back to the camera hides what is behind it.
    pub(crate) fn hides(&self, face: usize, front: bool) -> bool {
        let source = &self.sources[face];
        source.opaque && (source.two_sided || front != source.turned)
    }

    /// The surface of what a frame draws; `rule` says what a crease is in this pose.
    pub fn of(scene: &Scene, frame: &Frame, rule: &CreaseRule) -> Self {
        Self::refined(scene, frame, rule, &[])
    }

    /// The same, each shape of the frame followed as closely as `details` says (by its triangles as
    /// they are if it says nothing).
    pub fn refined(scene: &Scene, frame: &Frame, rule: &CreaseRule, details: &[Detail]) -> Self {
        build::surface(scene, frame, rule, details)
    }

    /// Where a half-edge begins.
    pub fn from(&self, half: u32) -> u32 {
        self.faces[half as usize / 3][half as usize % 3]
    }

    /// Where a half-edge ends.
    pub fn to(&self, half: u32) -> u32 {
        self.from(next(half))
    }

    /// The two ends of an edge, in the direction of its lower half-edge.
    pub fn ends(&self, edge: u32) -> [u32; 2] {
        let half = self.half[edge as usize];
        [self.from(half), self.to(half)]
    }

    /// Whether a face is part of a crease's strip.
    pub fn is_strip(&self, face: usize) -> bool {
        face >= self.real_faces
    }

    /// The crease whose strip a face is part of.
    pub fn crease_of(&self, face: usize) -> Option<Crease> {
        let crease = *self.strips.get(face.checked_sub(self.real_faces)?)?;
        self.creases.get(crease as usize).copied()
    }

    /// The crease of which a half-edge of a real face is a side.
    pub fn crease_at(&self, half: u32) -> Option<Crease> {
        let mate = self.mate[half as usize];
        if mate == NONE { None } else { self.crease_of(mate as usize / 3) }
    }

    /// The half-edge of a real face across one of a real face, beyond the strip if it is a crease's.
    pub fn across(&self, half: u32) -> u32 {
        match self.crease_at(half) {
            Some(c) if c.left == half => c.right,
            Some(c) => c.left,
            None => self.mate[half as usize],
        }
    }

    /// Whether an edge has one face alone.
    pub fn is_border(&self, edge: u32) -> bool {
        self.mate[self.half[edge as usize] as usize] == NONE
    }

    /// Vertices - edges + faces.
    pub fn euler_characteristic(&self) -> i64 {
        self.anchors.len() as i64 - self.half.len() as i64 + self.faces.len() as i64
    }

    /// Numbers edges and fans, once faces and mates are known.
    fn finish(&mut self) {
        let halves = 3 * self.faces.len();
        self.edge = vec![NONE; halves];
        self.half.clear();
        for h in 0..halves as u32 {
            let mate = self.mate[h as usize];
            self.edge[h as usize] = if mate < h {
                self.edge[mate as usize]
            } else {
                self.half.push(h);
                self.half.len() as u32 - 1
            };
        }
        self.out = vec![NONE; self.anchors.len()];
        for h in 0..halves as u32 {
            let slot = &mut self.out[self.faces[h as usize / 3][h as usize % 3] as usize];
            if *slot == NONE || self.mate[h as usize] == NONE {
                *slot = h;
            }
        }
    }
}

/// The half-edge after this one in its face.
pub fn next(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

/// The half-edge before this one in its face.
pub fn previous(half: u32) -> u32 {
    if half.is_multiple_of(3) { half + 2 } else { half - 1 }
}
