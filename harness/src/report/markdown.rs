//! The little of Markdown that pages need beside tables, which `sheet.rs` writes.

/// Text that cannot end its line or be taken for markup of a table.
pub(crate) fn inline(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|").replace('<', "&lt;")
}
