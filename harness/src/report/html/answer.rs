//! Which to choose for what, and why.

use std::fmt::Write as _;

use super::read::{Names, Read, Records};
use super::write::plain_html;
use super::{Place, budget, first};
use crate::report::document::Document;
use crate::report::format::{NONE, significant};
use crate::report::metrics;
use crate::report::pareto::page::{aimed, asked, right, too_few, with_cost};
use crate::report::pareto::{as_read, cost_name};
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::report::verdict;
use crate::results::Record;
use crate::studies::pareto::{Aim, By, Check, Entry, Field, LEVELS, Wrong, best, check, farthest};

/// The agreement that is asked for where one stands for all.
pub(super) const ASKED: f64 = LEVELS[1];

/// The answer in a sentence, which to choose and why, and every method.
pub(super) fn section(places: &[Place<'_>], records: &Records<'_>, names: &Names) -> String {
    let same = |[copy, of]: &[String; 2]| format!("{copy} (as {of})");
    let copies: Vec<String> = records.copies.iter().map(same).collect();
    let notes = doubts(&records.all)
        .paragraph(few("Left out, since the same record is there", &copies, "Left out"))
        .paragraphs((1..).zip(&records.machines).map(|(number, machine)| format!("Machine {number}: {machine}.")));
    let mut html = format!(
        "<div class=\"answer\">{}</div>\n<div class=\"notes\">{}</div>\n",
        first::in_short(places),
        plain_html(&notes, 3, names)
    );
    if places.is_empty() {
        return html;
    }
    html += &budget::section(places, ASKED);
    let how = "Closest hits are right by `footprint`, within a pixel; any hits by the balanced accuracy. Other rules stand under *operating \
               points*. Times are by the host's clock, of work on a device from submission until done.";
    let every = format!(
        "How often a method is right at best, and what it costs with at least {} right answers; **bold**: none costs less.",
        asked(ASKED)
    );
    let titled = |title: &str, words: &str, table| Document::default().heading(3, title).paragraph(words).table(table);
    let _ = write!(
        html,
        "{}<details><summary>At {} and {} agreement</summary>{}</details>\n{}",
        plain_html(&titled("Which to take, and why", how, needs(places, ASKED)), 1, names),
        asked(LEVELS[0]),
        asked(LEVELS[2]),
        plain_html(&Document::default().table(needs(places, LEVELS[0])).table(needs(places, LEVELS[2])), 1, names),
        plain_html(&titled("Every method", &every, methods(places)), 1, names),
    );
    html
}

/// So many records are named in a sentence; all stand further below.
const MAX_NAMED: usize = 2;

/// What speaks against records.
fn doubts(records: &[Read<'_>]) -> Document {
    let say = |of: fn(&Record) -> bool, what: &str| {
        let names: Vec<String> = records.iter().filter(|read| of(&read.record)).map(|read| read.name.clone()).collect();
        few(what, &names, "Machines and records")
    };
    Document::default()
        .paragraph(say(is_invalid, "Invalid, since a control fails, and part of no answer"))
        .paragraph(say(is_smoke, "Smoke runs, whose figures only show that things work"))
}

/// A sentence that names some, and of more than a few where they are told.
fn few(what: &str, all: &[String], below: &str) -> String {
    let named = all[..all.len().min(MAX_NAMED)].join(", ");
    match all.len().saturating_sub(MAX_NAMED) {
        _ if all.is_empty() => String::new(),
        0 => format!("**{what}:** {named}."),
        more => format!("**{what}:** {named} and {more} more, told below under *{below}*."),
    }
}

fn is_invalid(record: &Record) -> bool {
    !verdict::controls(record).is_empty()
}

pub(super) fn is_smoke(record: &Record) -> bool {
    record.preset == "smoke"
}

/// What speaks against a record, in a word or two.
pub(super) fn doubts_in_short(record: &Record) -> String {
    let of = [(is_invalid(record), ", invalid"), (is_smoke(record), ", smoke run")];
    of.iter().filter(|(is, _)| *is).map(|(_, word)| *word).collect()
}

/// A row a case and aim.
fn needs<'a>(places: &'a [Place<'a>], level: f64) -> Table {
    type Need<'a> = (&'a Place<'a>, Aim, Option<Entry<'a>>);
    let sheet = Sheet::<Need<'_>>::new()
        .column("rays", |(place, ..)| place.field.rays)
        .column("scene", |(place, ..)| Cell::Name(place.field.scene.scene.name.clone()))
        .column("machine", |(place, ..)| place.read.machine.to_string())
        .with(of_record(places, |(place, ..)| place))
        .column("right at least", move |(place, ..)| {
            format!("{} by {}{}", asked(level), place.by.name(), too_few(level, place.field))
        })
        .column("need", |(_, aim, _)| aim.name())
        .column("take", |(.., found)| found.map_or("nobody".to_owned(), |found| found.point.label()))
        .column("what it costs", |(place, aim, found)| {
            found.map(|found| format!("{}: {}", cost_name(aim.cost()), cost(place.field, *aim, &found).describe()))
        })
        .column("why", move |(place, aim, found)| match found {
            Some(found) => why(place, level, *aim, found),
            None => nobody(place),
        });
    let take = |place: &Place<'a>, aim| best(place.field, &place.field.entries, place.by, level, aim);
    let rows = places.iter().flat_map(|place| Aim::ALL.map(|aim| (place, aim, take(place, aim))));
    sheet.table(&rows.collect::<Vec<_>>())
}

/// The record of a row, where several answer the same.
fn of_record<'a, R>(places: &[Place<'_>], place: fn(&R) -> &Place<'a>) -> Vec<Column<'a, R>>
where
    R: 'a,
{
    let is_told = places.iter().any(|place| place.is_shared);
    is_told.then(|| Column::new("record", move |row: &R| place(row).read.name.clone())).into_iter().collect()
}

/// What a point costs.
fn cost(field: &Field<'_>, aim: Aim, found: &Entry<'_>) -> Cell {
    field.cost(found, aim.cost()).map(|cost| as_read(field, aim.cost(), cost).value).into()
}

fn right_share(place: &Place<'_>, entry: &Entry<'_>) -> String {
    let wrong = Wrong::of(entry.trace, place.by);
    wrong.map_or_else(|| NONE.to_owned(), |wrong| right(&wrong, metrics::trials(entry.trace)))
}

/// Who comes closest where nobody is right so often.
fn nobody(place: &Place<'_>) -> String {
    farthest(place.field, &place.field.entries, place.by).map_or_else(
        || "nobody was judged".to_owned(),
        |found| format!("the most is {}: {}", found.point.label(), right_share(place, &found)),
    )
}

/// How often a cost is another's, and what one that costs less is.
fn words(aim: Aim) -> [&'static str; 2] {
    match aim {
        Aim::Fastest => ["times as long", "faster"],
        Aim::Smallest => ["times as many bytes", "smaller"],
        Aim::QuickestBuilt => ["times as long to build", "quicker to build"],
    }
}

/// The best point of another tracer.
fn next<'a>(field: &Field<'a>, by: By, level: f64, aim: Aim, found: &Entry<'a>) -> Option<Entry<'a>> {
    let others: Vec<_> =
        field.entries.iter().copied().filter(|entry| entry.point.tracer != found.point.tracer).collect();
    best(field, &others, by, level, aim)
}

/// Whether another tracer's point may be as good as the best.
pub(super) fn is_within_noise(place: &Place<'_>, level: f64, aim: Aim, found: &Entry<'_>) -> bool {
    next(place.field, place.by, level, aim, found)
        .is_some_and(|next| !place.field.surely_cheaper(found, &next, aim.cost()))
}

/// Why a point is taken: how far the next tracer is, what would cost less but is right less often, and what became of it elsewhere.
fn why(place: &Place<'_>, level: f64, aim: Aim, found: &Entry<'_>) -> String {
    let (field, by, cost) = (place.field, place.by, aim.cost());
    let of = |entry: &Entry<'_>| field.cost(entry, cost).map_or(f64::INFINITY, |amount| amount.value);
    let [times, less] = words(aim);
    let mut said = vec![match next(field, by, level, aim, found) {
        None => "no other tracer is right so often".to_owned(),
        Some(next) => {
            let noise = if is_within_noise(place, level, aim, found) { ", within noise" } else { "" };
            let ratio = significant(of(&next) / of(found), 3);
            format!("the next tracer takes {ratio} {times}{noise} ({})", with_cost(field, aim, &next))
        }
    }];
    let cheaper = field.entries.iter().filter(|entry| of(entry) < of(found));
    if let Some(cheapest) = cheaper.min_by(|one, other| of(one).total_cmp(&of(other))) {
        said.push(format!("{} is {less} but right in {}", cheapest.point.label(), right_share(place, cheapest)));
    }
    said.push(match check(field, found.point, by, level) {
        Check::Holds(_) => "from another viewpoint it is right as often".to_owned(),
        Check::WithinNoise(_) => "from another viewpoint it is right as often within noise".to_owned(),
        Check::Misses(_, by) => {
            format!("**from another viewpoint it misses by {} points**", significant(by * 100.0, 2))
        }
        Check::NotMeasured => "it was not checked from another viewpoint".to_owned(),
    });
    said.join("; ")
}

/// A row a case and tracer.
fn methods(places: &[Place<'_>]) -> Table {
    type Method<'a> = (&'a Place<'a>, &'a str, Vec<Entry<'a>>);
    let of_aim = |aim| {
        aimed(aim, move |(place, tracer, own): &Method<'_>| {
            let text = cost(place.field, aim, &best(place.field, own, place.by, ASKED, aim)?).describe();
            let of_all = best(place.field, &place.field.entries, place.by, ASKED, aim);
            let is_best = of_all.is_some_and(|best| best.point.tracer == *tracer);
            Some(if is_best { format!("**{text}**") } else { text })
        })
    };
    let sheet = Sheet::<Method<'_>>::new()
        .column("rays", |(place, ..)| place.field.rays)
        .column("machine", |(place, ..)| place.read.machine.to_string())
        .with(of_record(places, |(place, ..)| place))
        .column("tracer", |(_, tracer, _)| (*tracer).to_owned())
        .column("scene", |(place, ..)| Cell::Name(place.field.scene.scene.name.clone()))
        .column("right at best", |(place, _, own)| {
            farthest(place.field, own, place.by).map(|found| right_share(place, &found))
        })
        .with(Aim::ALL.map(of_aim).into());
    let tracers = places.iter().flat_map(|place| place.field.tracers().into_iter().map(move |tracer| (place, tracer)));
    let rows = tracers.map(|(place, tracer)| (place, tracer, place.field.of_tracer(tracer)));
    sheet.table(&rows.collect::<Vec<_>>())
}
