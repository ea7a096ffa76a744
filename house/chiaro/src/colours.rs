//! [`Colours`] of a drawing: ink, paper and what is behind.

use serde_json::{Value, json};

/// Colours of the picture, sRGB-encoded RGBA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colours {
    /// Black regions and lines.
    pub ink: [f32; 4],
    /// White regions and lines.
    pub paper: [f32; 4],
    /// Where there is no geometry; may be transparent.
    pub background: [f32; 4],
}

impl Default for Colours {
    fn default() -> Self {
        Self { ink: [0.0, 0.0, 0.0, 1.0], paper: [1.0; 4], background: [1.0; 4] }
    }
}

impl Colours {
    /// For recipes.
    pub(crate) fn settings(&self) -> Value {
        json!({ "ink": self.ink, "paper": self.paper, "background": self.background })
    }

    /// Whether what has no geometry is nearer to paper than to ink.
    pub(crate) fn paper_is_white(&self) -> bool {
        let lightness = |c: [f32; 4]| 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
        self.background[3] < 0.5
            || lightness(self.background) >= 0.5 * (lightness(self.ink) + lightness(self.paper))
    }

    pub(crate) fn are_grey(&self) -> bool {
        [self.ink, self.paper, self.background]
            .iter()
            .all(|c| c[0] == c[1] && c[1] == c[2] && c[3] == 1.0)
    }
}
