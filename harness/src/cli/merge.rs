//! `merge`.

use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::output::print;
use super::work::OutputFolder;
use crate::results::merge;
use crate::{report, tables};

#[derive(Args)]
pub(super) struct MergeArguments {
    /// Every shard of one plan: run.json files, or the folders that hold them.
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Folder for the joined record and what derives from it.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn merge_shards(arguments: &MergeArguments) -> Result<(), CliError> {
    let place = |path: &std::path::Path| std::fs::canonicalize(super::run::folder_of(path)).ok();
    if arguments.shards.iter().any(|shard| place(shard).is_some() && place(shard) == place(&arguments.out)) {
        return Err(CliError::Argument("--out: it is one of the shards, which would be overwritten".to_owned()));
    }
    let read = |path: &PathBuf| Ok((path.display().to_string(), report::read_run(path)?));
    let shards = arguments.shards.iter().map(read).collect::<Result<Vec<_>, CliError>>()?;
    let whole = merge(shards).map_err(|error| CliError::Other(error.to_string()))?;
    if whole.runs.is_empty() {
        return Err(CliError::Other("nothing was measured in any shard".to_owned()));
    }
    let folder = OutputFolder::open(&arguments.out)?;
    let written = report::write_run(&whole, &folder.path, tables::of_run)?;
    report::take_pictures(&whole, &arguments.shards, &folder.path)?;
    print(&written.iter().map(|path| format!("{}\n", path.display())).collect::<String>())
}
