//! `claims`.

use std::path::PathBuf;

use clap::Args;

use super::output::print;
use super::work::refuse_others;
use super::{CliError, names};
use crate::files::OutputFolder;
use crate::results::Run;
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
    let place = |path: &PathBuf| std::fs::canonicalize(super::run::folder_of(path)).unwrap_or_else(|_| path.clone());
    let mut known: Vec<PathBuf> = Vec::new();
    for path in &arguments.runs {
        if known.contains(&place(path)) {
            return Err(CliError::Argument(format!("{}: it is given twice", path.display())));
        }
        known.push(place(path));
    }
    let runs = arguments.runs.iter().map(|path| report::read_run(path)).collect::<Result<Vec<_>, _>>()?;
    let of_paper = |run: &Run| {
        run.table.as_deref().and_then(|table| table.split_once('-')).is_some_and(|(of, _)| of == paper.name)
    };
    if !runs.is_empty() && !runs.iter().any(of_paper) {
        return Err(CliError::Argument(format!(
            "none of these runs is of a table of {}: `tracebench list tables` names them, `tracebench table NAME` makes one",
            paper.name
        )));
    }
    if let Some(out) = &arguments.out {
        let folder = OutputFolder::open(out)?;
        refuse_others(out, arguments.runs.iter())?;
        report::write_all(&papers::claims_files(paper, &runs)?, &folder)?;
    }
    print(&papers::claims_text(paper, &runs)?)
}
