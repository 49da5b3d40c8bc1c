//! Whether the controls of a run scored what they must; one that did not, or is not there, voids the run.

use crate::measure::controls::Control;
use crate::results::{Classes, Judgement, Record, Row, TraceRecord, TrueCounts, ViewpointRecord};
use crate::studies::tune::Tuning;

/// What the controls say of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// All stand beside every configuration and scored what they must.
    Sound,
    /// Those that did not, or are missing, as "name on rays of scene".
    Void(Vec<String>),
}

impl Verdict {
    /// In words.
    pub(super) fn sentence(&self) -> String {
        match self {
            Self::Sound => "all score what they must".to_owned(),
            Self::Void(failed) => format!("**the record is invalid**: {}", failed.join("; ")),
        }
    }
}

/// Looks for every control beside everything that was traced, by the rule that every interleaved set holds them to.
pub(super) fn controls(record: &Record) -> Verdict {
    let mut failed: Vec<String> = Vec::new();
    for (config, trace) in record.rows.iter().flat_map(|one| one.traces.iter().map(move |trace| (one, trace))) {
        for control in asked(&record.control_names) {
            if let Some(problem) = problem(record, control, config, trace) {
                let name = control.description().name;
                let sentence = format!("{name} {problem} on {} of {}", trace.rays, config.scene.name);
                if !failed.contains(&sentence) {
                    failed.push(sentence);
                }
            }
        }
    }
    if failed.is_empty() { Verdict::Sound } else { Verdict::Void(failed) }
}

/// The controls of a record: those of before a control was there do without it.
fn asked(names: &[String]) -> impl Iterator<Item = Control> {
    Control::ALL.into_iter().filter(move |control| names.iter().any(|name| name == control.description().name))
}

/// What is wrong with a control beside a configuration's trace.
fn problem(record: &Record, control: Control, config: &Row, trace: &TraceRecord) -> Option<&'static str> {
    // Frame and faces shape structures, not rays; controls have none.
    let pose = |view: &ViewpointRecord| ViewpointRecord { frame: [0; 2], face: 0, ..view.clone() };
    let beside = |one: &&Row| one.scene == config.scene && pose(&one.viewpoint) == pose(&config.viewpoint);
    let rays = (trace.rays.as_str(), trace.rays_sha256.as_str(), trace.count);
    problem_on(record.controls.iter().filter(beside), control, rays, &trace.judgement)
}

/// What is wrong with a control on rays (name, hash, number) beside a configuration's judgement.
fn problem_on<'a>(
    rows: impl Iterator<Item = &'a Row>,
    control: Control,
    rays: (&str, &str, u64),
    judgement: &Judgement,
) -> Option<&'static str> {
    let found = rows
        .filter(|one| one.tracer.name == control.description().name)
        .flat_map(|one| &one.traces)
        .find(|one| (one.rays.as_str(), one.rays_sha256.as_str(), one.count) == rays);
    let Some(found) = found else { return Some("is missing") };
    control.check(&found.judgement, &true_counts(judgement)).err().map(|_| "fails")
}

/// Looks for every control beside every ray set of a tuning, by the same rule.
pub(super) fn tuning_controls(tuning: &Tuning) -> Verdict {
    let mut failed = Vec::new();
    for (scene, view) in tuning.scenes.iter().flat_map(|scene| scene.views.iter().map(move |view| (scene, view))) {
        for set in &view.sets {
            let Some(judged) = set.values.iter().find_map(|each| each.judged.as_ref()) else { continue };
            for control in asked(&tuning.control_names) {
                let rays = (set.rays.as_str(), set.rays_sha256.as_str(), set.count);
                if let Some(problem) = problem_on(view.controls.iter(), control, rays, &judged.judgement) {
                    let (name, place) = (control.description().name, &view.viewpoint.name);
                    failed.push(format!("{name} {problem} on {} of {}, viewpoint {place}", set.rays, scene.scene.name));
                }
            }
        }
    }
    if failed.is_empty() { Verdict::Sound } else { Verdict::Void(failed) }
}

/// What the truth says of the rays, whoever traced them; where ambiguous rays are left out, by the classes of the others.
fn true_counts(judgement: &Judgement) -> TrueCounts {
    let of = |hits, misses| TrueCounts { hits, misses, ..TrueCounts::default() };
    match judgement {
        Judgement::Closest(judgement) => {
            let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = judgement.classes.tight;
            let by_class = || of(true_hit + false_miss + early + late, true_miss + false_hit);
            judgement.truth.clone().unwrap_or_else(by_class)
        }
        Judgement::Any(judgement) => {
            let table = &judgement.occlusion;
            of(table.true_occluded + table.false_free, table.true_free + table.false_occluded)
        }
    }
}
