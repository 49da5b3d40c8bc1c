//! What follows from a tuning's rows: everything that was judged of a tracer over the values of one parameter, from two
//! viewpoints of every scene, and the values that would have been chosen.

use std::collections::BTreeMap;

use tracebench_api::{Query, named};

use super::choice::{accuracy, choose};
use crate::judge::Rule;
use crate::results::{
    AxisRecord, Provenance, Record, Row, SceneRecord, Skipped, SweepRecord, TraceRecord, TracerRecord, TunedScene,
    ViewpointRecord, place_name,
};

/// A parameter of a tracer, tuned.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// Where, by which program and when.
    pub provenance: Provenance,
    /// Names of the controls that stand beside every configuration.
    pub control_names: Vec<String>,
    /// Seed of the ray sets.
    pub seed: u64,
    /// Run preset.
    pub preset: String,
    /// The tracer with its default values.
    pub tracer: TracerRecord,
    /// The parameter; `own` is its default, the value of the tracer's preset.
    pub axis: AxisRecord,
    /// The rule by which values are chosen; of any-hit sets it is balanced accuracy, whatever stands here.
    pub rule: Rule,
    /// The scenes.
    pub scenes: Vec<SceneTuned>,
    /// What did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneTuned {
    /// The scene.
    pub scene: SceneRecord,
    /// The own viewpoint, then another, if there is one.
    pub views: Vec<ViewTuned>,
}

/// One viewpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewTuned {
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// Its ray sets.
    pub sets: Vec<SetTuned>,
    /// The controls on the same rays.
    pub controls: Vec<Row>,
}

/// One ray set: every value traced the same rays.
#[derive(Clone, Debug, PartialEq)]
pub struct SetTuned {
    /// Ray set.
    pub rays: String,
    /// Hash of the rays.
    pub rays_sha256: String,
    /// What was asked.
    pub query: Query,
    /// Number of rays.
    pub count: u64,
    /// The parameter's values, in order.
    pub values: Vec<ValueTuned>,
    /// The values that would have been chosen, each judged on these rays, in the order of [`Label::ALL`].
    pub choices: Vec<Choice>,
}

/// One value of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueTuned {
    /// The value.
    pub value: String,
    /// What was judged; `None` where it could not be measured.
    pub judged: Option<Judged>,
    /// Why it could not.
    pub skipped: Option<String>,
}

/// What a value answered, without the list of wrong rays.
pub type Judged = TraceRecord;

named! {
    /// How a value was come by: which rays have seen it beforehand.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Label {
        /// The value of the tracer's preset: no rays.
        Default = "default",
        /// The best on the judged rays themselves: what no user has.
        TunedHere = "tuned here",
        /// The best from the scene's other viewpoint.
        TunedElsewhere = "tuned elsewhere",
        /// The best on average over the other scenes' own viewpoints.
        TunedOnOtherScenes = "tuned on the other scenes",
    }
}

/// A value that would have been chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// How.
    pub label: Label,
    /// The value; `None` where there was nothing to choose by.
    pub value: Option<String>,
    /// Its share of right answers on these rays by the rule; `None` if it was not measured or every ray is an ambiguous ray.
    pub score: Option<f64>,
    /// What it loses on these rays to the values come by otherwise: their score less its own.
    pub lost_to: BTreeMap<Label, f64>,
}

impl Tuning {
    /// What a record says of a tuning, with the values that would have been chosen; `None` if it is of none.
    pub fn of(record: &Record) -> Option<Self> {
        let (tuning, sweep) = (record.tuning.as_ref()?, record.sweep.as_ref()?);
        let axis = sweep.axes.first()?.clone();
        let mut scenes: Vec<SceneTuned> =
            tuning.scenes.iter().map(|scene| SceneTuned::of(record, sweep, &axis, scene)).collect();
        choose(&mut scenes, &axis.own, tuning.rule);
        Some(Self {
            provenance: record.provenance.clone(),
            control_names: record.control_names.clone(),
            seed: record.seed,
            preset: record.preset.clone(),
            tracer: tuning.tracer.clone(),
            axis,
            rule: tuning.rule,
            scenes,
            skipped: record.skipped.clone(),
        })
    }

    /// The value that a label has for a ray set from a scene's own viewpoint; `None` where there is no such scene or set, or nothing
    /// to choose by.
    pub fn value_from_own_viewpoint(&self, scene: &str, rays: &str, label: Label) -> Option<&str> {
        let own = self.scenes.iter().find(|each| each.scene.name == scene)?.views.first()?;
        own.sets.iter().find(|set| set.rays == rays)?.choice(label)?.value.as_deref()
    }
}

impl SceneTuned {
    fn of(record: &Record, sweep: &SweepRecord, axis: &AxisRecord, tuned: &TunedScene) -> Self {
        let view = |(view, viewpoint): (usize, &ViewpointRecord)| {
            let here = |one: &&Row| one.scene == tuned.scene && one.viewpoint == *viewpoint;
            let rows: Vec<&Row> = record.rows.iter().filter(here).collect();
            let controls: Vec<Row> = record.controls.iter().filter(here).cloned().collect();
            let place = place_name(&tuned.scene, viewpoint, view);
            let value = |value: &String, rays_sha256: &str| {
                let point = sweep.point(&axis.name, value, &[]);
                let found = point.and_then(|point| rows.iter().find(|one| point.is_of(one)));
                let trace = found.and_then(|one| one.traces.iter().find(|trace| trace.rays_sha256 == rays_sha256));
                let skipped = point.and_then(|point| point.skipped.get(&place).cloned());
                let mut judged = trace.cloned();
                judged.iter_mut().for_each(|judged| judged.judgement.wrong_rays_mut().clear());
                ValueTuned { value: value.clone(), judged, skipped }
            };
            let traces = controls.first().or(rows.first().copied()).map_or(&[][..], |first| &first.traces);
            let set = |trace: &TraceRecord| SetTuned {
                rays: trace.rays.clone(),
                rays_sha256: trace.rays_sha256.clone(),
                query: trace.query,
                count: trace.count,
                values: axis.values.iter().map(|each| value(each, &trace.rays_sha256)).collect(),
                choices: Vec::new(),
            };
            ViewTuned { viewpoint: viewpoint.clone(), sets: traces.iter().map(set).collect(), controls }
        };
        Self { scene: tuned.scene.clone(), views: tuned.viewpoints.iter().enumerate().map(view).collect() }
    }
}

impl SetTuned {
    /// What was judged of a value.
    pub fn judged(&self, value: &str) -> Option<&Judged> {
        self.values.iter().find(|each| each.value == value)?.judged.as_ref()
    }

    /// How often a value is right by a rule, if that says anything.
    pub fn score(&self, value: &str, rule: Rule) -> Option<f64> {
        accuracy(&self.judged(value)?.judgement, rule)?.share
    }

    /// The choice of a label.
    pub fn choice(&self, label: Label) -> Option<&Choice> {
        self.choices.iter().find(|choice| choice.label == label)
    }
}
