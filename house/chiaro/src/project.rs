//! [`Project`]: a scene, opened, with its view, its time and its film.

use crate::disk::{self, Folder};
use crate::number;
use crate::pattern::matches;
use chiaro_basis::{Error, Result, Run, nearest};
use chiaro_ink::Sheet;
use chiaro_scene::load::{self, Budget, Door, Up};
use chiaro_scene::{Choice, Frame, Playback, Poser, Scene, demo};
use chiaro_trace::{Hierarchy, Tracer};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Dots an inch of a print whose size nobody chose.
pub const PRINT_DPI: f64 = 600.0;

/// Options that every command on a scene shares, as the user typed them; empty ones take their
/// defaults.
#[derive(Clone, Debug)]
pub struct Options {
    /// Picture size in pixels; `None`: from the camera or the shape.
    pub size: Option<(usize, usize)>,
    /// Paper that a picture of a scene fills at [`PRINT_DPI`] where it has no size.
    pub paper: Option<Sheet>,
    /// Camera by name or index; `None`: the first, or the default view.
    pub camera: Option<String>,
    /// The eye, in scene units.
    pub from: Option<[f32; 3]>,
    /// What the eye looks at, in scene units.
    pub look_at: Option<[f32; 3]>,
    /// Vertical angle of view in degrees.
    pub fov: Option<f32>,
    /// Turns the default view, degrees.
    pub orbit: f32,
    /// Turns the default view once round over the shot.
    pub turntable: bool,
    /// Names of nodes whose meshes are left out; `*` stands for anything.
    pub without: Vec<String>,
    /// Which way is up.
    pub up: Up,
    /// Frames to write; `None`: see [`Options::time`].
    pub frames: Option<Vec<u32>>,
    /// Frames over which a film's decisions are taken; `None`: the frames.
    pub shot: Option<Vec<u32>>,
    /// Frames a second.
    pub fps: f64,
    /// A single picture at this time, seconds.
    pub time: Option<f64>,
    /// Whether animation starts again after its end.
    pub looped: bool,
    /// Which clips play.
    pub animation: Choice,
    /// Azimuth and elevation of the sun in degrees, seen from the default view's side.
    pub sun: Option<[f32; 2]>,
    /// Whether missing files are errors.
    pub strict: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size: None,
            paper: None,
            camera: None,
            from: None,
            look_at: None,
            fov: None,
            orbit: 0.0,
            turntable: false,
            without: Vec::new(),
            up: Up::Auto,
            frames: None,
            shot: None,
            fps: 24.0,
            time: None,
            looped: false,
            animation: Choice::Auto,
            sun: None,
            strict: false,
        }
    }
}

/// A scene, opened, with everything that does not change from frame to frame.
pub struct Project {
    /// The name as the user gave it.
    pub name: String,
    /// The hash of the scene's main file, or of its name if it is procedural.
    pub hash: String,
    /// The files that the scene was read from.
    pub files: Vec<PathBuf>,
    /// The scene.
    pub scene: Scene,
    /// What plays.
    pub playback: Playback,
    /// The options.
    pub options: Options,
    /// What was built for the frame traced last.
    hierarchy: Mutex<Option<Arc<Hierarchy>>>,
}

impl Project {
    /// Opens the scene called `name`: a path, or `demo:` and the name of a procedural one.
    pub fn open(name: &str, options: Options, run: &Run) -> Result<Self> {
        let (mut scene, hash, files) = run.stage("load", 1, || open_scene(name, options.up))?;
        options.without.iter().try_for_each(|pattern| leave_out(&mut scene, pattern))?;
        if options.strict && !scene.stored.missing_files.is_empty() {
            let why = format!(
                "missing {}; put them beside the scene, or leave out --strict",
                scene.stored.missing_files.join(", ")
            );
            return Err(Error::input(name, "", why));
        }
        for warning in &scene.warnings {
            run.warn(warning);
        }
        let (playback, notes) = scene.playback(&options.animation)?;
        for note in notes {
            run.warn(note);
        }
        let hierarchy = Mutex::default();
        Ok(Self { name: name.into(), hash, files, scene, playback, options, hierarchy })
    }

    /// The name without folders, for recipes.
    pub fn file_name(&self) -> String {
        let path = Path::new(&self.name);
        path.file_name().map_or_else(|| self.name.clone(), |n| n.to_string_lossy().into_owned())
    }

    /// The scene's frames, ready to be posed.
    pub fn poser(&self) -> Poser<'_> {
        Poser::new(&self.scene)
    }

    /// The frames to write. One picture is frame 1.
    pub fn frames(&self) -> Vec<u32> {
        self.options.frames.clone().unwrap_or_else(|| vec![1])
    }

    /// The frames of the shot.
    pub fn shot(&self) -> Vec<u32> {
        self.options.shot.clone().unwrap_or_else(|| self.frames())
    }

    /// Seconds of a frame.
    pub fn time(&self, frame: u32) -> f64 {
        match self.options.time {
            Some(time) if self.options.frames.is_none() => time,
            _ => self.playback.time(&self.scene, frame, self.options.fps, self.options.looped),
        }
    }

    /// At most `count` frames of the shot, spread evenly, the first always among them.
    pub fn sampled_shot(&self, count: usize) -> Vec<u32> {
        let shot = self.shot();
        let n = shot.len().min(count);
        let mut sampled: Vec<u32> = (0..n).map(|i| shot[i * shot.len() / n]).collect();
        sampled.dedup();
        sampled
    }

    /// The scene at a frame.
    pub fn pose(&self, poser: &Poser<'_>, frame: u32, run: &Run) -> Frame {
        run.stage("frame", 1, || poser.frame(self.time(frame), &self.playback))
    }

    /// Rays into a frame. What has not changed since the last call is used again, the rest is
    /// refitted; what rays meet does not depend on it.
    pub fn tracer<'a>(&'a self, frame: &'a Frame) -> Tracer<'a> {
        let last = self.hierarchy.lock().unwrap_or_else(PoisonError::into_inner).take();
        let hierarchy = Arc::new(match last {
            Some(last) => last.refit(&self.scene, frame),
            None => Hierarchy::build(&self.scene, frame),
        });
        *self.hierarchy.lock().unwrap_or_else(PoisonError::into_inner) = Some(hierarchy.clone());
        Tracer::with(&self.scene, frame, hierarchy)
    }
}

/// Takes the meshes off nodes that a pattern names.
fn leave_out(scene: &mut Scene, pattern: &str) -> Result<()> {
    let mut found = false;
    for node in scene.nodes.iter_mut().filter(|n| matches(pattern, &n.name)) {
        found |= node.mesh.take().is_some();
    }
    let shown = || scene.nodes.iter().filter(|n| n.mesh.is_some()).map(|n| n.name.as_str());
    if found && shown().next().is_some() {
        return Ok(());
    }
    let hint = nearest(pattern, shown()).map(|n| format!("; did you mean {n}?"));
    let range = match found {
        true => "names that leave something to be drawn".into(),
        false => format!("the name of a node that shows something{}", hint.unwrap_or_default()),
    };
    Err(Error::setting("--without", pattern, range))
}

/// The scene, the hash of its file, and all files that it was read from.
fn open_scene(name: &str, up: Up) -> Result<(Scene, String, Vec<PathBuf>)> {
    if let Some(demo_name) = name.strip_prefix("demo:") {
        let scene = demo::scene(demo_name)?;
        return Ok((scene, crate::write::sha256(name.as_bytes()), Vec::new()));
    }
    let path = Path::new(name);
    if !path.exists() {
        return Err(Error::input(name, "", not_found(path)));
    }
    let bytes = disk::read(path)?;
    let hash = crate::write::sha256(&bytes);
    let folder = Folder::of(path);
    let mut door = Door::new(name, &folder, Budget::default());
    let scene = load::read_scene(name, &bytes, up, &mut door)?;
    let mut files = folder.into_read();
    files.push(path.into());
    Ok((scene, hash, files))
}

/// Not found, with the nearest name in the folder or among the procedural scenes.
fn not_found(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if demo::names().contains(&name.as_str()) {
        return format!("not found; did you mean demo:{name}?");
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|e| Some(e.ok()?.file_name().to_string_lossy().into_owned())).collect();
    names.sort();
    match nearest(&name, names.iter().map(String::as_str)) {
        Some(near) => format!("not found; did you mean {}?", folder.join(near).display()),
        None => "not found; check the path".into(),
    }
}

/// A point as `--from` has it.
pub fn parse_point(option: &str, text: &str) -> Result<[f32; 3]> {
    number::parse_numbers(option, text, "X,Y,Z in scene units, as in 1,2.5,-3")
}
