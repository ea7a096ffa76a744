//! Lights: KHR_lights_punctual, one for each drawn node that holds one.

use super::context::{Context, Place};
use super::json::Value;
use super::tree::Tree;
use crate::{Light, LightKind};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

const PUNCTUAL: &str = "KHR_lights_punctual";

/// The lights, in the order of the document's nodes. One of an unknown kind is left out with a note.
pub(super) fn read(root: &Value, tree: &Tree, cx: &mut Context) -> Vec<Light> {
    let items = root.extension(PUNCTUAL).list("lights");
    let mut lights = Vec::new();
    for node in tree.drawn_nodes() {
        let index = tree.items[node].extension(PUNCTUAL).index("light", items.len());
        let index = index.unwrap_or_else(|why| {
            cx.note(Place::new("node", node), why);
            None
        });
        let Some(index) = index else { continue };
        match kind(&items[index]) {
            Some(kind) => {
                let name = Some(tree.items[node].name()).filter(|n| !n.is_empty());
                let name = name.unwrap_or_else(|| items[index].name());
                lights.push(light(&items[index], name, tree.id(node), kind));
            }
            None => cx.note(Place::new("light", index), "its type is not known; it is left out"),
        }
    }
    lights
}

fn light(item: &Value, name: String, node: crate::NodeId, kind: LightKind) -> Light {
    let not_negative = |n: f64| Some(n.max(0.0) as f32).filter(|n| n.is_finite());
    let colour = item.numbers::<3>("color").unwrap_or([1.0; 3]);
    let range = item.number("range").and_then(not_negative).filter(|r| *r > 0.0);
    Light {
        name,
        node,
        kind,
        colour: colour.map(|c| not_negative(c).unwrap_or(1.0)),
        intensity: item.number("intensity").and_then(not_negative).unwrap_or(1.0),
        range: range.unwrap_or(f32::INFINITY),
    }
}

fn kind(item: &Value) -> Option<LightKind> {
    match item.text("type")? {
        "directional" => Some(LightKind::Directional),
        "point" => Some(LightKind::Point),
        "spot" => {
            let angle = |key: &str, absent: f32| {
                item.get("spot").number(key).map_or(absent, |a| a as f32).clamp(0.0, FRAC_PI_2)
            };
            let outer = angle("outerConeAngle", FRAC_PI_4);
            Some(LightKind::Spot { inner: angle("innerConeAngle", 0.0).min(outer), outer })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NodeId;
    use crate::load::gltf::json::parse;
    use crate::load::{Budget, Door};

    fn read(text: &str) -> Option<Light> {
        let item = parse(text, &Door::new("a", &(), Budget::default())).unwrap();
        Some(light(&item, String::new(), NodeId::new(0), kind(&item)?))
    }

    #[test]
    fn what_is_absent_has_the_specification_s_value() {
        let spot = read(r#"{"type": "spot"}"#).unwrap();
        assert_eq!(spot.kind, LightKind::Spot { inner: 0.0, outer: FRAC_PI_4 });
        assert_eq!((spot.intensity, spot.colour, spot.range), (1.0, [1.0; 3], f32::INFINITY));
    }

    #[test]
    fn impossible_lights_become_possible() {
        let spot = read(
            r#"{"type": "spot", "intensity": -3, "color": [1e39, 0.5, -1], "range": 0,
                "spot": {"innerConeAngle": 9, "outerConeAngle": 1}}"#,
        )
        .unwrap();
        assert_eq!(spot.kind, LightKind::Spot { inner: 1.0, outer: 1.0 });
        assert_eq!((spot.intensity, spot.colour), (0.0, [1.0, 0.5, 0.0]));
        assert!(read(r#"{"type": "ambient"}"#).is_none());
        assert!(read("{}").is_none());
    }
}
