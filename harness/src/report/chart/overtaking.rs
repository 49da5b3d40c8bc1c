//! Break-even: what a frame takes by its number of rays.

use super::axis::log_range;
use super::canvas::register;
use super::frame::{Entry as Line, Frame, Sample};
use super::front::FrontStyles;
use super::palette::{GREY, Shape, Style};
use super::panel::{Aside, Axis, Chart, Mark, Panel, Place, Scale};
use super::{LONGEST_NAME, LONGEST_SET, cut, untimed_caption};
use crate::report::format::{self, percent, thousands};
use crate::results::Run;
use crate::studies::pareto::{BEYOND, Class, ClassCost, Field, Overtaking};

const PLOT_HEIGHT: f64 = 240.0;
const MEASURED: f64 = 3.0;
/// Places of a line.
const PLACES: u32 = 64;

/// The chart of who overtakes whom: a panel a class.
pub(super) fn chart(run: &Run, field: &Field<'_>, classes: &[Class<'_>], styles: &FrontStyles) -> Chart {
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
        format!("Break-even: {} ({} triangles), {rays}", cut(&scene.name, LONGEST_NAME), thousands(scene.triangles)),
        format!("viewpoint {}; points that are right as often, by {by}", field.viewpoint.name),
    ];
    let clock = "Times by the host's clock, of work on a device from submission until done.";
    let caption = format!("{clock} {}", untimed_caption(&run.provenance, &run.preset));
    let frame = Frame::in_columns(3, PLOT_HEIGHT, panels.len(), titles, &caption, key, legend);
    Chart { frame, panels }
}

fn panel(class: &Class<'_>, styles: &FrontStyles) -> Panel {
    let curve = |cost: &ClassCost<'_>| {
        let rays = || cost.cost.traces.samples.iter().map(|(rays, _)| *rays);
        let least = rays().fold(f64::INFINITY, f64::min) / BEYOND;
        let most = rays().fold(0.0, f64::max) * BEYOND;
        let at = |place: u32| least * (most / least).powf(f64::from(place) / f64::from(PLACES));
        let point = |rays: f64| (rays, cost.cost.at(rays).value);
        let line: Vec<Place> = (0..=PLACES).map(|place| point(at(place))).filter(|(_, ms)| *ms > 0.0).collect();
        let measured: Vec<Place> = rays().map(point).filter(|(_, ms)| *ms > 0.0).collect();
        (styles.get(cost.entry.point), line, measured)
    };
    let decided = |overtakes: &Overtaking| match overtakes {
        Overtaking::At { rays, .. } => Some(*rays),
        Overtaking::Always(_) | Overtaking::Undecided(_) => None,
    };
    let overtakes: Vec<&Overtaking> = class.stretches.iter().filter_map(|stretch| stretch.overtakes.as_ref()).collect();
    let curves: Vec<(Style, Vec<Place>, Vec<Place>)> = class.costs.iter().map(curve).collect();
    let all = || curves.iter().flat_map(|(_, line, _)| line);
    let scales = [log_range(all().map(|(rays, _)| *rays)), log_range(all().map(|(_, ms)| *ms))];
    let [x, y] = scales.map(|range| Scale::Log(range, 6));
    let aside = Aside::default();
    let mut marks: Vec<Mark> = overtakes.iter().filter_map(|found| decided(found)).map(Mark::Rule).collect();
    for (style, line, _) in &curves {
        marks.push(Mark::Line { places: line.clone(), colour: style.colour, width: 1.5, dashed: false, aside });
    }
    for (style, place) in
        curves.iter().flat_map(|(style, _, measured)| measured.iter().map(move |place| (style, place)))
    {
        marks.push(Mark::Marker { place: *place, radius: MEASURED, style: *style, hollow: false, aside });
    }
    let undecided = overtakes.iter().filter(|found| decided(found).is_none()).count();
    if undecided > 0 {
        let changes = if undecided == 1 { "change" } else { "changes" };
        marks.push(Mark::Words(format!("{undecided} {changes} undecided")));
    }
    Panel {
        title: format!("{}, at least {} % right", class.motion.name(), percent(class.level, 10_000)),
        x: Axis { name: "rays a frame".to_owned(), scale: x },
        y: Axis { name: "frame (ms)".to_owned(), scale: y },
        controls: Vec::new(),
        marks,
        note: curves.is_empty().then_some("no point is right so often"),
    }
}
