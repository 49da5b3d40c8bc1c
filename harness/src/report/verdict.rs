//! Whether the controls of a run scored what they must; one that did not, or is not there, voids the run.

use itertools::Itertools as _;

use crate::measure::controls::Control;
use crate::results::{Judgement, Record, Row, TraceRecord, TrueCounts, ViewpointRecord};

/// What controls say of a run of which these failed.
pub(super) fn sentence(failed: &[String]) -> String {
    match failed {
        [] => "all score what they must".to_owned(),
        failed => format!("**the record is invalid**: {}", failed.join("; ")),
    }
}

/// Looks for every control beside everything that was traced, by the rule that every interleaved set holds them to: those that did not score
/// what they must, or are missing, as "name on rays of scene".
pub(super) fn controls(record: &Record) -> Vec<String> {
    // Frame and faces shape structures, not rays; controls have none.
    let pose = |view: &ViewpointRecord| ViewpointRecord { frame: [0; 2], face: 0, ..view.clone() };
    let of_config = |config: &Row| {
        let beside = |one: &&Row| one.scene == config.scene && pose(&one.viewpoint) == pose(&config.viewpoint);
        let rows: Vec<&Row> = record.controls.iter().filter(beside).collect();
        let of_trace = |trace: &TraceRecord| {
            let rays = (trace.rays.as_str(), trace.rays_sha256.as_str(), trace.count);
            problems(&rows, &record.control_names, rays, &trace.judgement)
        };
        let (problems, view) = (config.traces.iter().flat_map(of_trace), &config.viewpoint.name);
        problems.map(|problem| format!("{problem} of {} from {view}", config.scene.name)).collect::<Vec<_>>()
    };
    record.rows.iter().flat_map(of_config).unique().collect()
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
