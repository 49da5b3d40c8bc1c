//! Several records in one page that needs nothing else: which to choose, fronts whose points can be asked, everything else that their own
//! pages say.
//!
//! Tables are those of the records' own documents. Charts are drawn as elsewhere; fronts in two layers, so that tracers can be left out
//! while axes stay.

mod again;
mod answer;
mod budget;
mod causes;
mod first;
mod fronts;
mod in_short;
mod pictures;
mod pieces;
mod player;
mod read;
mod records;
#[cfg(test)]
mod tests;
mod told;
mod write;

pub use again::quoted;
pub(super) use read::called;

use super::document::Document;
use super::pareto::{Shown, shown};
use super::verdict::{self, Verdict};
use super::{ReportError, Section, Tables, summary};
use crate::results::{ParetoRecord, Record};
use crate::studies::pareto::{By, Field};
use pieces::{Piece, Rank, Tags, escape, fit};
use read::{Names, Read, Records};

/// The most bytes of a page.
pub const MAX_BYTES: usize = 10_000_000;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = concat!(include_str!("budget.js"), include_str!("page.js"));
const RULES: &str = include_str!("../../../../RULES.md");

/// Says what papers' claims come to by records of their tables, a page a paper. Claims know reports, reports know no claim.
pub type Claims = fn(&[Record]) -> Vec<Document>;

/// What a page is made of besides records.
#[derive(Clone, Copy)]
pub struct Makers {
    /// Tables.
    pub tables: Tables,
    /// Claims.
    pub claims: Claims,
}

/// A page.
#[derive(Debug)]
pub struct Page {
    /// It.
    pub html: String,
    /// What was left out for want of room.
    pub dropped: Vec<String>,
}

/// A ray set in a scene of a record that fronts are made of.
struct Place<'a> {
    read: &'a Read<'a>,
    /// The record's place among all.
    number: usize,
    section: &'a ParetoRecord,
    shown: &'a Shown<'a>,
    field: &'a Field<'a>,
    /// The rule that stands for all: by which charts show methods that sample.
    by: By,
    /// Whether another record answers the same.
    is_shared: bool,
}

impl Place<'_> {
    fn tags(&self) -> Tags<'_> {
        Tags { scene: Some(&self.field.scene.scene.name), rays: Some(self.field.rays), tracer: None }
    }

    fn title(&self) -> String {
        let section = if self.is_shared { format!(", record {}", self.read.name) } else { String::new() };
        format!("{}, {}, machine {}{section}", self.field.scene.scene.name, self.field.rays, self.read.machine)
    }
}

/// Makes a page of records, each with where it was read from, in at most so many bytes. `missing` are measurements that were to be beside
/// them.
///
/// # Errors
/// If a chart cannot be drawn.
pub fn page(
    records: &[(String, Record)],
    missing: &[String],
    makers: Makers,
    command: &str,
    max_bytes: usize,
) -> Result<Page, ReportError> {
    let Records { all, machines, copies } = read::read(records);
    let names = Names::of(&all);
    let shown: Vec<Vec<Shown<'_>>> = all
        .iter()
        .map(|read| read.points.as_ref().map_or_else(Vec::new, |points| shown(&read.record, points)))
        .collect();
    let places = places(&all, &shown);
    let mut sections = Sections::default();
    let pages = |section| records::pages(&all, section, &machines, &names, makers.tables);
    sections.add("fronts", "Fronts", fronts::fronts(&places, &machines, &names)?);
    sections.add("operating-points", "Operating points", fronts::operating_points(&places, &names));
    sections.add("break-even", "Break-even", fronts::break_even(&places, &machines, &names)?);
    sections.add("pictures", "Pictures of answers", pictures::pictures(&places, &machines));
    sections.add("frames", "Frames", player::players(&all));
    sections.add("need", "The need curve", pages(Section::Need)?);
    let rows: Vec<Record> =
        all.iter().filter(|read| read.record.table.is_some()).map(|read| read.record.clone().into_owned()).collect();
    let mut tables = pages(Section::Table)?;
    tables.extend((makers.claims)(&rows).iter().map(|page| records::claims(page, &names)));
    sections.add("tables", "Tables and claims beside the published values", tables);
    sections.add("matrix", "The matrix", pages(Section::Matrix)?);
    sections.add("causes", "Causes of wrong answers", causes::causes(&places, &names));
    sections.add("studies", "Sweeps and other studies", pages(Section::Study)?);
    sections.add("runs", "Runs in full", pages(Section::Run)?);
    sections.add("machine", "Machines and records", vec![Piece::Fixed(sources(&all, &names))]);
    sections.add(
        "rules",
        "Rules",
        vec![Piece::Fixed(fronts::details("How it is measured and judged", "", &write::rules(RULES)))],
    );
    let chart = sections.first_chart(first::hardest(&places).map(Place::title));
    let first = first::screen(&places, &all, &machines, &chart, &sections.titles);
    let head = head(&names, &sections, &first, &answer::section(&places, &all, &machines, &copies, &names));
    let foot = foot(&again::section(command, &all));
    // What is left out is named once more below.
    let copies = same(&copies) + &listed("Not or not wholly measured", missing);
    let room = max_bytes.saturating_sub(head.len() + copies.len() + foot.len());
    Ok(sections.finish(head, &copies, &foot, room))
}

fn places<'a>(all: &'a [Read<'a>], shown: &'a [Vec<Shown<'a>>]) -> Vec<Place<'a>> {
    let mut places = Vec::new();
    for (number, (read, shown)) in all.iter().zip(shown).enumerate() {
        let Some(section) = read.points.as_ref().filter(|_| verdict::controls(&read.record) == Verdict::Sound) else {
            continue;
        };
        for shown in shown {
            for field in &shown.fronts.fields {
                if let Some(by) = By::all(field.query).last() {
                    places.push(Place { read, number, section, shown, field, by: *by, is_shared: false });
                }
            }
        }
    }
    let case = |place: &Place<'a>| (place.field.scene.scene.name.as_str(), place.field.rays, place.read.machine);
    let cases: Vec<_> = places.iter().map(case).collect();
    for place in &mut places {
        place.is_shared = cases.iter().filter(|known| **known == case(place)).count() > 1;
    }
    places
}

/// Records that are the same as others.
fn same(copies: &[[String; 2]]) -> String {
    let told: Vec<String> = copies.iter().map(|[copy, of]| format!("{copy}: the same as {of}")).collect();
    listed("Records that are given twice", &told)
}

/// A list with its title, where there is anything to list.
fn listed(title: &str, all: &[String]) -> String {
    let items: String = all.iter().map(|what| format!("<li>{}</li>", escape(what))).collect();
    if items.is_empty() { items } else { format!("<p>{title}:</p><ul>{items}</ul>\n") }
}

/// Sections with their titles; those that have nothing are not there.
#[derive(Default)]
struct Sections {
    titles: Vec<(&'static str, &'static str)>,
    pieces: Vec<Piece>,
}

impl Sections {
    fn add(&mut self, id: &'static str, title: &'static str, pieces: Vec<Piece>) {
        if pieces.is_empty() {
            return;
        }
        self.titles.push((id, title));
        self.pieces.push(Piece::Fixed(format!("<section id=\"{id}\"><h2>{title}</h2>\n")));
        self.pieces.extend(pieces);
        self.pieces.push(Piece::Fixed("</section>\n".to_owned()));
    }

    /// Takes the chart out that stands on the first screen: the front of a place, or where there is none the first chart of all.
    fn first_chart(&mut self, place: Option<String>) -> String {
        let is_first = |piece: &Piece| match (piece, &place) {
            (Piece::Heavy { what, rank: Rank::Front, .. }, Some(place)) => *what == format!("fronts of {place}"),
            (Piece::Heavy { rank: Rank::Chart, .. }, None) => true,
            _ => false,
        };
        let Some(at) = self.pieces.iter().position(is_first) else { return String::new() };
        match self.pieces.remove(at) {
            Piece::Heavy { html, .. } | Piece::Fixed(html) => html,
        }
    }

    fn finish(self, head: String, copies: &str, foot: &str, room: usize) -> Page {
        let (middle, dropped) = fit(&self.pieces, room);
        let mut left_out =
            "<section id=\"left-out\"><h2>Left out</h2>\n<p>Pictures of answers that do not lie beside their record. "
                .to_owned();
        left_out += "Charts of fronts by the other rules, PNGs and tables for programs: <code>tracebench report FOLDER</code> writes them \
                     beside each record.</p>\n";
        left_out += copies;
        if dropped.is_empty() {
            left_out += "<p>Nothing for want of room.</p>\n";
        }
        left_out += &listed("For want of room", &dropped);
        left_out += "</section>\n";
        Page { html: head + &middle + &left_out + foot, dropped }
    }
}

fn head(names: &Names, sections: &Sections, first: &str, answer: &str) -> String {
    let links: String =
        sections.titles.iter().map(|(id, title)| format!("<li><a href=\"#{id}\">{title}</a></li>")).collect();
    let choice = |what: &str, label: &str, all: &[String]| {
        let one = |name: &String| {
            let name = escape(name);
            format!("<label><input type=\"checkbox\" name=\"{what}\" value=\"{name}\" checked> {name}</label>")
        };
        let all: String = all.iter().map(one).collect();
        format!(
            "<details class=\"choice\"><summary>{label} <output></output></summary><fieldset><legend>{label}</legend>{all}</fieldset></details>"
        )
    };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\"><title>tracebench: which tracer to take</title>\n<style>{STYLE}</style></head>\n\
         <body><header><h1>Which tracer to take</h1></header>\n{first}<nav aria-label=\"Sections\"><ul>{links}\
         <li><a href=\"#left-out\">Left out</a></li><li><a href=\"#again\">Make it again</a></li></ul></nav>\n\
         <form id=\"choice\" aria-label=\"What is shown\">{}{}{}<button type=\"reset\">Show all</button></form>\n<main>\n\
         <section id=\"answer\">{answer}</section>\n",
        choice("scene", "Scenes", &names.scenes),
        choice("rays", "Ray sets", &names.rays),
        choice("tracer", "Tracers", &names.tracers),
    )
}

/// Where every record is from.
fn sources(all: &[Read<'_>], names: &Names) -> String {
    let of = |read: &Read<'_>| {
        let mut page = summary::head(&read.record, "").and(summary::skipped(&read.record.skipped));
        // The title stands above.
        page.blocks.remove(0);
        let title = format!("{} (machine {}{})", read.name, read.machine, answer::doubts_in_short(&read.record));
        fronts::details(&title, "", &write::plain_html(&page, 3, names))
    };
    all.iter().map(of).collect()
}

fn foot(again: &str) -> String {
    format!(
        "{again}</main>\n<div id=\"tip\" role=\"tooltip\" hidden></div>\n<script>{SCRIPT}</script>\n</body></html>\n"
    )
}
