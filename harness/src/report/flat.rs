//! `report --csv`: the rows of several records as one table.

use std::path::PathBuf;

use itertools::Itertools as _;

use super::html::called;
use super::sheet::{self, Cell, Sheet};
use super::{ReportError, Study, group, read_run, tables};
use crate::results::Row;

/// The rows of records, those of controls among them, as `rows.csv` has those of one, with the record's name, its study and of cases the
/// difficulty level. A column is where a record has it; other rows are empty there.
///
/// # Errors
/// If a record cannot be read.
pub fn flat_table(paths: &[PathBuf], say: impl Fn(&str)) -> Result<Vec<u8>, ReportError> {
    let shown: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let names = called(&shown.iter().map(String::as_str).collect::<Vec<_>>());
    let mut columns: Vec<String> = ["record", "study"].map(str::to_owned).into();
    let mut rows: Vec<Vec<String>> = Vec::new();
    for ((path, shown), name) in paths.iter().zip(&shown).zip(names) {
        say(shown);
        let record = read_run(path)?;
        let record = &*record.aligned();
        let level = |row: &&Row| row.difficulty_level.map_or(Cell::Absent, Cell::from);
        let groups = group::groups(record);
        let own = Sheet::new().csv_column("difficulty_level", level);
        let table = tables::rows(record, &groups, own, |(.., (_, row, _))| Some(*row)).csv(&name)?;
        let mut lines = csv::ReaderBuilder::new().has_headers(false).from_reader(&*table).into_records().flatten();
        let header = lines.next().unwrap_or_default();
        columns = columns.into_iter().chain(header.iter().map(str::to_owned)).unique().collect();
        let place = |name: &str| columns.iter().position(|known| known == name);
        let places: Vec<usize> = header.iter().filter_map(place).collect();
        rows.extend(lines.map(|line| {
            let mut row = vec![String::new(); columns.len()];
            (row[0], row[1]) = (name.clone(), Study::of(record).verb.to_owned());
            places.iter().zip(&line).for_each(|(place, field)| field.clone_into(&mut row[*place]));
            row
        }));
    }
    rows.iter_mut().for_each(|row| row.resize(columns.len(), String::new()));
    sheet::csv("the table of rows", std::iter::once(columns).chain(rows))
}
