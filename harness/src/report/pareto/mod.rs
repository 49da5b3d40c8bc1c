//! Fronts: `pareto.md`, `operating_points.csv`, `break_even.csv` and the charts.

mod csv;
pub(in crate::report) mod page;
#[cfg(test)]
pub(in crate::report) mod tests;

use super::group::{groups, stems};
use super::{Report, format, metrics, rows};
use crate::results::{FrontScene, ParetoRecord, Record};
use crate::studies::pareto::{Amount, Cost, Field, SceneFronts, scene_fronts};

/// The page.
pub const PARETO_PAGE: &str = "pareto.md";

/// What the names of its charts begin with.
pub(in crate::report) const STEM: &str = "pareto_";

/// A scene with the part of file names that distinguishes it.
pub(in crate::report) struct Shown<'a> {
    pub stem: String,
    pub fronts: SceneFronts<'a>,
}

impl Shown<'_> {
    /// What a chart of a ray set is called, without its end.
    pub(in crate::report) fn chart(&self, rays: &str, what: &str) -> String {
        format!("{STEM}{}_{}_{what}", self.stem, format::file_stem(rays))
    }
}

/// What is made of fronts: page, tables and charts.
pub(super) fn report(record: &Record) -> Option<Report> {
    let section = record.pareto.as_ref()?;
    let shown = shown(record, section);
    let (groups, fields) = (groups(record), csv::fields(section, &shown));
    Some(rows(record, &groups, csv::points(section), |(.., (.., trace))| csv::point(&fields, trace)).and(Report {
        pages: vec![(PARETO_PAGE.to_owned(), page::page(record, section, &shown))],
        tables: vec![
            ("operating_points.csv".to_owned(), csv::operating(&shown)),
            ("break_even.csv".to_owned(), csv::break_even_counts(&shown)),
        ],
        ..Report::default()
    }))
}

/// Every scene of a record.
pub(in crate::report) fn shown<'a>(record: &'a Record, section: &'a ParetoRecord) -> Vec<Shown<'a>> {
    let told = |scene: &'a FrontScene| [&*scene.scene.name, &*scene.scene.sha256, &*scene.viewpoint.name];
    let stems = stems(&section.scenes.iter().map(told).collect::<Vec<_>>());
    stems.into_iter().zip(scene_fronts(record, section)).map(|(stem, fronts)| Shown { stem, fronts }).collect()
}

/// A cost's name with its unit.
pub(in crate::report) fn cost_name(cost: Cost) -> String {
    match cost {
        Cost::Trace => metrics::SPEED.axis(),
        Cost::Build => metrics::BUILD_TIME.axis(),
        Cost::Bytes => "structure and geometry to trace (MiB)".to_owned(),
        Cost::Frame(rays) => format!("frame: build and {} (ms)", rays_a_pixel(rays)),
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
