//! What decides VVP16's claims.

pub(super) mod memory;
mod peers;
pub(super) mod search;
pub(super) mod variants;
mod views;

use crate::papers::Quantity;
use crate::results::{TraceRecord, TracerRun};

/// All of them.
pub(super) const QUANTITIES: &[&[Quantity]] =
    &[search::QUANTITIES, memory::QUANTITIES, peers::QUANTITIES, variants::QUANTITIES, views::QUANTITIES];

/// Median of a phase of the build, ms.
fn phase(run: &TracerRun, name: &str) -> Option<f64> {
    run.build.times.phases.iter().find(|phase| phase.name == name).map(|phase| phase.median_ms)
}

/// A counter over all rays of several sets.
pub(super) fn counted(traces: &[&TraceRecord], counter: &str) -> Option<f64> {
    traces.iter().map(|trace| trace.counters.get(counter).map(|each| each.total as f64)).sum()
}

/// Rays of several sets.
pub(super) fn rays(traces: &[&TraceRecord]) -> f64 {
    traces.iter().map(|trace| trace.count as f64).sum()
}
