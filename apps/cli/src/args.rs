//! Arguments as typed: one table for parser, help, man page and completions.

use chiaro::binary::Cutting;
use chiaro::colours::Colours;
use chiaro::given::Maps;
use chiaro::number::{parse_frames, parse_numbers, parse_size};
use chiaro::painting::Painting;
use chiaro::project::{Options, parse_point};
use chiaro::style::Style;
use chiaro::vector::{Print, Sheet, length};
use chiaro_basis::{Error, Result};
use chiaro_image::colour::parse_colour;
use chiaro_scene::Choice;
use chiaro_scene::load::Up;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Animated 3D scenes with few marks and much light.
#[derive(Parser)]
#[command(name = "chiaro", version, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
#[allow(clippy::large_enum_variant, reason = "there is one, parsed once")]
pub(crate) enum Command {
    /// Make pictures from embedded scenes through every pipeline, and a page that shows them.
    Demo {
        /// Folder for the pictures and index.html.
        #[arg(short, long, default_value = "chiaro-demo")]
        output: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// Say what is in a scene: meshes, triangles, cameras, lights, clips, warnings.
    Info {
        #[command(flatten)]
        scene: SceneArgs,
        #[command(flatten)]
        common: Common,
    },
    /// Write depth, normals, ids, motion and appearance as named EXR layers.
    Gbuffer {
        #[command(flatten)]
        scene: SceneArgs,
        /// An .exr file, or a pattern such as out/####.exr.
        #[arg(short, long)]
        output: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// Draw a scene, a picture or a renderer's EXR (renders/####.exr: a film) in black and white, balancing appearance against geometry by a minimal cut.
    Binary {
        #[command(flatten)]
        scene: SceneArgs,
        /// A .png, .svg, .tif, .pbm, .apng, .gif or .mp4 file, a pattern such as frames/####.png, or a folder.
        #[arg(short, long)]
        output: PathBuf,
        #[command(flatten)]
        ink: InkArgs,
        /// Also write the graph and its cut as NumPy arrays into this folder; of a film, a
        /// numbered folder a frame.
        #[arg(long, value_name = "DIR")]
        dump_graph: Option<PathBuf>,
        #[command(flatten)]
        print: PrintArgs,
        #[command(flatten)]
        stencil: StencilArgs,
        #[command(flatten)]
        maps: MapArgs,
        #[command(flatten)]
        common: Common,
    },
    /// Draw the lines of a scene: silhouettes, creases, borders, each with an id through the film.
    Lines {
        #[command(flatten)]
        scene: SceneArgs,
        /// A .png, .svg, .json, .apng, .gif or .mp4 file, a pattern such as frames/####.svg, or a folder.
        #[arg(short, long)]
        output: PathBuf,
        #[command(flatten)]
        marks: MarksArgs,
        #[command(flatten)]
        print: PrintArgs,
        #[command(flatten)]
        common: Common,
    },
    /// Light a scene in full: direct light, shadows, and light reflected any number of times.
    Light {
        #[command(flatten)]
        scene: SceneArgs,
        /// A .png, .exr, .apng, .gif or .mp4 file, a pattern such as frames/####.exr, or a folder.
        #[arg(short, long)]
        output: PathBuf,
        #[command(flatten)]
        light: LightArgs,
        #[command(flatten)]
        common: Common,
    },
    /// Measure how two pictures differ, or how much two films flicker along the motion.
    Compare {
        /// The picture to judge (PNG, JPEG or EXR), or a film: a folder, or a pattern with #.
        a: PathBuf,
        /// The picture to judge it by, or the other film.
        b: PathBuf,
        /// For films: EXR files with motion and depth, as `chiaro gbuffer` writes them.
        #[arg(long, value_name = "FILES")]
        motion: Option<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// Solve a DIMACS maximum-flow problem: flow, minimal cut, time.
    Mincut {
        /// A file of lines `p max NODES ARCS`, `n ID s`, `n ID t`, `a FROM TO CAPACITY`.
        #[arg(value_name = "FILE.max")]
        file: PathBuf,
        /// Write the flow, a line `f FROM TO FLOW` for each arc that carries some.
        #[arg(short, long)]
        output: Option<PathBuf>,
        /// Check the solution: capacities, conservation at every node, flow equal to cut.
        #[arg(long)]
        verify: bool,
        #[command(flatten)]
        common: Common,
    },
    /// Remake figures of the thesis as contact sheets, with a page that shows them.
    Figures {
        /// Which: 2.3, 3.4 to 3.16, table-3.1, 4.1 to 4.15, 4.events, 4.ids, 4.lines, 4.textures,
        /// 4.styles, 4.character, 5.1, 5.3, 6.1, 6.2, 6.5 to 6.10, 6.rate, 6.books, table-6.1 to table-6.3,
        /// baselines, flicker, methods, strokes, light; none means all but 6.rate, 6.books and the last four.
        names: Vec<String>,
        /// A scene for the figures of chapter 6 and for baselines, flicker, methods, strokes and light,
        /// which lay ways side by side; may be repeated.
        #[arg(long = "scene", value_name = "SCENE")]
        scenes: Vec<String>,
        /// Folder for the sheets and index.html.
        #[arg(short, long, default_value = "chiaro-figures")]
        output: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// List the named styles, or show one as TOML to start your own from.
    Style {
        #[command(subcommand)]
        action: StyleAction,
    },
    /// Print completions for a shell.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    Man,
}

#[derive(Subcommand)]
pub(crate) enum StyleAction {
    /// Name and description of each style.
    List {
        /// Also draw a sheet of thumbnails into this PNG file.
        #[arg(short, long)]
        output: Option<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// A style as TOML, every knob with its help.
    Show {
        /// The style's name.
        name: String,
    },
}

/// Options of every command that works for a while.
#[derive(Args, Clone, Debug)]
pub(crate) struct Common {
    /// Threads; 0 or none means all cores. The result does not depend on it.
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Write the record as JSON to a file, or to standard output alone with -.
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<String>,
    /// Print nothing but errors.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Print each stage with its time.
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

/// A scene with its view, its time and its film.
#[derive(Args, Clone, Debug)]
pub(crate) struct SceneArgs {
    /// A .gltf, .glb, .obj, .ply or .stl file, or demo:NAME.
    #[arg(value_name = "SCENE")]
    pub(crate) scene: String,
    /// Picture size in pixels [default: the camera's or the shape's aspect, 1024 on the longer side].
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// A camera of the scene.
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// The eye's place in scene units.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    from: Option<String>,
    /// What the eye looks at, in scene units.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    look_at: Option<String>,
    /// Vertical angle of view in degrees.
    #[arg(long, value_name = "DEG")]
    fov: Option<f32>,
    /// Turn the default view.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, default_value_t = 0.0)]
    orbit: f32,
    /// Turn the default view once round over the shot.
    #[arg(long)]
    turntable: bool,
    /// Leave out what the nodes of this name show; * stands for anything. May be repeated.
    #[arg(long, value_name = "NAME")]
    without: Vec<String>,
    /// Which way is up: y, z, -y, or auto.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true, default_value = "auto")]
    up: String,
    /// Frames to write: 7, 1-48, 1-100x2, or a list with commas.
    #[arg(long, value_name = "LIST")]
    frames: Option<String>,
    /// Frames over which the film's decisions are taken [default: --frames].
    #[arg(long, value_name = "LIST")]
    shot: Option<String>,
    /// Frames a second.
    #[arg(long, value_name = "N", default_value_t = 24.0)]
    fps: f64,
    /// One picture at this time.
    #[arg(long, value_name = "SECONDS", conflicts_with = "frames")]
    time: Option<f64>,
    /// Start animations again after their end.
    #[arg(long = "loop")]
    looped: bool,
    /// Which animation plays; all: every one, later ones winning.
    #[arg(long, value_name = "NAME|INDEX|all")]
    animation: Option<String>,
    /// Light the scene with a sun at this azimuth and elevation alone.
    #[arg(long, value_name = "AZIMUTH,ELEVATION", allow_hyphen_values = true)]
    sun: Option<String>,
    /// Make missing files errors.
    #[arg(long)]
    strict: bool,
    /// Begin again whenever the scene, a file around it or another file named here changes, until
    /// Ctrl-C.
    #[arg(long)]
    pub(crate) watch: bool,
}

/// How it is drawn.
#[derive(Args, Clone, Debug)]
pub(crate) struct InkArgs {
    /// A named style, or a TOML file.
    #[arg(long, value_name = "NAME|FILE", default_value = "ink")]
    pub(crate) style: String,
    /// Set a knob; `chiaro style show ink` lists them all.
    #[arg(long = "set", value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub(crate) sets: Vec<String>,
    #[command(flatten)]
    pub(crate) colours: ColourArgs,
}

/// Ink and background.
#[derive(Args, Clone, Debug)]
pub(crate) struct ColourArgs {
    /// Colour where there is nothing, or none [default: the style's, else white].
    #[arg(long, value_name = "COLOUR")]
    background: Option<String>,
    /// Colour of the ink [default: the style's, else black].
    #[arg(long, value_name = "COLOUR")]
    ink: Option<String>,
}

impl ColourArgs {
    /// The colours of a style, with what the arguments change.
    pub(crate) fn colours(&self, style: &Style) -> Result<Colours> {
        let mut colours = style.colours();
        if let Some(ink) = &self.ink {
            colours.ink = colour("--ink", ink)?;
        }
        if let Some(background) = &self.background {
            colours.background = colour("--background", background)?;
        }
        Ok(colours)
    }
}

/// A colour as an option has it.
pub(crate) fn colour(option: &str, text: &str) -> Result<[f32; 4]> {
    parse_colour(text).map_err(|e| match e {
        Error::Setting { got, range, .. } => Error::setting(option, got, range),
        other => other,
    })
}

/// How lines are drawn.
#[derive(Args, Clone, Debug)]
pub(crate) struct MarksArgs {
    /// How lines are parameterized: global, or a baseline: propagate, diffuse or arclength.
    #[arg(long, value_name = "HOW")]
    pub(crate) method: Option<String>,
    /// A named style of lines, or a TOML file.
    #[arg(long, value_name = "NAME|FILE", default_value = "pen")]
    pub(crate) style: String,
    /// What lines are drawn over: nothing, binary, light, a picture, or a pattern such as
    /// frames/####.png [default: as the style has it].
    #[arg(long, value_name = "WHAT")]
    pub(crate) over: Option<String>,
    /// What becomes of hidden lines: drop, dashed, or style (as the style's [stroke.hidden] says).
    #[arg(long, value_name = "HOW")]
    pub(crate) hidden: Option<String>,
    /// Measure errors of visibility against a surface sixteen times finer; takes a while.
    #[arg(long, value_name = "fine")]
    pub(crate) check: Option<String>,
    /// Set a knob, as in width=3, or of one line type alone, as in crease.width=1; `chiaro style
    /// show pen` lists them all.
    #[arg(long = "set", value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub(crate) sets: Vec<String>,
    #[command(flatten)]
    pub(crate) colours: ColourArgs,
}

/// Maps beside a colour image, and strokes on it.
#[derive(Args, Clone, Debug)]
pub(crate) struct MapArgs {
    /// For a picture: its normals, n = 2 c - 1, x right, z to the viewer.
    #[arg(long, value_name = "FILE")]
    normals: Option<PathBuf>,
    /// Where the y of --normals points.
    #[arg(long, value_name = "up|down", default_value = "up", value_parser = ["up", "down"])]
    normals_y: String,
    /// For a picture: its depth, growing with distance.
    #[arg(long, value_name = "FILE")]
    depth: Option<PathBuf>,
    /// For a picture: a map of lines to be drawn on top.
    #[arg(long, value_name = "FILE")]
    discontinuity: Option<PathBuf>,
    /// Paint: a text file of strokes, lines such as `white 6 120,80 140,90` (label white, black or
    /// erase, radius, points in pixels); white 6 frame 12 120,80 is on frame 12 alone, but teaches
    /// the whole shot.
    #[arg(long, value_name = "FILE")]
    strokes: Option<PathBuf>,
    /// How much of the weights is learned from the strokes: 0 none, 1 all.
    #[arg(long, value_name = "0..1", default_value_t = 0.5)]
    blend: f64,
}

impl MapArgs {
    /// The strokes, read.
    pub(crate) fn painting(&self) -> Result<Option<Painting>> {
        let blend = within("--blend", self.blend, 0.0, 1.0)? as f32;
        self.strokes.as_deref().map(|path| Painting::open(path, blend)).transpose()
    }

    /// What the arguments mean.
    pub(crate) fn maps(&self) -> Maps {
        Maps {
            normals: self.normals.clone(),
            normals_y_down: self.normals_y == "down",
            depth: self.depth.clone(),
            discontinuity: self.discontinuity.clone(),
        }
    }
}

/// Paper and pen.
#[derive(Args, Clone, Debug)]
pub(crate) struct PrintArgs {
    /// Paper for vectors and .tif: A4, letter, A3-landscape, 200x300mm [default: the picture's own size].
    /// A .tif without --size fills it at 600 dots an inch.
    #[arg(long, value_name = "PAPER")]
    paper: Option<String>,
    /// What stays free on every side of the paper.
    #[arg(long, value_name = "LENGTH", default_value = "0mm")]
    margin: String,
    /// Whether the picture fills the paper, or lies in its middle at 96 pixels to the inch.
    #[arg(long, value_name = "fit|centre", default_value = "fit")]
    place: String,
    /// Draw vectors with a pen of this width, as in 0.3mm: strokes alone, hatching instead of fills.
    #[arg(long, value_name = "LENGTH")]
    pen: Option<String>,
}

impl PrintArgs {
    /// What the arguments mean.
    pub(crate) fn print(&self) -> Result<Print> {
        let mut sheet = Sheet::default();
        if let Some(paper) = &self.paper {
            sheet.set_paper(paper)?;
        }
        sheet.margin = length("--margin", &self.margin, 0.0..=5000.0)?;
        sheet.fits = match self.place.as_str() {
            "fit" => true,
            "centre" => false,
            other => return Err(Error::setting("--place", other, "fit or centre")),
        };
        let pen = self.pen.as_deref().map(|p| length("--pen", p, 0.02..=50.0)).transpose()?;
        Ok(Print { sheet, pen })
    }
}

/// Stencils.
#[derive(Args, Clone, Debug)]
pub(crate) struct StencilArgs {
    /// Make a stencil: holes where the ink is, in a sheet of one piece, held by bridges of this
    /// width, as in 2mm; of a palette one for each ink, as layers of an SVG or as files `name-1.png`,
    /// `name-2.png`, the darkest first.
    #[arg(long, value_name = "LENGTH")]
    stencil: Option<String>,
    /// Holes and loose parts of a stencil smaller than a disc of this diameter are left out.
    #[arg(long, value_name = "LENGTH", default_value = "2mm", requires = "stencil")]
    smallest_part: String,
}

impl StencilArgs {
    /// What the arguments mean.
    pub(crate) fn cutting(&self) -> Result<Option<Cutting>> {
        let Some(bridge) = &self.stencil else { return Ok(None) };
        let bridge = length("--stencil", bridge, 0.01..=500.0)?;
        let part = length("--smallest-part", &self.smallest_part, 0.0..=500.0)?;
        Ok(Some(Cutting { bridge, part }))
    }
}

/// How it is lit.
#[derive(Args, Clone, Debug)]
pub(crate) struct LightArgs {
    /// How light is transported: pbgi (point-based, free of noise) or path (the reference).
    #[arg(long, value_name = "METHOD", default_value = "pbgi")]
    pub(crate) method: String,
    /// Surroundings in latitude and longitude: an .hdr, .exr, .png or .jpg file.
    #[arg(long, value_name = "FILE")]
    pub(crate) env: Option<PathBuf>,
    /// Stops brighter than the automatic exposure.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true)]
    pub(crate) exposure: Option<f32>,
    /// Set a knob: surfels, bounces, tree, clusters, error_bound and others.
    #[arg(long = "set", value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub(crate) sets: Vec<String>,
    /// Measure errors: against the path-traced reference (takes a while), or of a compact tree
    /// against the same tree before it was coded.
    #[arg(long, value_name = "path|exact")]
    pub(crate) check: Option<String>,
    /// Write the compact tree of surfels into a file, which is then mapped instead of kept.
    #[arg(long, value_name = "FILE", conflicts_with = "tree")]
    pub(crate) bake: Option<PathBuf>,
    /// Take far light from a tree that --bake wrote, and surfels and bounces from it too where --set does
    /// not say; larger than memory, and shared by renders.
    #[arg(long, value_name = "FILE")]
    pub(crate) tree: Option<PathBuf>,
    /// The table of words of a compact tree: read from FILE, or learned and written where there is no
    /// such file; one for a film or for several scenes.
    #[arg(long, value_name = "FILE", conflicts_with = "tree")]
    pub(crate) book: Option<PathBuf>,
    /// A compact tree by the smallest table of words that keeps this error of its nodes, as in 0.02.
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["tree", "book"])]
    pub(crate) max_error: Option<f32>,
    /// Keep within this much memory, as in 2GiB; a tree in a file may be larger. Some 150 MB and the
    /// scene are needed beside it.
    #[arg(long, value_name = "SIZE")]
    pub(crate) memory: Option<String>,
    /// Colour where there is nothing, or none [default: the sky].
    #[arg(long, value_name = "COLOUR")]
    pub(crate) background: Option<String>,
}

impl Command {
    /// The options that all long commands share.
    pub(crate) fn common(&self) -> Option<&Common> {
        match self {
            Self::Demo { common, .. }
            | Self::Info { common, .. }
            | Self::Gbuffer { common, .. }
            | Self::Binary { common, .. }
            | Self::Lines { common, .. }
            | Self::Light { common, .. }
            | Self::Compare { common, .. }
            | Self::Figures { common, .. }
            | Self::Mincut { common, .. }
            | Self::Style { action: StyleAction::List { common, .. } } => Some(common),
            Self::Style { .. } | Self::Completions { .. } | Self::Man => None,
        }
    }

    /// The scene of those that have one.
    pub(crate) fn scene(&self) -> Option<&SceneArgs> {
        match self {
            Self::Info { scene, .. }
            | Self::Gbuffer { scene, .. }
            | Self::Binary { scene, .. }
            | Self::Lines { scene, .. }
            | Self::Light { scene, .. } => Some(scene),
            _ => None,
        }
    }
}

impl SceneArgs {
    /// What the arguments mean.
    pub(crate) fn options(&self) -> Result<Options> {
        let frames = |option: &str, text: &Option<String>| {
            text.as_deref().map(|t| parse_frames(option, t)).transpose()
        };
        let point = |option: &str, text: &Option<String>| {
            text.as_deref().map(|t| parse_point(option, t)).transpose()
        };
        let options = Options {
            size: self.size.as_deref().map(parse_size).transpose()?,
            paper: None,
            camera: self.camera.clone(),
            from: point("--from", &self.from)?,
            look_at: point("--look-at", &self.look_at)?,
            fov: self.fov,
            orbit: within("--orbit", f64::from(self.orbit), -36000.0, 36000.0)? as f32,
            turntable: self.turntable,
            without: self.without.clone(),
            up: Up::parse(&self.up)?,
            frames: frames("--frames", &self.frames)?,
            shot: frames("--shot", &self.shot)?,
            fps: within("--fps", self.fps, 0.001, 10_000.0)?,
            time: self.time.map(|t| within("--time", t, 0.0, 1e9)).transpose()?,
            looped: self.looped,
            animation: match self.animation.as_deref() {
                None => Choice::Auto,
                Some("all") => Choice::All,
                Some(name) => Choice::One(name.into()),
            },
            sun: self.sun.as_deref().map(parse_sun).transpose()?,
            strict: self.strict,
        };
        check_shot(&options)?;
        Ok(options)
    }
}

fn parse_sun(text: &str) -> Result<[f32; 2]> {
    parse_numbers("--sun", text, "AZIMUTH,ELEVATION in degrees, as in -40,50")
}

fn within(option: &str, value: f64, min: f64, max: f64) -> Result<f64> {
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(Error::setting(option, value, format!("a number from {min} to {max}")))
    }
}

fn check_shot(options: &Options) -> Result<()> {
    let (Some(frames), Some(shot)) = (&options.frames, &options.shot) else { return Ok(()) };
    match frames.iter().find(|f| shot.binary_search(f).is_err()) {
        Some(outside) => Err(Error::setting("--frames", outside, "frames of the --shot")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_table_of_arguments_is_consistent() {
        Cli::command().debug_assert();
    }
}
