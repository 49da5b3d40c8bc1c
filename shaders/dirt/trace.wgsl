// DIRT's trace (section 4.2.1, Algorithm 1): a ray walks the tiles of the views that it passes, up and down the pyramid of
// depth bounds, and tests the triangles in the lists of the buckets that it meets.

#import tracebench::types::{Ray, Hit, miss, STATUS_UNWRITTEN, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, NO_PRIMITIVE}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::lanes::{WORKGROUP_SIZE, open, answer_rays, answer_again}
#import tracebench::view::{View, pixel_position}
#import tracebench::triangle::{RayFrame, ray_frame, cross_triangle}
#import tracebench::depth_bounds::bucket_of
#import tracebench::image_walk::{EyeRay, NEVER, Span, eye_ray_of, span_in_view, image_direction}
#import tracebench::cell_walk::{pixel_at, leaves_cell, next_pixel, is_in_image}
#import tracebench::view_walk::{SEAM_SLACK, crossed_first, nothing_crossed}
#import tracebench::pyramid::{CodedCell, level_size, place_of, first_below, next_after}
#import tracebench::dirt_lists::{grid, load_node, load_depths, load_head, load_corners}

struct TraceSettings {
    ray_count: u32,
    view_count: u32,
    any_hit: u32,
    // How a hit is accepted: 0 where its tile is the one searched, 1 by its distance.
    by_distance: u32,
    // 1: every bucket of a tile is searched, also after one with a hit.
    all_buckets: u32,
    // Steps after which a ray is given up.
    max_steps: u32,
    // The highest level of the pyramid that is walked; 0 where rays go from tile to tile.
    top_level: u32,
    rays_per_lane: u32,
}

@group(0) @binding(1) var<uniform> search: TraceSettings;
@group(0) @binding(3) var<uniform> views: array<View, 6>;
@group(0) @binding(7) var<storage, read> rays: array<Ray>;
@group(0) @binding(8) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray: pyramid steps, buckets opened, primitive tests, views entered.
@group(0) @binding(9) var<storage, read_write> counts: array<vec4<u32>>;
// A bit a node: tested by any ray.
@group(0) @binding(10) var<storage, read_write> touched: array<atomic<u32>>;
#endif

// Whether rays are searched for on their own near the views' centres.
override CENTRES: bool;

struct Best {
    t: f32,
    primitive: u32,
    u: f32,
    v: f32,
}

// The state of this lane's ray.
var<private> ray: Ray;
var<private> frame: RayFrame;
var<private> best: Best;
var<private> found: bool;
var<private> capped: bool;
var<private> steps: u32;
// Views that the search was in, a bit each.
var<private> visited: u32;
#ifdef COUNTERS
var<private> work: vec4<u32>;
#endif

// Tests the triangle of one node and gives the next link: none where any hit will do and this is the nearest so far.
fn test_node(link: u32, view: View, eye_ray: EyeRay, tile: vec2<i32>) -> u32 {
    let node = load_node(link - 1u);
#ifdef COUNTERS
    work.z += 1u;
    atomicOr(&touched[(link - 1u) >> 5u], 1u << ((link - 1u) & 31u));
#endif
    let triangle = node.primitive;
    let corners = load_corners(triangle);
    let crossed = cross_triangle(frame, corners.a, corners.b, corners.c);
    let nearer = crossed.t < best.t || (crossed.t == best.t && triangle < best.primitive);
    if (crossed.t >= ray.t_min && nearer) {
        let point = eye_ray.origin + eye_ray.direction * crossed.t;
        let in_tile = point.z > 0.0 && all(vec2<i32>(floor(pixel_position(view, point))) == tile);
        if (search.by_distance == 1u || in_tile) {
            best = Best(crossed.t, triangle, crossed.u, crossed.v);
            found = true;
            return select(node.next, 0u, search.any_hit == 1u);
        }
    }
    return node.next;
}

// Bucket tracing: the buckets of a tile between two depths, in the order in which the ray meets them, up to the first with
// a hit or all. A lane need not wait at the ends of its lists.
fn search_tile(number: u32, view: View, eye_ray: EyeRay, tile: vec2<i32>, depths: vec2<f32>, passed: vec2<f32>) {
    let first = bucket_of(passed.x, depths, grid.buckets);
    let last = bucket_of(passed.y, depths, grid.buckets);
    let backwards = eye_ray.direction.z < 0.0;
    let hit_ends = search.all_buckets == 0u || search.any_hit == 1u;
    var opened = first;
    var link = 0u;
    open += 1u;
    loop {
        // To the next list with a triangle.
        loop {
            if (link != 0u) {
                break;
            }
            if (opened > last || (opened > first && found && hit_ends)) {
                open -= 1u;
                break;
            }
#ifdef COUNTERS
            work.y += 1u;
#endif
            link = load_head(number, vec2<u32>(tile), select(opened, last + first - opened, backwards));
            opened += 1u;
        }
        if (link == 0u) {
            break;
        }
        link = test_node(link, view, eye_ray, tile);
    }
}

// Whether no hit can be nearer than the one found, where every tile before `end` has been searched. By the published rule a
// hit lies in the tile that was searched; by distance it may lie ahead.
fn is_final(end: f32) -> bool {
    return found && (search.by_distance == 0u || search.all_buckets == 0u || search.any_hit == 1u || best.t <= end);
}

// Hi-Z tracing: walks the tiles of a view that a part of the ray passes, up and down the pyramid as far as it is walked. Tiles are
// searched outside of the loop over steps: drivers may run every branch of a loop for all lanes.
fn walk(number: u32, view: View, eye_ray: EyeRay, span: Span) {
    let origin = eye_ray.origin;
    let direction = eye_ray.direction;
    let last_tile = vec2<i32>(grid.tiles) - 1;
    let heading = image_direction(eye_ray);
    var t = span.begin;
    var tile = pixel_at(view, eye_ray, t, last_tile);
    var level = search.top_level;
    open += 1u;
    loop {
        var finds = false;
        var leaves = vec2<f32>(0.0);
        var end = 0.0;
        var depths = vec2<f32>(0.0);
        var passed = vec2<f32>(0.0);
        // To the next tile that holds something at the ray's depths.
        loop {
            if (steps >= search.max_steps) {
                capped = true;
                open -= 1u;
                break;
            }
            steps += 1u;
#ifdef COUNTERS
            work.x += 1u;
#endif
            leaves = leaves_cell(view, eye_ray, heading, tile, level, t);
            end = min(min(leaves.x, leaves.y), span.end);
            depths = load_depths(number, level, vec2<u32>(tile >> vec2<u32>(level)));
            let z_begin = origin.z + direction.z * t;
            let z_end = origin.z + direction.z * end;
            let z_slack = (abs(origin.z) + abs(direction.z) * end) * 4.76837158e-7;
            passed = vec2<f32>(min(z_begin, z_end) - z_slack, max(z_begin, z_end) + z_slack);
            if (passed.x <= depths.y && passed.y >= depths.x) {
                finds = level == 0u;
                if (finds) {
                    break;
                }
                level -= 1u;
                continue;
            }
            tile = next_pixel(view, eye_ray, heading, tile, level, leaves, end, last_tile);
            if (end >= span.end || !is_in_image(tile, last_tile)) {
                open -= 1u;
                break;
            }
            t = end;
            level = min(level + 1u, search.top_level);
        }
        if (!finds) {
            break;
        }
        search_tile(number, view, eye_ray, tile, depths, passed);
        tile = next_pixel(view, eye_ray, heading, tile, level, leaves, end, last_tile);
        if (end >= span.end || is_final(end) || !is_in_image(tile, last_tile)) {
            open -= 1u;
            break;
        }
        t = end;
    }
}

// The part of the ray so near a view's centre that f32 does not tell its tile; none is far beyond everything.
fn near_centre(view: View, eye_ray: EyeRay) -> Span {
    let radius = centre_radius(view);
    let middle = -dot(eye_ray.origin, eye_ray.direction);
    let nearest = eye_ray.origin + eye_ray.direction * middle;
    let rest = radius * radius - dot(nearest, nearest);
    if (rest < 0.0) {
        return Span(NEVER, NEVER);
    }
    return Span(middle - sqrt(rest), middle + sqrt(rest));
}

// Points are rounded by about 2^-22 of the coordinates' size, which at this distance is the tiles' margin (2^-10 of a tile,
// see tile_margin) across half the view.
fn centre_radius(view: View) -> f32 {
    let size = abs(ray.origin) + abs(view.eye);
    return max(size.x, max(size.y, size.z)) * max(view.size.x, view.size.y) * 2.44140625e-4;
}

// Tests every triangle that is stored up to a depth, wherever in the image: down the pyramid in Morton order.
fn search_to_depth(number: u32, view: View, eye_ray: EyeRay, depth: f32) {
    let top = grid.levels - 1u;
    var cell = CodedCell(top, 0u);
    open += 1u;
    loop {
        let place = place_of(cell);
        var descend = false;
        if (all(place < level_size(grid.tiles, cell.level))) {
            let depths = load_depths(number, cell.level, place);
            let reached = depths.x <= depth;
            descend = reached && cell.level > 0u;
            if (reached && cell.level == 0u) {
                search_tile(number, view, eye_ray, vec2<i32>(place), depths, vec2<f32>(depths.x, depth));
            }
        }
        if (descend) {
            cell = first_below(cell);
            continue;
        }
        cell = next_after(cell, top);
        if (cell.level == top) {
            open -= 1u;
            break;
        }
    }
}

// Searches for a ray. `open` tells whether it was cut off.
fn find_hit(asked: Ray) {
    ray = asked;
    frame = ray_frame(ray.origin, ray.direction);
    best = Best(ray.t_max, NO_PRIMITIVE, 0.0, 0.0);
    found = false;
    capped = false;
    steps = 0u;
    open = 0u;
#ifdef COUNTERS
    work = vec4<u32>(0u);
#endif
    visited = 0u;
    if (CENTRES) {
        var each = 0u;
        open += 1u;
        loop {
            if (each >= search.view_count) {
                open -= 1u;
                break;
            }
            let view = views[each];
            let eye_ray = eye_ray_of(view, ray);
            let near = near_centre(view, eye_ray);
            if (near.end >= ray.t_min && near.begin <= ray.t_max) {
                search_to_depth(each, view, eye_ray, centre_radius(view));
            }
            each += 1u;
        }
    }
    // By distance, a ray along the seam between two views must not be lost by both to rounding.
    let slack = select(1.0, SEAM_SLACK, (search.by_distance == 1u));
    // A view is never entered twice (a line meets a view in one piece), so there are at most as many rounds as views.
    open += 1u;
    loop {
        // The view that the ray meets next.
        var crossed = nothing_crossed(search.view_count);
        var candidate = 0u;
        open += 1u;
        loop {
            if (candidate >= search.view_count) {
                open -= 1u;
                break;
            }
            if ((visited & (1u << candidate)) == 0u) {
                let view = views[candidate];
                let part = span_in_view(view, eye_ray_of(view, ray), Span(ray.t_min, best.t), slack);
                crossed = crossed_first(crossed, candidate, part);
            }
            candidate += 1u;
        }
        let chosen = crossed.view;
        let span = crossed.span;
        if (chosen == search.view_count) {
            open -= 1u;
            break;
        }
        visited |= 1u << chosen;
#ifdef COUNTERS
        work.w += 1u;
#endif
        let view = views[chosen];
        let eye_ray = eye_ray_of(view, ray);
        if (CENTRES) {
            let near = near_centre(view, eye_ray);
            var part = 0u;
            open += 1u;
            loop {
                if (part >= 2u) {
                    open -= 1u;
                    break;
                }
                let before = Span(span.begin, min(span.end, near.begin));
                let after = Span(max(span.begin, near.end), span.end);
                let side = Span(select(after.begin, before.begin, (part == 0u)), select(after.end, before.end, (part == 0u)));
                if (side.begin <= side.end && !capped) {
                    walk(chosen, view, eye_ray, side);
                }
                part += 1u;
            }
        } else {
            walk(chosen, view, eye_ray, span);
        }
        if (capped || is_final(-1e38)) {
            open -= 1u;
            break;
        }
    }
}

// The answer of the search.
fn answer() -> Hit {
    if (capped || open > 0u) {
        return miss(STATUS_STEP_CAP);
    }
    if (found) {
        return Hit(best.t, best.primitive, best.u, best.v, STATUS_HIT);
    }
    return miss(select(STATUS_MISS, STATUS_LEFT_VIEWS, (visited == 0u || search.view_count < 6u)));
}

override fn tracebench::lanes::search_ray(index: u32) {
    find_hit(rays[index]);
}

override fn tracebench::lanes::answer_ray(index: u32) {
    hits[index] = answer();
#ifdef COUNTERS
    counts[index] = work;
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, search.ray_count, search.rays_per_lane);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace_unanswered(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    answer_again(index, search.ray_count, index < search.ray_count && hits[index].status == STATUS_UNWRITTEN);
}
