//! The part of a paper's tables and figures that shows them within minutes: `table NAME --few-rows`, and what `reproduce` takes first.

use super::{Experiment, Paper};
use crate::plan::{Plan, RunPreset, SceneSource, TracerRequest};
use crate::results::SampleSchedule;

/// The scene.
const SCENE: &str = "room";
/// Part of the run preset's triangles that the scene has: on a software adapter a draw takes as long as its triangles do.
const SCALE: f64 = 0.125;
/// Samples of every time, at most.
const MAX_SAMPLES: u32 = 3;

/// What random ray sets are told, unless the user says otherwise: rays of sets that start several from a pixel.
pub(crate) const PART_SETTINGS: [&str; 1] = ["rays.pixel_random_count=2"];

impl Paper {
    /// Leaves of an experiment's steps, and of the plan that they are run over, the part: one scene of an eighth of its triangles, half the
    /// resolution, the rays that stand with the paper, the steps and rows that stand with the experiment.
    pub(crate) fn take_part(&self, experiment: &Experiment, base: &mut Plan, steps: &mut [Vec<TracerRequest>]) {
        let half = |edge: u32| edge.div_ceil(2);
        let preset = base.preset;
        base.scenes = vec![SceneSource::Catalogue(SCENE.to_owned())];
        base.ray_sets.retain(|set| self.own.few_rays.contains(&set.name));
        base.preset = RunPreset {
            ray_image: preset.ray_image.map(half),
            frame: preset.frame.map(half),
            face: half(preset.face),
            sampling: SampleSchedule::rounds(preset.sampling.min_rounds.min(MAX_SAMPLES)),
            scene_scale: preset.scene_scale * SCALE,
            ..preset
        };
        for (step, requests) in experiment.steps.iter().zip(steps) {
            let few = experiment.few_rows.as_ref();
            let is_of = |request: &TracerRequest| few.is_none_or(|rows| rows.iter().any(|row| row.takes(request)));
            requests.retain(|request| !step.left_out_of_few && is_of(request));
        }
    }
}
