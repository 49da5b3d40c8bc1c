//! Shards of one plan joined into the record that one machine would have made.

use super::{Run, ShardRecord, SweepRecord};
use crate::machine::Machine;

/// Why records cannot be joined.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Nothing to join.
    #[error("no records to join")]
    Nothing,
    /// A record of a whole plan.
    #[error("{0} is no shard: it was not made by --shard")]
    NoShard(String),
    /// Shards that do not belong together.
    #[error("{0} is of another {1} than {2}")]
    Other(String, &'static str, String),
    /// A shard that is there twice, or one that is missing.
    #[error("shard {index} of {count} is {problem}")]
    Incomplete {
        /// Which.
        index: u32,
        /// Of how many.
        count: u32,
        /// `missing`, or `there twice`.
        problem: &'static str,
    },
}

/// Joins all shards of a plan, each with a name for messages. Rows stand in the order of shards; each keeps its machine.
///
/// # Errors
/// [`MergeError`] if they are not all shards of one plan by one program, each once.
pub fn merge(mut shards: Vec<(String, Run)>) -> Result<Run, MergeError> {
    let mut parts: Vec<ShardRecord> = Vec::new();
    for (name, run) in &shards {
        parts.push(run.provenance.shard.clone().ok_or_else(|| MergeError::NoShard(name.clone()))?);
    }
    let Some(first) = parts.first().cloned() else { return Err(MergeError::Nothing) };
    for ((name, run), part) in shards.iter().zip(&parts) {
        let (of, lead) = (&shards[0].0, &shards[0].1.provenance);
        let other = |what| MergeError::Other(name.clone(), what, of.clone());
        if (&part.plan_sha256, part.count) != (&first.plan_sha256, first.count) {
            return Err(other("plan"));
        }
        if (&run.provenance.commit, run.provenance.dirty) != (&lead.commit, lead.dirty) {
            return Err(other("program"));
        }
    }
    for index in 1..=first.count {
        let problem = match parts.iter().filter(|part| part.index == index).count() {
            1 => continue,
            0 => "missing",
            _ => "there twice",
        };
        return Err(MergeError::Incomplete { index, count: first.count, problem });
    }
    shards.sort_by_key(|(_, run)| run.provenance.shard.as_ref().map_or(0, |shard| shard.index));
    let mut shards = shards.into_iter().map(|(_, run)| run);
    let Some(mut whole) = shards.next() else { return Err(MergeError::Nothing) };
    whole.provenance.shard = None;
    for shard in shards {
        join(&mut whole, shard);
    }
    Ok(whole)
}

fn join(whole: &mut Run, mut shard: Run) {
    let machine = place_of(whole, &shard.provenance.machine);
    for row in shard.controls.iter_mut().chain(&mut shard.runs).chain(&mut shard.anchors) {
        row.machine = machine;
    }
    whole.provenance.resumed.extend(shard.provenance.resumed);
    whole.controls.extend(shard.controls);
    whole.runs.extend(shard.runs);
    whole.anchors.extend(shard.anchors);
    for skipped in shard.skipped {
        if !whole.skipped.contains(&skipped) {
            whole.skipped.push(skipped);
        }
    }
    if let (Some(whole), Some(shard)) = (&mut whole.sweep, shard.sweep) {
        join_sweeps(whole, shard);
    }
    if let (Some(whole), Some(shard)) = (&mut whole.tuning, shard.tuning) {
        whole.scenes.extend(shard.scenes);
    }
    if let (Some(whole), Some(shard)) = (&mut whole.updates, shard.updates) {
        whole.scenes.extend(shard.scenes);
    }
    if let (Some(whole), Some(shard)) = (&mut whole.cases, shard.cases) {
        whole.cases.extend(shard.cases);
    }
    if let (Some(whole), Some(shard)) = (&mut whole.explanation, shard.explanation) {
        whole.scenes.extend(shard.scenes);
    }
}

/// The place of a machine among those of a record, where it is added if it is new.
fn place_of(whole: &mut Run, machine: &Machine) -> u32 {
    if whole.provenance.machine == *machine {
        return 0;
    }
    let further = &mut whole.provenance.further_machines;
    let known = further.iter().position(|other| other == machine);
    let place = known.unwrap_or_else(|| {
        further.push(machine.clone());
        further.len() - 1
    });
    place as u32 + 1
}

/// The points are the same; where each was left out adds up.
fn join_sweeps(whole: &mut SweepRecord, shard: SweepRecord) {
    for (point, other) in whole.points.iter_mut().zip(shard.points) {
        point.skipped.extend(other.skipped);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture;

    fn shard(index: u32, count: u32, plan: &str) -> Run {
        let mut run = fixture::run(&[], &[]);
        run.provenance.shard = Some(ShardRecord { index, count, plan_sha256: plan.to_owned() });
        run
    }

    fn joined(shards: Vec<Run>) -> Result<Run, MergeError> {
        merge(shards.into_iter().enumerate().map(|(place, run)| (format!("{place}"), run)).collect())
    }

    /// Shards are joined in their own order, whatever the order given; a record without shards, of another plan or program,
    /// one that is missing or there twice is refused.
    #[test]
    fn shards_must_be_whole() {
        let mut second = shard(2, 2, "plan");
        second.provenance.machine.cpu = "another".to_owned();
        let quality = fixture::Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: tracebench_api::ClockKind::Host };
        let mut row = fixture::run(&[("bvh-cpu", quality)], &[]).runs.remove(0);
        row.tracer.name = "second".to_owned();
        second.runs.push(row);
        let whole = joined(vec![second.clone(), shard(1, 2, "plan")]).unwrap();
        assert_eq!((whole.provenance.shard.as_ref(), whole.provenance.further_machines.len()), (None, 1));
        assert_eq!((whole.runs[0].machine, whole.skipped.len()), (1, 1));
        let mut other_program = second.clone();
        other_program.provenance.commit = "ffff".to_owned();
        for (shards, part) in [
            (Vec::new(), "no records"),
            (vec![fixture::run(&[], &[])], "no shard"),
            (vec![shard(1, 2, "plan"), shard(2, 2, "other")], "another plan"),
            (vec![shard(1, 2, "plan"), shard(2, 3, "plan")], "another plan"),
            (vec![shard(1, 2, "plan"), other_program], "another program"),
            (vec![shard(1, 2, "plan")], "2 of 2 is missing"),
            (vec![shard(1, 2, "plan"), shard(1, 2, "plan"), second], "1 of 2 is there twice"),
        ] {
            let error = joined(shards).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
