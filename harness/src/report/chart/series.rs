//! Values over a setting, a panel a quantity: lines through values at equal distances, whatever the setting's steps.

use plotters::prelude::DrawingBackend;

use super::axis::{LogAxis, labels, log_range};
use super::canvas::{Canvas, Drawn, Figure, register, to_svg};
use super::frame::{Entry, Frame, Rect, Sample};
use super::palette::{GREY, Shape, Style, Styles};
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
    draw(&chart.stem, &SeriesFigure::new(run, chart), &mut files)?;
    Ok(files)
}

/// A chart as SVG alone, for a page.
pub(crate) fn series_svg(run: &Run, chart: &SeriesChart) -> Result<String, ReportError> {
    to_svg(&SeriesFigure::new(run, chart)).map_err(|error| made(&chart.stem, &error))
}

#[derive(Debug)]
struct SeriesFigure<'a> {
    frame: Frame,
    panels: &'a [Panel],
    styles: Styles,
}

impl<'a> SeriesFigure<'a> {
    fn new(run: &Run, chart: &'a SeriesChart) -> Self {
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
        Self { frame, panels: &chart.panels, styles }
    }

    fn draw_panel<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, panel: &Panel, rect: Rect) -> Drawn {
        let usable = |value: &Option<f64>| value.filter(|value| value.is_finite() && *value > 0.0);
        let all = panel.series.iter().flat_map(|series| series.values.iter().filter_map(usable));
        let y = LogAxis::new(log_range(all), rect.bottom, rect.top);
        let x = |step: usize| {
            let part = (step as f64 + 0.5) / panel.steps.len().max(1) as f64;
            rect.left + (rect.right - rect.left) * part
        };
        for (step, label) in panel.steps.iter().enumerate() {
            rect.tick_below(canvas, x(step), Some(label))?;
        }
        let ticks = y.ticks(6);
        for (tick, text) in ticks.iter().zip(labels(&ticks)) {
            rect.tick_left(canvas, y.at(tick.value), text.as_deref())?;
        }
        rect.title(canvas, &panel.title)?;
        rect.axis_names(canvas, &panel.setting, &panel.quantity)?;
        rect.edge(canvas)?;
        let place = |series: &Series| {
            let at = |(step, value): (usize, &Option<f64>)| usable(value).map(|value| (x(step), y.at(value)));
            series.values.iter().enumerate().map(at).collect::<Vec<_>>()
        };
        // All lines before all markers: a line over a marker would hide which kind it is.
        for series in &panel.series {
            let style = self.styles.get(&series.label);
            for pair in place(series).windows(2) {
                match pair {
                    [Some(from), Some(to)] if series.dashed => canvas.dashed(*from, *to, style.colour, 1.5)?,
                    [Some(from), Some(to)] => canvas.path(&[*from, *to], style.colour, 2.0)?,
                    _ => {}
                }
            }
        }
        for series in &panel.series {
            let style = self.styles.get(&series.label);
            for at in place(series).into_iter().flatten() {
                if series.dashed {
                    canvas.hollow_marker(at, HOLLOW, style)?;
                } else {
                    canvas.filled_marker(at, FILLED, style)?;
                }
            }
        }
        let values = || panel.series.iter().flat_map(|series| &series.values);
        if values().all(|value| usable(value).is_none()) {
            // A logarithm never gets to zero.
            let zero = values().any(|value| *value == Some(0.0));
            rect.note(canvas, if zero { "0 throughout" } else { "nothing was measured" })?;
        }
        Ok(())
    }
}

impl Figure for SeriesFigure<'_> {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            self.draw_panel(canvas, panel, self.frame.panel(index))?;
        }
        Ok(())
    }
}
