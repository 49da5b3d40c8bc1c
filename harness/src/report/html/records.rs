//! Pages of records that are no fronts, with their charts: tables of papers, matrices, sweeps and all others.

use std::cell::RefCell;

use super::fronts::details;
use super::pieces::{Piece, Rank, Tags};
use super::read::{Names, Read};
use super::write::{caption, figure, html, plain_html};
use crate::report::chart::Chart;
use crate::report::document::Document;
use crate::report::{Report, ReportError, SUMMARY, Section, Study, Tables};

/// The pages of all records that are in a section.
///
/// # Errors
/// If a report cannot be made.
pub(super) fn pages(
    records: &[Read<'_>],
    section: Section,
    names: &Names,
    tables: Tables,
) -> Result<Vec<Piece>, ReportError> {
    let mut pieces = Vec::new();
    for (read, study) in records.iter().map(|read| (read, Study::of(&read.record))) {
        if study.section == section {
            pieces.extend(pages_of(read, &study.report(&read.record, tables)?, names));
        }
    }
    Ok(pieces)
}

/// Every page of a record, what it was made for first: before each its charts, then its text, which opens; what tells of every row in
/// full has its charts within.
fn pages_of(read: &Read<'_>, report: &Report, names: &Names) -> Vec<Piece> {
    let mut pages: Vec<&(String, Document)> = report.pages.iter().collect();
    pages.sort_by_key(|(name, _)| name == SUMMARY);
    let mut pieces = Vec::new();
    let drawn =
        |alt: &str, chart: &Chart, tags: Tags<'_>| figure(&chart.svg(), alt, &caption(alt, tags, &read.label()), tags);
    for (name, page) in pages {
        let title = format!("{} ({})", page.title().unwrap_or(name), read.name);
        let above = RefCell::new(Vec::new());
        let html = html(page, 3, names, &|stem, alt, chart, tags| {
            let html = drawn(alt, chart, tags);
            if name == SUMMARY {
                return html;
            }
            let what = format!("{stem}.svg of {}", read.name);
            above.borrow_mut().push(Piece::heavy(Rank::Chart, what, Tags::default(), html));
            String::new()
        });
        pieces.extend(above.into_inner());
        let (rank, what) = match name == SUMMARY {
            true => (Rank::Full, format!("{name} of {}", read.name)),
            false => (Rank::Page, title.clone()),
        };
        pieces.push(Piece::heavy(rank, what, Tags::default(), details(&title, "", &html)));
    }
    pieces
}

/// What a paper's claims come to.
pub(super) fn claims(page: &Document, names: &Names) -> Piece {
    let title = page.title().unwrap_or("Claims");
    Piece::heavy(Rank::Page, title, Tags::default(), details(title, "", &plain_html(page, 3, names)))
}
