//! Break-even: what a frame takes by its number of rays.

use plotters::prelude::DrawingBackend;

use super::axis::{LogAxis, labels, log_range};
use super::canvas::{Align, Canvas, Drawn, Figure, register, shorten};
use super::frame::{Entry as Line, Frame, Rect, Sample, TICK_SIZE};
use super::front::FrontStyles;
use super::palette::{CONTROL, GREY, Shape, Style};
use super::{LONGEST_NAME, LONGEST_SET, cut, untimed_caption};
use crate::report::format::{self, percent, thousands};
use crate::results::Run;
use crate::studies::pareto::{BEYOND, Class, ClassCost, Field, Overtaking};

const PLOT_HEIGHT: f64 = 240.0;
const MEASURED: f64 = 3.0;
/// Places of a line.
const PLACES: u32 = 64;

/// What a point takes, by its number of rays.
#[derive(Debug)]
struct Curve {
    style: Style,
    line: Vec<(f64, f64)>,
    measured: Vec<(f64, f64)>,
}

#[derive(Debug)]
struct Panel {
    title: String,
    curves: Vec<Curve>,
    /// Numbers of rays at which the cheapest is overtaken, where that is decided.
    changes: Vec<f64>,
    undecided: usize,
}

/// The chart.
#[derive(Debug)]
pub(in crate::report) struct OvertakingFigure {
    frame: Frame,
    panels: Vec<Panel>,
}

impl OvertakingFigure {
    /// A panel a class.
    pub(in crate::report) fn new(run: &Run, field: &Field<'_>, classes: &[Class<'_>], styles: &FrontStyles) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let panels: Vec<Panel> = classes.iter().map(|class| panel(class, styles)).collect();
        let grey = Style { colour: GREY, shape: Shape::Circle };
        let line = |sample, label: &str| Line { sample, label: label.to_owned() };
        let key = vec![
            line(Sample::Filled(grey), "measured"),
            line(Sample::Dashes, "the cheapest is overtaken, decided by intervals that do not overlap"),
        ];
        let mut legend: Vec<Line> = Vec::new();
        for cost in classes.iter().flat_map(|class| &class.costs) {
            let name = cost.entry.point.contender();
            if legend.iter().all(|line| line.label != name) {
                legend.push(Line { sample: Sample::Line(styles.get(cost.entry.point)), label: name });
            }
        }
        let scene = &field.scene.scene;
        let rays = format!("{}, {}", cut(field.rays, LONGEST_SET), format::query(field.query));
        let by = classes.first().map_or("", |class| class.by.name());
        let titles = [
            format!(
                "Break-even: {} ({} triangles), {rays}",
                cut(&scene.name, LONGEST_NAME),
                thousands(scene.triangles)
            ),
            format!("viewpoint {}; points that are right as often, by {by}", field.viewpoint.name),
        ];
        let clock = "Times by the host's clock, of work on a device from submission until done.";
        let caption = format!("{clock} {}", untimed_caption(&run.provenance, &run.preset));
        let frame = Frame::in_columns(3, PLOT_HEIGHT, panels.len(), titles, &caption, key, legend);
        Self { frame, panels }
    }
}

fn panel(class: &Class<'_>, styles: &FrontStyles) -> Panel {
    let curve = |cost: &ClassCost<'_>| {
        let rays = || cost.cost.traces.samples.iter().map(|(rays, _)| *rays);
        let least = rays().fold(f64::INFINITY, f64::min) / BEYOND;
        let most = rays().fold(0.0, f64::max) * BEYOND;
        let at = |place: u32| least * (most / least).powf(f64::from(place) / f64::from(PLACES));
        let point = |rays: f64| (rays, cost.cost.at(rays).value);
        Curve {
            style: styles.get(cost.entry.point),
            line: (0..=PLACES).map(|place| point(at(place))).filter(|(_, ms)| *ms > 0.0).collect(),
            measured: rays().map(point).filter(|(_, ms)| *ms > 0.0).collect(),
        }
    };
    let decided = |overtakes: &Overtaking| match overtakes {
        Overtaking::At { rays, .. } => Some(*rays),
        Overtaking::Always(_) | Overtaking::Undecided(_) => None,
    };
    let overtakes: Vec<&Overtaking> = class.stretches.iter().filter_map(|stretch| stretch.overtakes.as_ref()).collect();
    Panel {
        title: format!("{}, at least {} % right", class.motion.name(), percent(class.level, 10_000)),
        curves: class.costs.iter().map(curve).collect(),
        changes: overtakes.iter().filter_map(|found| decided(found)).collect(),
        undecided: overtakes.iter().filter(|found| decided(found).is_none()).count(),
    }
}

impl Figure for OvertakingFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            draw_panel(canvas, panel, self.frame.panel(index))?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(canvas: &Canvas<DB>, panel: &Panel, rect: Rect) -> Drawn {
    let all = || panel.curves.iter().flat_map(|curve| &curve.line);
    let x = LogAxis::new(log_range(all().map(|(rays, _)| *rays)), rect.left, rect.right);
    let y = LogAxis::new(log_range(all().map(|(_, ms)| *ms)), rect.bottom, rect.top);
    let ticks = x.ticks(6);
    for (tick, text) in ticks.iter().zip(labels(&ticks)) {
        rect.tick_below(canvas, x.at(tick.value), text.as_deref())?;
    }
    let ticks = y.ticks(6);
    for (tick, text) in ticks.iter().zip(labels(&ticks)) {
        rect.tick_left(canvas, y.at(tick.value), text.as_deref())?;
    }
    rect.title(canvas, &panel.title)?;
    rect.axis_names(canvas, "rays a frame", "frame (ms)")?;
    rect.edge(canvas)?;
    for rays in &panel.changes {
        canvas.dashed((x.at(*rays), rect.top), (x.at(*rays), rect.bottom), CONTROL, 1.0)?;
    }
    let at = |(rays, ms): &(f64, f64)| (x.at(*rays), y.at(*ms));
    for curve in &panel.curves {
        let line: Vec<(f64, f64)> = curve.line.iter().map(at).collect();
        canvas.path(&line, curve.style.colour, 1.5)?;
    }
    for curve in &panel.curves {
        for place in curve.measured.iter().map(at) {
            canvas.filled_marker(place, MEASURED, curve.style)?;
        }
    }
    if panel.undecided > 0 {
        let note = format!("{} {} undecided", panel.undecided, if panel.undecided == 1 { "change" } else { "changes" });
        let note = shorten(&note, TICK_SIZE, rect.right - rect.left - 8.0);
        canvas.text(&note, (rect.right - 4.0, rect.bottom - 9.0), Align::End, TICK_SIZE, GREY)?;
    }
    if panel.curves.is_empty() {
        rect.note(canvas, "no point is right so often")?;
    }
    Ok(())
}
