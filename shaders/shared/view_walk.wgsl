#define_import_path tracebench::view_walk

// A ray's way through several views, in the order in which it crosses them.

#import tracebench::view::View
#import tracebench::image_walk::{EyeRay, NEVER, Span}

// So far beyond a side that a ray along the seam between two views is not lost by both to rounding.
const SEAM_SLACK: f32 = 1.000002;

// A view and the part of the ray that lies in it.
struct Crossed {
    view: u32,
    span: Span,
}

// No view yet; `none` is a number that no view has.
fn nothing_crossed(none: u32) -> Crossed {
    return Crossed(none, Span(NEVER, -NEVER));
}

// Of what was crossed first so far and another view, which has this part of the ray, what is crossed first; of both at once the
// former.
fn crossed_first(first: Crossed, view: u32, part: Span) -> Crossed {
    if (part.begin <= part.end && part.begin < first.span.begin) {
        return Crossed(view, part);
    }
    return first;
}

// The sides of a view's frustum: right, left, upper and lower one are 0 to 3.
const FAR_SIDE: u32 = 4u;
const NEAR_SIDE: u32 = 5u;
const NO_SIDE: u32 = 6u;

// The side by which a ray that is in the view leaves it, where the frustum is widened by SEAM_SLACK; of several at once the
// first. NO_SIDE where it never does.
fn side_left(view: View, ray: EyeRay) -> u32 {
    let origin = ray.origin;
    let direction = ray.direction;
    let tangents = vec2<f32>(view.tan_half_width, view.tan_half_height) * SEAM_SLACK;
    // How fast the ray approaches right, left, upper and lower side, and how far it is from them.
    let away = vec4<f32>(
        tangents.x * origin.z - origin.x, tangents.x * origin.z + origin.x,
        tangents.y * origin.z - origin.y, tangents.y * origin.z + origin.y,
    );
    let approach = vec4<f32>(
        direction.x - tangents.x * direction.z, -direction.x - tangents.x * direction.z,
        direction.y - tangents.y * direction.z, -direction.y - tangents.y * direction.z,
    );
    var least = NEVER;
    var left = NO_SIDE;
    for (var side = 0u; side < 4u; side++) {
        let at = select(NEVER, away[side] / approach[side], (approach[side] > 0.0));
        if (at < least) {
            least = at;
            left = side;
        }
    }
    let to_far = select(NEVER, (view.far - origin.z) / direction.z, (direction.z > 0.0));
    let to_near = select(NEVER, (view.near - origin.z) / direction.z, (direction.z < 0.0));
    if (to_far < least) {
        return FAR_SIDE;
    }
    return select(left, NEAR_SIDE, (to_near < least));
}
