//! Whether the controls scored what they must; a control that did not voids the run.

use crate::results::{Judgement, Run, TraceRecord};

/// What the controls say of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// There are none.
    Absent,
    /// All scored what they must.
    Sound,
    /// Those that did not, as "name on rays of scene".
    Void(Vec<String>),
}

impl Verdict {
    /// In words.
    pub(super) fn sentence(&self) -> String {
        match self {
            Self::Absent => "none ran; nothing vouches for the judgement".to_owned(),
            Self::Sound => "all score what they must".to_owned(),
            Self::Void(failed) => format!("**the run is void**, these fail: {}", failed.join("; ")),
        }
    }
}

/// Looks at every control by name; names that are not known are not judged.
pub(super) fn controls(run: &Run) -> Verdict {
    if run.controls.is_empty() {
        return Verdict::Absent;
    }
    let mut failed = Vec::new();
    for control in &run.controls {
        for trace in control.traces.iter().filter(|trace| !sound(&control.tracer.name, trace)) {
            failed.push(format!("{} on {} of {}", control.tracer.name, trace.rays, control.scene.name));
        }
    }
    if failed.is_empty() { Verdict::Sound } else { Verdict::Void(failed) }
}

/// The oracle is never wrong; the others never say what they must not.
fn sound(name: &str, trace: &TraceRecord) -> bool {
    match (name, &trace.judgement) {
        ("oracle", Judgement::Closest(judgement)) => {
            let wrong = [&judgement.classes.tight, &judgement.classes.footprint]
                .map(|classes| classes.false_hit + classes.false_miss + classes.early + classes.late);
            wrong == [0, 0]
        }
        ("oracle", Judgement::Any(judgement)) => {
            judgement.occlusion.false_occluded + judgement.occlusion.false_free == 0
        }
        ("always-miss", Judgement::Closest(judgement)) => {
            let classes = &judgement.classes.tight;
            classes.true_hit + classes.false_hit + classes.early + classes.late == 0
        }
        ("always-miss", Judgement::Any(judgement)) => {
            judgement.occlusion.true_occluded + judgement.occlusion.false_occluded == 0
        }
        ("always-hit", Judgement::Closest(judgement)) => {
            judgement.classes.tight.true_miss + judgement.classes.tight.false_miss == 0
        }
        ("always-hit", Judgement::Any(judgement)) => {
            judgement.occlusion.true_free + judgement.occlusion.false_free == 0
        }
        _ => true,
    }
}
