//! Names beside the points of a front.

use super::{ARROW, NAME_SIZE, ON_FRONT, Placed, Places, Point};
use crate::report::chart::canvas::text_width;
use crate::report::chart::frame::Rect;
use crate::report::chart::panel::Panel;
use crate::studies::pareto::FrontStatus;

/// Height of a line of names.
const NAME_LINE: f64 = 12.0;

/// How far below a point the middle of its name may be, first where it is best.
const DROPS: [f64; 18] =
    [-8.0, 8.0, -8.0, 8.0, -15.0, 20.0, -22.0, -22.0, 22.0, 22.0, 34.0, -30.0, 0.0, 0.0, 36.0, 36.0, -36.0, -36.0];

/// A point's name.
#[derive(Debug)]
pub(in crate::report) struct Name<'a> {
    pub point: &'a Point,
    /// Where it begins, and its middle.
    pub place: (f64, f64),
}

/// What a point covers: left, right, top and bottom.
fn box_of(Placed { point, place: (left, top), .. }: &Placed<'_>) -> [f64; 4] {
    let below = if point.at_bound { ARROW[1] } else { ON_FRONT };
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

/// The names of points on the front, of neighbours of the same name one, and of every other tracer's best; each where it meets no
/// other.
pub(super) fn names<'a>(panel: &Panel, rect: Rect, front: &Places, points: &[Placed<'a>]) -> Vec<Name<'a>> {
    let [_, y] = panel.axes(rect);
    // Names keep off the line of the front and those of controls.
    let front = front.windows(2).map(|ends| box_round(ends[0], ends[1]));
    let heights = panel.controls.iter().flat_map(|(_, places)| places).map(|(_, share)| y.at(*share));
    let controls = heights.map(|height| box_round((rect.left, height), (rect.right, height)));
    let drawn: Vec<[f64; 4]> = points.iter().map(box_of).chain(front).chain(controls).collect();
    let is_on = |placed: &&Placed<'_>| placed.point.front_status == FrontStatus::OnFront;
    let (mut on, behind): (Vec<&Placed<'a>>, Vec<&Placed<'a>>) = points.iter().partition(is_on);
    on.sort_by(|a, b| a.point.cost.total_cmp(&b.point.cost).then(b.point.y.total_cmp(&a.point.y)));
    on.dedup_by(|next, before| next.point.name == before.point.name);
    let (mut taken, mut names): (Vec<[f64; 4]>, _) = (Vec::new(), Vec::new());
    let is_named: Vec<&str> = on.iter().map(|placed| &*placed.point.tracer).collect();
    let best = behind.into_iter().filter(|Placed { point, .. }| point.is_best && !is_named.contains(&&*point.tracer));
    for Placed { point, place: (left, top), .. } in on.into_iter().chain(best) {
        let width = text_width(&point.name, NAME_SIZE);
        let covers =
            |(begin, middle): &(f64, f64)| [*begin, begin + width, middle - NAME_LINE / 2.0, middle + NAME_LINE / 2.0];
        let free = |corner: &(f64, f64)| {
            let own = covers(corner);
            let inside = own[0] >= rect.left + 2.0
                && own[1] <= rect.right - 2.0
                && own[2] >= rect.top + 2.0
                && own[3] <= rect.bottom - 2.0;
            inside && !taken.iter().any(|other| meet(&own, other))
        };
        let clear = |corner: &(f64, f64)| free(corner) && !drawn.iter().any(|other| meet(&covers(corner), other));
        let ([right, far], [before, ahead]) =
            ([8.0, 16.0].map(|by| left + by), [8.0, 16.0].map(|by| left - by - width));
        let over = left - width / 2.0;
        let begins = [
            right, right, before, before, over, over, right, before, right, before, over, over, far, ahead, right,
            before, right, before,
        ];
        let corners = begins.into_iter().zip(DROPS.map(|drop| top + drop));
        // One that finds no room is told by its colour and form.
        let found = corners.clone().find(clear).or_else(|| corners.clone().find(free));
        let Some((begin, middle)) = found else { continue };
        taken.push(covers(&(begin, middle)));
        names.push(Name { point, place: (begin, middle) });
    }
    names
}
