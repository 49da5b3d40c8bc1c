//! Words of the command line that have gone, each with what stands for it now. docs/renames.md lists them, too.

use clap::CommandFactory as _;
use clap::error::{ContextKind, ContextValue};

use super::CommandLine;
use crate::registry::TRACERS;

/// What a word that has gone was.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Verb,
    /// An option, of this verb among others.
    Option(&'static str),
    /// A tracer's parameter.
    Parameter,
    Table,
    Tracer,
    /// A variable of the environment.
    Variable,
}

/// Words that have gone, with what stands for them now.
const RENAMES: &[(Kind, &str, &str)] = &[
    (Kind::Verb, "adapters", "doctor"),
    (Kind::Verb, "clock", "doctor --clock"),
    (Kind::Verb, "claims", "table NAME-claims --from RUN..."),
    (Kind::Verb, "tune", "sweep --choose RULE"),
    (Kind::Verb, "picture", "frames --frames 1 --effect E"),
    (Kind::Verb, "docs", "cargo run --release --example figures"),
    (Kind::Option("run"), "--end", "--trace-to"),
    (Kind::Option("run"), "--frame", "--frame-size"),
    (Kind::Option("run"), "--face", "--face-size"),
    (Kind::Option("run"), "--time", "--animation-time"),
    (Kind::Option("run"), "--interval", "--ratio-precision"),
    (Kind::Option("run"), "--means", "--launch"),
    (Kind::Option("sweep"), "--rule", "--choose"),
    (Kind::Option("table"), "--part", "--few-rows"),
    (Kind::Option("doctor"), "--races", "--interleaved-sets"),
    (Kind::Parameter, "reads", "memory_access"),
    (Kind::Table, "means", "launch-settings"),
    (Kind::Table, "view-updates", "frames --rays SET --move camera --update U"),
    (Kind::Table, "bvh-updates", "frames --rays SET --move geometry --update U"),
    (Kind::Table, "lbvh-gpu-ablation", "ploc-gpu-ablation"),
    (Kind::Variable, "TRACEBENCH_MEANS", "TRACEBENCH_LAUNCH"),
];

/// Every word that has gone: those, and former names of tracers.
fn renames() -> impl Iterator<Item = (Kind, &'static str, &'static str)> {
    let tracers = TRACERS.iter().filter_map(|each| Some((Kind::Tracer, each.formerly?, each.name())));
    RENAMES.iter().copied().chain(tracers)
}

/// What stands now for a word that could not be read, if it is one that has gone.
pub(super) fn renamed(is_kind: impl Fn(Kind) -> bool, word: &str) -> Option<String> {
    let (_, was, is) = renames().find(|(kind, was, _)| is_kind(*kind) && *was == word)?;
    Some(format!("`{was}` is `{is}` now; docs/renames.md has all that changed"))
}

/// What stands now for the word at which the command line could not be read, if it is one that has gone.
pub(super) fn answer(error: &clap::Error, words: &[String]) -> Option<String> {
    let unknown = |kind| match error.get(kind) {
        Some(ContextValue::String(word)) => Some(word.as_str()),
        _ => None,
    };
    let verb = unknown(ContextKind::InvalidSubcommand).and_then(|word| renamed(|kind| kind == Kind::Verb, word));
    // Of a verb that has the new one.
    let command = CommandLine::command();
    let of = command.get_subcommands().find(|verb| words.iter().any(|word| word == verb.get_name()));
    let has = |long: &str| of.is_some_and(|verb| verb.get_arguments().any(|one| one.get_long() == Some(&long[2..])));
    let option = || {
        let (_, was, is) = RENAMES.iter().find(|(_, was, _)| unknown(ContextKind::InvalidArg) == Some(*was))?;
        renamed(|kind| matches!(kind, Kind::Option(_)) && has(is), was)
    };
    Some(format!("error: {}", verb.or_else(option)?))
}

/// A variable of the environment that is set and has gone, with what stands for it now.
pub(super) fn variable() -> Option<String> {
    let set = |(kind, was, _): &&(Kind, &str, &str)| *kind == Kind::Variable && std::env::var_os(was).is_some();
    RENAMES.iter().find(set).and_then(|(kind, was, _)| renamed(|other| other == *kind, was))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::cli::names;

    /// Proves that every word that has gone is answered with what stands for it now, which the program takes, and is in docs/renames.md;
    /// and that another word is not answered so.
    #[test]
    fn every_old_word_is_answered() {
        let page = include_str!("../../../docs/renames.md");
        let read = |words: &[&str]| CommandLine::try_parse_from([&["tracebench"], words].concat()).err();
        let answer = |words: &[&str]| {
            let all: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
            read(words).and_then(|error| answer(&error, &all))
        };
        for (kind, was, is) in renames() {
            assert!(page.contains(&format!("| `{was}` | `{is}` |")), "docs/renames.md has no {was}");
            let said = match kind {
                Kind::Verb => answer(&[was]),
                Kind::Option(of) => answer(&[of, was]),
                Kind::Parameter => names::tracers(&format!("dirt@{was}=x"), &[]).err().map(|error| error.to_string()),
                Kind::Table => names::table(was).err().map(|error| error.to_string()),
                Kind::Tracer => names::tracers(was, &[]).err().map(|error| error.to_string()),
                Kind::Variable => renamed(|other| other == kind, was),
            };
            assert!(said.unwrap_or_default().contains(&format!("`{was}` is `{is}` now")), "{was}");
            let verb = match kind {
                Kind::Verb if !is.starts_with("cargo ") => is.split(' ').next().unwrap(),
                Kind::Option(of) => of,
                _ => continue,
            };
            let help = read(&[verb, "--help"]).map(|error| error.to_string()).unwrap_or_default();
            let options = is.split(' ').filter(|word| word.starts_with("--"));
            options.for_each(|option| assert!(help.contains(option), "{is}: {help}"));
        }
        assert_eq!((answer(&["no-such"]), answer(&["run", "--no-such"])), (None, None));
        // The new option is of other verbs.
        assert_eq!(answer(&["list", "--end"]), None);
    }
}
