//! Files that quotes look into, as JSON: records as they are, the tables of pages by heading, comma-separated values by row.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::report::unpacked;

/// What was read, each file once.
pub(super) struct Sources {
    pub(super) root: PathBuf,
    read: BTreeMap<String, Value>,
}

impl Sources {
    pub(super) fn new(root: &Path) -> Self {
        Self { root: root.to_owned(), read: BTreeMap::new() }
    }

    /// A file by its path from the root.
    pub(super) fn file(&mut self, name: &str) -> Result<&Value, String> {
        if !self.read.contains_key(name) {
            let value = read(&self.root.join(name)).map_err(|reason| format!("{name}: {reason}"))?;
            self.read.insert(name.to_owned(), value);
        }
        Ok(&self.read[name])
    }
}

fn read(path: &Path) -> Result<Value, String> {
    let bytes = unpacked(path).map_err(|error| error.to_string())?;
    let ends = |ending: &str| path.extension().is_some_and(|found| found == ending);
    if ends("gz") || ends("json") {
        return serde_json::from_slice(&bytes).map_err(|error| error.to_string());
    }
    let text = String::from_utf8(bytes).map_err(|error| error.to_string())?;
    match () {
        () if ends("md") => Ok(tables(&text)),
        () if ends("csv") => values(&text),
        () => Err("is neither .json, .json.gz, .md nor .csv".to_owned()),
    }
}

/// The tables of a page: of each the headings that it stands below, joined by " > ", and its rows by column.
fn tables(text: &str) -> Value {
    let mut headings: Vec<&str> = Vec::new();
    let mut tables: Vec<Value> = Vec::new();
    let mut columns: Option<Vec<String>> = None;
    for line in text.lines() {
        let marks = line.chars().take_while(|mark| *mark == '#').count();
        if marks > 0 && line[marks..].starts_with(' ') {
            headings.truncate(marks - 1);
            headings.push(line[marks..].trim());
        }
        let Some(cells) = line.strip_prefix("| ").and_then(|line| line.strip_suffix(" |")) else {
            columns = None;
            continue;
        };
        let cells: Vec<String> = cells.split(" | ").map(|cell| cell.trim().to_owned()).collect();
        match &columns {
            None => {
                tables.push(json!({ "heading": headings.join(" > "), "rows": [] }));
                columns = Some(cells);
            }
            Some(_) if cells.iter().all(|cell| cell.chars().all(|mark| mark == '-')) => {}
            Some(columns) => {
                let row: Map<String, Value> =
                    columns.iter().cloned().zip(cells.into_iter().map(Value::String)).collect();
                if let Some(rows) = tables.last_mut().and_then(|table| table["rows"].as_array_mut()) {
                    rows.push(Value::Object(row));
                }
            }
        }
    }
    Value::Array(tables)
}

fn values(text: &str) -> Result<Value, String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows: Result<Vec<BTreeMap<String, String>>, csv::Error> = reader.deserialize().collect();
    Ok(json!(rows.map_err(|error| error.to_string())?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of a page are found by their headings and their rows by column; what follows a table is another one.
    #[test]
    fn tables_of_pages_are_read() {
        let page = "# A\n\n## B\n\n| name | share |\n| --- | --- |\n| x | 3 % |\n| y | – |\n\n## C\n\n| name |\n| --- |\n| z |\n\ntext | no table |\n";
        let found = tables(page);
        assert_eq!(
            found,
            json!([
                { "heading": "A > B", "rows": [{ "name": "x", "share": "3 %" }, { "name": "y", "share": "–" }] },
                { "heading": "A > C", "rows": [{ "name": "z" }] },
            ])
        );
        assert_eq!(values("a,b\n1,\"x,y\"\n").unwrap(), json!([{ "a": "1", "b": "x,y" }]));
    }
}
