//! The papers' tables and figures as experiments: what is run, as data.

mod dirt;
mod vvp16;

use tracebench_api::{EndPoint, Preset};

use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::rays::MOST_RAYS;
use crate::registry;

/// A paper's table or figure, measured here.
#[derive(Debug, PartialEq)]
pub struct Experiment {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// The paper's short name.
    pub paper: &'static str,
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
    pub end: EndPoint,
    /// What is run one after the other.
    pub steps: &'static [Step],
    /// What the page shows of it beside rows and claims.
    pub shown: &'static [Shown],
    /// Deviations and what is to be known.
    pub notes: &'static [&'static str],
}

/// A section of a page, or a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Rays a second, a row a scene and a column a kind, beside the published ones, as ratios to the last kind.
    Throughput,
    /// Bytes by the formula of DIRT's Table 3 beside the ledger's.
    Formula,
    /// Build and traces of mixes of rays over resolution; a chart.
    Mixes,
    /// Memory, build, trace and tests over B by tile size; a chart.
    OverBuckets,
    /// Memory over resolution, a line a tracer and scene; a chart.
    MemoryOverResolution,
    /// Layers, views, efficiency and times of one and two bounces, as VVP16's Table 1 has them.
    Bounces,
    /// Bytes by the formula of VVP16's Table 2 beside the ledger's.
    AbufferFormula,
    /// Build and trace beside those of every other tracer, as ratios.
    Peers,
    /// Traces of storages, plain, decoupled and with skipping; a chart.
    Variants,
    /// Times and lost rays over views and layers, as ratios to the first row.
    ViewsAndLayers,
}

/// A scene of the catalogue in place of a paper's.
#[derive(Debug, PartialEq, Eq)]
pub struct StandIn {
    /// The scene of the catalogue.
    pub scene: &'static str,
    /// The paper's scene, as its tables name it.
    pub published: &'static str,
}

/// Contenders side by side at one resolution.
#[derive(Debug, PartialEq)]
pub struct Step {
    /// Factor on the edges of ray image, frame and faces.
    pub resolution: f64,
    /// Factor on the edges of the faces on top of it.
    pub faces: f64,
    /// Who runs.
    pub rows: &'static [Row],
}

/// A tracer with every combination of values of its parameters.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// The tracer.
    pub tracer: &'static str,
    /// Parameters with their values.
    pub values: Values,
}

const fn stands_for(scene: &'static str, published: &'static str) -> StandIn {
    StandIn { scene, published }
}

/// A step at a factor on every resolution.
const fn at(resolution: f64, rows: &'static [Row]) -> Step {
    Step { resolution, faces: 1.0, rows }
}

/// Values of parameters of a row.
type Values = &'static [(&'static str, &'static [&'static str])];

const fn dirt(values: Values) -> Row {
    Row { tracer: "dirt", values }
}

/// VVP16's tracer.
const fn abuffer(values: Values) -> Row {
    Row { tracer: "fragment-abuffer", values }
}

/// A tracer as published.
const fn peer(tracer: &'static str) -> Row {
    Row { tracer, values: &[] }
}

/// Every experiment.
pub const EXPERIMENTS: &[Experiment] = &[
    dirt::TABLE1,
    dirt::TABLE2,
    dirt::TABLE3,
    dirt::FIGURE8,
    dirt::FIGURE9,
    dirt::FIGURE10,
    dirt::FIGURE11,
    dirt::TEXT,
    vvp16::TABLE1,
    vvp16::TABLE2,
    vvp16::FIGURE11,
    vvp16::FIGURE12,
    vvp16::VIEWS,
];

/// Finds an experiment by name.
pub fn find(name: &str) -> Option<&'static Experiment> {
    EXPERIMENTS.iter().find(|experiment| experiment.name == name)
}

/// Why an experiment cannot be run as asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rays} rays at {factor} times the resolution, {MOST_RAYS} are the most: turn down --size or --preset")]
pub struct TooManyRays {
    rays: u64,
    factor: String,
}

impl Experiment {
    /// The tracers of each step; a value in the published preset counts as named all the same, so that labels tell it.
    pub fn requests(&self) -> Vec<Vec<TracerRequest>> {
        self.steps.iter().map(|step| step.rows.iter().flat_map(Row::requests).collect()).collect()
    }

    /// What is to be run: the base plan at the resolution of every step, with its tracers.
    ///
    /// # Errors
    /// If a step has more rays than one set may have.
    pub fn plans(&self, base: &Plan, steps: &[Vec<TracerRequest>]) -> Result<Vec<Plan>, TooManyRays> {
        let plan = |(step, tracers): (&Step, &Vec<TracerRequest>)| {
            let preset = step.scaled(base.preset);
            let rays = preset.ray_image.map(u64::from).iter().product();
            if rays > MOST_RAYS {
                return Err(TooManyRays { rays, factor: step.resolution.to_string() });
            }
            let end = if base.end == EndPoint::Surface { base.end } else { self.end };
            Ok(Plan { preset, end, tracers: tracers.clone(), table: Some(self.name), ..base.clone() })
        };
        self.steps.iter().zip(steps).map(plan).collect()
    }

    /// The paper's scene that a scene stands for.
    pub fn stands_for(&self, scene: &str) -> Option<&'static str> {
        self.scenes.iter().find(|each| each.scene == scene).map(|each| each.published)
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
            ..preset
        }
    }
}

impl Row {
    fn requests(&self) -> Vec<TracerRequest> {
        let Some(registration) = registry::find(self.tracer) else { return Vec::new() };
        let mut requests = vec![TracerRequest::of(registration, Preset::Published)];
        for (parameter, values) in self.values {
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
