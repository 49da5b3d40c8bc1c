//! Whether the controls of a run scored what they must; one that did not, or is not there, voids the run.

use itertools::Itertools as _;

use crate::measure::controls::Control;
use crate::results::{Judgement, Record, Row, TraceRecord, TrueCounts, ViewpointRecord};
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
    fn of(failed: impl Iterator<Item = String>) -> Self {
        let failed: Vec<String> = failed.unique().collect();
        if failed.is_empty() { Self::Sound } else { Self::Void(failed) }
    }

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
    // Frame and faces shape structures, not rays; controls have none.
    let pose = |view: &ViewpointRecord| ViewpointRecord { frame: [0; 2], face: 0, ..view.clone() };
    let of_config = |config: &Row| {
        let beside = |one: &&Row| one.scene == config.scene && pose(&one.viewpoint) == pose(&config.viewpoint);
        let rows: Vec<&Row> = record.controls.iter().filter(beside).collect();
        let of_trace = |trace: &TraceRecord| {
            let rays = (trace.rays.as_str(), trace.rays_sha256.as_str(), trace.count);
            problems(&rows, &record.control_names, rays, &trace.judgement)
        };
        let problems = config.traces.iter().flat_map(of_trace);
        problems.map(|problem| format!("{problem} of {}", config.scene.name)).collect::<Vec<_>>()
    };
    Verdict::of(record.rows.iter().flat_map(of_config))
}

/// Looks for every control beside every ray set of a tuning, by the same rule.
pub(super) fn tuning_controls(tuning: &Tuning) -> Verdict {
    let mut failed = Vec::new();
    for (scene, view) in tuning.scenes.iter().flat_map(|scene| scene.views.iter().map(move |view| (scene, view))) {
        let rows: Vec<&Row> = view.controls.iter().collect();
        for set in &view.sets {
            let Some(judged) = set.values.iter().find_map(|each| each.judged.as_ref()) else { continue };
            let rays = (set.rays.as_str(), set.rays_sha256.as_str(), set.count);
            let problems = problems(&rows, &tuning.control_names, rays, &judged.judgement).into_iter();
            let place = format!("of {}, viewpoint {}", scene.scene.name, view.viewpoint.name);
            failed.extend(problems.map(|problem| format!("{problem} {place}")));
        }
    }
    Verdict::of(failed.into_iter())
}

/// What is wrong with the controls of a record on rays (name, hash, number) beside a judgement; records of before a control was there do
/// without it.
fn problems(rows: &[&Row], names: &[String], rays: (&str, &str, u64), judgement: &Judgement) -> Vec<String> {
    let problem = |control: &Control| {
        let name = control.description().name;
        let traces = rows.iter().filter(|one| one.tracer.name == name).flat_map(|one| &one.traces);
        let mut of_rays = traces.filter(|one| (one.rays.as_str(), one.rays_sha256.as_str(), one.count) == rays);
        let problem = match of_rays.next() {
            Some(found) => control.check(&found.judgement, &true_counts(judgement)).err().map(|_| "fails")?,
            None => "is missing",
        };
        Some(format!("{name} {problem} on {}", rays.0))
    };
    let asked = |control: &&Control| names.iter().any(|name| name == control.description().name);
    Control::ALL.iter().filter(asked).filter_map(problem).collect()
}

/// What the truth says of the rays, whoever traced them; where ambiguous rays are left out, by the classes of the others.
fn true_counts(judgement: &Judgement) -> TrueCounts {
    let [hits, misses] = judgement.true_hits_and_misses();
    let told = if let Judgement::Closest(judgement) = judgement { judgement.truth.clone() } else { None };
    told.unwrap_or(TrueCounts { hits, misses, ..TrueCounts::default() })
}
