//! Verdicts on claims: the quantity of a run held against the rule of the claim.

use serde::Serialize;

use super::claims::{Claim, Test};
use super::rows::Rows;
use super::{DataError, Paper};
use crate::results::Run;

/// What is said of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Verdict {
    /// What was measured is as claimed.
    #[serde(rename = "holds")]
    Holds,
    /// What was measured is not as claimed.
    #[serde(rename = "does not hold here")]
    DoesNotHold,
    /// Nothing here can tell.
    #[serde(rename = "not measurable here")]
    NotMeasurable,
    /// What could tell was not measured, or lacks the rows for it.
    #[serde(rename = "not measured")]
    NotMeasured,
}

impl Verdict {
    /// Every verdict.
    pub const ALL: [Self; 4] = [Self::Holds, Self::DoesNotHold, Self::NotMeasurable, Self::NotMeasured];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold here",
            Self::NotMeasurable => "not measurable here",
            Self::NotMeasured => "not measured",
        }
    }
}

/// A measured value of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneValue {
    /// The scene.
    pub scene: String,
    /// The value.
    pub value: f64,
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
    /// Unit of the values.
    pub unit: &'static str,
    /// Their median.
    pub median: Option<f64>,
    /// The run that has them.
    pub measured_by: Option<MeasuredBy>,
}

/// The run behind a verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MeasuredBy {
    /// The table.
    pub table: String,
    /// Where.
    pub machine: String,
    /// The run preset.
    pub preset: String,
    /// The program's commit.
    pub commit: String,
    /// When, UTC.
    pub started: String,
}

impl JudgedClaim {
    fn not_measurable(claim: &Claim, reason: &str) -> Self {
        Self::without_values(claim.clone(), Verdict::NotMeasurable, reason.to_owned())
    }

    fn without_values(claim: Claim, verdict: Verdict, reason: String) -> Self {
        let (values, unit, median, measured_by) = (Vec::new(), "", None, None);
        Self { claim, verdict, reason: Some(reason), values, unit, median, measured_by }
    }
}

/// Whether a run's device times are those of hardware.
fn on_hardware(run: &Run) -> bool {
    run.provenance.machine.adapter.as_ref().is_some_and(|adapter| adapter.kind != "software")
}

/// Judges one claim of a paper by a run that was made for its table, or is taken for it.
pub fn judge(paper: &Paper, claim: &Claim, table: &str, rows: &Rows<'_>) -> JudgedClaim {
    let (wanted, name, scenes, rule) = match &claim.test {
        Test::NotMeasurable { not_measurable } => {
            return JudgedClaim::not_measurable(claim, not_measurable);
        }
        Test::Measured { table, quantity, scenes, rule } => (table, quantity, scenes, rule),
    };
    let quantity = paper.quantity(name).filter(|_| wanted == table);
    let about = paper.experiment(wanted).filter(|_| !scenes.is_empty()).map(|made| rows.standing_for(made, scenes));
    let values = quantity.map(|quantity| quantity.values(about.as_ref().unwrap_or(rows))).unwrap_or_default();
    let plain: Vec<f64> = values.iter().map(|value| value.value).collect();
    let (verdict, reason) = if values.is_empty() {
        let scene =
            if scenes.is_empty() { "scene".to_owned() } else { format!("scene in place of {}", scenes.join(" or ")) };
        (Verdict::NotMeasured, Some(format!("the run has no {scene} with the rows of {wanted} that it takes")))
    } else if claim.needs_hardware_raster && !on_hardware(rows.run) {
        (Verdict::NotMeasurable, Some("needs times of hardware rasterization, the adapter is software".to_owned()))
    } else if rule.holds(&plain) {
        (Verdict::Holds, None)
    } else {
        (Verdict::DoesNotHold, None)
    };
    let run = rows.run;
    let measured_by = MeasuredBy {
        table: table.to_owned(),
        machine: run.provenance.machine.label(),
        preset: run.preset.clone(),
        commit: run.provenance.commit.clone(),
        started: run.provenance.started.clone(),
    };
    JudgedClaim {
        claim: claim.clone(),
        verdict,
        reason,
        median: (!values.is_empty()).then(|| crate::statistics::median(&plain)),
        values,
        unit: quantity.map_or("", |quantity| quantity.unit),
        measured_by: Some(measured_by),
    }
}

/// Judges all claims of a paper by the runs that were made for its tables. A claim that several runs measure is judged by each;
/// one that none measures is named with the table that would.
///
/// # Errors
/// If the embedded claims are not as they should be.
pub fn judge_all(paper: &Paper, runs: &[Run]) -> Result<Vec<JudgedClaim>, DataError> {
    let mut judged = Vec::new();
    for claim in paper.claims()? {
        let table = match &claim.test {
            Test::Measured { table, .. } => table,
            Test::NotMeasurable { not_measurable } => {
                judged.push(JudgedClaim::not_measurable(&claim, not_measurable));
                continue;
            }
        };
        let before = judged.len();
        for run in runs.iter().filter(|run| run.table.as_deref() == Some(table)) {
            judged.push(judge(paper, &claim, table, &Rows::of(run)));
        }
        if judged.len() == before {
            let reason = format!("no run of `tracebench table {table}` was given");
            judged.push(JudgedClaim::without_values(claim, Verdict::NotMeasured, reason));
        }
    }
    Ok(judged)
}
