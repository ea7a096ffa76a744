//! One primitive of a mesh, as a [`Mesh`] of its own.
//!
//! 1. Mode and indices make triangles; those with a corner that is not finite are left out.
//! 2. Only vertices that triangles use are kept, so that primitives which share long accessors cost
//!    no more than they draw. The file's order stays.
//! 3. Without normals, each triangle gets three vertices of its own: it is flat (glTF 2.0, 3.7.2.1).
//! 4. Attributes are read at the kept vertices. A broken one is left out with a note, for the
//!    shape stands without it; only positions and indices must be sound.

use super::accessor::{Accessor, Accessors, named};
use super::context::{Context, Place};
use super::influences;
use super::json::Value;
use super::requirements::unsupported;
use super::triangles::{Mode, triangles};
use crate::{MaterialId, Mesh, Morph, NormalSource, normals};
use chiaro_basis::math::{Vec2, Vec3, Vec4};
use chiaro_basis::{Error, Result};

/// Sets of texture coordinates beyond these are not read.
pub(super) const UV_SETS: usize = 8;

/// Coordinates beyond this count as not finite: their squares' squares would not be.
const FARTHEST: f32 = 1e18;

const DRACO: &str = "KHR_draco_mesh_compression";

/// Numbers old vertices anew; one table serves all primitives of a document.
#[derive(Default)]
pub(super) struct Renumbering {
    /// In which round a vertex was seen last, and its number then.
    seen: Vec<(u32, u32)>,
    round: u32,
}

impl Renumbering {
    /// Makes `triangles` count the vertices they use, and returns which those are, rising.
    fn compact(
        &mut self,
        triangles: &mut [[u32; 3]],
        place: Place,
        cx: &mut Context,
    ) -> Result<Vec<u32>> {
        let Some(last) = triangles.iter().flatten().max() else { return Ok(Vec::new()) };
        let length = *last as usize + 1;
        if length > self.seen.len() {
            cx.hold::<(u32, u32)>(place, length - self.seen.len())?;
            self.seen.resize(length, (0, 0));
        }
        self.round += 1;
        let mut used = Vec::new();
        for v in triangles.iter().flatten() {
            if self.seen[*v as usize].0 != self.round {
                self.seen[*v as usize].0 = self.round;
                used.push(*v);
            }
        }
        used.sort_unstable();
        for (new, old) in used.iter().enumerate() {
            self.seen[*old as usize].1 = new as u32;
        }
        triangles.iter_mut().flatten().for_each(|v| *v = self.seen[*v as usize].1);
        Ok(used)
    }
}

/// What reading a primitive needs.
pub(super) struct Source<'s, 'r, 'b> {
    pub(super) accessors: &'s Accessors<'r, 'b>,
    pub(super) primitive: &'s Value<'r>,
    pub(super) place: Place,
    pub(super) material: MaterialId,
    /// Joints that vertices may follow; `None` where no skin bends the mesh.
    pub(super) joints: Option<usize>,
}

/// The vertices that are kept of a primitive, for reading its attributes.
pub(super) struct Kept<'k> {
    /// Which of the stored vertices, in any order.
    pub(super) picks: &'k [u32],
    /// How many are stored.
    stored: usize,
    pub(super) place: Place,
}

impl<'s, 'b> Source<'s, '_, 'b> {
    /// The primitive, drawn by `mode`; without triangles where it has no positions.
    pub(super) fn mesh(
        &self,
        mode: Mode,
        renumbering: &mut Renumbering,
        cx: &mut Context,
    ) -> Result<Mesh> {
        self.not_only_draco(cx)?;
        let attributes = self.primitive.get("attributes");
        let place = self.place;
        let Some(positions) = named(attributes, "POSITION", place, self.accessors, cx)? else {
            cx.note(place, "it has no positions and is left out");
            return Ok(Mesh::default());
        };
        let indices = named(self.primitive, "indices", place, self.accessors, cx)?;
        let mut faces = triangles(mode, indices.as_ref(), positions.count(), place, cx)?;
        let (mut picks, mut points) = self.points(&positions, &mut faces, renumbering, cx)?;
        let flat = attributes.get("NORMAL").as_whole().is_none();
        if flat {
            (picks, points) = split(&mut faces, &picks, &points, place, cx)?;
        }
        let kept = Kept { picks: &picks, stored: positions.count(), place };
        let targets = self.primitive.list("targets");
        cx.spend("vertices", |b| &mut b.vertices, picks.len().saturating_mul(1 + targets.len()))?;
        cx.hold::<MaterialId>(place, faces.len())?;
        let mut mesh = Mesh {
            materials: vec![self.material; faces.len()],
            triangles: faces,
            positions: points,
            ..Mesh::default()
        };
        mesh.normals = self.normals(&mesh, &kept, cx)?;
        self.attributes(&mut mesh, &kept, cx)?;
        mesh.morphs = self.morphs(&mesh, &kept, cx)?;
        Ok(mesh)
    }

    /// [`Error::Input`] where all data is compressed by Draco.
    fn not_only_draco(&self, cx: &mut Context) -> Result<()> {
        if !self.primitive.extension(DRACO).is_object() {
            return Ok(());
        }
        let has_data = |item: &Value, key: &str| match item.get(key).as_whole() {
            Some(index) => self.accessors.has_data(index),
            None => true,
        };
        let attributes = self.primitive.get("attributes");
        if has_data(attributes, "POSITION") && has_data(self.primitive, "indices") {
            cx.remark("Draco data is passed over for the uncompressed data beside it");
            return Ok(());
        }
        Err(unsupported(cx, DRACO))
    }

    /// Which vertices are used, and where they are; faces with one that is not finite are left out.
    fn points(
        &self,
        positions: &Accessor,
        faces: &mut Vec<[u32; 3]>,
        renumbering: &mut Renumbering,
        cx: &mut Context,
    ) -> Result<(Vec<u32>, Vec<Vec3>)> {
        let all = faces.len();
        let picks = renumbering.compact(faces, self.place, cx)?;
        let points = vectors(positions.floats(&picks, cx)?);
        let sound = |p: &Vec3| p.is_finite() && p.abs().max_element() < FARTHEST;
        let wrong = points.iter().filter(|p| !sound(p)).count();
        if wrong == 0 {
            return Ok((picks, points));
        }
        faces.retain(|f| f.iter().all(|v| sound(&points[*v as usize])));
        let gone = all - faces.len();
        cx.note(
            self.place,
            format!("{wrong} vertices are not finite; {gone} triangles are left out"),
        );
        let again = renumbering.compact(faces, self.place, cx)?;
        let points = again.iter().map(|v| points[*v as usize]).collect();
        Ok((again.iter().map(|v| picks[*v as usize]).collect(), points))
    }

    /// The numbers of an attribute at the kept vertices; `None` where there is none or it is broken.
    fn optional<const N: usize>(
        &self,
        name: &str,
        kept: &Kept,
        cx: &mut Context,
    ) -> Result<Option<Vec<[f32; N]>>> {
        let accessor = sound(self.primitive.get("attributes"), name, kept, self.accessors, cx)?;
        let Some(accessor) = accessor else { return Ok(None) };
        survive(accessor.floats(kept.picks, cx), name, kept.place, cx)
    }

    fn normals(&self, mesh: &Mesh, kept: &Kept, cx: &mut Context) -> Result<NormalSource> {
        let own = |n: usize| (0..n as u32).collect::<Vec<u32>>();
        let Some(given) = self.optional("NORMAL", kept, cx)? else {
            cx.hold::<u32>(kept.place, kept.picks.len())?;
            return Ok(NormalSource::Faces(own(kept.picks.len())));
        };
        let mut given = vectors(given);
        let unit = |n: &Vec3| n.is_finite().then(|| n.try_normalize()).flatten();
        let wrong = given.iter().filter(|n| unit(n).is_none()).count();
        if wrong > 0 {
            cx.note(
                kept.place,
                format!("{wrong} normals have no direction; their faces give them one"),
            );
            cx.hold::<[Vec3; 4]>(kept.place, mesh.triangles.len() + given.len())?;
            let faces = normals::of_faces(&mesh.positions, &mesh.triangles, &own(given.len()));
            let filled = given.iter().zip(faces).map(|(n, face)| unit(n).unwrap_or(face));
            return Ok(NormalSource::Given(filled.collect()));
        }
        given.iter_mut().for_each(|n| *n = n.normalize());
        Ok(NormalSource::Given(given))
    }

    fn attributes(&self, mesh: &mut Mesh, kept: &Kept, cx: &mut Context) -> Result<()> {
        let has_normals = matches!(mesh.normals, NormalSource::Given(_));
        let attributes = self.primitive.get("attributes");
        if has_normals && let Some(tangents) = self.optional("TANGENT", kept, cx)? {
            mesh.tangents = tangents.into_iter().map(tangent).collect();
        }
        for set in 0..UV_SETS {
            let name = format!("TEXCOORD_{set}");
            if let Some(uvs) = self.optional(&name, kept, cx)? {
                mesh.uvs.resize(set, vec![Vec2::ZERO; kept.picks.len()]);
                let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
                mesh.uvs.push(uvs.into_iter().map(|uv| finite(Vec2::from(uv))).collect());
            }
        }
        if let Some(accessor) = sound(attributes, "COLOR_0", kept, self.accessors, cx)? {
            mesh.colours = colours(&accessor, kept, cx)?;
        }
        if let Some(joints) = self.joints {
            mesh.influences = influences::read(attributes, joints, kept, self.accessors, cx)?;
        }
        Ok(())
    }

    fn morphs(&self, mesh: &Mesh, kept: &Kept, cx: &mut Context) -> Result<Vec<Morph>> {
        let targets = self.primitive.list("targets");
        cx.hold::<Morph>(kept.place, targets.len())?;
        let mut morphs = Vec::with_capacity(targets.len());
        for (i, target) in targets.iter().enumerate() {
            let kept = Kept { place: self.place.part("target", i), ..*kept };
            let mut read = |name: &str, wanted: bool| -> Result<Vec<Vec3>> {
                if !wanted {
                    return Ok(Vec::new());
                }
                let Some(accessor) = sound(target, name, &kept, self.accessors, cx)? else {
                    return Ok(Vec::new());
                };
                let deltas = survive(accessor.floats(kept.picks, cx), name, kept.place, cx)?;
                let finite = |d: Vec3| {
                    if d.is_finite() && d.abs().max_element() < FARTHEST { d } else { Vec3::ZERO }
                };
                Ok(vectors(deltas.unwrap_or_default()).into_iter().map(finite).collect())
            };
            morphs.push(Morph {
                positions: read("POSITION", true)?,
                normals: read("NORMAL", matches!(mesh.normals, NormalSource::Given(_)))?,
                tangents: read("TANGENT", !mesh.tangents.is_empty())?,
            });
        }
        Ok(morphs)
    }
}

/// Three vertices of its own for each face: which stored vertices they are, and where.
fn split(
    faces: &mut [[u32; 3]],
    picks: &[u32],
    points: &[Vec3],
    place: Place,
    cx: &mut Context,
) -> Result<(Vec<u32>, Vec<Vec3>)> {
    cx.hold::<[(u32, Vec3); 3]>(place, faces.len())?;
    let corners = || faces.iter().flatten().map(|v| *v as usize);
    let split = (corners().map(|v| picks[v]).collect(), corners().map(|v| points[v]).collect());
    for (i, face) in faces.iter_mut().enumerate() {
        *face = [0, 1, 2].map(|c| 3 * i as u32 + c);
    }
    Ok(split)
}

/// The accessor of an attribute, if it is sound and has an element for every stored vertex.
pub(super) fn sound<'b>(
    attributes: &Value,
    name: &str,
    kept: &Kept,
    accessors: &Accessors<'_, 'b>,
    cx: &mut Context,
) -> Result<Option<Accessor<'b>>> {
    let accessor =
        survive(named(attributes, name, kept.place, accessors, cx), name, kept.place, cx)?;
    let Some(accessor) = accessor.flatten() else { return Ok(None) };
    if accessor.count() < kept.stored {
        let (has, stored) = (accessor.count(), kept.stored);
        cx.note(
            kept.place,
            format!("{name} is ignored: it has {has} elements for {stored} vertices"),
        );
        return Ok(None);
    }
    Ok(Some(accessor))
}

/// Makes wrong input a note; other errors stay.
pub(super) fn survive<T>(
    read: Result<T>,
    name: &str,
    place: Place,
    cx: &mut Context,
) -> Result<Option<T>> {
    match read {
        Ok(value) => Ok(Some(value)),
        Err(Error::Input { place: at, why, .. }) => {
            let why = why.strip_suffix("; export the scene again").unwrap_or(&why);
            cx.note(place, format!("{name} is ignored: {at}: {why}"));
            Ok(None)
        }
        Err(other) => Err(other),
    }
}

fn colours(accessor: &Accessor, kept: &Kept, cx: &mut Context) -> Result<Vec<Vec4>> {
    let sound = |c: f32| if c.is_finite() { c.max(0.0) } else { 1.0 };
    let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    let read = if accessor.width() == 3 {
        accessor.floats(kept.picks, cx).map(|c| c.into_iter().map(opaque).collect())
    } else {
        accessor.floats(kept.picks, cx)
    };
    let colours: Vec<[f32; 4]> = survive(read, "COLOR_0", kept.place, cx)?.unwrap_or_default();
    Ok(colours.into_iter().map(|c| Vec4::from(c.map(sound))).collect())
}

fn vectors(rows: Vec<[f32; 3]>) -> Vec<Vec3> {
    rows.into_iter().map(Vec3::from).collect()
}

/// A unit tangent with the sign of its bitangent.
fn tangent([x, y, z, w]: [f32; 4]) -> Vec4 {
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    let t = Vec3::new(x, y, z);
    let unit = if t.is_finite() { t.normalize_or(Vec3::X) } else { Vec3::X };
    unit.extend(sign)
}
