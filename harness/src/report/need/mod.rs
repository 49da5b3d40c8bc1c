//! Needs: `need.md` and a chart a scene and ray set.

mod page;
#[cfg(test)]
mod tests;

use super::chart::series::{Series, SeriesChart, SeriesPanel};
use super::format::{self, significant, thousands};
use super::group::{groups, stems};
use super::sheet::Sheet;
use super::{Report, ReportError, Tables, rows};
use crate::results::{self, NeedCurve, NeedRecord, Record, SceneRecord};
use crate::studies::need::{Axis, Curve, Step, curves};
use itertools::Itertools as _;
use std::ptr;

/// The page.
pub const NEED_PAGE: &str = "need.md";

/// The least that is drawn, as a part of the limit: a logarithm has no place for structures whose answers got better.
const MIN_DRAWN: f64 = 0.1;

/// What the names of its charts begin with.
pub(in crate::report) const STEM: &str = "need_";

/// The curves of one ray set in one scene, from all of its viewpoints.
struct Shown<'a> {
    scene: &'a SceneRecord,
    rays: &'a str,
    curves: Vec<&'a Curve<'a>>,
    /// What its chart is called, without its end.
    chart: String,
}

/// What is made of needs: page, charts, and what smaller structures lose by rows.
pub(super) fn report(record: &Record, _: Tables) -> Result<Report, ReportError> {
    let Some(section) = &record.need else { return Ok(Report::default()) };
    let curves = curves(record, section);
    let shown = shown(record, &curves);
    let steps = || curves.iter().flat_map(page::structures);
    let groups = groups(record);
    Ok(Report {
        pages: vec![(NEED_PAGE.to_owned(), page::page(record, section, &curves, &shown))],
        ..rows(record, &groups, page::of_steps(Sheet::new()), |(.., (.., trace))| {
            steps().find(|row| row.step.trace.is_some_and(|own| ptr::eq(own, *trace)))
        })
    })
}

/// Curves by scene and ray set, in the order of first appearance.
fn shown<'a>(record: &'a Record, curves: &'a [Curve<'a>]) -> Vec<Shown<'a>> {
    let mut shown: Vec<Shown<'a>> = Vec::new();
    for curve in curves {
        let Some(row) = record.rows.iter().find(|row| curve.section.holds(row)) else { continue };
        let same = |each: &&mut Shown<'a>| each.scene.sha256 == row.scene.sha256 && each.rays == curve.rays;
        match shown.iter_mut().find(same) {
            Some(known) => known.curves.push(curve),
            None => {
                shown.push(Shown { scene: &row.scene, rays: curve.rays, curves: vec![curve], chart: String::new() });
            }
        }
    }
    let told: Vec<[&str; 3]> = shown.iter().map(|each| [&*each.scene.name, &*each.scene.sha256, each.rays]).collect();
    // Scenes of one name are distinguished; ray sets have their own part of the name.
    let scenes = told.iter().map(|[name, sha256, _]| [*name, *sha256, ""]).unique_by(|known| known[1]).collect_vec();
    let stems = stems(&scenes);
    let names: Vec<String> = told
        .iter()
        .map(|[_, sha256, rays]| {
            let place = scenes.iter().position(|known| known[1] == *sha256).unwrap_or(0);
            format!("{STEM}{}_{}", stems[place], format::file_stem(rays))
        })
        .collect();
    for (each, name) in shown.iter_mut().zip(names) {
        each.chart = name;
    }
    shown
}

/// A tracer with its preset unless it is the published one.
fn config(curve: &NeedCurve) -> String {
    results::config(&curve.tracer, &curve.preset)
}

/// A panel a tracer and axis: what its steps lose, from every viewpoint. None where there is nothing to shrink.
fn chart(section: &NeedRecord, shown: &Shown<'_>) -> Option<SeriesChart> {
    let mut panels = Vec::new();
    let configs = shown.curves.iter().map(|curve| (&curve.section.tracer, &curve.section.preset)).unique();
    for (tracer, preset) in configs {
        let own: Vec<&Curve<'_>> = shown
            .curves
            .iter()
            .copied()
            .filter(|curve| (&curve.section.tracer, &curve.section.preset) == (tracer, preset))
            .collect();
        let Some(first) = own.first() else { continue };
        for axis in &first.axes {
            let steps: Vec<String> = axis.steps.iter().map(|step| value_of(axis, step)).collect();
            let limit = Series {
                label: format!("limit, {} %", significant(section.max_lost_share * 100.0, 2)),
                values: vec![Some(section.max_lost_share * 100.0); steps.len()],
                dashed: true,
            };
            let series = own.iter().filter_map(|curve| {
                let beside = curve.axes.iter().find(|other| other.name == axis.name)?;
                let of = |step: &String| beside.steps.iter().find(|other| value_of(beside, other) == *step);
                let drawn = |upper: f64| upper.max(section.max_lost_share * MIN_DRAWN) * 100.0;
                let values = steps.iter().map(|step| Some(drawn(of(step)?.lost()?.1[1]))).collect();
                Some(Series { label: format!("from {}", curve.section.viewpoint), values, dashed: false })
            });
            let series = series.chain([limit]).collect();
            let title = format!("{}: {}", config(first.section), axis.name);
            let quantity = "rays lost, upper end (%), log".to_owned();
            let (of, setting) = (Some(config(first.section)), axis.name.to_owned());
            panels.push(SeriesPanel { of, title, setting, steps, quantity, series });
        }
    }
    (!panels.is_empty()).then(|| SeriesChart {
        stem: shown.chart.clone(),
        title: format!(
            "The need curve: {} ({} triangles), {}",
            shown.scene.name,
            thousands(shown.scene.triangles),
            shown.rays
        ),
        subtitle: format!(
            "newly wrong less newly right rays of smaller structures, upper end of the paired 95 % interval; what is below {} % is drawn there",
            significant(section.max_lost_share * MIN_DRAWN * 100.0, 2)
        ),
        key: Some(["found", "allowed"]),
        panels,
    })
}

/// A step's value on its axis.
fn value_of(axis: &Axis<'_>, step: &Step<'_>) -> String {
    step.point.shrunk.get(axis.name).cloned().unwrap_or_default()
}
