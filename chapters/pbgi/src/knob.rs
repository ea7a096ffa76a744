//! The knobs of light: the one table.

use chiaro_basis::knobs;
use chiaro_image::tone::Tone;

knobs! {
    /// How a scene is lit.
    pub struct LightKnobs {
        surfels: u32 = 100000, Count { min: 16, max: 100000000 }, "N (6.3.2)", "", "surfels that stand for the scene's surfaces";
        bounces: u32 = 3, Count { min: 0, max: 64 }, "", "", "times that light is reflected before it reaches what is seen; 0: direct light alone";
        solid_angle: f32 = 2.0, Number { min: 0.05, max: 64.0 }, "sigma (6.3.2)", "texels", "a node whose sphere looks smaller than this is not opened";
        resolution: u32 = 12, Count { min: 2, max: 64 }, "", "texels", "texels along a side of the cube buffer";
        error_bound: f32 = 0.1, Number { min: 0.0, max: 1.0 }, "", "share", "error allowed by sharing gathers; 0: every pixel gathers by itself";
        bounce_rays: u32 = 16, Count { min: 1, max: 1024 }, "", "rays", "rays by which a surfel sees the others";
        side_rays: u32 = 8, Count { min: 0, max: 64 }, "", "rays", "rays by which dead sides are found; 0: all sides live";
        flat_nodes: bool = true, Switch, "", "", "whether flat nodes use the exact cosine";
        near_field: bool = true, Switch, "", "", "whether the near field is rays on the triangles";
        samples: u32 = 64, Count { min: 1, max: 1000000 }, "", "paths", "paths a pixel of the reference (--method path)";
        exposure: f32 = 0.0, Number { min: -32.0, max: 32.0 }, "", "stops", "brighter or darker than the automatic exposure";
        tone: Tone = Tone::Neutral, Choice(Tone::WORDS), "", "", "tone curve of displayed pictures; neutral: Khronos PBR Neutral";
        edges: u32 = 4, Count { min: 1, max: 16 }, "", "", "samples along a side of pixels where edges are smoothed; 1: none";
    }
}
