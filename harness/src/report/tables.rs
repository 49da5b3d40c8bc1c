//! The tables for other programs: `rows.csv`, also that of several records (`report --csv`), and `wrong_rays.csv`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use itertools::Itertools as _;

use super::beside::{self, Place};
use super::cells::TableRow;
use super::format::{code, edges};
use super::group::{Group, RaySet, groups};
use super::html::called;
use super::metrics::{METRICS, Metric, with_ambiguous};
use super::sheet::{Cell, Column, Columns, Sheet, Table, csv};
use super::{Report, ReportError, Study, read_run};
use crate::results::{Record, Row, WrongRay};

/// A row of a record in its place.
pub(super) type Placed<'a> = (&'a Group<'a>, &'a RaySet<'a>, TableRow<'a>);

/// One row a ray set and tracer or control, with every scalar, and what a study tells of those that it is about; and every wrong ray that was
/// kept.
pub(super) fn rows<'a, R: 'a>(
    record: &'a Record,
    groups: &'a [Group<'a>],
    own: Sheet<'a, R>,
    of: impl Fn(&Placed<'a>) -> Option<R>,
) -> Report {
    type Told<'a, R> = (Placed<'a>, Option<R>);
    let rows: Vec<Told<'a, R>> = placed(groups).map(|row| (row, of(&row))).collect();
    let beside = with_ambiguous(record.rows.iter().flat_map(|row| &row.traces));
    let metric = |metric| Metric::column(metric, |((.., (_, row, trace)), _): &Told<'a, R>| Some((row, trace)));
    let sheet = Sheet::<Told<'a, R>>::new()
        .csv_column("role", |((.., (role, ..)), _)| role.name())
        .csv_column("scene", |((group, ..), _)| group.scene.name.clone())
        .csv_column("scene_sha256", |((group, ..), _)| group.scene.sha256.clone())
        .csv_column("triangles", |((group, ..), _)| group.scene.triangles)
        .csv_column("viewpoint", |((.., (_, row, _)), _)| row.viewpoint.name.clone())
        .csv_column("animation_time_s", |((.., (_, row, _)), _)| row.viewpoint.time_s)
        .csv_column("frame_px", |((.., (_, row, _)), _)| edges(row.viewpoint.frame))
        .csv_column("face_px", |((.., (_, row, _)), _)| row.viewpoint.face)
        .csv_column("ray_image_px", |((.., (_, row, _)), _)| edges(row.viewpoint.ray_image))
        .csv_column("tracer", |((.., (_, row, _)), _)| row.label())
        .csv_column("tracer_name", |((.., (_, row, _)), _)| row.tracer.name.clone())
        .csv_column("tracer_preset", |((.., (_, row, _)), _)| row.tracer.preset.clone())
        .json("parameters_json", |((.., (_, row, _)), _)| &row.tracer.parameters)
        .csv_column("residency", |((.., (_, row, _)), _)| row.tracer.residency.clone())
        .csv_column("update_mode", |((.., (_, row, _)), _)| {
            row.update_mode.as_ref().map_or(Cell::Absent, |mode| mode.name.clone().into())
        })
        .csv_column("rays", |((.., (.., trace)), _)| trace.rays.clone())
        .csv_column("rays_sha256", |((.., (.., trace)), _)| trace.rays_sha256.clone())
        .csv_column("query", |((.., (.., trace)), _)| code(trace.query))
        .csv_column("trace_to", |((.., (.., trace)), _)| code(trace.trace_to))
        .clock("clock", |((.., (.., trace)), _)| Some(&trace.times))
        .clock("build_clock", |((.., (_, row, _)), _)| Some(row.build.first()))
        .csv_column("hits_sha256", |((.., (.., trace)), _)| trace.hits_sha256.clone())
        .csv_column("commit", |_| record.provenance.commit.clone())
        .csv_column("dirty", |_| record.provenance.dirty)
        .csv_column("run_preset", |_| record.preset.clone())
        .csv_column("seed", |_| record.seed)
        .csv_column("machine", |((.., (_, row, _)), _)| record.provenance.machine_of(row.machine).label())
        .with(beside::columns(move |((group, set, row), _): &Told<'a, R>| Some((Place { record, group, set }, *row))))
        .with(METRICS.iter().chain(&beside).copied().map(metric).collect())
        .columns_of(own, |(_, own)| own.as_ref())
        .columns_of(Sheet::new().with(of_maps(&rows)), |((.., row), _)| Some(row));
    let tables = [("rows.csv", sheet.table(&rows)), ("wrong_rays.csv", wrong_rays(groups))];
    let tables = tables.map(|(name, table)| (name.to_owned(), table)).into();
    Report { tables, ..Report::default() }
}

/// The rows of records, those of controls among them, as `rows.csv` has those of one, with the record's name, its study and of cases the
/// difficulty level. A column is where a record has it; other rows are empty there.
///
/// # Errors
/// If a record cannot be read.
pub fn flat_table(paths: &[PathBuf], say: impl Fn(&str)) -> Result<Vec<u8>, ReportError> {
    let shown: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let names = called(&shown.iter().map(String::as_str).collect::<Vec<_>>());
    let mut columns: Vec<String> = ["record", "study"].map(str::to_owned).into();
    let mut rows: Vec<Vec<String>> = Vec::new();
    for ((path, shown), name) in paths.iter().zip(&shown).zip(names) {
        say(shown);
        let record = read_run(path)?;
        let record = &*record.aligned();
        let level = |row: &&Row| row.difficulty_level.map_or(Cell::Absent, Cell::from);
        let groups = groups(record);
        let own = Sheet::new().csv_column("difficulty_level", level);
        let made = self::rows(record, &groups, own, |(.., (_, row, _))| Some(*row));
        let table = made.tables[0].1.csv(&name)?;
        let mut lines = csv::ReaderBuilder::new().has_headers(false).from_reader(&*table).into_records().flatten();
        let header = lines.next().unwrap_or_default();
        columns = columns.into_iter().chain(header.iter().map(str::to_owned)).unique().collect();
        let place = |name: &str| columns.iter().position(|known| known == name);
        let places: Vec<usize> = header.iter().filter_map(place).collect();
        rows.extend(lines.map(|line| {
            let mut row = vec![String::new(); columns.len()];
            (row[0], row[1]) = (name.clone(), Study::of(record).verb.to_owned());
            places.iter().zip(&line).for_each(|(place, field)| field.clone_into(&mut row[*place]));
            row
        }));
    }
    rows.iter_mut().for_each(|row| row.resize(columns.len(), String::new()));
    csv("the table of rows", std::iter::once(columns).chain(rows))
}

/// Every wrong ray that the judge kept.
fn wrong_rays(groups: &[Group<'_>]) -> Table {
    type Wrong<'a> = (TableRow<'a>, &'a WrongRay);
    let rows: Vec<Wrong<'_>> =
        placed(groups).flat_map(|(.., row)| row.2.judgement.wrong_rays().iter().map(move |ray| (row, ray))).collect();
    let single = |value: f32| format!("{value:?}");
    let vector = |names: [&'static str; 3], of: fn(&WrongRay) -> [f32; 3]| {
        let part = |axis: usize| Column::csv(names[axis], move |(_, ray): &Wrong<'_>| single(of(ray)[axis]));
        [0, 1, 2].map(part).into()
    };
    let sheet = Sheet::<Wrong<'_>>::new()
        .csv_column("role", |((role, ..), _)| role.name())
        .csv_column("scene", |((_, row, _), _)| row.scene.name.clone())
        .csv_column("scene_sha256", |((_, row, _), _)| row.scene.sha256.clone())
        .csv_column("viewpoint", |((_, row, _), _)| row.viewpoint.name.clone())
        .csv_column("tracer", |((_, row, _), _)| row.label())
        .csv_column("rays", |((.., trace), _)| trace.rays.clone())
        .csv_column("query", |((.., trace), _)| code(trace.query))
        .csv_column("ray_index", |(_, ray)| ray.index)
        .with(vector(["origin_x_scene_units", "origin_y_scene_units", "origin_z_scene_units"], |ray| ray.origin))
        .with(vector(["direction_x", "direction_y", "direction_z"], |ray| ray.direction))
        .csv_column("t_min_scene_units", |(_, ray)| single(ray.t_min))
        .csv_column("t_max_scene_units", |(_, ray)| single(ray.t_max))
        .csv_column("true_t_scene_units", |(_, ray)| ray.true_t)
        .csv_column("true_primitive", |(_, ray)| ray.true_primitive)
        .csv_column("answered_t_scene_units", |(_, ray)| ray.answered_t.map(single))
        .csv_column("answered_primitive", |(_, ray)| ray.answered_primitive)
        .csv_column("status", |(_, ray)| ray.status.clone())
        .csv_column("class", |(_, ray)| ray.class.clone())
        .csv_column("cause", |(_, ray)| ray.cause.clone());
    sheet.table(&rows)
}

fn placed<'a>(groups: &'a [Group<'a>]) -> impl Iterator<Item = Placed<'a>> {
    let of_set =
        |(group, set): (&'a Group<'a>, &'a RaySet<'a>)| group.traces(set).into_iter().map(move |row| (group, set, row));
    groups.iter().flat_map(|group| group.ray_sets.iter().map(move |set| (group, set))).flat_map(of_set)
}

/// What only some rows have; all of a table must have the same.
fn of_maps<'a, R>(rows: &[(Placed<'a>, R)]) -> Columns<'a, TableRow<'a>> {
    let rows = || rows.iter().map(|((.., row), _)| *row);
    let traces = || rows().map(|(.., trace)| trace);
    let statistics: BTreeSet<&'a String> = rows().flat_map(|(_, row, _)| row.structure_statistics.keys()).collect();
    let counters: BTreeSet<&'a String> = traces().flat_map(|trace| trace.counters.keys()).collect();
    let statuses: BTreeSet<&'a String> = traces().flat_map(|trace| trace.statuses.keys()).collect();
    let causes: BTreeSet<(&'a String, &'a String)> = traces()
        .flat_map(|trace| trace.judgement.causes())
        .flat_map(|(rule, causes)| causes.keys().map(move |cause| (rule, cause)))
        .collect();
    let mut columns: Columns<'a, TableRow<'a>> = Vec::new();
    columns.extend(statistics.into_iter().map(|name| {
        Column::csv(format!("structure_{name}"), move |(_, row, _): &TableRow<'a>| {
            row.structure_statistics.get(name).copied()
        })
    }));
    for name in counters {
        let of = move |(.., trace): &TableRow<'a>| trace.counters.get(name);
        columns.push(Column::csv(format!("counter_{name}_per_ray"), move |row| of(row).map(|each| each.per_ray)));
        let greatest = move |row: &TableRow<'a>| of(row).and_then(|each| each.max_per_ray);
        columns.push(Column::csv(format!("counter_{name}_greatest_per_ray"), greatest));
        columns.push(Column::csv(format!("counter_{name}_total"), move |row| of(row).map(|each| each.total)));
    }
    columns.extend(statuses.into_iter().map(|status| {
        Column::csv(format!("status_{status}_rays"), move |(.., trace): &TableRow<'a>| {
            trace.statuses.get(status).copied()
        })
    }));
    columns.extend(causes.into_iter().map(|(rule, cause)| {
        let of = move |(.., trace): &TableRow<'a>| trace.judgement.causes().get(rule)?.get(cause).copied();
        Column::csv(format!("cause_{rule}_{cause}_rays"), of)
    }));
    columns
}
