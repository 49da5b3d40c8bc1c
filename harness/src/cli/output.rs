//! Standard output.

use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{CliError, fail};

/// The most lines that a verb ends with.
const MAX_LINES: usize = 25;

/// Writes a text that ends in a line break. A reader that has gone away (`| head`) has seen what it wanted; a full disk
/// is an error.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            fail(format!("cannot write to standard output: {error}; send it elsewhere"))
        }
        _ => Ok(()),
    }
}

/// Prints a value as JSON.
pub(super) fn print_json(value: &Value) -> Result<(), CliError> {
    print(&format!("{value:#}\n"))
}

/// Prints a text of which nothing is written: whole, but in a terminal as much as has room.
pub(super) fn print_text(text: &str) -> Result<(), CliError> {
    if std::io::stdout().is_terminal() { print(&beginning(text, MAX_LINES)) } else { print(text) }
}

/// Prints an answer, as much of it as has room, and where the page is that has all.
pub(super) fn print_end(answer: &str, page: &Path) -> Result<(), CliError> {
    print(&format!("{}{}\n", beginning(answer, MAX_LINES - 1), page.display()))
}

/// Prints the answer of a page that was written, and where it is.
pub(super) fn print_page(page: &Path, heading: Option<&str>) -> Result<(), CliError> {
    print_end(&answer(&read(page)?, heading), page)
}

/// Prints what a page begins with, up to its second empty line, and where it is.
pub(super) fn print_head(page: &Path) -> Result<(), CliError> {
    let text = read(page)?;
    print_end(&text.split("\n\n").take(2).collect::<Vec<_>>().join("\n"), page)
}

/// Prints how many files were written, and where the page is that tells of them.
pub(super) fn print_written(paths: &[PathBuf]) -> Result<(), CliError> {
    let is_page = |path: &&PathBuf| path.extension().is_some_and(|end| end == "md");
    let Some(page) = paths.iter().find(is_page).or(paths.first()) else { return Ok(()) };
    print_end(&format!("{} files in {}", paths.len(), page.parent().unwrap_or(page).display()), page)
}

fn read(page: &Path) -> Result<String, CliError> {
    std::fs::read_to_string(page).map_err(|error| CliError::Other(format!("cannot read {}: {error}", page.display())))
}

/// The answer of a page: its title, what it warns of before everything else, and what stands from a heading on, or where that is not there
/// from the heading of its first table on.
fn answer(page: &str, heading: Option<&str>) -> String {
    let lines: Vec<&str> = page.lines().filter(|line| !line.is_empty() && !line.starts_with("![")).collect();
    let named = heading.and_then(|heading| lines.iter().position(|line| *line == heading));
    let of_table = || {
        let table = lines.iter().position(|line| line.starts_with('|'))?;
        Some(lines[..table].iter().rposition(|line| line.starts_with("## ")).unwrap_or(table))
    };
    let begin = named.or_else(of_table).unwrap_or(0);
    let head = lines[..begin].iter().filter(|line| line.starts_with("# ") || line.starts_with("**"));
    head.chain(&lines[begin..]).map(|line| format!("{line}\n")).collect()
}

/// As many lines of a text as have room, with a line on what is left out.
fn beginning(text: &str, room: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let shown = if lines.len() > room { room - 1 } else { lines.len() };
    let mut beginning: String = lines[..shown].iter().map(|line| format!("{line}\n")).collect();
    if shown < lines.len() {
        beginning += &format!("... {} more lines\n", lines.len() - shown);
    }
    beginning
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that a text which has room is whole, and that one which has none is cut to it with the number of lines that are left out.
    #[test]
    fn texts_are_cut_to_their_room() {
        let text = |lines: usize| (0..lines).map(|line| format!("{line}\n")).collect::<String>();
        assert_eq!((beginning("", 3), beginning(&text(3), 3)), (String::new(), text(3)));
        assert_eq!(beginning(&text(4), 3), "0\n1\n... 2 more lines\n");
    }

    /// Proves that the answer is the title, the warnings and what stands from the heading on that is named, or from that of the first
    /// table, and that a page without tables is its own answer.
    #[test]
    fn pages_are_answered_from_their_first_table() {
        let page = "# Title\n\n- Machine: x\n\n**Software.**\n\nWords.\n\n## Room\n\n![a](b.svg)\n\nBefore:\n\n| a |\n| --- |\n\n## Claims\n\n| b |\n";
        let head = "# Title\n**Software.**\n";
        assert_eq!(answer(page, None), format!("{head}## Room\nBefore:\n| a |\n| --- |\n## Claims\n| b |\n"));
        assert_eq!(answer(page, Some("## Claims")), format!("{head}## Claims\n| b |\n"));
        assert_eq!(answer(page, Some("## No such")), answer(page, None));
        assert_eq!(answer("# Title\n\n- Machine: x\n", None), "# Title\n- Machine: x\n");
    }
}
