#define_import_path tracebench::image_walk

// Rays on their way over the image of a view: the part that lies in the view, and where they leave lines of the image.

#import tracebench::types::Ray
#import tracebench::view::{View, to_eye_space, direction_to_eye_space}

// No ray gets there.
const NEVER: f32 = 1e38;

// A ray in a view's eye space. Its direction is as long as in the scene, so that parameters are the same.
struct EyeRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

fn eye_ray_of(view: View, ray: Ray) -> EyeRay {
    return EyeRay(to_eye_space(view, ray.origin), direction_to_eye_space(view, ray.direction));
}

// A part of a ray, by its parameter; begin > end for none.
struct Span {
    begin: f32,
    end: f32,
}

// The span in which value + slope * t >= 0, within another.
fn cut(span: Span, value: f32, slope: f32) -> Span {
    if (slope == 0.0) {
        return Span(span.begin, select(span.end, -1.0, (value < 0.0)));
    }
    let at = -value / slope;
    return Span(select(span.begin, max(span.begin, at), (slope > 0.0)), select(span.end, min(span.end, at), (slope < 0.0)));
}

// The part of a span, which begins at 0 or later, in which a ray lies in the view. `slack` widens the view: a little more than
// 1 where a ray along the seam between two views must not be lost by both to rounding.
fn span_in_view(view: View, ray: EyeRay, whole: Span, slack: f32) -> Span {
    let origin = ray.origin;
    let direction = ray.direction;
    let at = vec2<f32>(view.tan_half_width, view.tan_half_height) * slack;
    var span = cut(whole, origin.z - view.near, direction.z);
    span = cut(span, view.far - origin.z, -direction.z);
    span = cut(span, origin.z * at.x - origin.x, direction.z * at.x - direction.x);
    span = cut(span, origin.z * at.x + origin.x, direction.z * at.x + direction.x);
    span = cut(span, origin.z * at.y - origin.y, direction.z * at.y - direction.y);
    return cut(span, origin.z * at.y + origin.y, direction.z * at.y + direction.y);
}

// A step of the ray across the image: -1, 0 or 1 along x (right) and y (down). A projected line keeps its direction.
fn image_direction(ray: EyeRay) -> vec2<i32> {
    let turn = ray.direction.xy * ray.origin.z - ray.origin.xy * ray.direction.z;
    return vec2<i32>(sign(vec2<f32>(turn.x, -turn.y)));
}

// Where the lines of the image at the top left corner of a pixel meet the plane at eye depth 1. Rows count downwards, eye space
// upwards.
fn image_lines(view: View, pixel: vec2<i32>) -> vec2<f32> {
    let tangents = vec2<f32>(view.tan_half_width, view.tan_half_height);
    return (vec2<f32>(pixel) * 2.0 / view.size - 1.0) * tangents * vec2<f32>(1.0, -1.0);
}

// The t at which a ray leaves the side of the plane through the eye and a line of the image `tangent` across, not before
// `now`; NEVER for a ray that does not. `heading` is the ray's along this axis of eye space: a ray may head for a line that it
// never meets, where it runs away from the eye inside of the line.
fn leaving(tangent: f32, heading: f32, origin: f32, direction: f32, origin_z: f32, direction_z: f32, now: f32) -> f32 {
    let inside = (tangent * origin_z - origin) * heading;
    let approach = (direction - tangent * direction_z) * heading;
    if (approach <= 0.0) {
        return NEVER;
    }
    return max(now, inside / approach);
}
