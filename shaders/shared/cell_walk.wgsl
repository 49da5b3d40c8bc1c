#define_import_path tracebench::cell_walk

// A ray's walk over the cells of an image, in the order in which it crosses them. Cells of level 0 are the image's pixels (or
// whatever its view's size counts), those of a level are squares of two by two of the level below. A walk is
//
//     var pixel = pixel_at(view, ray, span.begin, last);
//     loop {
//         let leaves = leaves_cell(view, ray, heading, pixel, level, t);
//         let end = min(min(leaves.x, leaves.y), span.end);
//         // The ray is in the cell from t to end. To look closer, lower the level and begin again; else:
//         if (end >= span.end) { break; }
//         pixel = next_pixel(view, ray, heading, pixel, level, leaves, end, last);
//         if (!is_in_image(pixel, last)) { break; }
//         t = end;
//     }
//
// with heading = image_direction(ray). It never steps back: after as many steps of one level as the image is wide and high in its
// cells it has ended, whatever rounding did. `last` is the image's last pixel.

#import tracebench::view::{View, pixel_position}
#import tracebench::image_walk::{EyeRay, NEVER, Span, image_direction, image_lines, leaving}

// The pixel that the ray is in, held within the image.
fn pixel_at(view: View, ray: EyeRay, t: f32, last: vec2<i32>) -> vec2<i32> {
    return clamp(vec2<i32>(floor(pixel_position(view, ray.origin + ray.direction * t))), vec2<i32>(0), last);
}

// The parameters, not before `now`, at which a ray leaves a pixel's cell across its upright and its level side; NEVER where it
// does not.
fn leaves_cell(view: View, ray: EyeRay, heading: vec2<i32>, pixel: vec2<i32>, level: u32, now: f32) -> vec2<f32> {
    let cell = pixel >> vec2<u32>(level);
    let line = image_lines(view, (cell + max(heading, vec2<i32>(0))) << vec2<u32>(level));
    let origin = ray.origin;
    let direction = ray.direction;
    var leaves = vec2<f32>(NEVER);
    if (heading.x != 0) {
        leaves.x = leaving(line.x, f32(heading.x), origin.x, direction.x, origin.z, direction.z, now);
    }
    if (heading.y != 0) {
        // Rows count downwards, eye space upwards.
        leaves.y = leaving(line.y, -f32(heading.y), origin.y, direction.y, origin.z, direction.z, now);
    }
    return leaves;
}

// The first pixel of the walk behind a pixel's cell: across the nearer of its two sides (the upright one of both at once), and
// along the other axis where the ray is at `end`, never back and never out of the cell. Outside of the image where the ray
// leaves that.
fn next_pixel(
    view: View,
    ray: EyeRay,
    heading: vec2<i32>,
    pixel: vec2<i32>,
    level: u32,
    leaves: vec2<f32>,
    end: f32,
    last: vec2<i32>,
) -> vec2<i32> {
    let cell = pixel >> vec2<u32>(level);
    let at = vec2<i32>(floor(pixel_position(view, ray.origin + ray.direction * end)));
    let low = max(cell << vec2<u32>(level), select(vec2<i32>(-1), pixel, (heading > vec2<i32>(0))));
    let high = min(((cell + 1) << vec2<u32>(level)) - 1, select(last, pixel, (heading < vec2<i32>(0))));
    var next = clamp(at, low, min(high, last));
    if (leaves.x <= leaves.y) {
        next.x = select((cell.x << level) - 1, (cell.x + 1) << level, (heading.x > 0));
    } else {
        next.y = select((cell.y << level) - 1, (cell.y + 1) << level, (heading.y > 0));
    }
    return next;
}

fn is_in_image(pixel: vec2<i32>, last: vec2<i32>) -> bool {
    return all(pixel >= vec2<i32>(0)) && all(pixel <= last);
}

// The part of a span that the ray spends within a pixel, one of those that it crosses there.
fn span_in_pixel(view: View, ray: EyeRay, pixel: vec2<i32>, span: Span) -> Span {
    let one = image_lines(view, pixel);
    let other = image_lines(view, pixel + 1);
    let origin = ray.origin;
    let direction = ray.direction;
    let heading = image_direction(ray);
    var part = span;
    for (var axis = 0u; axis < 2u; axis++) {
        // Rows count downwards, eye space upwards.
        let sense = f32(select(heading[axis], -heading[axis], (axis == 1u)));
        if (sense != 0.0) {
            let low = min(one[axis], other[axis]);
            let high = max(one[axis], other[axis]);
            let enters = select(high, low, (sense > 0.0));
            let leaves = select(low, high, (sense > 0.0));
            let entry = leaving(enters, sense, origin[axis], direction[axis], origin.z, direction.z, span.begin);
            let exit = leaving(leaves, sense, origin[axis], direction[axis], origin.z, direction.z, span.begin);
            part = Span(max(part.begin, select(span.begin, entry, (entry < NEVER))), min(part.end, exit));
        }
    }
    return part;
}
