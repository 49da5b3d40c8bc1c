//! Values over a setting, a panel a quantity: lines through values at equal distances, whatever the setting's steps.

use super::axis::log_range;
use super::canvas::{register, to_svg};
use super::frame::{Entry, Frame, Sample};
use super::palette::{GREY, Shape, Style, Styles};
use super::panel::{self, Aside, Axis, Chart, Mark, Place, Scale, between};
use super::{ChartFile, LONGEST_TRACER, cut, draw, made, untimed_caption};
use crate::report::ReportError;
use crate::results::Run;

const FILLED: f64 = 4.0;
const HOLLOW: f64 = 6.0;

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
pub(crate) struct Panel {
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
    pub panels: Vec<Panel>,
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
    let mut names: Vec<&str> = Vec::new();
    for series in chart.panels.iter().flat_map(|panel| &panel.series) {
        if !names.contains(&series.label.as_str()) {
            names.push(&series.label);
        }
    }
    let styles = Styles::of_labels(names.iter().map(|name| (*name).to_owned()));
    let entry = |name: &&str| Entry { sample: Sample::Line(styles.get(name)), label: cut(name, LONGEST_TRACER) };
    let legend = names.iter().map(entry).collect();
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

fn panel(panel: &Panel, styles: &Styles) -> panel::Panel {
    // A logarithm never gets to zero.
    let usable = |value: &Option<f64>| value.filter(|value| value.is_finite() && *value > 0.0);
    let range = log_range(panel.series.iter().flat_map(|series| series.values.iter().filter_map(usable)));
    let mut lines = Vec::new();
    let mut markers = Vec::new();
    for series in &panel.series {
        let (style, dashed, aside) = (styles.get(&series.label), series.dashed, Aside::default());
        let at = |(step, value): (usize, &Option<f64>)| Some((step as f64, usable(value)?));
        let places: Vec<Option<Place>> = series.values.iter().enumerate().map(at).collect();
        lines.extend(between(&places, style.colour, if dashed { 1.5 } else { 2.0 }, dashed, aside));
        let radius = if dashed { HOLLOW } else { FILLED };
        let marker = |place| Mark::Marker { place, radius, style, hollow: dashed, aside };
        markers.extend(places.into_iter().flatten().map(marker));
    }
    let zero = panel.series.iter().flat_map(|series| &series.values).any(|value| *value == Some(0.0));
    let note = if zero { "0 throughout" } else { "nothing was measured" };
    panel::Panel {
        title: panel.title.clone(),
        x: Axis { name: panel.setting.clone(), scale: Scale::Steps(panel.steps.clone()) },
        y: Axis { name: panel.quantity.clone(), scale: Scale::Log(range, 6) },
        controls: Vec::new(),
        note: markers.is_empty().then_some(note),
        // All lines before all markers: a line over a marker would hide which kind it is.
        marks: lines.into_iter().chain(markers).collect(),
    }
}
