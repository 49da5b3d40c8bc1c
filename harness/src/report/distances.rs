//! What a summary says of how far told hits are from the mesh, of sets that a tracer with images along axes answers: its texels are
//! the measure that such a method is built for.

use super::cells::TableRow;
use super::document::Document;
use super::format::significant;
use super::group::Role;
use super::metrics::{self, SURFACE_DISTANCE, WITHIN_OWN_TEXEL, WITHIN_TEXEL};
use super::sheet::{Cell, Sheet, Table};
use crate::results::{PieceDistance, SurfaceDistance};

/// Pieces of mesh that a table shows of each tracer.
const SHOWN_PIECES: usize = 6;

/// Every table; nothing where no tracer has texels of its own.
pub(super) fn tables(rows: &[TableRow<'_>]) -> Document {
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
    let mut rows: Vec<(TableRow<'_>, &SurfaceDistance, &PieceDistance)> = Vec::new();
    for (row, told) in told.iter().filter(|(_, told)| told.own_texel.is_some()) {
        rows.extend(told.pieces.iter().take(SHOWN_PIECES).map(|piece| (*row, *told, piece)));
    }
    let share = |within: Option<f64>, rays: u64| {
        within.filter(|_| rays > 0).map(|within| Cell::Share(within / rays as f64, None, rays))
    };
    let within = |piece: &PieceDistance| piece.within_own_texel_rays.map(|within| within as f64);
    let within_others = move |told: &SurfaceDistance, piece: &PieceDistance| {
        Some((told.within_own_texel? * told.rays as f64).round() - within(piece)?)
    };
    let sheet = Sheet::<(TableRow<'_>, &SurfaceDistance, &PieceDistance)>::new()
        .name()
        .column("piece (first triangle)", |(.., piece)| piece.first_triangle)
        .column("triangles", |(.., piece)| piece.triangles)
        .column("mean thickness (scene units)", |(.., piece)| match piece.open {
            true => Cell::from("open"),
            false => piece.mean_thickness.map(|thickness| Cell::Number(thickness, 3)).into(),
        })
        .column("rays", |(.., piece)| piece.rays)
        .column("within its own texel ↑", move |(.., piece)| share(within(piece), piece.rays))
        .column("rays that hit other pieces ↑", move |(_, told, piece)| {
            share(within_others(told, piece), told.rays - piece.rays)
        });
    sheet.table(&rows)
}
