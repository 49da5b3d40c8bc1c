//! Fronts for a page: a chart without its points, and the points at the places where the chart would draw them.

use plotters::prelude::DrawingBackend;

use super::{ARROW, CAP, FRONT_WIDTH, FrontFigure, HOLLOW, Mark, NAME_SIZE, ON_FRONT, OWN_WIDTH, Panel, line_round};
use crate::report::chart::canvas::{Canvas, DrawError, Drawn, Figure, SCALE, to_svg};
use crate::report::chart::palette::{Shape, hex};
use crate::studies::pareto::{Amount, Cost, FrontStatus};

/// A chart in two layers.
#[derive(Debug)]
pub(in crate::report) struct FrontLayers {
    /// Everything but the points, as SVG.
    pub ground: String,
    /// By how much lengths of the points are smaller than the ground's.
    pub scale: f64,
    /// Widths of the lines of the front of all and of a tracer's own.
    pub widths: [f64; 2],
    /// Radii of marks on the front and within noise of it.
    pub radii: [f64; 2],
    /// Size of names.
    pub name_size: f64,
    /// The points, by panel.
    pub panels: Vec<PanelPoints>,
}

/// The points of a panel.
#[derive(Debug)]
pub(in crate::report) struct PanelPoints {
    /// What they cost.
    pub cost: Cost,
    /// Its name with the unit.
    pub cost_name: String,
    /// The line of the front of all, as a path.
    pub front: String,
    /// Each tracer's own, with its colour.
    pub own: Vec<(String, String, String)>,
    /// The points, those on the front last.
    pub points: Vec<PointMark>,
}

/// A point.
#[derive(Debug)]
pub(in crate::report) struct PointMark {
    /// Its place among the record's points.
    pub index: usize,
    /// Its tracer.
    pub tracer: String,
    /// Where it is.
    pub place: (f64, f64),
    /// Its colour.
    pub colour: String,
    /// Its outline round its place, as a path; of a circle none.
    pub outline: Option<String>,
    /// The bars of its intervals round its place, as a path.
    pub bars: String,
    /// The arrow below it, as a path, if it is drawn at the bound.
    pub arrow: Option<String>,
    /// How it stands.
    pub front_status: FrontStatus,
    /// Whether it is its tracer's best.
    pub is_best: bool,
    /// What it costs as people read it.
    pub read: Amount,
    /// By how much points are distinguished: what it costs, and its error.
    pub spot: [f64; 2],
    /// Its name, where it has one beside it, and where that begins.
    pub name: Option<(String, (f64, f64))>,
}

struct Ground<'a>(&'a FrontFigure);

impl Figure for Ground<'_> {
    fn size(&self) -> (f64, f64) {
        self.0.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.0.frame.draw(canvas)?;
        for (index, panel) in self.0.panels.iter().enumerate() {
            panel.ground.draw(canvas, self.0.frame.panel(index))?;
        }
        Ok(())
    }
}

impl FrontFigure {
    /// The chart in two layers.
    pub(in crate::report) fn layers(&self) -> Result<FrontLayers, DrawError> {
        let panels = self.panels.iter().enumerate().map(|(index, panel)| self.points_of(index, panel)).collect();
        Ok(FrontLayers {
            ground: to_svg(&Ground(self))?,
            scale: SCALE,
            widths: [FRONT_WIDTH, OWN_WIDTH],
            radii: [ON_FRONT, HOLLOW],
            name_size: NAME_SIZE,
            panels,
        })
    }

    fn points_of(&self, index: usize, panel: &Panel) -> PanelPoints {
        let rect = self.frame.panel(index);
        let [x, y] = panel.ground.axes(rect);
        let names = self.names(panel, rect);
        let point = |mark: &&Mark| {
            let (left, top) = mark.place([&x, &y]);
            let across = mark.x.interval.map(|end| x.at(end) - left);
            let up = mark.error.interval.map(|share| y.at(share.max(10.0_f64.powf(self.floor))) - top);
            let mut bars = path(&[(across[0], 0.0), (across[1], 0.0)]) + &path(&[(0.0, up[0]), (0.0, up[1])]);
            for end in up.into_iter().filter(|end| end.abs() > 2.0 * ON_FRONT) {
                bars += &path(&[(-CAP, end), (CAP, end)]);
            }
            let [from, to] = ARROW;
            let arrow = || path(&[(0.0, from), (0.0, to)]) + &path(&[(-CAP, to - 3.0), (0.0, to), (CAP, to - 3.0)]);
            let named = names.iter().find(|name| std::ptr::eq(name.mark, *mark));
            PointMark {
                index: mark.index,
                tracer: mark.tracer.clone(),
                place: (left, top),
                colour: hex(mark.style.colour),
                outline: (mark.style.shape != Shape::Circle).then(|| path(&mark.style.shape.corners(ON_FRONT)) + "z"),
                bars,
                arrow: mark.at_bound.then(arrow),
                front_status: mark.front_status,
                is_best: mark.is_best,
                read: mark.x,
                spot: [mark.cost, mark.y],
                name: named.map(|name| (mark.name.clone(), name.place)),
            }
        };
        PanelPoints {
            cost: panel.cost,
            cost_name: panel.ground.x.name.clone(),
            front: path(&line_round(&panel.front(), [&x, &y])),
            own: panel
                .own
                .iter()
                .map(|(tracer, colour, corners)| (tracer.clone(), hex(*colour), path(&line_round(corners, [&x, &y]))))
                .collect(),
            points: panel.in_order().iter().map(point).collect(),
        }
    }
}

/// A line through places as the path of an SVG.
fn path(places: &[(f64, f64)]) -> String {
    let short = |length: f64| (length * 100.0).round() / 100.0;
    let step = |(index, (x, y)): (usize, &(f64, f64))| {
        format!("{}{} {}", if index == 0 { "M" } else { "L" }, short(*x), short(*y))
    };
    places.iter().enumerate().map(step).collect()
}
