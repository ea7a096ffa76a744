//! Which way is up.

use crate::{Node, NodeId, Scene, Transform};
use chiaro_basis::math::{DQuat, DVec3};
use chiaro_basis::{Error, Result};
use std::f64::consts::{FRAC_PI_2, PI};

/// Which way is up in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Up {
    /// What the file says, else y; STL z.
    #[default]
    Auto,
    /// y.
    Y,
    /// z, as in CAD and most scanners.
    Z,
    /// -y, as in pictures.
    NegY,
}

impl Up {
    /// Reads `y`, `z`, `-y` or `auto`, as `--up` has them.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "auto" => Ok(Self::Auto),
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            "-y" => Ok(Self::NegY),
            _ => Err(Error::setting("--up", text, "y, z, -y or auto")),
        }
    }

    /// What a comment of a file says, as in "z up", "Z-up", "up: +y" or "up axis: Z".
    pub(super) fn said(comment: &str) -> Option<Self> {
        let lower = comment.to_ascii_lowercase();
        let letter = |c: char| c.is_ascii_alphanumeric();
        // A minus sign right before a letter belongs to it.
        let lower = lower.replace("-y", " minusy ").replace("-z", " minusz ");
        let words: Vec<&str> =
            lower.split(|c| !letter(c)).filter(|w| !w.is_empty() && *w != "axis").collect();
        let axis = |word: &str| match word {
            "y" => Some(Self::Y),
            "z" => Some(Self::Z),
            "minusy" => Some(Self::NegY),
            _ => None,
        };
        let pairs = words.windows(2).find_map(|pair| match pair {
            [a, "up"] => axis(a),
            ["up", b] => axis(b),
            _ => None,
        });
        let joined = || words.iter().find_map(|w| axis(w.strip_suffix("up")?));
        pairs.or_else(joined)
    }
}

/// Turns the scene below a new root, so that y is up; tracks, cameras and lights turn with it.
pub(super) fn raise(scene: &mut Scene, up: Up) {
    let rotation = match up {
        Up::Auto | Up::Y => return,
        Up::Z => DQuat::from_rotation_x(-FRAC_PI_2),
        Up::NegY => DQuat::from_rotation_x(PI),
    };
    let transform = Transform::Parts { translation: DVec3::ZERO, rotation, scale: DVec3::ONE };
    let shifted = |id: NodeId| NodeId::new(id.index() + 1);
    for node in &mut scene.nodes {
        node.parent = Some(node.parent.map_or(NodeId::new(0), shifted));
    }
    scene.nodes.insert(0, Node { name: "up".into(), transform, ..Node::default() });
    scene.cameras.iter_mut().for_each(|c| c.node = shifted(c.node));
    scene.lights.iter_mut().for_each(|l| l.node = shifted(l.node));
    scene.skins.iter_mut().flat_map(|s| &mut s.joints).for_each(|j| *j = shifted(*j));
    let channels = scene.clips.iter_mut().flat_map(|c| &mut c.channels);
    channels.for_each(|c| c.node = shifted(c.node));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Channel, Clip, Interpolation, Light, LightKind, Projection};
    use crate::{Property, Skin, Track};

    #[test]
    fn comments_say_what_is_up() {
        let up = [
            ("San Miguel; architecture and upper tables; z up", Some(Up::Z)),
            ("Z-up", Some(Up::Z)),
            ("up axis: +Y", Some(Up::Y)),
            ("UP_AXIS=Z", Some(Up::Z)),
            ("zup", Some(Up::Z)),
            ("-y up", Some(Up::NegY)),
            ("axis: y, updated", None),
            ("a set up of the cup", None),
            ("easy up to here", None),
        ];
        for (comment, expected) in up {
            assert_eq!(Up::said(comment), expected, "{comment}");
        }
    }

    #[test]
    fn everything_turns_with_a_new_root() {
        let track = Track {
            times: vec![0.0],
            values: vec![0.0; 3],
            width: 3,
            interpolation: Interpolation::Step,
        };
        let node = NodeId::new(1);
        let mut scene = Scene {
            nodes: vec![Node::default(), Node { parent: Some(NodeId::new(0)), ..Node::default() }],
            skins: vec![Skin { joints: vec![node], ..Skin::default() }],
            cameras: vec![Camera {
                name: String::new(),
                node,
                projection: Projection::Orthographic { half_height: 1.0 },
                aspect: None,
            }],
            lights: vec![Light {
                name: String::new(),
                node,
                kind: LightKind::Point,
                colour: [1.0; 3],
                intensity: 1.0,
                range: f32::INFINITY,
            }],
            clips: vec![Clip {
                name: String::new(),
                channels: vec![Channel { node, property: Property::Translation, track }],
            }],
            ..Scene::default()
        };
        raise(&mut scene, Up::Z);
        let two = NodeId::new(2);
        assert_eq!(
            scene.nodes.iter().map(|n| n.parent.map(NodeId::index)).collect::<Vec<_>>(),
            [None, Some(0), Some(1)]
        );
        assert_eq!((scene.cameras[0].node, scene.lights[0].node), (two, two));
        assert_eq!((scene.skins[0].joints[0], scene.clips[0].channels[0].node), (two, two));
        let turned = scene.nodes[0].transform.matrix().transform_point3(DVec3::Z);
        assert!(turned.distance(DVec3::Y) < 1e-12);
    }
}
