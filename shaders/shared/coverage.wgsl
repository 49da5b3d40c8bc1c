#define_import_path tracebench::coverage

// Which pixels' centres a triangle covers, by a rule that is stated and exact, so that triangles with a common edge leave no gap and
// share no pixel, whatever device decides. It is the rule of every rasterizer (Vulkan, "Basic Polygon Rasterization"):
//
// - The triangle is cut to what lies between near and far and not beyond GUARD images (Sutherland, Hodgman, "Reentrant Polygon
//   Clipping", Communications of the ACM 17(1), 1974). An edge is cut from its inner end, so that it is cut alike for both triangles.
// - Corners are rounded to the nearest point of a grid of SUBPIXELS to a pixel. From here on all is integers.
// - A row of pixels' centres lies between two edges: those of which one end lies at the row or above it and the other below. Its pixels are
//   those from the first centre that is not left of the left edge up to the first that is not left of the right one. So a centre on a
//   left edge or on a level upper one is covered, on a right or lower one it is not (the top-left rule), and an edge is the same
//   number for the triangles on its two sides.
//
//     if (outline_in_view(view, a, b, c)) {
//         let rows = rows_of_outline();
//         for (var row = rows.x; row < rows.y; row++) {
//             let span = span_of_row(row);
//             for (var column = span.x; column < span.y; column++) { ... }
//         }
//     }
//
// Rows and spans may lie beyond the image: callers hold them within it.

#import tracebench::view::{View, to_eye_space}

// Steps of the grid to a pixel; the fewest bits that drivers of GPUs have are as many.
const SUBPIXELS: i32 = 256;
const SUBPIXEL_BITS: u32 = 8u;

// A pixel's centre.
const CENTRE: i32 = 128;

// How far beyond the image's middle triangles may reach before they are cut, in halves of the image.
const GUARD: f32 = 3.0;

// Corners of a triangle that is cut by six planes.
const MAX_CORNERS: u32 = 9u;

// A crossing that is computed in f32 is off by less than a 16th of a pixel in images of 32,768 pixels, whose triangles are 2^25 steps of
// the grid wide: twice as close to a centre it is decided in integers.
const UNDECIDED: f32 = 0.125;

// The outline, on the grid.
var<private> outline: array<vec2<i32>, 9>;
var<private> outline_corners: u32;

// Corners while they are cut: x and y of clip space, and w.
var<private> cut: array<vec3<f32>, 9>;
var<private> cut_corners: u32;

// How far a corner lies inside of a plane: near, far, the four sides.
fn inside_by(plane: u32, corner: vec3<f32>, near: f32, far: f32) -> f32 {
    switch (plane) {
        case 0u: {
            return corner.z - near;
        }
        case 1u: {
            return far - corner.z;
        }
        case 2u: {
            return GUARD * corner.z + corner.x;
        }
        case 3u: {
            return GUARD * corner.z - corner.x;
        }
        case 4u: {
            return GUARD * corner.z + corner.y;
        }
        default: {
            return GUARD * corner.z - corner.y;
        }
    }
}

// Where an edge crosses a plane. What rounding takes off the weights moves the point along its edge, where it does no harm; at near and far
// w is what it is there, so that it stays positive however far away the outer end is.
fn crossing(plane: u32, inner: vec3<f32>, outer: vec3<f32>, by: vec2<f32>, near: f32, far: f32) -> vec3<f32> {
    let whole = by.x - by.y;
    let at = inner * (-by.y / whole) + outer * (by.x / whole);
    if (plane == 0u) {
        return vec3<f32>(at.xy, near);
    }
    if (plane == 1u) {
        return vec3<f32>(at.xy, far);
    }
    return at;
}

// Leaves of the corners what lies inside of a plane.
fn cut_by(plane: u32, near: f32, far: f32) {
    var kept: array<vec3<f32>, 9>;
    var count = 0u;
    for (var index = 0u; index < cut_corners; index++) {
        let here = cut[index];
        let there = cut[select(index + 1u, 0u, (index + 1u == cut_corners))];
        let by = vec2<f32>(inside_by(plane, here, near, far), inside_by(plane, there, near, far));
        if (by.x >= 0.0 && count < MAX_CORNERS) {
            kept[count] = here;
            count += 1u;
        }
        if ((by.x >= 0.0) != (by.y >= 0.0) && count < MAX_CORNERS) {
            if (by.x >= 0.0) {
                kept[count] = crossing(plane, here, there, by, near, far);
            } else {
                kept[count] = crossing(plane, there, here, by.yx, near, far);
            }
            count += 1u;
        }
    }
    cut = kept;
    cut_corners = count;
}

// A corner on the grid; of an image whose size counts pixels, or whatever else is drawn.
fn on_grid(corner: vec3<f32>, size: vec2<f32>) -> vec2<i32> {
    let half = size * f32(CENTRE);
    // Rows count downwards.
    let at = clamp(vec2<f32>(corner.x, -corner.y) / corner.z, vec2<f32>(-1.25 * GUARD), vec2<f32>(1.25 * GUARD));
    return vec2<i32>(round(at * half)) + vec2<i32>(round(half));
}

// Makes the outline of a triangle in clip space: x and y of which the image spans from -w to w, and w. Whether there is one.
fn outline_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, near: f32, far: f32, size: vec2<f32>) -> bool {
    cut[0] = a;
    cut[1] = b;
    cut[2] = c;
    cut_corners = 3u;
    for (var plane = 0u; plane < 6u; plane++) {
        let by = vec3<f32>(
            inside_by(plane, a, near, far), inside_by(plane, b, near, far), inside_by(plane, c, near, far),
        );
        if (all(by < vec3<f32>(0.0))) {
            return false;
        }
        if (any(by < vec3<f32>(0.0))) {
            cut_by(plane, near, far);
        }
    }
    for (var index = 0u; index < cut_corners; index++) {
        outline[index] = on_grid(cut[index], size);
    }
    outline_corners = cut_corners;
    return cut_corners > 2u;
}

// Of a triangle in a perspective view.
fn outline_in_view(view: View, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
    let scale = vec3<f32>(1.0 / view.tan_half_width, 1.0 / view.tan_half_height, 1.0);
    return outline_of(
        to_eye_space(view, a) * scale, to_eye_space(view, b) * scale, to_eye_space(view, c) * scale,
        view.near, view.far, view.size,
    );
}

// Of a triangle whose corners lie at places in an orthographic image: shares of its width and height, from its upper left corner.
fn outline_in_image(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, size: vec2<f32>) -> bool {
    return outline_of(
        vec3<f32>(a.x * 2.0 - 1.0, 1.0 - a.y * 2.0, 1.0),
        vec3<f32>(b.x * 2.0 - 1.0, 1.0 - b.y * 2.0, 1.0),
        vec3<f32>(c.x * 2.0 - 1.0, 1.0 - c.y * 2.0, 1.0),
        0.0, 2.0, size,
    );
}

// The least and greatest corner of the outline, on the grid.
fn outline_box() -> vec4<i32> {
    var low = outline[0];
    var high = outline[0];
    for (var index = 1u; index < outline_corners; index++) {
        low = min(low, outline[index]);
        high = max(high, outline[index]);
    }
    return vec4<i32>(low, high);
}

// The first pixel along an axis whose centre does not lie before a place on the grid.
fn first_centre(place: i32) -> i32 {
    return (place + SUBPIXELS - 1 - CENTRE) >> SUBPIXEL_BITS;
}

// The first row of the outline, and the one behind its last.
fn rows_of_outline() -> vec2<i32> {
    var least = outline[0].y;
    var greatest = outline[0].y;
    for (var index = 1u; index < outline_corners; index++) {
        least = min(least, outline[index].y);
        greatest = max(greatest, outline[index].y);
    }
    return vec2<i32>(first_centre(least), first_centre(greatest));
}

// A product of 64 bits, of factors below 2^31: twice 32, the upper ones with the sign.
struct Product {
    upper: i32,
    lower: u32,
}

fn product(a: i32, b: i32) -> Product {
    let x = u32(abs(a));
    let y = u32(abs(b));
    let low = (x & 0xffffu) * (y & 0xffffu);
    let middle = (x >> 16u) * (y & 0xffffu) + (low >> 16u);
    let other = (x & 0xffffu) * (y >> 16u) + (middle & 0xffffu);
    let upper = (x >> 16u) * (y >> 16u) + (middle >> 16u) + (other >> 16u);
    let lower = (other << 16u) | (low & 0xffffu);
    if ((a < 0) == (b < 0)) {
        return Product(i32(upper), lower);
    }
    return Product(i32(~upper + select(0u, 1u, (lower == 0u))), ~lower + 1u);
}

fn at_least(a: Product, b: Product) -> bool {
    return a.upper > b.upper || (a.upper == b.upper && a.lower >= b.lower);
}

// The first pixel of a row whose centre does not lie left of an edge, the upper end of which lies at the row's centres or above, the lower
// one below.
fn first_right_of(upper: vec2<i32>, lower: vec2<i32>, row: i32) -> i32 {
    let along = lower - upper;
    let down = row * SUBPIXELS + CENTRE - upper.y;
    let at = (f32(upper.x - CENTRE) + f32(down) * f32(along.x) / f32(along.y)) / f32(SUBPIXELS);
    let nearest = round(at);
    if (abs(at - nearest) > UNDECIDED) {
        return i32(ceil(at));
    }
    let pixel = i32(nearest);
    let right = pixel * SUBPIXELS + CENTRE - upper.x;
    if (at_least(product(right, along.y), product(down, along.x))) {
        return pixel;
    }
    return pixel + 1;
}

// The first pixel of a row that the outline covers, and the one behind its last; not before the first where it covers none.
fn span_of_row(row: i32) -> vec2<i32> {
    let centre = row * SUBPIXELS + CENTRE;
    var first = 0x7fffffff;
    var last = -0x7fffffff;
    for (var index = 0u; index < outline_corners; index++) {
        let here = outline[index];
        let there = outline[select(index + 1u, 0u, (index + 1u == outline_corners))];
        let above = here.y <= centre;
        if (above != (there.y <= centre)) {
            let at = first_right_of(select(there, here, above), select(here, there, above), row);
            first = min(first, at);
            last = max(last, at);
        }
    }
    return vec2<i32>(first, last);
}
