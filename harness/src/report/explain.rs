//! `explain.md`: wrong rays by class and cause, from an explanation.

use std::collections::BTreeSet;

use super::document::Document;
use super::format;
use super::sheet::{Cell, Column, Columns, Sheet, Table};
use super::{Report, summary};
use crate::results::{Explained, ExplanationRecord, MAX_UNEXPLAINED, Record, RemedyRecord, SceneExplained};

/// What is made of an explanation.
pub(super) fn report(record: &Record) -> Option<Report> {
    Some(Report::of_page("explain.md", page(record, record.explanation.as_ref()?)))
}

/// The page.
fn page(record: &Record, found: &ExplanationRecord) -> Document {
    let dirty = if record.provenance.dirty == Some(true) { ", changed tree" } else { "" };
    let has_ambiguous = record.rows.iter().flat_map(|row| &row.traces).any(|trace| trace.judgement.has_ambiguous());
    let of_ambiguous = if has_ambiguous { "" } else { "; ambiguous rays left out" };
    let judged = if found.judged {
        format!(
            ", but for what the judge finds the cause of: the method samples, and no samples are fine enough for `tight`. Of no set may \
             more than {} % be unexplained",
            100.0 * MAX_UNEXPLAINED
        )
    } else {
        String::new()
    };
    let remedies = Sheet::<(usize, &RemedyRecord)>::new()
        .column("remedy", |(step, _)| step.to_string())
        .column("cause", |(_, remedy)| remedy.cause.clone())
        .column("taken away by", |(_, remedy)| format!("`{}={}`", remedy.parameter, remedy.value))
        .column("source", |(_, remedy)| remedy.source.clone());
    Document::titled(&format!("Why rays of {} are wrong", found.tracer.label()))
        .paragraph(record.provenance.machine.label())
        .paragraph(format!(
            "Commit {}{dirty}, rules version {}, {}, run preset {}, seed {}.",
            record.provenance.commit, record.provenance.rules_version, record.provenance.started, record.preset, record.seed
        ))
        .and(summary::notes(record))
        .paragraph(format!(
            "Every ray is traced after every step of the remedy sequence below, each of which takes one weakness away and keeps what the steps \
             before have taken. A wrong ray (under `tight`{of_ambiguous}) has the cause that is taken away by the step from which \
             on it is right; what is wrong on the last step was given up there (`step_cap`) or is unexplained{judged}."
        ))
        .table(remedies.table(&(1..).zip(&found.remedies).collect::<Vec<_>>()))
        .heading(2, "By scene")
        .table(scenes(found))
        .heading(2, "By class")
        .and(classes(found))
        .and(found.scenes.iter().map(|scene| one_scene(found, scene)))
}

/// A column a cause.
fn by_cause<'a, R>(found: &'a ExplanationRecord, of: impl Fn(&R, &str) -> u64 + Copy + 'a) -> Columns<'a, R> {
    let column = |cause| Column::new(cause, move |row: &R| of(row, cause));
    found.causes().into_iter().map(column).collect()
}

fn scenes(found: &ExplanationRecord) -> Table {
    type TableRow<'a> = (&'a str, Vec<&'a Explained>);
    let sum = |(_, sets): &TableRow<'_>, of: &dyn Fn(&Explained) -> u64| sets.iter().map(|set| of(set)).sum::<u64>();
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("scene", |(name, _)| Cell::Name((*name).to_owned()))
        .column("rays", |row| sum(row, &|set| set.count))
        .column("ambiguous rays", |row| sum(row, &|set| set.ambiguous_rays))
        .column("wrong", |row| sum(row, &|set| set.wrong_by_remedy[0]))
        .with(by_cause(found, |row, cause| sum(row, &|set| set.of_cause(cause))))
        .column("wrong on the last step", |row| sum(row, &Explained::left));
    let mut rows: Vec<TableRow<'_>> =
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
    let sheet = Sheet::<&String>::new().column("class", |class| (*class).clone()).with(by_cause(found, of));
    Document::default().table(sheet.table(&Vec::from_iter(known)))
}

fn one_scene(found: &ExplanationRecord, scene: &SceneExplained) -> Document {
    let view = &scene.viewpoint;
    let words = format!(
        "Frame {}x{}, faces {}, rays from {}x{} pixels. Wrong rays on each step:",
        view.frame[0], view.frame[1], view.face, view.ray_image[0], view.ray_image[1]
    );
    let mut sheet = Sheet::<Explained>::new()
        .column("rays", |set| set.rays.clone())
        .column("query", |set| format::query(set.query))
        .column("count", |set| set.count)
        .column("ambiguous rays", |set| set.ambiguous_rays);
    let steps = found.remedies.iter().map(|step| format!("+ {}={}", step.parameter, step.value));
    for (place, heading) in std::iter::once("as asked for".to_owned()).chain(steps).enumerate() {
        sheet = sheet.column(heading, move |set| set.wrong_by_remedy.get(place).copied());
    }
    sheet = sheet.column("right at first, wrong on a later step", |set| set.wrong_on_the_way);
    let left_out = scene.left_out.iter().map(|(step, reason)| format!("`{step}` took nothing away here: {reason}"));
    Document::default().scene(2, &scene.scene, "").paragraph(words).table(sheet.table(&scene.sets)).paragraphs(left_out)
}
