//! A tracer beside every other one of a table.

use super::Page;
use super::measured::{TIMES, ms_of, over_first, time_of};
use crate::papers::{SceneRows, Scope};
use crate::report::document::Document;
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Sheet};
use crate::results::{Row, host_ms};

/// Times of every row, as ratios to the first of the same resolution.
pub(super) fn by_part(page: &Page<'_>) -> Document {
    let mut section = Document::of(format!("{TIMES} Ratios are to the first row of a part."));
    for scene in page.rows.scenes.iter().flat_map(SceneRows::by_resolution) {
        let Some(first) = scene.rows.first().copied() else { continue };
        let mut sheet = Sheet::<&Row>::new().column("tracer", |row| row.label());
        for set in scene.ray_sets() {
            let trace = move |row: &Row| ms_of(row, &[set]);
            sheet = sheet
                .column(format!("{set} (ms) ↓"), move |row| time_of(row, &[set]))
                .and(over_first("ratio", first, trace));
        }
        let name = page.experiment.stands_for(&first.scene).map_or_else(String::new, |name| format!(" for {name}"));
        let [[width, height], [columns, lines]] = [first.viewpoint.ray_image, first.viewpoint.frame];
        let (label, face) = (literal(&scene.label), first.viewpoint.face);
        section = section
            .paragraph(format!("**{label}**{name}, rays from {width}x{height}, frame {columns}x{lines}, faces {face}"))
            .table(sheet.table(&scene.rows));
    }
    section
}

/// Build and traces of every row, with ratios to the first of a tracer.
pub(super) fn beside(page: &Page<'_>, reference: &str) -> Document {
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
