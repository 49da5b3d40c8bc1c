//! What decides VVP16's claims.

pub(super) mod memory;
pub(super) mod peers;
pub(super) mod search;
pub(super) mod variants;
mod views;

use crate::papers::Quantity;
use crate::results::TraceRecord;

/// All of them.
pub(super) const QUANTITIES: &[&[Quantity]] =
    &[search::QUANTITIES, memory::QUANTITIES, peers::QUANTITIES, variants::QUANTITIES, views::QUANTITIES];

/// A counter over all rays of several sets.
pub(super) fn counted(traces: &[&TraceRecord], counter: &str) -> Option<f64> {
    traces.iter().map(|trace| trace.counters.get(counter).map(|each| each.total as f64)).sum()
}

/// Rays of several sets.
pub(super) fn rays(traces: &[&TraceRecord]) -> f64 {
    traces.iter().map(|trace| trace.count as f64).sum()
}
