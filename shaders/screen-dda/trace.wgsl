// Perspective-correct DDA over a depth buffer: McGuire and Mara, "Efficient GPU Screen-Space Ray Tracing", JCGT 3(4),
// 2014, listing 1 and section 3. Along a ray's projection the position in pixels, 1/z and t/z are linear.

#import tracebench::types::{Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, STATUS_THICKNESS_REJECTED}
#import tracebench::view::{View, pixel_position}
#import tracebench::image_walk::{Span, eye_ray_of, span_in_view}
#import tracebench::image_line::between
#import tracebench::lanes::{WORKGROUP_SIZE, turns_of}
#import tracebench::reads::word_0

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
    // Words of the image's rows in a buffer.
    row_words: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> settings: Settings;
#ifdef TEXTURES
// As it was drawn; in a buffer it is the array of words 0.
@group(0) @binding(2) var eye_depths: texture_2d<f32>;
#endif
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
@group(0) @binding(5) var<storage, read_write> depth_samples: array<u32>;
// A bit a pixel, row by row: looked at by any ray.
@group(0) @binding(6) var<storage, read_write> pixels_touched: array<atomic<u32>>;
#endif
#ifdef SURFACES
// The triangle seen at every pixel, and of every ray the one that it hit.
@group(0) @binding(7) var primitives: texture_2d<u32>;
@group(0) @binding(8) var<storage, read_write> seen: array<u32>;
#endif

fn stored_depth(pixel: vec2<i32>) -> f32 {
#ifdef TEXTURES
    return textureLoad(eye_depths, pixel, 0).x;
#else
    return bitcast<f32>(word_0(u32(pixel.y) * settings.row_words + u32(pixel.x)));
#endif
}

struct Answer {
    hit: Hit,
    samples: u32,
    // Where the view was met; of hits alone.
    pixel: vec2<i32>,
}

fn no_hit(status: u32, samples: u32) -> Answer {
    return Answer(miss(status), samples, vec2<i32>(0));
}

fn march(ray: Ray) -> Answer {
    let eye_ray = eye_ray_of(view, ray);
    let origin = eye_ray.origin;
    let direction = eye_ray.direction;
    let part = span_in_view(view, eye_ray, Span(ray.t_min, ray.t_max), 1.0);
    let span = vec2<f32>(part.begin, part.end);
    if (!(span.x < span.y)) {
        return no_hit(STATUS_LEFT_VIEWS, 0u);
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

    let last_pixel = vec2<i32>(view.size) - vec2<i32>(1);
    var samples = 0u;
    var behind_a_surface = false;
    var low = first;
    var s = first;
    while (low < 1.0) {
        if (samples >= settings.max_steps) {
            return no_hit(STATUS_STEP_CAP, samples);
        }
        // The part of the ray up to half a step ahead; the last step takes what is left.
        let high = select(s + 0.5 * step, 1.0, (s + step > 1.0 || step == 1.0));
        let pixel = clamp(vec2<i32>(floor(mix(pixel_begin, pixel_end, s))), vec2<i32>(0), last_pixel);
        let stored = stored_depth(pixel);
        samples += 1u;
#ifdef COUNTERS
        let place = u32(pixel.y) * u32(view.size.x) + u32(pixel.x);
        atomicOr(&pixels_touched[place >> 5u], 1u << (place & 31u));
#endif
        let k_low = between(k, low);
        let k_high = between(k, high);
        let nearest = min(1.0 / k_low, 1.0 / k_high);
        let farthest = max(1.0 / k_low, 1.0 / k_high);
        if (farthest >= stored && nearest <= stored + settings.thickness) {
            let t_low = between(t_over_z, low) / k_low;
            let t_high = between(t_over_z, high) / k_high;
            var t = between(t_over_z, s) / between(k, s);
            // A ray that falls on one pixel has no other position than the stored depth.
            if ((settings.hit_point == 1u || step == 1.0) && direction.z != 0.0) {
                t = (stored - origin.z) / direction.z;
            }
            t = clamp(clamp(t, t_low, t_high), ray.t_min, ray.t_max);
            return Answer(Hit(t, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT), samples, pixel);
        }
        behind_a_surface = behind_a_surface || (nearest > stored + settings.thickness);
        low = high;
        s = min(first + f32(samples) * step, 1.0);
    }
    if (behind_a_surface) {
        return no_hit(STATUS_THICKNESS_REJECTED, samples);
    }
    let seen_whole = starts_inside && span.y >= ray.t_max;
    return no_hit(select(STATUS_LEFT_VIEWS, STATUS_MISS, seen_whole), samples);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    var turns =
        turns_of(workgroup, workgroups, local, 0u, settings.ray_count, settings.rays_per_lane);
    while (turns.ray < turns.end) {
        let answer = march(rays[turns.ray]);
        hits[turns.ray] = answer.hit;
#ifdef COUNTERS
        depth_samples[turns.ray] = answer.samples;
#endif
#ifdef SURFACES
        seen[turns.ray] = textureLoad(primitives, answer.pixel, 0).x;
#endif
        turns.ray += WORKGROUP_SIZE;
    }
}
