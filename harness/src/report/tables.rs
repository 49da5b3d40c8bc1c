//! The tables for other programs: `traces.csv` and `wrong_rays.csv`.

use std::collections::BTreeSet;

use super::ReportError;
use super::format::{clock_code, end};
use super::group::{Group, Role};
use super::metrics;
use crate::results::{Judgement, Run, TraceRecord, TracerRun, WrongRay};

/// One row a ray set and tracer or control, with every scalar.
pub(super) fn traces(run: &Run, groups: &[Group<'_>]) -> Result<Vec<u8>, ReportError> {
    let maps = MapColumns::of(groups);
    let fixed = [
        "role",
        "scene",
        "scene_sha256",
        "triangles",
        "viewpoint",
        "frame_px",
        "face_px",
        "ray_image_px",
        "tracer",
        "tracer_name",
        "tracer_preset",
        "parameters_json",
        "residency",
        "rays",
        "rays_sha256",
        "query",
        "end",
        "clock",
        "build_clock",
        "hits_sha256",
        "commit",
        "dirty",
        "run_preset",
        "seed",
        "machine",
    ];
    let metrics = metrics::COLUMNS.iter().map(|column| column.name.to_owned());
    let header: Vec<String> = fixed.map(str::to_owned).into_iter().chain(metrics).chain(maps.header()).collect();
    let mut rows = vec![header];
    for (role, one, trace) in all_traces(groups) {
        let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
        let mut row = vec![
            role.name().to_owned(),
            one.scene.name.clone(),
            one.scene.sha256.clone(),
            one.scene.triangles.to_string(),
            one.viewpoint.name.clone(),
            size(one.viewpoint.frame),
            one.viewpoint.face.to_string(),
            size(one.viewpoint.ray_image),
            one.label(),
            one.tracer.name.clone(),
            one.tracer.preset.clone(),
            serde_json::to_string(&one.tracer.parameters).unwrap_or_default(),
            one.tracer.residency.clone(),
            trace.rays.clone(),
            trace.rays_sha256.clone(),
            code(trace.query),
            end(trace.end),
            clock_code(trace.times.clock).to_owned(),
            clock_code(one.build.times.clock).to_owned(),
            trace.hits_sha256.clone(),
            run.provenance.commit.clone(),
            run.provenance.dirty.map_or_else(String::new, |dirty| dirty.to_string()),
            run.preset.clone(),
            run.seed.to_string(),
            run.provenance.machine.label(),
        ];
        row.extend(metrics::COLUMNS.iter().map(|column| number((column.value)(one, trace))));
        row.extend(maps.row(trace));
        rows.push(row);
    }
    to_csv("traces.csv", rows)
}

/// Every wrong ray that the judge kept.
pub(super) fn wrong_rays(groups: &[Group<'_>]) -> Result<Vec<u8>, ReportError> {
    let header = [
        "role",
        "scene",
        "scene_sha256",
        "viewpoint",
        "tracer",
        "rays",
        "query",
        "ray_index",
        "origin_x_scene_units",
        "origin_y_scene_units",
        "origin_z_scene_units",
        "direction_x",
        "direction_y",
        "direction_z",
        "t_min_scene_units",
        "t_max_scene_units",
        "true_t_scene_units",
        "true_primitive",
        "answered_t_scene_units",
        "answered_primitive",
        "status",
        "class",
        "cause",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for (role, run, trace) in all_traces(groups) {
        for ray in wrong_rays_of(trace) {
            let mut row = vec![
                role.name().to_owned(),
                run.scene.name.clone(),
                run.scene.sha256.clone(),
                run.viewpoint.name.clone(),
                run.label(),
                trace.rays.clone(),
                code(trace.query),
                ray.index.to_string(),
            ];
            let single = |value: f32| format!("{value:?}");
            row.extend(ray.origin.into_iter().chain(ray.direction).chain([ray.t_min, ray.t_max]).map(single));
            row.extend([number(ray.true_t), text(ray.true_primitive)]);
            row.extend([text(ray.answered_t.map(single)), text(ray.answered_primitive)]);
            row.extend([ray.status.clone(), ray.class.clone(), ray.cause.clone()]);
            rows.push(row);
        }
    }
    to_csv("wrong_rays.csv", rows)
}

fn all_traces<'a>(groups: &[Group<'a>]) -> Vec<(Role, &'a TracerRun, &'a TraceRecord)> {
    let of_group = |group: &Group<'a>| group.ray_sets.iter().flat_map(|set| group.traces(set)).collect::<Vec<_>>();
    groups.iter().flat_map(of_group).collect()
}

fn wrong_rays_of(trace: &TraceRecord) -> &[WrongRay] {
    match &trace.judgement {
        Judgement::Closest(judgement) => &judgement.wrong_rays,
        Judgement::Any(judgement) => &judgement.wrong_rays,
    }
}

/// Columns for what only some traces have; all rows of a table must have the same.
struct MapColumns {
    counters: BTreeSet<String>,
    statuses: BTreeSet<String>,
    causes: BTreeSet<(String, String)>,
}

impl MapColumns {
    fn of(groups: &[Group<'_>]) -> Self {
        let mut columns = Self { counters: BTreeSet::new(), statuses: BTreeSet::new(), causes: BTreeSet::new() };
        for (_, _, trace) in all_traces(groups) {
            columns.counters.extend(trace.counters.keys().cloned());
            columns.statuses.extend(trace.statuses.keys().cloned());
            for (rule, causes) in trace.judgement.causes() {
                columns.causes.extend(causes.keys().map(|cause| (rule.clone(), cause.clone())));
            }
        }
        columns
    }

    fn header(&self) -> Vec<String> {
        let counter = |name: &String| {
            [
                format!("counter_{name}_per_ray"),
                format!("counter_{name}_greatest_per_ray"),
                format!("counter_{name}_total"),
            ]
        };
        let counters = self.counters.iter().flat_map(counter);
        let statuses = self.statuses.iter().map(|status| format!("status_{status}_rays"));
        let causes = self.causes.iter().map(|(rule, cause)| format!("cause_{rule}_{cause}_rays"));
        counters.chain(statuses).chain(causes).collect()
    }

    fn row(&self, trace: &TraceRecord) -> Vec<String> {
        let counter = |name: &String| {
            trace.counters.get(name).map_or_else(
                || [String::new(), String::new(), String::new()],
                |counter| {
                    [
                        number(Some(counter.per_ray)),
                        counter.greatest_per_ray.map_or(String::new(), |greatest| greatest.to_string()),
                        counter.total.to_string(),
                    ]
                },
            )
        };
        let counters = self.counters.iter().flat_map(counter);
        let statuses = self.statuses.iter().map(|status| text(trace.statuses.get(status)));
        let cause = |(rule, cause): &(String, String)| {
            text(trace.judgement.causes().get(rule).and_then(|causes| causes.get(cause)))
        };
        counters.chain(statuses).chain(self.causes.iter().map(cause)).collect()
    }
}

/// The five columns that tell a trace's accuracy: shares by the three rules, balanced accuracy, ties.
pub(super) fn accuracy_columns(trace: &TraceRecord) -> [String; 5] {
    let closest = metrics::closest(trace).map(|verdict| &verdict.agreement);
    let balanced = metrics::any(trace).and_then(|verdict| verdict.occlusion.balanced_accuracy);
    [
        number(closest.and_then(|agreement| agreement.hit_miss)),
        number(closest.and_then(|agreement| agreement.tight)),
        number(closest.and_then(|agreement| agreement.footprint)),
        number(balanced),
        metrics::ties(&trace.judgement).to_string(),
    ]
}

pub(super) fn code(query: tracebench_api::Query) -> String {
    match query {
        tracebench_api::Query::Closest => "closest".to_owned(),
        tracebench_api::Query::Any => "any".to_owned(),
    }
}

/// The shortest text that reads back as the same number; whole numbers without a point.
pub(super) fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value.fract() == 0.0 && value.abs() < 1e15 => format!("{value:.0}"),
        Some(value) if value.is_finite() => format!("{value:?}"),
        _ => String::new(),
    }
}

fn text(value: Option<impl ToString>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

pub(super) fn to_csv(name: &str, rows: Vec<Vec<String>>) -> Result<Vec<u8>, ReportError> {
    let fail = |reason: String| ReportError::Made { what: name.to_owned(), reason };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(&row).map_err(|error| fail(error.to_string()))?;
    }
    writer.into_inner().map_err(|error| fail(error.to_string()))
}
