//! The tables of fronts: a row a point, an operating point, a pair of methods.

use tracebench_api::Query;

use super::Shown;
use crate::report::ReportError;
use crate::report::metrics;
use crate::report::tables::{code, number, to_csv};
use crate::results::{ParetoRecord, Run};
use crate::studies::pareto::{
    Aim, Amount, By, Check, Cost, Entry, Field, LEVELS, Overtaking, Wrong, best, check, classes, overtaking,
};

/// Every point on every ray set.
pub(super) const POINTS: &str = "pareto.csv";
/// The operating points.
pub(super) const OPERATING: &str = "operating_points.csv";
/// Who overtakes whom.
pub(super) const BREAK_EVEN: &str = "break_even.csv";

/// The rules and costs by which a point stands to a front, in the order of columns.
fn kinds(record: &ParetoRecord) -> Vec<(By, Cost)> {
    let rules = [By::all(Query::Closest), By::all(Query::Any)].concat();
    let costs = Cost::all(&record.rays_per_pixel);
    rules.into_iter().flat_map(|by| costs.iter().map(move |cost| (by, *cost)).collect::<Vec<_>>()).collect()
}

fn ends(amount: Option<Amount>) -> [String; 3] {
    let part = |of: fn(&Amount) -> f64| number(amount.as_ref().map(of));
    [part(|all| all.value), part(|all| all.interval[0]), part(|all| all.interval[1])]
}

/// How entries stand to their own front, by their places.
fn named<'a>(field: &Field<'a>, entries: &[Entry<'a>], cost: Cost, by: By) -> Vec<(usize, &'static str)> {
    let standings = field.standings(entries, cost, by).into_iter();
    standings.map(|(entry, _, standing)| (entry.index, standing.name())).collect()
}

/// A row a scene, ray set and point.
pub(super) fn points(run: &Run, record: &ParetoRecord, shown: &[Shown<'_>]) -> Result<Vec<u8>, ReportError> {
    let fixed = [
        "scene",
        "scene_sha256",
        "viewpoint",
        "rays",
        "rays_sha256",
        "query",
        "count_rays",
        "tracer",
        "preset",
        "order",
        "values_json",
        "parameters_json",
        "frame_px",
        "face_px",
        "hits_sha256",
    ];
    let costs = Cost::all(&record.rays_per_pixel);
    let kinds = kinds(record);
    let mut header: Vec<String> = fixed.map(str::to_owned).to_vec();
    for cost in &costs {
        let name = match cost {
            Cost::Trace => "trace_ms".to_owned(),
            Cost::Build => "build_ms".to_owned(),
            Cost::Bytes => "bytes".to_owned(),
            Cost::Frame(_) => format!("{}_ms", cost.code()),
        };
        header.extend(["", "_low", "_high"].map(|end| format!("{name}{end}")));
    }
    let rules = [By::all(Query::Closest), By::all(Query::Any)].concat();
    for by in &rules {
        header.extend(["", "_low", "_high"].map(|end| format!("wrong_{}{end}_share", by.name())));
        header.push(format!("wrong_{}_bound_share", by.name()));
    }
    for (by, cost) in &kinds {
        header.extend(["front", "own_front"].map(|front| format!("{front}_{}_{}", by.name(), cost.code())));
    }
    header.extend(["commit", "run_preset", "machine"].map(str::to_owned));
    let mut rows = vec![header];
    for field in shown.iter().flat_map(|scene| &scene.fronts.fields) {
        // By kind how every entry stands to the front of all, and to its tracer's own.
        let standing = |(by, cost): &(By, Cost)| {
            if !By::all(field.query).contains(by) {
                return [Vec::new(), Vec::new()];
            }
            let of_tracer = |tracer| named(field, &field.of_tracer(tracer), *cost, *by);
            let own = field.tracers().into_iter().flat_map(of_tracer).collect();
            [named(field, &field.entries, *cost, *by), own]
        };
        let standings: Vec<[Vec<(usize, &'static str)>; 2]> = kinds.iter().map(standing).collect();
        for entry in &field.entries {
            let (point, scene) = (entry.point, &field.scene.scene);
            let [width, height] = point.frame;
            let mut row = vec![
                scene.name.clone(),
                scene.sha256.clone(),
                field.viewpoint.name.clone(),
                field.rays.to_owned(),
                entry.trace.rays_sha256.clone(),
                code(field.query),
                field.count.to_string(),
                point.tracer.clone(),
                point.preset.clone(),
                point.order.to_string(),
                serde_json::to_string(&point.values).unwrap_or_default(),
                serde_json::to_string(&point.parameters).unwrap_or_default(),
                format!("{width}x{height}"),
                point.face.to_string(),
                entry.trace.hits_sha256.clone(),
            ];
            row.extend(costs.iter().flat_map(|cost| ends(field.cost(entry, *cost))));
            for by in &rules {
                let wrong = Wrong::of(entry.trace, *by).filter(|_| By::all(field.query).contains(by));
                row.extend(ends(wrong.map(|wrong| wrong.share)));
                row.push(number(wrong.map(|wrong| wrong.bound)));
            }
            for fronts in &standings {
                row.extend(fronts.each_ref().map(|front| {
                    let found = front.iter().find(|(index, _)| *index == entry.index);
                    found.map_or_else(String::new, |(_, name)| (*name).to_owned())
                }));
            }
            row.extend([run.provenance.commit.clone(), run.preset.clone(), run.provenance.machine.label()]);
            rows.push(row);
        }
    }
    to_csv(POINTS, rows)
}

/// A row a scene, ray set, rule, level, tracer and aim.
pub(super) fn operating(shown: &[Shown<'_>]) -> Result<Vec<u8>, ReportError> {
    let header = [
        "scene",
        "rays",
        "rule",
        "at_least_share",
        "of",
        "aim",
        "tracer",
        "preset",
        "values_json",
        "trace_ms",
        "build_ms",
        "bytes",
        "count_rays",
        "agreement_share",
        "checked_from",
        "checked_seed",
        "checked",
        "checked_agreement_share",
        "checked_agreement_low_share",
        "checked_agreement_high_share",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for scene in shown {
        let there = scene.fronts.scene.checked.as_ref();
        for field in &scene.fronts.fields {
            for by in By::all(field.query) {
                for level in LEVELS {
                    let all = std::iter::once(("all", field.entries.clone()));
                    let each = field.tracers().into_iter().map(|tracer| (tracer, field.of_tracer(tracer)));
                    for (who, entries) in all.chain(each) {
                        for aim in Aim::ALL {
                            let Some(found) = best(field, &entries, *by, level, aim) else { continue };
                            let (said, wrong) =
                                match check(&scene.fronts.elsewhere, field.rays, found.point, *by, level) {
                                    Check::Holds(wrong) => ("holds", Some(wrong)),
                                    Check::WithinNoise(wrong, _) => ("within_noise", Some(wrong)),
                                    Check::Misses(wrong, _) => ("misses", Some(wrong)),
                                    Check::NotMeasured => ("not_measured", None),
                                };
                            let value = |cost| number(field.cost(&found, cost).map(|amount| amount.value));
                            let right = |wrong: Wrong| wrong.share.times(-1.0).and(Amount::exact(1.0));
                            let mut row = vec![
                                field.scene.scene.name.clone(),
                                field.rays.to_owned(),
                                by.name().to_owned(),
                                level.to_string(),
                                who.to_owned(),
                                aim.name().to_owned(),
                                found.point.tracer.clone(),
                                found.point.preset.clone(),
                                serde_json::to_string(&found.point.values).unwrap_or_default(),
                                value(Cost::Trace),
                                value(Cost::Build),
                                value(Cost::Bytes),
                                metrics::trials(found.trace).to_string(),
                                number(Wrong::of(found.trace, *by).map(|wrong| 1.0 - wrong.share.value)),
                                there.map_or_else(String::new, |there| there.viewpoint.name.clone()),
                                there.map_or_else(String::new, |there| there.seed.to_string()),
                                said.to_owned(),
                            ];
                            row.extend(ends(wrong.map(right)));
                            rows.push(row);
                        }
                    }
                }
            }
        }
    }
    to_csv(OPERATING, rows)
}

/// A row a scene, ray set, rule, level, motion and pair of points of different tracers.
pub(super) fn break_even(shown: &[Shown<'_>]) -> Result<Vec<u8>, ReportError> {
    let header = [
        "scene",
        "rays",
        "rule",
        "at_least_share",
        "geometry",
        "one",
        "one_once_ms",
        "one_trace_ms",
        "one_per_ray_ms",
        "one_refitted",
        "other",
        "other_once_ms",
        "other_trace_ms",
        "other_per_ray_ms",
        "other_refitted",
        "verdict",
        "cheaper_below",
        "rays_a_frame",
        "rays_a_frame_low",
        "rays_a_frame_high",
        "beyond_measured",
        "why",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for scene in shown {
        for field in &scene.fronts.fields {
            for (by, level) in By::all(field.query).iter().flat_map(|by| LEVELS.map(|level| (*by, level))) {
                for class in classes(&scene.fronts, field, by, level) {
                    for (place, one) in class.costs.iter().enumerate() {
                        let others = class.costs[place + 1..].iter();
                        for other in others.filter(|other| other.entry.point.tracer != one.entry.point.tracer) {
                            let doubt = one.doubt.clone().or_else(|| other.doubt.clone());
                            let found = overtaking(&one.cost, &other.cost, doubt);
                            let mut row = vec![
                                field.scene.scene.name.clone(),
                                field.rays.to_owned(),
                                by.name().to_owned(),
                                level.to_string(),
                                class.motion.name().to_owned(),
                            ];
                            for cost in [one, other] {
                                let [trace, per_ray] = cost.cost.traces.parts();
                                row.push(cost.entry.point.label());
                                row.extend([cost.cost.once, trace, per_ray].map(|part| number(Some(part.value))));
                                row.push(cost.refitted.to_string());
                            }
                            let named = |who: usize| [one, other][who.min(1)].entry.point.label();
                            row.extend(match found {
                                Overtaking::Always(who) => [
                                    "always".to_owned(),
                                    named(who),
                                    String::new(),
                                    String::new(),
                                    String::new(),
                                    String::new(),
                                    String::new(),
                                ],
                                Overtaking::At { below, rays, interval: [low, high], beyond_measured } => [
                                    "overtakes".to_owned(),
                                    named(below),
                                    rays.to_string(),
                                    low.to_string(),
                                    high.to_string(),
                                    beyond_measured.to_string(),
                                    String::new(),
                                ],
                                Overtaking::Undecided(why) => [
                                    "undecided".to_owned(),
                                    String::new(),
                                    String::new(),
                                    String::new(),
                                    String::new(),
                                    String::new(),
                                    why,
                                ],
                            });
                            rows.push(row);
                        }
                    }
                }
            }
        }
    }
    to_csv(BREAK_EVEN, rows)
}
