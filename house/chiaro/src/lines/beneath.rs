//! What lines are drawn over: nothing, the regions of binary shading, the scene in its light, or
//! pictures from files.

use crate::binary::{self, Encoding};
use crate::colours::Colours;
use crate::disk;
use crate::film::Target;
use crate::project::Project;
use crate::style::Style;
use crate::vector::{Print, layers};
use chiaro_basis::{Error, Result, Run};
use chiaro_binary::BinaryKnobs;
use chiaro_image::Plane;
use chiaro_image::codec::{self, Limits};
use chiaro_ink::Layer;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// What lines are drawn over.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Over {
    /// The background alone.
    #[default]
    Nothing,
    /// Black and white regions by the style's own knobs.
    Binary,
    /// The scene under full light.
    Light,
    /// A picture a frame, or one for all.
    Pictures(Target),
}

impl Over {
    /// Reads `--over`, or a style's `over`: `nothing`, `binary`, `light`, a picture, or a pattern of
    /// pictures.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "nothing" => Ok(Self::Nothing),
            "binary" => Ok(Self::Binary),
            "light" => Ok(Self::Light),
            path if path.contains('#') || Path::new(path).extension().is_some() => {
                let path = PathBuf::from(path);
                let pattern = path.to_string_lossy().contains('#');
                Ok(Self::Pictures(if pattern {
                    Target::Pattern(path)
                } else {
                    Target::Single(path)
                }))
            }
            other => Err(Error::setting(
                "--over",
                other,
                "nothing, binary, light, a picture, or a pattern of pictures such as frames/####.png",
            )),
        }
    }

    /// The picture of a frame from its file, in a `size`.
    pub(super) fn picture(&self, number: u32, size: (usize, usize)) -> Result<Option<Beneath>> {
        let Self::Pictures(target) = self else { return Ok(None) };
        let path = target.file(number);
        let name = path.display().to_string();
        let picture = codec::read_picture(&disk::read(&path)?, &name, &Limits::default())?;
        if picture.size() != size {
            let ((w, h), (x, y)) = (picture.size(), size);
            let why =
                format!("is {w} x {h} pixels and the lines are {x} x {y}; give --size {w}x{h}");
            return Err(Error::input(name, "", why));
        }
        Ok(Some(Beneath::of(&picture)))
    }
}

/// A picture, sRGB-encoded, opacity apart.
pub(crate) type Plate = Plane<[f32; 4]>;

/// What lies under the lines of a frame.
#[derive(Clone, Debug)]
pub(crate) enum Beneath {
    /// Pixels.
    Pixels(Plate),
    /// Layers of a drawing.
    Layers(Vec<Layer>),
}

impl Beneath {
    pub(crate) fn of(picture: &Plane<[u8; 4]>) -> Self {
        Self::Pixels(picture.map(|p| p.map(|v| f32::from(v) / 255.0)))
    }
}

/// The binary shading under the lines of a job: same scene, same view.
pub(super) struct Regions<'a> {
    look: binary::Look<'a>,
    shot: binary::Shot<'a>,
    vectors: bool,
}

impl<'a> Regions<'a> {
    /// Surveys the shot; `vectors` says whether regions are wanted as outlines.
    pub(super) fn survey(
        project: &'a Project,
        (style, knobs): (&'a Style, &'a BinaryKnobs),
        (colours, print): (Colours, Print),
        vectors: bool,
        run: &Run,
    ) -> Result<Self> {
        let look = binary::Look { style, knobs, colours, print, painting: None, stencil: None };
        Ok(Self { look, shot: binary::Shot::survey(project, knobs, run)?, vectors })
    }

    /// What decides the regions, for recipes.
    pub(super) fn settings(&self) -> Map<String, Value> {
        let mut s = self.shot.view_settings();
        s.extend(self.look.settings(&self.shot.exposure, Encoding::Png));
        s
    }

    /// Draws the frames `numbers` one after the other.
    pub(super) fn shoot(
        &self,
        numbers: &[u32],
        deliver: &mut dyn FnMut(u32, Beneath) -> Result<()>,
        run: &Run,
    ) -> Result<Map<String, Value>> {
        let colours = &self.look.colours;
        let mut hand_over =
            |number: u32, picture: binary::Picture| deliver(number, self.beneath(&picture)?);
        binary::shoot(&self.shot, colours, numbers, &mut hand_over, run)
    }

    fn beneath(&self, picture: &binary::Picture) -> Result<Beneath> {
        let (colours, print) = (&self.look.colours, &self.look.print);
        if !self.vectors {
            return Ok(Beneath::of(&picture.coloured(colours)));
        }
        let two = [colours.ink, colours.paper];
        let place = print.sheet.place(picture.covered.size())?;
        let plate = binary::plate(picture, &two, colours);
        Ok(Beneath::Layers(layers(&plate, self.look.knobs, print.pen, &place).0))
    }
}

impl Over {
    /// For recipes: not where pictures lie, but what they are.
    pub(super) fn settings(&self, number: u32) -> Value {
        match self {
            Self::Nothing => json!("nothing"),
            Self::Binary => json!("binary"),
            Self::Light => json!("light"),
            Self::Pictures(target) => {
                let hash = |bytes: Vec<u8>| crate::write::sha256(&bytes);
                json!({ "picture_sha256": disk::read(&target.file(number)).ok().map(hash) })
            }
        }
    }
}
