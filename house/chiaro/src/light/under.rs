//! [`Under`]: lit pictures under something else that is drawn of the same scene and view.

use super::job::{Check, Job, Method};
use super::shot::Shot;
use crate::film::Target;
use crate::project::Project;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_pbgi::LightKnobs;
use serde_json::{Map, Value};

/// A surveyed shot that answers with one lit picture after the other.
pub(crate) struct Under<'a> {
    job: Job<'a>,
    shot: Shot<'a>,
}

impl<'a> Under<'a> {
    /// Surveys a project's shot. `backdrop` stands behind the scene; without it, its sky does.
    pub(crate) fn survey(
        project: &'a Project,
        knobs: &'a LightKnobs,
        backdrop: Option<[f32; 4]>,
        run: &Run,
    ) -> Result<Self> {
        let job = Job {
            project,
            knobs,
            method: Method::default(),
            env: None,
            check: Check::default(),
            bake: None,
            tree: None,
            book: None,
            memory: None,
            backdrop,
            target: Target::Single("under.png".into()),
        };
        Ok(Self { shot: Shot::survey(project, knobs, None, run)?, job })
    }

    /// What decides the pictures, for recipes.
    pub(crate) fn settings(&self) -> Map<String, Value> {
        self.job.settings(&self.shot)
    }

    /// The picture of a frame, sRGB-encoded.
    pub(crate) fn picture(&self, number: u32, run: &Run) -> Result<Plane<[u8; 4]>> {
        let project = self.job.project;
        let frame = project.pose(&project.poser(), number, run);
        let (layers, _) = self.job.frame(&self.shot, &frame, number, run)?;
        let pixels = layers.seen.len() as u64;
        Ok(run.stage("tone", pixels, || layers.displayed(self.job.knobs.tone, self.job.backdrop())))
    }
}
