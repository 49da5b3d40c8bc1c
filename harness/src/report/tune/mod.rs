//! What is made of a tuned parameter: `tune.md` and a chart a scene.

mod page;
#[cfg(test)]
pub(in crate::report) mod tests;

use super::group::{groups, stems};
use super::sheet::{Column, Sheet};
use super::tables::Placed;
use super::{Report, ReportError, Tables, rows};
use crate::judge::Rule;
use crate::results::{Judgement, Record};
use crate::studies::tune::{Label, SceneTuned, SetTuned, Tuning};

/// The page.
pub const TUNE_PAGE: &str = "tune.md";

/// What the names of its charts begin with.
pub(in crate::report) const STEM: &str = "tune_";

/// What is made of a record of a tuned parameter.
pub(super) fn report(record: &Record, _: Tables) -> Result<Report, ReportError> {
    let Some(tuning) = Tuning::of(record) else { return Ok(Report::default()) };
    let is_chosen = |label: Label| {
        Column::csv(format!("is_{}", code(label)), move |(set, value): &Tried<'_>| {
            labels_of(set, value).contains(&label)
        })
    };
    let lost_to = |label: Label| {
        let rule = tuning.rule;
        let lost = move |(set, value): &Tried<'_>| Some(set.choice(label)?.score? - set.score(value, rule)?);
        Column::csv(format!("lost_to_{}_share", code(label)), lost)
    };
    let own = Sheet::new().with(Label::ALL.map(is_chosen).into()).with(Label::ALL.map(lost_to).into());
    Ok(of_tuning(&tuning).and(rows(record, &groups(record), own, |row| tried(record, &tuning, row))))
}

/// A value on a ray set.
type Tried<'a> = (&'a SetTuned, &'a str);

/// What a row tried; controls tried nothing.
fn tried<'a>(record: &'a Record, tuning: &'a Tuning, (_, _, (_, row, trace)): &Placed<'_>) -> Option<Tried<'a>> {
    let point = record.sweep.as_ref()?.points.iter().find(|point| point.is_of(row))?;
    let views = tuning.scenes.iter().filter(|scene| scene.scene == row.scene).flat_map(|scene| &scene.views);
    let mut sets = views.filter(|view| view.viewpoint == row.viewpoint).flat_map(|view| &view.sets);
    Some((sets.find(|set| set.rays_sha256 == trace.rays_sha256)?, point.values.get(&tuning.axis.name)?))
}

/// A label as a part of a column's name.
fn code(label: Label) -> String {
    label.name().replace(' ', "_")
}

/// Page and a chart a scene.
pub(in crate::report) fn of_tuning(tuning: &Tuning) -> Report {
    Report::of_page(TUNE_PAGE, page::page(tuning))
}

/// What the charts of the scenes are called, without their ends.
fn chart_stems(tuning: &Tuning) -> Vec<String> {
    let told = |one: &SceneTuned| {
        let viewpoint = one.views.first().map(|view| view.viewpoint.name.clone()).unwrap_or_default();
        [one.scene.name.clone(), one.scene.sha256.clone(), viewpoint]
    };
    let told: Vec<_> = tuning.scenes.iter().map(told).collect();
    let told: Vec<[&str; 3]> = told.iter().map(|each| each.each_ref().map(String::as_str)).collect();
    stems(&told).into_iter().map(|stem| format!("{STEM}{stem}")).collect()
}

/// Wrong rays by class, by a rule; early and late hits only where a rule looks at t.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::report) struct Errors {
    pub false_misses: u64,
    pub false_hits: u64,
    pub early: Option<u64>,
    pub late: Option<u64>,
}

impl Errors {
    pub(in crate::report) fn of(judgement: &Judgement, rule: Rule) -> Self {
        let classes = match judgement {
            Judgement::Any(any) => {
                let table = &any.occlusion;
                return Self {
                    false_misses: table.false_free,
                    false_hits: table.false_occluded,
                    early: None,
                    late: None,
                };
            }
            Judgement::Closest(closest) if rule == Rule::Footprint => &closest.classes.footprint,
            Judgement::Closest(closest) => &closest.classes.tight,
        };
        let of_t = |rays: u64| (rule != Rule::HitMiss).then_some(rays);
        Self {
            false_misses: classes.false_miss,
            false_hits: classes.false_hit,
            early: of_t(classes.early),
            late: of_t(classes.late),
        }
    }
}

/// Rays that count.
pub(in crate::report) fn trials(set: &SetTuned, judgement: &Judgement) -> u64 {
    set.count.saturating_sub(judgement.left_out())
}

/// The labels under which a value would have been chosen.
pub(in crate::report) fn labels_of(set: &SetTuned, value: &str) -> Vec<Label> {
    let chosen = set.choices.iter().filter(|choice| choice.value.as_deref() == Some(value));
    chosen.map(|choice| choice.label).collect()
}

/// The name of what a set is scored by.
pub(in crate::report) fn score_name(set: &SetTuned, rule: Rule) -> String {
    match set.query {
        tracebench_api::Query::Closest => format!("agreement {}", rule.name()),
        tracebench_api::Query::Any => "balanced accuracy".to_owned(),
    }
}
