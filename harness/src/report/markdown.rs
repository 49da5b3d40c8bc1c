//! Documents as Markdown.

use std::fmt::Write as _;

use super::document::{Block, Document};

impl Document {
    /// The text: parts are a blank line apart, items of a list are not.
    pub(crate) fn markdown(&self) -> String {
        let mut text = String::new();
        let mut in_list = false;
        for block in &self.blocks {
            let is_item = matches!(block, Block::Item(_));
            let goes_on = in_list && is_item;
            if !text.is_empty() && !goes_on {
                text.push('\n');
            }
            in_list = is_item;
            let _ = match block {
                Block::Heading(level, words, _) => writeln!(text, "{} {}", "#".repeat(*level), inline(words)),
                Block::Words(words) => writeln!(text, "{}", safe(words)),
                Block::Item(words) => writeln!(text, "- {}", safe(words)),
                Block::Table(table) => write!(text, "{}", table.markdown()),
                Block::Chart(stem, alt, _) => writeln!(text, "![{}]({stem}.svg)", inline(alt)),
            };
        }
        text
    }
}

/// Words of a line that cannot be taken for HTML.
fn safe(words: &str) -> String {
    one_line(words).replace('<', "&lt;")
}

/// Text that cannot end its line or be taken for markup of a table; strong words stay strong.
pub(crate) fn inline(text: &str) -> String {
    let mut safe = String::new();
    for letter in self::safe(text).chars() {
        // What is escaped already stays as it is.
        if letter == '|' && safe.chars().rev().take_while(|before| *before == '\\').count().is_multiple_of(2) {
            safe.push('\\');
        }
        safe.push(letter);
    }
    safe
}

/// A name or other words that were not written here, none of which is markup: what looks like it stands as it is.
pub(crate) fn literal(text: &str) -> String {
    let text: Vec<char> = one_line(text).chars().collect();
    let is_word = |at: Option<usize>| at.and_then(|at| text.get(at)).is_some_and(|letter| letter.is_alphanumeric());
    let mut escaped = String::new();
    for (at, letter) in text.iter().enumerate() {
        // Between letters an underscore is none.
        let is_markup = match letter {
            '_' => !(is_word(at.checked_sub(1)) && is_word(Some(at + 1))),
            _ => "\\`*[]~|!".contains(*letter),
        };
        match letter {
            '<' => escaped.push_str("&lt;"),
            '&' => escaped.push_str("&amp;"),
            _ if is_markup => escaped.extend(['\\', *letter]),
            _ => escaped.push(*letter),
        }
    }
    escaped
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
