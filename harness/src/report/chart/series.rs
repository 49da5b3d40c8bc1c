//! What studies give as data: values over a setting, a panel a quantity, as lines through values at equal distances, whatever the setting's
//! steps; and errors against time, a panel an error.

use super::caption_with;
use super::curves::{Curve, Measured, Values, measured};
use super::frame::{Chart, Entry, Sample};
use super::palette::{PLAIN, Styles};
use super::panel::{Aside, Axis, Mark, Panel, Scale};
use super::scale::log_range;
use crate::results::Record;

/// Radius of the markers of errors.
const RADIUS: f64 = 4.5;

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
    pub title: String,
    pub setting: String,
    pub steps: Vec<String>,
    /// The quantity's name with its unit.
    pub quantity: String,
    pub series: Vec<Series>,
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SeriesChart {
    pub title: String,
    pub subtitle: String,
    /// What solid and dashed lines are, where it has both.
    pub key: Option<[&'static str; 2]>,
    pub panels: Vec<SeriesPanel>,
}

/// A chart of a record.
pub(crate) fn series(record: &Record, chart: SeriesChart) -> Chart {
    let SeriesChart { title, subtitle, key, panels } = chart;
    let labels = panels.iter().flat_map(|panel| &panel.series).map(|series| series.label.clone());
    let styles = Styles::of_labels(labels);
    let key = key.map_or_else(Vec::new, |[solid, dashed]| {
        vec![Entry::new(Sample::Line(PLAIN), solid), Entry::new(Sample::Hollow(PLAIN), format!("{dashed} (dashed)"))]
    });
    let panels = panels.iter().map(|each| panel(each, &styles)).collect();
    Chart::new(panels, [title, subtitle], caption_with(record, ""), [styles.legend(Sample::Line), key])
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

/// A panel of errors: the error's name, and by label time and error.
pub(in crate::report) type Errors<'a> = (&'a str, Vec<(String, f64, f64)>);

/// The chart of some errors over a time with a name: what is lower and further left is better.
pub(in crate::report) fn errors(record: &Record, titles: [String; 2], time: &str, errors: &[Errors<'_>]) -> Chart {
    let styles = Styles::of_labels(errors.iter().flat_map(|(_, points)| points).map(|(label, ..)| label.clone()));
    let panel = |(name, points): &Errors<'_>| {
        let positive = points.iter().map(|(.., error)| *error).filter(|error| *error > 0.0);
        let marker =
            |(label, ms, error): &(String, f64, f64)| Mark::marker((*ms, *error), RADIUS, styles.get(label), false);
        Panel {
            title: (*name).to_owned(),
            x: Axis { name: time.to_owned(), scale: Scale::Log(log_range(points.iter().map(|(_, ms, _)| *ms)), 6) },
            y: Axis { name: (*name).to_owned(), scale: Scale::LogAndZero(log_range(positive), 6) },
            controls: Vec::new(),
            marks: points.iter().map(marker).collect(),
            note: points.is_empty().then_some("no tracer was timed"),
        }
    };
    let caption = caption_with(record, "");
    let legends = [styles.legend(Sample::Filled), Vec::new()];
    Chart::new(errors.iter().map(panel).collect(), titles, caption, legends)
}
