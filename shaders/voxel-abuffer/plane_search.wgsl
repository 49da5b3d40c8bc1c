#define_import_path tracebench::voxel_plane_search

// The search where fragments are oriented planes: a ray goes through the grid voxel by voxel, in each over every image that shows
// anything there, and is met by a fragment where it goes through the fragment's plane within the fragment's part of its texel. The
// nearest of all that are met is the hit; nothing is told inside from outside.

#import tracebench::types::{Ray, Surface, SURFACE_WRITTEN}
#import tracebench::image_walk::{NEVER, Span}
#import tracebench::unit_space::{on_image, from_image, voxel_at}
#import tracebench::voxel_walk::{leaves_voxel, next_voxel, is_in_grid}
#import tracebench::lanes::open
#import tracebench::voxel_store::{search, begin_ray, ray, origin, direction, work, code_of, head_of, load_node, load_data, STEPPED, OPENED, SEARCHES, COMPARED}
#import tracebench::voxel_plane_parts::{lies_in_part, place_slack}
#import tracebench::surface::max_of

// What is found: the ray's parameter, and of the fragment its axis, data, and 1 where its normal points along the axis.
var<private> found: bool;
var<private> found_t: f32;
var<private> found_axis: u32;
var<private> found_data: vec4<u32>;
var<private> found_facing: u32;

// The parameter at which `origin` lies on the ray: where it enters the cube, if it starts outside. Places are then no larger than the
// cube, however far away the ray comes from, and parameters here count from there.
var<private> first_t: f32;

// What the ray's own ends leave of it.
var<private> ends: Span;

// The ray over the image that is searched: texels across, down and along.
var<private> line_origin: vec3<f32>;
var<private> line_direction: vec3<f32>;

fn is_before(t: f32, data: vec4<u32>, facing: u32) -> bool {
    if (!found || t != found_t) {
        return !found || t < found_t;
    }
    // Of what lies at the same place one is the hit, whatever order it was stored in.
    if (data.w != found_data.w) {
        return data.w < found_data.w;
    }
    if (data.x != found_data.x) {
        return data.x < found_data.x;
    }
    return facing < found_facing;
}

// What lies behind the last node of a list: farther than any.
const NO_NODE: vec2<u32> = vec2<u32>(0xffffffffu, 0u);

// Tests a fragment against the ray, which is at `entry` at parameter t, relative to the texel's low corner.
fn meet(axis: u32, node: u32, code: u32, t: f32, entry: vec3<f32>) {
    let data = load_data(axis, node);
#ifdef COUNTERS
    work[COMPARED] += 1u;
#endif
    let slopes = unpack2x16snorm(data.x);
    let depth = bitcast<f32>(code) * f32(search.space.image);
    // How far behind the plane the ray is, and how fast it gets there.
    let behind = entry.z - depth - dot(slopes, entry.xy - 0.5);
    let speed = line_direction.z - dot(slopes, line_direction.xy);
    if (speed == 0.0) {
        return;
    }
    let further = -behind / speed;
    let at = t + further;
    let place = entry.xy + line_direction.xy * further;
    if (at >= ends.begin && at <= ends.end && lies_in_part(data.xyz, place, place_slack(search.space.image))
        && is_before(at, data, code & 1u)) {
        found = true;
        found_t = at;
        found_axis = axis;
        found_data = data;
        found_facing = code & 1u;
    }
}

// The texel where the search of an image is: where the ray leaves it, the ray where it enters it, relative to the low corner, the codes of
// depths between which fragments may be met, and the next one.
var<private> texel: vec2<i32>;
var<private> leaves: vec2<f32>;
var<private> exit: f32;
var<private> entry: vec3<f32>;
var<private> nearest: u32;
var<private> farthest: u32;
var<private> link: u32;

fn enter_texel(axis: u32, begin: f32, end: f32, heading: vec2<i32>) {
    let still = heading == vec2<i32>(0);
    let slope = select(line_direction.xy, vec2<f32>(1.0), still);
    let borders = vec2<f32>(texel + max(heading, vec2<i32>(0)));
    leaves = select((borders - line_origin.xy) / slope, vec2<f32>(NEVER), still);
    exit = clamp(min(leaves.x, leaves.y), begin, end);
    let place = line_origin + line_direction * begin;
    let left = place.z + line_direction.z * (exit - begin);
    let edge = f32(search.space.image);
    // A plane is no more than half a texel by either slope off from where it is at the texel's centre, and is asked for a little beyond.
    nearest = bitcast<u32>(max((min(place.z, left) - 1.125) / edge, 0.0));
    farthest = bitcast<u32>(max((max(place.z, left) + 1.125) / edge, 0.0));
    entry = vec3<f32>(place.xy - vec2<f32>(texel), place.z);
    link = head_of(axis, vec2<u32>(texel));
}

// Every texel of an image that the ray crosses between two parameters, up to where it is met.
fn search_image(axis: u32, begin: f32, end: f32) {
#ifdef COUNTERS
    work[SEARCHES] += 1u;
#endif
    let edge = f32(search.space.image);
    line_origin = on_image(axis, origin) * edge;
    line_direction = on_image(axis, direction) * edge;
    let last = vec2<i32>(i32(search.space.image) - 1);
    let heading = vec2<i32>(sign(line_direction.xy));
    texel = clamp(vec2<i32>(floor(line_origin.xy + line_direction.xy * begin)), vec2<i32>(0), last);
    var t = begin;
    enter_texel(axis, t, end, heading);
    open += 1u;
    loop {
        var node = NO_NODE;
        var may_meet = false;
        // To the next fragment that may be met, which is tested outside.
        loop {
            open += 1u;
            loop {
                node = NO_NODE;
                if (link != 0u) {
                    node = load_node(axis, link - 1u);
                }
                if (node.x >= nearest) {
                    open -= 1u;
                    break;
                }
                link = node.y;
            }
            may_meet = node.x >= nearest && node.x <= farthest;
            if (may_meet) {
                break;
            }
            if (leaves.x <= leaves.y) {
                texel.x += heading.x;
            } else {
                texel.y += heading.y;
            }
            if (exit >= end || (found && found_t <= exit) || any(texel < vec2<i32>(0)) || any(texel > last)) {
                open -= 1u;
                break;
            }
            t = exit;
            enter_texel(axis, t, end, heading);
        }
        if (!may_meet) {
            break;
        }
        meet(axis, link - 1u, node.x, t, entry);
        link = node.y;
    }
}

// Every image that shows anything of a voxel.
fn search_voxel(axes: u32, begin: f32, end: f32) {
#ifdef COUNTERS
    work[OPENED] += 1u;
#endif
    var others = axes;
    open += 1u;
    loop {
        if (others == 0u) {
            open -= 1u;
            break;
        }
        search_image(firstTrailingBit(others), begin, end);
        others &= others - 1u;
    }
}

fn find_hit(given: Ray) {
    found = false;
    let space = search.space;
    var span = begin_ray(given);
    if (!(span.begin <= span.end)) {
        return;
    }
    first_t = 0.0;
    if (span.begin > ray.t_min) {
        first_t = span.begin;
        origin += direction * first_t;
        span = Span(0.0, span.end - first_t);
    } else {
        span.begin += search.start_bias / (f32(space.image) * length(direction));
        if (!(span.begin <= span.end)) {
            return;
        }
    }
    ends = Span(span.begin, ray.t_max - first_t);
    let edge = f32(space.grid);
    let heading = vec3<i32>(sign(direction));
    var voxel = voxel_at(space, origin + direction * span.begin);
    var t = span.begin;
    open += 1u;
    loop {
        var leaves = vec3<f32>(0.0);
        var exit = t;
        var axes = 0u;
        // To the next voxel that has anything, which is searched outside: drivers may run every branch of a loop for all lanes.
        loop {
            if (!is_in_grid(voxel, space.grid)) {
                open -= 1u;
                break;
            }
#ifdef COUNTERS
            work[STEPPED] += 1u;
#endif
            leaves = leaves_voxel(origin, direction, heading, voxel, edge);
            exit = clamp(min(leaves.x, min(leaves.y, leaves.z)), t, span.end);
            axes = code_of(voxel);
            if (axes != 0u) {
                break;
            }
            if (exit >= span.end || (found && found_t <= exit)) {
                open -= 1u;
                break;
            }
            voxel = next_voxel(voxel, heading, leaves);
            t = exit;
        }
        if (axes == 0u) {
            break;
        }
        search_voxel(axes, t, exit);
        // What is met beyond the voxel may lie behind what the next one has. Any hit is as good as the nearest where one is asked for.
        if (exit >= span.end || (found && (found_t <= exit || search.any_hit == 1u))) {
            open -= 1u;
            break;
        }
        voxel = next_voxel(voxel, heading, leaves);
        t = exit;
    }
    found_t = clamp(found_t + first_t, ray.t_min, ray.t_max);
}

// The fragment that was met has it all.
fn surface_of_hit() -> Surface {
    let slopes = unpack2x16snorm(found_data.x);
    let across = vec3<f32>(-slopes, 1.0) * select(-1.0, 1.0, found_facing == 1u);
    // Of the plane in the scene, not in the cube.
    let scaled = from_image(found_axis, across) * search.space.scale;
    let normal = normalize(scaled / max_of(scaled));
    return Surface(ray.origin + ray.direction * found_t, found_data.w, normal, SURFACE_WRITTEN);
}
