//! Fronts: `pareto.md`, `operating_points.csv`, `break_even.csv` and the charts.

mod csv;
pub(in crate::report) mod page;
#[cfg(test)]
pub(in crate::report) mod tests;

use super::group::{groups, stems};
use super::{Report, format, metrics, rows};
use crate::results::{FrontScene, ParetoRecord, Record};
use crate::studies::pareto::{Amount, Cost, Field, fields};

/// What the names of its charts begin with.
pub(super) const STEM: &str = "pareto_";

/// A scene with the part of file names that distinguishes it.
pub(super) struct Shown<'a> {
    stem: String,
    scene: &'a FrontScene,
    fields: Vec<Field<'a>>,
}

impl Shown<'_> {
    /// What a chart of a ray set is called, without its end.
    fn chart(&self, rays: &str, what: &str) -> String {
        format!("{STEM}{}_{}_{what}", self.stem, format::file_stem(rays))
    }
}

/// What is made of fronts: page, tables and charts.
pub(super) fn report(record: &Record) -> Option<Report> {
    let section = record.pareto.as_ref()?;
    let shown = shown(record, section);
    let fields = || shown.iter().flat_map(|scene| &scene.fields);
    let standings: Vec<_> = fields().map(|field| (field, csv::standings(field))).collect();
    let groups = groups(record);
    Some(rows(record, &groups, csv::points(section), |(.., (.., trace))| csv::point(&standings, trace)).and(Report {
        tables: vec![
            ("operating_points.csv".to_owned(), csv::operating(fields())),
            ("break_even.csv".to_owned(), csv::break_even_counts(fields())),
        ],
        ..Report::of_page("pareto.md", page::page(record, section, &shown))
    }))
}

/// Every scene of a record.
pub(super) fn shown<'a>(record: &'a Record, section: &'a ParetoRecord) -> Vec<Shown<'a>> {
    let told = |scene: &'a FrontScene| [&*scene.scene.name, &*scene.scene.sha256, &*scene.viewpoint.name];
    let stems = stems(&section.scenes.iter().map(told).collect::<Vec<_>>());
    let of = |(stem, scene): (String, &'a FrontScene)| Shown { stem, scene, fields: fields(record, section, scene) };
    stems.into_iter().zip(&section.scenes).map(of).collect()
}

/// A cost's name with its unit.
pub(in crate::report) fn cost_name(cost: Cost) -> String {
    match cost {
        Cost::Trace => metrics::SPEED.axis(),
        Cost::Build => metrics::FIRST_BUILD.axis(),
        Cost::Bytes => "structure and geometry to trace (MiB)".to_owned(),
        Cost::Frame(rays) => format!("frame: steady build and {} (ms)", rays_a_pixel(rays)),
    }
}

/// So many rays a pixel.
pub(in crate::report) fn rays_a_pixel(rays: f64) -> String {
    format!("{rays} {} a pixel", if rays == 1.0 { "ray" } else { "rays" })
}

/// A cost as people read it, by the unit of its name.
pub(in crate::report) fn as_read(field: &Field<'_>, cost: Cost, amount: Amount) -> Amount {
    let speed = |ms: f64| field.count as f64 / (ms * 1e3);
    match cost {
        Cost::Trace => {
            let [short, long] = amount.interval;
            Amount { value: speed(amount.value), interval: [speed(long), speed(short)] }
        }
        Cost::Bytes => amount.times(1.0 / f64::from(1 << 20)),
        Cost::Build | Cost::Frame(_) => amount,
    }
}
