//! [`Stage`]: puts forms, materials, lights and motion together into a [`Scene`].

use super::motion::Motion;
use super::shape::Form;
use crate::{
    Camera, Channel, Clip, Filter, Light, LightKind, Material, MaterialId, Mesh, MeshId, Node,
    NodeId, NormalSource, Pose, Projection, Scene, Stored, Texture, TextureId, TextureUse,
    Transform, Wrap,
};
use chiaro_basis::math::{DMat3, DQuat, DVec3, Vec2, Vec3, vec2};
use chiaro_image::Plane;

/// A scene in the making.
#[derive(Default)]
pub(crate) struct Stage {
    scene: Scene,
    clip: Clip,
}

/// Moved by (`x`, `y`, `z`).
pub(crate) fn moved(x: f64, y: f64, z: f64) -> Transform {
    placed(DVec3::new(x, y, z), DQuat::IDENTITY, 1.0)
}

/// Scaled evenly, turned, then moved.
pub(crate) fn placed(translation: DVec3, rotation: DQuat, scale: f64) -> Transform {
    Transform::Parts { translation, rotation, scale: DVec3::splat(scale) }
}

impl Stage {
    /// A matt material of an sRGB colour, 0xRRGGBB.
    pub(crate) fn matt(&mut self, name: &str, colour: u32) -> MaterialId {
        let matt = self.material(name, colour, 0.9, 0.0);
        self.scene.materials[matt.index()].specular = 0.0;
        matt
    }

    /// A material of an sRGB colour, 0xRRGGBB.
    pub(crate) fn material(
        &mut self,
        name: &str,
        colour: u32,
        roughness: f32,
        metallic: f32,
    ) -> MaterialId {
        let linear = |shift: u32| {
            let s = ((colour >> shift) & 255) as f32 / 255.0;
            if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
        };
        let base_colour = [linear(16), linear(8), linear(0), 1.0];
        let name = name.into();
        self.push_material(Material {
            name,
            base_colour,
            roughness,
            metallic,
            specular: 1.0,
            double_sided: false,
            ..Material::default()
        })
    }

    /// A material whose colour is a picture of `size` pixels: sRGB in [0, 1] at each (u, v).
    pub(crate) fn painted(
        &mut self,
        name: &str,
        roughness: f32,
        [width, height]: [usize; 2],
        colour: impl Fn(f32, f32) -> [f32; 3] + Sync,
    ) -> MaterialId {
        let pixels = Plane::from_fn(width, height, |x, y| {
            let at = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
            let [r, g, b] = colour(at(x, width), at(y, height));
            [r, g, b, 1.0].map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8)
        });
        self.scene.textures.push(Texture {
            name: name.into(),
            pixels: pixels.into(),
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
        });
        let picture = TextureUse::plain(TextureId::new(self.scene.textures.len() - 1));
        self.push_material(Material {
            name: name.into(),
            base_texture: Some(picture),
            roughness,
            specular: 1.0,
            double_sided: false,
            ..Material::default()
        })
    }

    /// Any material.
    pub(crate) fn push_material(&mut self, material: Material) -> MaterialId {
        self.scene.materials.push(material);
        MaterialId::new(self.scene.materials.len() - 1)
    }

    /// A mesh of forms, each with its material.
    pub(crate) fn mesh(
        &mut self,
        name: &str,
        parts: impl IntoIterator<Item = (Form, MaterialId)>,
    ) -> MeshId {
        self.push_mesh(mesh(name, parts))
    }

    /// Any mesh.
    pub(crate) fn push_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.scene.meshes.push(mesh);
        MeshId::new(self.scene.meshes.len() - 1)
    }

    /// A node without a mesh, to hang others on.
    pub(crate) fn joint(
        &mut self,
        name: &str,
        parent: Option<NodeId>,
        transform: Transform,
    ) -> NodeId {
        self.push_node(Node { name: name.into(), parent, transform, ..Node::default() })
    }

    /// A node that shows a mesh.
    pub(crate) fn show(
        &mut self,
        name: &str,
        parent: Option<NodeId>,
        transform: Transform,
        mesh: MeshId,
    ) -> NodeId {
        let name = name.into();
        self.push_node(Node { name, parent, transform, mesh: Some(mesh), ..Node::default() })
    }

    /// A node that shows a form of one material, in a mesh of its own.
    pub(crate) fn thing(
        &mut self,
        name: &str,
        parent: Option<NodeId>,
        transform: Transform,
        part: (Form, MaterialId),
    ) -> NodeId {
        let mesh = self.mesh(name, [part]);
        self.show(name, parent, transform, mesh)
    }

    /// A node that shows copies of a mesh.
    pub(crate) fn copies(&mut self, name: &str, mesh: MeshId, instances: Vec<Transform>) -> NodeId {
        self.push_node(Node { name: name.into(), mesh: Some(mesh), instances, ..Node::default() })
    }

    /// Any node; its parent must be there already.
    pub(crate) fn push_node(&mut self, node: Node) -> NodeId {
        self.scene.nodes.push(node);
        NodeId::new(self.scene.nodes.len() - 1)
    }

    /// A skin; its joints must be there already.
    pub(crate) fn skin(&mut self, skin: crate::Skin) -> crate::SkinId {
        self.scene.skins.push(skin);
        crate::SkinId::new(self.scene.skins.len() - 1)
    }

    /// A camera at a node of its own.
    pub(crate) fn camera(&mut self, from: Vec3, to: Vec3, projection: Projection, aspect: f32) {
        let transform = facing(from, to);
        let node = self.joint("camera", None, transform);
        let name = "camera".into();
        self.scene.cameras.push(Camera { name, node, projection, aspect: Some(aspect) });
    }

    /// Sunlight that falls along `direction`, in lux.
    pub(crate) fn sun(&mut self, direction: Vec3, intensity: f32) {
        let node = self.joint("sun", None, facing(Vec3::ZERO, direction));
        self.scene.lights.push(Light {
            name: "sun".into(),
            node,
            kind: LightKind::Directional,
            colour: [1.0; 3],
            intensity,
            range: f32::INFINITY,
        });
    }

    /// Light from a node, in candela; it shines along the node's -z.
    pub(crate) fn lamp(&mut self, node: NodeId, kind: LightKind, colour: [f32; 3], intensity: f32) {
        let name = "lamp".into();
        let range = f32::INFINITY;
        self.scene.lights.push(Light { name, node, kind, colour, intensity, range });
    }

    /// Lets a node move.
    pub(crate) fn animate(&mut self, node: NodeId, motion: Motion) {
        let Motion { property, track } = motion;
        self.clip.channels.push(Channel { node, property, track });
    }

    /// The scene.
    pub(crate) fn finish(mut self) -> Scene {
        if !self.clip.channels.is_empty() {
            self.clip.name = "motion".into();
            self.scene.clips.push(self.clip);
        }
        let sum =
            |f: &dyn Fn(&Mesh) -> usize| self.scene.meshes.iter().map(f).sum::<usize>() as u64;
        self.scene.stored = Stored {
            triangles: sum(&|m| m.triangles.len()),
            vertices: sum(&|m| m.positions.len()),
            materials: self.scene.materials.len() as u64,
            textures: self.scene.textures.len() as u64,
            ..Stored::default()
        };
        self.scene
    }
}

/// A mesh of forms, each with its material.
pub(crate) fn mesh(name: &str, parts: impl IntoIterator<Item = (Form, MaterialId)>) -> Mesh {
    let mut whole = Form::default();
    let mut materials = Vec::new();
    for (form, material) in parts {
        materials.extend(form.triangles.iter().map(|_| material));
        whole = whole.with(form);
    }
    Mesh {
        name: name.into(),
        positions: whole.positions,
        normals: NormalSource::Given(whole.normals),
        triangles: whole.triangles,
        materials,
        ..Mesh::default()
    }
}

impl Mesh {
    /// With texture coordinates that a map makes of position and normal.
    pub(crate) fn mapped(mut self, map: impl Fn(Vec3, Vec3) -> Vec2) -> Self {
        let NormalSource::Given(normals) = &self.normals else { return self };
        self.uvs = vec![self.positions.iter().zip(normals).map(|(&p, &n)| map(p, n)).collect()];
        self
    }
}

/// Texture coordinates of a box: from the side that the normal faces, u to the right and v down,
/// `scale` of them a unit.
pub(crate) fn boxed(scale: Vec2) -> impl Fn(Vec3, Vec3) -> Vec2 {
    move |p, n| {
        let a = n.abs();
        let flat = if a.y >= a.x && a.y >= a.z {
            vec2(p.x, p.z)
        } else if a.z >= a.x {
            vec2(p.x, -p.y)
        } else {
            vec2(p.z, -p.y)
        };
        scale * flat
    }
}

/// The transform whose -z looks from one point to another, y as near up as can be.
pub(crate) fn facing(from: Vec3, to: Vec3) -> Transform {
    let pose = Pose::look_at(from, to, Vec3::Y, Projection::Orthographic { half_height: 1.0 });
    let axes = [pose.right, pose.up, -pose.forward].map(Vec3::as_dvec3);
    let rotation = DQuat::from_mat3(&DMat3::from_cols(axes[0], axes[1], axes[2])).normalize();
    placed(from.as_dvec3(), rotation, 1.0)
}
