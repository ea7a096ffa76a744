//! A file's mesh: all of its primitives joined into one [`Mesh`].
//!
//! Attributes that only some primitives have are filled up for the others: white, no displacement,
//! the first joint. Where some have normals and some do not, the flat ones are given theirs at rest.
//! Tangents stay only if every primitive that reads a normal map has them.

use super::accessor::Accessors;
use super::context::{Context, Place};
use super::json::Value;
use super::primitive::{Renumbering, Source};
use super::triangles::{Drawing, drawing};
use crate::{Influences, Material, MaterialId, Mesh, Morph, NormalSource, Stored, normals};
use chiaro_basis::math::{Vec2, Vec3, Vec4};
use chiaro_basis::{Error, Result};

/// How a mesh is used by the nodes of a document.
#[derive(Clone, Copy)]
pub(super) struct Usage {
    /// Whether the default scene draws it.
    pub(super) drawn: bool,
    /// The joints of the smallest skin that bends it.
    pub(super) joints: Option<usize>,
}

/// All meshes, as many as the document has, and their counts as stored.
pub(super) fn read(
    root: &Value,
    accessors: &Accessors,
    materials: &[Material],
    usage: &[Usage],
    stored: &mut Stored,
    cx: &mut Context,
) -> Result<Vec<Mesh>> {
    let mut renumbering = Renumbering::default();
    let mut meshes = Vec::new();
    for (i, (item, usage)) in root.list("meshes").iter().zip(usage).enumerate() {
        let place = Place::new("mesh", i);
        count(item, accessors, stored);
        let reader = Reader { item, place, accessors, materials, usage: *usage };
        let mesh = match reader.mesh(&mut renumbering, cx) {
            Err(Error::Input { place: at, why, .. }) if !usage.drawn => {
                cx.note(place, format!("nothing draws it, and it is left out: {at}: {why}"));
                Mesh::default()
            }
            other => other?,
        };
        meshes.push(Mesh { name: item.name(), ..mesh });
    }
    Ok(meshes)
}

/// Adds a mesh to the counts as stored.
fn count(item: &Value, accessors: &Accessors, stored: &mut Stored) {
    let primitives = item.list("primitives");
    for primitive in primitives {
        let count = |v: Option<usize>| v.map(|i| accessors.count(i));
        let vertices = count(primitive.get("attributes").get("POSITION").as_whole()).unwrap_or(0);
        let corners = count(primitive.get("indices").as_whole()).unwrap_or(vertices);
        stored.vertices = stored.vertices.saturating_add(vertices as u64);
        if let Drawing::Triangles(mode) = drawing(primitive) {
            stored.triangles = stored.triangles.saturating_add(mode.triangles(corners) as u64);
        }
    }
    let targets = primitives.iter().map(|p| p.list("targets").len() as u64).max();
    stored.morph_targets += targets.unwrap_or(0);
}

struct Reader<'s, 'r, 'b> {
    item: &'s Value<'r>,
    place: Place,
    accessors: &'s Accessors<'r, 'b>,
    materials: &'s [Material],
    usage: Usage,
}

impl Reader<'_, '_, '_> {
    fn mesh(&self, renumbering: &mut Renumbering, cx: &mut Context) -> Result<Mesh> {
        let mut parts = Vec::new();
        for (i, primitive) in self.item.list("primitives").iter().enumerate() {
            let place = self.place.part("primitive", i);
            let mode = match drawing(primitive) {
                Drawing::Triangles(mode) => mode,
                Drawing::PointsOrLines => {
                    cx.note(place, "points and lines are not drawn");
                    continue;
                }
                Drawing::Unknown => {
                    cx.note(place, "its mode is none of glTF's, and it is left out");
                    continue;
                }
            };
            let source = Source {
                accessors: self.accessors,
                primitive,
                place,
                material: self.material(primitive, place, cx),
                joints: self.usage.joints,
            };
            let part = source.mesh(mode, renumbering, cx)?;
            if !part.triangles.is_empty() {
                parts.push(part);
            }
        }
        join(parts, self.place, self.materials, cx)
    }

    /// The material of a primitive; the default one comes before those of the file.
    fn material(&self, primitive: &Value, place: Place, cx: &mut Context) -> MaterialId {
        let index = primitive.index("material", self.materials.len() - 1);
        let index = index.unwrap_or_else(|why| {
            cx.note(place, format!("{why}; the default material stands in"));
            None
        });
        MaterialId::new(index.map_or(0, |i| i + 1))
    }
}

/// One mesh from parts that have triangles.
fn join(
    mut parts: Vec<Mesh>,
    place: Place,
    materials: &[Material],
    cx: &mut Context,
) -> Result<Mesh> {
    if parts.len() <= 1 {
        return Ok(parts.pop().unwrap_or_default());
    }
    fill_tangents(&mut parts, materials);
    let mut joiner =
        Joiner { counts: parts.iter().map(|p| p.positions.len()).collect(), place, cx };
    let mut mesh = Mesh {
        normals: joiner.normals(&mut parts)?,
        positions: joiner.column(&mut parts, |p| &mut p.positions, Vec3::ZERO)?,
        tangents: joiner.column(&mut parts, |p| &mut p.tangents, Vec4::ZERO)?,
        colours: joiner.column(&mut parts, |p| &mut p.colours, Vec4::ONE)?,
        ..Mesh::default()
    };
    let most = |count: fn(&Mesh) -> usize| parts.iter().map(count).max().unwrap_or(0);
    let (uvs, sets, morphs) =
        (most(|p| p.uvs.len()), most(|p| p.influences.joints.len()), most(|p| p.morphs.len()));
    for i in 0..uvs {
        mesh.uvs.push(joiner.column(&mut parts, |p| slot(&mut p.uvs, i), Vec2::ZERO)?);
    }
    mesh.influences = joiner.influences(&mut parts, sets)?;
    for i in 0..morphs {
        mesh.morphs.push(joiner.morph(&mut parts, i)?);
    }
    joiner.faces(&mut mesh, parts)?;
    Ok(mesh)
}

/// Gives parts without tangents some, where no normal map reads them; else takes all away.
fn fill_tangents(parts: &mut [Mesh], materials: &[Material]) {
    let reads = |p: &Mesh| {
        p.materials.first().is_some_and(|m| materials[m.index()].normal_texture.is_some())
    };
    let derive = parts.iter().any(|p| p.tangents.is_empty() && reads(p));
    let any = parts.iter().any(|p| !p.tangents.is_empty());
    for part in parts {
        if derive {
            part.tangents.clear();
            part.morphs.iter_mut().for_each(|m| m.tangents.clear());
        } else if any && part.tangents.is_empty() {
            part.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); part.positions.len()];
        }
    }
}

/// The `i`-th column, made if there is none.
fn slot<T: Default>(columns: &mut Vec<T>, i: usize) -> &mut T {
    if columns.len() <= i {
        columns.resize_with(i + 1, T::default);
    }
    &mut columns[i]
}

/// Joins columns of parts, each with so many vertices.
struct Joiner<'j, 'c, 'd> {
    counts: Vec<usize>,
    place: Place,
    cx: &'j mut Context<'c, 'd>,
}

impl Joiner<'_, '_, '_> {
    /// One column of all parts, `fill` where a part has none; empty where none has.
    fn column<T: Copy>(
        &mut self,
        parts: &mut [Mesh],
        column: impl Fn(&mut Mesh) -> &mut Vec<T>,
        fill: T,
    ) -> Result<Vec<T>> {
        if parts.iter_mut().all(|p| column(p).is_empty()) {
            return Ok(Vec::new());
        }
        let total = self.counts.iter().sum();
        self.cx.hold::<T>(self.place, total)?;
        let mut joined = Vec::with_capacity(total);
        for (part, count) in parts.iter_mut().zip(&self.counts) {
            let values = std::mem::take(column(part));
            let missing = count - values.len();
            joined.extend(values);
            joined.extend(std::iter::repeat_n(fill, missing));
        }
        Ok(joined)
    }

    fn normals(&mut self, parts: &mut [Mesh]) -> Result<NormalSource> {
        let flat = |p: &Mesh| matches!(p.normals, NormalSource::Faces(_));
        if parts.iter().all(flat) {
            let total: usize = self.counts.iter().sum();
            self.cx.hold::<u32>(self.place, total)?;
            return Ok(NormalSource::Faces((0..total as u32).collect()));
        }
        for part in parts.iter_mut() {
            if let NormalSource::Faces(groups) = &part.normals {
                self.cx.hold::<[Vec3; 4]>(self.place, part.triangles.len() + groups.len())?;
                let faces = normals::of_faces(&part.positions, &part.triangles, groups);
                part.normals = NormalSource::Given(faces);
            }
        }
        let given = |p: &mut Mesh| match &mut p.normals {
            NormalSource::Given(normals) => std::mem::take(normals),
            NormalSource::Faces(_) => Vec::new(),
        };
        let all: Vec<Vec<Vec3>> = parts.iter_mut().map(given).collect();
        self.cx.hold::<Vec3>(self.place, self.counts.iter().sum())?;
        Ok(NormalSource::Given(all.concat()))
    }

    fn influences(&mut self, parts: &mut [Mesh], sets: usize) -> Result<Influences> {
        let mut joined = Influences::default();
        for i in 0..sets {
            let first = [if i == 0 { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0];
            let joints = self.column(parts, |p| slot(&mut p.influences.joints, i), [0; 4])?;
            let has = |p: &Mesh| !p.influences.weights.is_empty();
            let filled = parts.iter().any(|p| !has(p)) && i == 0;
            if filled {
                self.cx.note(self.place, "a primitive without joints follows the first");
            }
            let weights = self.column(parts, |p| slot(&mut p.influences.weights, i), first)?;
            joined.joints.push(joints);
            joined.weights.push(weights);
        }
        Ok(joined)
    }

    fn morph(&mut self, parts: &mut [Mesh], i: usize) -> Result<Morph> {
        Ok(Morph {
            positions: self.column(parts, |p| &mut slot(&mut p.morphs, i).positions, Vec3::ZERO)?,
            normals: self.column(parts, |p| &mut slot(&mut p.morphs, i).normals, Vec3::ZERO)?,
            tangents: self.column(parts, |p| &mut slot(&mut p.morphs, i).tangents, Vec3::ZERO)?,
        })
    }

    fn faces(&mut self, mesh: &mut Mesh, parts: Vec<Mesh>) -> Result<()> {
        let total = parts.iter().map(|p| p.triangles.len()).sum();
        self.cx.hold::<([u32; 3], MaterialId)>(self.place, total)?;
        let mut start = 0;
        for (part, count) in parts.into_iter().zip(&self.counts) {
            mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + start)));
            mesh.materials.extend(part.materials);
            start += *count as u32;
        }
        Ok(())
    }
}
