//! What a summary says of hits beyond whether they are right: how far they are from the mesh; and of traces that end at surfaces, whether these are
//! right, which passes fetched them, what it took.

use itertools::Itertools as _;
use tracebench_api::{MemoryEntry, TraceTo};

use super::cells::TableRow;
use super::document::Document;
use super::format::{mib, significant};
use super::group::Role;
use super::metrics::{
    self, LOST, MATERIAL, NORMAL, NORMAL_ERROR, POSITION_ERROR_OF_SURFACE, POSITION_OF_SURFACE, SURFACE_DISTANCE,
    SURFACES, WITHIN_OWN_TEXEL, WITHIN_TEXEL,
};
use super::sheet::{Cell, Sheet, Table};
use crate::results::{PieceDistance, SurfaceDistance, TraceRecord};

/// Pieces of mesh that a table shows of each tracer.
const SHOWN_PIECES: usize = 6;

/// Where traces end, where that is not at hits; for a heading.
pub(super) fn heading(rows: &[TableRow<'_>]) -> &'static str {
    match rows.iter().any(|(_, _, trace)| trace.trace_to == TraceTo::Surface) {
        true => ", traced to surfaces",
        false => "",
    }
}

/// Every table.
pub(super) fn tables(rows: &[TableRow<'_>]) -> Document {
    let of = |has: fn(&TraceRecord) -> bool| rows.iter().copied().filter(|(.., trace)| has(trace)).collect_vec();
    let at_surfaces = |has: fn(&TraceRecord) -> bool| {
        let is_there = |(role, _, trace): &TableRow<'_>| *role == Role::Tracer && trace.trace_to == TraceTo::Surface;
        of(has).into_iter().filter(is_there).collect_vec()
    };
    let all = [SURFACES, MATERIAL, NORMAL, POSITION_OF_SURFACE, LOST, NORMAL_ERROR, POSITION_ERROR_OF_SURFACE];
    let surfaces = Sheet::<TableRow<'_>>::new().name().figures(all);
    let phases = Sheet::<TableRow<'_>>::new().name().phases("phases (ms)", "; ", |(.., trace)| Some(&trace.times));
    let memory = Sheet::<TableRow<'_>>::new().name().column("a trace takes (MiB)", |(.., trace)| {
        let part = |part: &MemoryEntry| format!("{} {}", part.name, mib(part.allocated_bytes));
        format!("{}: {}", mib(trace.per_trace_bytes), trace.per_trace.iter().map(part).join(", "))
    });
    distances(rows)
        .below(
            "Surfaces of the hits that are right within a pixel:",
            surfaces.table(&of(|trace| trace.surfaces.is_some())),
        )
        .below("Phases of the traces:", phases.table(&at_surfaces(|trace| !trace.times.phases.is_empty())))
        .below("Memory of a trace:", memory.table(&at_surfaces(|trace| !trace.per_trace.is_empty())))
}

/// How far told hits are from the mesh: texels are the measure that a method with images along axes is built for. Nothing where no tracer has texels
/// of its own.
fn distances(rows: &[TableRow<'_>]) -> Document {
    let told: Vec<(TableRow<'_>, &SurfaceDistance)> = rows
        .iter()
        .filter(|row| row.0 == Role::Tracer)
        .filter_map(|row| Some((*row, metrics::distance(row.2)?)))
        .collect();
    if told.iter().all(|(_, told)| told.own_texel.is_none()) {
        return Document::default();
    }
    let sheet = Sheet::<Told<'_>>::new()
        .name()
        .column("rays with a true hit", |(_, told)| told.rays)
        .figures([WITHIN_TEXEL, WITHIN_OWN_TEXEL])
        .column("its texel (scene units)", |(_, told)| told.own_texel.map(|texel| Cell::Number(texel, 3)))
        .figures([SURFACE_DISTANCE]);
    let common = told.first().map_or(0.0, |(_, told)| told.common_texel);
    let words = format!(
        "Told hits by their distance from the connected piece of mesh that is truly hit; a common texel is {} scene units:",
        significant(common, 3)
    );
    Document::of(words)
        .table(sheet.table(&told))
        .paragraph("The pieces of mesh that most rays truly hit, and what is left without each:")
        .table(pieces(&told))
}

/// A trace with how far its hits are off.
type Told<'a> = (TableRow<'a>, &'a SurfaceDistance);

/// The pieces that have the most rays, of tracers with texels of their own.
fn pieces(told: &[Told<'_>]) -> Table {
    type Piece<'a> = (Told<'a>, &'a PieceDistance);
    let with_texels = told.iter().filter(|(_, told)| told.own_texel.is_some());
    let rows = with_texels.flat_map(|told| told.1.pieces.iter().take(SHOWN_PIECES).map(move |piece| (*told, piece)));
    let share = |within: Option<f64>, rays: u64| {
        within.filter(|_| rays > 0).map(|within| Cell::Share(within / rays as f64, None, rays))
    };
    let within = |piece: &PieceDistance| piece.within_own_texel_rays.map(|within| within as f64);
    let within_others = move |told: &SurfaceDistance, piece: &PieceDistance| {
        Some((told.within_own_texel? * told.rays as f64).round() - within(piece)?)
    };
    let sheet = Sheet::<Piece<'_>>::new()
        .name()
        .column("piece (first triangle)", |(.., piece)| piece.first_triangle)
        .column("triangles", |(.., piece)| piece.triangles)
        .column("mean thickness (scene units)", |(.., piece)| match piece.open {
            true => Cell::from("open"),
            false => piece.mean_thickness.map(|thickness| Cell::Number(thickness, 3)).into(),
        })
        .column("rays", |(.., piece)| piece.rays)
        .column("within its own texel ↑", move |(.., piece)| share(within(piece), piece.rays))
        .column("rays that hit other pieces ↑", move |((_, told), piece)| {
            share(within_others(told, piece), told.rays - piece.rays)
        });
    sheet.table(&rows.collect::<Vec<_>>())
}
