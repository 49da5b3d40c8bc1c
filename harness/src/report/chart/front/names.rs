//! Names beside the points of a front.

use super::{ARROW, FrontFigure, Mark, NAME_SIZE, ON_FRONT, Panel, line_round};
use crate::report::chart::canvas::text_width;
use crate::report::chart::frame::Rect;
use crate::studies::pareto::FrontStatus;

/// Height of a line of names.
const NAME_LINE: f64 = 12.0;

/// A point's name.
#[derive(Debug)]
pub(super) struct Name<'a> {
    /// The point.
    pub mark: &'a Mark,
    /// Where it begins, and its middle.
    pub place: (f64, f64),
}

/// What a mark covers: left, right, top and bottom.
fn box_of((left, top): (f64, f64), mark: &Mark) -> [f64; 4] {
    let below = if mark.at_bound { ARROW[1] } else { ON_FRONT };
    [left - ON_FRONT, left + ON_FRONT, top - ON_FRONT, top + below]
}

/// The box round a line that goes along or up.
fn box_round(from: (f64, f64), to: (f64, f64)) -> [f64; 4] {
    [from.0.min(to.0), from.0.max(to.0), from.1.min(to.1), from.1.max(to.1)]
}

/// Whether two boxes lie less than a hair apart.
fn meet(one: &[f64; 4], other: &[f64; 4]) -> bool {
    one[0] < other[1] + 2.0 && other[0] < one[1] + 2.0 && one[2] < other[3] + 1.0 && other[2] < one[3] + 1.0
}

impl FrontFigure {
    /// The names of points on the front, of neighbours of the same name one, and of every other tracer's best; each where it meets no
    /// other.
    pub(super) fn names<'a>(&self, panel: &'a Panel, rect: Rect) -> Vec<Name<'a>> {
        let [x, y] = panel.ground.axes(rect);
        // Names keep off the line of the front and those of controls.
        let front = line_round(&panel.front(), [&x, &y]);
        let mut lines: Vec<[f64; 4]> = front.windows(2).map(|ends| box_round(ends[0], ends[1])).collect();
        let controls = panel.ground.controls.iter().flat_map(|(_, places)| places);
        let heights = controls.map(|(_, share)| y.at(*share));
        lines.extend(heights.map(|height| box_round((rect.left, height), (rect.right, height))));
        let (mut on, behind): (Vec<&Mark>, Vec<&Mark>) =
            panel.marks.iter().partition(|mark| mark.front_status == FrontStatus::OnFront);
        on.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(b.y.total_cmp(&a.y)));
        on.dedup_by(|next, before| next.name == before.name);
        let is_named: Vec<&str> = on.iter().map(|mark| mark.tracer.as_str()).collect();
        let best = behind.into_iter().filter(|mark| mark.is_best && !is_named.contains(&mark.tracer.as_str()));
        let all: Vec<&Mark> = on.iter().copied().chain(best).collect();
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let place = |mark: &Mark| mark.place([&x, &y]);
        let mut names = Vec::new();
        let marks = panel.marks.iter().map(|mark| box_of(place(mark), mark));
        let drawn: Vec<[f64; 4]> = marks.chain(lines).collect();
        for mark in all {
            let (left, top) = place(mark);
            let width = text_width(&mark.name, NAME_SIZE);
            let covers = |(begin, middle): &(f64, f64)| {
                [*begin, begin + width, middle - NAME_LINE / 2.0, middle + NAME_LINE / 2.0]
            };
            let free = |corner: &(f64, f64)| {
                let own = covers(corner);
                let inside = own[0] >= rect.left + 2.0
                    && own[1] <= rect.right - 2.0
                    && own[2] >= rect.top + 2.0
                    && own[3] <= rect.bottom - 2.0;
                inside && !taken.iter().any(|other| meet(&own, other))
            };
            let clear = |corner: &(f64, f64)| free(corner) && !drawn.iter().any(|other| meet(&covers(corner), other));
            let corners = [
                (left + 8.0, top - 8.0),
                (left + 8.0, top + 8.0),
                (left - 8.0 - width, top - 8.0),
                (left - 8.0 - width, top + 8.0),
                (left - width / 2.0, top - 15.0),
                (left - width / 2.0, top + 20.0),
                (left + 8.0, top - 22.0),
                (left - 8.0 - width, top - 22.0),
                (left + 8.0, top + 22.0),
                (left - 8.0 - width, top + 22.0),
                (left - width / 2.0, top + 34.0),
                (left - width / 2.0, top - 30.0),
                (left + 16.0, top),
                (left - 16.0 - width, top),
                (left + 8.0, top + 36.0),
                (left - 8.0 - width, top + 36.0),
                (left + 8.0, top - 36.0),
                (left - 8.0 - width, top - 36.0),
            ];
            // One that finds no room is told by its colour and form.
            let found = corners.iter().copied().find(clear).or_else(|| corners.iter().copied().find(free));
            let Some((begin, middle)) = found else { continue };
            taken.push(covers(&(begin, middle)));
            names.push(Name { mark, place: (begin, middle) });
        }
        names
    }
}
