//! Cameras: one for each drawn node that holds one, in the order of the document's cameras.

use super::context::{Context, Place};
use super::json::Value;
use super::tree::Tree;
use crate::{Camera, Projection};

/// The cameras. One that cannot see is left out with a note. A camera is called after its node, as
/// editors show it, or else after itself.
pub(super) fn read(root: &Value, tree: &Tree, cx: &mut Context) -> Vec<Camera> {
    let items = root.list("cameras");
    let mut cameras = Vec::new();
    for node in tree.drawn_nodes() {
        let index = tree.items[node].index("camera", items.len());
        let index = index.unwrap_or_else(|why| {
            cx.note(Place::new("node", node), why);
            None
        });
        let Some(index) = index else { continue };
        match projection(&items[index]) {
            Some((projection, aspect)) => {
                let name = Some(tree.items[node].name()).filter(|n| !n.is_empty());
                let name = name.unwrap_or_else(|| items[index].name());
                cameras.push((index, Camera { name, node: tree.id(node), projection, aspect }));
            }
            None => {
                cx.note(Place::new("camera", index), "its angle or size is none; it is left out")
            }
        }
    }
    cameras.sort_by_key(|(index, _)| *index);
    cameras.into_iter().map(|(_, camera)| camera).collect()
}

/// Projection and aspect; `None` for a camera that cannot see.
fn projection(item: &Value) -> Option<(Projection, Option<f32>)> {
    let positive = |n: f64| Some(n.abs() as f32).filter(|n| n.is_normal());
    let orthographic = item.get("orthographic");
    if item.text("type") == Some("orthographic") || orthographic.is_object() {
        let half_height = positive(orthographic.number("ymag")?)?;
        let half_width = orthographic.number("xmag").and_then(positive);
        let aspect = half_width.map(|w| w / half_height).filter(|a| a.is_normal());
        return Some((Projection::Orthographic { half_height }, aspect));
    }
    let perspective = item.get("perspective");
    let fov_y = positive(perspective.number("yfov")?)?;
    let aspect = perspective.number("aspectRatio").and_then(positive);
    (fov_y < std::f32::consts::PI).then_some((Projection::Perspective { fov_y }, aspect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::gltf::json::parse;
    use crate::load::{Budget, Door};

    fn seen(text: &str) -> Option<(Projection, Option<f32>)> {
        projection(&parse(text, &Door::new("a", &(), Budget::default())).unwrap())
    }

    #[test]
    fn heights_are_halves_and_aspects_optional() {
        assert_eq!(
            seen(r#"{"type": "perspective", "perspective": {"yfov": 0.5}}"#),
            Some((Projection::Perspective { fov_y: 0.5 }, None))
        );
        assert_eq!(
            seen(r#"{"type": "orthographic", "orthographic": {"xmag": 3, "ymag": -2}}"#),
            Some((Projection::Orthographic { half_height: 2.0 }, Some(1.5)))
        );
    }

    #[test]
    fn cameras_that_see_nothing_are_none() {
        for text in [
            "{}",
            r#"{"perspective": {"yfov": 0}}"#,
            r#"{"perspective": {"yfov": 4}}"#,
            r#"{"perspective": {"yfov": "1"}}"#,
            r#"{"orthographic": {"xmag": 1, "ymag": 0}}"#,
        ] {
            assert_eq!(seen(text), None, "{text}");
        }
    }
}
