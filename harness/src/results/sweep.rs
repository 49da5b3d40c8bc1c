//! What `run.json` says of a sweep: which runs are its points.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Row;

/// A sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepRecord {
    /// The tracer.
    pub tracer: String,
    /// Whether all values of the parameters were combined, rather than one changed at a time.
    pub grid: bool,
    /// What was swept.
    pub axes: Vec<AxisRecord>,
    /// What was asked for, each once. The first one has every axis at the tracer's own value.
    pub points: Vec<PointRecord>,
}

/// A parameter that was swept, or `resolution`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisRecord {
    /// Name.
    pub name: String,
    /// Unit; empty for names and pure numbers.
    pub unit: String,
    /// What it does, in one line.
    pub effect: String,
    /// The tracer's own value: the preset's, or what `--set` says.
    pub own: String,
    /// Every value in order, the own one among them.
    pub values: Vec<String>,
}

/// A point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointRecord {
    /// The value on every axis, by its name.
    pub values: BTreeMap<String, String>,
    /// Every parameter of the tracer.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Width and height of the viewpoint's frame, pixels.
    pub frame: [u32; 2],
    /// Edge of the viewpoint's cube faces, pixels.
    pub face: u32,
    /// Scenes in which it could not be measured, with the reason.
    pub skipped: BTreeMap<String, String>,
}

impl PointRecord {
    /// Whether a run is this point's.
    pub fn is_of(&self, row: &Row) -> bool {
        row.tracer.parameters == self.parameters && (row.viewpoint.frame, row.viewpoint.face) == (self.frame, self.face)
    }

    /// What it has on the axes as `name=value`, without those where it has the tracer's own.
    pub fn label(&self, axes: &[AxisRecord]) -> String {
        let value = |axis: &AxisRecord| self.values.get(&axis.name).filter(|value| **value != axis.own).cloned();
        let parts = axes.iter().filter_map(|axis| Some(format!("{}={}", axis.name, value(axis)?)));
        parts.collect::<Vec<_>>().join(" ")
    }
}

impl SweepRecord {
    /// The point with a value on one axis, and with `others` on some further ones; the tracer's own value on the rest.
    pub fn point(&self, axis: &str, value: &str, others: &[(&str, &str)]) -> Option<&PointRecord> {
        let wanted = |each: &AxisRecord| {
            let other = others.iter().find(|(name, _)| *name == each.name).map(|(_, value)| *value);
            if each.name == axis { value.to_owned() } else { other.unwrap_or(&each.own).to_owned() }
        };
        self.points.iter().find(|point| {
            self.axes.iter().all(|each| point.values.get(&each.name).is_some_and(|value| *value == wanted(each)))
        })
    }
}
