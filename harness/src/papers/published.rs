//! Values that a paper published, with hardware and scopes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What a paper printed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// The paper itself.
    pub paper: Publication,
    /// Its tables, and what captions and text state.
    pub tables: Vec<PublishedTable>,
}

/// A paper as it is cited, with how it measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Publication {
    /// Its title.
    pub title: String,
    /// Where it appeared.
    pub venue: String,
    /// When.
    pub year: u32,
    /// What it measured on.
    pub hardware: String,
    /// What holds of its measurements where nothing else is said: `name`, `value` where the paper states it, `section` and `note`.
    pub setup: Vec<BTreeMap<String, Option<String>>>,
}

/// A table, or what a figure's caption or the text states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedTable {
    /// Stable name.
    pub id: String,
    /// The paper's short name.
    pub paper: String,
    /// Where it stands there.
    pub place: String,
    /// What it tells.
    pub what: String,
    /// Its columns.
    pub columns: Vec<PublishedColumn>,
    /// Its rows; `None` where the figures stood in a picture alone and are not available.
    pub rows: Option<Vec<PublishedRow>>,
    /// What is to be known of it.
    pub notes: Vec<String>,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedColumn {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What is in it and what is not.
    pub scope: String,
}

/// A row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedRow {
    /// What it is of: scene, method and the like.
    pub labels: BTreeMap<String, String>,
    /// A value a column; `None` where there is none.
    pub values: Vec<Option<f64>>,
}

impl PublishedTable {
    /// The value in the row with these labels, in the column of this name.
    pub fn value(&self, labels: &[(&str, &str)], column: &str) -> Option<f64> {
        let index = self.columns.iter().position(|each| each.name == column)?;
        let is_row = |row: &&PublishedRow| {
            labels.iter().all(|(name, value)| row.labels.get(*name).is_some_and(|label| label == value))
        };
        self.rows.as_ref()?.iter().find(is_row)?.values.get(index).copied()?
    }
}
