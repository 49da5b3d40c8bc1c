//! Standard output.

use std::io::{ErrorKind, Write as _};
use std::path::Path;

use serde_json::Value;

use super::CliError;

/// Writes a text that ends in a line break. A reader that has gone away (`| head`) has seen what it wanted; a full disk
/// is an error.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(CliError::Other(format!("cannot write to standard output: {error}; send it elsewhere")))
        }
        _ => Ok(()),
    }
}

/// Prints a value as JSON.
pub(super) fn print_json(value: &Value) -> Result<(), CliError> {
    print(&format!("{value:#}\n"))
}

/// Prints a page that was written, and where it is.
pub(super) fn print_page(page: &Path) -> Result<(), CliError> {
    let text = std::fs::read_to_string(page)
        .map_err(|error| CliError::Other(format!("cannot read {}: {error}", page.display())))?;
    print(&format!("{text}\n{}\n", page.display()))
}
