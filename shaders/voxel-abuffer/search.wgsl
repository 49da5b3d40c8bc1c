#define_import_path tracebench::voxel_search

// The search for a crossing in the part of the ray that lies in one voxel, by the image that the voxel chooses (section 3.2).

#import tracebench::image_walk::NEVER
#import tracebench::unit_space::on_image
#import tracebench::voxel_space::depth_code
#import tracebench::lanes::open
#import tracebench::voxel_store::{search, origin, direction, work, head_of, load_node, load_data, OPENED, SEARCHES, COMPARED}

// No axis, where nothing was searched just before.
const NO_AXIS: u32 = 3u;

// What a search finds: the parameter, the texel by whose layers the point there is told from those before, and their side.
var<private> found: bool;
var<private> found_side: i32;
var<private> found_t: f32;
var<private> found_axis: u32;
var<private> found_texel: vec2<u32>;
// How `halve` narrows it: from what parameter, and whether by the side of points in that texel, or in each point's own, or by so many layers
// before them.
var<private> found_halved_by: u32;
var<private> found_from: f32;
var<private> found_layers: u32;

const BY_NOTHING: u32 = 0u;
const BY_SIDE: u32 = 1u;
const BY_SIDE_IN_TEXEL: u32 = 2u;
const BY_LAYERS: u32 = 3u;

// Where the search begins, the length of a texel along the ray, and the side that the ray starts on.
var<private> start_t: f32;
var<private> texel_t: f32;
var<private> start_side: i32;
// The axis of the voxel that the ray comes from, where it was searched, and the side that the ray had on entering the voxels that
// were searched by this axis one after the other.
var<private> run_axis: u32;
var<private> run_side: i32;

// The ray over the image that is searched: texels across and down, depth.
var<private> line_origin: vec3<f32>;
var<private> line_direction: vec3<f32>;

fn take_image(axis: u32) {
    let edge = f32(search.space.image);
    let scale = vec3<f32>(edge, edge, 1.0);
    line_origin = on_image(axis, origin) * scale;
    line_direction = on_image(axis, direction) * scale;
}

fn place_at(t: f32) -> vec3<f32> {
    return line_origin + line_direction * t;
}

// Texels by which a ray is taken to go on beyond a voxel: a layer that lies on the border of two is stored in one of them, which a ray
// may leave on that border, too. Far more than f32 rounds.
const BORDER: f32 = 0.015625;

// Where a search of a voxel ends that is left at `end`.
fn place_left(t: f32, end: f32) -> vec3<f32> {
    var place = place_at(t);
    if (t >= end) {
        place.z += sign(line_direction.z) * BORDER / f32(search.space.image);
    }
    return place;
}

fn texel_at(place: vec3<f32>) -> vec2<i32> {
    return clamp(vec2<i32>(floor(place.xy)), vec2<i32>(0), vec2<i32>(i32(search.space.image) - 1));
}

#ifdef PLANES
// Across a layer's plane as the axis' image has it.
fn tilt_of(axis: u32, link: u32) -> vec3<f32> {
    return on_image(axis, bitcast<vec3<f32>>(load_data(axis, link - 1u).xyz) / search.space.scale);
}

// By how much a plane lies deeper at a place than at its texel's centre; by no more than a texel, since steep layers end before.
fn off_centre(tilt: vec3<f32>, texel: vec2<i32>, place: vec3<f32>) -> f32 {
    let edge = f32(search.space.image);
    let rise = -dot(tilt.xy, place.xy - (vec2<f32>(texel) + 0.5)) / edge;
    let most = abs(tilt.z) / edge;
    return select(clamp(rise, -most, most) / tilt.z, 0.0, (tilt.z == 0.0));
}
#endif

// Where a point is among the ordered layers of a texel: on which side of the surfaces, 0 outside, by parity 1 inside, by facings in how
// many objects (entered where a layer faces the image, left where it does not); and how many layers lie before it.
struct Before {
    side: i32,
    layers: u32,
}

fn one_more(so_far: Before, code: u32) -> Before {
    let side = select(1 - so_far.side, so_far.side + select(1, -1, ((code & 1u) == 1u)), (search.nesting == 1u));
    return Before(side, so_far.layers + 1u);
}

// Of two points, by one look at the list.
struct BeforeBoth {
    first: Before,
    second: Before,
}

fn before_both(axis: u32, texel: vec2<i32>, first: vec3<f32>, second: vec3<f32>) -> BeforeBoth {
#ifdef PLANES
    // Planes are not in the order of their layers, but off by no more than that.
    let last = depth_code(max(first.z, second.z) + 1.0 / f32(search.space.image));
#else
    let codes = vec2<u32>(depth_code(first.z), depth_code(second.z));
    let last = max(codes.x, codes.y);
#endif
    var both = BeforeBoth(Before(0, 0u), Before(0, 0u));
    var link = head_of(axis, vec2<u32>(texel));
    open += 1u;
    loop {
        if (link == 0u) {
            open -= 1u;
            break;
        }
        let node = load_node(axis, link - 1u);
        if (node.x > last) {
            open -= 1u;
            break;
        }
#ifdef PLANES
        let tilt = tilt_of(axis, link);
        let depth = bitcast<f32>(node.x);
        let is_before_first = depth + off_centre(tilt, texel, first) <= first.z;
        let is_before_second = depth + off_centre(tilt, texel, second) <= second.z;
#else
        let is_before_first = node.x <= codes.x;
        let is_before_second = node.x <= codes.y;
#endif
        if (is_before_first) {
            both.first = one_more(both.first, node.x);
        }
        if (is_before_second) {
            both.second = one_more(both.second, node.x);
        }
        link = node.y;
    }
    return both;
}

fn before(axis: u32, texel: vec2<i32>, place: vec3<f32>) -> Before {
#ifdef COUNTERS
    work[COMPARED] += 1u;
#endif
    return before_both(axis, texel, place, place).first;
}

fn side_of(axis: u32, texel: vec2<i32>, place: vec3<f32>) -> i32 {
    return before(axis, texel, place).side;
}

// On which side a point of the ray is; whoever asks has taken the axis' image.
fn side_at(axis: u32, t: f32) -> i32 {
    let place = place_at(t);
    return side_of(axis, texel_at(place), place);
}

// Ends the search where the ray crosses between two parameters, which `halve` narrows as it is told.
fn take(axis: u32, begin: f32, end: f32, texel: vec2<i32>, halved_by: u32) {
    found = true;
    found_from = begin;
    found_t = end;
    found_axis = axis;
    found_texel = vec2<u32>(texel);
    found_halved_by = halved_by;
}

// Binary search between a point on a side and one that is not (Policarpo, Oliveira, Comba 2005, which section 3.2 names), or that has
// another number of layers before it. Behind the walk, since drivers may run every branch of a loop for all lanes.
fn halve() {
    let steps = select(search.binary_steps, 0u, (!found || open > 0u || found_halved_by == BY_NOTHING));
    var step = 0u;
    open += 1u;
    loop {
        if (step >= steps) {
            open -= 1u;
            break;
        }
        let middle = 0.5 * (found_from + found_t);
        let place = place_at(middle);
        let texel = select(vec2<i32>(found_texel), texel_at(place), found_halved_by == BY_SIDE);
        let there = before(found_axis, texel, place);
        if (select(there.side != found_side, there.layers != found_layers, found_halved_by == BY_LAYERS)) {
            found_t = middle;
            found_texel = vec2<u32>(texel);
        } else {
            found_from = middle;
        }
        step += 1u;
    }
}

// Whether the ray meets a surface in a texel, from where it enters it to where it leaves: it is on another side there, or passes a layer.
fn meets_in_texel(axis: u32, texel: vec2<i32>, begin: f32, exit: f32, end: f32, side: i32) -> bool {
    let at_exits = search.at_exits == 1u;
#ifdef COUNTERS
    work[COMPARED] += select(2u, 1u, at_exits);
#endif
    let left = place_left(exit, end);
    let both = before_both(axis, texel, select(place_at(begin), left, at_exits), left);
    found_layers = both.first.layers;
    if (both.first.side != side) {
        take(axis, begin, select(begin, exit, at_exits), texel, select(BY_NOTHING, BY_SIDE_IN_TEXEL, at_exits));
    } else if (both.first.layers != both.second.layers) {
        take(axis, begin, exit, texel, BY_LAYERS);
    }
    return found;
}

// 2D-DDA: every texel that the ray crosses.
fn walk_image(axis: u32, begin: f32, end: f32, side: i32) {
    let last = vec2<i32>(i32(search.space.image) - 1);
    let heading = vec2<i32>(sign(line_direction.xy));
    let still = heading == vec2<i32>(0);
    let slope = select(line_direction.xy, vec2<f32>(1.0), still);
    var texel = texel_at(place_at(begin));
    var t = begin;
    open += 1u;
    loop {
        let borders = vec2<f32>(texel + max(heading, vec2<i32>(0)));
        let leaves = select((borders - line_origin.xy) / slope, vec2<f32>(NEVER), still);
        let exit = clamp(min(leaves.x, leaves.y), t, end);
        if (meets_in_texel(axis, texel, t, exit, end, side)) {
            open -= 1u;
            break;
        }
        if (leaves.x <= leaves.y) {
            texel.x += heading.x;
        } else {
            texel.y += heading.y;
        }
        if (exit >= end || any(texel < vec2<i32>(0)) || any(texel > last)) {
            open -= 1u;
            break;
        }
        t = exit;
    }
}

// So many points, the last where the ray leaves the voxel.
fn look_at_points(axis: u32, begin: f32, end: f32, side: i32) {
    var t = begin;
    var step = 0u;
    open += 1u;
    loop {
        step += 1u;
        let next = select(begin + (end - begin) * (f32(step) / f32(search.points)), end, (step == search.points));
        let place = place_left(next, end);
        let texel = texel_at(place);
        if (side_of(axis, texel, place) != side) {
            take(axis, t, next, texel, BY_SIDE);
            open -= 1u;
            break;
        }
        if (step >= search.points) {
            open -= 1u;
            break;
        }
        t = next;
    }
}

// Searches a voxel, in which the ray is between two parameters.
fn search_voxel(axis: u32, begin: f32, end: f32) {
#ifdef COUNTERS
    work[OPENED] += 1u;
#endif
    take_image(axis);
    var side = start_side;
    // Voxels that are searched by one axis one after the other are one stretch of the ray: where the border of voxels is one of texels,
    // too, the step from one texel's layers to the next one's lies on it.
    let goes_on = search.by_change == 1u && axis == run_axis;
    if (search.by_change == 1u) {
        if (!goes_on) {
            // A texel before the entry: a layer's depth is that of its texel's centre, which may lie in the next voxel.
            run_side = side_at(axis, max(begin - texel_t, start_t));
        }
        side = run_side;
    }
    found_side = side;
    if (!goes_on) {
        let texel = texel_at(place_at(begin));
        if (side_of(axis, texel, place_at(begin)) != side) {
            take(axis, begin, begin, texel, BY_NOTHING);
            return;
        }
    }
    run_axis = axis;
#ifdef COUNTERS
    work[SEARCHES] += 1u;
#endif
    if (search.points == 0u) {
        walk_image(axis, begin, end, side);
    } else {
        look_at_points(axis, begin, end, side);
    }
}
