// Walks rays over images and through views, so that a test can compare the shared functions with f64.

#import tracebench::types::Ray
#import tracebench::view::View
#import tracebench::image_walk::{EyeRay, Span, eye_ray_of, span_in_view, image_direction}
#import tracebench::image_line::{image_line, place_after, depth_on, t_on}
#import tracebench::cell_walk::{pixel_at, leaves_cell, next_pixel, is_in_image, span_in_pixel}
#import tracebench::view_walk::{crossed_first, nothing_crossed, side_left}

struct Task {
    view: View,
    ray: Ray,
    // Of spans.
    slack: f32,
    // Levels of the pyramid that is walked, and which of them a step is at.
    levels: u32,
    seed: u32,
    // Of lines, along the major axis.
    pixels: f32,
}

// A step of a walk. `after`: 1 where it goes on, 2 at the span's end, 3 where the image ends; 0 for no step.
struct Piece {
    pixel: vec2<i32>,
    begin: f32,
    end: f32,
    level: u32,
    after: u32,
}

const MAX_PIECES: u32 = 96u;

@group(0) @binding(0) var<storage, read> tasks: array<Task>;
@group(0) @binding(1) var<storage, read_write> spans: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> pieces: array<Piece>;
@group(0) @binding(3) var<storage, read_write> lines: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> offered: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> chosen: array<u32>;

fn span_of(task: Task, ray: EyeRay) -> Span {
    return span_in_view(task.view, ray, Span(task.ray.t_min, task.ray.t_max), task.slack);
}

// The part of the ray in the view, and the side by which it leaves that.
@compute @workgroup_size(64)
fn enter(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&tasks)) {
        return;
    }
    let task = tasks[id.x];
    let ray = eye_ray_of(task.view, task.ray);
    let span = span_of(task, ray);
    spans[id.x] = vec4<f32>(span.begin, span.end, f32(side_left(task.view, ray)), 0.0);
}

@compute @workgroup_size(64)
fn walk(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&tasks)) {
        return;
    }
    let task = tasks[id.x];
    let view = task.view;
    let ray = eye_ray_of(view, task.ray);
    let span = span_of(task, ray);
    if (span.begin > span.end) {
        return;
    }
    let last = vec2<i32>(view.size) - 1;
    let heading = image_direction(ray);
    var pixel = pixel_at(view, ray, span.begin, last);
    var t = span.begin;
    for (var step = 0u; step < MAX_PIECES; step++) {
        let level = ((task.seed * (step + 1u)) >> 16u) % task.levels;
        let leaves = leaves_cell(view, ray, heading, pixel, level, t);
        let end = min(min(leaves.x, leaves.y), span.end);
        let next = next_pixel(view, ray, heading, pixel, level, leaves, end, last);
        var after = select(1u, 3u, !is_in_image(next, last));
        after = select(after, 2u, (end >= span.end));
        pieces[id.x * MAX_PIECES + step] = Piece(pixel, t, end, level, after);
        if (after != 1u) {
            return;
        }
        pixel = next;
        t = end;
    }
}

// Of the ray's line of the image: pixel, t and eye depth at a place; what it spends within that pixel.
@compute @workgroup_size(64)
fn follow(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&tasks)) {
        return;
    }
    let task = tasks[id.x];
    let ray = eye_ray_of(task.view, task.ray);
    let span = span_of(task, ray);
    if (span.begin > span.end) {
        return;
    }
    let line = image_line(task.view, ray, span);
    let place = place_after(line, task.pixels);
    let depth = depth_on(line, place);
    let at = mix(line.begin, line.end, place);
    lines[id.x * 2u] = vec4<f32>(at, t_on(line, place, depth), depth);
    let pixel = clamp(vec2<i32>(floor(at)), vec2<i32>(0), vec2<i32>(task.view.size) - 1);
    let part = span_in_pixel(task.view, ray, pixel, span);
    lines[id.x * 2u + 1u] = vec4<f32>(vec2<f32>(pixel), part.begin, part.end);
}

// Of four spans offered one after the other, two a vector, the view of the first.
@compute @workgroup_size(64)
fn choose(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&chosen)) {
        return;
    }
    var crossed = nothing_crossed(9u);
    for (var view = 0u; view < 4u; view++) {
        let two = offered[id.x * 2u + view / 2u];
        let span = select(two.xy, two.zw, (view % 2u == 1u));
        crossed = crossed_first(crossed, view, Span(span.x, span.y));
    }
    chosen[id.x] = crossed.view;
}
