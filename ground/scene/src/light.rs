//! [`Light`]: punctual lights, in the units of glTF.

use crate::NodeId;

/// A light at a node; it shines along the node's -z.
#[derive(Clone, Debug)]
pub struct Light {
    /// The name in the file, or empty.
    pub name: String,
    /// Where it hangs.
    pub node: NodeId,
    /// What shines.
    pub kind: LightKind,
    /// Linear RGB.
    pub colour: [f32; 3],
    /// Lux for directional lights, candela for the others.
    pub intensity: f32,
    /// Beyond this distance the light is dark, in scene units; infinite if the file has none.
    pub range: f32,
}

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional,
    /// All around, falling off with the square of the distance.
    Point,
    /// A cone, with half-angles in radians.
    Spot {
        /// Full strength inside.
        inner: f32,
        /// Dark outside.
        outer: f32,
    },
}
