//! The tables for other programs: `rows.csv` and `wrong_rays.csv`.

use std::collections::BTreeSet;

use tracebench_api::Query;

use super::cells::Row;
use super::format::end;
use super::group::{Group, RaySet};
use super::metrics::{METRICS, Metric, with_ambiguous};
use super::sheet::{Cell, Column, Columns, Sheet, Table};
use crate::results::{Judgement, Run, TraceRecord, WayRecord, WrongRay};

/// A row of a record in its place.
pub(super) type Placed<'a> = (&'a Group<'a>, &'a RaySet<'a>, Row<'a>);

/// One row a ray set and tracer or control, with every scalar, and what a study tells of those that it is about.
pub(super) fn rows<'a, R: 'a>(
    run: &'a Run,
    groups: &'a [Group<'a>],
    own: Sheet<'a, R>,
    of: impl Fn(&Placed<'a>) -> Option<R>,
) -> Table {
    type Told<'a, R> = (Placed<'a>, Option<R>);
    let rows: Vec<Told<'a, R>> = placed(groups).map(|row| (row, of(&row))).collect();
    let beside = with_ambiguous(run.runs.iter().flat_map(|run| &run.traces));
    let metric = |metric| Metric::column(metric, |((.., (_, run, trace)), _): &Told<'a, R>| Some((run, trace)));
    let way = |of: fn(&WayRecord) -> Cell| {
        move |((.., (_, run, _)), _): &Told<'a, R>| run.way.as_ref().map_or(Cell::Absent, of)
    };
    let sheet = Sheet::<Told<'a, R>>::new()
        .column("role", |((.., (role, ..)), _)| role.name())
        .column("scene", |((group, ..), _)| group.scene.name.clone())
        .column("scene_sha256", |((group, ..), _)| group.scene.sha256.clone())
        .column("triangles", |((group, ..), _)| group.scene.triangles)
        .column("viewpoint", |((.., (_, run, _)), _)| run.viewpoint.name.clone())
        .column("animation_time_s", |((.., (_, run, _)), _)| run.viewpoint.time_s)
        .column("frame_px", |((.., (_, run, _)), _)| size(run.viewpoint.frame))
        .column("face_px", |((.., (_, run, _)), _)| run.viewpoint.face)
        .column("ray_image_px", |((.., (_, run, _)), _)| size(run.viewpoint.ray_image))
        .column("tracer", |((.., (_, run, _)), _)| run.label())
        .column("tracer_name", |((.., (_, run, _)), _)| run.tracer.name.clone())
        .column("tracer_preset", |((.., (_, run, _)), _)| run.tracer.preset.clone())
        .json("parameters_json", |((.., (_, run, _)), _)| &run.tracer.parameters)
        .column("residency", |((.., (_, run, _)), _)| run.tracer.residency.clone())
        .column("way", way(|way| way.name.clone().into()))
        .column("frame", way(|way| way.frame.map_or(Cell::Absent, Cell::from)))
        .column("stale_by", way(|way| way.stale_by.join(" ").into()))
        .column("rays", |((.., (.., trace)), _)| trace.rays.clone())
        .column("rays_sha256", |((.., (.., trace)), _)| trace.rays_sha256.clone())
        .column("query", |((.., (.., trace)), _)| query(trace.query))
        .column("end", |((.., (.., trace)), _)| end(trace.end))
        .clock("clock", |((.., (.., trace)), _)| Some(&trace.times))
        .clock("build_clock", |((.., (_, run, _)), _)| Some(run.build.first()))
        .column("hits_sha256", |((.., (.., trace)), _)| trace.hits_sha256.clone())
        .column("commit", |_| run.provenance.commit.clone())
        .column("dirty", |_| run.provenance.dirty)
        .column("run_preset", |_| run.preset.clone())
        .column("seed", |_| run.seed)
        .column("machine", |((.., (_, row, _)), _)| run.provenance.machine_of(row.machine).label())
        .with(METRICS.iter().chain(&beside).copied().map(metric).collect())
        .told_of(own, |(_, own)| own.as_ref())
        .told_of(Sheet::new().with(of_maps(&rows)), |((.., row), _)| Some(row));
    sheet.table(&rows)
}

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

fn query(query: Query) -> &'static str {
    match query {
        Query::Closest => "closest",
        Query::Any => "any",
    }
}

/// Every wrong ray that the judge kept.
pub(super) fn wrong_rays(groups: &[Group<'_>]) -> Table {
    type Wrong<'a> = (Row<'a>, &'a WrongRay);
    let rows: Vec<Wrong<'_>> =
        placed(groups).flat_map(|(.., row)| wrong_rays_of(row.2).iter().map(move |ray| (row, ray))).collect();
    let single = |value: f32| format!("{value:?}");
    let vector = |names: [&'static str; 3], of: fn(&WrongRay) -> [f32; 3]| {
        let part = |axis: usize| Column::new(names[axis], move |(_, ray): &Wrong<'_>| single(of(ray)[axis]));
        [0, 1, 2].map(part).into()
    };
    let sheet = Sheet::<Wrong<'_>>::new()
        .column("role", |((role, ..), _)| role.name())
        .column("scene", |((_, run, _), _)| run.scene.name.clone())
        .column("scene_sha256", |((_, run, _), _)| run.scene.sha256.clone())
        .column("viewpoint", |((_, run, _), _)| run.viewpoint.name.clone())
        .column("tracer", |((_, run, _), _)| run.label())
        .column("rays", |((.., trace), _)| trace.rays.clone())
        .column("query", |((.., trace), _)| query(trace.query))
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

fn placed<'a>(groups: &'a [Group<'a>]) -> impl Iterator<Item = Placed<'a>> {
    let of_set =
        |(group, set): (&'a Group<'a>, &'a RaySet<'a>)| group.traces(set).into_iter().map(move |row| (group, set, row));
    groups.iter().flat_map(|group| group.ray_sets.iter().map(move |set| (group, set))).flat_map(of_set)
}

fn wrong_rays_of(trace: &TraceRecord) -> &[WrongRay] {
    match &trace.judgement {
        Judgement::Closest(judgement) => &judgement.wrong_rays,
        Judgement::Any(judgement) => &judgement.wrong_rays,
    }
}

/// What only some rows have; all of a table must have the same.
fn of_maps<'a, R>(rows: &[(Placed<'a>, R)]) -> Columns<'a, Row<'a>> {
    let rows = || rows.iter().map(|((.., row), _)| *row);
    let traces = || rows().map(|(.., trace)| trace);
    let statistics: BTreeSet<&'a String> = rows().flat_map(|(_, run, _)| run.structure_statistics.keys()).collect();
    let counters: BTreeSet<&'a String> = traces().flat_map(|trace| trace.counters.keys()).collect();
    let statuses: BTreeSet<&'a String> = traces().flat_map(|trace| trace.statuses.keys()).collect();
    let causes: BTreeSet<(&'a String, &'a String)> = traces()
        .flat_map(|trace| trace.judgement.causes())
        .flat_map(|(rule, causes)| causes.keys().map(move |cause| (rule, cause)))
        .collect();
    let mut columns: Columns<'a, Row<'a>> = Vec::new();
    columns.extend(statistics.into_iter().map(|name| {
        Column::new(format!("structure_{name}"), move |(_, run, _): &Row<'a>| {
            run.structure_statistics.get(name).copied()
        })
    }));
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
