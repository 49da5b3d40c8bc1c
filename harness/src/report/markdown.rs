//! The little of Markdown that pages need beside tables, which `sheet.rs` writes.

/// Text that cannot end its line or be taken for markup of a table; strong words stay strong.
pub(crate) fn inline(text: &str) -> String {
    one_line(text).replace('|', "\\|").replace('<', "&lt;")
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
