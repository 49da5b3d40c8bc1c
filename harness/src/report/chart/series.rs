//! Values over a setting, a panel a quantity: lines through values at equal distances, whatever the setting's steps.

use super::axis::log_range;
use super::canvas::{register, to_svg};
use super::curves::{Curve, Measured, Values, measured};
use super::frame::{Entry, Frame, Sample};
use super::palette::{GREY, Shape, Style, Styles};
use super::panel::{Aside, Axis, Chart, Panel, Scale};
use super::{ChartFile, LONGEST_TRACER, cut, draw, made, untimed_caption};
use crate::report::ReportError;
use crate::results::Run;
use itertools::Itertools as _;

/// A line of a panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Series {
    /// What it is of; the same label has the same look in every panel.
    pub label: String,
    /// A value a step of the setting; `None` where there is none.
    pub values: Vec<Option<f64>>,
    /// Dashed, with hollow markers.
    pub dashed: bool,
}

/// A panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SeriesPanel {
    /// Its title.
    pub title: String,
    /// The setting's name.
    pub setting: String,
    /// The setting's steps.
    pub steps: Vec<String>,
    /// The quantity's name with its unit.
    pub quantity: String,
    /// Its lines.
    pub series: Vec<Series>,
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SeriesChart {
    /// What its files are called, without their ends.
    pub stem: String,
    /// Its title.
    pub title: String,
    /// The line under it.
    pub subtitle: String,
    /// What solid and dashed lines are, where it has both.
    pub key: Option<[&'static str; 2]>,
    /// Its panels.
    pub panels: Vec<SeriesPanel>,
}

/// The files of a chart.
pub(crate) fn series_chart(run: &Run, chart: &SeriesChart) -> Result<Vec<ChartFile>, ReportError> {
    let mut files = Vec::new();
    draw(&chart.stem, &figure(run, chart), &mut files)?;
    Ok(files)
}

/// A chart as SVG alone, for a page.
pub(crate) fn series_svg(run: &Run, chart: &SeriesChart) -> Result<String, ReportError> {
    to_svg(&figure(run, chart)).map_err(|error| made(&chart.stem, &error))
}

fn figure(run: &Run, chart: &SeriesChart) -> Chart {
    // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
    let _ = register();
    let names = || chart.panels.iter().flat_map(|panel| &panel.series).map(|series| &series.label).unique();
    let styles = Styles::of_labels(names().cloned());
    let entry = |name: &String| Entry { sample: Sample::Line(styles.get(name)), label: cut(name, LONGEST_TRACER) };
    let legend = names().map(entry).collect();
    let grey = Style { colour: GREY, shape: Shape::Circle };
    let key = chart.key.map_or_else(Vec::new, |[solid, dashed]| {
        let entry = |sample, label: &str| Entry { sample, label: label.to_owned() };
        vec![entry(Sample::Line(grey), solid), entry(Sample::Hollow(grey), &format!("{dashed} (dashed)"))]
    });
    let caption = untimed_caption(&run.provenance, &run.preset);
    let titles = [chart.title.clone(), chart.subtitle.clone()];
    let frame = Frame::new(chart.panels.len(), titles, &caption, key, legend);
    let panels = chart.panels.iter().map(|each| panel(each, &styles)).collect();
    Chart { frame, panels }
}

fn panel(panel: &SeriesPanel, styles: &Styles) -> Panel {
    // A logarithm never gets to zero.
    let usable = |value: &Option<f64>| value.filter(|value| value.is_finite() && *value > 0.0).map(Measured::exact);
    let curve = |Series { label, values, dashed }: &Series| Curve {
        style: styles.get(label),
        hollow: *dashed,
        aside: Aside::default(),
        at: values.iter().map(usable).collect(),
    };
    let curves: Vec<Curve> = panel.series.iter().map(curve).collect();
    let scale = Scale::Log(log_range(measured(&curves).map(|one| one.value)), 6);
    let values = Values::steps(panel.setting.clone(), panel.steps.clone(), None);
    let y = Axis { name: panel.quantity.clone(), scale };
    let drawn = values.panel(panel.title.clone(), y, &curves, Vec::new());
    let zero = panel.series.iter().flat_map(|series| &series.values).any(|value| *value == Some(0.0));
    Panel { note: drawn.note.map(|note| if zero { "0 throughout" } else { note }), ..drawn }
}
