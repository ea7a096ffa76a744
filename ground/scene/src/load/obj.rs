//! Wavefront OBJ: polygons with texture coordinates, normals, materials, smoothing groups.
//!
//! Each `o` starts a mesh. Polygons are triangulated by cutting ears in their own plane and stay
//! known as polygons. Faces whose indices point nowhere are left out with a warning, as are faces
//! with a vertex that is not finite. Where a file has no normals, faces are smoothed by its
//! smoothing groups, or across edges that bend less than 40 degrees.

use super::Door;
use super::mtl::{self, Library};
use super::polygon::triangulate;
use crate::{MaterialId, Mesh, MeshId, Node, NormalSource, Scene, normals};
use chiaro_basis::Result;
use chiaro_basis::math::{Vec2, Vec3, Vec4, vec2};
use std::collections::HashMap;

/// Faces that bend less are smoothed where a file says nothing: 40 degrees.
pub(crate) const CREASE: f32 = 0.698;

/// A face's corner: indices of position, texture coordinate and normal.
type Corner = (u32, Option<u32>, Option<u32>);

/// What the lines so far have defined.
#[derive(Default)]
struct Pool {
    positions: Vec<Vec3>,
    colours: Vec<Option<Vec3>>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
}

/// A polygon.
struct Face {
    corners: Vec<Corner>,
    material: MaterialId,
    smoothing: Option<u32>,
}

/// One `o`.
#[derive(Default)]
struct Object {
    name: String,
    faces: Vec<Face>,
}

struct Reader<'a, 'b> {
    door: &'a mut Door<'b>,
    pool: Pool,
    objects: Vec<Object>,
    library: Library,
    material: MaterialId,
    smoothing: Option<u32>,
    skipped: u64,
    triangles: u64,
}

/// Reads an OBJ file and the material libraries that it names.
pub(super) fn read(bytes: &[u8], door: &mut Door) -> Result<Scene> {
    let mut reader = Reader {
        door,
        pool: Pool::default(),
        objects: vec![Object::default()],
        library: Library::new(),
        material: MaterialId::new(0),
        smoothing: None,
        skipped: 0,
        triangles: 0,
    };
    let text = String::from_utf8_lossy(bytes);
    for line in logical_lines(&text) {
        reader.line(&line)?;
    }
    reader.scene()
}

/// Lines with their continuations joined and comments cut off.
fn logical_lines(text: &str) -> impl Iterator<Item = std::borrow::Cow<'_, str>> {
    let mut lines = text.lines();
    std::iter::from_fn(move || {
        let first = lines.next()?;
        if !first.trim_end().ends_with('\\') {
            return Some(first.split('#').next().unwrap_or_default().into());
        }
        let mut joined = first.trim_end().trim_end_matches('\\').to_owned();
        for next in lines.by_ref() {
            joined.push(' ');
            joined += next.trim_end().trim_end_matches('\\');
            if !next.trim_end().ends_with('\\') {
                break;
            }
        }
        Some(joined.split('#').next().unwrap_or_default().to_owned().into())
    })
}

impl Reader<'_, '_> {
    fn line(&mut self, line: &str) -> Result<()> {
        let line = line.trim();
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match key {
            "v" => self.vertex(rest)?,
            "vt" => {
                let [u, v] = numbers::<2>(rest);
                self.pool.uvs.push(vec2(u, 1.0 - v));
            }
            "vn" => self.pool.normals.push(Vec3::from(numbers::<3>(rest))),
            "f" => self.face(rest)?,
            "o" => self.object(rest),
            "s" => self.smoothing = Some(rest.parse().unwrap_or(0)),
            "usemtl" => self.material = self.library.find(rest),
            "mtllib" => self.library.load(rest, self.door)?,
            _ => {}
        }
        Ok(())
    }

    fn vertex(&mut self, rest: &str) -> Result<()> {
        self.door.spend("vertices", |b| &mut b.vertices, 1)?;
        let mut n = [f32::NAN; 7];
        let count = read_numbers(rest, &mut n);
        // x y z, x y z w, x y z r g b, x y z w r g b.
        let colour = match count {
            6 => Some(Vec3::new(n[3], n[4], n[5])),
            7 => Some(Vec3::new(n[4], n[5], n[6])),
            _ => None,
        };
        self.pool.positions.push(Vec3::new(n[0], n[1], n[2]));
        self.pool.colours.push(colour);
        Ok(())
    }

    fn object(&mut self, name: &str) {
        let current = self.objects.last_mut().expect("there is always one");
        if current.faces.is_empty() {
            current.name = name.into();
        } else {
            self.objects.push(Object { name: name.into(), faces: Vec::new() });
        }
    }

    fn face(&mut self, rest: &str) -> Result<()> {
        let corners: Option<Vec<Corner>> =
            rest.split_whitespace().map(|text| self.corner(text)).collect();
        let finite = |c: &Corner| self.pool.positions[c.0 as usize].is_finite();
        match corners.filter(|c| c.len() >= 3 && c.iter().all(finite)) {
            Some(corners) => {
                let triangles = corners.len() as u64 - 2;
                self.door.spend("triangles", |b| &mut b.triangles, triangles)?;
                self.triangles += triangles;
                let (material, smoothing) = (self.material, self.smoothing);
                let current = self.objects.last_mut().expect("there is always one");
                current.faces.push(Face { corners, material, smoothing });
            }
            None => self.skipped += 1,
        }
        Ok(())
    }

    /// `v`, `v/t`, `v//n` or `v/t/n`; negative indices count back from the last.
    fn corner(&self, text: &str) -> Option<Corner> {
        let mut parts = text.split('/');
        let mut index = |count: usize| -> Option<Option<u32>> {
            match parts.next() {
                None | Some("") => Some(None),
                Some(part) => {
                    let i: i64 = part.parse().ok()?;
                    let i = if i < 0 { count as i64 + i } else { i - 1 };
                    Some(u32::try_from(i).ok().filter(|i| (*i as usize) < count))
                }
            }
        };
        let v = index(self.pool.positions.len())??;
        let t = index(self.pool.uvs.len())?;
        let n = index(self.pool.normals.len())?;
        Some((v, t, n))
    }

    fn scene(mut self) -> Result<Scene> {
        let mut scene = self.library.scene();
        scene.stored.triangles = self.triangles;
        scene.stored.vertices = self.pool.positions.len() as u64;
        if self.skipped > 0 {
            scene.warnings.push(format!(
                "{}: {} faces point to vertices that are not there or not finite, and are left out",
                self.door.name, self.skipped
            ));
        }
        for object in std::mem::take(&mut self.objects) {
            if object.faces.is_empty() {
                continue;
            }
            let mesh = self.mesh(object);
            if mesh.triangles.is_empty() {
                continue;
            }
            let id = MeshId::new(scene.meshes.len());
            let name = mesh.name.clone();
            scene.nodes.push(Node { name, mesh: Some(id), ..Node::default() });
            scene.meshes.push(mesh);
        }
        Ok(scene)
    }

    /// The mesh of an object: one vertex for each corner that differs.
    fn mesh(&self, object: Object) -> Mesh {
        let given = object.faces.iter().all(|f| f.corners.iter().all(|c| c.2.is_some()))
            && !object.faces.iter().all(|f| self.is_flat(f));
        let has_uv = object.faces.iter().any(|f| f.corners.iter().any(|c| c.1.is_some()));
        let mut mesh = Mesh { name: object.name, ..Mesh::default() };
        let mut vertices: HashMap<Corner, u32> = HashMap::new();
        let mut order: Vec<Corner> = Vec::new();
        let mut smoothing = Vec::new();
        for (polygon, face) in object.faces.iter().enumerate() {
            let points: Vec<Vec3> =
                face.corners.iter().map(|c| self.pool.positions[c.0 as usize]).collect();
            for t in triangulate(&points) {
                let triangle = t.map(|i| {
                    let (v, uv, n) = face.corners[i];
                    let key = (v, uv, if given { n } else { None });
                    *vertices.entry(key).or_insert_with(|| {
                        order.push(key);
                        order.len() as u32 - 1
                    })
                });
                mesh.triangles.push(triangle);
                mesh.materials.push(face.material);
                mesh.polygons.push(polygon as u32);
                smoothing.push(face.smoothing.unwrap_or(0));
            }
        }
        self.fill(&mut mesh, &order, has_uv);
        if given {
            let normal = |c: &Corner| c.2.map_or(Vec3::Z, |n| self.pool.normals[n as usize]);
            mesh.normals = NormalSource::Given(
                order.iter().map(|c| normal(c).normalize_or(Vec3::Z)).collect(),
            );
        } else {
            let grouped = object.faces.iter().any(|f| f.smoothing.is_some_and(|s| s != 0));
            normals::smooth(&mut mesh, CREASE, if grouped { &smoothing } else { &[] });
        }
        mesh
    }

    /// Whether a face's normals say no more than its corners: exporters write those for meshes that
    /// nobody meant to be faceted.
    fn is_flat(&self, face: &Face) -> bool {
        let p = |i: usize| self.pool.positions[face.corners[i].0 as usize];
        let normal = (p(1) - p(0)).cross(p(2) - p(0)).normalize_or_zero();
        face.corners.iter().all(|c| {
            let given = c.2.map_or(Vec3::ZERO, |n| self.pool.normals[n as usize]);
            normal == Vec3::ZERO || given.normalize_or_zero().dot(normal) > 0.9999
        })
    }

    fn fill(&self, mesh: &mut Mesh, order: &[Corner], has_uv: bool) {
        let pool = &self.pool;
        mesh.positions = order.iter().map(|c| pool.positions[c.0 as usize]).collect();
        if has_uv {
            let uv = |c: &Corner| c.1.map_or(Vec2::ZERO, |t| pool.uvs[t as usize]);
            mesh.uvs = vec![order.iter().map(uv).collect()];
        }
        let colour = |c: &Corner| pool.colours[c.0 as usize];
        if order.iter().any(|c| colour(c).is_some()) {
            let linear = |c: Vec3| mtl::linear(c.to_array());
            let one =
                |c: &Corner| colour(c).map_or(Vec4::ONE, |c| Vec3::from(linear(c)).extend(1.0));
            mesh.colours = order.iter().map(one).collect();
        }
    }
}

/// The first `N` numbers of a line; missing or broken ones are 0.
fn numbers<const N: usize>(text: &str) -> [f32; N] {
    let mut n = [0.0; N];
    read_numbers(text, &mut n);
    n.map(|x| if x.is_finite() { x } else { 0.0 })
}

/// Fills `numbers` from text and says how many there were; what is no number is NaN.
fn read_numbers(text: &str, numbers: &mut [f32]) -> usize {
    let mut count = 0;
    for (slot, word) in numbers.iter_mut().zip(text.split_ascii_whitespace()) {
        *slot = word.parse().unwrap_or(f32::NAN);
        count += 1;
    }
    count
}
