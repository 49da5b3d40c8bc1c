//! Wrong rays over the strength of cases, a panel a case.

use plotters::prelude::DrawingBackend;

use super::axis::{LogAxis, percent_label};
use super::canvas::{Align, Canvas, Drawn, Figure, register};
use super::frame::{Entry, Frame, Rect, Sample, TICK_SIZE};
use super::palette::{GREY, SHADE, Shape, Style, Styles};
use super::{LONGEST_TRACER, cut};
use crate::report::format;
use crate::report::stability::knob_value;
use crate::studies::stability::{CaseMatrix, Stability};

/// Height of the row for zero at the foot of a panel; a logarithm never gets there.
const ZERO_ROW: f64 = 26.0;
/// Decimal logarithm of the least share shown: a case has a thousand rays or so.
const FLOOR: f64 = -3.5;
const FILLED: f64 = 4.0;
const HOLLOW: f64 = 6.0;

/// One tracer in a panel: shares by strength, `None` where there are no answers.
#[derive(Debug)]
struct Curve {
    style: Style,
    tight: Vec<Option<f64>>,
    footprint: Vec<Option<f64>>,
}

#[derive(Debug)]
struct Panel {
    title: String,
    knob: String,
    values: Vec<String>,
    curves: Vec<Curve>,
}

/// The chart.
#[derive(Debug)]
pub(super) struct StrengthFigure {
    frame: Frame,
    panels: Vec<Panel>,
}

impl StrengthFigure {
    /// Takes what it shows from a run of cases.
    pub(super) fn new(stability: &Stability) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let tracers = stability.tracers();
        let styles = Styles::of_labels(tracers.iter().cloned());
        let panels: Vec<Panel> = stability.cases.iter().map(|case| panel(case, &styles)).collect();
        // A tracer that this machine cannot run keeps its colour for others, and is not shown.
        let measured = |label: &&String| {
            stability
                .cases
                .iter()
                .flat_map(|case| &case.cells)
                .any(|cell| cell.tracer == **label && !cell.measured.is_empty())
        };
        let legend = tracers
            .iter()
            .filter(measured)
            .map(|label| Entry { sample: Sample::Line(styles.get(label)), label: cut(label, LONGEST_TRACER) });
        let grey = Style { colour: GREY, shape: Shape::Circle };
        let entry = |sample, label: &str| Entry { sample, label: label.to_owned() };
        let key = vec![
            entry(Sample::Line(grey), "footprint rule; any hit: occlusion"),
            entry(Sample::Hollow(grey), "tight rule (dashed)"),
        ];
        let titles = [
            "Wrong rays over the strength of one difficulty".to_owned(),
            "From left to right harder; ties are left out".to_owned(),
        ];
        let commit = format::commit(&stability.provenance.commit, stability.provenance.dirty);
        let caption = format!("Commit {commit}. Machine: {}.", stability.provenance.machine.label());
        let frame = Frame::new(panels.len(), titles, &caption, key, legend.collect());
        Self { frame, panels }
    }
}

fn panel(CaseMatrix { case, cells }: &CaseMatrix, styles: &Styles) -> Panel {
    let curves = cells.iter().filter(|cell| !cell.measured.is_empty()).map(|cell| {
        let wrong = || cell.measured.iter().map(|measured| measured.wrong);
        Curve {
            style: styles.get(&cell.tracer),
            tight: wrong().map(|wrong| wrong.map(|wrong| wrong.tight)).collect(),
            footprint: wrong().map(|wrong| wrong.map(|wrong| wrong.footprint)).collect(),
        }
    });
    let rays = case.strengths.first().map_or(0, |strength| strength.rays);
    let knob = &case.knob;
    Panel {
        title: format!("{}: {} rays", case.name, format::thousands(rays)),
        knob: if knob.unit.is_empty() { knob.name.clone() } else { format!("{} ({})", knob.name, knob.unit) },
        values: knob.values.iter().map(|value| knob_value(*value)).collect(),
        curves: curves.collect(),
    }
}

/// The axes of one panel; strengths stand at equal distances, whatever their values.
struct Scales {
    rect: Rect,
    y: LogAxis,
    count: usize,
}

impl Scales {
    fn x(&self, index: usize) -> f64 {
        let part = (index as f64 + 0.5) / self.count.max(1) as f64;
        self.rect.left + (self.rect.right - self.rect.left) * part
    }

    fn y(&self, share: f64) -> f64 {
        if share > 0.0 { self.y.at(share) } else { self.rect.bottom - ZERO_ROW / 2.0 }
    }

    /// The places of shares, and the lines between neighbours.
    fn place(&self, shares: &[Option<f64>], aside: f64) -> Vec<Option<(f64, f64)>> {
        let at = |(index, share): (usize, &Option<f64>)| share.map(|share| (self.x(index) + aside, self.y(share)));
        shares.iter().enumerate().map(at).collect()
    }
}

impl Figure for StrengthFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            let rect = self.frame.panel(index);
            // A little above 100 %, so that markers there are whole.
            let y = LogAxis::new((FLOOR, 0.15), rect.bottom - ZERO_ROW, rect.top);
            draw_panel(canvas, panel, &Scales { rect, y, count: panel.values.len() })?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(canvas: &Canvas<DB>, panel: &Panel, scales: &Scales) -> Drawn {
    let rect = scales.rect;
    canvas.fill((rect.left, rect.bottom - ZERO_ROW), (rect.right, rect.bottom), SHADE)?;
    for (index, value) in panel.values.iter().enumerate() {
        rect.tick_below(canvas, scales.x(index), Some(value))?;
    }
    for tick in scales.y.ticks(9).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9) {
        let text = tick.labelled.then(|| percent_label(tick.value));
        rect.tick_left(canvas, scales.y.at(tick.value), text.as_deref())?;
    }
    canvas.text("0", (rect.left - 8.0, scales.y(0.0)), Align::End, TICK_SIZE, GREY)?;
    rect.title(canvas, &panel.title)?;
    rect.axis_names(canvas, &panel.knob, "wrong rays (%)")?;
    rect.edge(canvas)?;
    let gap = (2.0 * HOLLOW + 1.0).min(0.8 * (scales.x(1) - scales.x(0)) / panel.curves.len().max(1) as f64);
    // Tracers that coincide stand side by side.
    let aside = |order: usize| gap * (order as f64 - (panel.curves.len() as f64 - 1.0) / 2.0);
    // All lines before all markers: a line over a marker would hide which kind it is.
    for (order, curve) in panel.curves.iter().enumerate() {
        for pair in scales.place(&curve.tight, aside(order)).windows(2) {
            if let [Some(from), Some(to)] = pair {
                canvas.dashed(*from, *to, curve.style.colour, 1.0)?;
            }
        }
        for pair in scales.place(&curve.footprint, aside(order)).windows(2) {
            if let [Some(from), Some(to)] = pair {
                canvas.path(&[*from, *to], curve.style.colour, 2.0)?;
            }
        }
    }
    for (order, curve) in panel.curves.iter().enumerate() {
        // Hollow ones first: they are larger, and where both rules agree the filled one sits inside.
        for place in scales.place(&curve.tight, aside(order)).into_iter().flatten() {
            canvas.hollow_marker(place, HOLLOW, curve.style)?;
        }
        for place in scales.place(&curve.footprint, aside(order)).into_iter().flatten() {
            canvas.filled_marker(place, FILLED, curve.style)?;
        }
    }
    Ok(())
}
