//! What a summary says of traces that end at surfaces: whether these are right, which passes fetched them, what it took.

use tracebench_api::{EndPoint, MemoryEntry};

use super::cells::{Row, label};
use super::format::{NONE, mib, optional, percent, percent_with_interval, significant, thousands};
use super::group::Role;
use super::markdown::Table;
use super::metrics;
use crate::results::{Percentiles, PhaseRecord, TraceRecord};

/// Where traces end, where that is not at hits; for a heading.
pub(super) fn heading(rows: &[Row<'_>]) -> &'static str {
    match rows.iter().any(|(_, _, trace)| trace.end == EndPoint::Surface) {
        true => ", traced to surfaces",
        false => "",
    }
}

/// Every table.
pub(super) fn tables(rows: &[Row<'_>]) -> String {
    surfaces(rows) + &phases(rows) + &trace_memory(rows)
}

fn at_surfaces(role: Role, trace: &TraceRecord) -> bool {
    role == Role::Contender && trace.end == EndPoint::Surface
}

/// What traces left beyond hits, and what all of them took.
fn surfaces(rows: &[Row<'_>]) -> String {
    let mut table = Table::new(&[
        "tracer".to_owned(),
        metrics::SURFACES.heading(),
        "material ↑".to_owned(),
        "normal ↑".to_owned(),
        "position ↑".to_owned(),
        "lost (rays) ↓".to_owned(),
        "normal error p50 / p95 / p99 (degrees) ↓".to_owned(),
        "position error p50 / p95 / p99 (scene units) ↓".to_owned(),
    ]);
    let mut any = false;
    for (role, run, trace) in rows {
        let Some(judged) = &trace.surfaces else { continue };
        any = true;
        let of_judged = |value: Option<f64>| {
            value.map_or_else(|| NONE.to_owned(), |value| format!("{} %", percent(value, judged.judged)))
        };
        let errors = |errors: Percentiles| {
            format!("{} / {} / {}", optional(errors.p50, 3), optional(errors.p95, 3), optional(errors.p99, 3))
        };
        table.row(&[
            label(*role, run),
            judged.agreement.map_or_else(
                || NONE.to_owned(),
                |agreement| percent_with_interval(agreement, judged.interval, judged.judged),
            ),
            of_judged(judged.material),
            of_judged(judged.normal),
            of_judged(judged.position),
            thousands(judged.lost),
            errors(judged.normal_error_degrees),
            errors(judged.position_error),
        ]);
    }
    if any { format!("\nSurfaces of the hits that are right within a pixel:\n\n{}", table.text) } else { String::new() }
}

/// What a trace takes, by its parts.
fn trace_memory(rows: &[Row<'_>]) -> String {
    let mut table = Table::new(&["tracer", "a trace takes (MiB)"].map(str::to_owned));
    let mut any = false;
    for (role, run, trace) in rows.iter().filter(|(role, _, trace)| at_surfaces(*role, trace)) {
        let part = |part: &MemoryEntry| format!("{} {}", part.name, mib(part.allocated_bytes));
        let parts: Vec<_> = trace.per_trace.iter().map(part).collect();
        if !parts.is_empty() {
            table.row(&[label(*role, run), format!("{}: {}", mib(trace.per_trace_bytes), parts.join(", "))]);
            any = true;
        }
    }
    if any { format!("\nMemory of a trace:\n\n{}", table.text) } else { String::new() }
}

/// The passes of the traces that have several.
fn phases(rows: &[Row<'_>]) -> String {
    let mut table = Table::new(&["tracer", "phases (ms)"].map(str::to_owned));
    let mut any = false;
    for (role, run, trace) in
        rows.iter().filter(|(role, _, trace)| at_surfaces(*role, trace) && !trace.times.phases.is_empty())
    {
        let phase = |phase: &PhaseRecord| format!("{} {}", phase.name, significant(phase.median_ms, 3));
        table.row(&[label(*role, run), trace.times.phases.iter().map(phase).collect::<Vec<_>>().join("; ")]);
        any = true;
    }
    if any { format!("\nPhases of the traces:\n\n{}", table.text) } else { String::new() }
}
