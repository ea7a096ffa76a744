//! The knobs of a brush: the one table.
//!
//! Lengths are in pixels of the picture that is drawn.

use chiaro_basis::{choice, knobs};

choice! {
    /// What a stroke is made of.
    pub enum Mark {
        /// One line.
        #[default]
        Line = "line",
        /// Two lines side by side, with nothing between them.
        Double = "double",
        /// Pieces of line.
        Dashes = "dashes",
        /// Discs.
        Dots = "dots",
        /// A line with thorns.
        Thorns = "thorns",
        /// Hairs.
        Fur = "fur",
        /// Nothing.
        Nothing = "none",
    }
}

choice! {
    /// What the ink of a stroke looks like from near.
    pub enum Grain {
        /// Even.
        #[default]
        Solid = "solid",
        /// Streaks along the stroke, as of a brush that runs dry.
        Bristle = "bristle",
        /// Coarse specks.
        Charcoal = "charcoal",
        /// Fine specks.
        Pencil = "pencil",
        /// Pale with darker edges.
        Wash = "wash",
        /// A picture, once along the whole stroke, its ends unstretched.
        Stretch = "stretch",
        /// A picture, again and again.
        Repeat = "repeat",
    }
}

choice! {
    /// How a line ends.
    pub enum Cap {
        /// With half a disc.
        #[default]
        Round = "round",
        /// Straight.
        Flat = "flat",
    }
}

choice! {
    /// On which side thorns and hairs stand.
    pub enum Side {
        /// On the right: the outside of silhouettes.
        #[default]
        Outside = "outside",
        /// On the left: the front of silhouettes.
        Inside = "inside",
        /// On both.
        Both = "both",
    }
}

knobs! {
    /// What strokes look like.
    pub struct Brush {
        mark: Mark = Mark::Line, Choice(Mark::WORDS), "", "", "what a stroke is made of";
        colour: String = "ink".into(), Text, "", "", "ink, paper, object, id (each line its own), or any colour";
        opacity: f32 = 1.0, Number { min: 0.0, max: 1.0 }, "", "", "of the ink; a stroke never darkens itself";
        width: f32 = 2.0, Number { min: 0.05, max: 200.0 }, "", "px", "width of the line at its widest pressure";
        pressure: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of the width that comes and goes along u";
        pressure_length: f32 = 90.0, Number { min: 2.0, max: 5000.0 }, "", "px", "length of a change of pressure";
        taper: f32 = 0.0, Number { min: 0.0, max: 2000.0 }, "", "px", "length over which an end comes to a point";
        tip: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of the width that is left at an end";
        taper_end: f32 = 1.0, Number { min: 0.0, max: 10.0 }, "", "", "that of the last end, times the first's";
        swell: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of the width that is there in the middle of a stroke alone";
        shade: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of the width that is there away from the light alone";
        shade_angle: f32 = 125.0, Number { min: -360.0, max: 360.0 }, "", "degrees", "where the light of shade is, counter-clockwise from the right";
        nib: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "how flat the nib is: 1 draws nothing along its edge";
        nib_angle: f32 = 40.0, Number { min: -180.0, max: 180.0 }, "", "degrees", "how the nib is held";
        slender: f32 = 5.0, Number { min: 0.0, max: 100.0 }, "", "", "a short stroke is at least this many times as long as it is wide";
        cap: Cap = Cap::Round, Choice(Cap::WORDS), "", "", "how lines end";

        smooth: f32 = 2.0, Number { min: 0.0, max: 100.0 }, "", "px", "over which lines are smoothed, corners kept";
        overshoot: f32 = 0.0, Number { min: 0.0, max: 500.0 }, "", "px", "by which ends go too far";
        wobble: f32 = 0.0, Number { min: 0.0, max: 100.0 }, "", "px", "by which the hand strays";
        wobble_length: f32 = 60.0, Number { min: 2.0, max: 5000.0 }, "", "px", "length of a stray";
        repeat: u32 = 1, Count { min: 1, max: 12 }, "", "", "how often a line is drawn, each time a little elsewhere";

        grain: Grain = Grain::Solid, Choice(Grain::WORDS), "", "", "what the ink looks like from near";
        grain_size: f32 = 1.4, Number { min: 0.2, max: 100.0 }, "", "px", "of specks, or across streaks";
        grain_strength: f32 = 0.7, Number { min: 0.0, max: 1.0 }, "", "", "how much of the ink is missing where it misses most";
        rough: f32 = 0.0, Number { min: 0.0, max: 50.0 }, "", "px", "by which edges are torn";
        rough_length: f32 = 3.0, Number { min: 0.3, max: 500.0 }, "", "px", "length of a tear";
        picture: String = String::new(), Text, "", "", "PNG of a stroke from left to right, for the grains stretch and repeat";
        picture_cap: f32 = 0.15, Number { min: 0.0, max: 0.5 }, "", "", "share of the picture that is an end";

        spacing: f32 = 12.0, Number { min: 0.5, max: 2000.0 }, "a (4.4)", "px", "from mark to mark along u: dashes, dots, thorns, hairs";
        dash: f32 = 0.6, Number { min: 0.02, max: 1.0 }, "", "", "share of the spacing that a dash fills";
        size: f32 = 8.0, Number { min: 0.2, max: 500.0 }, "", "px", "length of thorns and hairs, diameter of dots";
        base: f32 = 0.35, Number { min: 0.01, max: 2.0 }, "", "", "width of thorns and hairs at their root, in lengths";
        lean: f32 = 0.3, Number { min: -3.0, max: 3.0 }, "", "", "by which thorns and hairs lean along the stroke, in lengths";
        jitter: f32 = 0.25, Number { min: 0.0, max: 1.0 }, "", "", "how uneven marks are";
        side: Side = Side::Outside, Choice(Side::WORDS), "", "", "where thorns and hairs stand";
        gap: f32 = 4.0, Number { min: 0.2, max: 200.0 }, "", "px", "between the middles of a double line";

        halo: f32 = 0.0, Number { min: 0.0, max: 100.0 }, "", "px", "gap by which a line interrupts those behind it";
        rim: f32 = 0.0, Number { min: 0.0, max: 100.0 }, "", "px", "band of paper outside a line, over what is beneath";
        outline: bool = true, Switch, "", "", "SVG holds strokes as filled outlines of their width, else as paths of its mean";
    }
}
