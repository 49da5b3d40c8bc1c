//! `claims`.

use std::path::PathBuf;

use clap::Args;

use super::output::print;
use super::work::OutputFolder;
use super::{CliError, names};
use crate::{papers, report};

#[derive(Args)]
pub(super) struct ClaimsArguments {
    /// The paper, by its short name.
    paper: String,
    /// Runs of the paper's tables: their folders, or run.json files. Claims that none measures are listed with the table that
    /// would.
    runs: Vec<PathBuf>,
    /// Folder for `claims_PAPER.md` and `claims_PAPER.json`; nothing is written if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(super) fn claims(arguments: &ClaimsArguments) -> Result<(), CliError> {
    let paper = names::paper(&arguments.paper)?;
    let runs = arguments.runs.iter().map(|path| report::read_run(path)).collect::<Result<Vec<_>, _>>()?;
    if let Some(out) = &arguments.out {
        papers::write_claims(paper, &runs, &OutputFolder::open(out)?.path)?;
    }
    print(&papers::claims_text(paper, &runs)?)
}
