//! `tune.csv`: a row a scene, viewpoint, ray set and value, also of what was skipped.

use tracebench_api::Query;

use super::{Errors, labels_of, score_at, trials};
use crate::report::metrics::{AMBIGUOUS, COUNT};
use crate::report::sheet::{Column, Sheet, Table};
use crate::results::Judgement;
use crate::studies::tune::{Label, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned};

/// A value on a ray set from a viewpoint.
struct Row<'a> {
    scene: &'a SceneTuned,
    /// The viewpoint's place in the scene.
    place: usize,
    view: &'a ViewTuned,
    set: &'a SetTuned,
    value: &'a ValueTuned,
}

impl Row<'_> {
    fn judgement(&self) -> Option<&Judgement> {
        self.value.judged.as_ref().map(|judged| &judged.judgement)
    }

    fn judged(&self) -> Option<(&Judgement, u64)> {
        self.judgement().map(|judgement| (judgement, trials(self.set, judgement)))
    }
}

fn rows(tuning: &Tuning) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    for scene in &tuning.scenes {
        for (place, view) in scene.views.iter().enumerate() {
            for set in &view.sets {
                rows.extend(set.values.iter().map(|value| Row { scene, place, view, set, value }));
            }
        }
    }
    rows
}

/// The whole table.
pub(super) fn table(tuning: &Tuning) -> Table {
    let axis = &tuning.axis;
    let mut parameters = tuning.tracer.parameters.clone();
    // All but the one that a row is about.
    parameters.remove(&axis.name);
    let is_chosen = |label: Label, name| {
        Column::new(name, move |row: &Row<'_>| labels_of(row.set, &row.value.value).contains(&label))
    };
    let score = |row: &Row<'_>| score_at(row.set, &row.value.value, tuning.rule);
    let lost_to = |label: Label, name| {
        let lost = move |row: &Row<'_>| Some(row.set.choice(label)?.score? - score(row)?);
        Column::new(name, lost)
    };
    let errors = |row: &Row<'_>| row.judgement().map(|judgement| Errors::of(judgement, tuning.rule));
    let sheet = Sheet::<Row<'_>>::new()
        .scene(|row| &row.scene.scene)
        .column("viewpoint", |row| row.view.viewpoint.name.clone())
        .column("is_own_viewpoint", |row| row.place == 0)
        .all_sizes(|row| &row.view.viewpoint)
        .constant("tracer", tuning.tracer.label())
        .json("parameters_json", |_| &parameters)
        .constant("parameter", axis.name.clone())
        .constant("unit", axis.unit.clone())
        .column("value", |row| row.value.value.clone())
        .with(NAMES.map(|(label, is, _)| is_chosen(label, is)).into())
        .column("rays", |row| row.set.rays.clone())
        .column("rays_sha256", |row| row.set.rays_sha256.clone())
        .query(|row| Some(row.set.query))
        .metric(COUNT, |row: &Row<'_>| Some(row.set.count.into()))
        .metric(AMBIGUOUS, |row: &Row<'_>| row.judgement().map(|judgement| judgement.ambiguous().into()))
        .column("skipped", |row| row.value.skipped.clone())
        .column("hits_sha256", |row| row.value.judged.as_ref().map(|judged| judged.hits_sha256.clone()))
        .constant("rule", tuning.rule.name())
        .column("score_share", score)
        .with(NAMES.map(|(label, _, lost)| lost_to(label, lost)).into())
        .accuracies_of(Query::Closest, Row::judged)
        .accuracies_of(Query::Any, Row::judged)
        .column("false_miss_rays", move |row| errors(row).map(|errors| errors.false_misses))
        .column("false_hit_rays", move |row| errors(row).map(|errors| errors.false_hits))
        .column("early_rays", move |row| errors(row).and_then(|errors| errors.early))
        .column("late_rays", move |row| errors(row).and_then(|errors| errors.late))
        .provenance(&tuning.provenance, &tuning.preset);
    sheet.table(&rows(tuning))
}

/// Columns of the values that were chosen: whether a value is one, and what it loses to it.
const NAMES: [(Label, &str, &str); 4] = [
    (Label::Default, "is_default", "lost_to_default_share"),
    (Label::TunedHere, "is_tuned_here", "lost_to_tuned_here_share"),
    (Label::TunedElsewhere, "is_tuned_elsewhere", "lost_to_tuned_elsewhere_share"),
    (Label::TunedOnOtherScenes, "is_tuned_on_other_scenes", "lost_to_tuned_on_other_scenes_share"),
];
