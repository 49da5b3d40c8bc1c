//! A paper's tables and figures as experiments: what is run, as data, and what its page shows of it.

use tracebench_api::{Parameters, Preset, TraceTo};

use super::page::Page;
use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::rays::{MAX_RAYS, ray_parameters};
use crate::registry;
use crate::report::chart::series::SeriesChart;
use crate::report::document::Document;
use crate::results::SceneRecord;

/// A paper's table or figure, measured here.
#[derive(Debug)]
pub struct Experiment {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Published tables that it stands beside, by id.
    pub published: &'static [&'static str],
    /// Scenes of the catalogue where nothing else is said, and what they stand for.
    pub scenes: &'static [StandIn],
    /// Ray sets where nothing else is said, as `--rays` takes them; none for an experiment without traces.
    pub rays: &'static str,
    /// Parameters of ray sets where nothing else is said, as `--set` takes them.
    pub settings: &'static [&'static str],
    /// How far traces go at least.
    pub trace_to: TraceTo,
    /// What is run one after the other.
    pub steps: &'static [Step],
    /// Whether rows stand at every choice of launch settings, how a search reads and is launched, that their tracer has: where traces of
    /// methods are compared.
    pub launch: bool,
    /// What the page shows of it before its rows.
    pub(crate) sections: &'static [Section],
    /// The charts of the page.
    pub(crate) charts: &'static [Charts],
    /// Deviations and what is to be known.
    pub notes: &'static [&'static str],
}

/// Makes a section of a page, in Markdown.
pub(crate) type Section = fn(&Page<'_>) -> Document;

/// Makes charts of a page.
pub(crate) type Charts = fn(&Page<'_>) -> Vec<SeriesChart>;

/// A scene of the catalogue in place of a paper's.
#[derive(Debug, PartialEq, Eq)]
pub struct StandIn {
    /// The scene of the catalogue.
    pub scene: &'static str,
    /// The paper's scene, as its tables name it.
    pub published: &'static str,
}

/// Configurations side by side at one resolution.
#[derive(Debug, PartialEq)]
pub struct Step {
    /// Factor on the edges of ray image, frame and faces.
    pub resolution: f64,
    /// Factor on the edges of the faces on top of it.
    pub faces: f64,
    /// Time of the animation where nothing else is said, seconds.
    pub time_s: f64,
    /// Factor on the triangles of procedural scenes.
    pub scale: f64,
    /// Parameters of ray sets that the step is about, with their values.
    pub rays: &'static [(&'static str, &'static str)],
    /// Who runs.
    pub rows: &'static [ExperimentRow],
}

/// How searches read and are launched, of tracers that have the choice: parameters with the values that tables show.
pub(super) const MEANS: [(&str, &[&str]); 2] =
    [("memory_access", &["buffer", "texture"]), ("rays_per_lane", &["1", "32"])];

/// A tracer with every combination of values of its parameters.
#[derive(Debug, PartialEq)]
pub struct ExperimentRow {
    /// The tracer.
    pub tracer: &'static str,
    /// Parameters with their values.
    pub values: Values,
}

/// The part of a paper's experiments that shows them within minutes.
#[derive(Debug)]
pub struct Part {
    /// Ray sets that are traced where an experiment has them.
    pub rays: &'static [&'static str],
    /// Which steps are taken.
    pub step: fn(&Step) -> bool,
    /// Which rows are taken of an experiment.
    pub row: fn(&Experiment, &TracerRequest) -> bool,
}

/// Values of parameters of a row.
pub(super) type Values = &'static [(&'static str, &'static [&'static str])];

pub(super) const fn stands_for(scene: &'static str, published: &'static str) -> StandIn {
    StandIn { scene, published }
}

/// A step at a factor on every resolution.
pub(super) const fn at(resolution: f64, rows: &'static [ExperimentRow]) -> Step {
    Step { resolution, faces: 1.0, time_s: 0.0, scale: 1.0, rays: &[], rows }
}

/// One step, at every resolution as it is.
pub(super) const fn once(rows: &'static [ExperimentRow]) -> [Step; 1] {
    [at(1.0, rows)]
}

/// A step at a time of the animation.
pub(super) const fn at_time(time_s: f64, rows: &'static [ExperimentRow]) -> Step {
    Step { time_s, ..at(1.0, rows) }
}

/// A step at a factor on the triangles of procedural scenes.
pub(super) const fn at_scale(scale: f64, rows: &'static [ExperimentRow]) -> Step {
    Step { scale, ..at(1.0, rows) }
}

/// A step of rays by values of their own.
pub(super) const fn of_rays(rays: &'static [(&'static str, &'static str)], rows: &'static [ExperimentRow]) -> Step {
    Step { rays, ..at(1.0, rows) }
}

/// A tracer as published.
pub(super) const fn peer(tracer: &'static str) -> ExperimentRow {
    ExperimentRow { tracer, values: &[] }
}

/// Why an experiment cannot be run as asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rays} rays at {factor} times the resolution, {MAX_RAYS} are the most: turn down --size or --preset")]
pub struct TooManyRays {
    rays: u64,
    factor: String,
}

impl Experiment {
    /// An experiment of hits without traces, of which nothing more is said.
    pub(super) const DEFAULT: Self = Self {
        name: "",
        summary: "",
        published: &[],
        scenes: &[],
        rays: "",
        settings: &[],
        trace_to: TraceTo::Hit,
        steps: &[],
        launch: false,
        sections: &[],
        charts: &[],
        notes: &[],
    };

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
            let tracers = tracers.clone();
            Ok(Plan { preset, trace_to, time_s, tracers, ray_parameters, table: Some(self.name), ..base.clone() })
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
        self.steps.iter().flat_map(|step| step.rows).any(|row| row.tracer == tracer)
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
    /// With every combination of its values, and of those of launch settings that its tracer has.
    fn requests(&self, launch: &[(&str, &[&str])]) -> Vec<TracerRequest> {
        let Some(registration) = registry::find(self.tracer) else { return Vec::new() };
        let known = registration.describe().parameters;
        let launch = launch.iter().filter(|(name, _)| known.iter().any(|parameter| parameter.name == *name));
        let mut requests = vec![TracerRequest::of(registration, Preset::Published)];
        for (parameter, values) in self.values.iter().chain(launch) {
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
