//! What a summary says of traces that end at surfaces: whether these are right, which passes fetched them, what it took.

use tracebench_api::{EndPoint, MemoryEntry};

use super::cells::{self, Row};
use super::document::Document;
use super::format::mib;
use super::group::Role;
use super::metrics::{LOST, MATERIAL, NORMAL, NORMAL_ERROR, POSITION_ERROR_OF_SURFACE, POSITION_OF_SURFACE, SURFACES};
use super::sheet::{Sheet, Table};
use crate::results::TraceRecord;

/// Where traces end, where that is not at hits; for a heading.
pub(super) fn heading(rows: &[Row<'_>]) -> &'static str {
    match rows.iter().any(|(_, _, trace)| trace.end == EndPoint::Surface) {
        true => ", traced to surfaces",
        false => "",
    }
}

/// Every table.
pub(super) fn tables(rows: &[Row<'_>]) -> Document {
    Document::default()
        .below("Surfaces of the hits that are right within a pixel:", surfaces(rows))
        .below("Phases of the traces:", phases(rows))
        .below("Memory of a trace:", trace_memory(rows))
}

fn at_surfaces(role: Role, trace: &TraceRecord) -> bool {
    role == Role::Contender && trace.end == EndPoint::Surface
}

/// What traces left beyond hits, and what all of them took.
fn surfaces(rows: &[Row<'_>]) -> Table {
    let rows: Vec<Row<'_>> = rows.iter().filter(|(.., trace)| trace.surfaces.is_some()).copied().collect();
    let all = [SURFACES, MATERIAL, NORMAL, POSITION_OF_SURFACE, LOST, NORMAL_ERROR, POSITION_ERROR_OF_SURFACE];
    let sheet = Sheet::<Row<'_>>::new()
        .name(cells::own)
        .with(all.map(|metric| metric.of_trace(|(.., trace): &Row<'_>| Some(trace))).into());
    sheet.table(&rows)
}

/// What a trace takes, by its parts.
fn trace_memory(rows: &[Row<'_>]) -> Table {
    let has_parts = |(role, _, trace): &&Row<'_>| at_surfaces(*role, trace) && !trace.per_trace.is_empty();
    let rows: Vec<Row<'_>> = rows.iter().filter(has_parts).copied().collect();
    let sheet = Sheet::<Row<'_>>::new().name(cells::own).told("a trace takes (MiB)", |(.., trace)| {
        let part = |part: &MemoryEntry| format!("{} {}", part.name, mib(part.allocated_bytes));
        let parts: Vec<_> = trace.per_trace.iter().map(part).collect();
        format!("{}: {}", mib(trace.per_trace_bytes), parts.join(", "))
    });
    sheet.table(&rows)
}

/// The passes of the traces that have several.
fn phases(rows: &[Row<'_>]) -> Table {
    let several = |(role, _, trace): &&Row<'_>| at_surfaces(*role, trace) && !trace.times.phases.is_empty();
    let rows: Vec<Row<'_>> = rows.iter().filter(several).copied().collect();
    let sheet = Sheet::<Row<'_>>::new().name(cells::own).phases("phases (ms)", "; ", |(.., trace)| Some(&trace.times));
    sheet.table(&rows)
}
