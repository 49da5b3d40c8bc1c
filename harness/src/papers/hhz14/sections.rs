//! What pages of HHZ14's tables and figures show before their rows.

use super::OCTREE;
use super::quantities::octree::{FRAME, pair};
use crate::papers::page::Page;
use crate::papers::page::measured::{Row, TIMES, ms_of, of_rows, over, time_of};
use crate::papers::rows::trace;
use crate::report::document::Document;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::results::{TraceRecord, TracerRun, host_ms};

/// Table 1: what the octree takes over what the A-buffers take, beside the same of the paper.
pub(super) fn octree(page: &Page<'_>) -> Document {
    // With the first of the A-buffers in its scene.
    let rows: Vec<_> = page.all().filter_map(|row| Some((row, pair(row.0)?[1]))).collect();
    let build = |run: &TracerRun| host_ms(run.build.steady());
    let traces = |run: &TracerRun| ms_of(run, &FRAME);
    // Without an accuracy there is no time of a frame.
    let both = |run: &TracerRun| Some(build(run)? + traces(run)?);
    let printed = |heading: &str, column: &'static str| {
        Column::told(heading, move |((_, run), first): &(Row<'_>, &TracerRun)| {
            let of = |method| page.printed_of(first, &[("method", method)], column);
            if run.tracer.name == OCTREE { over(of("SVO"), of("HHZ14")) } else { Cell::None }
        })
    };
    let sheet = of_rows::<(Row<'_>, &TracerRun)>(|(row, _)| *row)
        .told("build (ms) ↓", |((_, run), _)| build(run))
        .told("× A-buffers", |((_, run), first)| over(build(run), build(first)))
        .told("traces of a frame (ms) ↓", |((_, run), _)| time_of(run, &FRAME))
        .told("× A-buffers", |((_, run), first)| over(traces(run), traces(first)))
        .told("both (ms) ↓", |((_, run), _)| both(run))
        .told("× A-buffers", |((_, run), first)| over(both(run), both(first)))
        .and(printed("published: build × A-buffers", "Construction"))
        .and(printed("traces ×", "Tracing Rays"))
        .and(printed("all ×", "Total"));
    Document::of(format!("{TIMES} A frame is mirrored, refracted and shadow rays once each.")).table(sheet.table(&rows))
}

/// Figure 7: the time of a ray a pixel, over the number of rays.
pub(super) fn a_ray(page: &Page<'_>) -> Document {
    let printed = page.printed().and_then(|table| table.rows.as_ref()?.first()?.values.first().copied()?);
    let runs = page.rows.scenes.iter().flat_map(|scene| scene.by_resolution()).flat_map(|scene| scene.runs);
    let rows: Vec<(&TracerRun, &TraceRecord)> = runs.filter_map(|run| Some((run, trace(run, "ao")?))).collect();
    let times = |rays: f64| {
        move |(run, trace): &(&TracerRun, &TraceRecord)| {
            ms_of(run, &["ao"]).map(|ms| ms / trace.count.max(1) as f64 * rays)
        }
    };
    let sheet = Sheet::<(&TracerRun, &TraceRecord)>::new()
        .told("scene", |(run, _)| Cell::Name(run.scene.name.clone()))
        .told("tracer", |(run, _)| run.label())
        .told("rays", |(_, trace)| trace.count)
        .told("all rays (ms) ↓", |(run, _)| time_of(run, &["ao"]))
        .told("a million rays (ms) ↓", times(1e6))
        .told("a ray a pixel of 800x600 (ms) ↓", times(800.0 * 600.0))
        .told("published (ms)", |_| Cell::number(printed, 3));
    Document::of(format!("{TIMES} The published time is of its own hardware and stands beside no time here."))
        .table(sheet.table(&rows))
}
