//! Needs: `need.md` and a chart a scene.

#[cfg(test)]
mod tests;

use std::ptr;

use itertools::Itertools as _;

use super::chart::Chart;
use super::chart::series::errors;
use super::document::Document;
use super::format::{significant, thousands, with_interval};
use super::group::{groups, stems};
use super::sheet::{Cell, Column, Sheet, Table};
use super::{Report, metrics, rows, summary};
use crate::results::{self, ChangedRays, NeedCurve, NeedRecord, Record, SceneRecord, gathered, values_label};
use crate::studies::need::{Curve, OfTracer, Outcome, Step, Thumb, Tried, curves, rules};

/// What the names of its charts begin with.
pub(in crate::report) const STEM: &str = "need_";

/// The curves of one scene, from all of its viewpoints, by ray set.
struct Shown<'a> {
    scene: &'a SceneRecord,
    sets: Vec<(&'a str, Vec<&'a Curve<'a>>)>,
    /// What its chart is called, without its end.
    chart: String,
}

/// What is made of needs: page, charts, and what smaller structures lose by rows.
pub(super) fn report(record: &Record) -> Option<Report> {
    let section = record.need.as_ref()?;
    let curves = curves(record, section);
    let steps = || curves.iter().flat_map(structures);
    let of_rows = rows(record, &groups(record), of_steps(Sheet::new()), |(.., (.., trace))| {
        steps().find(|(_, step)| step.trace.is_some_and(|own| ptr::eq(own, *trace)))
    });
    Some(Report::of_page("need.md", page(record, section, &curves)).and(of_rows))
}

/// Curves by scene, in the order of first appearance.
fn shown<'a>(record: &'a Record, curves: &'a [Curve<'a>]) -> Vec<Shown<'a>> {
    let of_row = |curve: &'a Curve<'a>| Some((&record.rows.iter().find(|row| curve.section.holds(row))?.scene, curve));
    let placed = curves.iter().filter_map(of_row).map(|(scene, curve)| (&scene.sha256, (scene, curve)));
    let scenes = gathered(placed);
    // Scenes of one name are distinguished.
    let named = scenes.iter().map(|(sha256, all)| [&*all[0].0.name, sha256.as_str(), ""]);
    let stems = stems(&named.collect_vec());
    let of_scene = scenes.into_iter().zip(stems).map(|((_, all), stem)| {
        let scene = all[0].0;
        let sets = gathered(all.into_iter().map(|(_, curve)| (curve.rays, curve)));
        Shown { scene, sets, chart: format!("{STEM}{stem}") }
    });
    of_scene.collect()
}

/// A tracer with its preset unless it is the published one.
fn config(curve: &NeedCurve) -> String {
    results::config(&curve.tracer, &curve.preset)
}

/// A panel a ray set and kind of bytes: what is needed, and what rays touch, over what is stored, from every viewpoint. None where nothing tells.
fn chart(record: &Record, section: &NeedRecord, shown: &Shown<'_>) -> Option<Chart> {
    type Kind = (&'static str, fn(&Curve<'_>) -> Option<f64>);
    const KINDS: [Kind; 3] = [
        ("needed", |curve| curve.needed(false).bytes().map(|bytes| bytes as f64)),
        ("needed in time", |curve| curve.needed(true).bytes().map(|bytes| bytes as f64)),
        ("touched", |curve| curve.whole.touched_bytes()),
    ];
    let mib = |bytes: f64| bytes / f64::from(1 << 20);
    let panel = |((rays, curves), (kind, of)): (&(&str, Vec<&Curve<'_>>), Kind)| {
        let point =
            |curve: &&Curve<'_>| Some((config(curve.section), mib(curve.whole.bytes()? as f64), mib(of(curve)?)));
        (format!("{rays}: {kind} (MiB)"), curves.iter().filter_map(point).collect_vec())
    };
    let all =
        shown.sets.iter().cartesian_product(KINDS).map(panel).filter(|(_, points)| !points.is_empty()).collect_vec();
    let panels = all.iter().map(|(name, points)| (name.as_str(), points.clone())).collect_vec();
    let (name, triangles) = (&shown.scene.name, thousands(shown.scene.triangles));
    let titles = [
        format!("What structures need: {name} ({triangles} triangles)"),
        format!(
            "needed: the smallest that loses at most {} % of rays; what lies lower needs less of what is stored",
            significant(section.max_lost_share * 100.0, 2)
        ),
    ];
    (!panels.is_empty()).then(|| errors(record, titles, "stored (MiB)", &panels))
}

/// The whole page.
fn page(record: &Record, section: &NeedRecord, curves: &[Curve<'_>]) -> Document {
    let head = summary::head(record, "What structures need").paragraph(format!(
        "Every structure answers the same rays as smaller ones of its tracer. A smaller one is enough while the upper end of the 95 % \
         interval of newly wrong less newly right rays is at most {} % of them, and enough in time while its traces take at most {} times \
         as long besides. Shrinking a thing ends before its first step that is not enough; what is enough again behind that may be so by chance, and \
         counts only where every step is told, and in rules. Rays of analytic methods are right by `tight`, of methods that sample by `footprint`.",
        significant(section.max_lost_share * 100.0, 2),
        significant(section.max_slowdown, 3)
    ));
    let sections = shown(record, curves).into_iter().map(|each| {
        let page = Document::default().scene(2, each.scene, "");
        let page = match chart(record, section, &each) {
            Some(chart) => page.chart(&each.chart, "bytes needed and touched over bytes stored", chart),
            None => page,
        };
        page.and(each.sets.iter().map(|(rays, curves)| of_set(rays, curves)))
    });
    let rules = rules(curves);
    let told = (!rules.is_empty()).then(|| holds(&rules).and(thumbs(&rules, curves)));
    head.and(sections).and(told).and(summary::skipped(&record.skipped))
}

/// What is told of a ray set in a scene.
fn of_set(rays: &str, curves: &[&Curve<'_>]) -> Document {
    let few = curves.iter().find_map(|curve| curve.unseen_loss()).map(|(count, unseen)| {
        format!(
            "**{} rays are few:** without a single answer that changes up to {} % of them might be lost, so steps may not be enough for \
             want of rays.",
            thousands(count),
            significant(unseen * 100.0, 2)
        )
    });
    let page = Document::default().rays(3, rays, rays).paragraphs(few);
    page.paragraph("Bytes needed beside bytes stored and touched:")
        .table(needs(curves))
        .below("Every step:", steps(curves))
}

/// In how many of all cases steps are enough.
fn holds(rules: &[OfTracer<'_>]) -> Document {
    type Row<'a> = (&'a NeedCurve, &'a Tried<'a>);
    let count = |outcome: Option<Outcome>| {
        let name = outcome.map_or("not measured, or no smaller", Outcome::name);
        Column::new(name, move |(_, tried): &Row<'_>| tried.outcomes().filter(|own| *own == outcome).count() as u64)
    };
    let sheet = Sheet::<Row<'_>>::new()
        .column("tracer", |(tracer, _)| config(tracer))
        .column("less of", |(_, tried)| values_label(tried.values))
        .column("of the whole's bytes (%) ↓", |(_, tried)| share(tried))
        .column("cases", |(_, tried)| tried.outcomes().count() as u64)
        .with(Outcome::ALL.map(Some).into_iter().chain([None]).map(count).collect());
    let rows = rules.iter().flat_map(|(tracer, all, _)| all.iter().map(move |tried| (*tracer, tried))).collect_vec();
    let everywhere = rows.iter().filter(|(_, tried)| tried.outcome() == Some(Outcome::Enough)).count();
    let words = format!(
        "A case is a scene, viewpoint and ray set. Of {} smaller structures {everywhere} are enough in every case. One is undecided where the \
         interval of what it loses holds the limit, and not enough where all of that is beyond it. Bytes are the geometric mean over all cases.",
        rows.len()
    );
    Document::default().heading(2, "What holds").below(words, sheet.table(&rows))
}

/// The bytes of a structure, percent of the whole one's.
fn share(tried: &Tried<'_>) -> Cell {
    Cell::number(tried.share().map(|share| 100.0 * share), 3)
}

/// Rules of thumb, and what they lose where they were not made.
fn thumbs(rules: &[OfTracer<'_>], curves: &[Curve<'_>]) -> Document {
    type Row<'a> = (&'a NeedCurve, &'a Thumb<'a>);
    let page = Document::default().heading(2, "Rules of thumb");
    if curves.iter().map(|curve| &curve.section.scene_sha256).all_equal() {
        return page.paragraph("None: a rule needs two scenes, of which it is made of one and tried in the other.");
    }
    let sheet = Sheet::<Row<'_>>::new()
        .column("tracer", |(tracer, _)| config(tracer))
        .column("made of", |(_, (held_out, _))| {
            Cell::Name(held_out.map_or("all scenes".to_owned(), |scene| format!("all but {}", scene.scene)))
        })
        .column("rule", |(_, (_, tried))| {
            tried.as_ref().map_or("the whole".to_owned(), |tried| values_label(tried.values))
        })
        .column("there of the whole's bytes (%) ↓", |(_, (_, tried))| tried.as_ref().map_or(Cell::from(100.0), share))
        .column("rays lost there at worst (%) ↓", |(_, (_, tried))| {
            tried.as_ref().and_then(Tried::worst).and_then(lost)
        })
        .column("times as long there at most ↓", |(_, (_, tried))| {
            tried.as_ref().and_then(Tried::slowest).map(|ratio| with_interval(ratio.value, ratio.interval, 3))
        })
        .column("there it is", |(_, (_, tried))| {
            tried.as_ref().map(|tried| tried.outcome().map_or("not measured, or no smaller", Outcome::name))
        });
    let rows = rules.iter().flat_map(|(tracer, _, all)| all.iter().map(move |thumb| (*tracer, thumb))).collect_vec();
    let tried = rows.iter().filter_map(|(_, (held_out, tried))| held_out.and(tried.as_ref())?.outcome()).collect_vec();
    let enough = tried.iter().filter(|outcome| **outcome == Outcome::Enough).count();
    let words = format!(
        "A rule is the smallest structure, by its bytes as a share of the whole one's, that is enough in every case that it is made of. Each is \
         made of all scenes, and of all but one, which is then *there*: {enough} of {} that ask for less than the whole are enough there. Rays \
         lost are those of the worst viewpoint and ray set. What has nothing to shrink has no rule.",
        tried.len()
    );
    page.paragraph(words).table(sheet.table(&rows))
}

/// A row a tracer and viewpoint.
fn needs(curves: &[&Curve<'_>]) -> Table {
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
            let far = curve.axes.iter().map(|axis| format!("{}: {}", axis.name, until(axis.need(false)))).join("; ");
            if far.is_empty() { "nothing shrinks".to_owned() } else { far }
        });
    sheet.table(curves)
}

fn bytes(step: &Step<'_>) -> Option<Cell> {
    step.bytes().map(|bytes| Cell::Bytes(bytes as f64))
}

fn lost(step: &Step<'_>) -> Option<Cell> {
    step.lost().map(|(value, interval)| Cell::Percent(value, interval))
}

/// What a structure has less of.
fn by(step: &Step<'_>) -> String {
    if step.point.shrunk.is_empty() { "the whole".to_owned() } else { step.point.label() }
}

/// A need in words.
fn until(need: [Option<&str>; 2]) -> String {
    match need {
        [Some(smallest), Some(too_small)] => format!("{smallest}, {too_small} is too small"),
        [Some(smallest), None] => format!("{smallest}, the smallest tried"),
        [None, Some(too_small)] => format!("not at all, {too_small} is too small"),
        [None, None] => "not measured".to_owned(),
    }
}

/// A structure of a curve.
type TableRow<'a> = (&'a Curve<'a>, &'a Step<'a>);

/// All structures of a curve, the whole one first.
fn structures<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = TableRow<'a>> {
    std::iter::once(&curve.whole).chain(curve.steps()).map(move |step| (curve, step))
}

/// What a smaller structure loses and takes.
fn of_steps<'a>(sheet: Sheet<'a, TableRow<'a>>) -> Sheet<'a, TableRow<'a>> {
    let changed = |of: fn(ChangedRays) -> u64| move |(_, step): &TableRow<'a>| step.changed.map(of);
    let enough = |in_time: bool| move |(_, step): &TableRow<'a>| step.changed.map(|_| step.is_enough(in_time));
    sheet
        .csv_column("rule", |(curve, _)| curve.section.rule.name())
        .json("shrunk_json", |(_, step)| &step.point.shrunk)
        .csv_column("touched_bytes", |(_, step)| step.touched_bytes())
        .csv_column("compared_rays", changed(|changed| changed.rays))
        .csv_column("newly_wrong_rays", changed(|changed| changed.newly_wrong))
        .csv_column("newly_right_rays", changed(|changed| changed.newly_right))
        .and(Column::csv("lost_share", |(_, step): &TableRow<'a>| lost(step)).headed("rays lost (%) ↓"))
        .and(Column::csv("is_enough", enough(false)).headed("enough"))
        .and(Column::csv("times_as_long", |(_, step): &TableRow<'a>| step.times_as_long).headed("times as long ↓"))
        .and(Column::csv("is_enough_in_time", enough(true)).headed("enough in time"))
}

/// Every step.
fn steps(curves: &[&Curve<'_>]) -> Table {
    let rows: Vec<TableRow<'_>> = curves.iter().flat_map(|curve| structures(curve).skip(1)).collect();
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("tracer", |(curve, _)| config(curve.section))
        .column("from", |(curve, _)| curve.section.viewpoint.clone())
        .column("less of", |(_, step)| step.point.label())
        .column("MiB ↓", |(_, step)| bytes(step));
    of_steps(sheet).table(&rows)
}
