//! A run's rows as quantities look at them: by scene, by parameters, by resolution.

use std::collections::{BTreeMap, BTreeSet};

use itertools::Itertools as _;
use serde_json::{Value, json};

use super::experiment::Experiment;
use crate::results::{Judgement, Record, Row, Skipped, TraceRecord, same_pose};

/// A run by scene.
pub struct Rows<'a> {
    /// The run.
    pub record: &'a Record,
    /// Its scenes, in order of first appearance.
    pub scenes: Vec<SceneRows<'a>>,
}

/// What was measured of one scene from one viewpoint, at every resolution and of all rays.
#[derive(Clone)]
pub struct SceneRows<'a> {
    /// The run that it is of.
    pub record: &'a Record,
    /// The scene's name, with the viewpoint's where the scene stands there twice.
    pub label: String,
    /// Its configurations.
    pub rows: Vec<&'a Row>,
    /// What could not be run there.
    pub skipped: Vec<&'a Skipped>,
}

impl<'a> Rows<'a> {
    /// Sorts a run by scene and viewpoint.
    pub fn of(record: &'a Record) -> Self {
        let mut scenes: Vec<SceneRows<'a>> = Vec::new();
        for one in &record.rows {
            match scenes.iter_mut().find(|scene| same_pose(scene.rows[0], one)) {
                Some(scene) => scene.rows.push(one),
                None => {
                    let skipped = record.skipped.iter().filter(|skipped| skipped.scene == one.scene.name).collect();
                    scenes.push(SceneRows { record, label: one.scene.name.clone(), rows: vec![one], skipped });
                }
            }
        }
        let first: Vec<&Row> = scenes.iter().map(|scene| scene.rows[0]).collect();
        for scene in &mut scenes {
            let (own, label) = (scene.rows[0], &scene.label);
            let same_name = || first.iter().filter(|other| other.scene.name == *label);
            let other_scale = same_name().any(|other| other.scene.scale != own.scene.scale);
            if let Some(scale) = own.scene.scale.filter(|_| other_scale) {
                scene.label = format!("{label} at scale {scale}");
            } else if same_name().any(|other| other.viewpoint.time_s != own.viewpoint.time_s) {
                scene.label = format!("{label} at {} s", own.viewpoint.time_s);
            } else if same_name().count() > 1 {
                scene.label = format!("{label} from {}", own.viewpoint.name);
            }
        }
        Self { record, scenes }
    }

    /// The scenes alone that stand for some of a paper's in an experiment, for any of them where none is named.
    pub(super) fn standing_for(&self, experiment: &Experiment, published: &[String]) -> Self {
        let wanted = |scene: &&SceneRows<'_>| {
            let name = scene.rows.first().and_then(|row| experiment.stands_for(&row.scene));
            name.is_some_and(|name| published.is_empty() || published.iter().any(|each| each == name))
        };
        Self { record: self.record, scenes: self.scenes.iter().filter(wanted).cloned().collect() }
    }

    /// How many scenes there are, whatever the viewpoints and times.
    pub(super) fn names(&self) -> usize {
        self.scenes.iter().map(|scene| &scene.rows[0].scene.name).collect::<BTreeSet<_>>().len()
    }

    /// How many rows there are of an experiment's own, and how many it has over all its scenes.
    pub(super) fn of_all(&self, experiment: &Experiment) -> [usize; 2] {
        let own = self.standing_for(experiment, &[]).scenes.iter().map(|scene| scene.rows.len()).sum();
        [own, experiment.scenes.len() * experiment.requests().iter().map(Vec::len).sum::<usize>()]
    }
}

/// Whether a run has a value of a parameter, given as the command line takes it.
pub(crate) fn has(row: &Row, parameter: &str, value: &str) -> bool {
    row.tracer.parameters.get(parameter).is_some_and(|found| is(found, value))
}

/// Whether a value is what is given as the command line takes it.
fn is(found: &Value, value: &str) -> bool {
    match found {
        Value::String(text) => text == value,
        Value::Number(number) => value.parse::<f64>().is_ok_and(|value| number.as_f64() == Some(value)),
        other => value.parse::<Value>().is_ok_and(|value| value == *other),
    }
}

/// A parameter's number.
pub(crate) fn parameter(row: &Row, name: &str) -> Option<f64> {
    match row.tracer.parameters.get(name)? {
        Value::String(text) => text.parse().ok(),
        other => other.as_f64(),
    }
}

impl<'a> SceneRows<'a> {
    /// The runs of a tracer.
    pub fn of_tracer(&self, tracer: &str) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(move |row| row.tracer.name == tracer).copied()
    }

    /// The first run of a tracer and those at its resolution and of its rays that differ from it in these parameters at most. So rows are
    /// distinguished by what the experiment varies, whatever else is set for all of them.
    pub fn differing_in(&self, tracer: &str, parameters: &[&str]) -> impl Iterator<Item = &'a Row> {
        let first = self.of_tracer(tracer).next();
        let alike = move |row: &&Row, first: &Row| {
            place(row) == place(first)
                && row.tracer.parameters.iter().all(|(name, value)| {
                    parameters.contains(&name.as_str()) || first.tracer.parameters.get(name) == Some(value)
                })
        };
        self.of_tracer(tracer).filter(move |row| first.is_some_and(|first| alike(row, first)))
    }

    /// Names of the ray sets, in order of first appearance.
    pub fn ray_sets(&self) -> Vec<&'a str> {
        self.rows.iter().flat_map(|row| &row.traces).map(|trace| trace.rays.as_str()).unique().collect()
    }

    /// The runs by resolution, of the ray image, from the lowest, then of the views, and of each by what was said of their rays.
    pub fn by_resolution(&self) -> Vec<SceneRows<'a>> {
        let places = self.rows.iter().map(|row| place(row)).unique().sorted_by_key(|(resolution, _)| *resolution);
        places.map(|wanted| self.only(|row| place(row) == wanted)).collect()
    }

    /// The runs alone of whose ray sets this was said.
    pub fn of_rays(&self, said: &[(&str, &str)]) -> SceneRows<'a> {
        self.only(|row| {
            said.iter().all(|(name, value)| {
                let own = row.viewpoint.ray_parameters.get(*name).or_else(|| self.record.ray_parameters.get(*name));
                own.is_some_and(|own| is(own, value))
            })
        })
    }

    fn only(&self, wanted: impl Fn(&Row) -> bool) -> SceneRows<'a> {
        SceneRows {
            record: self.record,
            label: self.label.clone(),
            rows: self.rows.iter().filter(|row| wanted(row)).copied().collect(),
            skipped: self.skipped.clone(),
        }
    }
}

/// Where a row stands among those of its scene: pixels of ray image, frame and a face, and what was said about its ray sets.
fn place(row: &Row) -> ([u64; 3], &BTreeMap<String, Value>) {
    let viewpoint = &row.viewpoint;
    let sizes = [viewpoint.ray_image, viewpoint.frame, [viewpoint.face; 2]];
    (sizes.map(|size| size.map(u64::from).iter().product()), &viewpoint.ray_parameters)
}

/// A tracer's trace of a ray set.
pub(crate) fn trace<'a>(row: &'a Row, rays: &str) -> Option<&'a TraceRecord> {
    row.traces.iter().find(|trace| trace.rays == rays)
}

/// What a structure says of itself.
pub(crate) fn statistic(row: &Row, name: &str) -> Option<f64> {
    row.structure_statistics.get(name).copied()
}

/// How often a set is right: by a rule, of any-hit sets `balanced`.
pub(super) fn right(trace: &TraceRecord, rule: &str) -> Option<f64> {
    match &trace.judgement {
        Judgement::Any(any) => any.occlusion.balanced_accuracy.filter(|_| rule == "balanced"),
        Judgement::Closest(closest) => json!(closest.agreement)[rule].as_f64(),
    }
}

/// The share of a row's rays that it answers as the first row of its tracer does, of the ray set with the least.
pub(super) fn answered_as_first(row: &Row) -> Option<f64> {
    let share = |trace: &TraceRecord| Some(trace.same_as_first? as f64 / trace.count as f64);
    row.traces.iter().map(share).collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::min)
}

/// The share of the ray sets of two rows that have the same hits in both.
pub(super) fn same_hits(one: &Row, other: &Row) -> Option<f64> {
    let pairs = one.traces.iter().filter_map(|own| {
        let same = trace(other, &own.rays).filter(|each| each.rays_sha256 == own.rays_sha256)?;
        Some(same.hits_sha256 == own.hits_sha256)
    });
    let same: Vec<bool> = pairs.collect();
    (!same.is_empty()).then(|| same.iter().filter(|same| **same).count() as f64 / same.len() as f64)
}
