//! `tune.csv`: a row a scene, viewpoint, ray set and value, also of what was skipped.

use super::{Errors, labels_of, score_at, trials};
use crate::judge::Rule;
use crate::report::ReportError;
use crate::report::tables::{code, number, to_csv};
use crate::results::Judgement;
use crate::studies::tune::{Label, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned, interval, score};

/// Its name.
pub(super) const NAME: &str = "tune.csv";

const HEADER: [&str; 45] = [
    "scene",
    "scene_sha256",
    "triangles",
    "viewpoint",
    "is_own_viewpoint",
    "frame_px",
    "face_px",
    "ray_image_px",
    "tracer",
    "parameters_json",
    "parameter",
    "unit",
    "value",
    "is_default",
    "is_tuned_here",
    "is_tuned_elsewhere",
    "is_tuned_on_other_scenes",
    "rays",
    "rays_sha256",
    "query",
    "count_rays",
    "ties_rays",
    "skipped",
    "hits_sha256",
    "rule",
    "score_share",
    "lost_to_default_share",
    "lost_to_tuned_here_share",
    "lost_to_tuned_elsewhere_share",
    "lost_to_tuned_on_other_scenes_share",
    "agreement_hit_miss_share",
    "agreement_hit_miss_low_share",
    "agreement_hit_miss_high_share",
    "agreement_tight_share",
    "agreement_tight_low_share",
    "agreement_tight_high_share",
    "agreement_footprint_share",
    "agreement_footprint_low_share",
    "agreement_footprint_high_share",
    "balanced_accuracy_share",
    "balanced_accuracy_low_share",
    "balanced_accuracy_high_share",
    "commit",
    "run_preset",
    "machine",
];

/// Wrong rays by the rule, between the accuracies and the provenance.
const CLASSES: [&str; 4] = ["false_miss_rays", "false_hit_rays", "early_rays", "late_rays"];

/// Columns of [`HEADER`] after [`CLASSES`].
const LAST: usize = 3;

/// The whole table.
pub(super) fn table(tuning: &Tuning) -> Result<Vec<u8>, ReportError> {
    let (first, last) = HEADER.split_at(HEADER.len() - LAST);
    let mut rows = vec![[first, &CLASSES, last].concat().into_iter().map(str::to_owned).collect()];
    for scene in &tuning.scenes {
        for (place, view) in scene.views.iter().enumerate() {
            for set in &view.sets {
                rows.extend(set.values.iter().map(|value| row(tuning, scene, (place, view), set, value)));
            }
        }
    }
    to_csv(NAME, rows)
}

fn row(
    tuning: &Tuning,
    SceneTuned { scene, .. }: &SceneTuned,
    (place, view): (usize, &ViewTuned),
    set: &SetTuned,
    value: &ValueTuned,
) -> Vec<String> {
    let viewpoint = &view.viewpoint;
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let mut parameters = tuning.tracer.parameters.clone();
    // All but the one that the row is about.
    parameters.remove(&tuning.axis.name);
    let mut row = vec![
        scene.name.clone(),
        scene.sha256.clone(),
        scene.triangles.to_string(),
        viewpoint.name.clone(),
        (place == 0).to_string(),
        size(viewpoint.frame),
        viewpoint.face.to_string(),
        size(viewpoint.ray_image),
        tuning.tracer.label(),
        serde_json::to_string(&parameters).unwrap_or_default(),
        tuning.axis.name.clone(),
        tuning.axis.unit.clone(),
        value.value.clone(),
    ];
    let labels = labels_of(set, &value.value);
    row.extend(Label::ALL.map(|label| labels.contains(&label).to_string()));
    let judgement = value.judged.as_ref().map(|judged| &judged.judgement);
    row.extend([set.rays.clone(), set.rays_sha256.clone(), code(set.query), set.count.to_string()]);
    row.push(judgement.map_or_else(String::new, |judgement| (set.count - trials(set, judgement)).to_string()));
    row.push(value.skipped.clone().unwrap_or_default());
    row.push(value.judged.as_ref().map(|judged| judged.hits_sha256.clone()).unwrap_or_default());
    row.push(tuning.rule.name().to_owned());
    let own = score_at(set, &value.value, tuning.rule);
    row.push(number(own));
    let score_of = |label| set.choice(label).and_then(|choice| choice.score);
    row.extend(Label::ALL.map(|label| number(score_of(label).zip(own).map(|(theirs, own)| theirs - own))));
    row.extend(accuracies(judgement));
    let errors = judgement.map(|judgement| Errors::of(judgement, tuning.rule));
    let count = |rays: Option<u64>| rays.map_or_else(String::new, |rays| rays.to_string());
    row.push(count(errors.map(|errors| errors.false_misses)));
    row.push(count(errors.map(|errors| errors.false_hits)));
    row.push(count(errors.and_then(|errors| errors.early)));
    row.push(count(errors.and_then(|errors| errors.late)));
    row.extend([tuning.provenance.commit.clone(), tuning.preset.clone(), tuning.provenance.machine.label()]);
    row
}

/// Shares with their intervals: three of closest-hit sets, then one of any-hit sets; those of the other kind empty.
fn accuracies(judgement: Option<&Judgement>) -> Vec<String> {
    let told = |judgement: Option<&Judgement>, rule| {
        let interval = judgement.and_then(|judgement| interval(judgement, rule));
        let share = judgement.and_then(|judgement| score(judgement, rule));
        [share, interval.map(|[low, _]| low), interval.map(|[_, high]| high)].map(number)
    };
    let closest = judgement.filter(|judgement| matches!(judgement, Judgement::Closest(_)));
    let any = judgement.filter(|judgement| matches!(judgement, Judgement::Any(_)));
    let cells = Rule::ALL.map(|rule| told(closest, rule));
    [cells.as_flattened(), &told(any, Rule::HitMiss)].concat()
}
