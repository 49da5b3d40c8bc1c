//! The tables for other programs: `traces.csv` and `wrong_rays.csv`.

use std::collections::BTreeSet;

use super::cells::Row;
use super::format::end;
use super::group::Group;
use super::sheet::{Column, Columns, Sheet, Table};
use crate::results::{Judgement, Run, TraceRecord, WrongRay};

/// One row a ray set and tracer or control, with every scalar.
pub(super) fn traces(run: &Run, groups: &[Group<'_>]) -> Table {
    let rows = all_traces(groups);
    let sheet = Sheet::<Row<'_>>::new()
        .column("role", |(role, ..)| role.name())
        .scene(|(_, run, _)| &run.scene)
        .column("viewpoint", |(_, run, _)| run.viewpoint.name.clone())
        .all_sizes(|(_, run, _)| &run.viewpoint)
        .column("tracer", |(_, run, _)| run.label())
        .column("tracer_name", |(_, run, _)| run.tracer.name.clone())
        .column("tracer_preset", |(_, run, _)| run.tracer.preset.clone())
        .json("parameters_json", |(_, run, _)| &run.tracer.parameters)
        .column("residency", |(_, run, _)| run.tracer.residency.clone())
        .rays(|(.., trace)| Some(trace))
        .query(|(.., trace)| Some(trace.query))
        .column("end", |(.., trace)| end(trace.end))
        .clock("clock", |(.., trace)| Some(&trace.times))
        .clock("build_clock", |(_, run, _)| Some(run.build.first()))
        .hits(|(.., trace)| Some(trace))
        .whole_provenance(run)
        .metrics(&run.runs, |(_, run, trace)| Some((run, trace)))
        .with(of_maps(&rows));
    sheet.table(&rows)
}

/// Every wrong ray that the judge kept.
pub(super) fn wrong_rays(groups: &[Group<'_>]) -> Table {
    type Wrong<'a> = (Row<'a>, &'a WrongRay);
    let rows: Vec<Wrong<'_>> =
        all_traces(groups).into_iter().flat_map(|row| wrong_rays_of(row.2).iter().map(move |ray| (row, ray))).collect();
    let single = |value: f32| format!("{value:?}");
    let vector = |names: [&'static str; 3], of: fn(&WrongRay) -> [f32; 3]| {
        let part = |axis: usize| Column::new(names[axis], move |(_, ray): &Wrong<'_>| single(of(ray)[axis]));
        [0, 1, 2].map(part).into()
    };
    let sheet = Sheet::<Wrong<'_>>::new()
        .column("role", |((role, ..), _)| role.name())
        .scene_of(|((_, run, _), _)| (&run.scene.name, &run.scene.sha256))
        .column("viewpoint", |((_, run, _), _)| run.viewpoint.name.clone())
        .column("tracer", |((_, run, _), _)| run.label())
        .column("rays", |((.., trace), _)| trace.rays.clone())
        .query(|((.., trace), _)| Some(trace.query))
        .column("ray_index", |(_, ray)| ray.index)
        .with(vector(["origin_x_scene_units", "origin_y_scene_units", "origin_z_scene_units"], |ray| ray.origin))
        .with(vector(["direction_x", "direction_y", "direction_z"], |ray| ray.direction))
        .column("t_min_scene_units", |(_, ray)| single(ray.t_min))
        .column("t_max_scene_units", |(_, ray)| single(ray.t_max))
        .column("true_t_scene_units", |(_, ray)| ray.true_t)
        .column("true_primitive", |(_, ray)| ray.true_primitive)
        .column("answered_t_scene_units", |(_, ray)| ray.answered_t.map(single))
        .column("answered_primitive", |(_, ray)| ray.answered_primitive)
        .column("status", |(_, ray)| ray.status.clone())
        .column("class", |(_, ray)| ray.class.clone())
        .column("cause", |(_, ray)| ray.cause.clone());
    sheet.table(&rows)
}

fn all_traces<'a>(groups: &[Group<'a>]) -> Vec<Row<'a>> {
    let of_group = |group: &Group<'a>| group.ray_sets.iter().flat_map(|set| group.traces(set)).collect::<Vec<_>>();
    groups.iter().flat_map(of_group).collect()
}

fn wrong_rays_of(trace: &TraceRecord) -> &[WrongRay] {
    match &trace.judgement {
        Judgement::Closest(judgement) => &judgement.wrong_rays,
        Judgement::Any(judgement) => &judgement.wrong_rays,
    }
}

/// What only some traces have; all rows of a table must have the same.
fn of_maps<'a>(rows: &[Row<'a>]) -> Columns<'a, Row<'a>> {
    let traces = || rows.iter().map(|(.., trace)| *trace);
    let counters: BTreeSet<&'a String> = traces().flat_map(|trace| trace.counters.keys()).collect();
    let statuses: BTreeSet<&'a String> = traces().flat_map(|trace| trace.statuses.keys()).collect();
    let causes: BTreeSet<(&'a String, &'a String)> = traces()
        .flat_map(|trace| trace.judgement.causes())
        .flat_map(|(rule, causes)| causes.keys().map(move |cause| (rule, cause)))
        .collect();
    let mut columns: Columns<'a, Row<'a>> = Vec::new();
    for name in counters {
        let of = move |(.., trace): &Row<'a>| trace.counters.get(name);
        columns.push(Column::new(format!("counter_{name}_per_ray"), move |row| of(row).map(|each| each.per_ray)));
        let greatest = move |row: &Row<'a>| of(row).and_then(|each| each.greatest_per_ray);
        columns.push(Column::new(format!("counter_{name}_greatest_per_ray"), greatest));
        columns.push(Column::new(format!("counter_{name}_total"), move |row| of(row).map(|each| each.total)));
    }
    columns.extend(statuses.into_iter().map(|status| {
        Column::new(format!("status_{status}_rays"), move |(.., trace): &Row<'a>| trace.statuses.get(status).copied())
    }));
    columns.extend(causes.into_iter().map(|(rule, cause)| {
        let of = move |(.., trace): &Row<'a>| trace.judgement.causes().get(rule)?.get(cause).copied();
        Column::new(format!("cause_{rule}_{cause}_rays"), of)
    }));
    columns
}
