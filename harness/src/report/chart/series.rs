//! Values over a setting, a panel a quantity: lines through values at equal distances, whatever the setting's steps.

use super::axis::log_range;
use super::curves::{Curve, Measured, Values, measured};
use super::frame::{Entry, Frame, Sample};
use super::palette::{PLAIN, Styles};
use super::panel::{Aside, Axis, Chart, Panel, Scale};
use super::{Drawing, LONGEST_TRACER, cut, untimed_caption};
use crate::results::Record;
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
    /// The tracer that it is of alone: a page leaves it out with that.
    pub of: Option<String>,
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

/// A chart of a record.
pub(crate) fn series(record: &Record, chart: SeriesChart) -> Drawing {
    Drawing::Series(chart, untimed_caption(&record.provenance, &record.preset))
}

impl SeriesChart {
    /// A chart a tracer, where every panel is of one.
    pub(crate) fn by_tracer(&self) -> Vec<(&str, Self)> {
        let tracers = self.panels.iter().filter_map(|panel| panel.of.as_deref()).unique();
        let of_tracer = |tracer| {
            let panels = self.panels.iter().filter(|panel| panel.of.as_deref() == Some(tracer)).cloned().collect();
            (tracer, Self { panels, ..self.clone() })
        };
        tracers.map(of_tracer).collect()
    }
}

/// Lays a chart out.
pub(super) fn figure(chart: &SeriesChart, caption: &str) -> Chart {
    let names = || chart.panels.iter().flat_map(|panel| &panel.series).map(|series| &series.label).unique();
    let styles = Styles::of_labels(names().cloned());
    let entry = |name: &String| Entry::new(Sample::Line(styles.get(name)), cut(name, LONGEST_TRACER));
    let legend = names().map(entry).collect();
    let key = chart.key.map_or_else(Vec::new, |[solid, dashed]| {
        vec![Entry::new(Sample::Line(PLAIN), solid), Entry::new(Sample::Hollow(PLAIN), format!("{dashed} (dashed)"))]
    });
    let titles = [chart.title.clone(), chart.subtitle.clone()];
    let frame = Frame::new(chart.panels.len(), titles, caption, key, legend);
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
