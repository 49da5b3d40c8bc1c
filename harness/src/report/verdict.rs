//! Whether the controls of a run scored what they must; one that did not, or is not there, voids the run.

use crate::controls::Control;
use crate::results::{Classes, Judgement, Run, TraceRecord, TracerRun, ViewpointRecord};

/// What the controls say of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// All stand beside every contender and scored what they must.
    Sound,
    /// Those that did not, or are missing, as "name on rays of scene".
    Void(Vec<String>),
}

impl Verdict {
    /// In words.
    pub(super) fn sentence(&self) -> String {
        match self {
            Self::Sound => "all score what they must".to_owned(),
            Self::Void(failed) => format!("**the run is void**: {}", failed.join("; ")),
        }
    }
}

/// Looks for every control beside everything that was traced, by the rule that the runner holds them to.
pub(super) fn controls(run: &Run) -> Verdict {
    let mut failed: Vec<String> = Vec::new();
    for (contender, trace) in run.runs.iter().flat_map(|one| one.traces.iter().map(move |trace| (one, trace))) {
        for control in Control::ALL {
            if let Some(problem) = problem(run, control, contender, trace) {
                let name = control.description().name;
                let sentence = format!("{name} {problem} on {} of {}", trace.rays, contender.scene.name);
                if !failed.contains(&sentence) {
                    failed.push(sentence);
                }
            }
        }
    }
    if failed.is_empty() { Verdict::Sound } else { Verdict::Void(failed) }
}

/// What is wrong with a control beside a contender's trace.
fn problem(run: &Run, control: Control, contender: &TracerRun, trace: &TraceRecord) -> Option<&'static str> {
    // Frame and faces shape structures, not rays; controls have none.
    let pose = |view: &ViewpointRecord| ViewpointRecord { frame: [0; 2], face: 0, ..view.clone() };
    let beside = |one: &&TracerRun| {
        one.tracer.name == control.description().name
            && one.scene == contender.scene
            && pose(&one.viewpoint) == pose(&contender.viewpoint)
    };
    let found = run
        .controls
        .iter()
        .filter(beside)
        .flat_map(|one| &one.traces)
        .find(|one| one.rays == trace.rays && one.rays_sha256 == trace.rays_sha256 && one.count == trace.count);
    let Some(found) = found else { return Some("is missing") };
    let (occluded, free) = hits_and_misses(&trace.judgement);
    control.check(&found.judgement, occluded, free).err().map(|_| "fails")
}

/// The numbers of rays, without ties, that truth says hit and miss: a property of the rays, whoever traced them.
fn hits_and_misses(judgement: &Judgement) -> (u64, u64) {
    match judgement {
        Judgement::Closest(judgement) => {
            let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = judgement.classes.tight;
            (true_hit + false_miss + early + late, true_miss + false_hit)
        }
        Judgement::Any(judgement) => {
            let table = &judgement.occlusion;
            (table.true_occluded + table.false_free, table.true_free + table.false_occluded)
        }
    }
}
