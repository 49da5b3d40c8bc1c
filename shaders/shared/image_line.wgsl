#define_import_path tracebench::image_line

// A part of a ray as a line of the image, along which pixels, 1 / depth and t / depth are linear (McGuire and Mara, JCGT 3(4),
// 2014, section 3). Places on it run from 0 to 1.

#import tracebench::view::{View, pixel_position}
#import tracebench::image_walk::{EyeRay, Span}

struct ImageLine {
    // Pixels.
    begin: vec2<f32>,
    end: vec2<f32>,
    // At both ends.
    inverse_depths: vec2<f32>,
    ts_over_depth: vec2<f32>,
    // Pixels along the major axis.
    major: f32,
}

// The span lies in the view.
fn image_line(view: View, ray: EyeRay, span: Span) -> ImageLine {
    let begin = ray.origin + ray.direction * span.begin;
    let end = ray.origin + ray.direction * span.end;
    // Rounding may leave the clipped ends a little before the near plane.
    let depths = max(vec2<f32>(begin.z, end.z), vec2<f32>(view.near));
    let first_pixel = pixel_position(view, vec3<f32>(begin.xy, depths.x));
    let last_pixel = pixel_position(view, vec3<f32>(end.xy, depths.y));
    let along = abs(last_pixel - first_pixel);
    let ts_over_depth = vec2<f32>(span.begin, span.end) / depths;
    return ImageLine(first_pixel, last_pixel, 1.0 / depths, ts_over_depth, max(along.x, along.y));
}

// The place so many pixels along the major axis from the beginning, at most the end.
fn place_after(line: ImageLine, pixels: f32) -> f32 {
    return min(pixels / max(line.major, 1e-6), 1.0);
}

// Between two values, exact at both ends. The built-in mix may be a + (b - a) * share, which is not: by it the far end of a ray that
// begins near the eye has no depth.
fn between(ends: vec2<f32>, share: f32) -> f32 {
    return ends.x * (1.0 - share) + ends.y * share;
}

fn depth_on(line: ImageLine, place: f32) -> f32 {
    return 1.0 / between(line.inverse_depths, place);
}

// The parameter at a place, whose depth is known.
fn t_on(line: ImageLine, place: f32, depth: f32) -> f32 {
    return between(line.ts_over_depth, place) * depth;
}
