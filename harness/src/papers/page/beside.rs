//! A tracer beside every other one of a table.

use super::Page;
use super::measured::{TIMES, ms_of, over_first, time_of};
use crate::papers::Scope;
use crate::report::document::Document;
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Sheet};
use crate::results::{Row, host_ms};

/// Build and traces of every row, with ratios to the first of a tracer.
pub(in crate::papers) fn beside(page: &Page<'_>, reference: &str) -> Document {
    let mut section = Document::of(format!("{TIMES} Ratios are to the first row of {reference} in a scene."));
    let build = |row: &Row| host_ms(row.build.steady());
    for scene in &page.rows.scenes {
        let Some(first) = scene.like_first(reference, &[]) else { continue };
        let mut sheet = Sheet::<&Row>::new().column("tracer", |row| row.label());
        for (scope, heading) in Scope::ALL {
            let bytes = move |row: &Row| page.paper.bytes(row, scope);
            sheet =
                sheet.column(heading, move |row| bytes(row).map(Cell::Bytes)).and(over_first("ratio", first, bytes));
        }
        sheet = sheet.column("build (ms) ↓", move |row| build(row)).and(over_first("ratio", first, build));
        for set in scene.ray_sets() {
            let trace = move |row: &Row| ms_of(row, &[set]);
            sheet = sheet
                .column(format!("{set} (ms) ↓"), move |row| time_of(row, &[set]))
                .and(over_first("ratio", first, trace))
                .and(over_first("build and trace: ratio", first, move |row| Some(trace(row)? + build(row)?)));
        }
        section = section.paragraph(format!("**{}**", literal(&scene.label))).table(sheet.table(&scene.rows));
    }
    section
}
