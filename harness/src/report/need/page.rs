//! `need.md`.

use std::fmt::Write as _;

use super::csv::{self, Row};
use super::{Shown, contender};
use crate::report::format::{significant, thousands};
use crate::report::markdown::{inline, literal};
use crate::report::metrics;
use crate::report::sheet::{Cell, Sheet};
use crate::report::summary;
use crate::results::{NeedCurve, NeedRecord, Run};
use crate::studies::need::{Curve, Need, Step, Transfer, transfers};

/// The whole page.
pub(super) fn page(run: &Run, record: &NeedRecord, curves: &[Curve<'_>], shown: &[Shown<'_>]) -> String {
    let mut text = summary::head(run, "What structures need");
    let _ = writeln!(
        text,
        "\nEvery structure answers the same rays as smaller ones of its tracer. A smaller one is enough while the upper end of the 95 % \
         interval of newly wrong less newly right rays is at most {} % of them, and enough in time while its traces take at most {} times \
         as long besides. Shrinking a thing ends before its first step that is not enough; what is enough again behind that may be so by chance, and \
         counts only in the table of steps. Rays of analytic methods are right by `tight`, of methods that sample by `footprint`.",
        significant(record.most_lost_share * 100.0, 2),
        significant(record.most_times_as_long, 3)
    );
    for each in shown {
        let name = literal(&each.scene.name);
        let _ = writeln!(text, "\n## {name} ({} triangles), {}", thousands(each.scene.triangles), inline(each.rays));
        if each.curves.iter().any(|curve| !curve.axes.is_empty()) {
            let _ = writeln!(text, "\n![rays lost over steps]({}.svg)", each.chart);
        }
        if let Some((rays, unseen)) = each.curves.iter().find_map(|curve| curve.unseen_loss()) {
            let _ = writeln!(
                text,
                "\n**{} rays are few:** without a single answer that changes up to {} % of them might be lost, so steps may not be enough for \
                 want of rays.",
                thousands(rays),
                significant(unseen * 100.0, 2)
            );
        }
        let _ = write!(text, "\nBytes needed beside bytes stored and touched:\n\n{}", needs(each));
        text += &steps(each);
    }
    text += &elsewhere(curves);
    text + &summary::skipped(&run.skipped)
}

/// A row a tracer and viewpoint.
fn needs(shown: &Shown<'_>) -> String {
    let bytes = |step: &Step<'_>| step.bytes().map(|bytes| Cell::Bytes(bytes as f64));
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
    sheet.markdown(&shown.curves)
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

/// Every step.
fn steps(shown: &Shown<'_>) -> String {
    let rows: Vec<Row<'_>> = shown.curves.iter().flat_map(|curve| csv::steps(curve)).collect();
    if rows.is_empty() {
        return String::new();
    }
    let sheet = Sheet::<Row<'_>>::new()
        .told("tracer", |row| contender(row.curve.record))
        .told("from", |row| row.curve.record.viewpoint.clone())
        .told("less of", |row| row.less.clone())
        .then(csv::of_steps);
    format!("\nEvery step:\n\n{}", sheet.markdown(&rows))
}

/// Whether needs serve where they were not found.
fn elsewhere(curves: &[Curve<'_>]) -> String {
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
    let head = "\n## Needs that are tried elsewhere\n\n";
    if tried == 0 {
        return format!(
            "{head}None: there is no other viewpoint or scene, or nothing less than the whole is enough.\n"
        );
    }
    format!("{head}{served} of {tried} serve where they were not found.\n\n{}", sheet.markdown(&all))
}
