//! Objects to one oriented manifold.

use super::bevel::{self, Corners};
use super::fold::{Fold, folds, is_faceted};
use super::refine::{Net, Origin, Refinement};
use super::{Anchor, Detail, NONE, Source, Surface};
use chiaro_basis::math::Vec3;
use chiaro_scene::topology::weld::Weld;
use chiaro_scene::topology::{EdgeKind, Side, Topology};
use chiaro_scene::{Alpha, Frame, Material, Mesh, Object, Scene};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

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
    net: Net,
    /// The vertex of the shape at each point, where it is not refined.
    first: Vec<u32>,
    refinement: Option<Refinement>,
    notes: Vec<String>,
}

pub(super) fn surface(
    scene: &Scene,
    frame: &Frame,
    rule: &CreaseRule,
    details: &[Detail],
) -> Surface {
    let mut corners = Corners::default();
    let mut notes = Vec::new();
    let mut parts: Vec<Option<Part>> = frame.shapes.iter().map(|_| None).collect();
    for (index, object) in frame.objects.iter().enumerate() {
        let shape = &frame.shapes[object.shape];
        let mesh = shape.mesh_in(scene);
        let part = parts[object.shape].get_or_insert_with(|| {
            let detail = details.get(object.shape).copied().unwrap_or_default();
            let part = Part::of(mesh, &shape.positions, rule, detail);
            notes.extend(part.notes.iter().cloned());
            part
        });
        append(&mut corners, part, scene, mesh, (index, object));
    }
    let mut surface = bevel::surface(corners);
    surface.notes = notes;
    let refinements = parts.into_iter().map(|p| p.and_then(|p| p.refinement));
    surface.refinements = refinements.collect();
    surface
}

impl Part {
    fn of(mesh: &Mesh, positions: &[Vec3], rule: &CreaseRule, detail: Detail) -> Self {
        let twins = Twins::of(mesh);
        let single = twins.without(mesh);
        let mesh = single.as_ref().unwrap_or(mesh);
        let topology = Topology::of(mesh);
        let turned = wind_alike(&topology);
        let joined: Vec<bool> =
            (0..topology.edges.len()).map(|e| joins(&topology, &turned, e)).collect();
        let folds = folds(&topology, mesh, positions, rule, detail.facets);
        let notes = notes(mesh, &topology, &turned);
        let net = net(&topology, &turned, (&joined, &folds), &twins);
        let plane = detail.facets && is_faceted(&topology, mesh, positions, &folds);
        let first = topology.weld.first;
        if detail.levels == 0 || plane {
            return Self { net, first, refinement: None, notes };
        }
        let (refinement, net) = Refinement::of(net, &first, positions, detail.levels);
        Self { net, first, refinement: Some(refinement), notes }
    }
}

fn notes(mesh: &Mesh, topology: &Topology, turned: &[bool]) -> Vec<String> {
    let name = if mesh.name.is_empty() { "a mesh" } else { &mesh.name };
    let mut notes = Vec::new();
    let several =
        (0..topology.edges.len()).filter(|&e| topology.kind(e) == EdgeKind::NonManifold).count();
    if several > 0 {
        notes.push(format!(
            "{name}: {several} edges join more than two triangles; the surface is cut there"
        ));
    }
    let turned = turned.iter().filter(|t| **t).count();
    if turned > 0 {
        notes.push(format!(
            "{name}: {turned} triangles wind against their neighbours; lines take them turned over"
        ));
    }
    notes
}

/// Triangles that a mesh has several times, as files do that model the two sides of a leaf or a
/// cloak: one of each is kept, seen from both sides.
struct Twins {
    /// For each kept triangle, its index in the mesh, and whether it is there with both windings.
    kept: Vec<(u32, bool)>,
    all: usize,
}

impl Twins {
    fn of(mesh: &Mesh) -> Self {
        let weld = Weld::of(mesh);
        let mut known: HashMap<[u32; 3], usize> = HashMap::with_capacity(mesh.triangles.len());
        let mut kept: Vec<(u32, bool)> = Vec::with_capacity(mesh.triangles.len());
        for (f, t) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = t.map(|v| weld.welded[v as usize]);
            let mut key = [a, b, c];
            key.sort_unstable();
            match known.entry(key) {
                Entry::Occupied(first) if a != b && b != c && c != a => {
                    let (other, both) = &mut kept[*first.get()];
                    let there = mesh.triangles[*other as usize].map(|v| weld.welded[v as usize]);
                    *both |= is_even(there) != is_even([a, b, c]);
                }
                Entry::Occupied(_) => kept.push((f as u32, false)),
                Entry::Vacant(slot) => {
                    slot.insert(kept.len());
                    kept.push((f as u32, false));
                }
            }
        }
        Self { kept, all: mesh.triangles.len() }
    }

    /// The mesh with one of each; `None` if it has no more.
    fn without(&self, mesh: &Mesh) -> Option<Mesh> {
        if self.kept.len() == self.all {
            return None;
        }
        let of = |i: &(u32, bool)| i.0 as usize;
        let polygons = match mesh.polygons.is_empty() {
            true => Vec::new(),
            false => self.kept.iter().map(|i| mesh.polygons[of(i)]).collect(),
        };
        Some(Mesh {
            triangles: self.kept.iter().map(|i| mesh.triangles[of(i)]).collect(),
            materials: self.kept.iter().map(|i| mesh.materials[of(i)]).collect(),
            polygons,
            ..mesh.clone()
        })
    }
}

/// Whether three different numbers can be sorted by turning them round.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    [a < b, b < c, c < a].into_iter().filter(|rises| *rises).count() == 2
}

/// The triangles of a topology, turned to wind alike, with their neighbours.
fn net(
    topology: &Topology,
    turned: &[bool],
    (joined, folds): (&[bool], &[Fold]),
    twins: &Twins,
) -> Net {
    let mut net = Net::default();
    let mut face_of = vec![NONE; topology.triangles.len()];
    let mut collapsed = topology.collapsed.iter().peekable();
    for (f, &[a, b, c]) in topology.triangles.iter().enumerate() {
        if collapsed.next_if(|&&c| c as usize == f).is_some() {
            continue;
        }
        face_of[f] = net.triangles.len() as u32;
        net.triangles.push(if turned[f] { [a, c, b] } else { [a, b, c] });
        let (face, twice) = twins.kept[f];
        net.origins.push(Origin { face, turned: turned[f], twice, part: 1 });
    }
    net.mate = vec![NONE; 3 * net.triangles.len()];
    net.folds = vec![Fold::Smooth; 3 * net.triangles.len()];
    for edge in (0..topology.edges.len()).filter(|&e| joined[e]) {
        let [a, b] = [topology.sides(edge)[0], topology.sides(edge)[1]].map(|s| {
            let corner = corner_listed(s.corner(), turned[s.face()]);
            3 * face_of[s.face()] as usize + corner
        });
        net.mate[a] = b as u32;
        net.mate[b] = a as u32;
        net.folds[a] = folds[edge];
        net.folds[b] = folds[edge];
    }
    net
}

/// The corner at which a side begins once corners a, b, c are listed a, c, b: sides ab, bc, ca
/// become ba, cb, ac.
fn corner_listed(corner: usize, against: bool) -> usize {
    if against { [2, 1, 0][corner] } else { corner }
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
    let (base_vertex, base_face) = (corners.anchors.len() as u32, corners.faces.len() as u32);
    let anchor = |vertex: u32| Anchor { object: index as u32, vertex };
    match &part.refinement {
        Some(refinement) => corners.anchors.extend((0..refinement.count() as u32).map(anchor)),
        None => corners.anchors.extend(part.first.iter().copied().map(anchor)),
    }
    let net = &part.net;
    for (t, origin) in net.triangles.iter().zip(&net.origins) {
        let [a, b, c] = t.map(|v| v + base_vertex);
        corners.faces.push(if object.mirrored { [a, c, b] } else { [a, b, c] });
        let material = mesh.materials[origin.face as usize];
        corners.sources.push(Source {
            object: index as u32,
            face: origin.face,
            part: origin.part,
            turned: origin.turned,
            mirrored: object.mirrored,
            material,
            two_sided: origin.twice || scene.materials[material.index()].double_sided,
            opaque: is_opaque(&scene.materials[material.index()]),
        });
    }
    corners.mate.resize(3 * corners.faces.len(), NONE);
    corners.folds.resize(3 * corners.faces.len(), Fold::Smooth);
    let placed =
        |h: u32| 3 * (base_face + h / 3) + corner_listed(h as usize % 3, object.mirrored) as u32;
    for h in 0..net.mate.len() as u32 {
        let at = placed(h) as usize;
        if net.mate[h as usize] != NONE {
            corners.mate[at] = placed(net.mate[h as usize]);
        }
        corners.folds[at] = net.folds[h as usize];
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
