//! Words of the command line that have gone, each with what stands for it now.

use clap::error::{ContextKind, ContextValue};

/// Verbs that have gone.
const RENAMES: [(&str, &str); 1] = [("docs", "cargo run --release --example figures")];

/// What stands now for the word at which the command line could not be read, if it is one that has gone.
pub(super) fn answer(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    let (was, is) = RENAMES.iter().find(|(was, _)| was == word)?;
    Some(format!("error: `{was}` is `{is}` now"))
}
