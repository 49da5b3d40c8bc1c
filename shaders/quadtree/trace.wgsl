// The trace over quad-trees (WKP15, section 4): through a view's layers, each asked where the one before leaves something open, and
// from view to view where faces of a cube are connected (section 5.4).

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::types::{Hit, Surface, miss, no_surface, NO_PRIMITIVE, STATUS_UNWRITTEN, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, STATUS_BEHIND_LAST_LAYER, STATUS_INPAINTED, SURFACE_NO_HIT, SURFACE_WRITTEN}
#import tracebench::types::Ray
#import tracebench::lanes::{WORKGROUP_SIZE, open, answer_rays, answer_again}
#import tracebench::reads::{quad_0, quad_1}
#import tracebench::view::{View, pixel_position}
#import tracebench::image_walk::{Span, eye_ray_of, span_in_view}
#import tracebench::image_line::t_on
#import tracebench::view_walk::{SEAM_SLACK, FAR_SIDE, crossed_first, nothing_crossed, side_left}
#import tracebench::quadtree_forest::depth_of_z
#import tracebench::quadtree_node::{Plane, is_empty, plane_of}
#import tracebench::quadtree_track::{NOWHERE, track_of}
#import tracebench::quadtree_store::{forest, search, views, ray, eye_ray, capped, steps, work, counted, pixel_node, is_joined}
#import tracebench::quadtree_walk::{found, track, walk_tree}

@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef SURFACES
@group(0) @binding(5) var<storage, read_write> surfaces: array<Surface>;
#endif
#ifdef SECONDARY
// Of every ray the sum of its samples' weights.
@group(0) @binding(7) var<storage, read_write> weights: array<f32>;
#endif

// Of every ray: nodes visited, planes tested, boxes tested, layers asked, views entered, whether a second layer was asked, whether
// a layer behind the first was hit; and where planes are joined, neighbours of pixels that were looked at.
const COUNTS: u32 = 8u;

// The codes of `next_layer`.
const ASK_BEHIND_VOLUMES: u32 = 0u;
const ASK_AFTER_MISSES: u32 = 1u;

// The nearest hit in a view, over its layers.
var<private> best_place: f32;
var<private> best_z: f32;
var<private> best_layer: u32;
var<private> best_pixel: vec2<u32>;
var<private> best_inpainted: bool;
var<private> best_plane: Plane;
var<private> best_middle: vec2<f32>;
// The ray lies in an occlusion volume of the last layer, and what lies in there is not known.
var<private> occluded: bool;
// Nothing more is looked at.
var<private> ended: bool;

// Walks the layers of a view, each up to the nearest hit so far.
fn trace_layers(number: u32) {
    best_place = NOWHERE;
    var first = 0.0;
    var limit = 1.0;
    var layer = 0u;
    open += 1u;
    loop {
#ifdef COUNTERS
        work[3] += 1u;
        work[5] = max(work[5], min(layer, 1u));
#endif
        let holes = select(0u, search.inpaints, (layer + 1u == forest.layers));
        walk_tree(number * forest.layers + layer, first, limit, holes);
        let hit = found.place <= limit;
        if (hit) {
            best_place = found.place;
            best_z = found.z;
            best_layer = layer;
            best_pixel = found.pixel;
            best_inpainted = found.inpainted;
            best_plane = found.plane;
            best_middle = found.middle;
            limit = found.place;
        }
        ended = found.stopped;
        // Before the hit, else it hides nothing of the ray.
        let passed = found.volume < limit;
        layer += 1u;
        var done = capped || ended || (hit && search.any_hit == 1u);
        if (search.next_layer == ASK_BEHIND_VOLUMES) {
            // Nothing lies before the volume: what is in the layers behind is behind this one.
            done = done || !passed;
            first = min(found.volume, limit);
        } else if (search.next_layer == ASK_AFTER_MISSES) {
            done = done || hit;
        }
        if (done || layer >= forest.layers) {
            occluded = occluded || (passed && layer >= forest.layers) || (ended && !hit);
            open -= 1u;
            break;
        }
    }
}

#ifdef SECONDARY
// Rays beside this one, with the plane that it hit: the sum of weights by how far from it the image's own depth lies (section 5.2).
// They lie on a spiral round the ray, evenly spread over a disk.
fn sample_plane(number: u32) -> f32 {
    let view = views[number].view;
    let size = vec2<f32>(forest.size);
    // In eye space the plane's points p have dot(normal, p) = z_scale.
    let tangents = vec2<f32>(view.tan_half_width, -view.tan_half_height);
    let across = best_plane.slope * 0.5 * size;
    let upright = best_plane.z + forest.z_shift + dot(best_plane.slope, 0.5 * size - best_middle);
    let normal = vec3<f32>(across / tangents, upright);
    let direction = eye_ray.direction;
    let axis = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), (abs(direction.x) > 0.5));
    let first = normalize(cross(direction, axis));
    let second = cross(direction, first);
    var sum = 0.0;
    var sample = 0u;
    for (; sample < search.samples; sample++) {
        let radius = sqrt((f32(sample) + 0.5) / f32(search.samples)) * search.jitter * forest.pixel_angle;
        // The golden angle.
        let turn = f32(sample) * 2.3999632;
        let beside = direction + radius * (cos(turn) * first + sin(turn) * second);
        let slope = dot(normal, beside);
        let t = (forest.z_scale - dot(normal, eye_ray.origin)) / slope;
        let point = eye_ray.origin + t * beside;
        if (slope == 0.0 || !(t > 0.0) || point.z < view.near || point.z > view.far) {
            continue;
        }
        let at = floor(pixel_position(view, point));
        if (any(at < vec2<f32>(0.0)) || any(at >= size)) {
            continue;
        }
        let words = pixel_node(number * forest.layers + best_layer, vec2<u32>(at));
        if (is_empty(words)) {
            continue;
        }
        let off = (forest.z_scale / point.z - forest.z_shift - plane_of(words, size).z) * search.inverse_sigma;
        sum += exp(-off * off);
    }
    // Cut off.
    open += select(0u, 1u, (sample < search.samples));
    return sum;
}
#endif

// Views that the search was in, the last of them, and whether they hold all of the ray.
var<private> entered: u32;
var<private> number: u32;
var<private> seen_whole: bool;
var<private> hit: bool;
#ifdef SECONDARY
var<private> weight: f32;
#endif

override fn tracebench::lanes::search_ray(index: u32) {
    // Nothing is left of the ray before.
    capped = false;
    steps = 0u;
    open = 0u;
    occluded = false;
    ended = false;
    best_place = NOWHERE;
#ifdef COUNTERS
    work = array<u32, COUNTS>();
#endif
    ray = rays[index];
    var now = ray.t_min;
    var visited = 0u;
    entered = 0u;
    seen_whole = false;
    number = 0u;
    // The view that the ray is known to be in next.
    var hint = search.view_count;
    open += 1u;
    loop {
        let rest = Span(now, ray.t_max);
        var crossed = nothing_crossed(search.view_count);
        if (hint < search.view_count && (visited & (1u << hint)) == 0u) {
            let view = views[hint].view;
            crossed = crossed_first(crossed, hint, span_in_view(view, eye_ray_of(view, ray), rest, SEAM_SLACK));
        }
        if (crossed.view == search.view_count) {
            var candidate = 0u;
            for (; candidate < search.view_count; candidate++) {
                if ((visited & (1u << candidate)) == 0u) {
                    let view = views[candidate].view;
                    let span = span_in_view(view, eye_ray_of(view, ray), rest, SEAM_SLACK);
                    crossed = crossed_first(crossed, candidate, span);
                }
            }
            // Cut off.
            open += select(0u, 1u, (candidate < search.view_count));
        }
        if (crossed.view == search.view_count) {
            open -= 1u;
            break;
        }
        number = crossed.view;
        visited |= 1u << number;
        let view = views[number].view;
        eye_ray = eye_ray_of(view, ray);
        var span = crossed.span;
        let starts = entered == 0u && span.begin <= ray.t_min;
        seen_whole = search.has_faces == 1u || (starts && span.end >= ray.t_max);
        entered += 1u;
        if (starts) {
            // Away from the surface that the ray may start on, by widths of a pixel there.
            let depth = eye_ray.origin.z + eye_ray.direction.z * span.begin;
            span.begin += search.start_bias * forest.pixel_angle * max(depth, view.near);
        }
        if (span.begin < span.end) {
            track = track_of(forest, view, eye_ray, span);
            trace_layers(number);
        }
        now = max(now, crossed.span.end);
        let side = side_left(view, eye_ray);
        hint = search.view_count;
        if (side < 4u) {
            hint = views[number].beyond[side];
        }
        if (best_place <= 1.0 || capped || ended || side == FAR_SIDE || now >= ray.t_max) {
            open -= 1u;
            break;
        }
    }
    // The pixel takes part where no surface is asked for, too: else compilers make other sums of the place that both it and t come from.
    hit = best_place <= 1.0 && all(best_pixel < vec2<u32>(65536u));
#ifdef SECONDARY
    weight = 0.0;
    if (hit && !best_inpainted) {
        weight = sample_plane(number);
    }
#endif
}

override fn tracebench::lanes::answer_ray(index: u32) {
    let is_found = hit && !capped && open == 0u;
    let depth = depth_of_z(forest, best_z);
    let t = clamp(t_on(track.line, best_place, depth), ray.t_min, ray.t_max);
    if (capped || open > 0u) {
        hits[index] = miss(STATUS_STEP_CAP);
    } else if (hit) {
        hits[index] = Hit(t, NO_PRIMITIVE, 0.0, 0.0, select(STATUS_HIT, STATUS_INPAINTED, best_inpainted));
    } else if (occluded) {
        hits[index] = miss(STATUS_BEHIND_LAST_LAYER);
    } else {
        hits[index] = miss(select(STATUS_LEFT_VIEWS, STATUS_MISS, (entered > 0u && seen_whole)));
    }
#ifdef SECONDARY
    weights[index] = select(0.0, weight, is_found);
#endif
#ifdef SURFACES
    if (is_found) {
        let pixels = forest.size.x * forest.size.y;
        let is_even = (best_layer & 1u) == 1u;
        let layers = select((forest.layers + 1u) / 2u, forest.layers / 2u, is_even);
        let pixel = best_pixel.y * forest.size.x + best_pixel.x;
        let at = (number * layers + best_layer / 2u) * pixels + pixel;
        var payload = vec4<u32>(0u);
        if (is_even) {
            payload = quad_1(at);
        } else {
            payload = quad_0(at);
        }
        let position = ray.origin + ray.direction * t;
        surfaces[index] = Surface(position, payload.w, bitcast<vec3<f32>>(payload.xyz), SURFACE_WRITTEN);
#ifdef COUNTERS
        let bit = (number * forest.layers + best_layer) * pixels + pixel;
        atomicOr(&counted[search.touched_words + (bit >> 5u)], 1u << (bit & 31u));
#endif
    } else {
        surfaces[index] = no_surface(SURFACE_NO_HIT);
    }
#endif
#ifdef COUNTERS
    work[4] = entered;
    work[6] = select(0u, 1u, (is_found && best_layer > 0u));
    let counts = select(COUNTS - 1u, COUNTS, is_joined());
    for (var count = 0u; count < counts; count++) {
        atomicStore(&counted[2u * search.touched_words + index * counts + count], work[count]);
    }
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
