//! The one record, `run.json`: everything that any verb measured. Every other file is derived from it.
//!
//! Rows are [`Row`]s, whoever asked for them. What a study adds to its rows is a section of the record: which points a
//! sweep has, what a case is about, how the rays of an explanation hang together. What follows from rows and sections, such as
//! the values that a tuning would choose or the verdicts on cases, is derived and not kept.
//!
//! docs/record.md describes each field; the schema number changes whenever a field changes its meaning or goes.

mod attack;
mod cases;
mod explanation;
mod fault;
mod frames;
mod interleaved_set;
mod judgement;
mod key;
mod launch;
mod merge;
mod need;
mod paired;
mod pareto;
mod provenance;
mod ratio;
mod resident_batches;
mod row;
mod sweep;
pub(crate) mod times;
mod trace;
mod tuning;
mod values;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use attack::*;
pub use cases::*;
pub use explanation::*;
pub use fault::*;
pub use frames::*;
pub use interleaved_set::*;
pub use judgement::*;
pub use key::*;
pub use launch::*;
pub use merge::*;
pub use need::*;
pub use paired::*;
pub use pareto::*;
pub use provenance::*;
pub use ratio::*;
pub use resident_batches::*;
pub use row::*;
pub use sweep::*;
pub use times::*;
pub use trace::*;
pub use tuning::*;

/// The schema that this program writes and reads.
pub const SCHEMA: u32 = 3;

/// A whole record.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tuning: Option<TuningRecord>,
    /// The cases of a stability matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cases: Option<CasesRecord>,
    /// Why rays are wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub explanation: Option<ExplanationRecord>,
    /// Points of several tracers, for fronts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pareto: Option<ParetoRecord>,
    /// Frames of moving scenes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FramesRecord>,
    /// Structures that were shrunk until answers got worse.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub need: Option<NeedRecord>,
    /// The poses at which tracers are wrong the most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attack: Option<AttackRecord>,
    /// Answers of a program that is no tracer of this suite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judged: Option<JudgedRecord>,
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
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub anchors: Vec<Row>,
    /// The interleaved sets that were timed; rows name theirs by its place ([`Times::interleaved_set`]). Empty in files of before they were
    /// told of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub interleaved_sets: Vec<InterleavedSetRecord>,
    /// What did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// Whether a value is what is read where there is none, and need not be written.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// What answers from elsewhere were judged by.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JudgedRecord {
    /// Truths that were computed anew and found to be the same.
    pub truths_checked: u64,
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
            ("frames", self.frames.is_some()),
            ("table", self.table.is_some()),
            ("sweep", self.sweep.is_some()),
        ];
        sections.into_iter().find(|(_, is_there)| *is_there).map_or("run", |(verb, _)| verb)
    }

    /// Whether it is of a kind that takes no times: its rows have no samples.
    pub fn is_untimed(&self) -> bool {
        let studies = [self.tuning.is_some(), self.cases.is_some(), self.explanation.is_some(), self.judged.is_some()];
        studies.contains(&true) || self.attack.is_some()
    }
}
