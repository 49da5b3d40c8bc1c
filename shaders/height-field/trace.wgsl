// A depth buffer as a height field under rays: Tevs, Ihrke and Seidel, "Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic
// Height Field Rendering", I3D 2008, in its iterative form without bilinear patches, as WKP15 (section 5.1) measured it. A ray goes
// down and up a pyramid over the depths. In a cell whose nearest depth it does not reach there is nothing; a pixel is a column whose
// top is its stored depth, and all behind that is solid. Where a ray comes behind a top within a pixel is found by halving, or, as the top
// is level, at once.
//
// MIN_MAX: cells bound the farthest depth, too: a ray that enters one behind that is in solid wherever it is in it.

#import tracebench::dispatch::Invocation
#import tracebench::types::{Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS}
#import tracebench::view::View
#import tracebench::image_walk::{EyeRay, Span, cut, eye_ray_of, span_in_view, image_direction}
#import tracebench::image_line::{image_line, place_after, depth_on, t_on}
#import tracebench::cell_walk::{pixel_at, leaves_cell, next_pixel, is_in_image}
#import tracebench::lanes::{WORKGROUP_SIZE, answer_rays}
#import tracebench::reads::{word_0, word_1, pair_0}
#import tracebench::depth_cells::{PyramidLayout, NO_SURFACE, depth_cell}

struct HeightSettings {
    ray_count: u32,
    // Halvings of the part of a ray in the pixel where it hits.
    refinement: u32,
    rays_per_lane: u32,
    // Words of the image's rows in a buffer.
    row_words: u32,
    // Pixels along the major axis.
    start_bias: f32,
    // 1: hits are placed where the ray is as deep as the top.
    closed: u32,
    // 1: rays are cut before the nearest depth.
    depth_clip: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> settings: HeightSettings;
#ifdef TEXTURES
// As it was drawn; in a buffer it is the array of words 0.
@group(0) @binding(2) var eye_depths: texture_2d_array<f32>;
#endif
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray the cells of all levels, and the pixels among them.
@group(0) @binding(5) var<storage, read_write> counts: array<vec2<u32>>;
// A bit a pixel, row by row, and then one a cell: visited by any ray.
@group(0) @binding(6) var<storage, read_write> cells_touched: array<atomic<u32>>;
#endif
#ifdef SURFACES
// The triangle seen at every pixel, and of every ray the one that it hit.
@group(0) @binding(7) var primitives: texture_2d_array<u32>;
@group(0) @binding(8) var<storage, read_write> seen: array<u32>;
#endif
// Its cells are the array of pairs 0, near and far, or of words 1, near alone.
@group(0) @binding(9) var<uniform> pyramid: PyramidLayout;

fn stored_depth(pixel: vec2<i32>) -> f32 {
#ifdef TEXTURES
    return textureLoad(eye_depths, pixel, 0, 0).x;
#else
    return bitcast<f32>(word_0(u32(pixel.y) * settings.row_words + u32(pixel.x)));
#endif
}

// Share of depths by which rays are cut off before the nearest one.
const CLIP_SLACK: f32 = 4e-6;

// The cell of a level above the pixels that holds a pixel.
fn cell_number(level: u32, pixel: vec2<i32>) -> u32 {
    let offset = pyramid.level_offsets[level >> 2u][level & 3u];
    return depth_cell(pyramid, offset, 0u, level, vec2<u32>(pixel >> vec2<u32>(level)));
}

// Near and far of a cell; of a pixel both are its depth. Without MIN_MAX a cell has no far.
fn bounds_of(level: u32, pixel: vec2<i32>) -> vec2<f32> {
    if (level == 0u) {
        return vec2<f32>(stored_depth(pixel));
    }
    let index = cell_number(level, pixel);
#ifdef MIN_MAX
    return bitcast<vec2<f32>>(pair_0(index));
#else
    return vec2<f32>(bitcast<f32>(word_1(index)), NO_SURFACE);
#endif
}

struct Answer {
    hit: Hit,
    work: vec2<u32>,
    // Where the view was met; of hits alone.
    pixel: vec2<i32>,
}

fn eye_depth(ray: EyeRay, t: f32) -> f32 {
    return ray.origin.z + ray.direction.z * t;
}

// Where within a part, which begins before a depth and ends behind it, the ray comes behind it.
fn crossing(ray: EyeRay, part: Span, depth: f32) -> f32 {
    if (settings.closed == 1u) {
        return clamp((depth - ray.origin.z) / ray.direction.z, part.begin, part.end);
    }
    var before = part.begin;
    var behind = part.end;
    for (var halving = 0u; halving < settings.refinement; halving++) {
        let middle = 0.5 * (before + behind);
        if (eye_depth(ray, middle) >= depth) {
            behind = middle;
        } else {
            before = middle;
        }
    }
    return behind;
}

fn search(ray: Ray) -> Answer {
    let eye_ray = eye_ray_of(view, ray);
    var whole = span_in_view(view, eye_ray, Span(ray.t_min, ray.t_max), 1.0);
    var work = vec2<u32>(0u);
    if (!(whole.begin < whole.end)) {
        return Answer(miss(STATUS_LEFT_VIEWS), work, vec2<i32>(0));
    }
    let starts_inside = whole.begin <= ray.t_min;
    let nothing = miss(select(STATUS_LEFT_VIEWS, STATUS_MISS, (starts_inside && whole.end >= ray.t_max)));
    var t = whole.begin;
    if (starts_inside && settings.start_bias > 0.0) {
        let line = image_line(view, eye_ray, whole);
        let first = place_after(line, settings.start_bias);
        if (first >= 1.0) {
            return Answer(nothing, work, vec2<i32>(0));
        }
        t = clamp(t_on(line, first, depth_on(line, first)), whole.begin, whole.end);
    }
    let top = pyramid.levels - 1u;
    if (settings.depth_clip == 1u) {
        // Nothing lies before it; by so much rounding may move depths of the ray.
        let nearest = bounds_of(top, vec2<i32>(0)).x;
        let slack = CLIP_SLACK * (nearest + abs(eye_ray.origin.z));
        whole = cut(Span(t, whole.end), eye_ray.origin.z - (nearest - slack), eye_ray.direction.z);
        if (whole.begin > whole.end) {
            return Answer(nothing, work, vec2<i32>(0));
        }
        t = whole.begin;
    }
    let last_pixel = vec2<i32>(view.size) - 1;
    let heading = image_direction(eye_ray);
    var pixel = pixel_at(view, eye_ray, t, last_pixel);
    var level = top;
    loop {
        work.x += 1u;
        work.y += select(0u, 1u, (level == 0u));
#ifdef COUNTERS
        let width = u32(view.size.x);
        var place = u32(pixel.y) * width + u32(pixel.x);
        if (level > 0u) {
            place = width * u32(view.size.y) + cell_number(level, pixel);
        }
        atomicOr(&cells_touched[place >> 5u], 1u << (place & 31u));
#endif
        let leaves = leaves_cell(view, eye_ray, heading, pixel, level, t);
        let end = min(min(leaves.x, leaves.y), whole.end);
        let bounds = bounds_of(level, pixel);
        let entered_at = eye_depth(eye_ray, t);
        if (max(entered_at, eye_depth(eye_ray, end)) >= bounds.x) {
            // In solid at once; of a ray that starts there that is its start.
            let in_solid = entered_at >= bounds.y;
            if (in_solid || level == 0u) {
                var found = t;
                if (!in_solid) {
                    found = crossing(eye_ray, Span(t, end), bounds.x);
                }
                let hit = Hit(clamp(found, ray.t_min, ray.t_max), NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
                return Answer(hit, work, pixel);
            }
            level -= 1u;
            continue;
        }
        if (end >= whole.end) {
            break;
        }
        let next = next_pixel(view, eye_ray, heading, pixel, level, leaves, end, last_pixel);
        if (!is_in_image(next, last_pixel)) {
            break;
        }
        // Up where the ray comes into another cell of the level above, which it has not asked yet.
        let above = vec2<u32>(level + 1u);
        level += select(0u, 1u, ((level < top) && any((pixel >> above) != (next >> above))));
        pixel = next;
        t = end;
    }
    return Answer(nothing, work, vec2<i32>(0));
}

override fn tracebench::lanes::answer_ray(index: u32) {
    let answer = search(rays[index]);
    hits[index] = answer.hit;
#ifdef COUNTERS
    counts[index] = answer.work;
#endif
#ifdef SURFACES
    seen[index] = textureLoad(primitives, answer.pixel, 0, 0).x;
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, settings.ray_count, settings.rays_per_lane);
}
