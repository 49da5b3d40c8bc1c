//! Where results come from: the head of every record.

use serde::{Deserialize, Serialize};
use tracebench_api::Gpu;

use super::{LaunchRecord, is_default};
use crate::machine::{self, Machine};

/// Version of the rules of measuring, RULES.md.
pub const RULES_VERSION: u32 = 3;

/// Where something was measured, by which program, and when; flattened into the record of what was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Where it ran.
    pub machine: Machine,
    /// Commit of the program, or "unknown".
    pub commit: String,
    /// Whether the program was built from a changed tree; `None` if unknown.
    pub dirty: Option<bool>,
    /// How searches on the device read and are launched where nothing is set; none where no tracer has the choice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub launch: Option<LaunchRecord>,
    /// When it began, UTC, ISO 8601.
    pub started: String,
    /// Version of the rules that it was measured by ([`RULES_VERSION`]); 0 of records from before they were written down.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rules_version: u32,
    /// When it was gone on with after it had been broken off, UTC.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resumed: Vec<String>,
    /// Hash of the plan, of all shards together; none in records of before it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan_sha256: Option<String>,
    /// Which part of the plan it is, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardRecord>,
    /// Machines of further shards, where records were merged; rows name theirs by its place, from 1.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_machines: Vec<Machine>,
    /// The form that it had before, if it was measured by a program that wrote another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converted_from: Option<ConvertedFrom>,
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
