//! Names beside the points of a front.

use itertools::Itertools as _;

use super::{ARROW, NAME_SIZE, ON_FRONT, Placed, Places, Point};
use crate::report::chart::canvas::text_width;
use crate::report::chart::frame::Rect;
use crate::report::chart::panel::Panel;
use crate::studies::pareto::FrontStatus;

/// Height of a line of names.
const NAME_LINE: f64 = 12.0;
/// A line from a place to another.
type Way = [(f64, f64); 2];

/// A point's name.
#[derive(Debug)]
pub(in crate::report) struct Name<'a> {
    pub point: &'a Point,
    /// Where it begins, and its middle.
    pub place: (f64, f64),
    /// The line from the point to it if that is longer than a line of names is high.
    pub leader: Places,
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

/// Whether a way goes through a box in which it does not begin.
fn crosses([from, to]: &Way, of: &[f64; 4]) -> bool {
    let at = |part: f64| [from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part];
    let within = |[x, y]: [f64; 2]| x > of[0] && x < of[1] && y > of[2] && y < of[3];
    !within(at(0.0)) && (1..16).any(|part| within(at(f64::from(part) / 16.0)))
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
    let (mut taken, mut names): (Vec<([f64; 4], Way)>, _) = (Vec::new(), Vec::new());
    let is_named: Vec<&str> = on.iter().map(|placed| &*placed.point.tracer).collect();
    let best = behind.into_iter().filter(|Placed { point, .. }| point.is_best && !is_named.contains(&&*point.tracer));
    for Placed { point, place, .. } in on.into_iter().chain(best) {
        let width = text_width(&point.name, NAME_SIZE);
        // Where it begins and has its middle, what it covers, and the way to it, which ends a little before it.
        let spot = |(begin, middle): (f64, f64)| {
            let own = [begin, begin + width, middle - NAME_LINE / 2.0, middle + NAME_LINE / 2.0];
            let to = (place.0.clamp(begin - 3.0, begin + width + 3.0), place.1.clamp(own[2] + 2.0, own[3] - 2.0));
            ((begin, middle), own, [*place, to])
        };
        let length = |[from, to]: &Way| (to.0 - from.0).hypot(to.1 - from.1);
        let begins = [8.0, 28.0, 64.0].into_iter().flat_map(|by| [place.0 + by, place.0 - by - width]);
        let drops = (0..24).map(|step| 7.0 * f64::from(step));
        let spots = begins.cartesian_product(drops.flat_map(|by| [place.1 - by, place.1 + by])).map(spot);
        let spots = spots.sorted_by(|a, b| length(&a.2).total_cmp(&length(&b.2))).collect_vec();
        let free = |(_, own, way): &&(_, [f64; 4], Way)| {
            let inside = own[0] >= rect.left + 2.0 && own[1] <= rect.right - 2.0;
            let inside = inside && own[2] >= rect.top + 2.0 && own[3] <= rect.bottom - 2.0;
            inside && !taken.iter().any(|(name, led)| meet(own, name) || crosses(led, own) || crosses(way, name))
        };
        let bare = |spot: &&_| free(spot) && !drawn.iter().any(|other| meet(&spot.1, other));
        let clear = |spot: &&_| bare(spot) && !drawn[..points.len()].iter().any(|other| crosses(&spot.2, other));
        // One that finds no room is told by its colour and form.
        let found = spots.iter().find(clear).or_else(|| spots.iter().find(bare)).or_else(|| spots.iter().find(free));
        let Some((corner, own, way)) = found.copied() else { continue };
        taken.push((own, way));
        let leader = way.into_iter().filter(|_| length(&way) > NAME_LINE).collect();
        names.push(Name { point, place: corner, leader });
    }
    names
}
