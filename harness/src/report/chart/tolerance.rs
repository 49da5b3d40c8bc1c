//! Agreement over tolerance: how near hits must be asked to be before a tracer fails.

use plotters::prelude::DrawingBackend;
use tracebench_api::Query;

use super::axis::{LogAxis, labels, log_range};
use super::canvas::{Canvas, Drawn, Figure, register};
use super::frame::{Entry, Frame, Rect, Sample};
use super::palette::{CONTROL, Style, Styles};
use super::{caption, legend_label, panel_title, titles};
use crate::report::group::{Group, RaySet, Role};
use crate::report::metrics;
use crate::results::Run;

/// Markers on a curve, apart from each other by at least this much, so that the line shows between them.
const MARKER_GAP: f64 = 48.0;

/// A curve: tolerance and agreement, by rising tolerance.
type Curve = Vec<[f64; 2]>;

#[derive(Debug)]
struct Panel {
    title: String,
    contenders: Vec<(Style, Curve)>,
    controls: Vec<(String, Curve)>,
}

/// The chart.
#[derive(Debug)]
pub(super) struct ToleranceFigure {
    frame: Frame,
    panels: Vec<Panel>,
    tolerances: (f64, f64),
}

impl ToleranceFigure {
    /// Takes what it shows from a group.
    pub(super) fn new(run: &Run, group: &Group<'_>, styles: &Styles) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let sets = group.ray_sets.iter().filter(|set| set.query == Query::Closest);
        let panels: Vec<Panel> = sets.map(|set| panel(group, set, styles)).collect();
        let contenders = panels.iter().flat_map(|panel| panel.contenders.iter().map(|(_, curve)| curve));
        let curves = contenders.chain(panels.iter().flat_map(|panel| panel.controls.iter().map(|(_, curve)| curve)));
        let tolerances = log_range(curves.flatten().map(|point| point[0]));
        let legend = group
            .contenders
            .iter()
            .map(|one| Entry { sample: Sample::Line(styles.get(&one.label())), label: legend_label(one, &[]) });
        let key = vec![Entry { sample: Sample::Dashes, label: "control".to_owned() }];
        let titles = titles("Agreement over tolerance", run, group);
        let frame = Frame::new(panels.len(), titles, &caption(run, group), key, legend.collect());
        Self { frame, panels, tolerances }
    }
}

fn panel(group: &Group<'_>, set: &RaySet<'_>, styles: &Styles) -> Panel {
    let mut contenders = Vec::new();
    let mut controls = Vec::new();
    for (role, run, trace) in group.traces(set) {
        let Some(judgement) = metrics::closest(trace) else { continue };
        let whole = |point: &[f64; 2]| point[0] > 0.0 && point.iter().all(|each| each.is_finite());
        let mut curve: Curve = judgement.curve.iter().copied().filter(whole).collect();
        curve.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let name = run.label();
        match role {
            _ if curve.is_empty() => {}
            Role::Control => controls.push((name, curve)),
            Role::Contender => contenders.push((styles.get(&name), curve)),
        }
    }
    Panel { title: panel_title(set), contenders, controls }
}

impl Figure for ToleranceFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            let rect = self.frame.panel(index);
            draw_panel(canvas, panel, rect, LogAxis::new(self.tolerances, rect.left, rect.right))?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(canvas: &Canvas<DB>, panel: &Panel, rect: Rect, x: LogAxis) -> Drawn {
    // Air above 100 % and below 0 %, where lines often run.
    let (top, bottom) = (rect.top + 10.0, rect.bottom - 10.0);
    let y = |share: f64| bottom + (top - bottom) * share.clamp(0.0, 1.0);
    let ticks = x.ticks(6);
    for (tick, text) in ticks.iter().zip(labels(&ticks)) {
        rect.tick_below(canvas, x.at(tick.value), text.as_deref())?;
    }
    for percent in (0..=100).step_by(20) {
        rect.tick_left(canvas, y(f64::from(percent) / 100.0), Some(&format!("{percent} %")))?;
    }
    rect.title(canvas, &panel.title)?;
    rect.axis_names(canvas, "tolerance (scene diagonals)", "agreement (%)")?;
    let place =
        |curve: &Curve| curve.iter().map(|[tolerance, share]| (x.at(*tolerance), y(*share))).collect::<Vec<_>>();
    let mut names = Vec::new();
    for (name, curve) in &panel.controls {
        let mut points = place(curve);
        names.push((name.clone(), points[points.len() - 1].1));
        // On to the edge, where its name is.
        points.push((rect.right, points[points.len() - 1].1));
        canvas.dashed_path(&points, CONTROL, 1.0)?;
    }
    rect.names_right(canvas, &names)?;
    rect.edge(canvas)?;
    for (style, curve) in &panel.contenders {
        canvas.path(&place(curve), style.colour, 2.0)?;
    }
    for (index, (style, curve)) in panel.contenders.iter().enumerate() {
        // Each begins elsewhere, so that the markers of curves that coincide stand side by side.
        let mut next = rect.left + MARKER_GAP * (index as f64 / panel.contenders.len() as f64);
        for point in place(curve) {
            if point.0 >= next {
                canvas.filled_marker(point, 4.0, *style)?;
                next = point.0 + MARKER_GAP;
            }
        }
    }
    if panel.contenders.is_empty() {
        rect.note(canvas, "no contender traced these rays")?;
    }
    Ok(())
}
