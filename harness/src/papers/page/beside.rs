//! A tracer beside every other one of a table.

use super::Page;
use super::measured::{TIMES, ms_of, over_first, time_of};
use crate::papers::Scope;
use crate::report::document::Document;
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Sheet};
use crate::results::{TracerRun, host_ms};

/// Build and traces of every row, with ratios to the first of a tracer.
pub(in crate::papers) fn beside(page: &Page<'_>, reference: &str) -> Document {
    let mut section = Document::of(format!("{TIMES} Ratios are to the first row of {reference} in a scene."));
    let build = |run: &TracerRun| host_ms(run.build.steady());
    for scene in &page.rows.scenes {
        let Some(first) = scene.like_first(reference, &[]) else { continue };
        let mut sheet = Sheet::<&TracerRun>::new().told("tracer", |run| run.label());
        for (scope, heading) in Scope::ALL {
            let bytes = move |run: &TracerRun| page.paper.bytes(run, scope);
            sheet = sheet.told(heading, move |run| bytes(run).map(Cell::Bytes)).and(over_first("ratio", first, bytes));
        }
        sheet = sheet.told("build (ms) ↓", move |run| build(run)).and(over_first("ratio", first, build));
        for set in scene.ray_sets() {
            let trace = move |run: &TracerRun| ms_of(run, &[set]);
            sheet = sheet
                .told(format!("{set} (ms) ↓"), move |run| time_of(run, &[set]))
                .and(over_first("ratio", first, trace))
                .and(over_first("build and trace: ratio", first, move |run| Some(trace(run)? + build(run)?)));
        }
        section = section.words(format!("**{}**", literal(&scene.label))).table(sheet.table(&scene.runs));
    }
    section
}
