//! A drawing: layers of fills and strokes on a page, in millimetres.
//!
//! One layer is one pen, or one ink. Within a layer marks are drawn in order; layers lie above each
//! other in order. See [`Drawing::to_svg`] for the file.

use crate::travel::{Plan, plan};
use crate::{Path, Point};

/// Red, green, blue and opacity in [0, 1], sRGB-encoded.
pub type Colour = [f32; 4];

/// What is on a page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height in millimetres.
    pub page: Point,
    /// A short name, shown by programs that open the file.
    pub title: String,
    /// What made it, as JSON.
    pub recipe: Option<String>,
    /// What the page is filled with beneath everything.
    pub background: Option<Colour>,
    /// A picture on the background, beneath all layers.
    pub picture: Option<Picture>,
    /// Its layers, the lowest first.
    pub layers: Vec<Layer>,
}

/// A picture on a page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// The file.
    pub png: Vec<u8>,
    /// Its upper left corner in millimetres.
    pub corner: Point,
    /// Its width and height in millimetres.
    pub size: Point,
}

/// The marks of one pen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// Its name, as layer lists show it.
    pub name: String,
    /// Its marks, the lowest first.
    pub marks: Vec<Mark>,
}

/// An area or a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// An area: its outline and its holes, closed, filled by the even-odd rule.
    Fill {
        /// Outline and holes.
        outline: Vec<Path>,
        /// What it is filled with.
        colour: Colour,
    },
    /// A line of constant width with round ends and joints.
    Stroke {
        /// The middle of the line.
        path: Path,
        /// Millimetres.
        width: f64,
        /// Its colour.
        colour: Colour,
    },
    /// A stroke with a name of its own, which other programs can look up.
    Named {
        /// The name, once a file.
        name: String,
        /// The middles of its lines.
        paths: Vec<Path>,
        /// Millimetres.
        width: f64,
        /// Its colour.
        colour: Colour,
        /// What is known of it: names and values of data attributes.
        data: Vec<(&'static str, String)>,
    },
    /// A stroke as an area: outlines, closed, filled by the nonzero rule.
    Shape {
        /// The name, once a file.
        name: String,
        /// Its outlines.
        outline: Vec<Path>,
        /// What it is filled with.
        colour: Colour,
        /// What is known of it: names and values of data attributes.
        data: Vec<(&'static str, String)>,
    },
}

impl Layer {
    /// A layer of strokes of one pen, joined where they meet within `join` millimetres, ordered and
    /// reversed for little travel with the pen up. Returns the layer and its plan's lengths.
    pub fn strokes(
        name: impl Into<String>,
        paths: Vec<Path>,
        width: f64,
        colour: Colour,
        join: f64,
    ) -> (Self, Travel) {
        let Plan { paths, travel } = plan(paths, join);
        let marks = paths.into_iter().map(|path| Mark::Stroke { path, width, colour }).collect();
        (Self { name: name.into(), marks }, travel)
    }
}

/// How far a pen goes, in millimetres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Travel {
    /// On the paper.
    pub down: f64,
    /// Above it, between strokes, from the page's upper left corner on.
    pub up: f64,
}

impl std::ops::Add for Travel {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { down: self.down + other.down, up: self.up + other.up }
    }
}
