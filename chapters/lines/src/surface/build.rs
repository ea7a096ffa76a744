//! Objects to one oriented manifold.

use super::bevel::{self, Corners};
use super::{Anchor, NONE, Source, Surface};
use chiaro_basis::math::Vec3;
use chiaro_scene::topology::{EdgeKind, Side, Topology, crease};
use chiaro_scene::{Alpha, Frame, Material, Mesh, NormalSource, Object, Scene};

/// Normals of the file that are further apart than this mark an edge as hard, radians.
const HARD_NORMALS: f32 = 0.1;

/// What a crease is: an edge that bends by more than an angle and that is shaded hard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreaseRule {
    /// The least bend, radians; an edge that is shaded smooth must bend by `smooth_angle`.
    pub angle: f32,
    /// The least bend of an edge that is shaded smooth, radians.
    pub smooth_angle: f32,
}

/// What is known of one shape, shared by the objects that draw it.
struct Part {
    topology: Topology,
    /// Whether each triangle is turned over.
    turned: Vec<bool>,
    /// Whether each edge is a crease.
    creased: Vec<bool>,
    /// Whether each edge joins its two triangles.
    joined: Vec<bool>,
}

pub(super) fn surface(scene: &Scene, frame: &Frame, rule: &CreaseRule) -> Surface {
    let mut corners = Corners::default();
    let mut notes = Vec::new();
    let mut parts: Vec<Option<Part>> = frame.shapes.iter().map(|_| None).collect();
    for (index, object) in frame.objects.iter().enumerate() {
        let shape = &frame.shapes[object.shape];
        let mesh = shape.mesh_in(scene);
        let part = parts[object.shape].get_or_insert_with(|| {
            let part = Part::of(mesh, &shape.positions, rule);
            part.note(mesh, &mut notes);
            part
        });
        append(&mut corners, part, scene, mesh, (index, object));
    }
    let mut surface = bevel::surface(corners);
    surface.notes = notes;
    surface
}

impl Part {
    fn of(mesh: &Mesh, positions: &[Vec3], rule: &CreaseRule) -> Self {
        let topology = Topology::of(mesh);
        let turned = wind_alike(&topology);
        let joined = (0..topology.edges.len()).map(|e| joins(&topology, &turned, e)).collect();
        let creased = creases(&topology, mesh, positions, rule);
        Self { topology, turned, creased, joined }
    }

    fn note(&self, mesh: &Mesh, notes: &mut Vec<String>) {
        let name = if mesh.name.is_empty() { "a mesh" } else { &mesh.name };
        let several = (0..self.topology.edges.len())
            .filter(|&e| self.topology.kind(e) == EdgeKind::NonManifold)
            .count();
        if several > 0 {
            notes.push(format!(
                "{name}: {several} edges join more than two triangles; the surface is cut there"
            ));
        }
        let turned = self.turned.iter().filter(|t| **t).count();
        if turned > 0 {
            notes.push(format!(
                "{name}: {turned} triangles wind against their neighbours; lines take them turned over"
            ));
        }
    }
}

fn creases(topology: &Topology, mesh: &Mesh, positions: &[Vec3], rule: &CreaseRule) -> Vec<bool> {
    let sharp = crease::by_angle(topology, positions, rule.smooth_angle);
    let bent = crease::by_angle(topology, positions, rule.angle);
    let shaded = match &mesh.normals {
        NormalSource::Given(normals) if normals.is_empty() => vec![true; bent.len()],
        _ => crease::by_normals(topology, mesh, HARD_NORMALS),
    };
    let of = |e: usize| sharp[e] || (bent[e] && shaded[e]);
    (0..topology.edges.len()).map(of).collect()
}

/// For each triangle, whether to turn it over so that neighbours wind alike; in each piece the
/// smaller part is turned.
fn wind_alike(topology: &Topology) -> Vec<bool> {
    let count = topology.triangles.len();
    let mut turned = vec![false; count];
    let mut seen = vec![false; count];
    for first in 0..count {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let mut piece = vec![first];
        let mut at = 0;
        while at < piece.len() {
            let face = piece[at];
            at += 1;
            for corner in 0..3 {
                let side = Side::new(face, corner);
                let (Some(twin), Some(edge)) = (topology.twin(side), topology.edge(side)) else {
                    continue;
                };
                let other = twin.face();
                if !seen[other] {
                    seen[other] = true;
                    turned[other] = turned[face] == topology.is_consistent(edge);
                    piece.push(other);
                }
            }
        }
        let against = piece.iter().filter(|&&f| turned[f]).count();
        if 2 * against > piece.len() {
            piece.iter().for_each(|&f| turned[f] = !turned[f]);
        }
    }
    turned
}

/// Whether an edge has two triangles that wind alike once they are turned.
fn joins(topology: &Topology, turned: &[bool], edge: usize) -> bool {
    match *topology.sides(edge) {
        [a, b] => {
            a.face() != b.face()
                && topology.is_consistent(edge) == (turned[a.face()] == turned[b.face()])
        }
        _ => false,
    }
}

/// Adds an object's triangles.
fn append(
    corners: &mut Corners,
    part: &Part,
    scene: &Scene,
    mesh: &Mesh,
    (index, object): (usize, &Object),
) {
    let topology = &part.topology;
    let base_vertex = corners.anchors.len() as u32;
    let anchor = |&v: &u32| Anchor { object: index as u32, vertex: v };
    corners.anchors.extend(topology.weld.first.iter().map(anchor));
    let mut face_of = vec![NONE; topology.triangles.len()];
    let mut collapsed = topology.collapsed.iter().peekable();
    for (f, t) in topology.triangles.iter().enumerate() {
        if collapsed.next_if(|&&c| c as usize == f).is_some() {
            continue;
        }
        face_of[f] = corners.faces.len() as u32;
        let turned = part.turned[f];
        let [a, b, c] = t.map(|v| v + base_vertex);
        let clockwise = turned != object.mirrored;
        corners.faces.push(if clockwise { [a, c, b] } else { [a, b, c] });
        corners.sources.push(Source {
            object: index as u32,
            face: f as u32,
            turned,
            material: mesh.materials[f],
            two_sided: scene.materials[mesh.materials[f].index()].double_sided,
            opaque: is_opaque(&scene.materials[mesh.materials[f].index()]),
        });
        corners.clockwise.push(clockwise);
    }
    corners.mate.resize(3 * corners.faces.len(), NONE);
    corners.hard.resize(3 * corners.faces.len(), false);
    for edge in (0..topology.edges.len()).filter(|&e| part.joined[e]) {
        let [a, b] = [topology.sides(edge)[0], topology.sides(edge)[1]];
        let half = |s: Side| corners.half(face_of[s.face()], s.corner());
        let (ha, hb) = (half(a), half(b));
        corners.mate[ha as usize] = hb;
        corners.mate[hb as usize] = ha;
        corners.hard[ha as usize] = part.creased[edge];
        corners.hard[hb as usize] = part.creased[edge];
    }
}

/// Whether a material hides what is behind it, textures left aside.
fn is_opaque(material: &Material) -> bool {
    match material.alpha {
        Alpha::Opaque => true,
        Alpha::Mask(cutoff) => material.base_colour[3] >= cutoff,
        Alpha::Blend => material.base_colour[3] >= 0.5,
    }
}
