#define_import_path tracebench::quadtree_track

// A ray's way over an image, in the unit cube with x and y in pixels: a straight line from place 0 to place 1, along which x, y and z
// are linear. And how a walk over cells of any level goes along it. It never steps back, whatever rounding does.

#import tracebench::view::View
#import tracebench::image_walk::{EyeRay, NEVER, Span}
#import tracebench::image_line::{ImageLine, image_line, between}
#import tracebench::quadtree_forest::{Forest, z_of_depth}

// What no place is: behind the end.
const NOWHERE: f32 = 2.0;

struct Track {
    line: ImageLine,
    // z at both ends.
    zs: vec2<f32>,
    // Places a pixel, 0 along an axis on which the ray does not move.
    pace: vec2<f32>,
    // -1, 0 or 1 along x and y.
    heading: vec2<i32>,
}

// The span lies in the view.
fn track_of(forest: Forest, view: View, ray: EyeRay, span: Span) -> Track {
    let line = image_line(view, ray, span);
    let way = line.end - line.begin;
    let heading = vec2<i32>(sign(way));
    let pace = select(vec2<f32>(0.0), 1.0 / way, (heading != vec2<i32>(0)));
    let zs = vec2<f32>(z_of_depth(forest, 1.0 / line.inverse_depths.x), z_of_depth(forest, 1.0 / line.inverse_depths.y));
    return Track(line, zs, pace, heading);
}

fn pixels_at(track: Track, place: f32) -> vec2<f32> {
    return track.line.begin * (1.0 - place) + track.line.end * place;
}

fn z_along(track: Track, place: f32) -> f32 {
    return between(track.zs, place);
}

// A cell in pixels.
struct Bounds {
    low: vec2<f32>,
    high: vec2<f32>,
}

fn bounds_of(cell: vec2<i32>, level: u32) -> Bounds {
    return Bounds(vec2<f32>(cell << vec2<u32>(level)), vec2<f32>((cell + 1) << vec2<u32>(level)));
}

// The places, not before `now`, at which the ray leaves a cell across its upright and its level side; NEVER where it does not.
fn leaves_at(track: Track, bounds: Bounds, now: f32) -> vec2<f32> {
    let sides = select(bounds.low, bounds.high, (track.heading > vec2<i32>(0)));
    let at = max((sides - track.line.begin) * track.pace, vec2<f32>(now));
    return select(vec2<f32>(NEVER), at, (track.heading != vec2<i32>(0)));
}

// The place, not before `first`, at which the ray enters a cell that it crosses.
fn enters_at(track: Track, bounds: Bounds, first: f32) -> f32 {
    let sides = select(bounds.high, bounds.low, (track.heading > vec2<i32>(0)));
    let at = select(vec2<f32>(first), (sides - track.line.begin) * track.pace, (track.heading != vec2<i32>(0)));
    return max(first, max(at.x, at.y));
}

// So many pixels as places, along the axis on which the ray moves most.
fn places_of(track: Track, pixels: f32) -> f32 {
    return pixels / max(track.line.major, 1e-6);
}

// The part of the way, between two places, from so many pixels before a cell that it crosses, between the places that are given, to
// as many behind it.
fn part_near(track: Track, reach: f32, crossed: vec2<f32>, first: f32, last: f32) -> vec2<f32> {
    let beyond = places_of(track, reach);
    return vec2<f32>(max(first, crossed.x - beyond), min(last, crossed.y + beyond));
}

// The place between two at which the ray, behind by so much at both, passes the plane.
fn crossing(first: f32, second: f32, at_first: f32, at_second: f32) -> f32 {
    let share = clamp(at_first / (at_first - at_second), 0.0, 1.0);
    return first * (1.0 - share) + second * share;
}

// The places between two at which the ray, behind two planes by so much at both, passes each; NOWHERE for one that it does not pass.
fn crossings(first: f32, second: f32, at_first: vec2<f32>, at_second: vec2<f32>) -> vec2<f32> {
    let places = vec2<f32>(
        crossing(first, second, at_first.x, at_second.x), crossing(first, second, at_first.y, at_second.y),
    );
    let passes = (at_first > vec2<f32>(0.0)) != (at_second > vec2<f32>(0.0));
    return select(vec2<f32>(NOWHERE), places, passes);
}

// Rays may run along a border between cells, where what a place is rounded to in pixels says nothing of which side they are on. Which
// cell a ray is in is told by the places at which it crosses borders, and by nothing else.

// The cell of a level, up to the last one, that the ray is in at a place.
fn cell_at(track: Track, place: f32, level: u32, last: vec2<i32>) -> vec2<i32> {
    let at = select(pixels_at(track, place), track.line.begin, (track.heading == vec2<i32>(0)));
    let cell = clamp(vec2<i32>(floor(at)) >> vec2<u32>(level), vec2<i32>(0), last);
    let bounds = bounds_of(cell, level);
    let sides = select(bounds.high, bounds.low, (track.heading > vec2<i32>(0)));
    let is_ahead = (sides - track.line.begin) * track.pace > vec2<f32>(place);
    return clamp(cell - select(vec2<i32>(0), track.heading, is_ahead), vec2<i32>(0), last);
}

// The one of the four cells below a cell that the ray is in at a place; the last of their level is given.
fn child_at(track: Track, place: f32, cell: vec2<i32>, level: u32, last: vec2<i32>) -> vec2<i32> {
    let middle = vec2<f32>((2 * cell + 1) << vec2<u32>(level - 1u));
    let passed_at = (middle - track.line.begin) * track.pace;
    let moving = select(vec2<f32>(place) < passed_at, vec2<f32>(place) >= passed_at, (track.heading > vec2<i32>(0)));
    let is_upper = select(moving, track.line.begin >= middle, (track.heading == vec2<i32>(0)));
    return min(2 * cell + select(vec2<i32>(0), vec2<i32>(1), is_upper), last);
}

// The next cell of the same level on the way, of one that the ray leaves at these places: across the nearer of its two sides (the upright
// one of both at once). Outside of the image where the ray leaves that.
fn successor(track: Track, leaves: vec2<f32>, cell: vec2<i32>) -> vec2<i32> {
    if (leaves.x <= leaves.y) {
        return cell + vec2<i32>(track.heading.x, 0);
    }
    return cell + vec2<i32>(0, track.heading.y);
}
