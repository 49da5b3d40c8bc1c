//! The commands behind a page: of the page itself, and of its records as far as they tell.

use super::pieces::escape;
use super::read::Read;
use crate::report::Study;
use crate::results::{Record, config};
use itertools::Itertools as _;

/// What is said of the commands of records.
const HOW: &str = "The records were measured by these, as far as they tell: a scene that was read from a file is named as that file \
                   begins, and sizes, parameters and limits of time that were given are not here; what came of them stands under Machines \
                   and records.";

/// The part of a page.
pub(super) fn section(command: &str, all: &[Read<'_>]) -> String {
    let mut text = format!(
        "<section id=\"again\"><h2>Make it again</h2>\n<pre><code>{}</code></pre>\n<p>{HOW}</p>\n<pre><code>",
        escape(command)
    );
    for Read { record, name, .. } in all {
        let line = format!("{} --out {} # {}\n", of_record(record), quoted(name), record.provenance.commit);
        text += &escape(&line);
    }
    text + "</code></pre>\n</section>\n"
}

/// The command of a record, without its folder.
fn of_record(record: &Record) -> String {
    let verb = Study::of(record).verb;
    let mut words = vec!["tracebench".to_owned()];
    // Tables have their own tracers.
    match &record.table {
        Some(table) => words.extend(["table".to_owned(), quoted(table)]),
        None => {
            words.push(verb.to_owned());
            option(&mut words, "--tracer", record.rows.iter().map(|row| config(&row.tracer.name, &row.tracer.preset)));
        }
    }
    if let Some(tuning) = &record.tuning {
        option(&mut words, "--choose", [tuning.rule.name().to_owned()].into_iter());
    }
    // Cases are scenes with rays of their own.
    if verb != "stability" {
        option(&mut words, "--scene", record.rows.iter().map(|row| row.scene.name.clone()));
        option(&mut words, "--rays", record.rows.iter().flat_map(|row| &row.traces).map(|trace| trace.rays.clone()));
        option(&mut words, "--preset", [record.preset.clone()].into_iter());
        option(&mut words, "--seed", [record.seed.to_string()].into_iter());
    }
    words.join(" ")
}

/// An option with its values, each once; without one nothing.
fn option(words: &mut Vec<String>, name: &str, values: impl Iterator<Item = String>) {
    let once = values.unique().join(",");
    if !once.is_empty() {
        words.extend([name.to_owned(), quoted(&once)]);
    }
}

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+@:".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}
