//! `explain.md`: wrong rays by class and cause, from an explanation.

use std::collections::BTreeSet;

use super::document::Document;
use super::format;
use super::sheet::{Cell, Column, Columns, Sheet, Table};
use super::{Report, ReportError, Tables, summary};
use crate::results::{Explained, ExplanationRecord, MOST_UNEXPLAINED, RemedyRecord, Run, SceneExplained};

/// The page's file.
pub const EXPLAIN_PAGE: &str = "explain.md";

/// What is made of an explanation.
pub(super) fn report(run: &Run, _: Tables) -> Result<Report, ReportError> {
    let page = run.explanation.iter().map(|found| (EXPLAIN_PAGE.to_owned(), page(run, found)));
    Ok(Report { pages: page.collect(), ..Report::default() })
}

/// The page.
fn page(run: &Run, found: &ExplanationRecord) -> Document {
    let dirty = if run.provenance.dirty == Some(true) { ", changed tree" } else { "" };
    let has_ambiguous = run.runs.iter().flat_map(|row| &row.traces).any(|trace| trace.judgement.has_ambiguous());
    let of_ambiguous = if has_ambiguous { "" } else { "; ties left out" };
    let judged = if found.judged {
        format!(
            ", but for what the judge finds the cause of: the method samples, and no samples are fine enough for `tight`. Of no set may \
             more than {} % be unexplained",
            100.0 * MOST_UNEXPLAINED
        )
    } else {
        String::new()
    };
    let ladder = Sheet::<(usize, &RemedyRecord)>::new()
        .told("rung", |(rung, _)| rung.to_string())
        .told("cause", |(_, remedy)| remedy.cause.clone())
        .told("taken away by", |(_, remedy)| format!("`{}={}`", remedy.parameter, remedy.value))
        .told("source", |(_, remedy)| remedy.source.clone());
    Document::titled(&format!("Why rays of {} are wrong", found.tracer.label()))
        .words(run.provenance.machine.label())
        .words(format!(
            "Commit {}{dirty}, rules version {}, {}, run preset {}, seed {}.",
            run.provenance.commit, run.provenance.rules_version, run.provenance.started, run.preset, run.seed
        ))
        .and(summary::notes(run))
        .words(format!(
            "Every ray is traced on every rung of the ladder below, each of which takes one weakness away and keeps what the rungs \
             before have taken. A wrong ray (under `tight`{of_ambiguous}) has the cause that is taken away by the rung from which \
             on it is right; what is wrong on the last rung was given up there (`step_cap`) or is unexplained{judged}."
        ))
        .table(ladder.table(&(1..).zip(&found.ladder).collect::<Vec<_>>()))
        .heading(2, "By scene")
        .table(scenes(found))
        .heading(2, "By class")
        .and(classes(found))
        .and(found.scenes.iter().map(|scene| one_scene(found, scene)))
}

/// A column a cause.
fn by_cause<'a, R>(found: &'a ExplanationRecord, of: impl Fn(&R, &str) -> u64 + Copy + 'a) -> Columns<'a, R> {
    let column = |cause| Column::told(cause, move |row: &R| of(row, cause));
    found.causes().into_iter().map(column).collect()
}

fn scenes(found: &ExplanationRecord) -> Table {
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
    sheet.table(&rows)
}

fn classes(found: &ExplanationRecord) -> Document {
    let sets = || found.scenes.iter().flat_map(|scene| &scene.sets);
    let known: BTreeSet<&String> = sets().flat_map(|set| set.causes.keys()).collect();
    if known.is_empty() {
        return Document::of("No ray is wrong.");
    }
    let of = |class: &&String, cause: &str| sets().filter_map(|set| set.causes.get(*class)?.get(cause)).sum();
    let sheet = Sheet::<&String>::new().told("class", |class| (*class).clone()).with(by_cause(found, of));
    Document::default().table(sheet.table(&Vec::from_iter(known)))
}

fn one_scene(found: &ExplanationRecord, scene: &SceneExplained) -> Document {
    let view = &scene.viewpoint;
    let words = format!(
        "Frame {}x{}, faces {}, rays from {}x{} pixels. Wrong rays on each rung:",
        view.frame[0], view.frame[1], view.face, view.ray_image[0], view.ray_image[1]
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
    let left_out =
        scene.left_out.iter().map(|(rung, reason)| Document::of(format!("`{rung}` took nothing away here: {reason}")));
    Document::default().scene(2, &scene.scene, "").words(words).table(sheet.table(&scene.sets)).and(left_out)
}
