//! Which camera looks, and how large the picture is.

use crate::number::{LONGEST_SIDE, MOST_PIXELS};
use crate::project::{Options, PRINT_DPI, Project};
use chiaro_basis::math::{Quat, Vec3};
use chiaro_basis::{Error, Result, Run, nearest};
use chiaro_ink::Sheet;
use chiaro_scene::{Bounds, Frame, Pose, Projection};
use chiaro_trace::view;
use serde_json::{Map, Value, json};
use std::borrow::Cow;

/// The longer side of a picture whose size nobody chose, in pixels.
const DEFAULT_SIDE: f32 = 1024.0;

/// Frames that a default view is framed by at most, and vertices in all of them.
const FRAMING: usize = 48;
const FRAMING_VERTICES: usize = 1_000_000;

/// The camera of a shot.
#[derive(Clone, Debug)]
pub struct Camera {
    source: Source,
    /// Width and height in pixels.
    pub size: (usize, usize),
    /// How it was chosen, for `settings.camera`.
    pub note: String,
}

#[derive(Clone, Debug)]
enum Source {
    /// One of the scene's cameras, which may move.
    Scene { index: usize, fov: Option<f32> },
    /// A fixed view, turned once round the axis through a centre over a turntable's shot.
    Fixed { pose: Pose, turn: Option<(Vec3, u32, u32)> },
}

impl Camera {
    /// Chooses the camera of a project's shot, `frames` being a few of the shot's frames.
    pub fn choose(project: &Project, frames: &[Frame], run: &Run) -> Result<Self> {
        let o = &project.options;
        if let Some(fov) = o.fov
            && !(1.0..=170.0).contains(&fov)
        {
            return Err(Error::setting("--fov", fov, "a vertical angle from 1 to 170 degrees"));
        }
        let by_hand = o.from.is_some() || o.look_at.is_some();
        let turned = o.turntable || o.orbit != 0.0;
        if !by_hand && (o.camera.is_some() || (!project.scene.cameras.is_empty() && !turned)) {
            return Self::of_scene(project);
        }
        Self::default_view(project, frames, by_hand, run)
    }

    fn of_scene(project: &Project) -> Result<Self> {
        let cameras = &project.scene.cameras;
        let index = match &project.options.camera {
            None => 0,
            Some(name) => find_camera(project, name)?,
        };
        let camera = &cameras[index];
        let aspect = camera.aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(4.0 / 3.0);
        let size = size(&project.options, aspect)?;
        let fov = project.options.fov.map(f32::to_radians);
        let note = match camera.name.as_str() {
            "" => format!("camera {index} of the scene"),
            name => format!("camera {index} of the scene, {name}"),
        };
        Ok(Self { source: Source::Scene { index, fov }, size, note })
    }

    fn default_view(project: &Project, frames: &[Frame], by_hand: bool, run: &Run) -> Result<Self> {
        let o = &project.options;
        let first = frames.first().expect("a shot has a frame");
        let tracer = project.tracer(first);
        let framing = view::Framing::of(&tracer, &framed(project, frames, run));
        let framing = if o.turntable { framing.turned() } else { framing };
        let size = size(o, framing.aspect(o.orbit))?;
        let aspect = size.0 as f32 / size.1 as f32;
        let (mut pose, setting) = framing.view(aspect, o.orbit);
        let mut note = match setting {
            view::Setting::Room => "default view: inside the room, where most is to be seen",
            view::Setting::Object => "default view: three-quarter",
        }
        .to_owned();
        if by_hand {
            pose = by_hand_view(pose, o.from, o.look_at, &framing.bounds);
            note = "by --from and --look-at".into();
        } else {
            run.warn(format!("no camera in use from the scene: {note}"));
        }
        if let (Some(fov), Projection::Perspective { fov_y }) = (o.fov, &mut pose.projection) {
            *fov_y = fov.to_radians();
        }
        let turn = o.turntable.then(|| {
            let shot = project.shot();
            let centre = if setting == view::Setting::Room {
                pose.position
            } else {
                framing.bounds.centre()
            };
            (centre, shot[0], shot.len() as u32)
        });
        Ok(Self { source: Source::Fixed { pose, turn }, size, note })
    }

    /// The camera at a frame.
    pub fn pose(&self, frame: &Frame, number: u32) -> Pose {
        match &self.source {
            Source::Scene { index, fov } => {
                let mut pose = frame.cameras[*index];
                if let (Some(fov), Projection::Perspective { fov_y }) = (fov, &mut pose.projection)
                {
                    *fov_y = *fov;
                }
                pose
            }
            Source::Fixed { pose, turn: None } => *pose,
            Source::Fixed { pose, turn: Some((centre, first, count)) } => {
                let share = number.saturating_sub(*first) as f32 / (*count).max(1) as f32;
                let turn = Quat::from_rotation_y(share * std::f32::consts::TAU);
                Pose {
                    position: *centre + turn * (pose.position - *centre),
                    right: turn * pose.right,
                    up: turn * pose.up,
                    forward: turn * pose.forward,
                    ..*pose
                }
            }
        }
    }

    /// The fixed view in numbers, to be given by hand; `None` for cameras of the scene.
    pub fn numbers(&self) -> Option<[Vec3; 2]> {
        match &self.source {
            Source::Scene { .. } => None,
            Source::Fixed { pose, .. } => Some([pose.position, pose.position + pose.forward]),
        }
    }

    /// What decides the view, for recipes.
    pub fn settings(&self, project: &Project) -> Map<String, Value> {
        let o = &project.options;
        let mut s = Map::new();
        let mut put = |name: &str, value: Value| s.insert(name.into(), value);
        put("input", project.file_name().into());
        put("input_sha256", project.hash.clone().into());
        put("without", json!(o.without));
        put("size", json!([self.size.0, self.size.1]));
        put("camera", self.note.clone().into());
        put(
            "camera_choice",
            json!({
                "camera": o.camera, "from": o.from, "look_at": o.look_at, "fov": o.fov,
                "orbit": o.orbit, "turntable": o.turntable, "up": format!("{:?}", o.up),
            }),
        );
        put(
            "time",
            json!({
                "fps": o.fps, "time": o.time, "loop": o.looped,
                "animation": format!("{:?}", o.animation), "shot": project.shot(),
            }),
        );
        if let Some([from, look_at]) = self.numbers() {
            put("view", json!({ "from": from.to_array(), "look_at": look_at.to_array() }));
        }
        s
    }

    /// The same camera with a picture `height` pixels high, or lower where it is more than four times
    /// as wide as high, so that it never has more than 4 `height`² pixels, but for a row.
    pub fn at_height(&self, height: usize) -> Self {
        let (w, h) = self.size;
        let fitting = ((4 * height * height * h) as f64 / w as f64).sqrt().ceil() as usize;
        let height = height.min(fitting.max(1));
        let width = ((w * height) as f32 / h as f32).round().max(1.0) as usize;
        Self { size: (width, height), ..self.clone() }
    }
}

/// Frames of a shot that show all of its movement, as many as vertices allow; `few` at least.
fn framed<'a>(project: &Project, few: &'a [Frame], run: &Run) -> Cow<'a, [Frame]> {
    let vertices: usize = few[0].shapes.iter().map(|s| s.positions.len()).sum();
    let numbers = project.sampled_shot((FRAMING_VERTICES / vertices.max(1)).min(FRAMING));
    if numbers.len() <= few.len() {
        return Cow::Borrowed(few);
    }
    let poser = project.poser();
    Cow::Owned(numbers.into_iter().map(|n| project.pose(&poser, n, run)).collect())
}

fn find_camera(project: &Project, name: &str) -> Result<usize> {
    let cameras = &project.scene.cameras;
    let named = cameras.iter().position(|c| c.name == name);
    let by_index = || name.parse::<usize>().ok().filter(|i| *i < cameras.len());
    named.or_else(by_index).ok_or_else(|| {
        if cameras.is_empty() {
            return Error::setting("--camera", name, "a scene with cameras; this one has none");
        }
        let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).collect();
        let hint = nearest(name, names.iter().copied().filter(|n| !n.is_empty()))
            .map(|n| format!("; did you mean {n}?"))
            .unwrap_or_default();
        let range =
            format!("an index below {} or one of {}{hint}", cameras.len(), names.join(", "));
        Error::setting("--camera", name, range)
    })
}

/// The picture's size, of an aspect (width over height) where nobody chose it.
fn size(options: &Options, aspect: f32) -> Result<(usize, usize)> {
    match (options.size, &options.paper) {
        (Some(size), _) => Ok(size),
        (None, Some(sheet)) => print_size(sheet, aspect),
        (None, None) => Ok(size_for(aspect)),
    }
}

/// The size of a picture of an aspect that fills what the margins leave of a sheet.
fn print_size(sheet: &Sheet, aspect: f32) -> Result<(usize, usize)> {
    // Of a shape as large as needed for the rounding to be far under a dot.
    let shape = ((1e6 * f64::from(aspect)).round().max(1.0) as usize, 1_000_000);
    let dots = PRINT_DPI / sheet.place(shape)?.dpi();
    let [w, h] = [shape.0, shape.1].map(|side| (side as f64 * dots).round().max(1.0) as usize);
    if w.max(h) > LONGEST_SIDE || w * h > MOST_PIXELS {
        let range = format!(
            "smaller paper, or a --size: at {PRINT_DPI} dots an inch, {} megapixels at most",
            MOST_PIXELS / 1_000_000
        );
        return Err(Error::setting("--paper", format!("{w}x{h} dots"), range));
    }
    Ok((w, h))
}

/// The picture size for an aspect (width over height).
fn size_for(aspect: f32) -> (usize, usize) {
    let (w, h) = if aspect >= 1.0 {
        (DEFAULT_SIDE, DEFAULT_SIDE / aspect)
    } else {
        (DEFAULT_SIDE * aspect, DEFAULT_SIDE)
    };
    let side = |s: f32| (s.round().max(1.0) as usize).min(LONGEST_SIDE);
    debug_assert!(side(w) * side(h) <= MOST_PIXELS);
    (side(w), side(h))
}

/// The default view with the eye, the target, or both given by hand.
fn by_hand_view(
    default: Pose,
    from: Option<[f32; 3]>,
    look_at: Option<[f32; 3]>,
    bounds: &Bounds,
) -> Pose {
    let target = look_at.map_or(bounds.centre(), Vec3::from);
    let distance = (default.position - bounds.centre()).length();
    let eye = from.map_or(target - default.forward * distance, Vec3::from);
    Pose::look_at(eye, target, Vec3::Y, default.projection)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_fill_what_the_margins_leave() {
        let mut sheet = Sheet { margin: 10.0, ..Sheet::default() };
        sheet.set_paper("A4").expect("a paper");
        // 190 and 277 mm at 600 dots an inch; the paper is turned for what is wide.
        assert_eq!(print_size(&sheet, 0.5).expect("fits"), (3272, 6543));
        assert_eq!(print_size(&sheet, 2.0).expect("fits"), (6543, 3272));
        assert_eq!(print_size(&sheet, 0.9).expect("fits"), (4488, 4987));
        sheet.set_paper("A0").expect("a paper");
        let error = print_size(&sheet, 1.0).expect_err("too large").to_string();
        assert!(error.contains("--size"), "{error}");
    }
}
