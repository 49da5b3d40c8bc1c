//! What the paper printed, with hardware and scopes.

use std::collections::BTreeSet;

use crate::papers::{Publication, PublishedColumn, PublishedRow, PublishedTable};
use crate::report::document::Document;
use crate::report::sheet::{Sheet, Table};
use crate::results::gathered;

/// The published tables beside which an experiment stands.
pub(super) fn section(paper: &Publication, tables: &[&PublishedTable]) -> Document {
    let Publication { title, venue, year, hardware, .. } = paper;
    let page = Document::default()
        .heading(2, "Published")
        .paragraph(format!("{title}, {venue} {year}. Measured on: {hardware}."));
    if tables.is_empty() {
        return page.paragraph("The claims below are all that is stated.");
    }
    page.and(tables.iter().map(|table| {
        let page = Document::of(format!("**{}**: {}.", table.place, table.what));
        let page = match &table.rows {
            None => page.paragraph("The figure is not available: its numbers stood in a picture alone."),
            Some(all) => page.table(rows(table, all)),
        };
        // Columns may share a scope.
        let scoped = table.columns.iter().filter(|column| !column.scope.is_empty());
        let scopes = gathered(scoped.map(|column| (&column.scope, column.name.as_str()))).into_iter();
        let scopes = scopes.map(|(scope, names)| format!("{}: {scope}.", names.join(", ")));
        page.paragraphs(scopes.chain(table.notes.iter().cloned()))
    }))
}

fn rows(table: &PublishedTable, rows: &[PublishedRow]) -> Table {
    let mut sheet = Sheet::<PublishedRow>::new();
    for name in rows.iter().flat_map(|row| row.labels.keys()).collect::<BTreeSet<_>>() {
        sheet = sheet.column(name, move |row| row.labels.get(name).cloned().unwrap_or_default());
    }
    for (place, PublishedColumn { name, unit, .. }) in table.columns.iter().enumerate() {
        let heading = if unit.is_empty() { name.clone() } else { format!("{name} ({unit})") };
        sheet = sheet.column(heading, move |row| Some(row.values.get(place).copied()??.to_string()));
    }
    sheet.table(rows)
}
