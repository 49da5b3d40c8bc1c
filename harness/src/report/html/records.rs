//! Pages of records that are no fronts, with their charts: tables of papers, matrices, sweeps and all others.

use std::cell::RefCell;

use super::fronts::details;
use super::markdown::{caption, figure, html};
use super::pieces::{Piece, Rank, Tags};
use super::read::{Names, Read};
use crate::report::need::{self, NeedPage};
use crate::report::{Contents, ReportError, SUMMARY, Tables, derived};
use crate::results::Run;

/// Where a record's pages stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Fronts, which have sections of their own.
    Fronts,
    /// What structures need.
    Need,
    /// A table of peers or of a paper.
    Table,
    /// Cases.
    Matrix,
    /// A sweep, a tuning, updates, an explanation.
    Study,
    /// A plain run.
    Run,
}

impl Kind {
    /// Of a record.
    pub(super) fn of(run: &Run) -> Self {
        match () {
            () if run.pareto.is_some() => Self::Fronts,
            () if run.need.is_some() => Self::Need,
            () if run.cases.is_some() => Self::Matrix,
            () if run.tuning.is_some() || run.sweep.is_some() || run.explanation.is_some() => Self::Study,
            () if run.table.is_some() => Self::Table,
            () if run.updates.is_some() => Self::Study,
            () => Self::Run,
        }
    }
}

/// The pages of all records of a kind.
///
/// # Errors
/// If a chart cannot be drawn.
pub(super) fn pages(
    records: &[Read<'_>],
    kind: Kind,
    machines: &[String],
    names: &Names,
    tables: Tables,
) -> Result<Vec<Piece>, ReportError> {
    let mut pieces = Vec::new();
    for read in records.iter().filter(|read| Kind::of(&read.run) == kind) {
        let machine = &machines[read.machine - 1];
        match &read.run.need {
            Some(record) => pieces.extend(needs(read, &need::for_page(&read.run, record)?, machine, names)),
            None => pieces.extend(page(read, &derived(&read.run, tables)?.0, machine, names)),
        }
    }
    Ok(pieces)
}

/// Every page of a record, what it was made for first.
fn page(read: &Read<'_>, contents: &Contents, machine: &str, names: &Names) -> Vec<Piece> {
    let mut pages: Vec<&(String, Vec<u8>)> = contents.iter().filter(|(name, _)| name.ends_with(".md")).collect();
    pages.sort_by_key(|(name, _)| is_full(name));
    let chart = |place: &str, alt: &str, tags: Tags<'_>| {
        let (_, svg) = contents.iter().find(|(name, _)| name == place)?;
        Some(figure(&String::from_utf8_lossy(svg), alt, &caption(alt, tags, machine), tags))
    };
    let of = |(name, text): &(String, Vec<u8>)| {
        let text = String::from_utf8_lossy(text);
        let title = format!("{} ({})", title_of(&text).unwrap_or(name), read.name);
        if is_full(name) {
            let html = html(&text, 3, names, &|place, alt, tags| chart(place, alt, tags).unwrap_or_default());
            return vec![heavy(Rank::Full, format!("{name} of {}", read.name), details(&title, "", &html))];
        }
        with_charts(&title, &text, names, &|place, alt, tags| {
            let html = chart(place, alt, tags)?;
            Some(vec![heavy(Rank::Chart, format!("{place} of {}", read.name), html)])
        })
    };
    pages.into_iter().flat_map(of).collect()
}

/// Whether a page tells of every row in full: of a run that was made for a table or a sweep, beside that.
fn is_full(name: &str) -> bool {
    name == SUMMARY
}

/// The page of needs, with a chart a tracer.
fn needs(read: &Read<'_>, NeedPage { text, charts }: &NeedPage, machine: &str, names: &Names) -> Vec<Piece> {
    with_charts(&format!("What structures need ({})", read.name), text, names, &|place, alt, tags| {
        let chart = |(tracer, svg): &(String, String)| {
            let alt = format!("{tracer}, {alt}");
            let tags = Tags { tracer: names.tracer(tracer), ..tags };
            let html = figure(svg, &alt, &caption(&alt, tags, machine), tags);
            heavy(Rank::Chart, format!("{place} of {tracer} in {}", read.name), html)
        };
        Some(charts.get(place.strip_suffix(".svg")?)?.iter().map(chart).collect())
    })
}

/// What a paper's claims come to.
pub(super) fn claims(text: &str, names: &Names) -> Vec<Piece> {
    with_charts(title_of(text).unwrap_or("Claims"), text, names, &|_, _, _| None)
}

/// Makes the charts that stand for a picture, of where it lies, what it shows and what it belongs to.
type Charts<'a> = dyn Fn(&str, &str, Tags<'_>) -> Option<Vec<Piece>> + 'a;

/// The charts of a page, then its text, which opens.
fn with_charts(title: &str, text: &str, names: &Names, charts: &Charts<'_>) -> Vec<Piece> {
    let pieces = RefCell::new(Vec::new());
    let html = html(text, 3, names, &|place, alt, tags| {
        pieces.borrow_mut().extend(charts(place, alt, tags).into_iter().flatten());
        String::new()
    });
    let mut pieces = pieces.into_inner();
    pieces.push(heavy(Rank::Page, title.to_owned(), details(title, "", &html)));
    pieces
}

fn heavy(rank: Rank, what: String, html: String) -> Piece {
    Piece::Heavy { rank, what, tags: String::new(), html }
}

/// The title of a page.
fn title_of(text: &str) -> Option<&str> {
    text.lines().next()?.strip_prefix("# ")
}
