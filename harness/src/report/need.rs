//! Needs: `need.md` and a chart a scene and ray set.

#[cfg(test)]
mod tests;

use std::ptr;

use itertools::Itertools as _;

use super::chart::Chart;
use super::chart::series::{Series, SeriesChart, SeriesPanel, series};
use super::document::{Document, Of};
use super::format::{self, significant, thousands};
use super::group::{gathered, groups, stems};
use super::markdown::literal;
use super::sheet::{Cell, Column, Sheet, Table};
use super::{Report, metrics, rows, summary};
use crate::results::{self, ChangedRays, NeedCurve, NeedRecord, Record, SceneRecord};
use crate::studies::need::{Axis, Curve, Need, Step, Transfer, curves, transfers};

/// The page.
pub const NEED_PAGE: &str = "need.md";

/// The least that is drawn, as a part of the limit: a logarithm has no place for structures whose answers got better.
const MIN_DRAWN: f64 = 0.1;

/// What the names of its charts begin with.
pub(in crate::report) const STEM: &str = "need_";

/// The curves of one ray set in one scene, from all of its viewpoints.
struct Shown<'a> {
    scene: &'a SceneRecord,
    rays: &'a str,
    curves: Vec<&'a Curve<'a>>,
    /// What its chart is called, without its end.
    chart: String,
}

/// What is made of needs: page, charts, and what smaller structures lose by rows.
pub(super) fn report(record: &Record) -> Option<Report> {
    let section = record.need.as_ref()?;
    let curves = curves(record, section);
    let steps = || curves.iter().flat_map(structures);
    let of_rows = rows(record, &groups(record), of_steps(Sheet::new()), |(.., (.., trace))| {
        steps().find(|row| row.step.trace.is_some_and(|own| ptr::eq(own, *trace)))
    });
    Some(Report::of_page(NEED_PAGE, page(record, section, &curves)).and(of_rows))
}

/// Curves by scene and ray set, in the order of first appearance.
fn shown<'a>(record: &'a Record, curves: &'a [Curve<'a>]) -> Vec<Shown<'a>> {
    let of_row = |curve: &'a Curve<'a>| Some((&record.rows.iter().find(|row| curve.section.holds(row))?.scene, curve));
    let placed: Vec<(&SceneRecord, &Curve<'_>)> = curves.iter().filter_map(of_row).collect();
    // Scenes of one name are distinguished; ray sets have their own part of the name.
    let scenes = placed.iter().map(|(scene, _)| [&*scene.name, &*scene.sha256, ""]).unique_by(|known| known[1]);
    let scenes = scenes.collect_vec();
    let stems = stems(&scenes);
    let by_set = gathered(placed.into_iter().map(|(scene, curve)| ((&scene.sha256, curve.rays), (scene, curve))));
    let of_set = |((sha256, rays), all): ((&String, &'a str), Vec<(&'a SceneRecord, &'a Curve<'a>)>)| {
        let place = scenes.iter().position(|known| known[1] == sha256).unwrap_or(0);
        let chart = format!("{STEM}{}_{}", stems[place], format::file_stem(rays));
        Shown { scene: all[0].0, rays, curves: all.into_iter().map(|(_, curve)| curve).collect(), chart }
    };
    by_set.into_iter().map(of_set).collect()
}

/// A tracer with its preset unless it is the published one.
fn config(curve: &NeedCurve) -> String {
    results::config(&curve.tracer, &curve.preset)
}

/// A panel a tracer and axis: what its steps lose, from every viewpoint. None where there is nothing to shrink.
fn chart(record: &Record, section: &NeedRecord, shown: &Shown<'_>) -> Option<Chart> {
    let limit = section.max_lost_share * 100.0;
    let mut panels = Vec::new();
    for (tracer, own) in gathered(shown.curves.iter().map(|curve| (config(curve.section), *curve))) {
        for axis in &own[0].axes {
            let steps: Vec<String> = axis.steps.iter().map(|step| value_of(axis, step)).collect();
            let of_curve = |curve: &&Curve<'_>| {
                let beside = curve.axes.iter().find(|other| other.name == axis.name)?;
                let of = |step: &String| beside.steps.iter().find(|other| value_of(beside, other) == *step);
                let drawn = |upper: f64| upper.max(section.max_lost_share * MIN_DRAWN) * 100.0;
                let values = steps.iter().map(|step| Some(drawn(of(step)?.lost()?.1[1]))).collect();
                Some(Series { label: format!("from {}", curve.section.viewpoint), values, dashed: false })
            };
            let label = format!("limit, {} %", significant(limit, 2));
            let limit = Series { label, values: vec![Some(limit); steps.len()], dashed: true };
            panels.push(SeriesPanel {
                title: format!("{tracer}: {}", axis.name),
                of: Some(tracer.clone()),
                setting: axis.name.to_owned(),
                series: own.iter().filter_map(of_curve).chain([limit]).collect(),
                steps,
                quantity: "rays lost, upper end (%), log".to_owned(),
            });
        }
    }
    let (name, triangles) = (&shown.scene.name, thousands(shown.scene.triangles));
    let chart = SeriesChart {
        stem: shown.chart.clone(),
        title: format!("The need curve: {name} ({triangles} triangles), {}", shown.rays),
        subtitle: format!(
            "newly wrong less newly right rays of smaller structures, upper end of the paired 95 % interval; what is below {} % is drawn there",
            significant(section.max_lost_share * MIN_DRAWN * 100.0, 2)
        ),
        key: Some(["found", "allowed"]),
        panels,
    };
    (!chart.panels.is_empty()).then(|| series(record, chart))
}

/// A step's value on its axis.
fn value_of(axis: &Axis<'_>, step: &Step<'_>) -> String {
    step.point.shrunk.get(axis.name).cloned().unwrap_or_default()
}

/// The whole page.
fn page(record: &Record, section: &NeedRecord, curves: &[Curve<'_>]) -> Document {
    let head = summary::head(record, "What structures need").paragraph(format!(
        "Every structure answers the same rays as smaller ones of its tracer. A smaller one is enough while the upper end of the 95 % \
         interval of newly wrong less newly right rays is at most {} % of them, and enough in time while its traces take at most {} times \
         as long besides. Shrinking a thing ends before its first step that is not enough; what is enough again behind that may be so by chance, and \
         counts only in the table of steps. Rays of analytic methods are right by `tight`, of methods that sample by `footprint`.",
        significant(section.max_lost_share * 100.0, 2),
        significant(section.max_slowdown, 3)
    ));
    let shown = shown(record, curves);
    let sections = shown.iter().map(|each| {
        let (name, triangles) = (literal(&each.scene.name), thousands(each.scene.triangles));
        let of = Of { scene: Some(each.scene.name.clone()), rays: Some(each.rays.to_owned()) };
        let mut page = Document::default().headed(2, format!("{name} ({triangles} triangles), {}", each.rays), of);
        if let Some(chart) = chart(record, section, each) {
            page = page.chart(&each.chart, "rays lost over steps", chart);
        }
        if let Some((rays, unseen)) = each.curves.iter().find_map(|curve| curve.unseen_loss()) {
            page = page.paragraph(format!(
                "**{} rays are few:** without a single answer that changes up to {} % of them might be lost, so steps may not be enough for \
                 want of rays.",
                thousands(rays),
                significant(unseen * 100.0, 2)
            ));
        }
        page.paragraph("Bytes needed beside bytes stored and touched:").table(needs(each)).below("Every step:", steps(each))
    });
    head.and(sections).and(elsewhere(curves)).and(summary::skipped(&record.skipped))
}

/// A row a tracer and viewpoint.
fn needs(shown: &Shown<'_>) -> Table {
    let sheet = Sheet::<&Curve<'_>>::new()
        .column("tracer", |curve| config(curve.section))
        .column("from", |curve| curve.section.viewpoint.clone())
        .column("rule", |curve| curve.section.rule.name())
        .column("right as a whole ↑", |curve| {
            if let Some(why) = curve.whole.trace.and_then(|trace| trace.judgement.one_sided()) {
                return Some(Cell::Text(why.to_owned()));
            }
            let (value, interval) = curve.whole.right()?;
            Some(Cell::Share(value, Some(interval), curve.whole.trace.map_or(0, metrics::trials)))
        })
        .column("stored (MiB)", |curve| bytes(&curve.whole))
        .column("touched (MiB)", |curve| curve.whole.touched_bytes().map(Cell::Bytes))
        .column("needed (MiB) ↓", |curve| bytes(curve.needed(false)))
        .column("by", |curve| by(curve.needed(false)))
        .column("needed in time (MiB) ↓", |curve| bytes(curve.needed(true)))
        .column("by", |curve| by(curve.needed(true)))
        .column("how far each may shrink", |curve| {
            let far = curve.axes.iter().map(|axis| format!("{}: {}", axis.name, until(&axis.need(false)))).join("; ");
            if far.is_empty() { "nothing shrinks".to_owned() } else { far }
        });
    sheet.table(&shown.curves)
}

fn bytes(step: &Step<'_>) -> Option<Cell> {
    step.bytes().map(|bytes| Cell::Bytes(bytes as f64))
}

/// What a structure has less of.
fn by(step: &Step<'_>) -> String {
    if step.point.shrunk.is_empty() { "the whole".to_owned() } else { step.point.label() }
}

/// A need in words.
fn until(need: &Need<'_>) -> String {
    match (need.smallest, need.too_small) {
        (Some(smallest), Some(too_small)) => format!("{smallest}, {too_small} is too small"),
        (Some(smallest), None) => format!("{smallest}, the smallest tried"),
        (None, Some(too_small)) => format!("not at all, {too_small} is too small"),
        (None, None) => "not measured".to_owned(),
    }
}

/// A structure beside the whole one.
struct TableRow<'a> {
    curve: &'a Curve<'a>,
    step: &'a Step<'a>,
    /// What it has less of, for people.
    less: String,
}

/// The structures of a curve that have less of something.
fn smaller<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = TableRow<'a>> {
    let single = curve
        .axes
        .iter()
        .flat_map(|axis| axis.steps.iter().map(move |step| (format!("{}={}", axis.name, value_of(axis, step)), step)));
    let all = single.chain(curve.joint.iter().map(|step| (step.point.label(), step)));
    all.map(move |(less, step)| TableRow { curve, step, less })
}

/// All structures of a curve, the whole one first.
fn structures<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = TableRow<'a>> {
    std::iter::once(TableRow { curve, step: &curve.whole, less: String::new() }).chain(smaller(curve))
}

/// What a smaller structure loses and takes.
fn of_steps<'a>(sheet: Sheet<'a, TableRow<'a>>) -> Sheet<'a, TableRow<'a>> {
    let changed = |of: fn(ChangedRays) -> u64| move |row: &TableRow<'a>| row.step.changed.map(of);
    let lost = |row: &TableRow<'a>| row.step.lost().map(|(value, interval)| Cell::Percent(value, interval));
    let enough = |row: &TableRow<'a>| row.step.changed.map(|_| row.step.is_enough(false));
    let enough_in_time = |row: &TableRow<'a>| row.step.changed.map(|_| row.step.is_enough(true));
    sheet
        .csv_column("rule", |row| row.curve.section.rule.name())
        .json("shrunk_json", |row| &row.step.point.shrunk)
        .csv_column("touched_bytes", |row| row.step.touched_bytes())
        .csv_column("compared_rays", changed(|changed| changed.rays))
        .csv_column("newly_wrong_rays", changed(|changed| changed.newly_wrong))
        .csv_column("newly_right_rays", changed(|changed| changed.newly_right))
        .and(Column::csv("lost_share", lost).headed("rays lost (%) ↓"))
        .and(Column::csv("is_enough", enough).headed("enough"))
        .and(Column::csv("times_as_long", |row: &TableRow<'a>| row.step.times_as_long).headed("times as long ↓"))
        .and(Column::csv("is_enough_in_time", enough_in_time).headed("enough in time"))
}

/// Every step.
fn steps(shown: &Shown<'_>) -> Table {
    let rows: Vec<TableRow<'_>> = shown.curves.iter().flat_map(|curve| smaller(curve)).collect();
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("tracer", |row| config(row.curve.section))
        .column("from", |row| row.curve.section.viewpoint.clone())
        .column("less of", |row| row.less.clone())
        .column("MiB ↓", |row| bytes(row.step));
    of_steps(sheet).table(&rows)
}

/// Whether needs serve where they were not found.
fn elsewhere(curves: &[Curve<'_>]) -> Document {
    let place = |curve: &NeedCurve| format!("{} from {}", curve.scene, curve.viewpoint);
    let sheet = Sheet::<Transfer<'_>>::new()
        .column("tracer", |each| config(each.from))
        .column("rays", |each| each.rays.to_owned())
        .column("found in", |each| place(each.from))
        .column("needs", |each| each.values_label())
        .column("tried in", |each| place(each.to))
        .column("rays lost there (%) ↓", |each| each.lost.map(|(value, interval)| Cell::Percent(value, interval)))
        .column("serves", |each| match each.serves {
            Some(true) => "yes",
            Some(false) => "**no**",
            None => "not measured",
        });
    let all = transfers(curves);
    let tried = all.iter().filter(|each| each.serves.is_some()).count();
    let served = all.iter().filter(|each| each.serves == Some(true)).count();
    let page = Document::default().heading(2, "Needs that are tried elsewhere");
    if tried == 0 {
        return page.paragraph("None: there is no other viewpoint or scene, or nothing less than the whole is enough.");
    }
    page.paragraph(format!("{served} of {tried} serve where they were not found.")).table(sheet.table(&all))
}
