//! A paper's tables and figures as experiments: what is run, as data, and what its page shows of it.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use tracebench_api::{Parameters, Preset, TraceTo};

use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::rays::{MAX_RAYS, ray_parameters};
use crate::registry;
use crate::results::SceneRecord;
use crate::studies::frames::FramesRequest;

/// A paper's table or figure, measured here: an entry of its `experiments.json`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Published tables that it stands beside, by id.
    #[serde(default)]
    pub published: Vec<&'static str>,
    /// Scenes of the catalogue where nothing else is said, and what they stand for.
    pub scenes: Vec<StandIn>,
    /// Ray sets where nothing else is said, as `--rays` takes them; none for an experiment without traces.
    #[serde(default)]
    pub rays: &'static str,
    /// Parameters of ray sets where nothing else is said, as `--set` takes them.
    #[serde(default)]
    pub settings: Vec<&'static str>,
    /// How far traces go at least.
    #[serde(default)]
    pub trace_to: TraceTo,
    /// Whether it is about traces alone: its builds are not timed.
    #[serde(default)]
    pub traces_alone: bool,
    /// What is asked where it is frames of a moving scene, of effects or of its ray sets, of one step.
    pub frames: Option<FramesRequest>,
    /// What is run one after the other.
    pub steps: Vec<Step>,
    /// Whether rows stand at every choice of launch settings, how a search reads and is launched, that their tracer has: where traces of
    /// methods are compared.
    #[serde(default)]
    pub launch: bool,
    /// The rows that show it within minutes, those that have such values: `named` is of parameters that the row itself names. All where
    /// none is said.
    pub(super) few_rows: Option<Vec<ExperimentRow>>,
    /// What the page shows of it before its rows: tables of its paper by name, `beside TRACER`, or `by part`.
    #[serde(default)]
    pub(super) sections: Vec<&'static str>,
    /// The charts of the page, by name.
    #[serde(default)]
    pub(super) charts: Vec<&'static str>,
    /// Deviations and what is to be known.
    #[serde(default)]
    pub notes: Vec<&'static str>,
}

/// A scene of the catalogue in place of a paper's.
#[derive(Debug, PartialEq, Eq, Deserialize)]
pub struct StandIn {
    /// The scene of the catalogue.
    pub scene: &'static str,
    /// The paper's scene, as its tables name it.
    pub published: &'static str,
}

/// Configurations side by side at one resolution.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Factor on the edges of ray image, frame and faces.
    #[serde(default = "one")]
    pub resolution: f64,
    /// Factor on the edges of the faces on top of it.
    #[serde(default = "one")]
    pub faces: f64,
    /// Time of the animation where nothing else is said, seconds.
    #[serde(default)]
    pub time_s: f64,
    /// Factor on the triangles of procedural scenes.
    #[serde(default = "one")]
    pub scale: f64,
    /// Parameters of ray sets that the step is about, with their values.
    #[serde(default, borrow)]
    pub rays: Vec<(&'static str, &'static str)>,
    /// Whether what shows the experiment within minutes does without it.
    #[serde(default)]
    pub left_out_of_few: bool,
    /// Who runs.
    pub rows: Vec<ExperimentRow>,
}

fn one() -> f64 {
    1.0
}

/// How searches read and are launched, of tracers that have the choice: parameters with the values that tables show.
pub(super) const MEANS: [(&str, &[&str]); 2] =
    [("memory_access", &["buffer", "texture"]), ("rays_per_lane", &["1", "32"])];

/// A tracer with every combination of values of its parameters.
#[derive(Debug, PartialEq)]
pub struct ExperimentRow {
    /// The tracer.
    pub tracer: &'static str,
    /// From which preset.
    pub preset: Preset,
    /// Parameters with their values.
    pub values: Vec<(&'static str, Vec<&'static str>)>,
}

impl Deserialize<'static> for ExperimentRow {
    /// In one line: `dirt tile_size=1,2 buckets=24`, `dirt:improved`.
    fn deserialize<D: Deserializer<'static>>(deserializer: D) -> Result<Self, D::Error> {
        let line = <&'static str>::deserialize(deserializer)?;
        let (head, rest) = line.split_once(' ').unwrap_or((line, ""));
        let (tracer, preset) = head.split_once(':').unwrap_or((head, Preset::Published.name()));
        let preset = Preset::ALL.into_iter().find(|each| each.name() == preset);
        let with_values =
            |word: &'static str| Some((word.split_once('=')?.0, word.split_once('=')?.1.split(',').collect()));
        let values = rest.split_whitespace().map(with_values).collect::<Option<_>>();
        let row = preset.zip(values).map(|(preset, values)| Self { tracer, preset, values });
        row.ok_or_else(|| D::Error::custom(format!("`{line}` is not `TRACER[:PRESET] PARAMETER=VALUE,VALUE ...`")))
    }
}

/// Why an experiment cannot be run as asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rays} rays at {factor} times the resolution, {MAX_RAYS} are the most: turn down --size or --preset")]
pub struct TooManyRays {
    rays: u64,
    factor: String,
}

impl Experiment {
    /// The tracers of each step; a value in the published preset counts as named all the same, so that labels tell it.
    pub fn requests(&self) -> Vec<Vec<TracerRequest>> {
        let launch = if self.launch { &MEANS[..] } else { &[] };
        self.steps.iter().map(|step| step.rows.iter().flat_map(|row| row.requests(launch)).collect()).collect()
    }

    /// What is to be run: the base plan at the resolution, time, scale and rays of every step, with its tracers.
    ///
    /// # Errors
    /// If a step has more rays than one set may have.
    pub fn plans(&self, base: &Plan, steps: &[Vec<TracerRequest>]) -> Result<Vec<Plan>, TooManyRays> {
        let plan = |(step, tracers): (&Step, &Vec<TracerRequest>)| {
            let preset = step.scaled(base.preset);
            let rays = preset.ray_image.map(u64::from).iter().product();
            if rays > MAX_RAYS {
                return Err(TooManyRays { rays, factor: step.resolution.to_string() });
            }
            let trace_to = if base.trace_to == TraceTo::Surface { base.trace_to } else { self.trace_to };
            let time_s = if base.time_s == 0.0 { step.time_s } else { base.time_s };
            let ray_parameters = step.ray_parameters(&base.ray_parameters);
            let (tracers, builds_timed, table) = (tracers.clone(), !self.traces_alone, Some(self.name));
            Ok(Plan { preset, trace_to, builds_timed, time_s, tracers, ray_parameters, table, ..base.clone() })
        };
        self.steps.iter().zip(steps).map(plan).collect()
    }

    /// The paper's scene that a scene stands for: one of the catalogue does at its own scale and at those that steps are about, a file
    /// of the same name does not.
    pub fn stands_for(&self, scene: &SceneRecord) -> Option<&'static str> {
        let whole = self.steps.iter().any(|step| scene.scale == Some(step.scale));
        self.scenes.iter().find(|each| whole && each.scene == scene.name).map(|each| each.published)
    }

    /// Whether a tracer of this name belongs into the table.
    pub fn holds(&self, tracer: &str) -> bool {
        self.steps.iter().flat_map(|step| &step.rows).any(|row| row.tracer == tracer)
    }
}

impl Step {
    fn scaled(&self, preset: RunPreset) -> RunPreset {
        let scaled = |pixels: u32, factor: f64| ((f64::from(pixels) * factor).round() as u32).max(1);
        let edge = |pixels: u32| scaled(pixels, self.resolution);
        RunPreset {
            ray_image: preset.ray_image.map(edge),
            frame: preset.frame.map(edge),
            face: scaled(preset.face, self.resolution * self.faces),
            scene_scale: preset.scene_scale * self.scale,
            ..preset
        }
    }

    /// The base's, but for what the step is about.
    fn ray_parameters(&self, base: &Parameters) -> Parameters {
        let known = ray_parameters();
        self.rays.iter().fold(base.clone(), |values, (name, value)| {
            let mut with = values.clone();
            // A test holds every value against its parameter's range.
            if with.set(&known, name, value).is_ok() { with } else { values }
        })
    }
}

impl ExperimentRow {
    /// Whether a request of a table is one of these, of either preset.
    pub(super) fn takes(&self, request: &TracerRequest) -> bool {
        let is = |(name, values): &(&str, Vec<&str>)| match *name {
            "named" => values.iter().all(|value| request.changed.iter().any(|changed| changed == value)),
            name => request.parameters.value(name).is_some_and(|own| values.contains(&&*own.to_string())),
        };
        request.name() == self.tracer && self.values.iter().all(is)
    }

    /// With every combination of its values, and of those of launch settings that its tracer has.
    fn requests(&self, launch: &[(&str, &[&str])]) -> Vec<TracerRequest> {
        let Some(registration) = registry::find(self.tracer) else { return Vec::new() };
        let known = registration.describe().parameters;
        let launch = launch.iter().filter(|(name, _)| known.iter().any(|parameter| parameter.name == *name));
        let mut requests = vec![TracerRequest::of(registration, self.preset)];
        let own = self.values.iter().map(|(name, values)| (*name, &values[..]));
        for (parameter, values) in own.chain(launch.copied()) {
            let with = |request: &TracerRequest, value: &str| {
                let mut request = request.clone();
                // A test holds every value against its parameter's range.
                request.set(parameter, value).is_ok().then_some(request)
            };
            requests =
                requests.iter().flat_map(|request| values.iter().filter_map(|each| with(request, each))).collect();
        }
        requests
    }
}
