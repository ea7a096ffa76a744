//! [`Track`]: one animated property over time, and the [`Clip`]s that group them.

use crate::NodeId;

/// A named animation of a file.
#[derive(Clone, Debug, Default)]
pub struct Clip {
    /// The name in the file, or empty.
    pub name: String,
    /// What it moves.
    pub channels: Vec<Channel>,
}

/// One property of one node, moved by one track.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Which node.
    pub node: NodeId,
    /// Which of its properties.
    pub property: Property,
    /// The keys.
    pub track: Track,
}

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// Three numbers a key.
    Translation,
    /// Four numbers a key: a unit quaternion x, y, z, w.
    Rotation,
    /// Three numbers a key.
    Scale,
    /// One number a morph target and key.
    Weights,
}

/// How values between keys are found (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the key before.
    Step,
    /// Linear, spherical for rotations.
    Linear,
    /// Hermite splines: each key holds in-tangent, value, out-tangent.
    CubicSpline,
}

/// Keys over time.
#[derive(Clone, Debug)]
pub struct Track {
    /// Key times in seconds, rising; at least one.
    pub times: Vec<f32>,
    /// `width` numbers a key (three times as many for cubic splines).
    pub values: Vec<f32>,
    /// Numbers in a value.
    pub width: usize,
    /// Between keys.
    pub interpolation: Interpolation,
}
