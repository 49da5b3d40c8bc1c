// DIRT's trace (section 4.2.1, Algorithm 1): a ray walks the tiles of the views that it passes, up and down the pyramid of
// depth bounds, and tests the triangles in the lists of the buckets that it meets.

#import tracebench::types::{Ray, Hit, miss, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, NO_PRIMITIVE}
#import tracebench::dispatch::linear_invocation
#import tracebench::view::{View, to_eye_space, direction_to_eye_space, pixel_position}
#import tracebench::triangle::{RayFrame, ray_frame, cross_triangle}
#import tracebench::dirt_grid::{TileGrid, Node, level_tiles, bounds_index, head_index, depths_of, bucket_of}

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
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> grid: TileGrid;
@group(0) @binding(1) var<uniform> search: TraceSettings;
@group(0) @binding(2) var<uniform> views: array<View, 6>;
@group(0) @binding(3) var<storage, read> positions: array<f32>;
@group(0) @binding(4) var<storage, read> indices: array<u32>;
@group(0) @binding(5) var<storage, read> bounds: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> heads: array<u32>;
@group(0) @binding(7) var<storage, read> nodes: array<Node>;
@group(0) @binding(8) var<storage, read> rays: array<Ray>;
@group(0) @binding(9) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray: pyramid steps, buckets opened, primitive tests, views entered.
@group(0) @binding(10) var<storage, read_write> counts: array<vec4<u32>>;
// A bit a node: tested by any ray.
@group(0) @binding(11) var<storage, read_write> touched: array<atomic<u32>>;
#ifdef SPLIT
@group(0) @binding(12) var<storage, read> nodes_1: array<Node>;
@group(0) @binding(13) var<storage, read> nodes_2: array<Node>;
@group(0) @binding(14) var<storage, read> nodes_3: array<Node>;
@group(0) @binding(15) var<storage, read> nodes_4: array<Node>;
@group(0) @binding(16) var<storage, read> nodes_5: array<Node>;
@group(0) @binding(17) var<storage, read> nodes_6: array<Node>;
@group(0) @binding(18) var<storage, read> nodes_7: array<Node>;
#endif
#else
#ifdef SPLIT
// Further nodes, where one binding does not hold all.
@group(0) @binding(10) var<storage, read> nodes_1: array<Node>;
@group(0) @binding(11) var<storage, read> nodes_2: array<Node>;
@group(0) @binding(12) var<storage, read> nodes_3: array<Node>;
@group(0) @binding(13) var<storage, read> nodes_4: array<Node>;
@group(0) @binding(14) var<storage, read> nodes_5: array<Node>;
@group(0) @binding(15) var<storage, read> nodes_6: array<Node>;
@group(0) @binding(16) var<storage, read> nodes_7: array<Node>;
#endif
#endif

const WORKGROUP_SIZE: u32 = 64u;

// The part of a ray inside a view; begin > end for none.
struct Span {
    begin: f32,
    end: f32,
}

struct Best {
    t: f32,
    primitive: u32,
    u: f32,
    v: f32,
}

fn load_node(index: u32) -> Node {
#ifdef SPLIT
    let within = index % grid.nodes_per_part;
    switch (index / grid.nodes_per_part) {
        case 0u: {
            return nodes[within];
        }
        case 1u: {
            return nodes_1[within];
        }
        case 2u: {
            return nodes_2[within];
        }
        case 3u: {
            return nodes_3[within];
        }
        case 4u: {
            return nodes_4[within];
        }
        case 5u: {
            return nodes_5[within];
        }
        case 6u: {
            return nodes_6[within];
        }
        default: {
            return nodes_7[within];
        }
    }
#else
    return nodes[index];
#endif
}

// The span in which value + slope * t >= 0, within another.
fn cut(span: Span, value: f32, slope: f32) -> Span {
    if (slope == 0.0) {
        return Span(span.begin, select(span.end, -1.0, (value < 0.0)));
    }
    let at = -value / slope;
    return Span(select(span.begin, max(span.begin, at), (slope > 0.0)), select(span.end, min(span.end, at), (slope < 0.0)));
}

fn span_in_view(view: View, origin: vec3<f32>, direction: vec3<f32>, whole: Span) -> Span {
    let at = vec2<f32>(view.tan_half_width, view.tan_half_height);
    var span = cut(whole, origin.z - view.near, direction.z);
    span = cut(span, view.far - origin.z, -direction.z);
    span = cut(span, origin.z * at.x - origin.x, direction.z * at.x - direction.x);
    span = cut(span, origin.z * at.x + origin.x, direction.z * at.x + direction.x);
    span = cut(span, origin.z * at.y - origin.y, direction.z * at.y - direction.y);
    return cut(span, origin.z * at.y + origin.y, direction.z * at.y + direction.y);
}

// The t at which a ray leaves the side of the plane through the eye and a line of the image `tangent` across, not before
// `now`; 1e38 for a ray that does not. `heading` is the ray's along this axis: a ray may head for a line that it never
// meets, where it runs away from the eye inside of the line.
fn leaving(tangent: f32, heading: f32, origin: f32, direction: f32, origin_z: f32, direction_z: f32, now: f32) -> f32 {
    let inside = (tangent * origin_z - origin) * heading;
    let approach = (direction - tangent * direction_z) * heading;
    if (approach <= 0.0) {
        return 1e38;
    }
    return max(now, inside / approach);
}

// A step of the ray across the image: -1, 0 or 1 along x (right) and y (down). A projected line keeps its direction.
fn image_direction(origin: vec3<f32>, direction: vec3<f32>) -> vec2<i32> {
    let turn = direction.xy * origin.z - origin.xy * direction.z;
    return vec2<i32>(sign(vec2<f32>(turn.x, -turn.y)));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_invocation(workgroup, workgroups, local, WORKGROUP_SIZE);
    if (index >= search.ray_count) {
        return;
    }
    let ray = rays[index];
    let frame = ray_frame(ray.origin, ray.direction);
    var best = Best(ray.t_max, NO_PRIMITIVE, 0.0, 0.0);
    var found = false;
    var capped = false;
    var visited = 0u;
    var steps = 0u;
#ifdef COUNTERS
    var work = vec4<u32>(0u);
#endif
    // A view is never entered twice (a line meets a view in one piece), so there are at most as many rounds as views.
    for (var round = 0u; round < search.view_count; round++) {
        // The view that the ray meets next.
        var chosen = search.view_count;
        var span = Span(1e38, -1e38);
        for (var candidate = 0u; candidate < search.view_count; candidate++) {
            let view = views[candidate];
            let part = span_in_view(view, to_eye_space(view, ray.origin), direction_to_eye_space(view, ray.direction), Span(ray.t_min, best.t));
            if ((visited & (1u << candidate)) == 0u && part.begin <= part.end && part.begin < span.begin) {
                chosen = candidate;
                span = part;
            }
        }
        if (chosen == search.view_count) {
            break;
        }
        visited |= 1u << chosen;
#ifdef COUNTERS
        work.w += 1u;
#endif
        let view = views[chosen];
        let origin = to_eye_space(view, ray.origin);
        let direction = direction_to_eye_space(view, ray.direction);
        let tangents = vec2<f32>(view.tan_half_width, view.tan_half_height);
        let last_tile = vec2<i32>(grid.tiles) - 1;
        let heading = image_direction(origin, direction);
        var t = span.begin;
        var tile = clamp(vec2<i32>(floor(pixel_position(view, origin + direction * t))), vec2<i32>(0), last_tile);
        var level = grid.levels - 1u;
        loop {
            if (steps >= search.max_steps) {
                capped = true;
                break;
            }
            steps += 1u;
#ifdef COUNTERS
            work.x += 1u;
#endif
            let cell = tile >> vec2<u32>(level);
            // Lines of the image at which the ray leaves the cell.
            let edge = (cell + max(heading, vec2<i32>(0))) << vec2<u32>(level);
            let line = (vec2<f32>(edge) * 2.0 / view.size - 1.0) * tangents * vec2<f32>(1.0, -1.0);
            var leaves = vec2<f32>(1e38);
            if (heading.x != 0) {
                leaves.x = leaving(line.x, f32(heading.x), origin.x, direction.x, origin.z, direction.z, t);
            }
            if (heading.y != 0) {
                // Rows count downwards, eye space upwards.
                leaves.y = leaving(line.y, -f32(heading.y), origin.y, direction.y, origin.z, direction.z, t);
            }
            let end = min(min(leaves.x, leaves.y), span.end);
            // (1) Hi-Z tracing.
            let depths = depths_of(bounds[bounds_index(grid, chosen, level, vec2<u32>(cell))]);
            let z_begin = origin.z + direction.z * t;
            let z_end = origin.z + direction.z * end;
            let z_slack = (abs(origin.z) + abs(direction.z) * end) * 4.76837158e-7;
            let least = min(z_begin, z_end) - z_slack;
            let greatest = max(z_begin, z_end) + z_slack;
            let overlaps = least <= depths.y && greatest >= depths.x;
            if (overlaps && level > 0u) {
                level -= 1u;
                continue;
            }
            if (overlaps) {
                // (2) Bucket tracing, in the order in which the ray meets the buckets.
                let first = bucket_of(least, depths, grid.buckets);
                let last = bucket_of(greatest, depths, grid.buckets);
                let backwards = direction.z < 0.0;
                for (var opened = first; opened <= last; opened++) {
                    let bucket = select(opened, last + first - opened, backwards);
#ifdef COUNTERS
                    work.y += 1u;
#endif
                    var link = heads[head_index(grid, chosen, vec2<u32>(tile), bucket)];
                    var in_bucket = false;
                    while (link != 0u) {
                        let node = load_node(link - 1u);
#ifdef COUNTERS
                        work.z += 1u;
                        atomicOr(&touched[(link - 1u) >> 5u], 1u << ((link - 1u) & 31u));
#endif
                        link = node.next;
                        let corner = node.primitive * 3u;
                        let a = indices[corner] * 3u;
                        let b = indices[corner + 1u] * 3u;
                        let c = indices[corner + 2u] * 3u;
                        let crossed = cross_triangle(
                            frame,
                            vec3<f32>(positions[a], positions[a + 1u], positions[a + 2u]),
                            vec3<f32>(positions[b], positions[b + 1u], positions[b + 2u]),
                            vec3<f32>(positions[c], positions[c + 1u], positions[c + 2u]),
                        );
                        let nearer = crossed.t < best.t || (crossed.t == best.t && node.primitive < best.primitive);
                        if (crossed.t >= ray.t_min && nearer) {
                            let eye_point = origin + direction * crossed.t;
                            let in_tile = eye_point.z > 0.0 && all(vec2<i32>(floor(pixel_position(view, eye_point))) == tile);
                            let accepted = search.by_distance == 1u || in_tile;
                            if (accepted) {
                                best = Best(crossed.t, node.primitive, crossed.u, crossed.v);
                                in_bucket = true;
                            }
                        }
                    }
                    if (in_bucket) {
                        found = true;
                        if (search.all_buckets == 0u || search.any_hit == 1u) {
                            break;
                        }
                    }
                }
                // By the published rule a hit lies in this tile, so nothing nearer is left; by distance it may lie ahead.
                if (found && (search.by_distance == 0u || search.all_buckets == 0u || search.any_hit == 1u || best.t <= end)) {
                    break;
                }
            }
            if (end >= span.end) {
                break;
            }
            // To the next cell across the nearer line; along the other axis to where the ray is, never back.
            let along_x = leaves.x <= leaves.y;
            let at = vec2<i32>(floor(pixel_position(view, origin + direction * end)));
            let low = max(cell << vec2<u32>(level), select(vec2<i32>(-1), tile, (heading > vec2<i32>(0))));
            let high = min(((cell + 1) << vec2<u32>(level)) - 1, select(last_tile, tile, (heading < vec2<i32>(0))));
            var next = clamp(at, low, min(high, last_tile));
            if (along_x) {
                next.x = select((cell.x << level) - 1, (cell.x + 1) << level, (heading.x > 0));
            } else {
                next.y = select((cell.y << level) - 1, (cell.y + 1) << level, (heading.y > 0));
            }
            if (any(next < vec2<i32>(0)) || any(next > last_tile)) {
                break;
            }
            tile = next;
            t = end;
            if (!overlaps) {
                level = min(level + 1u, grid.levels - 1u);
            }
        }
        if (capped || (found && (search.by_distance == 0u || search.all_buckets == 0u || search.any_hit == 1u))) {
            break;
        }
    }
    if (found) {
        hits[index] = Hit(best.t, best.primitive, best.u, best.v, STATUS_HIT);
    } else if (capped) {
        hits[index] = miss(STATUS_STEP_CAP);
    } else {
        hits[index] = miss(select(STATUS_MISS, STATUS_LEFT_VIEWS, (visited == 0u || search.view_count < 6u)));
    }
#ifdef COUNTERS
    counts[index] = work;
#endif
}
