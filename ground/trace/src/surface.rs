//! [`Surface`]: what is where a ray hit.
//!
//! Shading normals are interpolated, bent by the material's normal texture, and turned to the side
//! from which the surface is seen: the side of a face's vertex normals decides, as winding and
//! normals disagree in many files. Textures are read from the mip level whose texels are as large
//! as the pixel's footprint, so that fine textures turn grey instead of noisy.

use crate::mip::Mips;
use crate::tracer::{Hit, Tracer};
use chiaro_basis::math::{Affine3A, Mat3, Vec2, Vec3, Vec4};
use chiaro_scene::{Material, MaterialId, Mesh, Scene, TextureUse};

/// What is where a ray hit.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// World position.
    pub position: Vec3,
    /// Unit normal of the triangle, towards the ray's origin.
    pub geometric_normal: Vec3,
    /// Unit normal, interpolated, on the side that is seen.
    pub smooth_normal: Vec3,
    /// The smooth normal bent by the normal texture.
    pub normal: Vec3,
    /// The material.
    pub material: MaterialId,
    /// Linear base colour, textures and vertex colours included.
    pub base_colour: [f32; 3],
    /// Perceptual roughness in [0, 1].
    pub roughness: f32,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Emitted radiance.
    pub emissive: [f32; 3],
}

/// The textures of a scene, ready to be read at any footprint.
pub struct Surfaces<'a> {
    scene: &'a Scene,
    mips: Mips,
}

impl<'a> Surfaces<'a> {
    /// Prepares the textures that the scene's materials use.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, mips: Mips::of(scene) }
    }

    /// The surface at `hit`, seen along `direction` by a pixel that is `footprint` scene units
    /// wide there.
    pub fn at(&self, tracer: &Tracer, hit: &Hit, direction: Vec3, footprint: f32) -> Surface {
        let corner = Corners::of(tracer, hit);
        let material_id = corner.mesh.materials[hit.face as usize];
        let material = &self.scene.materials[material_id.index()];
        let geometric_normal = facing(corner.face_normal(), -direction);
        let smooth_normal = corner.smooth_normal(geometric_normal);
        let reader = Reader { surfaces: self, corner: &corner, hit, footprint };
        let normal = reader.bent(material, smooth_normal, geometric_normal);
        let surface = Surface {
            position: corner.position(),
            geometric_normal,
            smooth_normal,
            normal,
            material: material_id,
            base_colour: reader.base_colour(material),
            roughness: material.roughness,
            metallic: material.metallic,
            emissive: reader.emissive(material),
        };
        reader.with_roughness(material, surface)
    }

    /// The radiance that the surface at `hit` emits from a side that shines, averaged over a
    /// footprint this wide, in scene units.
    pub fn emission(&self, tracer: &Tracer, hit: &Hit, footprint: f32) -> [f32; 3] {
        let corner = Corners::of(tracer, hit);
        let material = &self.scene.materials[corner.mesh.materials[hit.face as usize].index()];
        Reader { surfaces: self, corner: &corner, hit, footprint }.emissive(material)
    }
}

/// The hit triangle in world space.
struct Corners<'a> {
    mesh: &'a Mesh,
    vertices: [usize; 3],
    weights: [f32; 3],
    positions: [Vec3; 3],
    normals: [Vec3; 3],
    tangents: Option<[Vec4; 3]>,
}

impl<'a> Corners<'a> {
    fn of(tracer: &Tracer<'a>, hit: &Hit) -> Self {
        let object = tracer.object(hit);
        let shape = &tracer.frame.shapes[object.shape];
        let mesh = tracer.mesh(hit);
        let vertices = mesh.triangles[hit.face as usize].map(|v| v as usize);
        let m = &object.world_from_shape;
        let for_normals = object.normal_from_shape();
        // Shapes in world space have their mirroring in the sign already.
        let mirrors = object.mirrored && *m != Affine3A::IDENTITY;
        let sign = if mirrors { -1.0 } else { 1.0 };
        let tangents = (!shape.tangents.is_empty()).then(|| {
            vertices.map(|v| {
                let t = shape.tangents[v];
                m.transform_vector3(t.truncate()).extend(t.w * sign)
            })
        });
        Self {
            mesh,
            vertices,
            weights: [1.0 - hit.b[0] - hit.b[1], hit.b[0], hit.b[1]],
            positions: vertices.map(|v| m.transform_point3(shape.positions[v])),
            normals: vertices.map(|v| (for_normals * shape.normals[v]).normalize_or_zero()),
            tangents,
        }
    }

    fn position(&self) -> Vec3 {
        self.blend(self.positions)
    }

    fn blend(&self, values: [Vec3; 3]) -> Vec3 {
        values[0] * self.weights[0] + values[1] * self.weights[1] + values[2] * self.weights[2]
    }

    fn face_normal(&self) -> Vec3 {
        let [a, b, c] = self.positions;
        (b - a).cross(c - a).normalize_or(self.normals[0])
    }

    fn smooth_normal(&self, seen_from: Vec3) -> Vec3 {
        let mean = self.normals[0] + self.normals[1] + self.normals[2];
        let side = if mean.dot(seen_from) < 0.0 { -1.0 } else { 1.0 };
        (self.blend(self.normals) * side).normalize_or(seen_from)
    }

    fn uv(&self, set: usize) -> Option<[Vec2; 3]> {
        let uvs = self.mesh.uvs.get(set).filter(|uvs| !uvs.is_empty())?;
        Some(self.vertices.map(|v| uvs[v]))
    }

    /// Unit tangent along u, and the direction of growing v, of a uv set.
    fn tangent_frame(&self, uv: &[Vec2; 3], normal: Vec3) -> Option<(Vec3, Vec3)> {
        if let Some(t) = self.tangents {
            let along = self.blend(t.map(Vec4::truncate));
            let along = (along - normal * along.dot(normal)).try_normalize()?;
            return Some((along, normal.cross(along) * t[0].w));
        }
        let (e1, e2) =
            (self.positions[1] - self.positions[0], self.positions[2] - self.positions[0]);
        let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let det = d1.x * d2.y - d1.y * d2.x;
        if det == 0.0 {
            return None;
        }
        let u = (e1 * d2.y - e2 * d1.y) / det;
        let v = (e2 * d1.x - e1 * d2.x) / det;
        let along = (u - normal * u.dot(normal)).try_normalize()?;
        // glTF's bitangent points towards the top of the picture, against v.
        let across = normal.cross(along);
        Some((along, if across.dot(v) > 0.0 { -across } else { across }))
    }
}

/// Reads a material's textures at one hit.
struct Reader<'a> {
    surfaces: &'a Surfaces<'a>,
    corner: &'a Corners<'a>,
    hit: &'a Hit,
    footprint: f32,
}

impl Reader<'_> {
    fn read(&self, used: &TextureUse) -> Option<[f32; 4]> {
        let uv = uv_at(self.corner.mesh, used.uv_set, self.hit)?;
        let level = self.level(used);
        Some(self.surfaces.mips.sample(used.texture, used.map(uv), level))
    }

    /// log2 of texels a pixel.
    fn level(&self, used: &TextureUse) -> f32 {
        let Some(uv) = self.corner.uv(used.uv_set) else { return 0.0 };
        let uv = uv.map(|p| used.map(p));
        let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let [a, b, c] = self.corner.positions;
        let area = (b - a).cross(c - a).length();
        let (w, h) = self.surfaces.scene.textures[used.texture.index()].pixels.size();
        let texels = (d1.x * d2.y - d1.y * d2.x).abs() * (w * h) as f32;
        0.5 * (texels / area.max(f32::MIN_POSITIVE)).log2() + self.footprint.log2()
    }

    fn base_colour(&self, material: &Material) -> [f32; 3] {
        let mut c = [0, 1, 2].map(|i| material.base_colour[i]);
        if let Some(t) = material.base_texture.as_ref().and_then(|t| self.read(t)) {
            c = std::array::from_fn(|i| c[i] * t[i]);
        }
        let mesh = self.corner.mesh;
        if !mesh.colours.is_empty() {
            let v = self.corner.vertices.map(|v| mesh.colours[v].truncate());
            let v = self.corner.blend(v).to_array();
            c = std::array::from_fn(|i| c[i] * v[i]);
        }
        c
    }

    fn emissive(&self, material: &Material) -> [f32; 3] {
        let t = material.emissive_texture.as_ref().and_then(|t| self.read(t)).unwrap_or([1.0; 4]);
        std::array::from_fn(|i| material.emissive[i] * t[i])
    }

    fn with_roughness(&self, material: &Material, mut surface: Surface) -> Surface {
        let texture = material.metallic_roughness_texture.as_ref();
        if let Some(t) = texture.and_then(|t| self.read(t)) {
            surface.roughness *= t[1];
            surface.metallic *= t[2];
        }
        surface
    }

    /// The smooth normal bent by the normal texture.
    fn bent(&self, material: &Material, smooth: Vec3, seen_from: Vec3) -> Vec3 {
        let Some(used) = material.normal_texture.as_ref() else { return smooth };
        let (Some(texel), Some(uv)) = (self.read(used), self.corner.uv(used.uv_set)) else {
            return smooth;
        };
        let uv = uv.map(|p| used.map(p));
        let Some((along, across)) = self.corner.tangent_frame(&uv, smooth) else { return smooth };
        let [x, y, z] = [0, 1, 2].map(|i| 2.0 * texel[i] - 1.0);
        let bent = Mat3::from_cols(along, across, smooth)
            * Vec3::new(x * material.normal_scale, y * material.normal_scale, z);
        let bent = bent.normalize_or(smooth);
        if bent.dot(seen_from) < 0.0 { smooth } else { bent }
    }
}

/// Texture coordinates at a hit, if the mesh has that set.
pub(crate) fn uv_at(mesh: &Mesh, set: usize, hit: &Hit) -> Option<Vec2> {
    let uvs = mesh.uvs.get(set).filter(|uvs| !uvs.is_empty())?;
    let [a, b, c] = mesh.triangles[hit.face as usize].map(|v| uvs[v as usize]);
    Some(a * (1.0 - hit.b[0] - hit.b[1]) + b * hit.b[0] + c * hit.b[1])
}

fn facing(normal: Vec3, towards: Vec3) -> Vec3 {
    if normal.dot(towards) < 0.0 { -normal } else { normal }
}
