//! Verdicts on claims: the quantity of a run compared with the rule of the claim.

use itertools::Itertools as _;
use serde::Serialize;
use tracebench_api::named;

use super::Paper;
use super::claims::{Claim, Rule, Test};
use super::experiment::StandIn;
use super::frames::with_rows;
use super::quantity::{OfScene, Quantity};
use super::rows::Rows;
use crate::results::Record;

named! {
    /// What is said of a claim.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    pub enum Verdict {
        /// What was measured is as claimed.
        #[serde(rename = "holds")]
        Holds = "holds",
        /// What was measured is not as claimed.
        #[serde(rename = "does not hold here")]
        DoesNotHold = "does not hold here",
        /// What was measured does not tell.
        #[serde(rename = "undecided")]
        Undecided = "undecided",
        /// Nothing here can tell.
        #[serde(rename = "not measurable here")]
        NotMeasurable = "not measurable here",
        /// What could tell was not measured, or lacks the rows for it.
        #[serde(rename = "not measured")]
        NotMeasured = "not measured",
    }
}

/// A measured value of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneValue {
    /// The scene.
    pub scene: String,
    /// The value.
    pub value: f64,
    /// Where it lies, if a time is in it; an end that is `null` is open.
    pub interval: Option<[f64; 2]>,
}

impl From<&OfScene> for SceneValue {
    fn from((scene, found): &OfScene) -> Self {
        let scene = found.note.as_ref().map_or_else(|| scene.clone(), |note| format!("{scene} ({note})"));
        Self { scene, value: found.value, interval: found.timed.then_some(found.interval) }
    }
}

/// A claim with what is said of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedClaim {
    /// The claim.
    pub claim: Claim,
    /// What is said.
    pub verdict: Verdict,
    /// Why, where it is not told by the values.
    pub reason: Option<String>,
    /// What was measured, whatever the verdict.
    pub values: Vec<SceneValue>,
    /// The same by every other reading that the claim has.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub either: Vec<Vec<SceneValue>>,
    /// Unit of the values.
    pub unit: String,
    /// Their median.
    pub median: Option<f64>,
    /// How many of the scenes that it is about were measured, and how many there are.
    pub scenes: [usize; 2],
    /// The run that has them.
    pub measured_by: Option<MeasuredBy>,
}

/// The run behind a verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MeasuredBy {
    /// The table.
    pub table: String,
    /// How many of the table's rows it has, and how many there are.
    pub rows: [usize; 2],
    /// Where.
    pub machine: String,
    /// The adapter's kind, the frames, and how many rays a set has.
    pub scope: String,
    /// The run preset.
    pub preset: String,
    /// The program's commit.
    pub commit: String,
    /// When, UTC.
    pub started: String,
}

impl JudgedClaim {
    /// One that no record was measured for.
    fn unmeasured(claim: &Claim) -> Self {
        let (verdict, reason) = match &claim.test {
            Test::NotMeasurable { not_measurable } => (Verdict::NotMeasurable, not_measurable.clone()),
            Test::Measured { table, .. } => {
                (Verdict::NotMeasured, format!("no record of `tracebench table {table}` was given"))
            }
        };
        let (claim, reason, scenes) = (claim.clone(), Some(reason), [0; 2]);
        let (values, either, unit, median, measured_by) = (Vec::new(), Vec::new(), String::new(), None, None);
        Self { claim, verdict, reason, values, either, unit, median, scenes, measured_by }
    }
}

/// Judges one claim of a paper by a run that was made for its table, or is taken for it.
pub fn judge(paper: &Paper, claim: &Claim, rows: &Rows<'_>) -> JudgedClaim {
    let Test::Measured { table, quantity: name, either, scenes, rule } = &claim.test else {
        return JudgedClaim::unmeasured(claim);
    };
    let quantities: Option<Vec<_>> = std::iter::once(name).chain(either).map(|name| paper.quantity(name)).collect();
    let Some((experiment, quantities)) = paper.experiment(table).zip(quantities) else {
        let reason = Some(format!("there is no table {table} or no quantity {name}"));
        return JudgedClaim { reason, ..JudgedClaim::unmeasured(claim) };
    };
    let about = rows.standing_for(experiment, scenes);
    // What stands for nothing decides nothing, and is shown all the same.
    let shown = if about.scenes.is_empty() { rows } else { &about };
    let readings: Vec<_> = quantities.into_iter().map(|quantity| (quantity, quantity.values(paper, shown))).collect();
    let adapter = rows.record.provenance.machine.adapter.as_ref().map_or("no", |adapter| &adapter.kind);
    let (verdict, reason) = match readings.iter().find(|(_, found)| found.is_empty()) {
        _ if about.scenes.is_empty() => {
            let of = if scenes.is_empty() { "any of the paper's".to_owned() } else { scenes.join(" or ") };
            (Verdict::NotMeasured, Some(format!("the record has no scene that stands for {of}")))
        }
        Some((Quantity { name, .. }, _)) => {
            (Verdict::NotMeasured, Some(format!("the record has no scene with the rows of {table} that {name} takes")))
        }
        None if claim.needs_hardware_raster && ["no", "software"].contains(&adapter) => {
            let reason = "needs times of hardware rasterization, the adapter is software";
            (Verdict::NotMeasurable, Some(reason.to_owned()))
        }
        None => agreed(rule, &readings),
    };
    let record = rows.record;
    let is_about = |each: &&StandIn| scenes.is_empty() || scenes.iter().any(|name| name == each.published);
    let measured_by = MeasuredBy {
        table: experiment.name.to_owned(),
        rows: rows.of_all(experiment),
        machine: record.provenance.machine.label(),
        scope: scope(adapter, shown),
        preset: record.preset.clone(),
        commit: record.provenance.commit.clone(),
        started: record.provenance.started.clone(),
    };
    let mut values = readings.iter().map(|(_, found)| found.iter().map(SceneValue::from).collect::<Vec<_>>());
    let (values, either) = (values.next().unwrap_or_default(), values.collect());
    let plain: Vec<f64> = values.iter().map(|value| value.value).collect();
    JudgedClaim {
        claim: claim.clone(),
        verdict,
        reason,
        median: (!values.is_empty()).then(|| crate::statistics::median(&plain)),
        values,
        either,
        unit: readings[0].0.unit.clone(),
        scenes: [about.names(), experiment.scenes.iter().filter(is_about).count()],
        measured_by: Some(measured_by),
    }
}

/// On what kind of adapter, at which frames and with how many rays a set something was measured.
fn scope(adapter: &str, rows: &Rows<'_>) -> String {
    let all = || rows.scenes.iter().flat_map(|scene| &scene.rows);
    let frames = all().map(|row| row.viewpoint.frame.map(|edge| edge.to_string()).join("x")).unique();
    let rays = all().flat_map(|row| &row.traces).map(|trace| trace.count).minmax().into_option();
    let rays = rays.map_or_else(String::new, |(least, most)| match least == most {
        true => format!(", {least} rays a set"),
        false => format!(", {least} to {most} rays a set"),
    });
    format!("{adapter} adapter, frame {}{rays}", frames.collect::<Vec<_>>().join(", "))
}

/// What every reading says: undecided with all that they say where it is not the same.
fn agreed(rule: &Rule, readings: &[(&Quantity, Vec<OfScene>)]) -> (Verdict, Option<String>) {
    let each: Vec<_> = readings.iter().map(|(_, found)| decided(rule, found)).collect();
    if each.iter().all_equal() {
        return each[0].clone();
    }
    let said = readings.iter().zip(each).map(|((quantity, _), (verdict, reason))| {
        let reason = reason.map_or_else(String::new, |reason| format!(" ({reason})"));
        format!("by {} {}{reason}", quantity.name, verdict.name())
    });
    (Verdict::Undecided, Some(said.collect::<Vec<_>>().join("; ")))
}

/// What a reading alone says.
fn decided(rule: &Rule, found: &[OfScene]) -> (Verdict, Option<String>) {
    let estimates: Vec<_> = found.iter().map(|(_, found)| found.clone()).collect();
    let verdict = rule.decide(&estimates);
    (verdict, (verdict == Verdict::Undecided).then(|| open(rule, found)))
}

/// Why nothing is said, by scene.
fn open(rule: &Rule, found: &[OfScene]) -> String {
    let why = |(scene, found): &OfScene| {
        let why = match (found.doubts.is_empty(), found.at_launch_settings) {
            (false, _) => found.doubts.iter().join(", "),
            (true, false) => "the interval does not separate".to_owned(),
            (true, true) => "equal and best launch settings disagree, or their intervals do not separate".to_owned(),
        };
        (rule.place(found) == Verdict::Undecided).then(|| format!("{scene}: {why}"))
    };
    let all: Vec<String> = found.iter().filter_map(why).collect();
    // Every scene's lies on one side, the median's between them does not.
    if all.is_empty() { "the interval of the median does not separate".to_owned() } else { all.join("; ") }
}

/// Judges all claims of a paper by the runs that were made for its tables, of which one may have some rows and another others. A claim
/// that several runs measure is judged by each; one that none measures is named with the table that would.
pub fn judge_all(paper: &Paper, rows: &[Record]) -> Vec<JudgedClaim> {
    let mut judged = Vec::new();
    for claim in paper.claims.iter() {
        let is_of_table = |record: &&Record| record.table.as_deref().is_some_and(|table| claim.table() == Some(table));
        let of_table = rows.iter().filter(is_of_table);
        let told = |record: &Record| judge(paper, claim, &Rows::of(&with_rows(&record.aligned())));
        let mut of_claim: Vec<_> = of_table.map(told).collect();
        if of_claim.iter().any(|each| each.verdict != Verdict::NotMeasured) {
            of_claim.retain(|each| each.verdict != Verdict::NotMeasured);
        }
        if of_claim.is_empty() {
            of_claim.push(JudgedClaim::unmeasured(claim));
        }
        judged.extend(of_claim);
    }
    judged
}
