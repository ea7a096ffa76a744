//! The knobs of light: the one table.

use crate::code::Recipe;
use crate::stream::{LESSONS, SPARSE};
use chiaro_basis::{choice, knobs};
use chiaro_image::tone::Tone;

choice! {
    /// How the tree is kept in memory.
    pub enum Storage {
        /// In single precision.
        #[default]
        Exact = "exact",
        /// Coded, built batch by batch.
        Compact = "compact",
    }
}

choice! {
    /// From what a coded tree's book is learned.
    pub enum Teaching {
        /// A few frames of the film: one book for all.
        #[default]
        Film = "film",
        /// Each frame by itself.
        Frame = "frame",
    }
}

choice! {
    /// How surfels are spread.
    pub enum Sampling {
        /// Evenly along the sum of the triangles' areas.
        #[default]
        Sequence = "sequence",
        /// At a least distance from each other.
        Poisson = "poisson",
    }
}

choice! {
    /// How a tree in single precision divides space.
    pub enum Division {
        /// In two, into bounding spheres.
        #[default]
        Spheres = "spheres",
        /// In eight, into the cells of cubes.
        Octree = "octree",
    }
}

choice! {
    /// What pixels share.
    pub enum Sharing {
        /// Cube buffers, one a tile, and near rays.
        #[default]
        Tiles = "tiles",
        /// Few receivers that look by rays, with gradients.
        Records = "records",
    }
}

choice! {
    /// Whether a sky is added to a scene that has none.
    pub enum OwnSky {
        /// A clear one, outdoors, where a sun is the only light.
        #[default]
        Auto = "auto",
        /// Never.
        None = "none",
    }
}

knobs! {
    /// How a scene is lit.
    pub struct LightKnobs {
        surfels: u32 = 100000, Count { min: 16, max: 4000000000 }, "N (6.3.2)", "", "surfels that stand for the scene's surfaces";
        sampling: Sampling = Sampling::Sequence, Choice(Sampling::WORDS), "6.3.2", "", "sequence: surfels spread evenly by area; poisson: at a least distance from each other (slower)";
        focus: bool = false, Switch, "", "", "whether surfels lie denser where the shot's cameras see them: steadier detail, less of it where gathers are shared";
        tree: Storage = Storage::Exact, Choice(Storage::WORDS), "", "", "compact: some nine bytes a surfel, any number of surfels";
        hierarchy: Division = Division::Spheres, Choice(Division::WORDS), "6.3.2", "", "how a tree that is not compact divides space; spheres: in two; octree: in eight";
        clusters: u32 = 0, Count { min: 0, max: 65536 }, "l (6.5.1)", "words", "a compact tree whose lobes are one word each of a table of so many; 0: the default code";
        max_error: f32 = 0.0, Number { min: 0.0, max: 1.0 }, "6.7", "share", "a compact tree by the smallest book whose error of nodes it has not seen is at most this; 0: the default code";
        book: Teaching = Teaching::Film, Choice(Teaching::WORDS), "6.5.1", "", "film: one book for all frames of a compact tree; frame: one a frame, which may flicker";
        bounces: u32 = 3, Count { min: 0, max: 64 }, "", "", "times that light is reflected before it reaches what is seen; 0: direct light alone";
        solid_angle: f32 = 0.7, Number { min: 0.05, max: 64.0 }, "sigma (6.3.2)", "texels", "a node whose sphere looks smaller than this is not opened";
        resolution: u32 = 10, Count { min: 2, max: 64 }, "", "texels", "texels along a side of the cube buffer";
        error_bound: f32 = 0.1, Number { min: 0.0, max: 1.0 }, "", "share", "error allowed by sharing gathers; 0: every pixel gathers by itself";
        sharing: Sharing = Sharing::Tiles, Choice(Sharing::WORDS), "", "", "tiles: a buffer for each tile of the picture, and near rays; records: few pixels look by rays, those between follow their gradients (quick, for smooth interiors)";
        bounce_rays: u32 = 16, Count { min: 1, max: 1024 }, "", "rays", "rays by which a surfel sees the others";
        side_rays: u32 = 8, Count { min: 0, max: 64 }, "", "rays", "rays by which dead sides are found; 0: all sides live";
        flat_nodes: bool = true, Switch, "", "", "whether flat nodes use the exact cosine";
        near_field: bool = true, Switch, "", "", "whether the near field is rays on the triangles";
        glossy: bool = false, Switch, "", "", "whether what is seen is glossy as its material says (metal, roughness), not clean in mirrors yet; else all is matt";
        occlusion: f32 = 0.6, Number { min: 0.001, max: 1000.0 }, "", "R", "what is farther does not occlude (layer ao)";
        samples: u32 = 64, Count { min: 1, max: 1000000 }, "", "paths", "paths a pixel of the reference (--method path)";
        sky: OwnSky = OwnSky::Auto, Choice(OwnSky::WORDS), "", "", "auto: a clear sky outdoors where a sun is the only light; none: the scene's own light alone";
        exposure: f32 = 0.0, Number { min: -32.0, max: 32.0 }, "", "stops", "brighter or darker than the automatic exposure";
        tone: Tone = Tone::Neutral, Choice(Tone::WORDS), "", "", "tone curve of displayed pictures; neutral: Khronos PBR Neutral";
        edges: u32 = 4, Count { min: 1, max: 16 }, "", "", "samples along a side of pixels where edges are smoothed; 1: none";
    }
}

impl LightKnobs {
    /// Whether the tree is coded.
    pub fn is_compact(&self) -> bool {
        self.tree == Storage::Compact || self.clusters > 0 || self.max_error > 0.0
    }

    /// Whether pixels gather by rays alone, shared as records.
    pub fn is_by_records(&self) -> bool {
        self.sharing == Sharing::Records && self.error_bound > 0.0
    }

    /// Surfels that are lit in full and kept: all, or those that a coded tree learns from.
    pub fn kept_surfels(&self) -> u32 {
        if self.is_compact() { self.surfels.min(SPARSE as u32) } else { self.surfels }
    }

    /// The most surfels of a tree in single precision.
    pub const MOST_EXACT: u32 = 100_000_000;

    /// Nodes of a size from which a book is learned, at most.
    pub fn lessons(&self) -> usize {
        LESSONS.max(self.clusters as usize)
    }

    /// How lobes of a coded tree are coded.
    pub fn recipe(&self) -> Recipe {
        match self.clusters {
            0 => Recipe::default(),
            words => Recipe::clusters(words as usize),
        }
    }
}
