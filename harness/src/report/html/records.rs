//! Pages of records that are no fronts, with their charts: tables of papers, matrices, sweeps and all others.

use std::cell::RefCell;

use super::fronts::details;
use super::pieces::{Piece, Rank, Tags};
use super::read::{Names, Read};
use super::write::{caption, figure, html};
use crate::report::chart::{self, Drawing};
use crate::report::document::Document;
use crate::report::{Report, ReportError, SUMMARY, Section, Study, Tables};

/// The pages of all records that are in a section.
///
/// # Errors
/// If a chart cannot be drawn.
pub(super) fn pages(
    records: &[Read<'_>],
    section: Section,
    machines: &[String],
    names: &Names,
    tables: Tables,
) -> Result<Vec<Piece>, ReportError> {
    let mut pieces = Vec::new();
    for (read, study) in records.iter().map(|read| (read, Study::of(&read.record))) {
        if study.section == section {
            pieces.extend(pages_of(read, &study.report(&read.record, tables)?, &machines[read.machine - 1], names)?);
        }
    }
    Ok(pieces)
}

/// Every page of a record, what it was made for first: before each its charts, then its text, which opens; what tells of every row in
/// full has its charts within.
fn pages_of(read: &Read<'_>, report: &Report, machine: &str, names: &Names) -> Result<Vec<Piece>, ReportError> {
    let mut pages: Vec<&(String, Document)> = report.pages.iter().collect();
    pages.sort_by_key(|(name, _)| name == SUMMARY);
    let mut pieces = Vec::new();
    // What the writer meets of charts that cannot be drawn.
    let failed: RefCell<Option<ReportError>> = RefCell::new(None);
    let charts = |stem: &str, alt: &str, drawing: &Drawing, tags: Tags<'_>| {
        drawn(drawing, alt, tags, read, machine, names).unwrap_or_else(|error| {
            failed.borrow_mut().get_or_insert(chart::made(stem, &error));
            Vec::new()
        })
    };
    for (name, page) in pages {
        let title = format!("{} ({})", page.title().unwrap_or(name), read.name);
        if name == SUMMARY {
            let html = html(page, 3, names, &|stem, alt, drawing, tags| {
                charts(stem, alt, drawing, tags).into_iter().map(|(_, html)| html).collect()
            });
            pieces.push(heavy(Rank::Full, format!("{name} of {}", read.name), details(&title, "", &html)));
            continue;
        }
        let above = RefCell::new(Vec::new());
        let html = html(page, 3, names, &|stem, alt, drawing, tags| {
            let heavy = |(of, html): (String, String)| heavy(Rank::Chart, format!("{stem}.svg of {of}"), html);
            above.borrow_mut().extend(charts(stem, alt, drawing, tags).into_iter().map(heavy));
            String::new()
        });
        pieces.extend(above.into_inner());
        pieces.push(heavy(Rank::Page, title.clone(), details(&title, "", &html)));
    }
    failed.into_inner().map_or(Ok(pieces), Err)
}

/// A chart with what it is of; one a tracer where its panels are of tracers, so that these can be left out.
fn drawn(
    drawing: &Drawing,
    alt: &str,
    tags: Tags<'_>,
    read: &Read<'_>,
    machine: &str,
    names: &Names,
) -> Result<Vec<(String, String)>, chart::DrawError> {
    let parts = drawing.by_tracer();
    if parts.is_empty() {
        let html = figure(&drawing.svg()?, alt, &caption(alt, tags, machine), tags);
        return Ok(vec![(read.name.clone(), html)]);
    }
    let part = |(tracer, part): &(String, Drawing)| {
        let alt = format!("{tracer}, {alt}");
        let tags = Tags { tracer: names.tracer(tracer), ..tags };
        Ok((format!("{tracer} in {}", read.name), figure(&part.svg()?, &alt, &caption(&alt, tags, machine), tags)))
    };
    parts.iter().map(part).collect()
}

/// What a paper's claims come to.
pub(super) fn claims(page: &Document, names: &Names) -> Piece {
    let title = page.title().unwrap_or("Claims");
    heavy(Rank::Page, title.to_owned(), details(title, "", &super::write::plain_html(page, 3, names)))
}

fn heavy(rank: Rank, what: String, html: String) -> Piece {
    Piece::Heavy { rank, what, tags: String::new(), html }
}
