// The trace of the fragment A-buffer (section 3.4): a ray is marched over the images of the views that it passes; in each pixel
// that it looks at, the fragments are searched for one within the depths that the ray has there.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::types::{Ray, Hit, Surface, miss, no_surface, NO_PRIMITIVE, STATUS_UNWRITTEN, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, SURFACE_NO_HIT, SURFACE_WRITTEN}
#import tracebench::lanes::{WORKGROUP_SIZE, open, answer_rays, answer_again}
#import tracebench::image_walk::{Span, eye_ray_of, span_in_view}
#import tracebench::view_walk::{SEAM_SLACK, FAR_SIDE, Crossed, crossed_first, nothing_crossed, side_left}
#import tracebench::fragment_store::{shape, search, views, ray, eye_ray, number, traced, found, found_node, found_t, capped, steps, work, counted, data_of, load_payload}
#import tracebench::fragment_march::{BY_STEPS, march_steps, walk_pixels}

@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef SURFACES
@group(0) @binding(5) var<storage, read_write> surfaces: array<Surface>;
#endif
// Of every ray: pixels looked at, pixels with fragments tested, fragments tested, views entered, views asked for, lists searched.
const COUNTS: u32 = 6u;

fn span_in(candidate: u32, whole: Span) -> Span {
    let view = views[candidate].view;
#ifdef COUNTERS
    work[4] += 1u;
#endif
    return span_in_view(view, eye_ray_of(view, ray), whole, SEAM_SLACK);
}

// Where a ray is on its way through the views: in faces up to where it meets the camera's view, in this, in faces again.
const BEFORE_CAMERA: u32 = 0u;
const IN_CAMERA: u32 = 1u;
const AFTER_CAMERA: u32 = 2u;

// Views that the search was in, and whether these hold all of the ray.
var<private> entered: u32;
var<private> seen_whole: bool;

override fn tracebench::lanes::search_ray(index: u32) {
    // Nothing is left of the ray before.
    found = false;
    capped = false;
    steps = 0u;
    open = 0u;
#ifdef COUNTERS
    work = array<u32, 6>();
#endif
    ray = rays[index];
    var camera = Span(1.0, 0.0);
    if (views[0].is_face == 0u) {
        camera = span_in(0u, Span(ray.t_min, ray.t_max));
    }
    let sees_camera = camera.begin <= camera.end;
    let has_faces = views[search.view_count - 1u].is_face == 1u;
    var stage = select(AFTER_CAMERA, BEFORE_CAMERA, sees_camera);
    var now = ray.t_min;
    var visited = 0u;
    entered = 0u;
    // The face that the ray is known to be in next.
    var hint = search.view_count;
    open += 1u;
    loop {
        let limit = select(ray.t_max, camera.begin, (stage == BEFORE_CAMERA));
        if (stage == BEFORE_CAMERA && (now >= limit || !has_faces)) {
            stage = IN_CAMERA;
        }
        var crossed = nothing_crossed(search.view_count);
        if (stage == IN_CAMERA) {
            crossed = Crossed(0u, camera);
        } else if (has_faces) {
            if (hint < search.view_count && (visited & (1u << hint)) == 0u) {
                crossed = crossed_first(crossed, hint, span_in(hint, Span(now, limit)));
            }
            if (crossed.view == search.view_count) {
                var candidate = 0u;
                for (; candidate < search.view_count; candidate++) {
                    if (views[candidate].is_face == 1u && (visited & (1u << candidate)) == 0u) {
                        crossed = crossed_first(crossed, candidate, span_in(candidate, Span(now, limit)));
                    }
                }
                // Cut off.
                open += select(0u, 1u, (candidate < search.view_count));
            }
        }
        let chosen = crossed.view;
        let span = crossed.span;
        hint = search.view_count;
        var done = false;
        if (chosen == search.view_count) {
            done = stage == AFTER_CAMERA;
            now = limit;
        } else {
            visited |= 1u << chosen;
            number = chosen;
            traced = views[chosen];
            let view = traced.view;
            eye_ray = eye_ray_of(view, ray);
            let starts = entered == 0u && span.begin <= ray.t_min;
            entered += 1u;
            if (search.march == BY_STEPS) {
                march_steps(view, span, starts);
            } else {
                walk_pixels(view, span, starts);
            }
            now = max(now, span.end);
            if (stage == IN_CAMERA) {
                stage = AFTER_CAMERA;
                visited = 0u;
            } else if (now < limit) {
                // Edge connectivity: the face beyond the side by which the ray leaves this one.
                let side = side_left(view, eye_ray);
                if (side < 4u) {
                    hint = traced.beyond[side];
                }
                done = side == FAR_SIDE && stage == AFTER_CAMERA;
            }
            done = done || found || capped || now >= ray.t_max;
        }
        if (done) {
            open -= 1u;
            break;
        }
    }
    seen_whole = entered > 0u && (has_faces || (camera.begin <= ray.t_min && camera.end >= ray.t_max));
}

override fn tracebench::lanes::answer_ray(index: u32) {
    if (capped || open > 0u) {
        found = false;
        hits[index] = miss(STATUS_STEP_CAP);
    } else if (found) {
        hits[index] = Hit(found_t, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
    } else {
        hits[index] = miss(select(STATUS_LEFT_VIEWS, STATUS_MISS, seen_whole));
    }
#ifdef SURFACES
    if (found) {
        let data = data_of(found_node);
        let at = data * shape.data_words + shape.data_offset;
        let normal = vec3<u32>(load_payload(at), load_payload(at + 1u), load_payload(at + 2u));
        let position = ray.origin + ray.direction * found_t;
        surfaces[index] = Surface(position, load_payload(at + 3u), bitcast<vec3<f32>>(normal), SURFACE_WRITTEN);
#ifdef COUNTERS
        let bit = traced.first_node + data;
        atomicOr(&counted[search.touched_words + (bit >> 5u)], 1u << (bit & 31u));
#endif
    } else {
        surfaces[index] = no_surface(SURFACE_NO_HIT);
    }
#endif
#ifdef COUNTERS
    work[3] = entered;
    for (var count = 0u; count < COUNTS; count++) {
        atomicStore(&counted[2u * search.touched_words + index * COUNTS + count], work[count]);
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
