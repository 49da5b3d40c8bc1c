//! What pages of HHZ14's tables and figures show before their rows.

use super::quantities::octree::{FRAME, pair};
use super::{OCTREE, SAMPLES};
use crate::papers::page::Page;
use crate::papers::page::measured::{TIMES, TableRow, ms_of, of_rows, over, time_of};
use crate::papers::rows::trace;
use crate::report::document::Document;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::results::{Row, TraceRecord, host_ms};

/// Table 1: what the octree takes over what the A-buffers take, beside the same of the paper.
pub(super) fn octree(page: &Page<'_>) -> Document {
    // With the first of the A-buffers in its scene.
    let rows: Vec<_> = page.all().filter_map(|row| Some((row, pair(row.0, "dda2d")?[1]))).collect();
    let build = |row: &Row| host_ms(row.build.steady());
    let traces = |row: &Row| ms_of(row, &FRAME);
    // Without an accuracy there is no time of a frame.
    let both = |row: &Row| Some(build(row)? + traces(row)?);
    let printed = |heading: &str, column: &'static str| {
        Column::new(heading, move |((_, row), first): &(TableRow<'_>, &Row)| {
            let of = |method| page.printed_of(first, &[("method", method)], column);
            if row.tracer.name == OCTREE { over(of("SVO"), of("HHZ14")) } else { Cell::None }
        })
    };
    let sheet = of_rows::<(TableRow<'_>, &Row)>(|(row, _)| *row)
        .column("build (ms) ↓", |((_, row), _)| build(row))
        .column("× A-buffers", |((_, row), first)| over(build(row), build(first)))
        .column("traces of a frame (ms) ↓", |((_, row), _)| time_of(row, &FRAME))
        .column("× A-buffers", |((_, row), first)| over(traces(row), traces(first)))
        .column("both (ms) ↓", |((_, row), _)| both(row))
        .column("× A-buffers", |((_, row), first)| over(both(row), both(first)))
        .and(printed("published: build × A-buffers", "Construction"))
        .and(printed("traces ×", "Tracing Rays"))
        .and(printed("all ×", "Total"));
    Document::of(format!("{TIMES} A frame is mirrored, refracted and shadow rays once each.")).table(sheet.table(&rows))
}

/// Figure 7: the time of a sample a pixel, over the number of samples.
pub(super) fn a_ray(page: &Page<'_>) -> Document {
    let printed = page.printed().and_then(|table| table.rows.as_ref()?.first()?.values.first().copied()?);
    let rows = page.rows.scenes.iter().flat_map(|scene| scene.by_resolution()).flat_map(|scene| scene.rows);
    let rows: Vec<(&Row, &TraceRecord)> = rows.filter_map(|row| Some((row, trace(row, SAMPLES)?))).collect();
    let times = |rays: f64| {
        move |(row, trace): &(&Row, &TraceRecord)| {
            ms_of(row, &[SAMPLES]).map(|ms| ms / trace.count.max(1) as f64 * rays)
        }
    };
    let sheet = Sheet::<(&Row, &TraceRecord)>::new()
        .column("scene", |(row, _)| Cell::Name(row.scene.name.clone()))
        .column("tracer", |(row, _)| row.label())
        .column("rays", |(_, trace)| trace.count)
        .column("all rays (ms) ↓", |(row, _)| time_of(row, &[SAMPLES]))
        .column("a million rays (ms) ↓", times(1e6))
        .column("a ray a pixel of 800x600 (ms) ↓", times(800.0 * 600.0))
        .column("published (ms)", |_| Cell::number(printed, 3));
    Document::of(format!("{TIMES} The published time is of its own hardware and stands beside no time here."))
        .table(sheet.table(&rows))
}
