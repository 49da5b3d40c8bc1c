//! The page of a reproduction: what was measured, where it stands, and what was left out.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::{Reproduction, State, Step};
use crate::cli::CliError;
use crate::files::OutputFolder;
use crate::report::sheet::Sheet;

/// The page's file.
pub(super) const PAGE: &str = "reproduce.md";

/// Writes the page into the folder of all.
pub(super) fn write(found: &Reproduction, out: &OutputFolder, took: Duration) -> Result<PathBuf, CliError> {
    let pages = |step: &Step| pages(&out.path().join(&step.name));
    let text = text(found, &out.path().display().to_string(), took, pages);
    Ok(out.write(PAGE, text.as_bytes())?)
}

/// The pages in a step's folder, in the order of their names.
fn pages(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut pages: Vec<String> = names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    pages.retain(|name| name.ends_with(".md"));
    pages.sort();
    pages
}

fn text(found: &Reproduction, out: &str, took: Duration, pages: impl Fn(&Step) -> Vec<String>) -> String {
    let done = found.steps.iter().filter(|step| step.state == State::Done).count();
    let mut text = format!(
        "# Reproduction: {done} of {} steps, this time in {} s\n\nEvery page names its machine, and how much of its table was measured.\n\n",
        found.steps.len(),
        took.as_secs()
    );
    let sheet = Sheet::<&Step>::new()
        .column("step", |step| step.name.clone())
        .column("state", |step| match &step.state {
            State::Done => "measured".to_owned(),
            State::BrokenOff => "broken off, gone on with by `--resume`".to_owned(),
            State::Failed(reason) => format!("failed: {reason}"),
            State::LeftOut => "left out".to_owned(),
        })
        .column("took (s)", |step| format!("{:.0}", step.took_s))
        .column("pages", |step| {
            let links = pages(step).into_iter().map(|page| format!("[{page}]({}/{page})", step.name));
            links.collect::<Vec<_>>().join(", ")
        })
        .column("by itself", |step| command(step));
    let (left, taken): (Vec<&Step>, _) = found.steps.iter().partition(|step| step.state == State::LeftOut);
    text += &sheet.table(&taken).markdown();
    if !left.is_empty() {
        text += "\n## Left out\n\nThese were not reached. With more time `reproduce` goes on:\n\n```sh\n";
        let _ = writeln!(text, "tracebench reproduce --out {out} --resume --budget 1h\n```\n");
        for step in left {
            let _ = writeln!(text, "- {}: {}", step.name, command(step));
        }
    }
    text
}

fn command(step: &Step) -> String {
    format!("`tracebench {}`", step.arguments.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(name: &str, state: State) -> Step {
        Step { name: name.to_owned(), arguments: vec!["table".to_owned(), name.to_owned()], state, took_s: 1.6 }
    }

    /// Proves that the page counts what was measured, links its pages, tells why a step failed, and lists what was left out and nothing
    /// else there.
    #[test]
    fn the_page_tells_what_is_there_and_what_is_not() {
        let steps = vec![
            step("first", State::Done),
            step("second", State::Failed("no | room".to_owned())),
            step("third", State::BrokenOff),
            step("fourth", State::LeftOut),
        ];
        let found = Reproduction { preset: None, steps };
        let text = text(&found, "here", Duration::from_secs(9), |step| vec![format!("{}.md", step.name)]);
        assert!(text.starts_with("# Reproduction: 1 of 4 steps, this time in 9 s"));
        let line = |name: &str| text.lines().find(|line| line.contains(name)).unwrap().to_owned();
        assert!(line("| first").contains("measured | 2 | [first.md](first/first.md)"), "{text}");
        assert!(line("| second").contains("no \\| room"), "{text}");
        assert!(line("| third").contains("broken off"));
        let (before, after) = text.split_once("## Left out").unwrap();
        assert!(
            after.contains("- fourth: `tracebench table fourth`")
                && !after.contains("third")
                && !before.contains("fourth")
        );
        assert!(after.contains("--out here --resume"));
    }
}
