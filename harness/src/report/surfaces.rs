//! What a summary says of traces that end at surfaces: whether these are right, which passes fetched them, what it took.

use itertools::Itertools as _;
use tracebench_api::{MemoryEntry, TraceTo};

use super::cells::TableRow;
use super::document::Document;
use super::format::mib;
use super::group::Role;
use super::metrics::{LOST, MATERIAL, NORMAL, NORMAL_ERROR, POSITION_ERROR_OF_SURFACE, POSITION_OF_SURFACE, SURFACES};
use super::sheet::{Sheet, Table};
use crate::results::TraceRecord;

/// Where traces end, where that is not at hits; for a heading.
pub(super) fn heading(rows: &[TableRow<'_>]) -> &'static str {
    match rows.iter().any(|(_, _, trace)| trace.trace_to == TraceTo::Surface) {
        true => ", traced to surfaces",
        false => "",
    }
}

/// Every table.
pub(super) fn tables(rows: &[TableRow<'_>]) -> Document {
    Document::default()
        .below("Surfaces of the hits that are right within a pixel:", surfaces(rows))
        .below("Phases of the traces:", phases(rows))
        .below("Memory of a trace:", trace_memory(rows))
}

fn at_surfaces(role: Role, trace: &TraceRecord) -> bool {
    role == Role::Tracer && trace.trace_to == TraceTo::Surface
}

/// What traces left beyond hits, and what all of them took.
fn surfaces(rows: &[TableRow<'_>]) -> Table {
    let rows: Vec<TableRow<'_>> = rows.iter().filter(|(.., trace)| trace.surfaces.is_some()).copied().collect();
    let all = [SURFACES, MATERIAL, NORMAL, POSITION_OF_SURFACE, LOST, NORMAL_ERROR, POSITION_ERROR_OF_SURFACE];
    Sheet::<TableRow<'_>>::new().name().figures(all).table(&rows)
}

/// What a trace takes, by its parts.
fn trace_memory(rows: &[TableRow<'_>]) -> Table {
    let has_parts = |(role, _, trace): &&TableRow<'_>| at_surfaces(*role, trace) && !trace.per_trace.is_empty();
    let rows: Vec<TableRow<'_>> = rows.iter().filter(has_parts).copied().collect();
    let sheet = Sheet::<TableRow<'_>>::new().name().column("a trace takes (MiB)", |(.., trace)| {
        let part = |part: &MemoryEntry| format!("{} {}", part.name, mib(part.allocated_bytes));
        format!("{}: {}", mib(trace.per_trace_bytes), trace.per_trace.iter().map(part).join(", "))
    });
    sheet.table(&rows)
}

/// The passes of the traces that have several.
fn phases(rows: &[TableRow<'_>]) -> Table {
    let several = |(role, _, trace): &&TableRow<'_>| at_surfaces(*role, trace) && !trace.times.phases.is_empty();
    let rows: Vec<TableRow<'_>> = rows.iter().filter(several).copied().collect();
    let sheet = Sheet::<TableRow<'_>>::new().name().phases("phases (ms)", "; ", |(.., trace)| Some(&trace.times));
    sheet.table(&rows)
}
