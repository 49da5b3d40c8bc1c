#define_import_path tracebench::fragment_march

// Marches over the image of one view: by a number of steps, over every pixel, up and down the pyramid of depth bounds.

#import tracebench::view::View
#import tracebench::image_walk::{Span, image_direction}
#import tracebench::image_line::{ImageLine, image_line, place_after, depth_on, t_on}
#import tracebench::cell_walk::{pixel_at, leaves_cell, next_pixel, is_in_image, span_in_pixel}
#import tracebench::depth_bounds::depths_of
#import tracebench::reads::word_2
#import tracebench::fragment_layout::pyramid_index
#import tracebench::lanes::open
#import tracebench::fragment_store::{shape, search, views, ray, eye_ray, number, traced, found, found_depth, found_t, capped, steps, work, word_of, misses, looked_at, part, depth_slack, has_pieces, has_planes}
#import tracebench::fragment_search::search_fragments

const BY_STEPS: u32 = 0u;
const BY_HI_Z: u32 = 2u;

// The depths that fragments have which a ray between two depths meets, where each is a frustum-shaped voxel of some thickness
// (VVP16, section 4.2; DIRT, section 5.1).
fn reached(view: View, depth_begin: f32, depth_end: f32) -> vec2<f32> {
    let least = min(depth_begin, depth_end);
    let most = max(depth_begin, depth_end);
    if (has_planes()) {
        // They have no thickness.
        return vec2<f32>(least - depth_slack(least), most + depth_slack(most));
    }
    let width = 2.0 * max(view.tan_half_width / view.size.x, view.tan_half_height / view.size.y);
    let thickness = search.thickness + most * width * search.thickness_in_pixels;
    return vec2<f32>(least - max(thickness, 0.0), most - min(thickness, 0.0));
}

// Searches a pixel, for the part of the ray between two parameters, for fragments between these depths.
fn look(view: View, pixel: vec2<u32>, within: Span, depths: vec2<f32>) {
    let forwards = eye_ray.direction.z >= 0.0;
    looked_at = pixel;
    part = within;
#ifdef COUNTERS
    let tested = work[2];
#endif
    search_fragments(traced.first_pixel + pixel.y * u32(view.size.x) + pixel.x, depths.x, depths.y, forwards);
#ifdef COUNTERS
    work[1] += select(0u, 1u, (work[2] > tested));
#endif
    if (!has_planes() && found) {
        // The parameter at the fragment's depth, within the part.
        var t = within.begin;
        if (eye_ray.direction.z != 0.0) {
            t = (found_depth - eye_ray.origin.z) / eye_ray.direction.z;
        }
        found_t = clamp(clamp(t, within.begin, within.end), ray.t_min, ray.t_max);
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
    var word = 0u;
    for (; word < 6u; word++) {
        let state = (hash ^ words[word]) * 747796405u + 2891336453u;
        let mixed = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        hash = (mixed >> 22u) ^ mixed;
    }
    // Cut off.
    open += select(0u, 1u, (word < 6u));
    return f32(hash >> 8u) * 5.9604644775390625e-8;
}

// Whether pixels are skipped whose depth bounds the ray misses (step a), if they have any.
fn skips_pixels() -> bool {
    // Pieces of points have their ends for bounds.
    return search.skip_bounds == 1u && shape.bounds_word > 0u && (has_planes() || !has_pieces());
}

// Both marches go to the next pixel that bounds do not skip in a loop of their own, and search it outside: drivers may run every branch
// of a loop for all lanes.

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
    let skips = skips_pixels();
    var step = 0u;
    open += 1u;
    loop {
        var looks = false;
        var pixel = vec2<i32>(0);
        var within = Span(0.0, 0.0);
        var depths = vec2<f32>(0.0);
        loop {
            step += 1u;
            let high = select(first + rest * (f32(step) / f32(count)), 1.0, (step == count));
            let high_depth = depth_on(line, high);
            let high_t = t_on(line, high, high_depth);
            let at = mix(line.begin, line.end, mix(low, high, jitter));
            pixel = clamp(vec2<i32>(floor(at)), vec2<i32>(0), last_pixel);
            within = Span(low_t, max(low_t, high_t));
            depths = vec2<f32>(low_depth, high_depth);
            if (search.span_by_pixel == 1u) {
                within = span_in_pixel(view, eye_ray, pixel, within);
                depths = eye_ray.origin.z + eye_ray.direction.z * vec2<f32>(within.begin, within.end);
            }
            if (within.begin <= within.end) {
#ifdef COUNTERS
                work[0] += 1u;
#endif
                depths = reached(view, depths.x, depths.y);
                looks = !skips || !misses_cell(view, 0u, vec2<u32>(pixel), depths);
            }
            low = high;
            low_depth = high_depth;
            low_t = high_t;
            if (looks || step == count) {
                break;
            }
        }
        if (looks) {
            look(view, vec2<u32>(pixel), within, depths);
        }
        if (found || step == count) {
            open -= 1u;
            break;
        }
        // Cut off.
        if (!looks) {
            break;
        }
    }
}

// Every pixel that the ray crosses; by Hi-Z up and down the pyramid, so that empty cells are crossed at once.
fn walk_pixels(view: View, whole: Span, starts: bool) {
    let origin = eye_ray.origin;
    let direction = eye_ray.direction;
    var span = whole;
    if (starts && search.start_bias > 0.0) {
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
    let top = select(0u, traced.levels - 1u, hi_z);
    let skips = hi_z || skips_pixels();
    var t = span.begin;
    var pixel = pixel_at(view, eye_ray, t, last_pixel);
    var level = top;
    open += 1u;
    loop {
        var looks = false;
        var over = false;
        var looked = pixel;
        var within = Span(0.0, 0.0);
        var depths = vec2<f32>(0.0);
        loop {
            if (steps >= search.max_steps) {
                capped = true;
                over = true;
                break;
            }
            steps += 1u;
            let leaves = leaves_cell(view, eye_ray, heading, pixel, level, t);
            let end = min(min(leaves.x, leaves.y), span.end);
            depths = reached(view, origin.z + direction.z * t, origin.z + direction.z * end);
            let empty = skips && misses_cell(view, level, vec2<u32>(pixel >> vec2<u32>(level)), depths);
            if (!empty && level > 0u) {
                level -= 1u;
                continue;
            }
#ifdef COUNTERS
            work[0] += select(1u, 0u, empty && hi_z);
#endif
            looks = !empty;
            looked = pixel;
            within = Span(t, end);
            over = end >= span.end;
            if (!over) {
                pixel = next_pixel(view, eye_ray, heading, pixel, level, leaves, end, last_pixel);
                over = !is_in_image(pixel, last_pixel);
                t = end;
                level = select(level, min(level + 1u, top), empty);
            }
            if (looks || over) {
                break;
            }
        }
        if (looks) {
            look(view, vec2<u32>(looked), within, depths);
        }
        if (found || over) {
            open -= 1u;
            break;
        }
        // Cut off.
        if (!looks) {
            break;
        }
    }
}

// Whether a cell of the pyramid has none of these depths.
fn misses_cell(view: View, level: u32, cell: vec2<u32>, depths: vec2<f32>) -> bool {
    var codes = vec2<u32>(0u);
    if (level == 0u) {
        let pixel = traced.first_pixel + cell.y * u32(view.size.x) + cell.x;
        codes = vec2<u32>(word_of(pixel, shape.bounds_word), word_of(pixel, shape.bounds_word + 1u));
    } else {
        let index = 2u * pyramid_index(view, views[number].level_offsets[level >> 2u][level & 3u], level, cell);
        codes = vec2<u32>(word_2(index), word_2(index + 1u));
    }
    return misses(depths_of(codes), depths.x, depths.y);
}
