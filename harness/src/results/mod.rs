//! The one record, `run.json`: everything that any verb measured. Every other file is derived from it.
//!
//! Rows are [`Row`]s, whoever asked for them. What a study adds to its rows is a section of the record: which points a
//! sweep has, what a case is about, how the rays of an explanation hang together. What follows from rows and sections, such as
//! the values that a tuning would choose or the verdicts on cases, is derived and not kept.
//!
//! docs/record.md describes each field; the schema number changes whenever a field changes its meaning or goes.

/// Parts of a record. A field that is `= default` is not written where it has the value that is read where there is none.
macro_rules! records {
    ($($(#[$of:meta])* pub struct $Name:ident {
        $($(#[$about:meta])* pub $field:ident: $Type:ty $(= $default:ident)?,)*
    })*) => { $(
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        $(#[$of])*
        pub struct $Name { $(
            $(#[$about])*
            $(#[serde($default, skip_serializing_if = "crate::results::is_default")])?
            pub $field: $Type,
        )* }
    )* };
}

mod cases;
mod fault;
mod frames;
mod interleaved_set;
mod judgement;
mod launch;
mod merge;
mod paired;
mod ratio;
mod resident_batches;
mod row;
mod studies;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::Gpu;

use crate::machine::{self, Machine};
pub use cases::*;
pub use fault::*;
pub use frames::*;
pub use interleaved_set::*;
pub use judgement::*;
pub use launch::*;
pub use merge::*;
pub use paired::*;
pub use ratio::*;
pub use resident_batches::*;
pub use row::*;
pub use studies::*;

/// The schema that this program writes and reads.
pub const SCHEMA: u32 = 3;

records! {
    /// A whole record.
    #[derive(Default)]
    pub struct Record {
        /// [`SCHEMA`].
        pub schema: u32,
        /// Where, by which program and when; its fields stand among these.
        #[serde(flatten)]
        pub provenance: Provenance,
        /// Seed of the ray sets.
        pub seed: u64,
        /// Run preset: smoke, quick or paper. Figures of a smoke run only show that things work. Empty for cases, which have none.
        pub preset: String,
        /// The table that the run was made for, if it was made for one.
        pub table: Option<String>,
        /// The sweep that the run is, if it is one; a tuning is one over a single parameter.
        pub sweep: Option<SweepRecord>,
        /// What a tuning adds to its sweep.
        pub tuning: Option<TuningRecord> = default,
        /// The cases of a stability matrix.
        pub cases: Option<CasesRecord> = default,
        /// Why rays are wrong.
        pub explanation: Option<ExplanationRecord> = default,
        /// Points of several tracers, for fronts.
        pub pareto: Option<ParetoRecord> = default,
        /// Frames of moving scenes.
        pub frames: Option<FramesRecord> = default,
        /// Structures that were shrunk until answers got worse.
        pub need: Option<NeedRecord> = default,
        /// The poses at which tracers are wrong the most.
        pub attack: Option<AttackRecord> = default,
        /// Answers of a program that is no tracer of this suite.
        pub judged: Option<JudgedRecord> = default,
        /// What was said about ray sets: every parameter's value. Empty in files of before there were any.
        #[serde(default)]
        pub ray_parameters: BTreeMap<String, serde_json::Value>,
        /// Names of the controls that stand beside every configuration. In files of before they were told the first three.
        #[serde(default = "first_controls")]
        pub control_names: Vec<String>,
        /// The controls, in the form of runs.
        pub controls: Vec<Row>,
        /// The configurations.
        pub rows: Vec<Row>,
        /// The first configuration of a scene, measured again in every resident batch after the first ([`Row::resident_batch`]): ratios between
        /// resident batches go through it.
        pub anchors: Vec<Row> = default,
        /// The interleaved sets that were timed; rows name theirs by its place ([`Times::interleaved_set`]). Empty in files of before they were
        /// told of.
        pub interleaved_sets: Vec<InterleavedSetRecord> = default,
        /// What did not run, and why.
        pub skipped: Vec<Skipped>,
    }

    /// What answers from elsewhere were judged by.
    #[derive(Eq)]
    pub struct JudgedRecord {
        /// Truths that were computed anew and found to be the same.
        pub truths_checked: u64,
    }
}

/// Whether a value is what is read where there is none, and need not be written.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Values by their keys, both in the order of first appearance.
pub(crate) fn gathered<K: PartialEq, V>(pairs: impl IntoIterator<Item = (K, V)>) -> Vec<(K, Vec<V>)> {
    let mut all: Vec<(K, Vec<V>)> = Vec::new();
    for (key, value) in pairs {
        match all.iter_mut().find(|(known, _)| *known == key) {
            Some((_, values)) => values.push(value),
            None => all.push((key, vec![value])),
        }
    }
    all
}

/// Something that was asked for and did not run.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Skipped {
    /// Tracer, `None` if it concerns all.
    pub tracer: Option<String>,
    /// Scene.
    pub scene: String,
    /// Ray set, `None` if it concerns all.
    pub rays: Option<String>,
    /// Why.
    pub reason: String,
}

fn first_controls() -> Vec<String> {
    ["oracle", "always-miss", "always-hit"].map(str::to_owned).to_vec()
}

/// The verb, with its option, that measures what the choice of a parameter costs.
pub const CHOOSE: &str = "sweep --choose";

/// The verbs that take no times: rows have no samples.
pub const UNTIMED: [&str; 5] = [CHOOSE, "stability", "explain", "judge", "attack"];

impl Record {
    /// The verb that has measured it.
    pub fn verb(&self) -> &'static str {
        let sections = [
            (CHOOSE, self.tuning.is_some()),
            ("stability", self.cases.is_some()),
            ("explain", self.explanation.is_some()),
            ("judge", self.judged.is_some()),
            ("pareto", self.pareto.is_some()),
            ("need", self.need.is_some()),
            ("attack", self.attack.is_some()),
            ("table", self.table.is_some()),
            ("frames", self.frames.is_some()),
            ("sweep", self.sweep.is_some()),
        ];
        sections.into_iter().find(|(_, is_there)| *is_there).map_or("run", |(verb, _)| verb)
    }

    /// Whether it is of a verb that takes no times.
    pub fn is_untimed(&self) -> bool {
        UNTIMED.contains(&self.verb())
    }
}

/// Version of the rules of measuring, RULES.md.
pub const RULES_VERSION: u32 = 3;

records! {
    /// Where something was measured, by which program, and when; flattened into the record of what was measured.
    #[derive(Default)]
    pub struct Provenance {
        /// Where it ran.
        pub machine: Machine,
        /// Commit of the program, or "unknown".
        pub commit: String,
        /// Whether the program was built from a changed tree; `None` if unknown.
        pub dirty: Option<bool>,
        /// How searches on the device read and are launched where nothing is set; none where no tracer has the choice.
        pub launch: Option<LaunchRecord> = default,
        /// When it began, UTC, ISO 8601.
        pub started: String,
        /// Version of the rules that it was measured by ([`RULES_VERSION`]); 0 of records from before they were written down.
        pub rules_version: u32 = default,
        /// When it was gone on with after it had been broken off, UTC.
        pub resumed: Vec<String> = default,
        /// Hash of the plan, of all shards together; none in records of before it was kept.
        pub plan_sha256: Option<String> = default,
        /// Which part of the plan it is, if it is one.
        pub shard: Option<ShardRecord> = default,
        /// Machines of further shards, where records were merged; rows name theirs by its place, from 1.
        pub further_machines: Vec<Machine> = default,
        /// The form that it had before, if it was measured by a program that wrote another one.
        pub converted_from: Option<ConvertedFrom> = default,
    }
}

impl Provenance {
    /// The machine of a row, by its place; that of the head for a place that there is none of.
    pub fn machine_of(&self, place: u32) -> &Machine {
        let further = (place as usize).checked_sub(1).and_then(|place| self.further_machines.get(place));
        further.unwrap_or(&self.machine)
    }

    /// Here, by this program, now; with the device that is used, if one is.
    pub fn now(gpu: Option<&Gpu>) -> Self {
        Self {
            machine: machine::this_machine(gpu),
            commit: machine::COMMIT.to_owned(),
            dirty: machine::dirty(),
            started: machine::utc_now(),
            rules_version: RULES_VERSION,
            ..Self::default()
        }
    }
}

/// A part of a plan: whole scenes and viewpoints, dealt out in turn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardRecord {
    /// Which, from 1.
    pub index: u32,
    /// Of how many.
    pub count: u32,
    /// Hash of the whole plan: shards of another one are not joined.
    pub plan_sha256: String,
    /// Hash of the program: shards of another one are not joined.
    pub program_sha256: String,
    /// Tells machines of one kind apart; empty where the system has nothing to tell them by.
    pub machine_id: String,
}

impl ShardRecord {
    /// A part of a plan, by this program on this machine.
    pub fn here(index: u32, count: u32, plan_sha256: String) -> Self {
        let (program_sha256, machine_id) = (machine::program_sha256(), machine::machine_id());
        Self { index, count, plan_sha256, program_sha256, machine_id }
    }

    /// Whether a scene with its viewpoint, by its place in the plan, is of this part.
    pub fn takes(&self, place: usize) -> bool {
        place % self.count as usize + 1 == self.index as usize
    }
}

/// What a record was before.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConvertedFrom {
    /// The file.
    pub file: String,
    /// Its schema.
    pub schema: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that records name the version that RULES.md has, and that a record without one is distinguished.
    #[test]
    fn the_rules_that_are_written_are_the_ones_that_records_name() {
        let rules = include_str!("../../../RULES.md");
        assert!(rules.contains(&format!("\nVersion {RULES_VERSION}. ")));
        let now = serde_json::to_value(Provenance::now(None)).unwrap();
        assert_eq!(now["rules_version"], RULES_VERSION);
        let mut before = now;
        before.as_object_mut().unwrap().remove("rules_version");
        assert_eq!(serde_json::from_value::<Provenance>(before).unwrap().rules_version, 0);
    }
}
