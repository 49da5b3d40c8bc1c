#define_import_path tracebench::quadtree_walk

// The walk of a ray through one quad-tree (WKP15, section 4): planes and boxes are tested in the unit cube; of a box that is hit the
// child follows in which the ray meets it; of a node that is missed the next of its level on the ray's way, from the level below the
// last ancestor that both have in common.

#import tracebench::quadtree_forest::{DILATE_NONE, levels_apart, z_of_pixels}
#import tracebench::quadtree_node::{Plane, NOTHING, SIDES, end_of, is_plane, is_empty, plane_of, box_of, z_on}
#import tracebench::quadtree_proxy::is_dilated
#import tracebench::quadtree_track::{NOWHERE, Track, Bounds, pixels_at, z_along, bounds_of, leaves_at, enters_at, places_of, part_near, crossing, crossings, cell_at, child_at, successor}
#import tracebench::lanes::open
#import tracebench::quadtree_store::{forest, search, capped, steps, work, visit, pixel_node, neighbour_node, is_joined}
#import tracebench::quadtree_patches::step_across

// Whether nodes on the way down are kept on a stack.
override STACK: bool;

// How far before an occlusion volume the pixel is looked at that an inpainted hit shows, pixels ("slightly dilated", section 4.1).
const INPAINT_PIXELS: f32 = 0.5;

// How far apart the end of one node and the beginning of the next may be rounded, pixels.
const SIDE_SLACK: f32 = 0.01;

// Share of z by which boxes are held to be larger than they are: z along a ray is rounded otherwise than z of planes.
const BOX_SLACK: f32 = 2e-6;

// So many times the reach of planes a walk begins before where a box is met: places are rounded.
const REACH_SLACK: f32 = 1.001;

// What a walk found.
struct Found {
    // The place of a hit, and z there; NOWHERE for none.
    place: f32,
    z: f32,
    // The pixel that shows what was hit.
    pixel: vec2<u32>,
    // The first place at which the ray lies in an occlusion volume; NOWHERE for none.
    volume: f32,
    // Whether the hit is one with an occlusion volume, and whether the walk ended there, with a hit or without.
    inpainted: bool,
    stopped: bool,
    // The plane that was hit, and its node's middle, pixels.
    plane: Plane,
    middle: vec2<f32>,
}

var<private> found: Found;
var<private> track: Track;
// Places between which the tree is walked.
var<private> begin: f32;
var<private> end: f32;
// Where the ray comes into the image, of which views are a little wider. A walk begins there, and ends where the ray leaves the image: else
// it would hang on the size of cells which of those along a side are met before the ray is in them, or behind.
var<private> inside_from: f32;
// Where the ray left the node before, if it was before the plane there by no more than it must be behind one to lie in its
// occlusion volume; NOT_BEFORE for all else.
var<private> before_until: f32;
const NOT_BEFORE: f32 = -1.0;
// How holes are inpainted: not at all, just before occlusion volumes, or on the planes of the pixels there.
var<private> inpaints: u32;
const INPAINT_NEVER: u32 = 0u;
const INPAINT_AT_PLANES: u32 = 2u;

// By how much a plane lies before the ray, in z: above 0 the ray is behind it.
fn behind_by(plane: Plane, middle: vec2<f32>, place: f32) -> f32 {
    return z_on(plane, pixels_at(track, place) - middle) - z_along(track, place);
}

// How far behind a plane the ray must be to lie in its occlusion volume.
fn tolerance_at(place: f32) -> f32 {
    return z_of_pixels(forest, z_along(track, place), search.occlusion_bias);
}

fn take(place: f32, plane: Plane, middle: vec2<f32>, bounds: Bounds) {
    let at = pixels_at(track, place);
    found.place = place;
    // By the plane: along a ray from near to far, places are too coarse for the depth of what is far.
    found.z = clamp(z_on(plane, at - middle), 0.0, 1.0);
    let last = vec2<f32>(forest.size) - 1.0;
    found.pixel = vec2<u32>(clamp(floor(at), bounds.low, min(bounds.high - 1.0, last)));
    found.plane = plane;
    found.middle = middle;
}

// The ray lies in a node's occlusion volume from a place on (section 4.1). Where holes are inpainted, it ends there.
fn pass_volume(place: f32) {
    if (found.volume == NOWHERE) {
        found.volume = place;
    }
    found.stopped = inpaints != INPAINT_NEVER;
}

// Ends a walk that stopped at an occlusion volume with a hit on what the image shows just before, if it shows something: there, or
// farther on where the ray gets behind that pixel's plane.
fn inpaint(image: u32) {
    let place = found.volume;
    let before = part_near(track, INPAINT_PIXELS, vec2<f32>(place), begin, end).x;
    // What begins behind a surface has come from nowhere that the image shows.
    if (place <= inside_from || before >= place) {
        return;
    }
    let last = vec2<f32>(forest.size) - 1.0;
    let pixel = clamp(floor(pixels_at(track, before)), vec2<f32>(0.0), last);
    let words = pixel_node(image, vec2<u32>(pixel));
    if (is_empty(words)) {
        return;
    }
    found.place = before;
    if (inpaints == INPAINT_AT_PLANES) {
        let plane = plane_of(words, last + 1.0);
        let middle = pixel + 0.5;
        let passes = crossings(before, 1.0, vec2<f32>(behind_by(plane, middle, before)), vec2<f32>(behind_by(plane, middle, 1.0)));
        found.place = select(before, passes.x, passes.x <= 1.0);
    }
    found.z = z_along(track, found.place);
    found.pixel = vec2<u32>(pixel);
    found.inpainted = true;
}

// A node's plane with the one beside it at which it ends, else itself, each with its middle. What is shown lies behind both.
struct Pair {
    own: Plane,
    middle: vec2<f32>,
    other: Plane,
    other_middle: vec2<f32>,
}

fn both_behind(pair: Pair, place: f32) -> vec2<f32> {
    return vec2<f32>(behind_by(pair.own, pair.middle, place), behind_by(pair.other, pair.other_middle, place));
}

fn take_of(pair: Pair, is_other: bool, place: f32, bounds: Bounds) {
    if (is_other) {
        let beside = pair.other_middle - pair.middle;
        take(place, pair.other, pair.other_middle, Bounds(bounds.low + beside, bounds.high + beside));
    } else {
        take(place, pair.own, pair.middle, bounds);
    }
}

// Tests a plane, and one at which it ends, on the ray's way through its node. What is found does not hang on how the walk came there.
fn test_plane(image: u32, words: vec2<u32>, cell: vec2<i32>, bounds: Bounds) {
    let size = vec2<f32>(forest.size);
    let own = plane_of(words, size);
    let middle = 0.5 * (bounds.low + bounds.high);
    var pair = Pair(own, middle, own, middle);
    var ends = false;
    if (is_joined()) {
        let side = end_of(words);
        ends = side < SIDES;
        if (ends) {
            let step = step_across(side);
            pair.other = plane_of(neighbour_node(image, cell + step), size);
            pair.other_middle = middle + vec2<f32>(step);
        }
    }
    let entry = min(enters_at(track, bounds, begin), end);
    let leaves = leaves_at(track, bounds, entry);
    let exit = min(min(leaves.x, leaves.y), end);
    let entries = both_behind(pair, entry);
    let exits = both_behind(pair, exit);
    let at_entry = min(entries.x, entries.y);
    let at_exit = min(exits.x, exits.y);
    let tolerance = tolerance_at(entry);
    let was_before = entry <= before_until + places_of(track, SIDE_SLACK);
    before_until = select(NOT_BEFORE, exit, (at_exit <= 0.0 && at_exit >= -tolerance_at(exit)));
    var part = vec2<f32>(entry, exit);
    if (is_dilated(forest, own.flagged) && !ends) {
        part = part_near(track, forest.dilation, part, begin, end);
    }
    let at_begin = select(behind_by(own, middle, part.x), at_entry, ends);
    if (at_entry > 0.0 && at_entry <= tolerance) {
        // Not surely behind: through a crack, on the surface that the ray starts on, or on the way out of a volume.
        if (at_begin <= 0.0) {
            take_of(pair, false, crossing(part.x, entry, at_begin, at_entry), bounds);
        } else if (was_before && at_exit > at_entry) {
            take_of(pair, entries.y < entries.x, entry, bounds);
        } else if (found.volume < entry && at_exit < 0.0) {
            let out = crossings(entry, exit, entries, exits);
            take_of(pair, out.y < out.x, min(out.x, out.y), bounds);
        }
        return;
    }
    let lasts = select(vec2<f32>(behind_by(own, middle, part.y)), exits, vec2<bool>(ends));
    let met = crossings(entry, part.y, entries, lasts);
    if (at_entry <= 0.0) {
        // Behind both from the later of where it gets behind either on, if it is before neither again by then.
        let inside = entries > vec2<f32>(0.0);
        let enters = select(met, vec2<f32>(-1.0), inside);
        let out = select(vec2<f32>(NOWHERE), met, inside);
        let place = max(enters.x, enters.y);
        if (place < min(out.x, out.y)) {
            take_of(pair, enters.y > enters.x, place, bounds);
        } else if (!ends && found.volume < entry && at_entry >= -tolerance && at_begin > 0.0) {
            // Out of a volume, through a crack.
            take_of(pair, false, crossing(part.x, entry, at_begin, at_entry), bounds);
        }
        return;
    }
    pass_volume(entry);
    // Out of the volume, through the plane from behind.
    if (!found.stopped && min(lasts.x, lasts.y) < 0.0) {
        take_of(pair, met.y < met.x, min(met.x, met.y), bounds);
    }
}

// Where on its way through a node the ray must be looked at more closely; NOWHERE where it meets nothing in a box.
fn test_box(words: vec2<u32>, place: f32, exit: f32) -> f32 {
    if (is_empty(words)) {
        return NOWHERE;
    }
    let box = box_of(words);
    let reach = select(forest.dilation, 0.0, (forest.dilated == DILATE_NONE));
    let part = part_near(track, reach, vec2<f32>(place, exit), begin, end);
    let ends = vec2<f32>(z_along(track, part.x), z_along(track, part.y));
    // What the ray passes by less than tolerance_at is looked at.
    let share = 1.0 - search.occlusion_bias * forest.pixel_angle;
    let closest = box.greatest + BOX_SLACK * (box.greatest + forest.z_shift)
        + z_of_pixels(forest, box.greatest, search.occlusion_bias) / max(share, 1e-3);
    let greatest = select(1e30, closest, share > 1e-3);
    if (min(ends.x, ends.y) > greatest) {
        return NOWHERE;
    }
    let tolerance = z_of_pixels(forest, box.least, search.occlusion_bias) + BOX_SLACK * (box.least + forest.z_shift);
    if (max(ends.x, ends.y) < box.least - tolerance) {
        if (box.holes && found.volume == NOWHERE) {
            return place;
        }
        if (!box.holes) {
            pass_volume(place);
        }
        return NOWHERE;
    }
    let here = z_along(track, place);
    if (min(ends.x, here) <= greatest) {
        return place;
    }
    // From before: where it gets as deep as the box begins, or where it leaves a plane that reaches there.
    let there = z_along(track, exit);
    var met = exit;
    if (there < greatest) {
        met = crossing(place, exit, greatest - here, greatest - there);
    }
    return max(place, met - places_of(track, REACH_SLACK * reach));
}

// The node where the walk is, the place from which it looks at it, and where it leaves the image or what it found.
var<private> level: u32;
var<private> cell: vec2<i32>;
var<private> place: f32;
var<private> outside_from: f32;
// The cells of all levels on the way down to where the walk is, if they are kept.
var<private> path: array<vec2<i32>, 16>;

// Goes on behind a node that the ray leaves at these places, at first at `exit`; false where the walk is over.
fn goes_on(leaves: vec2<f32>, exit: f32) -> bool {
    // Beyond its node a plane is met where another one may lie before it, near a discontinuity.
    let is_beyond = found.place > exit && found.plane.flagged;
    if (found.stopped || (found.place <= end && !is_beyond)) {
        return false;
    }
    end = min(end, found.place);
    outside_from = min(outside_from, end);
    var next = successor(track, leaves, cell);
    let last = (vec2<i32>(forest.size) - 1) >> vec2<u32>(level);
    if (exit >= outside_from || any(next < vec2<i32>(0)) || any(next > last)) {
        return false;
    }
    place = exit;
    if (STACK) {
        // Nodes are taken from the stack up to the first that holds the successor.
        open += 1u;
        loop {
            let above = min(level + 1u, forest.top);
            if (level >= forest.top || all(path[above] == next >> vec2<u32>(1u))) {
                open -= 1u;
                break;
            }
            next = next >> vec2<u32>(1u);
            level += 1u;
        }
    } else {
        let up = min(levels_apart(vec2<u32>(cell), vec2<u32>(next)), forest.top - level);
        next = next >> vec2<u32>(up);
        level += up;
    }
    cell = next;
    return true;
}

// Walks the tree of an image between two places, and leaves in `found` what it found; `holes` says how it inpaints. Planes are
// tested, and holes inpainted, outside of the loop over boxes: drivers may run every branch of a loop for all lanes.
fn walk_tree(image: u32, first: f32, limit: f32, holes: u32) {
    inpaints = holes;
    found.place = NOWHERE;
    found.volume = NOWHERE;
    found.inpainted = false;
    found.stopped = false;
    before_until = NOT_BEFORE;
    begin = first;
    end = limit;
    let whole = Bounds(vec2<f32>(0.0), vec2<f32>(forest.size));
    inside_from = min(enters_at(track, whole, first), end);
    let out = leaves_at(track, whole, inside_from);
    outside_from = min(min(out.x, out.y), end);
    let last = vec2<i32>(forest.size) - 1;
    place = inside_from;
    level = forest.top;
    cell = cell_at(track, place, 0u, last);
    if (search.from_ancestor == 1u) {
        // The child of the last ancestor that the ray's both ends have in common.
        let other = cell_at(track, outside_from, 0u, last);
        level = min(select(levels_apart(vec2<u32>(cell), vec2<u32>(other)), 0u, all(cell == other)), level);
    }
    cell = cell >> vec2<u32>(level);
    open += 1u;
    loop {
        var words = NOTHING;
        var bounds = Bounds();
        var leaves = vec2<f32>(0.0);
        var exit = 0.0;
        // To the next plane.
        loop {
            if (steps >= search.max_steps) {
                capped = true;
                open -= 1u;
                break;
            }
            steps += 1u;
            if (STACK) {
                path[level] = cell;
            }
            bounds = bounds_of(cell, level);
            leaves = leaves_at(track, bounds, place);
            exit = min(min(leaves.x, leaves.y), end);
            var down = NOWHERE;
            // Of cells that are touched at a corner alone it hangs on the way of the walk which are met.
            if (exit > place && place < outside_from) {
                words = visit(image, level, vec2<u32>(cell));
                if (is_plane(words)) {
                    break;
                }
#ifdef COUNTERS
                work[2] += 1u;
#endif
                down = test_box(words, place, exit);
                if (down != place) {
                    before_until = NOT_BEFORE;
                }
            }
            if (down <= end && level > 0u) {
                place = max(place, down);
                cell = child_at(track, place, cell, level, last >> vec2<u32>(level - 1u));
                level -= 1u;
                continue;
            }
            if (!goes_on(leaves, exit)) {
                open -= 1u;
                break;
            }
        }
        if (!is_plane(words)) {
            break;
        }
#ifdef COUNTERS
        work[1] += 1u;
#endif
        test_plane(image, words, cell, bounds);
        if (!goes_on(leaves, exit)) {
            open -= 1u;
            break;
        }
    }
    if (found.stopped) {
        inpaint(image);
    }
}
