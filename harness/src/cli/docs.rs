//! `docs`.

use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::output::print;
use crate::quotes;

#[derive(Args)]
pub(super) struct DocsArguments {
    /// Write what records say in the place of what differs.
    #[arg(long, conflicts_with = "check")]
    write: bool,
    /// Only tell what differs, which is an error; this is what is done where nothing is said.
    #[arg(long)]
    check: bool,
    /// The folder with README.md and docs/; the files that markers name are below it.
    #[arg(long, value_name = "DIR", default_value = ".")]
    root: PathBuf,
    /// Documents to look at, in the place of README.md and all of docs/.
    documents: Vec<PathBuf>,
}

pub(super) fn docs(arguments: &DocsArguments) -> Result<(), CliError> {
    let root = &arguments.root;
    let documents = if arguments.documents.is_empty() {
        quotes::documents(root).map_err(|error| {
            CliError::Other(format!("cannot list the documents of {}: {error}; say where by --root", root.display()))
        })?
    } else {
        arguments.documents.clone()
    };
    let found = quotes::bring(root, &documents, arguments.write).map_err(|error| CliError::Other(error.to_string()))?;
    let mut text = String::new();
    for each in &found {
        let (path, line) = (each.path.display(), each.line);
        text += &format!("{path}, line {line}: '{}' is '{}' by its record\n", each.says.trim(), each.record.trim());
    }
    print(&text)?;
    if arguments.write || found.is_empty() {
        return Ok(());
    }
    Err(CliError::Other(format!(
        "{} quotes differ from their records; `tracebench docs --write` writes them",
        found.len()
    )))
}
