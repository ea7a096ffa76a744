//! Commands: what each does, and what it says at the end.

use crate::args::{
    Cli, Command, InkArgs, LightArgs, MapArgs, MarksArgs, PrintArgs, SceneArgs, StencilArgs,
    StyleAction, colour,
};
use crate::spared;
use chiaro::binary::{self, Look};
use chiaro::film::Target;
use chiaro::given::{self, Given, Sequence};
use chiaro::project::{Options, Project};
use chiaro::record::Record;
use chiaro::style::{self, Style};
use chiaro::{compare, compare_films, demo, figures, gbuffer, info, lines, mincut};
use chiaro_basis::{Error, Knobs, Result, Run};
use clap::CommandFactory;
use std::io::Write;
use std::path::Path;

/// Runs a command; the record of those that have one.
pub(crate) fn run(command: &Command, run: &Run) -> Result<Option<Record>> {
    spared::check(command)?;
    match command {
        Command::Demo { output, .. } => demo::demo(output, run).map(Some),
        Command::Info { scene, .. } => {
            let project = Project::open(&scene.scene, scene.options()?, run)?;
            info::info(&project, run).map(Some)
        }
        Command::Gbuffer { scene, output, .. } => {
            let project = Project::open(&scene.scene, scene.options()?, run)?;
            let target = Target::parse(output, project.frames().len())?;
            gbuffer::Job { project: &project, target }.run(run).map(Some)
        }
        Command::Binary { scene, output, ink, print, stencil, maps, dump_graph, .. } => {
            let dump_graph = dump_graph.as_deref();
            let drawing = Drawing { scene, output, ink, print, stencil, maps, dump_graph };
            binary(&drawing, run).map(Some)
        }
        Command::Lines { scene, output, marks, print, common } => {
            draw_lines(scene, output, marks, print, common.json.is_some(), run).map(Some)
        }
        Command::Compare { a, b, motion, .. } => {
            compare_any(a, b, motion.as_deref(), run).map(Some)
        }
        Command::Light { scene, output, light, .. } => {
            draw_light(scene, output, light, run).map(Some)
        }
        Command::Mincut { file, output, verify, .. } => {
            mincut::Job { file, output: output.clone(), verify: *verify }.run(run).map(Some)
        }
        Command::Figures { names, scenes, output, .. } => {
            figures::figures(names, scenes, output, run).map(Some)
        }
        Command::Style { action: StyleAction::List { output, .. } } => list_styles(output, run),
        Command::Style { action: StyleAction::Show { name } } => {
            print(Style::find(name)?.to_toml().as_bytes())
        }
        Command::Completions { shell } => {
            let mut bytes = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "chiaro", &mut bytes);
            print(&bytes)
        }
        Command::Man => print(&man()?),
    }
}

/// What `binary` was told.
struct Drawing<'a> {
    scene: &'a SceneArgs,
    output: &'a Path,
    ink: &'a InkArgs,
    print: &'a PrintArgs,
    stencil: &'a StencilArgs,
    maps: &'a MapArgs,
    dump_graph: Option<&'a Path>,
}

fn binary(drawing: &Drawing, run: &Run) -> Result<Record> {
    let Drawing { scene, output, ink, print, stencil, maps, dump_graph } = *drawing;
    let mut options = scene.options()?;
    let (style, knobs) = knobs(ink)?;
    let sequence = sequence(scene, &options, maps)?;
    let scene_frames = || options.frames.as_ref().map_or(1, Vec::len);
    let frames = sequence.as_ref().map_or_else(scene_frames, |s| s.frames().len());
    let target = Target::parse(output, frames)?;
    let print = print.print()?;
    options.paper = binary::printed(&target, &print)?;
    let look = Look {
        style: &style,
        knobs: &knobs,
        colours: ink.colours.colours(&style)?,
        print,
        painting: maps.painting()?,
        stencil: stencil.cutting()?,
    };
    if let Some(sequence) = &sequence {
        let film = given::Film { sequence, look, target, fps: options.fps };
        return film.run(run);
    }
    let maps = maps.maps();
    if given::is_picture(&scene.scene) {
        let given = &Given::open(&scene.scene, &maps, run)?;
        return given::Job { given, look, target }.run(run);
    }
    if maps.any() {
        let range = "a PNG, JPEG or EXR picture beside --normals, --depth and --discontinuity";
        return Err(Error::setting("SCENE", &scene.scene, range));
    }
    let project = Project::open(&scene.scene, options, run)?;
    let (project, dump_graph) = (&project, dump_graph.map(Path::to_path_buf));
    let job = binary::Job { project, look, target, dump_graph };
    job.run(run)
}

/// The film that another program drew, where the scene is one.
fn sequence(scene: &SceneArgs, options: &Options, maps: &MapArgs) -> Result<Option<Sequence>> {
    if !given::is_sequence(&scene.scene) {
        return Ok(None);
    }
    let (frames, shot) = (options.frames.clone(), options.shot.clone());
    Sequence::open(&scene.scene, maps.maps(), frames, shot).map(Some)
}

fn draw_lines(
    scene: &SceneArgs,
    output: &Path,
    marks: &MarksArgs,
    print: &PrintArgs,
    measure: bool,
    run: &Run,
) -> Result<Record> {
    let options = scene.options()?;
    let style = Style::of_lines(&marks.style)?;
    let look = look_of_lines(&style, marks, print)?;
    let target = lines::target(output, options.frames.as_ref().map_or(1, Vec::len))?;
    let project = Project::open(&scene.scene, options, run)?;
    let check = match marks.check.as_deref() {
        None => false,
        Some("fine") => true,
        Some(other) => return Err(Error::setting("--check", other, "fine")),
    };
    lines::Job { project: &project, look, target, measure, check }.run(run)
}

fn look_of_lines<'a>(
    style: &'a Style,
    marks: &MarksArgs,
    print: &PrintArgs,
) -> Result<lines::Look<'a>> {
    let mut look = lines::Look::of(style)?;
    marks.sets.iter().try_for_each(|text| look.set(text))?;
    if let Some(method) = &marks.method {
        look.lines.knobs.set("method", method)?;
    }
    if let Some(hidden) = &marks.hidden {
        look.lines.knobs.set("hidden", hidden)?;
    }
    if let Some(over) = &marks.over {
        look.over = lines::Over::parse(over)?;
    }
    look.colours = marks.colours.colours(style)?;
    look.print = print.print()?;
    Ok(look)
}

/// Two pictures, or two films along the motion of one of them.
fn compare_any(a: &Path, b: &Path, motion: Option<&Path>, run: &Run) -> Result<Record> {
    match (motion, [a, b].into_iter().find(|p| compare_films::is_film(p))) {
        (Some(motion), _) => compare_films::compare_films(a, b, motion, run),
        (None, Some(film)) => Err(Error::setting(
            "--motion",
            film.display(),
            "films are compared along their motion: name the files of chiaro gbuffer",
        )),
        (None, None) => compare::compare(a, b, run),
    }
}

fn draw_light(scene: &SceneArgs, output: &Path, light: &LightArgs, run: &Run) -> Result<Record> {
    let options = scene.options()?;
    let settings = LightSettings::of(light)?;
    let frames = options.frames.as_ref().map_or(1, Vec::len);
    let target = Target::parse(output, frames)?;
    chiaro::light::check_target(&target)?;
    let project = Project::open(&scene.scene, options, run)?;
    let job = chiaro::light::Job {
        project: &project,
        knobs: &settings.knobs,
        method: settings.method,
        env: light.env.clone(),
        check: settings.check,
        bake: light.bake.clone(),
        tree: light.tree.clone(),
        book: light.book.clone(),
        memory: settings.memory,
        backdrop: settings.backdrop,
        target,
    };
    job.run(run)
}

fn knobs(ink: &InkArgs) -> Result<(Style, chiaro_binary::BinaryKnobs)> {
    let style = Style::of_regions(&ink.style)?;
    let mut knobs = style.binary.clone();
    for text in &ink.sets {
        style::set(&mut knobs, text)?;
    }
    Ok((style, knobs))
}

/// What the options of light mean.
struct LightSettings {
    knobs: chiaro_pbgi::LightKnobs,
    method: chiaro::light::Method,
    check: chiaro::light::Check,
    backdrop: Option<[f32; 4]>,
    memory: Option<u64>,
}

impl LightSettings {
    fn of(args: &LightArgs) -> Result<Self> {
        let mut knobs = chiaro_pbgi::LightKnobs::default();
        for text in &args.sets {
            style::set(&mut knobs, text)?;
        }
        if let Some(error) = args.max_error {
            if error <= 0.0 {
                return Err(Error::setting("--max-error", error, "a share over 0, as in 0.02"));
            }
            knobs.set("max_error", &error.to_string())?;
        }
        let memory = args
            .memory
            .as_deref()
            .map(|m| chiaro::light::parse_bytes("--memory", m))
            .transpose()?;
        if args.bake.is_some() || args.tree.is_some() || args.book.is_some() {
            knobs.set("tree", "compact")?;
        }
        if let Some(tree) = &args.tree {
            let set = |knob: &str| {
                args.sets.iter().any(|s| s.split('=').next().map(str::trim) == Some(knob))
            };
            let said = |knob: &str| set(knob) || knob == "max_error" && args.max_error.is_some();
            chiaro::light::adopt(tree, &mut knobs, said)?;
        }
        if let Some(stops) = args.exposure {
            knobs.set("exposure", &stops.to_string())?;
        }
        let method = match args.method.as_str() {
            "pbgi" => chiaro::light::Method::Pbgi,
            "path" => chiaro::light::Method::Path,
            other => return Err(Error::setting("--method", other, "pbgi or path")),
        };
        let check = match args.check.as_deref() {
            None => chiaro::light::Check::Nothing,
            Some(word) if method != chiaro::light::Method::Pbgi => {
                return Err(Error::setting("--check", word, "--method pbgi beside it"));
            }
            Some("path") => chiaro::light::Check::Path,
            Some("exact") if knobs.is_compact() => chiaro::light::Check::Exact,
            Some("exact") => {
                let remedy = "--set tree=compact or --set clusters=N beside it";
                return Err(Error::setting("--check", "exact", remedy));
            }
            Some(other) => return Err(Error::setting("--check", other, "path or exact")),
        };
        let backdrop = args.background.as_deref().map(|t| colour("--background", t)).transpose()?;
        Ok(Self { knobs, method, check, backdrop, memory })
    }
}

fn list_styles(output: &Option<std::path::PathBuf>, run: &Run) -> Result<Option<Record>> {
    let mut text = String::new();
    for style in Style::all()? {
        let parts = match (style.has_regions(), style.has_lines()) {
            (true, true) => "both",
            (true, false) => "binary",
            _ => "lines",
        };
        text += &format!("{:<13} {parts:<7} {}\n", style.name, style.description);
    }
    print(text.as_bytes())?;
    match output {
        Some(path) => figures::style_sheet(path, run).map(Some),
        None => Ok(None),
    }
}

/// The manual: a page for the program and one for each command.
fn man() -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let root = Cli::command();
    let fail = |e: std::io::Error| Error::output("the manual page", e);
    clap_mangen::Man::new(root.clone()).render(&mut bytes).map_err(fail)?;
    for sub in root.get_subcommands() {
        let name: &'static str = format!("chiaro-{}", sub.get_name()).leak();
        clap_mangen::Man::new(sub.clone().name(name)).render(&mut bytes).map_err(fail)?;
    }
    Ok(bytes)
}

fn print(bytes: &[u8]) -> Result<Option<Record>> {
    match std::io::stdout().write_all(bytes) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::output("standard output", e))
        }
        _ => Ok(None),
    }
}

/// What holds a stencil together, if the record is of one.
fn of_stencil(record: &Record) -> String {
    let count = |name: &str| record.counts.get(name).and_then(serde_json::Value::as_f64);
    let [Some(bridges), Some(length)] = [count("bridges"), count("bridges_mm")] else {
        return String::new();
    };
    let bridges = format!("{bridges} bridges ({length:.1} mm in all)");
    match (count("stencils"), count("stencil_energy")) {
        (Some(sheets), Some(energy)) => {
            format!(": {sheets} stencils of one piece each, {bridges}, energy {energy:+.1}")
        }
        (_, Some(energy)) => format!(": one piece, {bridges}, energy {energy:+.1}"),
        _ => String::new(),
    }
}

/// What a command says at its end, for people.
pub(crate) fn summary(command: &Command, record: &Record) -> String {
    let quiet = command.common().is_some_and(|c| c.quiet);
    match command {
        Command::Info { .. } => info::text(record),
        Command::Mincut { .. } => mincut::text(record),
        Command::Compare { .. } => {
            record.counts.iter().map(|(name, value)| format!("{name:<18} {value}\n")).collect()
        }
        _ if quiet => String::new(),
        Command::Demo { output, .. } | Command::Figures { output, .. } => {
            format!("open {}\n", output.join("index.html").display())
        }
        _ => match record.outputs.as_slice() {
            [] => String::new(),
            [one] => format!("{}{}\n", one.path.display(), of_stencil(record)),
            [first, .., last] => format!(
                "{} files, {} to {}{}\n",
                record.outputs.len(),
                first.path.display(),
                last.path.display(),
                of_stencil(record)
            ),
        },
    }
}
