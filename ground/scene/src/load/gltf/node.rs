//! Nodes: transforms, what they show, and copies (EXT_mesh_gpu_instancing).

use super::accessor::{Accessor, Accessors};
use super::context::{Context, Place};
use super::json::Value;
use super::mesh::Usage;
use super::primitive::survive;
use super::tree::Tree;
use crate::{Mesh, MeshId, Node, Skin, SkinId, Transform};
use chiaro_basis::Result;
use chiaro_basis::math::{DQuat, DVec3};

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// How the document's nodes use each of its meshes.
pub(super) fn usage(root: &Value, tree: &Tree, skins: &[Skin], cx: &Context) -> Result<Vec<Usage>> {
    let unused = Usage { drawn: tree.items.is_empty(), joints: None };
    let mut usage = vec![unused; root.list("meshes").len()];
    for (node, item) in tree.items.iter().enumerate() {
        let wrong = |why| cx.wrong(Place::new("node", node), why);
        let Some(mesh) = item.index("mesh", usage.len()).map_err(wrong)? else { continue };
        let used = &mut usage[mesh];
        used.drawn |= tree.is_drawn(node);
        if let Some(skin) = item.index("skin", skins.len()).map_err(wrong)? {
            let joints = skins[skin].joints.len();
            if joints > 0 {
                used.joints = Some(used.joints.map_or(joints, |least| least.min(joints)));
            }
        }
    }
    Ok(usage)
}

/// All nodes, parents first. The indices of meshes and skins were checked by [`usage`].
pub(super) fn read(
    root: &Value,
    tree: &Tree,
    meshes: &[Mesh],
    skins: &[Skin],
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Vec<Node>> {
    if tree.items.is_empty() && !meshes.is_empty() {
        cx.remark("it has no nodes; each mesh is drawn as it is");
        return Ok((0..meshes.len()).map(|i| alone(i, &meshes[i])).collect());
    }
    let mut nodes = Vec::with_capacity(tree.order().len());
    let mut shown = vec![false; meshes.len()];
    for &i in tree.order() {
        let item = &tree.items[i];
        let place = Place::new("node", i);
        let mut node = Node {
            name: item.name(),
            parent: tree.parent(i),
            transform: transform(item, place, cx),
            ..Node::default()
        };
        let mesh = item.get("mesh").as_whole().filter(|_| tree.is_drawn(i));
        if let Some(mesh) = mesh {
            let skin = item.get("skin").as_whole().filter(|s| !skins[*s].joints.is_empty());
            node.skin = skin.map(SkinId::new);
            node.weights = weights(root, item, mesh, meshes[mesh].morphs.len());
            let copies = instances(item, place, accessors, cx)?;
            let empty = copies.as_ref().is_some_and(Vec::is_empty);
            node.instances = copies.unwrap_or_default();
            if !empty && !meshes[mesh].triangles.is_empty() {
                node.mesh = Some(MeshId::new(mesh));
                charge(&node, &meshes[mesh], &mut shown[mesh], place, cx)?;
            }
        }
        nodes.push(node);
    }
    Ok(nodes)
}

/// A node for a mesh that none shows.
fn alone(index: usize, mesh: &Mesh) -> Node {
    Node {
        name: mesh.name.clone(),
        mesh: (!mesh.triangles.is_empty()).then(|| MeshId::new(index)),
        weights: vec![0.0; mesh.morphs.len()],
        ..Node::default()
    }
}

/// Takes what drawing a node costs: triangles, and memory where frames need copies of its vertices.
fn charge(
    node: &Node,
    mesh: &Mesh,
    shown: &mut bool,
    place: Place,
    cx: &mut Context,
) -> Result<()> {
    let copies = node.instances.len().max(1);
    cx.spend("instances", |b| &mut b.instances, copies.saturating_mul(mesh.triangles.len()))?;
    let deforms = node.skin.is_some() || !mesh.morphs.is_empty();
    let again = copies - usize::from(!std::mem::replace(shown, true));
    if deforms {
        cx.hold::<[f32; 10]>(place, again.saturating_mul(mesh.positions.len()))?;
    }
    cx.hold::<crate::Object>(place, again)
}

/// The transform of a node. What is not finite, or has the wrong form, counts as absent.
fn transform(item: &Value, place: Place, cx: &mut Context) -> Transform {
    if let Some(matrix) = item.numbers::<16>("matrix") {
        return Transform::from_columns(matrix);
    }
    let mut wrong = !matches!(item.get("matrix"), Value::Null);
    let mut three = |key: &str, absent: DVec3| {
        let numbers = item.numbers::<3>(key);
        wrong |= numbers.is_none() && !matches!(item.get(key), Value::Null);
        numbers.map_or(absent, DVec3::from)
    };
    let (translation, scale) = (three("translation", DVec3::ZERO), three("scale", DVec3::ONE));
    let rotation = item.numbers::<4>("rotation").map_or(DQuat::IDENTITY, unit);
    if wrong {
        cx.note(place, "parts of its transform are no lists of numbers and count as absent");
    }
    Transform::Parts { translation, rotation, scale }
}

/// A unit quaternion; the identity where there is no direction.
fn unit(numbers: [f64; 4]) -> DQuat {
    let q = DQuat::from_array(numbers);
    let length = q.length();
    if length > 1e-12 && length.is_finite() { (q / length).normalize() } else { DQuat::IDENTITY }
}

/// The rest weights of a node's mesh with that many morph targets.
fn weights(root: &Value, item: &Value, mesh: usize, targets: usize) -> Vec<f32> {
    let own = item.list("weights");
    let shared = root.list("meshes")[mesh].list("weights");
    let given = if own.is_empty() { shared } else { own };
    let number = |v: &Value| v.as_number().map_or(0.0, |n| n as f32);
    let mut weights: Vec<f32> = given.iter().take(targets).map(number).collect();
    weights.iter_mut().filter(|w| !w.is_finite()).for_each(|w| *w = 0.0);
    weights.resize(targets, 0.0);
    weights
}

/// The copies that a node asks for; `None` where it asks for none.
fn instances(
    item: &Value,
    place: Place,
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Option<Vec<Transform>>> {
    let attributes = item.extension(INSTANCING).get("attributes");
    let mut column = |name: &str| -> Result<Option<Accessor>> {
        let accessor = super::accessor::named(attributes, name, place, accessors, cx);
        Ok(survive(accessor, name, place, cx)?.flatten())
    };
    let columns = [column("TRANSLATION")?, column("ROTATION")?, column("SCALE")?];
    let Some(count) = columns.iter().flatten().map(Accessor::count).min() else { return Ok(None) };
    cx.hold::<Transform>(place, count)?;
    cx.hold::<u32>(place, count)?;
    let all: Vec<u32> = (0..count as u32).collect();
    let [t, r, s] = columns;
    let t = floats::<3>(t, &all, place, cx)?;
    let r = floats::<4>(r, &all, place, cx)?;
    let s = floats::<3>(s, &all, place, cx)?;
    let vector = |rows: &Option<Vec<[f32; 3]>>, i: usize, absent: DVec3| {
        rows.as_ref().map_or(absent, |rows| DVec3::from(rows[i].map(f64::from)))
    };
    let instance = |i: usize| Transform::Parts {
        translation: vector(&t, i, DVec3::ZERO),
        rotation: r.as_ref().map_or(DQuat::IDENTITY, |rows| unit(rows[i].map(f64::from))),
        scale: vector(&s, i, DVec3::ONE),
    };
    let finite = |t: &Transform| t.matrix().is_finite();
    Ok(Some((0..count).map(instance).filter(finite).collect()))
}

fn floats<const N: usize>(
    accessor: Option<Accessor>,
    picks: &[u32],
    place: Place,
    cx: &mut Context,
) -> Result<Option<Vec<[f32; N]>>> {
    let Some(accessor) = accessor else { return Ok(None) };
    survive(accessor.floats(picks, cx), INSTANCING, place, cx)
}
