//! `explain.md`: wrong rays by class and cause, from an explanation.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::format::{self, thousands};
use super::markdown::{inline, literal};
use super::sheet::{Cell, Column, Columns, Sheet};
use super::summary;
use crate::results::{Explained, ExplanationRecord, MOST_UNEXPLAINED, RemedyRecord, Run, SceneExplained};

/// The page's file.
pub const EXPLAIN_PAGE: &str = "explain.md";

/// The page.
pub fn explanation_page(run: &Run, found: &ExplanationRecord) -> String {
    let dirty = if run.provenance.dirty == Some(true) { ", changed tree" } else { "" };
    let mut page = format!(
        "# Why rays of {} are wrong\n\n{}\n\nCommit {}{dirty}, rules version {}, {}, run preset {}, seed {}.\n\n",
        inline(&found.tracer.label()),
        inline(&run.provenance.machine.label()),
        run.provenance.commit,
        run.provenance.rules_version,
        run.provenance.started,
        run.preset,
        run.seed
    );
    page.push_str(&summary::notes(run));
    let has_ambiguous = run.runs.iter().flat_map(|row| &row.traces).any(|trace| trace.judgement.has_ambiguous());
    let of_ambiguous = if has_ambiguous { "" } else { "; ties left out" };
    let _ = write!(
        page,
        "Every ray is traced on every rung of the ladder below, each of which takes one weakness away and keeps what the rungs \
         before have taken. A wrong ray (under `tight`{of_ambiguous}) has the cause that is taken away by the rung from which \
         on it is right; what is wrong on the last rung was given up there (`step_cap`) or is unexplained",
    );
    if found.judged {
        let _ = write!(
            page,
            ", but for what the judge finds the cause of: the method samples, and no samples are fine enough for `tight`. Of no set may \
             more than {} % be unexplained",
            100.0 * MOST_UNEXPLAINED
        );
    }
    page.push_str(".\n\n");
    let ladder = Sheet::<(usize, &RemedyRecord)>::new()
        .told("rung", |(rung, _)| rung.to_string())
        .told("cause", |(_, remedy)| remedy.cause.clone())
        .told("taken away by", |(_, remedy)| format!("`{}={}`", remedy.parameter, remedy.value))
        .told("source", |(_, remedy)| remedy.source.clone());
    page.push_str(&ladder.markdown(&(1..).zip(&found.ladder).collect::<Vec<_>>()));
    page.push_str("\n## By scene\n\n");
    page.push_str(&scenes(found));
    page.push_str("\n## By class\n\n");
    page.push_str(&classes(found));
    for scene in &found.scenes {
        page.push_str(&one_scene(found, scene));
    }
    page
}

/// A column a cause.
fn by_cause<'a, R>(found: &'a ExplanationRecord, of: impl Fn(&R, &str) -> u64 + Copy + 'a) -> Columns<'a, R> {
    let column = |cause| Column::told(cause, move |row: &R| of(row, cause));
    found.causes().into_iter().map(column).collect()
}

fn scenes(found: &ExplanationRecord) -> String {
    type Row<'a> = (&'a str, Vec<&'a Explained>);
    let sum = |(_, sets): &Row<'_>, of: &dyn Fn(&Explained) -> u64| sets.iter().map(|set| of(set)).sum::<u64>();
    let sheet = Sheet::<Row<'_>>::new()
        .told("scene", |(name, _)| Cell::Name((*name).to_owned()))
        .told("rays", |row| sum(row, &|set| set.count))
        .told("ties", |row| sum(row, &|set| set.ties))
        .told("wrong", |row| sum(row, &|set| set.wrong_by_rung[0]))
        .with(by_cause(found, |row, cause| sum(row, &|set| set.of_cause(cause))))
        .told("wrong on the last rung", |row| sum(row, &Explained::left));
    let mut rows: Vec<Row<'_>> =
        found.scenes.iter().map(|scene| (&*scene.scene.name, scene.sets.iter().collect())).collect();
    rows.push(("all", found.scenes.iter().flat_map(|scene| &scene.sets).collect()));
    sheet.markdown(&rows)
}

fn classes(found: &ExplanationRecord) -> String {
    let sets = || found.scenes.iter().flat_map(|scene| &scene.sets);
    let known: BTreeSet<&String> = sets().flat_map(|set| set.causes.keys()).collect();
    if known.is_empty() {
        return "No ray is wrong.\n".to_owned();
    }
    let of = |class: &&String, cause: &str| sets().filter_map(|set| set.causes.get(*class)?.get(cause)).sum();
    let sheet = Sheet::<&String>::new().told("class", |class| (*class).clone()).with(by_cause(found, of));
    sheet.markdown(&Vec::from_iter(known))
}

fn one_scene(found: &ExplanationRecord, scene: &SceneExplained) -> String {
    let view = &scene.viewpoint;
    let mut text = format!(
        "\n## {}: {} triangles\n\nFrame {}x{}, faces {}, rays from {}x{} pixels. Wrong rays on each rung:\n\n",
        literal(&scene.scene.name),
        thousands(scene.scene.triangles),
        view.frame[0],
        view.frame[1],
        view.face,
        view.ray_image[0],
        view.ray_image[1]
    );
    let mut sheet = Sheet::<Explained>::new()
        .told("rays", |set| set.rays.clone())
        .told("query", |set| format::query(set.query))
        .told("count", |set| set.count)
        .told("ties", |set| set.ties);
    let rungs = found.ladder.iter().map(|rung| format!("+ {}={}", rung.parameter, rung.value));
    for (place, heading) in std::iter::once("as asked for".to_owned()).chain(rungs).enumerate() {
        sheet = sheet.told(heading, move |set| set.wrong_by_rung.get(place).copied());
    }
    sheet = sheet.told("right at first, wrong on a later rung", |set| set.wrong_on_the_way);
    text += &sheet.markdown(&scene.sets);
    for (rung, reason) in &scene.left_out {
        let _ = write!(text, "\n`{rung}` took nothing away here: {}\n", inline(reason));
    }
    text
}
