//! `merge`.

use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::output::print_written;
use crate::files::OutputFolder;
use crate::measure::Journal;
use crate::report::{self, ReportError};
use crate::results::merge;
use crate::tables;

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
    if whole.rows.is_empty() && whole.frames.as_ref().is_none_or(|frames| frames.rows.is_empty()) {
        return Err(CliError::Other("nothing was measured in any shard".to_owned()));
    }
    let folder = OutputFolder::open(&arguments.out)?;
    folder.check_all(report::may_be_written)?;
    let is_same = match report::read_run(folder.path()) {
        Ok(record) => {
            record.provenance.shard.is_none() && record.provenance.plan_sha256 == whole.provenance.plan_sha256
        }
        Err(ReportError::Missing(..)) => !Journal::is_in(folder.path()),
        Err(_) => false,
    };
    if !is_same {
        let out = arguments.out.display();
        return Err(CliError::Argument(format!("{out} holds another record: choose another folder with --out")));
    }
    let written = report::write_run(&whole, &folder, tables::of_run)?;
    report::take_pictures(&whole, &arguments.shards, &folder)?;
    super::page::beside(&whole, &folder)?;
    print_written(&written)
}
