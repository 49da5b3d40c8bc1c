//! `need.md`.

use super::{Shown, chart, contender, value_of};
use crate::report::chart::series::series;
use crate::report::document::{Document, Of};
use crate::report::format::{significant, thousands};
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::report::{metrics, summary};
use crate::results::{ChangedRays, NeedCurve, NeedRecord, Run};
use crate::studies::need::{Curve, Need, Step, Transfer, transfers};

/// The whole page.
pub(super) fn page(run: &Run, record: &NeedRecord, curves: &[Curve<'_>], shown: &[Shown<'_>]) -> Document {
    let head = summary::head(run, "What structures need").words(format!(
        "Every structure answers the same rays as smaller ones of its tracer. A smaller one is enough while the upper end of the 95 % \
         interval of newly wrong less newly right rays is at most {} % of them, and enough in time while its traces take at most {} times \
         as long besides. Shrinking a thing ends before its first step that is not enough; what is enough again behind that may be so by chance, and \
         counts only in the table of steps. Rays of analytic methods are right by `tight`, of methods that sample by `footprint`.",
        significant(record.most_lost_share * 100.0, 2),
        significant(record.most_times_as_long, 3)
    ));
    let sections = shown.iter().map(|each| {
        let (name, triangles) = (literal(&each.scene.name), thousands(each.scene.triangles));
        let of = Of { scene: Some(each.scene.name.clone()), rays: Some(each.rays.to_owned()) };
        let mut page = Document::default().headed(2, format!("{name} ({triangles} triangles), {}", each.rays), of);
        if let Some(chart) = chart(record, each) {
            page = page.chart(&each.chart, "rays lost over steps", series(run, chart));
        }
        if let Some((rays, unseen)) = each.curves.iter().find_map(|curve| curve.unseen_loss()) {
            page = page.words(format!(
                "**{} rays are few:** without a single answer that changes up to {} % of them might be lost, so steps may not be enough for \
                 want of rays.",
                thousands(rays),
                significant(unseen * 100.0, 2)
            ));
        }
        page.words("Bytes needed beside bytes stored and touched:").table(needs(each)).below("Every step:", steps(each))
    });
    head.and(sections).and(elsewhere(curves)).and(summary::skipped(&run.skipped))
}

/// A row a tracer and viewpoint.
fn needs(shown: &Shown<'_>) -> Table {
    let sheet = Sheet::<&Curve<'_>>::new()
        .told("tracer", |curve| contender(curve.record))
        .told("from", |curve| curve.record.viewpoint.clone())
        .told("rule", |curve| curve.record.rule.name())
        .told("right as a whole ↑", |curve| {
            if let Some(why) = curve.whole.trace.and_then(|trace| trace.judgement.one_sided()) {
                return Some(Cell::Text(why.to_owned()));
            }
            let (value, interval) = curve.whole.right()?;
            Some(Cell::Share(value, Some(interval), curve.whole.trace.map_or(0, metrics::trials)))
        })
        .told("stored (MiB)", |curve| bytes(&curve.whole))
        .told("touched (MiB)", |curve| curve.whole.touched_bytes().map(Cell::Bytes))
        .told("needed (MiB) ↓", |curve| bytes(curve.needed(false)))
        .told("by", |curve| by(curve.needed(false)))
        .told("needed in time (MiB) ↓", |curve| bytes(curve.needed(true)))
        .told("by", |curve| by(curve.needed(true)))
        .told("how far each may shrink", |curve| {
            let far = curve.axes.iter().map(|axis| format!("{}: {}", axis.name, until(&axis.need())));
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
pub(super) struct Row<'a> {
    pub curve: &'a Curve<'a>,
    pub step: &'a Step<'a>,
    /// What it has less of, for people.
    pub less: String,
}

/// The structures of a curve that have less of something.
fn smaller<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = Row<'a>> {
    let single = curve
        .axes
        .iter()
        .flat_map(|axis| axis.steps.iter().map(move |step| (format!("{}={}", axis.name, value_of(axis, step)), step)));
    let all = single.chain(curve.joint.iter().map(|step| (step.point.label(), step)));
    all.map(move |(less, step)| Row { curve, step, less })
}

/// All structures of a curve, the whole one first.
pub(super) fn structures<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = Row<'a>> {
    std::iter::once(Row { curve, step: &curve.whole, less: String::new() }).chain(smaller(curve))
}

/// What a smaller structure loses and takes.
pub(super) fn of_steps<'a>(sheet: Sheet<'a, Row<'a>>) -> Sheet<'a, Row<'a>> {
    let changed = |of: fn(ChangedRays) -> u64| move |row: &Row<'a>| row.step.changed.map(of);
    let lost = |row: &Row<'a>| row.step.lost().map(|(value, interval)| Cell::Percent(value, interval));
    let enough = |row: &Row<'a>| row.step.changed.map(|_| row.step.is_enough());
    let enough_in_time = |row: &Row<'a>| row.step.changed.map(|_| row.step.is_enough_in_time());
    sheet
        .column("rule", |row| row.curve.record.rule.name())
        .json("shrunk_json", |row| &row.step.point.shrunk)
        .column("touched_bytes", |row| row.step.touched_bytes())
        .column("compared_rays", changed(|changed| changed.rays))
        .column("newly_wrong_rays", changed(|changed| changed.newly_wrong))
        .column("newly_right_rays", changed(|changed| changed.newly_right))
        .and(Column::new("lost_share", lost).headed("rays lost (%) ↓"))
        .and(Column::new("is_enough", enough).headed("enough"))
        .and(Column::new("times_as_long", |row: &Row<'a>| row.step.times_as_long).headed("times as long ↓"))
        .and(Column::new("is_enough_in_time", enough_in_time).headed("enough in time"))
}

/// Every step.
fn steps(shown: &Shown<'_>) -> Table {
    let rows: Vec<Row<'_>> = shown.curves.iter().flat_map(|curve| smaller(curve)).collect();
    let sheet = Sheet::<Row<'_>>::new()
        .told("tracer", |row| contender(row.curve.record))
        .told("from", |row| row.curve.record.viewpoint.clone())
        .told("less of", |row| row.less.clone())
        .told("MiB ↓", |row| bytes(row.step))
        .then(of_steps);
    sheet.table(&rows)
}

/// Whether needs serve where they were not found.
fn elsewhere(curves: &[Curve<'_>]) -> Document {
    let place = |curve: &NeedCurve| format!("{} from {}", curve.scene, curve.viewpoint);
    let sheet = Sheet::<Transfer<'_>>::new()
        .told("tracer", |each| contender(each.from))
        .told("rays", |each| each.rays.to_owned())
        .told("found in", |each| place(each.from))
        .told("needs", |each| each.values_label())
        .told("tried in", |each| place(each.to))
        .told("rays lost there (%) ↓", |each| each.lost.map(|(value, interval)| Cell::Percent(value, interval)))
        .told("serves", |each| match each.serves {
            Some(true) => "yes",
            Some(false) => "**no**",
            None => "not measured",
        });
    let all = transfers(curves);
    let tried = all.iter().filter(|each| each.serves.is_some()).count();
    let served = all.iter().filter(|each| each.serves == Some(true)).count();
    let page = Document::default().heading(2, "Needs that are tried elsewhere");
    if tried == 0 {
        return page.words("None: there is no other viewpoint or scene, or nothing less than the whole is enough.");
    }
    page.words(format!("{served} of {tried} serve where they were not found.")).table(sheet.table(&all))
}
