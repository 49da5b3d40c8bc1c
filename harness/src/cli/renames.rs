//! Words of the command line that have gone, each with what stands for it now. docs/renames.md lists them, too.

use clap::error::{ContextKind, ContextValue};

/// A word that has gone.
struct Rename {
    /// The verb that an option was of; none of a verb.
    of: Option<&'static str>,
    /// The word.
    was: &'static str,
    /// What stands for it now.
    is: &'static str,
}

const fn verb(was: &'static str, is: &'static str) -> Rename {
    Rename { of: None, was, is }
}

/// Every word that has gone.
const RENAMES: &[Rename] = &[
    verb("adapters", "doctor"),
    verb("clock", "doctor --clock"),
    verb("claims", "table NAME-claims --from RUN..."),
    verb("tune", "sweep --choose RULE"),
    verb("docs", "cargo run --release --example figures"),
];

/// What stands now for the word at which the command line could not be read, if it is one that has gone.
pub(super) fn answer(error: &clap::Error, words: &[String]) -> Option<String> {
    let unknown = |kind| match error.get(kind) {
        Some(ContextValue::String(word)) => Some(word.as_str()),
        _ => None,
    };
    let verb = unknown(ContextKind::InvalidSubcommand);
    let word = verb.or_else(|| unknown(ContextKind::InvalidArg))?;
    let of = |rename: &&Rename| match rename.of {
        None => verb.is_some(),
        Some(of) => words.iter().any(|word| word == of),
    };
    let Rename { of, was, is } = RENAMES.iter().filter(of).find(|rename| rename.was == word)?;
    let was = of.map_or_else(|| (*was).to_owned(), |of| format!("{of} {was}"));
    Some(format!("error: `{was}` is `{is}` now; docs/renames.md has all that changed"))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::cli::CommandLine;

    /// Proves that every word that has gone is answered with what stands for it now, which the program takes, and stands in docs/renames.md;
    /// and that another word is not answered so.
    #[test]
    fn every_old_word_is_answered() {
        let page = include_str!("../../../docs/renames.md");
        let answer = |words: &[&str]| {
            let words: Vec<String> = ["tracebench"].iter().chain(words).map(|word| (*word).to_owned()).collect();
            CommandLine::try_parse_from(&words).err().and_then(|error| answer(&error, &words))
        };
        for Rename { of, was, is } in RENAMES {
            let words: Vec<&str> = of.iter().copied().chain([*was]).collect();
            let said = answer(&words).unwrap_or_default();
            assert!(said.contains(&format!("`{}` is `{is}` now", words.join(" "))), "{words:?}: {said}");
            assert!(page.contains(&format!("| `{}` | `{is}` |", words.join(" "))), "docs/renames.md has no {words:?}");
            if is.starts_with("cargo ") {
                continue;
            }
            let help = [&is.split(' ').take(1).collect::<Vec<_>>()[..], &["--help"]].concat();
            let found =
                CommandLine::try_parse_from([&["tracebench"][..], &help].concat()).err().map(|error| error.to_string());
            let options = is.split(' ').filter(|word| word.starts_with("--"));
            let found = found.unwrap_or_default();
            options.for_each(|option| assert!(found.contains(option), "{is}: {found}"));
        }
        assert_eq!((answer(&["no-such"]), answer(&["run", "--no-such"])), (None, None));
    }
}
