//! Shards of one plan joined into one record.

use itertools::Itertools as _;

use super::{FrameSeries, Provenance, Record, Row, ShardRecord};

/// Joins all shards of a plan, each with a name for messages. Rows are in the order of shards; each keeps its machine.
///
/// # Errors
/// Why they are not all shards of one plan by one program, each once.
pub fn merge(shards: Vec<(String, Record)>) -> Result<Record, String> {
    let no_shard = |name: &str| format!("{name} is no shard: it was not made by --shard");
    let part = |(name, record): &(String, Record)| record.provenance.shard.clone().ok_or_else(|| no_shard(name));
    let parts = shards.iter().map(part).collect::<Result<Vec<ShardRecord>, String>>()?;
    let Some(first) = parts.first() else { return Err("no records to join".to_owned()) };
    let (lead, of) = (&shards[0].0, &shards[0].1.provenance);
    for ((name, record), part) in shards.iter().zip(&parts) {
        let other = |what: &str| Err(format!("{name} is of another {what} than {lead}"));
        if (&part.plan_sha256, part.count) != (&first.plan_sha256, first.count) {
            return other("plan");
        }
        let program = |of: &Provenance, part: &ShardRecord| (of.commit.clone(), of.dirty, part.program_sha256.clone());
        if program(&record.provenance, part) != program(of, first) {
            return other("program");
        }
    }
    if first.count == 0 || parts.iter().any(|part| !(1..=first.count).contains(&part.index)) {
        return Err(no_shard(lead));
    }
    for index in 1..=first.count {
        let problem = match parts.iter().filter(|part| part.index == index).count() {
            1 => continue,
            0 => "missing",
            _ => "there twice",
        };
        return Err(format!("shard {index} of {} is {problem}", first.count));
    }
    let parts = shards.into_iter().zip(parts).sorted_by_key(|(_, part)| part.index);
    let mut shards = parts.map(|((_, record), part)| (record, part.machine_id));
    let Some((mut whole, id)) = shards.next() else { return Err("no records to join".to_owned()) };
    let mut machines = vec![(whole.provenance.machine.clone(), id)];
    whole.provenance.shard = None;
    for (shard, id) in shards {
        // Two machines of one kind are two machines.
        let own = (shard.provenance.machine.clone(), id);
        let known = machines.iter().position(|other| *other == own);
        let place = known.unwrap_or_else(|| {
            whole.provenance.further_machines.push(own.0.clone());
            machines.push(own);
            machines.len() - 1
        });
        join(&mut whole, shard, place as u32);
    }
    Ok(whole)
}

fn join(whole: &mut Record, mut shard: Record, machine: u32) {
    for row in shard.controls.iter_mut().chain(&mut shard.rows).chain(&mut shard.anchors) {
        row.machine = machine;
    }
    whole.provenance.resumed.extend(shard.provenance.resumed);
    let before = whole.interleaved_sets.len() as u32;
    let placed = |row: Row| row.with_races_after(before);
    whole.controls.extend(shard.controls.into_iter().map(placed));
    whole.rows.extend(shard.rows.into_iter().map(placed));
    whole.anchors.extend(shard.anchors.into_iter().map(placed));
    whole.interleaved_sets.extend(shard.interleaved_sets);
    for skipped in shard.skipped {
        if !whole.skipped.contains(&skipped) {
            whole.skipped.push(skipped);
        }
    }
    // The points are the same; where each was left out adds up.
    both(&mut whole.sweep, shard.sweep, |whole, shard| {
        for (point, other) in whole.points.iter_mut().zip(shard.points) {
            point.skipped.extend(other.skipped);
        }
    });
    both(&mut whole.tuning, shard.tuning, |whole, shard| whole.scenes.extend(shard.scenes));
    both(&mut whole.frames, shard.frames, |whole, shard| {
        let scenes = whole.scenes.len() as u32;
        whole.scenes.extend(shard.scenes);
        whole.rows.extend(shard.rows.into_iter().map(|row| FrameSeries {
            scene: row.scene + scenes,
            interleaved_set: row.interleaved_set.map(|set| set + before),
            machine,
            ..row
        }));
    });
    both(&mut whole.cases, shard.cases, |whole, shard| whole.cases.extend(shard.cases));
    both(&mut whole.explanation, shard.explanation, |whole, shard| whole.scenes.extend(shard.scenes));
    both(&mut whole.need, shard.need, |whole, shard| whole.curves.extend(shard.curves));
    both(&mut whole.pareto, shard.pareto, |whole, shard| {
        for (point, other) in whole.points.iter_mut().zip(shard.points) {
            point.skipped.extend(other.skipped);
        }
        whole.scenes.extend(shard.scenes);
    });
    both(&mut whole.attack, shard.attack, |whole, shard| {
        whole.viewpoints.extend(shard.viewpoints);
        whole.searches.extend(shard.searches);
    });
}

/// Joins a section that both have.
fn both<T>(whole: &mut Option<T>, shard: Option<T>, join: impl FnOnce(&mut T, T)) {
    if let (Some(whole), Some(shard)) = (whole, shard) {
        join(whole, shard);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture;

    fn shard(index: u32, count: u32, plan: &str) -> Record {
        let mut record = fixture::run(&[], &[]);
        let (program_sha256, machine_id) = ("program".to_owned(), "one".to_owned());
        let plan_sha256 = plan.to_owned();
        record.provenance.shard = Some(ShardRecord { index, count, plan_sha256, program_sha256, machine_id });
        record
    }

    fn joined(shards: Vec<Record>) -> Result<Record, String> {
        merge(shards.into_iter().enumerate().map(|(place, record)| (format!("{place}"), record)).collect())
    }

    /// Shards are joined in their own order, whatever the order given; a record without shards, of another plan or program,
    /// one that is missing or there twice is refused.
    #[test]
    fn shards_must_be_whole() {
        let mut second = shard(2, 2, "plan");
        // Of the same kind, and yet another one.
        second.provenance.shard.as_mut().unwrap().machine_id = "another".to_owned();
        let quality = fixture::Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: tracebench_api::ClockKind::Host };
        let mut row = fixture::run(&[("bvh-cpu", quality)], &[]).rows.remove(0);
        row.tracer.name = "second".to_owned();
        second.rows.push(row);
        let whole = joined(vec![second.clone(), shard(1, 2, "plan")]).unwrap();
        assert_eq!((whole.provenance.shard.as_ref(), whole.provenance.further_machines.len()), (None, 1));
        assert_eq!((whole.rows[0].machine, whole.skipped.len()), (1, 1));
        // Interleaved sets of the second stand behind that of the first.
        assert_eq!((whole.rows[0].build.times.interleaved_set, whole.interleaved_sets.len()), (Some(1), 2));
        let mut other_program = second.clone();
        other_program.provenance.commit = "ffff".to_owned();
        let mut other_build = second.clone();
        other_build.provenance.shard.as_mut().unwrap().program_sha256 = "ffff".to_owned();
        for (shards, part) in [
            (Vec::new(), "no records"),
            (vec![fixture::run(&[], &[])], "no shard"),
            (vec![shard(1, 2, "plan"), shard(2, 2, "other")], "another plan"),
            (vec![shard(1, 2, "plan"), shard(2, 3, "plan")], "another plan"),
            (vec![shard(1, 2, "plan"), other_program], "another program"),
            (vec![shard(1, 2, "plan"), other_build], "another program"),
            (vec![shard(9, 1, "plan")], "no shard"),
            (vec![shard(1, 2, "plan")], "2 of 2 is missing"),
            (vec![shard(1, 2, "plan"), shard(1, 2, "plan"), second], "1 of 2 is there twice"),
        ] {
            let error = joined(shards).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
