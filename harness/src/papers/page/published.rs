//! What the paper printed, with hardware and scopes.

use std::collections::BTreeSet;

use crate::papers::{Publication, PublishedColumn, PublishedRow, PublishedTable};
use crate::report::document::Document;
use crate::report::sheet::{Sheet, Table};

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
        let scopes = scopes(table).into_iter().map(|(names, scope)| format!("{}: {scope}.", names.join(", ")));
        page.paragraphs(scopes.chain(table.notes.iter().cloned()))
    }))
}

/// Scopes with the columns that share them.
fn scopes(table: &PublishedTable) -> Vec<(Vec<&str>, &str)> {
    let mut scopes: Vec<(Vec<&str>, &str)> = Vec::new();
    for column in table.columns.iter().filter(|column| !column.scope.is_empty()) {
        match scopes.iter_mut().find(|(_, scope)| *scope == column.scope) {
            Some((names, _)) => names.push(&column.name),
            None => scopes.push((vec![&column.name], &column.scope)),
        }
    }
    scopes
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
