// The trace of the fragment A-buffer (section 3.4): a ray is marched over the images of the views that it passes; in each pixel
// that it looks at, the fragments are searched for one within the depths that the ray has there.

#import tracebench::types::{Ray, Hit, Surface, miss, no_surface, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, SURFACE_NO_HIT, SURFACE_WRITTEN}
#import tracebench::dispatch::linear_invocation
#import tracebench::view::View
#import tracebench::image_walk::{EyeRay, Span, eye_ray_of, span_in_view, image_direction}
#import tracebench::image_line::{ImageLine, image_line, place_after, depth_on, t_on}
#import tracebench::cell_walk::{pixel_at, leaves_cell, next_pixel, is_in_image, span_in_pixel}
#import tracebench::view_walk::{SEAM_SLACK, FAR_SIDE, Crossed, crossed_first, nothing_crossed, side_left}
#import tracebench::depth_bounds::{depths_of, bucket_share}
#import tracebench::fragment_layout::{Storage, TracedView, pyramid_index, BOUNDS_SLACK}

struct MarchSettings {
    ray_count: u32,
    view_count: u32,
    // 0: a number of steps a view, 1: every pixel, 2: up and down the pyramid.
    march: u32,
    // Steps a view; steps after which a ray is given up.
    steps: u32,
    max_steps: u32,
    // 1: steps look at their middle.
    centred: u32,
    // 1: a step asks for depths within its pixel alone.
    span_by_pixel: u32,
    // 1: pixels, buckets and rests of lists that hold no hit are skipped.
    skipping: u32,
    binary_search_above: u32,
    // Scene units, and parts of the eye depth: one of both is 0.
    thickness: f32,
    // Widths of a pixel.
    thickness_in_pixels: f32,
    // Pixels along the major axis.
    start_bias: f32,
    // 1: fragments are as thick as that before their depth, not behind it.
    thick_before: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(1) var<uniform> search: MarchSettings;
@group(0) @binding(2) var<uniform> views: array<TracedView, 7>;
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
@group(0) @binding(5) var<storage, read> pixels: array<u32>;
@group(0) @binding(6) var<storage, read> ids: array<u32>;
// Of the levels above the pixels; with other marches anything.
@group(0) @binding(7) var<storage, read> pyramid: array<u32>;
#ifdef SURFACES
@group(0) @binding(8) var<storage, read> payloads: array<u32>;
@group(0) @binding(9) var<storage, read_write> surfaces: array<Surface>;
#endif
#ifdef COUNTERS
// Of every ray COUNTS: pixels looked at, pixels with fragments tested, fragments tested, views entered, views asked for.
@group(0) @binding(10) var<storage, read_write> counts: array<u32>;
// A bit a node: tested by any ray.
@group(0) @binding(11) var<storage, read_write> touched: array<atomic<u32>>;
#ifdef SURFACES
// A bit a node: its payload read for any ray.
@group(0) @binding(12) var<storage, read_write> payloads_touched: array<atomic<u32>>;
#endif
#endif
#ifdef SPLIT
// Where one binding does not hold all, each view has buffers of its own: these are the further views'.
@group(1) @binding(0) var<storage, read> pixels_1: array<u32>;
@group(1) @binding(1) var<storage, read> pixels_2: array<u32>;
@group(1) @binding(2) var<storage, read> pixels_3: array<u32>;
@group(1) @binding(3) var<storage, read> pixels_4: array<u32>;
@group(1) @binding(4) var<storage, read> pixels_5: array<u32>;
@group(1) @binding(5) var<storage, read> pixels_6: array<u32>;
@group(1) @binding(6) var<storage, read> ids_1: array<u32>;
@group(1) @binding(7) var<storage, read> ids_2: array<u32>;
@group(1) @binding(8) var<storage, read> ids_3: array<u32>;
@group(1) @binding(9) var<storage, read> ids_4: array<u32>;
@group(1) @binding(10) var<storage, read> ids_5: array<u32>;
@group(1) @binding(11) var<storage, read> ids_6: array<u32>;
#ifdef SURFACES
@group(1) @binding(12) var<storage, read> payloads_1: array<u32>;
@group(1) @binding(13) var<storage, read> payloads_2: array<u32>;
@group(1) @binding(14) var<storage, read> payloads_3: array<u32>;
@group(1) @binding(15) var<storage, read> payloads_4: array<u32>;
@group(1) @binding(16) var<storage, read> payloads_5: array<u32>;
@group(1) @binding(17) var<storage, read> payloads_6: array<u32>;
#endif
#endif

const WORKGROUP_SIZE: u32 = 64u;
const COUNTS: u32 = 5u;
const BY_STEPS: u32 = 0u;
const BY_HI_Z: u32 = 2u;

// The state of this lane's ray.
var<private> ray: Ray;
var<private> eye_ray: EyeRay;
var<private> number: u32;
var<private> found: bool;
var<private> found_node: u32;
var<private> found_depth: f32;
var<private> found_t: f32;
var<private> capped: bool;
var<private> steps: u32;
// Loops that were begun and not ended by themselves. Mesa's software driver ends the loops of eight lanes together after
// 65,535 rounds in all; a ray that it cut off is given up like one that ran out of steps.
var<private> open: u32;
#ifdef COUNTERS
var<private> work: array<u32, 5>;
#endif

fn load_pixel(index: u32) -> u32 {
#ifdef SPLIT
    switch (number) {
        case 0u: {
            return pixels[index];
        }
        case 1u: {
            return pixels_1[index];
        }
        case 2u: {
            return pixels_2[index];
        }
        case 3u: {
            return pixels_3[index];
        }
        case 4u: {
            return pixels_4[index];
        }
        case 5u: {
            return pixels_5[index];
        }
        default: {
            return pixels_6[index];
        }
    }
#else
    return pixels[index];
#endif
}

fn load_id(index: u32) -> u32 {
#ifdef SPLIT
    switch (number) {
        case 0u: {
            return ids[index];
        }
        case 1u: {
            return ids_1[index];
        }
        case 2u: {
            return ids_2[index];
        }
        case 3u: {
            return ids_3[index];
        }
        case 4u: {
            return ids_4[index];
        }
        case 5u: {
            return ids_5[index];
        }
        default: {
            return ids_6[index];
        }
    }
#else
    return ids[index];
#endif
}

#ifdef SURFACES
fn load_payload(index: u32) -> u32 {
#ifdef SPLIT
    switch (number) {
        case 0u: {
            return payloads[index];
        }
        case 1u: {
            return payloads_1[index];
        }
        case 2u: {
            return payloads_2[index];
        }
        case 3u: {
            return payloads_3[index];
        }
        case 4u: {
            return payloads_4[index];
        }
        case 5u: {
            return payloads_5[index];
        }
        default: {
            return payloads_6[index];
        }
    }
#else
    return payloads[index];
#endif
}
#endif

// The depth of a fragment that is tested.
fn test_depth(node: u32) -> f32 {
#ifdef COUNTERS
    work[2] += 1u;
    let bit = views[number].first_node + node;
    atomicOr(&touched[bit >> 5u], 1u << (bit & 31u));
#endif
    return bitcast<f32>(load_id(node * shape.node_words));
}

fn take(node: u32, depth: f32) {
    found = true;
    found_node = node;
    found_depth = depth;
}

fn word_of(pixel: u32, word: u32) -> u32 {
    return load_pixel(pixel * shape.pixel_stride + word * views[number].word_stride);
}

fn bounds_of(pixel: u32) -> vec2<f32> {
    return depths_of(vec2<u32>(word_of(pixel, shape.bounds_word), word_of(pixel, shape.bounds_word + 1u)));
}

// Whether a ray with these depths passes outside of depth bounds (step a).
fn misses(bounds: vec2<f32>, least: f32, most: f32) -> bool {
    return most <= bounds.x * (1.0 - BOUNDS_SLACK) || least > bounds.y * (1.0 + BOUNDS_SLACK);
}

#ifdef CONTIGUOUS
// The first node of a piece with at least this depth, its end if there is none.
fn first_not_before(begin: u32, end: u32, depth: f32) -> u32 {
    var low = begin;
    var high = end;
    open += 1u;
    loop {
        if (low >= high) {
            open -= 1u;
            break;
        }
        let middle = low + (high - low) / 2u;
        if (test_depth(middle) < depth) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// A pixel's piece of the s-buffer: from the side that the ray comes from, by halving where it is long. Of equal depths the first.
fn search_fragments(pixel: u32, least: f32, most: f32, forwards: bool) {
    let begin = word_of(pixel, 0u);
    let count = word_of(pixel, 1u);
    let end = min(begin + count, views[number].node_capacity);
    if (begin >= end) {
        return;
    }
    let skipping = search.skipping == 1u;
    if (skipping && misses(vec2<f32>(test_depth(begin), test_depth(end - 1u)), least, most)) {
        return;
    }
    if (count > search.binary_search_above) {
        if (!forwards) {
            // The last before `most`, and of its depth the first.
            let behind = first_not_before(begin, end, most);
            if (behind > begin) {
                let depth = test_depth(behind - 1u);
                if (depth >= least) {
                    take(first_not_before(begin, behind, depth), depth);
                }
            }
            return;
        }
        let at = first_not_before(begin, end, least);
        if (at < end) {
            let depth = test_depth(at);
            if (depth < most) {
                take(at, depth);
            }
        }
        return;
    }
    var step = 0u;
    open += 1u;
    loop {
        if (step >= end - begin) {
            open -= 1u;
            break;
        }
        let node = select(end - 1u - step, begin + step, forwards);
        let depth = test_depth(node);
        let inside = depth >= least && depth < most;
        let passed = select((depth < least), (depth >= most), forwards);
        if ((found && (forwards || depth != found_depth)) || (skipping && passed)) {
            open -= 1u;
            break;
        }
        if (inside) {
            take(node, depth);
        }
        step += 1u;
    }
}
#else
// A list, from its head or, where it is linked both ways, from the end that the ray comes from. Of equal depths the first.
fn search_list(pixel: u32, bucket: u32, least: f32, most: f32, forwards: bool) {
    let backwards = !forwards && shape.double == 1u;
    var link = word_of(pixel, bucket + select(0u, shape.buckets, backwards));
    if (link == 0u) {
        return;
    }
    let skipping = search.skipping == 1u;
    open += 1u;
    loop {
        let node = link - 1u;
        let depth = test_depth(node);
        let inside = depth >= least && depth < most;
        if (backwards) {
            if ((found && depth != found_depth) || (skipping && depth < least)) {
                open -= 1u;
                break;
            }
            if (inside) {
                take(node, depth);
            }
        } else {
            if (inside && (!found || depth > found_depth)) {
                take(node, depth);
            }
            if ((found && forwards) || (skipping && depth >= most)) {
                open -= 1u;
                break;
            }
        }
        link = load_id(node * shape.node_words + select(1u, 2u, backwards));
        if (link == 0u) {
            open -= 1u;
            break;
        }
    }
}

// The buckets of a pixel that the ray's depths overlap (step b), in the order in which it meets them, up to the first with a
// hit (step c).
fn search_fragments(pixel: u32, least: f32, most: f32, forwards: bool) {
    var first = 0u;
    var last = shape.buckets - 1u;
    if (search.skipping == 1u) {
        if (shape.bounds_word > 0u) {
            let bounds = bounds_of(pixel);
            if (misses(bounds, least, most)) {
                return;
            }
            // A little more than what is asked for: fragments were put into buckets by another shader.
            let shares = vec2<f32>(bucket_share(least, bounds), bucket_share(most, bounds)) * f32(shape.buckets);
            let held = clamp(floor(shares + vec2<f32>(-1e-3, 1e-3)), vec2<f32>(0.0), vec2<f32>(f32(last)));
            first = u32(held.x);
            last = u32(held.y);
        } else if (shape.double == 1u) {
            let head = word_of(pixel, 0u);
            if (head == 0u) {
                return;
            }
            let tail = word_of(pixel, 1u);
            if (misses(vec2<f32>(test_depth(head - 1u), test_depth(tail - 1u)), least, most)) {
                return;
            }
        }
    }
    var opened = first;
    open += 1u;
    loop {
        search_list(pixel, select(last + first - opened, opened, forwards), least, most, forwards);
        opened += 1u;
        if (opened > last || found) {
            open -= 1u;
            break;
        }
    }
}
#endif

// The depths that fragments have which a ray between two depths meets, where each is a frustum-shaped voxel of some thickness
// (VVP16, section 4.2; DIRT, section 5.1).
fn reached(view: View, depth_begin: f32, depth_end: f32) -> vec2<f32> {
    let least = min(depth_begin, depth_end);
    let most = max(depth_begin, depth_end);
    let width = 2.0 * max(view.tan_half_width / view.size.x, view.tan_half_height / view.size.y);
    let thickness = search.thickness + most * width * search.thickness_in_pixels;
    if (search.thick_before == 1u) {
        return vec2<f32>(least, most + thickness);
    }
    return vec2<f32>(least - thickness, most);
}

// Looks at a pixel for the part of the ray between two parameters, whose eye depths these are.
fn look(pixel: vec2<u32>, part: Span, depth_begin: f32, depth_end: f32) {
    let view = views[number].view;
    let depths = reached(view, depth_begin, depth_end);
    let forwards = eye_ray.direction.z >= 0.0;
#ifdef COUNTERS
    work[0] += 1u;
    let tested = work[2];
#endif
    search_fragments(views[number].first_pixel + pixel.y * u32(view.size.x) + pixel.x, depths.x, depths.y, forwards);
#ifdef COUNTERS
    work[1] += select(0u, 1u, (work[2] > tested));
#endif
    if (found) {
        // The parameter at the fragment's depth, within the part.
        var t = part.begin;
        if (eye_ray.direction.z != 0.0) {
            t = (found_depth - eye_ray.origin.z) / eye_ray.direction.z;
        }
        found_t = clamp(clamp(t, part.begin, part.end), ray.t_min, ray.t_max);
    }
}

// Where on its line of the image the search for a ray begins: away from where the ray itself does.
fn first_place(line: ImageLine, starts: bool) -> f32 {
    return select(0.0, place_after(line, search.start_bias), starts);
}

// A number in [0, 1) that is fixed for the ray, wherever it stands in its set.
fn jitter_of() -> f32 {
    if (search.centred == 1u) {
        return 0.5;
    }
    let words = array<u32, 6>(
        bitcast<u32>(ray.origin.x), bitcast<u32>(ray.origin.y), bitcast<u32>(ray.origin.z),
        bitcast<u32>(ray.direction.x), bitcast<u32>(ray.direction.y), bitcast<u32>(ray.direction.z),
    );
    // PCG (Jarzynski, Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020), fed with one word after the other.
    var hash = 0u;
    for (var word = 0u; word < 6u; word++) {
        let state = (hash ^ words[word]) * 747796405u + 2891336453u;
        let mixed = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        hash = (mixed >> 22u) ^ mixed;
    }
    return f32(hash >> 8u) * 5.9604644775390625e-8;
}

// A number of steps of equal length on the image, fewer than asked for where no more pixels are crossed, each with the depths
// that the ray has along it and a look at one pixel.
fn march_steps(view: View, span: Span, starts: bool) {
    let line = image_line(view, eye_ray, span);
    let first = first_place(line, starts);
    let last_pixel = vec2<i32>(view.size) - 1;
    let rest = 1.0 - first;
    let count = clamp(u32(ceil(min(line.major * rest, 1e6))), 1u, search.steps);
    if (rest <= 0.0) {
        return;
    }
    let jitter = jitter_of();
    var low = first;
    var low_depth = depth_on(line, low);
    var low_t = t_on(line, low, low_depth);
    var step = 0u;
    open += 1u;
    loop {
        step += 1u;
        let high = select(first + rest * (f32(step) / f32(count)), 1.0, (step == count));
        let high_depth = depth_on(line, high);
        let high_t = t_on(line, high, high_depth);
        let at = mix(line.begin, line.end, mix(low, high, jitter));
        let pixel = clamp(vec2<i32>(floor(at)), vec2<i32>(0), last_pixel);
        var part = Span(low_t, max(low_t, high_t));
        var depths = vec2<f32>(low_depth, high_depth);
        if (search.span_by_pixel == 1u) {
            part = span_in_pixel(view, eye_ray, pixel, part);
            depths = eye_ray.origin.z + eye_ray.direction.z * vec2<f32>(part.begin, part.end);
        }
        if (part.begin <= part.end) {
            look(vec2<u32>(pixel), part, depths.x, depths.y);
        }
        low = high;
        low_depth = high_depth;
        low_t = high_t;
        if (found || step == count) {
            open -= 1u;
            break;
        }
    }
}

// Every pixel that the ray crosses; by Hi-Z up and down the pyramid, so that empty cells are crossed at once.
fn walk_pixels(view: View, whole: Span, starts: bool) {
    let origin = eye_ray.origin;
    let direction = eye_ray.direction;
    var span = whole;
    if (starts) {
        let line = image_line(view, eye_ray, whole);
        let first = first_place(line, starts);
        if (first >= 1.0) {
            return;
        }
        span.begin = clamp(t_on(line, first, depth_on(line, first)), whole.begin, whole.end);
    }
    let last_pixel = vec2<i32>(view.size) - 1;
    let heading = image_direction(eye_ray);
    let hi_z = search.march == BY_HI_Z;
    let top = select(0u, views[number].levels - 1u, hi_z);
    var t = span.begin;
    var pixel = pixel_at(view, eye_ray, t, last_pixel);
    var level = top;
    open += 1u;
    loop {
        if (steps >= search.max_steps) {
            capped = true;
            open -= 1u;
            break;
        }
        steps += 1u;
        let leaves = leaves_cell(view, eye_ray, heading, pixel, level, t);
        let end = min(min(leaves.x, leaves.y), span.end);
        let depth_begin = origin.z + direction.z * t;
        let depth_end = origin.z + direction.z * end;
        var empty = false;
        if (hi_z) {
            empty = misses_cell(view, level, vec2<u32>(pixel >> vec2<u32>(level)), depth_begin, depth_end);
            if (!empty && level > 0u) {
                level -= 1u;
                continue;
            }
        }
        if (!empty) {
            look(vec2<u32>(pixel), Span(t, end), depth_begin, depth_end);
        }
        if (found || end >= span.end) {
            open -= 1u;
            break;
        }
        pixel = next_pixel(view, eye_ray, heading, pixel, level, leaves, end, last_pixel);
        if (!is_in_image(pixel, last_pixel)) {
            open -= 1u;
            break;
        }
        t = end;
        if (empty) {
            level = min(level + 1u, top);
        }
    }
}

// Whether a cell of the pyramid has no depths that the ray has in it.
fn misses_cell(view: View, level: u32, cell: vec2<u32>, depth_begin: f32, depth_end: f32) -> bool {
    let traced = views[number];
    var codes = vec2<u32>(0u);
    if (level == 0u) {
        let pixel = traced.first_pixel + cell.y * u32(view.size.x) + cell.x;
        codes = vec2<u32>(word_of(pixel, shape.bounds_word), word_of(pixel, shape.bounds_word + 1u));
    } else {
        let index = 2u * pyramid_index(traced, level, cell);
        codes = vec2<u32>(pyramid[index], pyramid[index + 1u]);
    }
    let depths = reached(view, depth_begin, depth_end);
    return misses(depths_of(codes), depths.x, depths.y);
}

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
    var entered = 0u;
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
                for (var candidate = 0u; candidate < search.view_count; candidate++) {
                    if (views[candidate].is_face == 1u && (visited & (1u << candidate)) == 0u) {
                        crossed = crossed_first(crossed, candidate, span_in(candidate, Span(now, limit)));
                    }
                }
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
            let view = views[chosen].view;
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
                    hint = views[number].beyond[side];
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
    if (capped || open > 0u) {
        found = false;
        hits[index] = miss(STATUS_STEP_CAP);
    } else if (found) {
        hits[index] = Hit(found_t, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
    } else {
        let seen_whole = entered > 0u && (has_faces || (camera.begin <= ray.t_min && camera.end >= ray.t_max));
        hits[index] = miss(select(STATUS_LEFT_VIEWS, STATUS_MISS, seen_whole));
    }
#ifdef SURFACES
    if (found) {
#ifdef CONTIGUOUS
        var data = found_node;
        // In the s-buffer nodes are put into their order and data stays.
        if (shape.data_offset == 0u) {
            data = load_id(found_node * shape.node_words + 1u);
        }
#else
        let data = found_node;
#endif
        let at = data * shape.data_words + shape.data_offset;
        let normal = vec3<u32>(load_payload(at), load_payload(at + 1u), load_payload(at + 2u));
        let position = ray.origin + ray.direction * found_t;
        surfaces[index] = Surface(position, load_payload(at + 3u), bitcast<vec3<f32>>(normal), SURFACE_WRITTEN);
#ifdef COUNTERS
        let bit = views[number].first_node + data;
        atomicOr(&payloads_touched[bit >> 5u], 1u << (bit & 31u));
#endif
    } else {
        surfaces[index] = no_surface(SURFACE_NO_HIT);
    }
#endif
#ifdef COUNTERS
    work[3] = entered;
    for (var count = 0u; count < COUNTS; count++) {
        counts[index * COUNTS + count] = work[count];
    }
#endif
}
