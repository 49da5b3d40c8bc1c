//! A sweep: what its points measured, laid out along its axes. File `sweep.md`; the charts show the same.

mod choices;
#[cfg(test)]
pub(in crate::report) mod tests;

use std::borrow::Cow;

use itertools::Itertools as _;

use super::cells::{TableRow, Told, coverage};
use super::chart;
use super::document::Document;
use super::format::{file_stem, size};
use super::group::{Group, RaySet, Role, groups};
use super::markdown::literal;
use super::metrics::{BUILD_TIME, SPEED, STRUCTURE, USED};
use super::sheet::{self, Sheet};
use super::{Report, rows, summary};
use crate::results::{AxisRecord, PointRecord, Record, Row, SweepRecord, TraceRecord, gathered, place_name};
use crate::studies::sweep::RESOLUTION;
use crate::studies::tune::{Label, SetTuned, Tuning};
use choices::Tried;

/// What the names of a sweep's charts begin with.
pub(in crate::report) const STEM: &str = "sweep_";

/// One parameter over one ray set of one scene.
#[derive(Debug)]
pub(in crate::report) struct View<'a> {
    /// The scene with its viewpoint.
    pub group: &'a Group<'a>,
    /// The rays.
    pub set: &'a RaySet<'a>,
    /// What changes along it.
    pub axis: &'a AxisRecord,
    /// What tells the curves apart, if there are several.
    pub other: Option<&'a AxisRecord>,
    /// One, or one a value of the other axis of a grid.
    pub curves: Vec<Curve<'a>>,
    /// The values that would be chosen, where one is.
    pub tuned: Option<&'a SetTuned<'a>>,
}

/// Points along an axis.
#[derive(Debug)]
pub(in crate::report) struct Curve<'a> {
    /// Its value on the other axis of a grid.
    pub other: Option<&'a str>,
    /// In the order of the axis.
    pub cells: Vec<Cell<'a>>,
}

/// A point in a scene and ray set.
#[derive(Debug)]
pub(in crate::report) struct Cell<'a> {
    /// Its value on the axis.
    pub value: &'a str,
    /// Its record.
    pub point: &'a PointRecord,
    /// What was measured.
    pub measured: Option<(&'a Row, &'a TraceRecord)>,
}

impl View<'_> {
    /// The part of file names that distinguishes views.
    pub(in crate::report) fn stem(&self) -> String {
        format!("{STEM}{}_{}_{}", self.group.stem, file_stem(&self.axis.name), file_stem(&self.set.title))
    }
}

/// Every view of a sweep: of every scene every axis (of a grid the first), of every axis every ray set.
pub(in crate::report) fn views<'a>(
    sweep: &'a SweepRecord,
    groups: &'a [Group<'a>],
    tuning: Option<&'a Tuning<'a>>,
) -> Vec<View<'a>> {
    let axes = if sweep.grid { &sweep.axes[..sweep.axes.len().min(1)] } else { &sweep.axes[..] };
    let other = sweep.axes.get(1).filter(|_| sweep.grid);
    let mut views = Vec::new();
    for group in groups {
        for axis in axes {
            for set in &group.ray_sets {
                let curve = |value: Option<&'a str>| Curve {
                    other: value,
                    cells: cells(sweep, group, set, axis, other.zip(value).map(|(other, value)| (&*other.name, value))),
                };
                let curves: Vec<Curve<'_>> = match other {
                    Some(other) => other.values.iter().map(|value| curve(Some(value))).collect(),
                    None => vec![curve(None)],
                };
                // A file may name axes that no point is on.
                if curves.iter().any(|curve| !curve.cells.is_empty()) {
                    let mut measured = curves.iter().flat_map(|curve| &curve.cells).filter_map(|cell| cell.measured);
                    let tuned = measured.find_map(|(row, trace)| tuning?.set_of(row, trace));
                    views.push(View { group, set, axis, other, curves, tuned });
                }
            }
        }
    }
    views
}

fn cells<'a>(
    sweep: &'a SweepRecord,
    group: &Group<'a>,
    set: &RaySet<'_>,
    axis: &'a AxisRecord,
    other: Option<(&str, &str)>,
) -> Vec<Cell<'a>> {
    let others: Vec<(&str, &str)> = other.into_iter().collect();
    let cell = |value: &'a String| {
        let point = sweep.point(&axis.name, value, &others)?;
        let mut rows = group.configs.iter().filter(|row| row.tracer.name == sweep.tracer && point.is_of(row));
        let measured = rows.find_map(|row| Some((*row, row.traces.iter().find(|trace| set.holds(trace))?)));
        Some(Cell { value, point, measured })
    };
    axis.values.iter().filter_map(cell).collect()
}

/// What is made of a sweep beside what is made of its run: page, charts, and what each row has on the axes.
pub(super) fn report(record: &Record, sweep: &SweepRecord, groups: &[Group<'_>]) -> Report {
    let tuning = Tuning::of(record);
    let own = Sheet::<Tried<'_>>::new().json("values_json", |(point, _)| &point.values);
    let own = if tuning.is_some() { own.with(choices::columns()) } else { own };
    let tried = |row: &Row, trace: &TraceRecord| {
        let point = sweep.points.iter().find(|point| row.tracer.name == sweep.tracer && point.is_of(row))?;
        let tuned = tuning.as_ref().and_then(|tuning| {
            let value = point.values.get(&tuning.axis.name)?;
            Some((tuning.set_of(row, trace)?, value.as_str()))
        });
        Some((point, tuned))
    };
    let page = page(record, sweep, &views(sweep, groups, tuning.as_ref()), tuning.as_ref());
    Report::of_page("sweep.md", page).and(rows(record, groups, own, |(.., (_, row, trace))| tried(row, trace)))
}

/// What is made of a sweep by which a value is chosen: nothing was timed, and of its run alone there is nothing else to show.
pub(super) fn untimed(record: &Record) -> Option<Report> {
    Some(report(record, record.sweep.as_ref()?, &groups(record)))
}

/// The run as other tables and charts can show it: with the resolution in the labels of what was measured at another one
/// than the first point, and with controls once that ran again beside points tried alone and scored the same.
pub(super) fn labelled(record: &Record) -> Cow<'_, Record> {
    let Some(first) = record.sweep.as_ref().and_then(|sweep| sweep.points.first()) else {
        return Cow::Borrowed(record);
    };
    let mut record = record.clone();
    let points = record.sweep.as_ref().map(|sweep| sweep.points.clone()).unwrap_or_default();
    for one in &mut record.rows {
        let Some(point) = points.iter().find(|point| point.is_of(one)) else { continue };
        if let Some(value) =
            point.values.get(RESOLUTION).filter(|_| (point.frame, point.face) != (first.frame, first.face))
        {
            one.tracer.parameters.insert(RESOLUTION.to_owned(), serde_json::Value::from(value.clone()));
            one.tracer.changed.push(RESOLUTION.to_owned());
        }
    }
    let controls = std::mem::take(&mut record.controls);
    for control in controls {
        if !record.controls.iter().any(|other| scored_the_same(other, &control)) {
            record.controls.push(control);
        }
    }
    Cow::Owned(record)
}

fn scored_the_same(one: &Row, other: &Row) -> bool {
    let scores = |row: &Row| {
        let score = |trace: &TraceRecord| (trace.rays_sha256.clone(), trace.query, trace.judgement.clone());
        row.traces.iter().map(score).collect::<Vec<_>>()
    };
    one.scene == other.scene && one.tracer == other.tracer && scores(one) == scores(other)
}

/// The whole page.
fn page(record: &Record, sweep: &SweepRecord, views: &[View<'_>], tuning: Option<&Tuning<'_>>) -> Document {
    let own = sweep.axes.iter().map(|axis| format!("{}={}", axis.name, axis.own)).join(", ");
    let head = summary::head(record, &format!("Sweep of {}", sweep.tracer)).paragraph(format!(
        "{} points; {}. The tracer's own values, with an asterisk below: {own}. {}",
        sweep.points.len(),
        if sweep.grid { "all combinations of two parameters" } else { "one parameter changed at a time" },
        if tuning.is_some() { "Nothing was timed." } else { "All points were measured in turn, sample by sample." },
    ));
    let of_axis = |(_, views): (&str, Vec<&View<'_>>)| {
        let axis = views[0].axis;
        let page = Document::default().heading(3, &axis.name).paragraph(format!("{}.", axis.effect));
        page.and(views.into_iter().map(|view| section(record, view)))
    };
    let of_scene = |(_, views): (&str, Vec<&View<'_>>)| {
        let Group { scene, viewpoint, .. } = views[0].group;
        let from = if tuning.is_some() { format!(" from {}", literal(&viewpoint.name)) } else { String::new() };
        let page = Document::default().scene(2, scene, &from);
        let by_axis = gathered(views.into_iter().map(|view| (view.axis.name.as_str(), view)));
        page.and(by_axis.into_iter().map(of_axis))
    };
    let by_scene = gathered(views.iter().map(|view| (view.group.stem.as_str(), view)));
    let head = head.and(tuning.map(choices::section));
    head.and(by_scene.into_iter().map(of_scene)).and(summary::skipped(&record.skipped))
}

fn section(record: &Record, view: &View<'_>) -> Document {
    let set = view.set;
    let all: Vec<_> = view.curves.iter().flat_map(|curve| &curve.cells).collect();
    let rows: Vec<_> =
        all.iter().filter_map(|cell| cell.measured).map(|(row, trace)| (Role::Tracer, row, trace)).collect();
    let noted = [0, 1].map(|nth| place_name(view.group.scene, view.group.viewpoint, nth));
    let is_skipped = |point: &PointRecord| noted.iter().any(|place| point.skipped.contains_key(place));
    let mut sheet = Sheet::<Place<'_>>::new();
    if let Some(other) = view.other {
        sheet = sheet.column(&other.name, |(curve, _)| curve.other.map(str::to_owned));
    }
    sheet = sheet.column(&view.axis.name, |(_, cell)| {
        format!("{}{}", cell.value, if cell.value == view.axis.own { " *" } else { "" })
    });
    if [Some(view.axis), view.other].iter().flatten().any(|axis| axis.name == RESOLUTION) {
        sheet =
            sheet.column("frame, faces (px)", |(_, cell)| format!("{}, {}", size(cell.point.frame), cell.point.face));
    }
    let sheet = sheet
        .and(STRUCTURE.shown(|(_, cell): &Place<'_>| match cell.measured {
            Some((row, _)) => Some(sheet::Cell::Bytes(row.memory.structure_bytes as f64)),
            None => is_skipped(cell.point).then(|| "skipped, see below".into()),
        }))
        .structure(USED, |row| row.1.measured.map(|(row, _)| row));
    let sheet = match view.tuned {
        Some(tuned) => sheet.column("is", move |(_, cell)| tuned.labels(cell.value).map(Label::name).join(", ")),
        None => sheet
            .clock("build_clock", |row| row.1.measured.map(|(row, _)| row.build.first()))
            .builds(BUILD_TIME.label, |row| row.1.measured.map(|(row, _)| row))
            .own_clock()
            .taken(SPEED),
    };
    // How much of what is stored rays touched.
    let sheet = sheet.right(set.query).counted(&rows, |of_set| of_set);
    let places: Vec<Place<'_>> =
        view.curves.iter().flat_map(|curve| curve.cells.iter().map(move |cell| (curve, cell))).collect();
    set.headed(4, "")
        .chart(view.stem(), format!("{} over {}", set.title, view.axis.name), chart::sweep::chart(record, view))
        .paragraph(coverage(&rows))
        .table(sheet.table(&places))
}

/// A place along a curve.
type Place<'a> = (&'a Curve<'a>, &'a Cell<'a>);

impl Told for Place<'_> {
    fn told(&self) -> Option<TableRow<'_>> {
        self.1.measured.map(|(row, trace)| (Role::Tracer, row, trace))
    }
}
