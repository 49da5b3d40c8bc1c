//! The little of Markdown that the summary needs.

use std::fmt::Write as _;

/// Text that cannot end its line or be taken for markup of a table.
pub(crate) fn inline(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|").replace('<', "&lt;")
}

/// A table in Markdown.
pub(crate) struct Table {
    /// The rows so far.
    pub text: String,
}

impl Table {
    /// A table with its headings.
    pub(crate) fn new(headings: &[String]) -> Self {
        let mut table = Self { text: String::new() };
        table.row(headings);
        let _ = writeln!(table.text, "|{}", " --- |".repeat(headings.len()));
        table
    }

    /// Adds a row.
    pub(crate) fn row(&mut self, cells: &[String]) {
        for cell in cells {
            let _ = write!(self.text, "| {} ", inline(cell));
        }
        self.text.push_str("|\n");
    }
}
