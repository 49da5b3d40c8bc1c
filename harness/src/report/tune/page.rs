//! `tune.md`.

use itertools::Itertools as _;
use tracebench_api::Query;

use super::{Errors, chart_stems, labels_of, score_name, trials};
use crate::report::chart::{self, Drawing};
use crate::report::document::Document;
use crate::report::format::{self, points, significant, thousands};
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::report::{metrics, summary, verdict};
use crate::results::Judgement;
use crate::studies::tune::{Choice, Judged, Label, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned, accuracy};

/// The whole page.
pub(super) fn page(tuning: &Tuning) -> Document {
    let section = |(scene, stem): (&SceneTuned, String)| {
        let name = literal(&scene.scene.name);
        let sets = scene
            .views
            .iter()
            .zip(["own"].into_iter().chain(std::iter::repeat("other")))
            .flat_map(|(view, whose)| view.sets.iter().map(move |set| one_set(tuning, whose, view, set)));
        let page = Document::default().scene(2, &scene.scene, "");
        let drawing = Drawing::Panels(chart::tune::chart(tuning, scene));
        page.chart(stem, format!("{name}: errors over {}", tuning.axis.name), drawing).and(sets)
    };
    let sections = tuning.scenes.iter().zip(chart_stems(tuning)).map(section);
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
    let errors = |name: &str, of: fn(&Errors) -> Option<u64>| {
        Column::new(format!("{name} ↓ ({by})"), move |value: &ValueTuned| {
            of(&Errors::of(&value.judged.as_ref()?.judgement, tuning.rule))
        })
    };
    let sheet = Sheet::<ValueTuned>::new()
        .column(&tuning.axis.name, |value| value.value.clone())
        .accuracies_of(set.query, |value| value.judged.as_ref().map(|judged| (&judged.judgement, of_judgement(judged))))
        .and(errors("false misses", |errors| Some(errors.false_misses)))
        .and(errors("false hits", |errors| Some(errors.false_hits)))
        .and(errors("early", |errors| errors.early))
        .and(errors("late", |errors| errors.late))
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
