//! The knobs of binary shading: the one table.
//!
//! Lengths are in pixels of a picture 480 pixels high and grow with the picture, areas with its
//! square; the neighbour weight grows with the height, since terminals add up over areas and
//! borders over lengths.

use chiaro_basis::{choice, knobs};

choice! {
    /// How terminal weights are made of channels.
    pub enum Model {
        /// One tone, mixed from the channels, stretched and exposed.
        #[default]
        Tone = "tone",
        /// The thesis's sum over channels, (3.1) with (3.5).
        Thesis = "thesis",
    }
}

choice! {
    /// How depth differences are measured.
    pub enum DepthForm {
        /// The step off the tangent planes, in parts of R.
        #[default]
        Plane = "plane",
        /// The difference of distances to the camera, in parts of R: (3.6) as printed.
        Raw = "raw",
    }
}

choice! {
    /// How the mean curvature of (3.8) is found.
    pub enum CurvatureForm {
        /// From one Gaussian of the normal field, at a cost that does not depend on c.
        #[default]
        Fast = "fast",
        /// From all pixels of the window, each angle divided by its distance.
        Exact = "exact",
        /// As printed, but normalised: angles are not divided by their distance.
        Raw = "raw",
    }
}

knobs! {
    /// How a picture becomes black and white.
    pub struct BinaryKnobs {
        darkness: f32 = 0.0, Number { min: -1.0, max: 1.0 }, "", "macro", "more black, or less";
        detail: f32 = 0.0, Number { min: -1.0, max: 1.0 }, "", "macro", "more and smaller shapes, or fewer and larger ones";
        contrast: f32 = 0.0, Number { min: -1.0, max: 1.0 }, "", "macro", "more local contrast, or more of the light as a whole";
        features: f32 = 0.0, Number { min: -1.0, max: 1.0 }, "", "macro", "borders and lines keep more to ridges, creases and depth edges, or less";
        line_weight: f32 = 0.0, Number { min: -1.0, max: 1.0 }, "", "macro", "thicker lines, or thinner ones";

        model: Model = Model::Tone, Choice(Model::WORDS), "(3.1)", "", "how terminal weights are made of channels";

        half: f32 = 0.5, Number { min: 0.0, max: 1.0 }, "", "", "share of half-shadowed diffuse light in the tone";
        lit: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of fully shadowed diffuse light in the tone";
        diffuse: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of unshadowed diffuse light in the tone";
        headlamp: f32 = 0.2, Number { min: 0.0, max: 1.0 }, "", "", "share of the head lamp in the tone";
        occlusion: f32 = 0.3, Number { min: 0.0, max: 1.0 }, "", "", "share of ambient occlusion in the tone";
        specular: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of highlights in the tone";
        reflection: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of mirrored surroundings in the tone";
        luminance: f32 = 0.2, Number { min: 0.0, max: 1.0 }, "", "", "share of the base colour's lightness in the tone";
        indirect: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "share of light that surfaces send each other in the tone (scenes only)";
        occlusion_radius: f32 = 0.6, Number { min: 0.001, max: 10.0 }, "", "R", "reach of ambient occlusion";
        occlusion_rays: u32 = 8, Count { min: 1, max: 256 }, "", "rays", "occlusion rays a sample; sixty-four times as many directions count";
        gloss: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "", "", "roughness of highlights; 0: the material's";

        global: f32 = 0.35, Number { min: 0.0, max: 1.0 }, "g (3.5)", "", "global tone against local contrast";
        local_radius: f32 = 16.0, Number { min: 0.5, max: 480.0 }, "h (3.3)", "px at 480", "neighbourhood of local contrast";
        low: f32 = 2.0, Number { min: 0.0, max: 49.0 }, "", "percent", "tones below this percentile are black";
        high: f32 = 98.0, Number { min: 51.0, max: 100.0 }, "", "percent", "tones above this percentile are white";
        threshold: f32 = 0.0, Number { min: -0.5, max: 0.5 }, "", "", "added to the threshold between black and white";
        black_min: f32 = 0.35, Number { min: 0.0, max: 1.0 }, "", "share", "least share of black, if it can be had by exposure";
        black_max: f32 = 0.60, Number { min: 0.0, max: 1.0 }, "", "share", "greatest share of black, if it can be had by exposure";

        diffuse_w: f32 = 1.0, Number { min: 0.0, max: 4.0 }, "w_i (3.1)", "", "thesis model: pull of diffuse light to white";
        diffuse_b: f32 = 1.0, Number { min: 0.0, max: 4.0 }, "b_i (3.1)", "", "thesis model: pull of diffuse shade to black";
        diffuse_g: f32 = 1.0, Number { min: 0.0, max: 1.0 }, "g_i (3.5)", "", "thesis model: global against local diffuse light";
        diffuse_h: f32 = 16.0, Number { min: 0.5, max: 480.0 }, "h_i (3.3)", "px at 480", "thesis model: neighbourhood of diffuse light";
        headlamp_w: f32 = 0.0, Number { min: 0.0, max: 4.0 }, "w_i (3.1)", "", "thesis model: pull of the head lamp to white";
        headlamp_b: f32 = 0.0, Number { min: 0.0, max: 4.0 }, "b_i (3.1)", "", "thesis model: pull of grazing surfaces to black";
        headlamp_g: f32 = 1.0, Number { min: 0.0, max: 1.0 }, "g_i (3.5)", "", "thesis model: global against local head lamp";
        headlamp_h: f32 = 16.0, Number { min: 0.5, max: 480.0 }, "h_i (3.3)", "px at 480", "thesis model: neighbourhood of the head lamp";
        specular_w: f32 = 0.0, Number { min: 0.0, max: 4.0 }, "w_i (3.1)", "", "thesis model: pull of highlights to white";
        specular_b: f32 = 0.0, Number { min: 0.0, max: 4.0 }, "b_i (3.1)", "", "thesis model: pull of what has no highlight to black";
        specular_g: f32 = 1.0, Number { min: 0.0, max: 1.0 }, "g_i (3.5)", "", "thesis model: global against local highlights";
        specular_h: f32 = 16.0, Number { min: 0.5, max: 480.0 }, "h_i (3.3)", "px at 480", "thesis model: neighbourhood of highlights";
        occlusion_w: f32 = 0.0, Number { min: 0.0, max: 4.0 }, "w_i (3.1)", "", "thesis model: pull of open surfaces to white";
        occlusion_b: f32 = 0.0, Number { min: 0.0, max: 4.0 }, "b_i (3.1)", "", "thesis model: pull of hollows to black";
        occlusion_g: f32 = 1.0, Number { min: 0.0, max: 1.0 }, "g_i (3.5)", "", "thesis model: global against local occlusion";
        occlusion_h: f32 = 16.0, Number { min: 0.5, max: 480.0 }, "h_i (3.3)", "px at 480", "thesis model: neighbourhood of occlusion";

        neighbour: f32 = 0.15, Number { min: 0.0, max: 10.0 }, "N~ (3.2)", "at 480", "cost of a border, before geometry lowers it";
        floor: f32 = 0.1, Number { min: 0.0, max: 1.0 }, "", "", "share of the neighbour weight that geometry leaves";
        depth_falloff: f32 = 0.02, Number { min: 1e-6, max: 100.0 }, "d (3.6)", "R", "depth step that draws a border";
        depth_form: DepthForm = DepthForm::Plane, Choice(DepthForm::WORDS), "(3.6)", "", "how depth differences are measured";
        curvature_falloff: f32 = 0.15, Number { min: 1e-4, max: 100.0 }, "k (3.9)", "rad/px", "change of curvature that draws a border";
        curvature_radius: f32 = 3.0, Number { min: 0.5, max: 64.0 }, "c (3.8)", "px at 480", "neighbourhood of the mean curvature";
        curvature_form: CurvatureForm = CurvatureForm::Fast, Choice(CurvatureForm::WORDS), "(3.8)", "", "how the mean curvature is found";
        object_edge: f32 = 0.3, Number { min: 0.0, max: 1.0 }, "", "", "neighbour weight left between two objects";
        material_edge: f32 = 0.6, Number { min: 0.0, max: 1.0 }, "", "", "neighbour weight left between two materials";
        use_geometry: bool = true, Switch, "(3.2)", "", "whether geometry lowers neighbour weights";
        diagonal: bool = true, Switch, "", "", "whether diagonal borders weigh 1/sqrt 2";

        round: f32 = 4.0, Number { min: 0.0, max: 64.0 }, "", "px at 480", "how far from their borders regions are cut again with sixteen neighbours, without which they run in facets; 0: not at all";
        island: f32 = 30.0, Number { min: 0.0, max: 100000.0 }, "", "px at 480", "smaller patches take the colour around them; 0 keeps all";
        smooth: f32 = 1.1, Number { min: 0.0, max: 10.0 }, "", "px at 480", "smoothing of borders after the cut";

        palette: String = String::new(), Text, "", "", "colours: a number of tones, colours from dark to light, or spot: and colours; empty: ink and paper";
        coherence: f32 = 0.3, Number { min: 0.0, max: 1.0 }, "", "N~", "films: how strongly frames hold on to each other; 0: each frame on its own";
        window: u32 = 7, Count { min: 2, max: 9 }, "", "frames", "films: frames that are cut together; 3 is faster";

        lines: bool = true, Switch, "", "", "whether lines are drawn on top";
        line_width: f32 = 1.5, Number { min: 0.1, max: 50.0 }, "", "px at 480", "width of lines";
        line_depth: f32 = 0.015, Number { min: 1e-6, max: 100.0 }, "", "R", "depth step that draws a line";
        line_crease: f32 = 40.0, Number { min: 1.0, max: 181.0 }, "", "degrees", "crease that draws a line; 181: none";
        line_objects: bool = true, Switch, "", "", "whether borders between objects draw lines";
        line_silhouette: bool = true, Switch, "", "", "whether the outline is drawn where the region is white";
        line_white: bool = true, Switch, "", "", "whether lines inside black are white";
        line_black: bool = true, Switch, "", "", "whether lines inside white are black";
        halo: f32 = 0.0, Number { min: 0.0, max: 100.0 }, "", "px at 480", "white gap behind what occludes, whatever the label there; 0: none";
        line_shortest: f32 = 8.0, Number { min: 0.0, max: 1000.0 }, "", "px at 480", "shorter runs of line are dropped";

        vector_tolerance: f32 = 0.04, Number { min: 0.001, max: 10.0 }, "", "px at 480", "how far curves of an SVG may be from the smoothed borders";
        vector_corner: f32 = 40.0, Number { min: 5.0, max: 180.0 }, "", "degrees", "bends that stay sharp corners in an SVG; 180: none";
        hatch_angle: f32 = 45.0, Number { min: -360.0, max: 360.0 }, "", "degrees", "direction of hatching for a pen, from the right downwards";
        hatch_turn: f32 = 0.0, Number { min: -360.0, max: 360.0 }, "", "degrees", "by how much the hatching of each lighter colour is turned";
        hatch_spacing: f32 = 1.0, Number { min: 0.2, max: 100.0 }, "", "pens", "from one stroke of hatching to the next, for black";
        hatch_outline: bool = true, Switch, "", "", "whether hatched regions get an outline";
    }
}

impl BinaryKnobs {
    /// The knobs with their five macro controls worked into the weights; the macros are then 0.
    pub fn resolved(&self) -> Self {
        let mut k = self.clone();
        let towards = |x: f32, end: f32, t: f32| x + (end - x) * t;
        let both = |x: f32, low: f32, high: f32, t: f32| {
            if t < 0.0 { towards(x, low, -t) } else { towards(x, high, t) }
        };
        let times = |x: &mut f32, octaves: f32| *x *= octaves.exp2();

        k.black_min = both(k.black_min, 0.02, 0.85, self.darkness);
        k.black_max = both(k.black_max, 0.08, 0.95, self.darkness).max(k.black_min);
        k.threshold = (k.threshold + 0.2 * self.darkness).clamp(-0.5, 0.5);

        times(&mut k.neighbour, -1.8 * self.detail);
        times(&mut k.island, -2.5 * self.detail);
        times(&mut k.smooth, -0.7 * self.detail);
        times(&mut k.local_radius, -self.detail);
        times(&mut k.line_shortest, -1.5 * self.detail);
        times(&mut k.line_depth, -self.detail);

        k.global = both(k.global, 1.0, 0.02, self.contrast);
        for g in [&mut k.diffuse_g, &mut k.headlamp_g, &mut k.specular_g, &mut k.occlusion_g] {
            *g = both(*g, 1.0, 0.02, self.contrast);
        }

        k.floor = both(k.floor, 1.0, 0.02, self.features);
        times(&mut k.neighbour, 0.6 * self.features);
        times(&mut k.curvature_falloff, -self.features);
        times(&mut k.depth_falloff, -self.features);
        k.line_crease = both(k.line_crease, 90.0, 20.0, self.features).min(k.line_crease.max(90.0));
        times(&mut k.line_depth, -0.7 * self.features);

        times(&mut k.line_width, 1.6 * self.line_weight);
        (k.darkness, k.detail, k.contrast, k.features, k.line_weight) = (0.0, 0.0, 0.0, 0.0, 0.0);
        k
    }

    /// The knobs for a picture of so many tones: the more tones there are, the less local contrast
    /// has to stand in for them.
    pub fn for_tones(&self, tones: usize) -> Self {
        let steps = tones.saturating_sub(1).max(1) as f32;
        Self { global: 1.0 - (1.0 - self.global) / steps.powf(1.2), ..self.clone() }
    }

    /// The smallest area that a piece keeps, in pixels of a picture of this height.
    pub fn island_area(&self, height: usize) -> f32 {
        self.island * scaled(1.0, height).powi(2)
    }
}

/// The picture height that lengths are stated for, in pixels.
pub const REFERENCE_HEIGHT: f32 = 480.0;

/// Pixels for a length stated at the reference height.
pub fn scaled(length: f32, height: usize) -> f32 {
    length * height as f32 / REFERENCE_HEIGHT
}
