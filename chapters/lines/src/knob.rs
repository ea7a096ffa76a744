//! The knobs of animated lines: the one table.
//!
//! Lengths are in pixels of the picture that is drawn, whatever its size, unless said otherwise:
//! a pen does not grow with the paper.

use chiaro_basis::{choice, knobs};

choice! {
    /// What becomes of hidden lines.
    pub enum Hidden {
        /// They are not drawn.
        #[default]
        Drop = "drop",
        /// They are dashed.
        Dashed = "dashed",
        /// They are drawn as the style has it.
        Style = "style",
    }
}

choice! {
    /// How lines are parameterized.
    pub enum Method {
        /// Once over the film (4.6).
        #[default]
        Global = "global",
        /// From frame to frame, by votes (Kalnins et al. 2003).
        Propagate = "propagate",
        /// From frame to frame, by diffusion (4.9).
        Diffuse = "diffuse",
        /// Every frame by itself.
        Arclength = "arclength",
    }
}

choice! {
    /// What textures do on lines whose length changes.
    pub enum Texture {
        /// They repeat (4.11).
        #[default]
        Periodic = "periodic",
        /// They stretch to cover the line (4.8, 4.10).
        Stretched = "stretched",
    }
}

choice! {
    /// How lines that merge and split are kept apart.
    pub enum Cuts {
        /// As charts; where that leaves links that contradict each other, as both.
        #[default]
        Auto = "auto",
        /// A robust solve finds what contradicts; lines are cut there into charts, and parted in name
        /// alone where lines of two ids merge.
        Charts = "charts",
        /// At every merger and split, paired within the sliding limit, and where contradictions are
        /// left: half the solve, and on most films fewer jumps, on some more stretch.
        Both = "both",
        /// As charts, but links are dropped and lines stay whole.
        Links = "links",
        /// At every merger and split, paired within the sliding limit.
        Events = "events",
        /// At every merger and split, each to the end of its line's life.
        Unpaired = "unpaired",
        /// Not at all.
        None = "none",
    }
}

choice! {
    /// How a sample finds its place one frame later.
    pub enum Links {
        /// By its material point's projection.
        #[default]
        Projected = "projected",
        /// Along the space-time surface, where there is one.
        Swept = "swept",
    }
}

knobs! {
    /// Which lines are found, and how they are tracked.
    pub struct LinesKnobs {
        silhouette: bool = true, Switch, "n . V = 0 (4.5.2)", "", "silhouettes";
        crease: bool = true, Switch, "", "", "sharp edges";
        border: bool = true, Switch, "", "", "where a surface ends";
        material: bool = true, Switch, "", "", "borders between materials";
        intersection: bool = true, Switch, "", "", "where pieces pass through each other";
        suggestive: bool = false, Switch, "", "", "suggestive contours";
        ridge: bool = false, Switch, "", "", "ridges";
        valley: bool = false, Switch, "", "", "valleys";
        apparent_ridge: bool = false, Switch, "", "", "apparent ridges";
        terminator: bool = false, Switch, "", "", "shadow lines of a light";

        suggestive_strength: f32 = 6.0, Number { min: 0.0, max: 1e4 }, "D_w k_r", "1/R^2", "least rise of the radial curvature at suggestive contours";
        ridge_strength: f32 = 8.0, Number { min: 0.0, max: 1e4 }, "k", "1/R", "least curvature of ridges and valleys";
        apparent_strength: f32 = 8.0, Number { min: 0.0, max: 1e4 }, "q_1", "1/R", "least view-dependent curvature of apparent ridges";
        smooth_curvature: u32 = 3, Count { min: 0, max: 20 }, "", "passes", "one-ring means of the curvature";
        light_azimuth: f32 = -50.0, Number { min: -180.0, max: 180.0 }, "", "degrees", "where the terminator's light is, right of the viewer";
        light_elevation: f32 = 35.0, Number { min: -90.0, max: 90.0 }, "", "degrees", "how high the terminator's light is";

        crease_angle: f32 = 40.0, Number { min: 1.0, max: 180.0 }, "", "degrees", "least bend of a sharp edge that the file shades hard";
        smooth_crease_angle: f32 = 75.0, Number { min: 1.0, max: 180.0 }, "", "degrees", "least bend of a sharp edge that the file shades smooth";
        smooth_normals: u32 = 0, Count { min: 0, max: 4 }, "K", "passes", "one-ring means of the normals of silhouettes, for scans";

        subdivide: u32 = 2, Count { min: 0, max: 3 }, "", "levels", "how often coarse meshes are refined at most, once for the shot";
        subdivide_edge: f32 = 8.0, Number { min: 0.1, max: 100.0 }, "", "px", "length of edges near silhouettes at which a mesh is fine enough";

        step: f32 = 3.0, Number { min: 0.5, max: 20.0 }, "ds", "px", "distance of a stroke's samples";
        bridge: f32 = 4.0, Number { min: 0.0, max: 100.0 }, "", "px", "hidden gaps below this are bridged";
        shortest: f32 = 10.0, Number { min: 0.0, max: 500.0 }, "", "px", "visible runs below this are dropped";
        beside: f32 = 1.5, Number { min: 0.0, max: 20.0 }, "", "px", "lines that run beside a stronger one within this are left out";
        prune: f32 = 24.0, Number { min: 0.0, max: 1000.0 }, "", "px", "closed silhouettes that never grow longer than this are dropped, hidden parts counted";
        hidden: Hidden = Hidden::Drop, Choice(Hidden::WORDS), "", "", "what becomes of hidden lines";
        margin: f32 = 24.0, Number { min: 0.0, max: 1000.0 }, "", "px", "lines are followed this far out of the picture";

        method: Method = Method::Global, Choice(Method::WORDS), "", "", "how lines are parameterized";
        texture: Texture = Texture::Periodic, Choice(Texture::WORDS), "(4.10), (4.11)", "", "whether textures repeat or stretch";
        coherence: f32 = 0.8, Number { min: 0.0, max: 1.0 }, "", "", "0: textures spread evenly, 1: they follow the surface";
        pattern_length: f32 = 24.0, Number { min: 1.0, max: 10000.0 }, "a", "px", "pixels a unit of u of repeated textures";
        sliding_limit: f32 = 8.0, Number { min: 0.5, max: 1000.0 }, "sigma", "px", "disagreement from which lines are kept apart";
        cuts: Cuts = Cuts::Auto, Choice(Cuts::WORDS), "(4.7)", "", "how lines that merge and split are kept apart";
        links: Links = Links::Projected, Choice(Links::WORDS), "(4.7)", "", "how a sample finds its place one frame later";
        octaves: bool = false, Switch, "", "", "repeated textures grow with the zoom, to be redrawn at twice or half their size";
        w_projection: f32 = 0.0, Number { min: 0.0, max: 1e4 }, "w_proj", "1/px^2", "weight of following the surface; 0: by coherence";
        w_distortion: f32 = 1.0, Number { min: 1e-3, max: 1e4 }, "w_dis", "", "weight of spreading evenly";
        w_end: f32 = 0.3, Number { min: 0.0, max: 1e4 }, "w_end", "1/px^2", "weight of stretched textures ending where lines do";
    }
}
