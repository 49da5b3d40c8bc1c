//! `need.md`.

use super::{Shown, chart, config, value_of};
use crate::report::chart::series::series;
use crate::report::document::{Document, Of};
use crate::report::format::{significant, thousands};
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::report::{metrics, summary};
use crate::results::{ChangedRays, NeedCurve, NeedRecord, Record};
use crate::studies::need::{Curve, Need, Step, Transfer, transfers};

/// The whole page.
pub(super) fn page(record: &Record, section: &NeedRecord, curves: &[Curve<'_>], shown: &[Shown<'_>]) -> Document {
    let head = summary::head(record, "What structures need").paragraph(format!(
        "Every structure answers the same rays as smaller ones of its tracer. A smaller one is enough while the upper end of the 95 % \
         interval of newly wrong less newly right rays is at most {} % of them, and enough in time while its traces take at most {} times \
         as long besides. Shrinking a thing ends before its first step that is not enough; what is enough again behind that may be so by chance, and \
         counts only in the table of steps. Rays of analytic methods are right by `tight`, of methods that sample by `footprint`.",
        significant(section.max_lost_share * 100.0, 2),
        significant(section.max_slowdown, 3)
    ));
    let sections = shown.iter().map(|each| {
        let (name, triangles) = (literal(&each.scene.name), thousands(each.scene.triangles));
        let of = Of { scene: Some(each.scene.name.clone()), rays: Some(each.rays.to_owned()) };
        let mut page = Document::default().headed(2, format!("{name} ({triangles} triangles), {}", each.rays), of);
        if let Some(chart) = chart(section, each) {
            page = page.chart(&each.chart, "rays lost over steps", series(record, chart));
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
            let far = curve.axes.iter().map(|axis| format!("{}: {}", axis.name, until(&axis.need(false))));
            let far: Vec<String> = far.collect();
            if far.is_empty() { "nothing shrinks".to_owned() } else { far.join("; ") }
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
pub(super) struct TableRow<'a> {
    pub curve: &'a Curve<'a>,
    pub step: &'a Step<'a>,
    /// What it has less of, for people.
    pub less: String,
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
pub(super) fn structures<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = TableRow<'a>> {
    std::iter::once(TableRow { curve, step: &curve.whole, less: String::new() }).chain(smaller(curve))
}

/// What a smaller structure loses and takes.
pub(super) fn of_steps<'a>(sheet: Sheet<'a, TableRow<'a>>) -> Sheet<'a, TableRow<'a>> {
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
        .column("MiB ↓", |row| bytes(row.step))
        .then(of_steps);
    sheet.table(&rows)
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
