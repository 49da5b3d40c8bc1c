//! What the charts share: panels in a grid, title above, legend and caption below, gutters for labels beside.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use super::canvas::{Align, Canvas, Drawn, register, shorten, text_width, wrap};
use super::palette::{CONTROL, GREY, GRID, INK, Style};

/// Room on the left of a panel, for the axis's name and tick labels.
const LEFT: f64 = 70.0;
/// Room on the right, for the names of controls.
const RIGHT: f64 = 90.0;
/// Height of the data's rectangle.
const PLOT_HEIGHT: f64 = 300.0;
/// Least width of the data's rectangle.
const PLOT_WIDTH: f64 = 270.0;
/// Least width of a figure: titles and captions need it even beside a single panel.
const MIN_WIDTH: f64 = 720.0;
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
/// Size of tick labels.
pub(super) const TICK_SIZE: f64 = 10.5;
/// Size of axes' names.
const AXIS_SIZE: f64 = 11.5;

/// What stands before a legend's text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sample {
    /// A filled marker.
    Filled(Style),
    /// A hollow marker.
    Hollow(Style),
    /// A filled marker on a line.
    Line(Style),
    /// A strong line.
    Strong(Style),
    /// The dashes of controls.
    Dashes,
    /// Bars of intervals.
    Bars,
}

/// A line of the legend.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    /// The sample.
    pub sample: Sample,
    /// The text.
    pub label: String,
}

impl Entry {
    /// One with a text.
    pub(super) fn new(sample: Sample, label: impl Into<String>) -> Self {
        Self { sample, label: label.into() }
    }
}

/// Entries in rows and columns.
#[derive(Debug)]
struct Block {
    rows: Vec<Vec<Entry>>,
    /// Left edges.
    columns: Vec<f64>,
}

/// The frame of a figure.
#[derive(Debug)]
pub(super) struct Frame {
    title: String,
    subtitle: String,
    caption: Vec<String>,
    /// Who is who, then how to read.
    legends: Vec<Block>,
    columns: usize,
    panels: usize,
    width: f64,
    /// Height of the data's rectangle.
    plot_height: f64,
}

/// The rectangle of a panel's data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    /// Left edge.
    pub left: f64,
    /// Top edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Bottom edge.
    pub bottom: f64,
}

impl Frame {
    /// Lays a figure out.
    pub(super) fn new(
        panels: usize,
        [title, subtitle]: [String; 2],
        caption: &str,
        key: Vec<Entry>,
        legend: Vec<Entry>,
    ) -> Self {
        Self::in_columns(panels.min(3), PLOT_HEIGHT, panels, [title, subtitle], caption, key, legend)
    }

    /// Lays a figure out in so many columns of panels of a height.
    pub(super) fn in_columns(
        columns: usize,
        plot_height: f64,
        panels: usize,
        [title, subtitle]: [String; 2],
        caption: &str,
        key: Vec<Entry>,
        legend: Vec<Entry>,
    ) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let (panels, columns) = (panels.max(1), columns.max(1));
        let width = (columns as f64 * (LEFT + PLOT_WIDTH + RIGHT)).max(MIN_WIDTH);
        let inner = width - 2.0 * MARGIN;
        Self {
            title: shorten(&title, TITLE_SIZE, inner),
            subtitle: shorten(&subtitle, SUBTITLE_SIZE, inner),
            caption: wrap(caption, CAPTION_SIZE, inner, 4),
            legends: [legend, key].into_iter().map(|entries| in_columns(entries, inner)).collect(),
            columns,
            panels,
            width,
            plot_height,
        }
    }

    /// The figure's size.
    pub(super) fn size(&self) -> (f64, f64) {
        let caption = self.caption.len() as f64 * CAPTION_LINE + 8.0;
        (self.width, (self.legend_top() + self.legend_height() + caption + MARGIN).ceil())
    }

    /// The rectangle of a panel's data.
    pub(super) fn panel(&self, index: usize) -> Rect {
        let cell = self.width / self.columns as f64;
        let left = (index % self.columns) as f64 * cell + LEFT;
        let top = Self::head() + (index / self.columns) as f64 * self.row_height() + PANEL_TITLE;
        Rect { left, top, right: left - LEFT + cell - RIGHT, bottom: top + self.plot_height }
    }

    /// Draws everything around the panels.
    pub(super) fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        canvas.text(&self.title, (MARGIN, 20.0), Align::Start, TITLE_SIZE, INK)?;
        canvas.text(&self.subtitle, (MARGIN, 41.0), Align::Start, SUBTITLE_SIZE, GREY)?;
        let mut y = self.legend_top();
        for Block { rows, columns } in &self.legends {
            for row in rows {
                for (entry, left) in row.iter().zip(columns) {
                    let x = MARGIN + left;
                    draw_sample(canvas, entry.sample, (x + LEGEND_SAMPLE / 2.0 - 3.0, y))?;
                    canvas.text(&entry.label, (x + LEGEND_SAMPLE, y), Align::Start, LEGEND_SIZE, INK)?;
                }
                y += LEGEND_LINE;
            }
            y += if rows.is_empty() { 0.0 } else { 5.0 };
        }
        y += 6.0;
        for line in &self.caption {
            canvas.text(line, (MARGIN, y), Align::Start, CAPTION_SIZE, GREY)?;
            y += CAPTION_LINE;
        }
        Ok(())
    }

    fn head() -> f64 {
        54.0
    }

    fn row_height(&self) -> f64 {
        PANEL_TITLE + self.plot_height + PANEL_FOOT
    }

    fn legend_top(&self) -> f64 {
        Self::head() + self.panels.div_ceil(self.columns) as f64 * self.row_height() + 12.0
    }

    fn legend_height(&self) -> f64 {
        let rows = |Block { rows, .. }: &Block| {
            if rows.is_empty() { 0.0 } else { rows.len() as f64 * LEGEND_LINE + 5.0 }
        };
        self.legends.iter().map(rows).sum()
    }
}

/// Entries in as many columns as fit, each as wide as its widest.
fn in_columns(mut entries: Vec<Entry>, width: f64) -> Block {
    for entry in &mut entries {
        entry.label = shorten(&entry.label, LEGEND_SIZE, width - LEGEND_SAMPLE);
    }
    let widths: Vec<f64> =
        entries.iter().map(|entry| LEGEND_SAMPLE + text_width(&entry.label, LEGEND_SIZE) + 14.0).collect();
    let columns_of = |count: usize| -> Vec<f64> {
        let widest = |column: usize| widths.iter().skip(column).step_by(count).copied().fold(0.0, f64::max);
        (0..count).map(widest).collect()
    };
    let fits = |count: &usize| columns_of(*count).iter().sum::<f64>() <= width + 14.0;
    let count = (1..=entries.len().min(6)).rev().find(fits).unwrap_or(1);
    let mut left = 0.0;
    let mut columns = Vec::new();
    for column in columns_of(count) {
        columns.push(left);
        left += column;
    }
    Block { rows: entries.chunks(count).map(<[Entry]>::to_vec).collect(), columns }
}

fn draw_sample<DB: DrawingBackend>(canvas: &Canvas<DB>, sample: Sample, (x, y): (f64, f64)) -> Drawn {
    match sample {
        Sample::Filled(style) => canvas.filled_marker((x, y), 4.5, style),
        Sample::Hollow(style) => canvas.hollow_marker((x, y), 6.5, style),
        Sample::Line(style) => {
            canvas.path(&[(x - 13.0, y), (x + 13.0, y)], style.colour, 2.0)?;
            canvas.filled_marker((x, y), 4.0, style)
        }
        Sample::Strong(style) => canvas.path(&[(x - 13.0, y), (x + 13.0, y)], style.colour, STRONG),
        Sample::Dashes => canvas.dashed((x - 13.0, y), (x + 13.0, y), CONTROL, 1.0),
        Sample::Bars => {
            canvas.path(&[(x - 9.0, y), (x + 9.0, y)], GREY, 1.0)?;
            canvas.path(&[(x, y - 7.0), (x, y + 7.0)], GREY, 1.0)
        }
    }
}

impl Rect {
    /// The title above a panel, with the space beside it.
    pub(super) fn title<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, title: &str) -> Drawn {
        let text = shorten(title, 13.0, self.right - self.left + RIGHT - 6.0);
        canvas.text(&text, (self.left, self.top - 14.0), Align::Start, 13.0, INK)
    }

    /// The names of the axes, below so many lines of labels.
    pub(super) fn axis_names<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, x: &str, y: &str, lines: usize) -> Drawn {
        let middle = (self.left + self.right) / 2.0;
        let drop = if lines > 1 { 42.0 } else { 35.0 };
        let x = shorten(x, AXIS_SIZE, self.right - self.left + LEFT);
        canvas.text(&x, (middle, self.bottom + drop), Align::Middle, AXIS_SIZE, INK)?;
        canvas.text_upwards(y, (self.left - 57.0, (self.top + self.bottom) / 2.0), AXIS_SIZE, INK)
    }

    /// A tick of the lower axis with its grid line, its label on a line of several.
    pub(super) fn tick_below<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<DB>,
        x: f64,
        label: Option<&str>,
        line: usize,
    ) -> Drawn {
        if let Some(label) = label {
            canvas.path(&[(x, self.top), (x, self.bottom)], GRID, 1.0)?;
            canvas.path(&[(x, self.bottom), (x, self.bottom + 5.0)], GREY, 1.0)?;
            let drop = 15.0 + TICK_SIZE * line as f64;
            canvas.text(label, (x, self.bottom + drop), Align::Middle, TICK_SIZE, GREY)
        } else {
            canvas.path(&[(x, self.bottom), (x, self.bottom + 3.0)], GREY, 0.5)
        }
    }

    /// A tick of the left axis with its grid line.
    pub(super) fn tick_left<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, y: f64, label: Option<&str>) -> Drawn {
        if let Some(label) = label {
            canvas.path(&[(self.left, y), (self.right, y)], GRID, 1.0)?;
            canvas.path(&[(self.left - 5.0, y), (self.left, y)], GREY, 1.0)?;
            canvas.text(label, (self.left - 8.0, y), Align::End, TICK_SIZE, GREY)
        } else {
            canvas.path(&[(self.left - 3.0, y), (self.left, y)], GREY, 0.5)
        }
    }

    /// The edge of a panel, drawn last over the grid.
    pub(super) fn edge<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        canvas.outline((self.left, self.top), (self.right, self.bottom), GREY, 1.0)
    }

    /// Names in the gutter on the right, moved apart, each led to its height.
    pub(super) fn names_right<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<DB>,
        names: &[(String, f64, RGBColor)],
    ) -> Drawn {
        let wanted: Vec<f64> = names.iter().map(|(_, y, _)| *y).collect();
        let places = super::axis::spread(&wanted, 12.5, self.top + 4.0, self.bottom - 4.0);
        for ((name, y, colour), place) in names.iter().zip(places) {
            canvas.path(&[(self.right, *y), (self.right + 5.0, *y), (self.right + 11.0, place)], CONTROL, 0.5)?;
            let name = shorten(name, TICK_SIZE, RIGHT - 14.0);
            canvas.text(&name, (self.right + 13.0, place), Align::Start, TICK_SIZE, *colour)?;
        }
        Ok(())
    }

    /// A word in the middle of a panel that has nothing to show.
    pub(super) fn note<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, note: &str) -> Drawn {
        let middle = ((self.left + self.right) / 2.0, (self.top + self.bottom) / 2.0);
        canvas.text(&shorten(note, AXIS_SIZE, self.right - self.left - 8.0), middle, Align::Middle, AXIS_SIZE, GREY)
    }
}
