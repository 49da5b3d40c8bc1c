//! What is made of a tuned parameter: `tune.md` and a chart a scene.

#[cfg(test)]
pub(in crate::report) mod tests;

use itertools::Itertools as _;
use tracebench_api::Query;

use super::chart;
use super::document::Document;
use super::format::{self, points, significant, thousands};
use super::group::{groups, stems};
use super::markdown::literal;
use super::sheet::{Cell, Column, Sheet};
use super::tables::Placed;
use super::{Report, metrics, rows, summary, verdict};
use crate::judge::Rule;
use crate::results::{AnyJudgement, Classes, Judgement, Record};
use crate::studies::tune::{Choice, Judged, Label, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned, accuracy};

/// The page.
pub const TUNE_PAGE: &str = "tune.md";

/// What the names of its charts begin with.
pub(in crate::report) const STEM: &str = "tune_";

/// What is made of a record of a tuned parameter.
pub(super) fn report(record: &Record) -> Option<Report> {
    let tuning = Tuning::of(record)?;
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
    Some(of_tuning(&tuning).and(rows(record, &groups(record), own, |row| tried(record, &tuning, row))))
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
    Report::of_page(TUNE_PAGE, page(tuning))
}

/// The classes of wrong rays.
pub(in crate::report) const CLASSES: [&str; 4] = ["false misses", "false hits", "early", "late"];

/// Wrong rays by class, by a rule; early and late hits only where a rule looks at t.
pub(in crate::report) fn errors(judgement: &Judgement, rule: Rule) -> [Option<u64>; 4] {
    let Classes { false_miss, false_hit, early, late, .. } = match judgement {
        Judgement::Any(AnyJudgement { occlusion: of, .. }) => {
            return [Some(of.false_free), Some(of.false_occluded), None, None];
        }
        Judgement::Closest(closest) if rule == Rule::Footprint => &closest.classes.footprint,
        Judgement::Closest(closest) => &closest.classes.tight,
    };
    let of_t = |rays: &u64| (rule != Rule::HitMiss).then_some(*rays);
    [Some(*false_miss), Some(*false_hit), of_t(early), of_t(late)]
}

/// Rays that count.
pub(in crate::report) fn trials(set: &SetTuned, judgement: &Judgement) -> u64 {
    set.count.saturating_sub(judgement.left_out())
}

/// The labels under which a value would have been chosen.
fn labels_of(set: &SetTuned, value: &str) -> Vec<Label> {
    let chosen = set.choices.iter().filter(|choice| choice.value.as_deref() == Some(value));
    chosen.map(|choice| choice.label).collect()
}

/// The name of what a set is scored by.
pub(in crate::report) fn score_name(set: &SetTuned, rule: Rule) -> String {
    match set.query {
        Query::Closest => format!("agreement {}", rule.name()),
        Query::Any => "balanced accuracy".to_owned(),
    }
}

/// The whole page.
fn page(tuning: &Tuning) -> Document {
    let told = tuning.scenes.iter().map(|one| {
        let viewpoint = one.views.first().map_or("", |view| view.viewpoint.name.as_str());
        [one.scene.name.as_str(), one.scene.sha256.as_str(), viewpoint]
    });
    let section = |(scene, stem): (&SceneTuned, String)| {
        let name = literal(&scene.scene.name);
        let sets = scene
            .views
            .iter()
            .zip(["own"].into_iter().chain(std::iter::repeat("other")))
            .flat_map(|(view, whose)| view.sets.iter().map(move |set| one_set(tuning, whose, view, set)));
        let page = Document::default().scene(2, &scene.scene, "");
        let chart = chart::tune::chart(tuning, scene);
        page.chart(format!("{STEM}{stem}"), format!("{name}: errors over {}", tuning.axis.name), chart).and(sets)
    };
    let sections = tuning.scenes.iter().zip(stems(&told.collect_vec())).map(section);
    head(tuning).and(sections).and(summary::skipped(&tuning.skipped))
}

/// What holds of the whole tuning, and what every choice is worth in every scene.
fn head(tuning: &Tuning) -> Document {
    let axis = &tuning.axis;
    let title = format!("Tuning {} of {}", axis.name, tuning.tracer.label());
    let controls = verdict::tuning_controls(tuning);
    let sets = tuning.scenes.iter().flat_map(|scene| &scene.views).flat_map(|view| &view.sets);
    let judged = sets.flat_map(|set| &set.values).filter_map(|value| value.judged.as_ref());
    let unit = if axis.unit.is_empty() { String::new() } else { format!(" ({})", axis.unit) };
    let page = summary::head_of(&tuning.provenance, &tuning.preset, tuning.seed, &controls, &title)
        .paragraph(format!("`{}`{unit}: {}.", axis.name, axis.effect))
        .paragraph(format!(
            "Every value traces the same rays, in every scene from its own viewpoint and from another one. **Default** is the \
             preset's value. **Tuned here** is the value that is best on the judged rays themselves: an upper bound, since whoever \
             tunes has seen the answers. **Tuned elsewhere** is the value that is best from the scene's other viewpoint, **tuned on \
             the other scenes** the one that is best on average over their own viewpoints; both are judged here. Best is by `{}`, of \
             any-hit sets by balanced accuracy; of equal values the smaller. Losses are in percentage points, negative ones are \
             gains; those in bold are beyond both 95 % Wilson intervals. {}",
            tuning.rule.name(),
            metrics::of_ambiguous(judged.map(|judged| &judged.judgement))
        ));
    let sets = all_sets(tuning).map(|(_, _, set)| (&set.rays, set.query)).unique();
    page.and(sets.map(|(rays, query)| overview(tuning, rays, query)))
}

fn all_sets(tuning: &Tuning) -> impl Iterator<Item = (&SceneTuned, &ViewTuned, &SetTuned)> {
    let views = tuning.scenes.iter().flat_map(|scene| scene.views.iter().map(move |view| (scene, view)));
    views.flat_map(|(scene, view)| view.sets.iter().map(move |set| (scene, view, set)))
}

/// What every choice is worth in every scene, and on average.
fn overview(tuning: &Tuning, rays: &str, query: Query) -> Document {
    // A set in its place; below all of them their mean.
    type TableRow<'a> = Option<(&'a SceneTuned, &'a ViewTuned, &'a SetTuned)>;
    let sets: Vec<_> = all_sets(tuning).filter(|(_, _, set)| set.rays == rays && set.query == query).collect();
    let Some((_, _, first)) = sets.first() else { return Document::default() };
    let mean = |of: &dyn Fn(&SetTuned) -> Option<f64>| {
        // Over the same sets in every column, or the columns would not compare.
        let found: Option<Vec<f64>> = sets.iter().map(|(_, _, set)| of(set)).collect();
        found.map(|found| found.iter().sum::<f64>() / found.len() as f64)
    };
    let all: u64 = sets.iter().map(|(_, _, set)| set.count).sum();
    let value = |label: Label| {
        Column::new(format!("{}: value, share ↑", label.name()), move |row: &TableRow<'_>| match row {
            Some((.., set)) => worth(tuning, set, label),
            None => Some(Cell::Share(mean(&|set| set.choice(label)?.score)?, None, all).describe()),
        })
    };
    let loss = |label: Label| {
        Column::new(format!("{} loses to tuned here ↓", label.name()), move |row: &TableRow<'_>| match row {
            Some((.., set)) => lost(tuning, set, label, Label::TunedHere),
            None => {
                mean(&|set| set.choice(label)?.lost_to.get(&Label::TunedHere).copied()).map(|loss| points(loss, all))
            }
        })
    };
    // Whatever is not tuned on the judged rays themselves.
    let losers = Label::ALL.into_iter().filter(|label| *label != Label::TunedHere);
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("scene", |row| row.map_or("mean".to_owned(), |(scene, ..)| scene.scene.name.clone()))
        .column("viewpoint", |row| {
            row.map_or_else(|| format!("of {}", sets.len()), |(_, view, _)| view.viewpoint.name.clone())
        })
        .with(Label::ALL.map(value).into())
        .with(losers.map(loss).collect());
    let rows: Vec<TableRow<'_>> = sets.iter().copied().map(Some).chain([None]).collect();
    let heading = format!("{rays}: {}, {}", format::query(query), score_name(first, tuning.rule));
    Document::default().rays(2, rays, heading).table(sheet.table(&rows))
}

fn worth(tuning: &Tuning, set: &SetTuned, label: Label) -> Option<String> {
    let choice = set.choice(label)?;
    let value = choice.value.as_ref()?;
    let judgement = set.judged(value).map(|judged| &judged.judgement);
    if let Some(why) = judgement.and_then(Judgement::one_sided) {
        return Some(format!("{value}: {why}"));
    }
    let interval = |judged: &Judgement| accuracy(judged, tuning.rule)?.interval;
    let share =
        judgement.zip(choice.score).map(|(judged, score)| Cell::Share(score, interval(judged), trials(set, judged)));
    Some(format!("{value}: {}", Cell::from(share).describe()))
}

/// What a choice loses to another, in bold where their intervals do not meet.
fn lost(tuning: &Tuning, set: &SetTuned, label: Label, to: Label) -> Option<String> {
    let (own, other) = set.choice(label).zip(set.choice(to))?;
    let loss = *own.lost_to.get(&to)?;
    let judgement = |choice: &Choice| Some(&set.judged(choice.value.as_deref()?)?.judgement);
    let trials = trials(set, judgement(own)?);
    let interval = |choice: &Choice| accuracy(judgement(choice)?, tuning.rule)?.interval;
    let apart =
        interval(own).zip(interval(other)).is_some_and(|([low, high], [least, most])| high < least || most < low);
    let text = points(loss, trials);
    Some(if apart { format!("**{text}**") } else { text })
}

/// A chosen value with what it does.
type Chosen<'a> = (&'a Choice, Option<&'a Judged>);

fn one_set(tuning: &Tuning, whose: &str, view: &ViewTuned, set: &SetTuned) -> Document {
    let name = literal(&view.viewpoint.name);
    let [x, y, z] = view.viewpoint.eye.map(|each| significant(f64::from(each), 4));
    let (rays, query, count) = (&set.rays, format::query(set.query), thousands(set.count));
    let heading = format!("{rays}, {whose} viewpoint {name} at ({x}, {y}, {z}): {query}, {count} rays");
    let of_judgement = |judged: &Judged| trials(set, &judged.judgement);
    let loses = |to: Label| {
        let lost = move |(choice, _): &Chosen<'_>| lost(tuning, set, choice.label, to);
        Column::new(format!("loses to {}", to.name()), lost)
    };
    let sheet = Sheet::<Chosen<'_>>::new()
        .column("choice", |(choice, _)| choice.label.name())
        .column(&tuning.axis.name, |(choice, _)| {
            choice.value.clone().unwrap_or_else(|| "nothing to choose by".to_owned())
        })
        .accuracies_of(set.query, |(_, judged)| judged.map(|judged| (&judged.judgement, of_judgement(judged))))
        .with(Label::ALL.map(loses).into());
    let judged = set.choices.iter().map(|choice| choice.value.as_deref().and_then(|value| set.judged(value)));
    let rows: Vec<Chosen<'_>> = set.choices.iter().zip(judged).collect();
    let chosen = sheet.table(&rows);
    let by = match set.query {
        Query::Any => "occlusion",
        Query::Closest => tuning.rule.name(),
    };
    let of_class = |(place, name): (usize, &str)| {
        Column::new(format!("{name} ↓ ({by})"), move |value: &ValueTuned| {
            errors(&value.judged.as_ref()?.judgement, tuning.rule)[place]
        })
    };
    let sheet = Sheet::<ValueTuned>::new()
        .column(&tuning.axis.name, |value| value.value.clone())
        .accuracies_of(set.query, |value| value.judged.as_ref().map(|judged| (&judged.judgement, of_judgement(judged))))
        .with(CLASSES.into_iter().enumerate().map(of_class).collect())
        .column("is", |value| {
            let mut labels: Vec<&str> = labels_of(set, &value.value).into_iter().map(Label::name).collect();
            if value.judged.is_none() {
                labels.push("skipped, see below");
            } else if set.score(&value.value, tuning.rule).is_none() {
                let one_sided = set.judged(&value.value).and_then(|judged| judged.judgement.one_sided());
                labels.push(one_sided.unwrap_or("not judged: every ray is ambiguous"));
            }
            labels.join(", ")
        });
    Document::default().rays(3, rays, heading).table(chosen).table(sheet.table(&set.values))
}
