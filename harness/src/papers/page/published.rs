//! What the paper printed, with hardware and scopes.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::papers::{Publication, PublishedColumn, PublishedRow, PublishedTable};
use crate::report::markdown::inline;
use crate::report::sheet::Sheet;

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
    let rows = table.rows.as_deref().unwrap_or_default();
    let mut sheet = Sheet::<PublishedRow>::new();
    for name in rows.iter().flat_map(|row| row.labels.keys()).collect::<BTreeSet<_>>() {
        sheet = sheet.told(name, move |row| row.labels.get(name).cloned().unwrap_or_default());
    }
    for (place, PublishedColumn { name, unit, .. }) in table.columns.iter().enumerate() {
        let heading = if unit.is_empty() { name.clone() } else { format!("{name} ({unit})") };
        sheet = sheet.told(heading, move |row| Some(row.values.get(place).copied()??.to_string()));
    }
    sheet.markdown(rows)
}
