//! What the choice of a value costs, on the page of a sweep by which one is chosen: the value of every label beside what it is worth.

#[cfg(test)]
mod tests;

use tracebench_api::Query;

use crate::judge::Rule;
use crate::report::document::Document;
use crate::report::format::{self, points};
use crate::report::metrics::{accuracies, trials};
use crate::report::sheet::{Cell, Column, Columns, Sheet};
use crate::results::{PointRecord, gathered};
use crate::studies::tune::{Label, SetTuned, Tuning};

/// What a row tried: its point and, where a value is chosen, the ray set with the value.
pub(super) type Tried<'a> = (&'a PointRecord, Option<(&'a SetTuned<'a>, &'a str)>);

/// Of each row whether its value is that of a label, and what it loses to that.
pub(super) fn columns<'a>() -> Columns<'a, Tried<'a>> {
    let code = |label: Label| label.name().replace(' ', "_");
    let is_chosen = |label: Label| {
        Column::csv(format!("is_{}", code(label)), move |(_, tried): &Tried<'_>| {
            tried.map(|(set, value)| set.chosen(label) == Some(value))
        })
    };
    let lost_to = |label: Label| {
        Column::csv(format!("lost_to_{}_share", code(label)), move |(_, tried): &Tried<'_>| {
            tried.and_then(|(set, value)| set.lost(value, label))
        })
    };
    Label::ALL.map(is_chosen).into_iter().chain(Label::ALL.map(lost_to)).collect()
}

/// What every choice is worth in every scene, and on average.
pub(super) fn section(tuning: &Tuning<'_>) -> Document {
    let page = Document::default().heading(2, "Choices").paragraph(format!(
        "Every value traces the same rays, in every scene from its own viewpoint and then from another one. **Default** is the preset's \
         value. **Tuned here** is the value that is best on the judged rays themselves: an upper bound, since whoever tunes has seen the \
         answers. **Tuned elsewhere** is the value that is best from the scene's other viewpoint, **tuned on the other scenes** the one \
         that is best on average over their own viewpoints; both are judged here. Best is by `{}`, of any-hit sets by balanced accuracy; \
         of equal values the smaller. Losses are in percentage points, negative ones are gains; those in bold are beyond both 95 % Wilson \
         intervals.",
        tuning.rule.name()
    ));
    let sets = gathered(tuning.sets.iter().map(|set| ((set.rays.rays.as_str(), set.rays.query), set)));
    page.and(sets.into_iter().map(|((rays, query), sets)| overview(rays, query, tuning.rule, &sets)))
}

/// The sets of the same rays, below all of them their mean.
fn overview(rays: &str, query: Query, rule: Rule, sets: &[&SetTuned<'_>]) -> Document {
    type Line<'a> = Option<&'a SetTuned<'a>>;
    let mean = |of: &dyn Fn(&SetTuned<'_>) -> Option<f64>| {
        // Over the same sets in every column, or the columns would not compare.
        let found: Option<Vec<f64>> = sets.iter().map(|set| of(set)).collect();
        found.map(|found| found.iter().sum::<f64>() / found.len() as f64)
    };
    let all: u64 = sets.iter().map(|set| set.rays.count).sum();
    let value = |label: Label| {
        Column::new(format!("{}: value, share ↑", label.name()), move |line: &Line<'_>| match line {
            Some(set) => Some(worth(set, label)),
            None => Some(Cell::Share(mean(&|set| set.score(set.chosen(label)?))?, None, all).describe()),
        })
    };
    let lost = |label: Label| {
        Column::new(format!("{} loses to tuned here ↓", label.name()), move |line: &Line<'_>| match line {
            Some(set) => loss(set, label),
            None => mean(&|set| set.lost(set.chosen(label)?, Label::TunedHere)).map(|loss| points(loss, all)),
        })
    };
    // Whatever is not tuned on the judged rays themselves.
    let losers = Label::ALL.into_iter().filter(|label| *label != Label::TunedHere);
    let sheet = Sheet::<Line<'_>>::new()
        .column("scene", |line| line.map_or("mean".to_owned(), |set| set.scene.name.clone()))
        .column("viewpoint", |line| line.map_or_else(|| format!("of {}", sets.len()), |set| set.viewpoint.name.clone()))
        .with(Label::ALL.map(value).into())
        .with(losers.map(lost).collect());
    let lines: Vec<Line<'_>> = sets.iter().copied().map(Some).chain([None]).collect();
    let by = accuracies(query).get(rule as usize).or(accuracies(query).first()).map_or("", |metric| metric.label);
    Document::default().rays(3, rays, format!("{rays}: {}, {by}", format::query(query))).table(sheet.table(&lines))
}

/// The value of a label, with the share of answers that are right by it.
fn worth(set: &SetTuned<'_>, label: Label) -> String {
    let Some(value) = set.chosen(label) else { return "nothing to choose by".to_owned() };
    let told = set.trace(value).and_then(|trace| match trace.judgement.one_sided() {
        Some(why) => Some(Cell::from(why)),
        None => set.right(value).and_then(|right| Some(Cell::Share(right.share?, right.interval, trials(trace)))),
    });
    format!("{value}: {}", Cell::from(told).describe())
}

/// What the value of a label loses to the best one, in bold where their intervals do not meet.
fn loss(set: &SetTuned<'_>, label: Label) -> Option<String> {
    let (own, best) = (set.chosen(label)?, set.chosen(Label::TunedHere)?);
    let text = points(set.lost(own, Label::TunedHere)?, trials(set.trace(own)?));
    let intervals = [own, best].map(|value| set.right(value)?.interval);
    let apart = matches!(intervals, [Some([low, high]), Some([least, most])] if high < least || most < low);
    Some(if apart { format!("**{text}**") } else { text })
}
