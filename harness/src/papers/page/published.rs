//! What the paper printed, with hardware and scopes.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::papers::{Publication, PublishedTable};
use crate::report::format::NONE;
use crate::report::markdown::{Table, inline};

/// The published tables beside which an experiment stands.
pub(super) fn section(paper: &Publication, tables: &[&PublishedTable]) -> String {
    let mut text = format!(
        "\n## Published\n\n{}, {} {}. Measured on: {}.\n",
        inline(&paper.title),
        inline(&paper.venue),
        paper.year,
        inline(&paper.hardware)
    );
    if tables.is_empty() {
        text += "\nThe claims below are all that is stated.\n";
    }
    for table in tables {
        let _ = writeln!(text, "\n**{}**: {}.\n", inline(&table.place), inline(&table.what));
        match &table.rows {
            None => text += "The figure is not available: its numbers stood in a picture alone.\n",
            Some(_) => text += &rows(table),
        }
        for (names, scope) in scopes(table) {
            let _ = writeln!(text, "\n{}: {}.", inline(&names.join(", ")), inline(scope));
        }
        for note in &table.notes {
            let _ = writeln!(text, "\n{}", inline(note));
        }
    }
    text
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

fn rows(table: &PublishedTable) -> String {
    let rows = table.rows.iter().flatten();
    let names: BTreeSet<&String> = rows.clone().flat_map(|row| row.labels.keys()).collect();
    let column = |name: &str, unit: &str| if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") };
    let mut headings: Vec<String> = names.iter().map(|name| (*name).clone()).collect();
    headings.extend(table.columns.iter().map(|each| column(&each.name, &each.unit)));
    let mut text = Table::new(&headings);
    for row in rows {
        let mut cells: Vec<String> =
            names.iter().map(|name| row.labels.get(*name).cloned().unwrap_or_default()).collect();
        cells.extend(row.values.iter().map(|value| value.map_or_else(|| NONE.to_owned(), |value| value.to_string())));
        text.row(&cells);
    }
    text.text
}
