//! Quantities of the fragment A-buffer: what VVP16 claims, and what DIRT claims beside it.

pub(super) mod beside_dirt;
pub(super) mod memory;
pub(super) mod peers;
pub(super) mod search;
pub(super) mod variants;
pub(super) mod views;

use crate::papers::rows::SceneRows;
use crate::results::{TraceRecord, TracerRun};

/// VVP16's tracer.
pub(crate) const ABUFFER: &str = "fragment-abuffer";

/// Its row with these values, and else those of its first row.
fn row<'a>(scene: &SceneRows<'a>, values: &[(&str, &str)]) -> Option<&'a TracerRun> {
    scene.like_first(ABUFFER, values)
}

/// Median of a phase of the build, ms.
fn phase(run: &TracerRun, name: &str) -> Option<f64> {
    run.build.times.phases.iter().find(|phase| phase.name == name).map(|phase| phase.median_ms)
}

/// A counter over all rays of several sets.
pub(crate) fn counted(traces: &[&TraceRecord], counter: &str) -> Option<f64> {
    traces.iter().map(|trace| trace.counters.get(counter).map(|each| each.total as f64)).sum()
}

/// Rays of several sets.
pub(crate) fn rays(traces: &[&TraceRecord]) -> f64 {
    traces.iter().map(|trace| trace.count as f64).sum()
}
