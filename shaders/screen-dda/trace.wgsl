// Perspective-correct DDA over a depth buffer: McGuire and Mara, "Efficient GPU Screen-Space Ray Tracing", JCGT 3(4),
// 2014, listing 1 and section 3. Along a ray's projection the position in pixels, 1/z and t/z are linear.
//
// DEEP: several layers of depth, backs behind them. HI_Z: samples that cannot hit are skipped by a pyramid of depth bounds
// (Uludag, "Hi-Z Screen-Space Cone-Traced Reflections", GPU Pro 5, 2014). A skip is of samples that lie surely in one cell and all
// before or all behind what the cell bounds, so that what is answered is the same bit for bit. Which cell a sample on a border lies in
// is told by the pixel that it reads; of a ray along a border the cells on both sides are asked.

#import tracebench::dispatch::Invocation
#import tracebench::types::{Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, STATUS_THICKNESS_REJECTED}
#import tracebench::view::{View, pixel_position}
#import tracebench::image_walk::{Span, eye_ray_of, span_in_view}
#import tracebench::image_line::between
#import tracebench::lanes::{WORKGROUP_SIZE, answer_rays}
#import tracebench::reads::{word_0, pair_0}
#import tracebench::depth_cells::{PyramidLayout, NO_SURFACE, depth_cell}

struct Settings {
    ray_count: u32,
    max_steps: u32,
    // 0: t at the step's own position (listing 1); 1: t at the stored eye depth, held within the step.
    hit_point: u32,
    // Pixels along the major axis.
    stride: f32,
    // Eye depth in scene units.
    thickness: f32,
    // Pixels along the major axis.
    start_bias: f32,
    rays_per_lane: u32,
    // Words of the images' rows, and of an image, in a buffer.
    row_words: u32,
    image_words: u32,
    // Layers of depth: the first images.
    layers: u32,
    // 1: as many images of backs follow.
    backs: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> settings: Settings;
#ifdef TEXTURES
// As they were drawn; in a buffer they are the array of words 0.
@group(0) @binding(2) var eye_depths: texture_2d_array<f32>;
#endif
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray the depth samples and, with HI_Z, the cells.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// A bit a pixel, row by row: looked at by any ray.
@group(0) @binding(6) var<storage, read_write> pixels_touched: array<atomic<u32>>;
#endif
#ifdef SURFACES
// The triangle seen at every pixel, and of every ray the one that it hit.
@group(0) @binding(7) var primitives: texture_2d_array<u32>;
@group(0) @binding(8) var<storage, read_write> seen: array<u32>;
#endif
#ifdef HI_Z
// Its cells are the array of pairs 0: near and far.
@group(0) @binding(9) var<uniform> pyramid: PyramidLayout;

// Share by which depths at the ends of a run of samples may be off those of the samples between, by rounding: some ulps.
const DEPTH_SLACK: f32 = 4e-6;
// Part of the image's edge by which positions of samples may be off the line, by rounding: some ulps.
const PLACE_SLACK: f32 = 2e-6;
#endif

// Whether there are several images.
override DEEP: bool;

fn stored_depth(image: u32, pixel: vec2<i32>) -> f32 {
#ifdef TEXTURES
    return textureLoad(eye_depths, pixel, i32(image), 0).x;
#else
    return bitcast<f32>(word_0(image * settings.image_words + u32(pixel.y) * settings.row_words + u32(pixel.x)));
#endif
}

// How deep what is stored at a depth of a layer is taken to reach.
fn end_of(layer: u32, pixel: vec2<i32>, stored: f32) -> f32 {
    if (DEEP && settings.backs == 1u) {
        let back = stored_depth(settings.layers + layer, pixel);
        if (back < NO_SURFACE) {
            return back;
        }
    }
    return stored + settings.thickness;
}

struct Answer {
    hit: Hit,
    // Depth samples, and cells of the pyramid.
    work: vec2<u32>,
    // Where the view was met, and in which layer; of hits alone.
    pixel: vec2<i32>,
    layer: u32,
}

fn no_hit(status: u32, work: vec2<u32>) -> Answer {
    return Answer(miss(status), work, vec2<i32>(0), 0u);
}

// Where on the line a sample looks, and up to where it reaches: half a step ahead; the last step takes what is left.
fn place_of(first: f32, step: f32, sample: u32) -> f32 {
    return min(first + f32(sample) * step, 1.0);
}

fn reach_of(place: f32, step: f32) -> f32 {
    return select(place + 0.5 * step, 1.0, (place + step > 1.0 || step == 1.0));
}

// The pixel that a sample reads.
fn pixel_of(position: vec2<f32>) -> vec2<i32> {
    return clamp(vec2<i32>(floor(position)), vec2<i32>(0), vec2<i32>(view.size) - 1);
}

#ifdef HI_Z
// The borders round two cells side by side, or one, pixels: left and top, right and bottom. Beyond the image's own there is nothing to be
// taken for.
fn borders_of(one: vec2<i32>, other: vec2<i32>, level: u32) -> vec4<f32> {
    let beyond = view.size + 4.0;
    let first = min(one, other);
    let low = vec2<f32>(first << vec2<u32>(level));
    let high = vec2<f32>((max(one, other) + 1) << vec2<u32>(level));
    return vec4<f32>(
        select(low, -beyond, (first == vec2<i32>(0))),
        select(high, beyond + view.size, (high >= view.size)),
    );
}

// By how much positions of samples may be off the line, pixels.
fn place_slack() -> f32 {
    return PLACE_SLACK * max(view.size.x, view.size.y);
}

// Along which axes samples lie so far apart that rounding does not change their order: what lies between two of them that read a cell
// reads it too, be they on its very borders. Along the other ones a ray may run along a border.
fn keeps_order(way: vec2<f32>) -> vec2<bool> {
    return abs(way) >= vec2<f32>(2.0 * place_slack());
}

// The cell across the border that the ray runs along, where rounding decides which of both its samples read; the same for none.
fn cell_across(at: vec2<f32>, cell: vec2<i32>, level: u32, ordered: vec2<bool>) -> vec2<i32> {
    let borders = borders_of(cell, cell, level);
    let slack = place_slack();
    let before = select(vec2<i32>(0), vec2<i32>(1), at < borders.xy + slack);
    let behind = select(vec2<i32>(0), vec2<i32>(1), at > borders.zw - slack);
    return cell + select(behind - before, vec2<i32>(0), ordered);
}

// Whether a position lies within borders by more than rounding moves it, along axes that need it.
fn is_within(at: vec2<f32>, borders: vec4<f32>, ordered: vec2<bool>) -> bool {
    let slack = place_slack();
    let clear = (at >= borders.xy + slack) & (at <= borders.zw - slack);
    return all(clear | ordered);
}

// Whether a sample reads a pixel of one of two cells.
fn reads_one_of(at: vec2<f32>, one: vec2<i32>, other: vec2<i32>, level: u32) -> bool {
    let cell = pixel_of(at) >> vec2<u32>(level);
    return all(cell == one) || all(cell == other);
}

// Samples from a position on that lie within borders, by their way between one and the next: one at least, and one too many where the
// last of them falls on a border.
fn samples_within(at: vec2<f32>, way: vec2<f32>, borders: vec4<f32>, ordered: vec2<bool>) -> u32 {
    let slack = place_slack();
    let margin = select(vec2<f32>(-slack), vec2<f32>(slack), ordered);
    let left = select(at - borders.xy, borders.zw - at, (way > vec2<f32>(0.0))) + margin;
    let steps = select(vec2<f32>(65536.0), left / max(abs(way), vec2<f32>(1e-6)), (abs(way) > vec2<f32>(1e-6)));
    return u32(clamp(min(steps.x, steps.y), 0.0, 65535.0)) + 1u;
}

// The level of the next cell: one up where the ray comes into another one of the level above, which it has not asked yet. It does not come
// into those that it runs along.
fn next_level(pixel: vec2<i32>, position: vec2<f32>, level: u32, ordered: vec2<bool>) -> u32 {
    let next = pixel_of(position);
    let above = vec2<u32>(level + 1u);
    let crosses = any(((pixel >> above) != (next >> above)) & ordered) && level + 1u < pyramid.levels;
    return select(level, level + 1u, crosses);
}

// What depths of a ray are to what a cell bounds in every layer.
const MEETS: u32 = 0u;
const ALL_BEFORE: u32 = 1u;
const SOME_BEHIND: u32 = 2u;

fn compare_to_cell(level: u32, cell: vec2<u32>, nearest: f32, farthest: f32) -> u32 {
    var found = ALL_BEFORE;
    var layer = 0u;
    loop {
        let bounds = bitcast<vec2<f32>>(pair_0(depth_cell(pyramid, layer, level, cell)));
        var end = bounds.y + settings.thickness;
        if (DEEP && settings.backs == 1u) {
            end = max(end, bitcast<f32>(pair_0(depth_cell(pyramid, settings.layers + layer, level, cell)).y));
        }
        if (!(farthest < bounds.x)) {
            if (!(nearest > end)) {
                return MEETS;
            }
            found = SOME_BEHIND;
        }
        layer += 1u;
        if (!DEEP || layer >= settings.layers) {
            break;
        }
    }
    return found;
}
#endif

fn march(ray: Ray) -> Answer {
    let eye_ray = eye_ray_of(view, ray);
    let origin = eye_ray.origin;
    let direction = eye_ray.direction;
    let part = span_in_view(view, eye_ray, Span(ray.t_min, ray.t_max), 1.0);
    let span = vec2<f32>(part.begin, part.end);
    if (!(span.x < span.y)) {
        return no_hit(STATUS_LEFT_VIEWS, vec2<u32>(0u));
    }
    let begin = origin + span.x * direction;
    let end = origin + span.y * direction;
    // Rounding may leave the clipped ends a little before the near plane.
    let k = vec2<f32>(1.0 / max(begin.z, view.near), 1.0 / max(end.z, view.near));
    let t_over_z = span * k;
    let pixel_begin = pixel_position(view, begin);
    let pixel_end = pixel_position(view, end);
    let along = abs(pixel_end - pixel_begin);
    let major = max(along.x, along.y);
    // A ray that stays within a stride (every primary ray does) is one step.
    let step = min(settings.stride / max(major, 1e-6), 1.0);
    // The bias keeps rays that start on a surface from finding it; a ray that enters the view from outside needs none.
    let starts_inside = span.x <= ray.t_min;
    let first = select(0.0, min(settings.start_bias / max(major, 1e-6), 1.0), starts_inside);

    // Of the next sample: its number, where it begins and where it looks.
    var sample = 0u;
    var low = first;
    var s = first;
    var work = vec2<u32>(0u);
    var behind_a_surface = false;
#ifdef HI_Z
    let way = (pixel_end - pixel_begin) * step;
    let ordered = keeps_order(way);
    // Rays start on surfaces: a coarse cell would say nothing.
    var level = 0u;
#endif
    while (low < 1.0) {
        if (sample >= settings.max_steps) {
            return no_hit(STATUS_STEP_CAP, work);
        }
        let position = mix(pixel_begin, pixel_end, s);
        let pixel = pixel_of(position);
#ifdef HI_Z
        if (level > 0u) {
            work.y += 1u;
            let cell = pixel >> vec2<u32>(level);
            let other = cell_across(position, cell, level, ordered);
            let borders = borders_of(cell, other, level);
            var count = min(samples_within(position, way, borders, ordered), settings.max_steps - sample);
            var last = place_of(first, step, sample + count - 1u);
            if (count > 1u && !reads_one_of(mix(pixel_begin, pixel_end, last), cell, other, level)) {
                count -= 1u;
                last = place_of(first, step, sample + count - 1u);
            }
            let last_position = mix(pixel_begin, pixel_end, last);
            // The ray's end may lie closer behind a sample than samples behind each other.
            let last_ordered = ordered & vec2<bool>(last < 1.0);
            if (is_within(position, borders, ordered) && is_within(last_position, borders, last_ordered)
                && reads_one_of(last_position, cell, other, level)) {
                let reach = reach_of(last, step);
                let depths = 1.0 / vec2<f32>(between(k, low), between(k, reach));
                let nearest = min(depths.x, depths.y) * (1.0 - DEPTH_SLACK);
                let farthest = max(depths.x, depths.y) * (1.0 + DEPTH_SLACK);
                var compared = compare_to_cell(level, vec2<u32>(cell), nearest, farthest);
                if (compared != MEETS && any(other != cell)) {
                    work.y += 1u;
                    // Of which it is behind some only the samples could tell.
                    let beside = compare_to_cell(level, vec2<u32>(other), nearest, farthest);
                    compared = select(MEETS, compared, beside == compared);
                }
                if (compared != MEETS) {
                    behind_a_surface = behind_a_surface || (compared == SOME_BEHIND);
                    sample += count;
                    low = reach;
                    s = place_of(first, step, sample);
                    level = next_level(pixel, mix(pixel_begin, pixel_end, s), level, ordered);
                    continue;
                }
            }
            level -= 1u;
            continue;
        }
#endif
        let high = reach_of(s, step);
        sample += 1u;
        work.x += 1u;
#ifdef COUNTERS
        let place = u32(pixel.y) * u32(view.size.x) + u32(pixel.x);
        atomicOr(&pixels_touched[place >> 5u], 1u << (place & 31u));
#endif
        let k_low = between(k, low);
        let k_high = between(k, high);
        let nearest = min(1.0 / k_low, 1.0 / k_high);
        let farthest = max(1.0 / k_low, 1.0 / k_high);
        var layer = 0u;
        var each = 0u;
        loop {
            // The layer that the ray meets first: the nearest, or from behind the farthest.
            layer = select(each, settings.layers - 1u - each, DEEP && direction.z < 0.0);
            let stored = stored_depth(layer, pixel);
            let reaches = end_of(layer, pixel, stored);
            if (farthest >= stored && nearest <= reaches) {
                let t_low = between(t_over_z, low) / k_low;
                let t_high = between(t_over_z, high) / k_high;
                var t = between(t_over_z, s) / between(k, s);
                // A ray that falls on one pixel has no other position than the stored depth.
                if ((settings.hit_point == 1u || step == 1.0) && direction.z != 0.0) {
                    t = (stored - origin.z) / direction.z;
                }
                t = clamp(clamp(t, t_low, t_high), ray.t_min, ray.t_max);
                return Answer(Hit(t, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT), work, pixel, layer);
            }
            behind_a_surface = behind_a_surface || (nearest > reaches);
            each += 1u;
            if (!DEEP || each >= settings.layers) {
                break;
            }
        }
        low = high;
        s = place_of(first, step, sample);
#ifdef HI_Z
        level = next_level(pixel, mix(pixel_begin, pixel_end, s), 0u, ordered);
#endif
    }
    if (behind_a_surface) {
        return no_hit(STATUS_THICKNESS_REJECTED, work);
    }
    let seen_whole = starts_inside && span.y >= ray.t_max;
    return no_hit(select(STATUS_LEFT_VIEWS, STATUS_MISS, seen_whole), work);
}

override fn tracebench::lanes::answer_ray(index: u32) {
    let answer = march(rays[index]);
    hits[index] = answer.hit;
#ifdef COUNTERS
#ifdef HI_Z
    counts[2u * index] = answer.work.x;
    counts[2u * index + 1u] = answer.work.y;
#else
    counts[index] = answer.work.x;
#endif
#endif
#ifdef SURFACES
    seen[index] = textureLoad(primitives, answer.pixel, i32(answer.layer), 0).x;
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, settings.ray_count, settings.rays_per_lane);
}
