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
mod pictures;
mod pieces;
mod read;
mod records;
#[cfg(test)]
mod tests;
mod told;
mod write;

pub use again::quoted;
pub(super) use read::called;

use itertools::Itertools as _;

use super::document::Document;
use super::{ReportError, Section, Tables, summary, verdict};
use crate::results::Record;
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
pub type Makers = (Tables, Claims);

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

    /// Something of it that may be left out.
    fn piece(&self, rank: Rank, what: &str, html: String) -> Piece {
        Piece::heavy(rank, format!("{what} of {}", self.title()), self.tags(), html)
    }
}

/// Makes a page of records, each with where it was read from, in at most so many bytes. `missing` are measurements that were to be beside
/// them.
///
/// # Errors
/// If what tables are made of cannot be.
pub fn page(
    records: &[(String, Record)],
    missing: &[String],
    (tables, claims): Makers,
    command: &str,
    max_bytes: usize,
) -> Result<Page, ReportError> {
    let records = read::read(records);
    let Records { all, copies, .. } = &records;
    let names = Names::of(all);
    let fields: Vec<Vec<Field<'_>>> = all.iter().map(Read::fields).collect();
    let places = places(all, &fields);
    let pages = |section| records::pages(all, section, &names, tables);
    let rows: Vec<Record> =
        all.iter().filter(|read| read.record.table.is_some()).map(|read| read.record.clone().into_owned()).collect();
    let mut tables = pages(Section::Table)?;
    tables.extend(claims(&rows).iter().map(|page| records::claims(page, &names)));
    let rules = fronts::details("How it is measured and judged", "", &write::rules(RULES));
    let mut sections = vec![
        ("fronts", "Fronts", fronts::fronts(&places, &names)),
        ("operating-points", "Operating points", fronts::operating_points(&places, &names)),
        ("break-even", "Break-even", fronts::break_even(&places, &names)),
        ("pictures", "Pictures of answers", pictures::pictures(&places)),
        ("frames", "Frames", pictures::players(all)),
        ("need", "The need curve", pages(Section::Need)?),
        ("tables", "Tables and claims beside the published values", tables),
        ("matrix", "The matrix", pages(Section::Matrix)?),
        ("causes", "Causes of wrong answers", causes::causes(&places, &names)),
        ("studies", "Sweeps and other studies", pages(Section::Study)?),
        ("runs", "Runs in full", pages(Section::Run)?),
        ("machine", "Machines and records", vec![Piece::fixed(sources(all, &names))]),
        ("rules", "Rules", vec![Piece::fixed(rules)]),
    ];
    // Those that have nothing are not there.
    sections.retain(|(.., pieces)| !pieces.is_empty());
    let titles = sections.iter().map(|(id, title, _)| (*id, *title)).collect_vec();
    let chart = first_chart(&mut sections, first::hardest(&places).map(Place::title));
    let first = first::screen(&places, &records, &chart, &titles);
    let link = |(id, title): &(&str, &str)| format!("<li><a href=\"#{id}\">{title}</a></li>");
    let links: String = titles.iter().map(link).collect();
    let section = |(id, title, pieces): (&str, &str, Vec<Piece>)| {
        let begin = Piece::fixed(format!("<section id=\"{id}\"><h2>{title}</h2>\n"));
        std::iter::once(begin).chain(pieces).chain([Piece::fixed("</section>\n")])
    };
    let pieces: Vec<Piece> = sections.into_iter().flat_map(section).collect();
    let answer = answer::section(&places, &records, &names);
    let again = again::section(command, all);
    let copies: Vec<String> = copies.iter().map(|[copy, of]| format!("{copy}: the same as {of}")).collect();
    let title = if places.is_empty() { "what was measured" } else { "which tracer to take" };
    let heading = first::capitalised(title);
    // What is left out is named once more below.
    let copies = listed("Records that are given twice", &copies) + &listed("Not or not wholly measured", missing);
    let whole = |sections: &str, left_out: &str| {
        format!(
            include_str!("page.html"),
            title = title,
            heading = heading,
            style = STYLE,
            first = first,
            links = links,
            choices = choices(&names),
            answer = answer,
            sections = sections,
            left_out = left_out,
            again = again,
            script = SCRIPT,
        )
    };
    let (sections, dropped) = fit(&pieces, max_bytes.saturating_sub(whole("", &copies).len()));
    let nothing = if dropped.is_empty() { "<p>Nothing for want of room.</p>\n" } else { "" };
    let left_out = copies + nothing + &listed("For want of room", &dropped);
    Ok(Page { html: whole(&sections, &left_out), dropped })
}

/// Takes the chart out that stands on the first screen: the front of a place, or where there is none the first chart of all.
fn first_chart(sections: &mut [(&str, &str, Vec<Piece>)], place: Option<String>) -> String {
    let is_first = |piece: &mut Piece| match &place {
        Some(place) => piece.rank == Some(Rank::Front) && piece.what == format!("fronts of {place}"),
        None => piece.rank == Some(Rank::Chart),
    };
    let found = sections.iter_mut().find_map(|(.., pieces)| pieces.extract_if(.., is_first).next());
    found.map_or_else(String::new, |piece| piece.html)
}

fn places<'a>(all: &'a [Read<'a>], fields: &'a [Vec<Field<'a>>]) -> Vec<Place<'a>> {
    let mut places = Vec::new();
    for (number, (read, fields)) in all.iter().zip(fields).enumerate() {
        if verdict::controls(&read.record).is_empty() {
            places.extend(fields.iter().filter_map(|field| {
                let by = *By::all(field.query).last()?;
                Some(Place { read, number, field, by, is_shared: false })
            }));
        }
    }
    let case = |place: &Place<'a>| (place.field.scene.scene.name.as_str(), place.field.rays, place.read.machine);
    let cases: Vec<_> = places.iter().map(case).collect();
    for place in &mut places {
        place.is_shared = cases.iter().filter(|known| **known == case(place)).count() > 1;
    }
    places
}

/// A list with its title, where there is anything to list.
fn listed(title: &str, all: &[String]) -> String {
    let items: String = all.iter().map(|what| format!("<li>{}</li>", escape(what))).collect();
    if items.is_empty() { items } else { format!("<p>{title}:</p><ul>{items}</ul>\n") }
}

/// What can be left out.
fn choices(names: &Names) -> String {
    let choice = |(what, label, all): (&str, &str, &Vec<String>)| {
        let one = |name: &String| {
            let name = escape(name);
            format!("<label><input type=\"checkbox\" name=\"{what}\" value=\"{name}\" checked> {name}</label>")
        };
        let all: String = all.iter().map(one).collect();
        format!(
            "<details class=\"choice\"><summary>{label} <output></output></summary><fieldset><legend>{label}</legend>{all}</fieldset></details>"
        )
    };
    let Names { scenes, rays, tracers } = names;
    [("scene", "Scenes", scenes), ("rays", "Ray sets", rays), ("tracer", "Tracers", tracers)].map(choice).concat()
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
