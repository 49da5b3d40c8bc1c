//! `pareto.md`.

use std::collections::BTreeSet;

use itertools::Itertools as _;

use super::{Shown, as_read, cost_name, csv};
use crate::rays::shared_centres;
use crate::report::chart::{break_even, front};
use crate::report::document::{Document, set_heading};
use crate::report::format::{edges, percent, percent_with_interval, significant, thousands};
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::report::{format, metrics, summary};
use crate::results::{MIN_ROUNDS, ParetoRecord, Record};
use crate::studies::pareto::{
    Aim, Amount, By, Check, Class, Cost, Entry, Field, FrontStatus, LEVELS, Wrong, best, check, classes, contested,
    farthest,
};

/// The share of rays through samples from which on a page warns.
const MAX_SHARED_CENTRES: f64 = 0.01;

/// The whole page.
pub(in crate::report) fn page(record: &Record, section: &ParetoRecord, shown: &[Shown<'_>]) -> Document {
    let tracers: BTreeSet<&str> = section.points.iter().map(|point| point.tracer.as_str()).collect();
    let head = summary::head(record, "Fronts of speed, build and bytes against error").paragraph(format!(
        "{} points of {} tracers, at most {} each, published and improved together. All times are by the host's clock, of work on a \
         device from submission until done. A point is on a front if none costs less and is as often right, or costs as much and is right \
         more often; controls are part of none. Errors below what so many rays tell from none, three of them, count as that.",
        section.points.len(),
        tracers.len(),
        section.max_points
    ));
    let sections = shown.iter().map(|scene| {
        let front = scene.scene;
        let here =
            format!("Points are chosen from viewpoint {} with seed {}", literal(&front.viewpoint.name), record.seed);
        let held_out = match (&front.held_out, &front.held_out_skipped) {
            (Some(there), _) => {
                let (viewpoint, seed) = (literal(&there.viewpoint.name), there.seed);
                format!("{here}, and told from {viewpoint} with seed {seed} (*there*).")
            }
            (None, Some(reason)) => format!("{here}. **They were not checked elsewhere**: {reason}."),
            (None, None) => format!("{here}. No point was chosen, so none was checked elsewhere."),
        };
        let fields = scene.fields.iter().map(|field| {
            let page = Document::default().rays(3, field.rays, set_heading(field.rays, field.query, field.count));
            page.and(By::all(field.query).iter().map(|by| by_rule(scene, field, *by)))
        });
        let page = Document::default()
            .scene(2, &front.scene, "")
            .paragraph(held_out)
            .paragraph(through_samples(section, scene));
        page.and(in_short(scene)).and(fields)
    });
    head.and(sections).and(summary::skipped(&record.skipped))
}

/// A warning where rays go through the very samples of some structures: `--size` may ask for that.
fn through_samples(section: &ParetoRecord, scene: &Shown<'_>) -> String {
    let image = scene.scene.viewpoint.ray_image;
    let is_shared = |frame: &[u32; 2]| shared_centres(image, *frame) > MAX_SHARED_CENTRES;
    let frames: BTreeSet<[u32; 2]> = section.points.iter().map(|point| point.frame).filter(is_shared).collect();
    if frames.is_empty() {
        return String::new();
    }
    let frames: Vec<String> = frames.into_iter().map(edges).collect();
    format!(
        "**Rays from {} pixels go through the samples of structures with frames of {}**: methods that sample are right there, whatever \
         they do elsewhere. Without `--size` no ray but one does so.",
        edges(image),
        frames.join(", ")
    )
}

/// Which to choose, by ray set and agreement: of any-hit sets by the balanced accuracy, of others by the rule that methods which sample can
/// meet.
fn in_short(scene: &Shown<'_>) -> Document {
    type Asked<'a> = (&'a Field<'a>, By, f64);
    let take = |aim: Aim| {
        aimed(aim, move |&(field, by, level): &Asked<'_>| {
            let Some(found) = best(field, &field.entries, by, level, aim) else { return "nobody".to_owned() };
            let there = check(field, found.point, by, level);
            let misses = if let Check::Misses(..) = there { "; **misses there**" } else { "" };
            format!("{}{misses}", with_cost(field, aim, &found))
        })
    };
    let sheet = Sheet::<Asked<'_>>::new()
        .column("rays", |(field, ..)| field.rays)
        .column("at least", |(field, by, level)| {
            format!("{} by {}{}", asked(*level), by.name(), too_few(*level, field))
        })
        .with(Aim::ALL.map(take).into());
    let fields = scene.fields.iter().filter_map(|field| Some((field, *By::all(field.query).last()?)));
    let rows: Vec<Asked<'_>> = fields.flat_map(|(field, by)| LEVELS.map(|level| (field, by, level))).collect();
    Document::of("In short:").table(sheet.table(&rows)).paragraph(checks(scene))
}

/// What became of all operating points elsewhere.
fn checks(scene: &Shown<'_>) -> String {
    let (mut holds, mut within_noise, mut misses, mut most) = (0, 0, 0, 0.0_f64);
    // A point with several aims is one.
    let of_tracers = csv::operating_points(scene.fields.iter()).into_iter().filter(|row| row.of != "all");
    for row in of_tracers.unique_by(|row| (row.field.rays, row.by.name(), row.level.to_bits(), row.found.index)) {
        match row.check() {
            Check::Holds(_) => holds += 1,
            Check::WithinNoise(_) => within_noise += 1,
            Check::Misses(_, missed) => (misses, most) = (misses + 1, most.max(missed)),
            Check::NotMeasured => {}
        }
    }
    let all = holds + within_noise + misses;
    if all == 0 {
        return String::new();
    }
    let by = if misses > 0 { format!(", by up to {} points", significant(most * 100.0, 2)) } else { String::new() };
    format!(
        "Of {all} operating points, of all tracers by every rule, {holds} hold there, {within_noise} are within noise of what \
         was asked, and {misses} miss{by}. A point with several aims counts once."
    )
}

/// A column of an aim, with what it makes least.
pub(in crate::report) fn aimed<'a, R, C: Into<Cell>>(aim: Aim, cell: impl Fn(&R) -> C + 'a) -> Column<'a, R> {
    Column::new(format!("{}: {}", aim.name(), cost_name(aim.cost())), cell)
}

/// An operating point with what it costs.
pub(in crate::report) fn with_cost(field: &Field<'_>, aim: Aim, found: &Entry<'_>) -> String {
    let cost = field.cost(found, aim.cost()).map(|cost| as_read(field, aim.cost(), cost).value);
    format!("{}: {}", found.point.label(), format::optional(cost, 4))
}

/// Everything by one rule: operating points, how far tracers get, who is on a front, who overtakes whom.
fn by_rule(scene: &Shown<'_>, field: &Field<'_>, by: By) -> Document {
    let name = by.name();
    let stem = |what: &str| scene.chart(field.rays, what);
    let speed = front::fronts(field, by, |cost| matches!(cost, Cost::Trace));
    let others = front::fronts(field, by, |cost| !matches!(cost, Cost::Trace));
    let mut page = Document::default().heading(4, format!("By {name}")).chart(stem(name), "fronts of speed", speed);
    // By the other rules they are much the same.
    if By::all(field.query).last() == Some(&by) {
        page = page.chart(stem(&format!("{name}_costs")), "fronts of first builds, bytes and frames", others);
        if let Some(matched) = front::matched(field, by) {
            page = page.chart(stem(&format!("{name}_matched")), "fronts at matched bytes and first build", matched);
        }
    }
    let tables = [operating_points(field, by), reach(field, by), front_points(field, by)];
    page.and(tables).and(break_even(field, by, stem("break_even")))
}

/// The operating points of every level: over all tracers, then of each.
pub(in crate::report) fn operating_points(field: &Field<'_>, by: By) -> Document {
    type Of<'a> = (f64, &'a str, Vec<Entry<'a>>);
    let found = |(level, _, entries): &Of<'_>, aim| {
        best(field, entries, by, *level, aim).map(|found| operating_point(field, by, *level, aim, &found))
    };
    let sheet = Sheet::<Of<'_>>::new()
        .column("at least", |(level, ..)| asked(*level) + &too_few(*level, field))
        .column("of", |(_, who, _)| (*who).to_owned())
        .with(Aim::ALL.map(|aim| aimed(aim, move |of: &Of<'_>| found(of, aim))).into());
    let mut rows: Vec<Of<'_>> = Vec::new();
    for level in LEVELS {
        rows.push((level, "**all**", field.entries.clone()));
        rows.extend(field.tracers().into_iter().map(|tracer| (level, tracer, field.of_tracer(tracer))));
    }
    rows.retain(|(level, _, entries)| Aim::ALL.iter().any(|aim| best(field, entries, by, *level, *aim).is_some()));
    if rows.is_empty() {
        return Document::of("No point is right so often.");
    }
    Document::of("Operating points; what they do *there* was not seen when they were chosen:").table(sheet.table(&rows))
}

/// A level as people read it.
pub(in crate::report) fn asked(level: f64) -> String {
    format!("{} %", percent(level, 10_000))
}

/// What follows a level where a ray set is too small to tell it: that none of N rays is wrong tells no more than that fewer than three of N
/// are.
pub(in crate::report) fn too_few(level: f64, field: &Field<'_>) -> String {
    let tells = field.count as f64 * (1.0 - level) >= 3.0 - 1e-9;
    if tells { String::new() } else { format!(" (**{} rays are too few to tell**)", thousands(field.count)) }
}

fn operating_point(field: &Field<'_>, by: By, level: f64, aim: Aim, found: &Entry<'_>) -> String {
    let trials = metrics::trials(found.trace);
    let there = match check(field, found.point, by, level) {
        Check::Holds(wrong) => format!("{}, holds", right(&wrong, trials)),
        Check::WithinNoise(wrong) => format!("{}, within noise", right(&wrong, trials)),
        Check::Misses(wrong, by) => {
            format!("{}, **misses by {} points**", right(&wrong, trials), significant(by * 100.0, 2))
        }
        Check::NotMeasured => "not checked".to_owned(),
    };
    format!("{}; there {there}", with_cost(field, aim, found))
}

/// The share of right answers with its interval.
pub(in crate::report) fn right(wrong: &Wrong, trials: u64) -> String {
    let [least, most] = wrong.share.interval;
    percent_with_interval(1.0 - wrong.share.value, Some([1.0 - most, 1.0 - least]), trials)
}

/// How far every tracer gets.
pub(in crate::report) fn reach(field: &Field<'_>, by: By) -> Document {
    type Reached<'a> = (&'a str, Entry<'a>, Wrong);
    let reached = |tracer| {
        let found = farthest(field, &field.of_tracer(tracer), by)?;
        Some((tracer, found, Wrong::of(found.trace, by)?))
    };
    let rows: Vec<Reached<'_>> = field.tracers().into_iter().filter_map(reached).collect();
    let sheet = Sheet::<Reached<'_>>::new()
        .column("tracer", |(tracer, ..)| (*tracer).to_owned())
        .column("farthest", |(_, found, wrong)| right(wrong, metrics::trials(found.trace)))
        .column("by", |(_, found, _)| found.point.label())
        .column(metrics::SPEED.heading(), |(_, found, _)| {
            field.cost(found, Cost::Trace).map(|cost| as_read(field, Cost::Trace, cost).value)
        });
    Document::of("How far each tracer gets:").table(sheet.table(&rows))
}

/// The points that are on a front of all tracers, or within noise of one.
pub(in crate::report) fn front_points<'a>(field: &Field<'a>, by: By) -> Document {
    type OnFront<'a> = (Entry<'a>, Wrong, Vec<&'static str>);
    let Field { record, section, .. } = *field;
    let costs = Cost::all(&section.rays_per_pixel);
    let front_statuses: Vec<_> = costs.iter().map(|cost| field.front_statuses(&field.entries, *cost, by)).collect();
    let of_entry = |entry: &Entry<'_>| {
        let mark = |of: &Vec<(Entry<'_>, _, FrontStatus)>| {
            let found = of.iter().find(|(other, ..)| other.index == entry.index);
            match found.map(|(_, _, front_status)| *front_status) {
                Some(FrontStatus::OnFront) => "● ",
                Some(FrontStatus::WithinNoise) => "○ ",
                _ => "",
            }
        };
        front_statuses.iter().map(mark).collect::<Vec<_>>()
    };
    let with_marks = |entry: &Entry<'a>| Some((*entry, Wrong::of(entry.trace, by)?, of_entry(entry)));
    let mut rows: Vec<OnFront<'_>> = field.entries.iter().filter_map(with_marks).collect();
    rows.retain(|(.., marks)| marks.iter().any(|mark| !mark.is_empty()));
    let of_cost = |(place, cost): (usize, &Cost)| {
        let cost = *cost;
        Column::new(cost_name(cost), move |(entry, _, marks): &OnFront<'_>| {
            let read = match field.cost(entry, cost).map(|amount| as_read(field, cost, amount)) {
                Some(Amount { value, interval }) if interval == [value; 2] => Cell::from(value),
                amount => amount.into(),
            };
            format!("{}{}", marks[place], read.describe())
        })
    };
    let sheet = Sheet::<OnFront<'_>>::new()
        .column("point", |(entry, ..)| entry.point.label())
        .column("wrong ↓", |(entry, wrong, _)| {
            let bound = if wrong.at_bound() { " (below what is told from none)" } else { "" };
            let share = Cell::Share(wrong.share.value, Some(wrong.share.interval), metrics::trials(entry.trace));
            format!("{}{bound}", share.describe())
        })
        .with(costs.iter().enumerate().map(of_cost).collect());
    let mut words =
        "● on the front of all tracers, ○ within noise of it: no point of the front is better by more than noise, in cost or in error."
            .to_owned();
    if record.rows.iter().any(|row| row.resident_batch > 0) {
        words += " Not all points were timed in one resident batch.";
    }
    if record.interleaved_sets.iter().any(|set| set.orders.len() < MIN_ROUNDS as usize) {
        words += &format!(" Times of fewer than {MIN_ROUNDS} rounds tell no two points apart: they are within noise.");
    }
    Document::of(words).table(sheet.table(&rows))
}

/// Who is cheapest at how many rays a frame.
pub(in crate::report) fn break_even(field: &Field<'_>, by: By, stem: String) -> Document {
    // A class, and a place among those who are cheapest there.
    type Cheapest<'a> = (&'a Class<'a>, usize);
    let classes: Vec<Class<'_>> = LEVELS.iter().flat_map(|level| classes(field, by, *level)).collect();
    let rows: Vec<Cheapest<'_>> =
        classes.iter().flat_map(|class| (0..class.stretches.len()).map(move |place| (class, place))).collect();
    let break_even = |(class, place): &Cheapest<'_>| {
        let (found, before) = (class.stretches[*place].overtakes.clone()?, class.stretches.get(place.checked_sub(1)?)?);
        Some((found, label(class, before.who)))
    };
    let sheet = Sheet::<Cheapest<'_>>::new()
        .column("at least", |(class, _)| asked(class.level))
        .column("geometry", |(class, _)| class.motion.name())
        .column("rays a frame", |row| {
            let Some((found, _)) = break_even(row) else { return Some("few".to_owned()) };
            let (rays, [low, high], beyond_measured) = found.at()?;
            let [rays, low, high] = [rays, low, high].map(|rays| thousands(rays.round().max(0.0) as u64));
            let beyond = if beyond_measured { ", beyond what was measured" } else { "" };
            Some(format!("{rays} [{low}, {high}]{beyond}"))
        })
        .column("cheapest", |(class, place)| label(class, class.stretches[*place].who))
        .column("overtakes", |row| {
            let (found, before) = break_even(row)?;
            let why = found.undecided().map_or_else(String::new, |why| format!(": undecided, {why}"));
            Some(before + &why)
        });
    let how = "Break-even, between points that are right as often: who is cheapest from how many rays a frame on (*static*: \
                    structures are kept; *refitted*: to moved vertices, built where a method cannot; *rebuilt*: in every frame)";
    if rows.is_empty() {
        return Document::of(format!("{how}: no point is right so often."));
    }
    let page = Document::of(format!("{how}:")).table(sheet.table(&rows));
    // By the last rule, by which charts show methods that sample.
    let contested = if By::all(field.query).last() == Some(&by) { contested(field, by) } else { Vec::new() };
    if contested.is_empty() {
        return page;
    }
    let chart = break_even::chart(field, &contested);
    page.chart(stem, "break-even", chart)
}

fn label(class: &Class<'_>, who: usize) -> String {
    class.costs.get(who).map_or_else(String::new, |cost| cost.entry.point.label())
}
