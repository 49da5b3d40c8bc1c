//! What charts share: panels in a grid, title above, legends and caption below, gutters for labels beside.

use super::canvas::{Align, Canvas, shorten, text_width, wrap};
use super::palette::{CONTROL, GREY, INK, Style};
use super::panel::Panel;

/// Room on the left of a panel, for the axis's name and tick labels.
pub(super) const LEFT: f64 = 70.0;
/// Room on the right, for the names of controls.
pub(super) const RIGHT: f64 = 90.0;
/// Height of the data's rectangle.
const PLOT_HEIGHT: f64 = 300.0;
/// Least width of the data's rectangle.
const PLOT_WIDTH: f64 = 270.0;
/// Least width of a figure: titles and captions need it even beside a single panel.
const MIN_WIDTH: f64 = 720.0;
/// Height of what stands above all panels.
const HEAD: f64 = 54.0;
const PANEL_TITLE: f64 = 30.0;
const PANEL_FOOT: f64 = 52.0;
const MARGIN: f64 = 14.0;
const TITLE_SIZE: f64 = 17.0;
const SUBTITLE_SIZE: f64 = 11.5;
const LEGEND_SIZE: f64 = 11.5;
const LEGEND_LINE: f64 = 19.0;
const LEGEND_SAMPLE: f64 = 34.0;
const CAPTION_SIZE: f64 = 10.5;
const CAPTION_LINE: f64 = 15.0;

/// Width of a line that stands out.
pub(super) const STRONG: f64 = 4.0;

/// What stands before a legend's text.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sample {
    Filled(Style),
    Hollow(Style),
    /// A filled marker on a line.
    Line(Style),
    Strong(Style),
    /// The dashes of controls.
    Dashes,
    /// Bars of intervals.
    Bars,
}

/// A line of a legend.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    sample: Sample,
    label: String,
}

impl Entry {
    /// One with a text.
    pub(super) fn new(sample: Sample, label: impl Into<String>) -> Self {
        Self { sample, label: label.into() }
    }
}

/// A chart.
#[derive(Debug)]
pub(crate) struct Chart {
    /// The title, and the line under it.
    titles: [String; 2],
    caption: String,
    /// Who is who, then how to read.
    legends: [Vec<Entry>; 2],
    columns: usize,
    /// Height of the data's rectangle.
    plot_height: f64,
    pub(super) panels: Vec<Panel>,
}

/// The rectangle of a panel's data.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Chart {
    /// Panels with the title and the line under it, the caption, and the legends: who is who, and how to read.
    pub(super) fn new(panels: Vec<Panel>, titles: [String; 2], caption: String, legends: [Vec<Entry>; 2]) -> Self {
        Self { titles, caption, legends, columns: panels.len().clamp(1, 3), plot_height: PLOT_HEIGHT, panels }
    }

    /// The same in so many columns of panels of a height.
    pub(super) fn in_columns(self, columns: usize, plot_height: f64) -> Self {
        Self { columns, plot_height, ..self }
    }

    fn width(&self) -> f64 {
        (self.columns as f64 * (LEFT + PLOT_WIDTH + RIGHT)).max(MIN_WIDTH)
    }

    fn row_height(&self) -> f64 {
        PANEL_TITLE + self.plot_height + PANEL_FOOT
    }

    /// The rectangle of a panel's data.
    pub(super) fn rect(&self, index: usize) -> Rect {
        let cell = self.width() / self.columns as f64;
        let left = (index % self.columns) as f64 * cell + LEFT;
        let top = HEAD + (index / self.columns) as f64 * self.row_height() + PANEL_TITLE;
        Rect { left, top, right: left - LEFT + cell - RIGHT, bottom: top + self.plot_height }
    }

    /// As SVG.
    pub(in crate::report) fn svg(&self) -> String {
        self.drawn().svg()
    }

    /// Draws it.
    pub(super) fn drawn(&self) -> Canvas {
        let mut canvas = Canvas::default();
        let (inner, [title, subtitle]) = (self.width() - 2.0 * MARGIN, &self.titles);
        canvas.text(&shorten(title, TITLE_SIZE, inner), (MARGIN, 20.0), Align::Left, TITLE_SIZE, INK);
        canvas.text(&shorten(subtitle, SUBTITLE_SIZE, inner), (MARGIN, 41.0), Align::Left, SUBTITLE_SIZE, GREY);
        let rows = self.panels.len().max(1).div_ceil(self.columns);
        let mut y = HEAD + rows as f64 * self.row_height() + 12.0;
        for entries in &self.legends {
            for row in in_columns(entries, inner) {
                for (left, Entry { sample, label }) in row {
                    let x = MARGIN + left;
                    draw_sample(&mut canvas, sample, (x + LEGEND_SAMPLE / 2.0 - 3.0, y));
                    canvas.text(&label, (x + LEGEND_SAMPLE, y), Align::Left, LEGEND_SIZE, INK);
                }
                y += LEGEND_LINE;
            }
            y += if entries.is_empty() { 0.0 } else { 5.0 };
        }
        y += 6.0;
        for line in wrap(&self.caption, CAPTION_SIZE, inner, 4) {
            canvas.text(&line, (MARGIN, y), Align::Left, CAPTION_SIZE, GREY);
            y += CAPTION_LINE;
        }
        canvas.size = (self.width(), y + 2.0 + MARGIN);
        for (index, panel) in self.panels.iter().enumerate() {
            panel.draw(&mut canvas, self.rect(index));
        }
        canvas
    }
}

/// Rows of entries with their left edges, in as many columns as fit, each as wide as its widest.
fn in_columns(entries: &[Entry], width: f64) -> Vec<Vec<(f64, Entry)>> {
    let cut = |Entry { sample, label }: &Entry| Entry::new(*sample, shorten(label, LEGEND_SIZE, width - LEGEND_SAMPLE));
    let entries: Vec<Entry> = entries.iter().map(cut).collect();
    let widths: Vec<f64> =
        entries.iter().map(|entry| LEGEND_SAMPLE + text_width(&entry.label, LEGEND_SIZE) + 14.0).collect();
    let columns_of = |count: usize| -> Vec<f64> {
        let widest = |column: usize| widths.iter().skip(column).step_by(count).copied().fold(0.0, f64::max);
        (0..count).map(widest).collect()
    };
    let fits = |count: &usize| columns_of(*count).iter().sum::<f64>() <= width + 14.0;
    let count = (1..=entries.len().min(6)).rev().find(fits).unwrap_or(1);
    let lefts = || columns_of(count).into_iter().scan(0.0, |left, width| Some(std::mem::replace(left, *left + width)));
    entries.chunks(count).map(|row| lefts().zip(row.iter().cloned()).collect()).collect()
}

fn draw_sample(canvas: &mut Canvas, sample: Sample, (x, y): (f64, f64)) {
    let level = [(x - 13.0, y), (x + 13.0, y)];
    match sample {
        Sample::Filled(style) => canvas.filled_marker((x, y), 4.5, style),
        Sample::Hollow(style) => canvas.hollow_marker((x, y), 6.5, style),
        Sample::Line(style) => {
            canvas.path(&level, style.colour, 2.0);
            canvas.filled_marker((x, y), 4.0, style);
        }
        Sample::Strong(style) => canvas.path(&level, style.colour, STRONG),
        Sample::Dashes => canvas.dashed(&level, CONTROL, 1.0),
        Sample::Bars => {
            canvas.path(&[(x - 9.0, y), (x + 9.0, y)], GREY, 1.0);
            canvas.path(&[(x, y - 7.0), (x, y + 7.0)], GREY, 1.0);
        }
    }
}
