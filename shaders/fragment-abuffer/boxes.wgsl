// Depth bounds by the bounding boxes of objects (section 3.3): looser than the geometry's own and quicker to draw where objects
// have many triangles. In compute (`draw`) without the rasterizer.

#import tracebench::dispatch::{Invocation, linear_invocation, linear_workgroup}
#import tracebench::view::{View, to_eye_space}
#import tracebench::depth_bounds::{near_code, far_code}
#import tracebench::fragment_layout::{Storage, RasterizedView, word_index}

// Floats as numbers of the same order, above 0.
fn ordered(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(~bits, bits | 0x80000000u, ((bits >> 31u) == 0u));
}

fn unordered(code: u32) -> f32 {
    return bitcast<f32>(select(~code, code & 0x7fffffffu, ((code >> 31u) == 1u)));
}

@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
// The object of every triangle.
@group(0) @binding(2) var<storage, read> objects: array<u32>;
// Six of every object: greatest corner, complement of the least one, so that both grow from 0.
@group(0) @binding(3) var<storage, read_write> bound_boxes: array<atomic<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bound(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle >= arrayLength(&objects)) {
        return;
    }
    let first = objects[triangle] * 6u;
    for (var axis = 0u; axis < 3u; axis++) {
        let a = positions[indices[triangle * 3u] * 3u + axis];
        let b = positions[indices[triangle * 3u + 1u] * 3u + axis];
        let c = positions[indices[triangle * 3u + 2u] * 3u + axis];
        atomicMax(&bound_boxes[first + axis], ordered(max(a, max(b, c))));
        atomicMax(&bound_boxes[first + 3u + axis], ~ordered(min(a, min(b, c))));
    }
}

// Of the passes that draw boxes.
@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(3) var<uniform> drawn: RasterizedView;
@group(0) @binding(2) var<storage, read> boxes: array<u32>;
@group(0) @binding(4) var<storage, read_write> pixels: array<atomic<u32>>;

// A box, grown by a pixel where it is farthest, and the rectangle of the image that it lies in, from -1 to 1.
struct DrawnBox {
    low: vec3<f32>,
    high: vec3<f32>,
    least: vec2<f32>,
    greatest: vec2<f32>,
    // Whether any of it lies beyond near.
    is_seen: bool,
}

fn drawn_box(object: u32) -> DrawnBox {
    let first = object * 6u;
    var low = vec3<f32>(unordered(~boxes[first + 3u]), unordered(~boxes[first + 4u]), unordered(~boxes[first + 5u]));
    var high = vec3<f32>(unordered(boxes[first]), unordered(boxes[first + 1u]), unordered(boxes[first + 2u]));
    let view = drawn.view;
    let pixel = 2.0 * max(view.tan_half_width / view.size.x, view.tan_half_height / view.size.y);
    let reach = max(abs(low - view.eye), abs(high - view.eye));
    let size = max(max(abs(low), abs(high)), abs(view.eye));
    let grown = pixel * (reach.x + reach.y + reach.z) + 1e-5 * max(size.x, max(size.y, size.z));
    low -= grown;
    high += grown;
    var least = vec2<f32>(1e30);
    var greatest = vec2<f32>(-1e30);
    var nearest = 1e30;
    var farthest = -1e30;
    for (var corner = 0u; corner < 8u; corner++) {
        let which = vec3<bool>((corner & 1u) != 0u, (corner & 2u) != 0u, (corner & 4u) != 0u);
        let point = to_eye_space(view, select(low, high, which));
        nearest = min(nearest, point.z);
        farthest = max(farthest, point.z);
        let at = point.xy / (max(point.z, view.near) * vec2<f32>(view.tan_half_width, view.tan_half_height));
        least = min(least, at);
        greatest = max(greatest, at);
    }
    // A box that reaches before near may lie anywhere in the image.
    if (nearest < view.near) {
        least = vec2<f32>(-1.0);
        greatest = vec2<f32>(1.0);
    }
    least = clamp(least, vec2<f32>(-1.0), vec2<f32>(1.0));
    greatest = clamp(greatest, vec2<f32>(-1.0), vec2<f32>(1.0));
    return DrawnBox(low, high, least, greatest, farthest >= view.near);
}

// The depths at which the line through a pixel's centre passes a box.
fn put_depths(centre: vec2<f32>, box_low: vec3<f32>, box_high: vec3<f32>) {
    let view = drawn.view;
    let across = (centre.x * 2.0 / view.size.x - 1.0) * view.tan_half_width;
    let upward = (1.0 - centre.y * 2.0 / view.size.y) * view.tan_half_height;
    // At eye depth 1, so that parameters are depths.
    let direction = view.forward + view.right * across + view.up * upward;
    var nearest = view.near;
    var farthest = view.far;
    for (var axis = 0u; axis < 3u; axis++) {
        let low = box_low[axis] - view.eye[axis];
        let high = box_high[axis] - view.eye[axis];
        if (abs(direction[axis]) < 1e-30) {
            if (low > 0.0 || high < 0.0) {
                return;
            }
        } else {
            let one = low / direction[axis];
            let other = high / direction[axis];
            nearest = max(nearest, min(one, other));
            farthest = min(farthest, max(one, other));
        }
    }
    if (nearest <= farthest) {
        let at = vec2<u32>(centre);
        let pixel = drawn.first_pixel + at.y * drawn.width + at.x;
        atomicMax(&pixels[word_index(shape, pixel, shape.bounds_word)], near_code(nearest * (1.0 - 1e-5)));
        atomicMax(&pixels[word_index(shape, pixel, shape.bounds_word + 1u)], far_code(farthest * (1.0 + 1e-5)));
    }
}

// Rows of a box that a workgroup draws: Mesa's software driver ends loops after 65,535 rounds.
const BAND: u32 = 16u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let size = vec2<u32>(drawn.view.size);
    let bands = (size.y + BAND - 1u) / BAND;
    let group = linear_workgroup(invocation);
    if (group / bands >= arrayLength(&boxes) / 6u) {
        return;
    }
    let found = drawn_box(group / bands);
    let view = drawn.view;
    let low = vec2<u32>(floor(vec2<f32>(found.least.x + 1.0, 1.0 - found.greatest.y) * 0.5 * view.size));
    let high = min(vec2<u32>(ceil(vec2<f32>(found.greatest.x + 1.0, 1.0 - found.least.y) * 0.5 * view.size)), size);
    let first = group % bands * BAND;
    if (!found.is_seen) {
        return;
    }
    for (var row = max(low.y, first); row < min(high.y, first + BAND); row++) {
        for (var column = low.x + invocation.local; column < high.x; column += WORKGROUP_SIZE) {
            put_depths(vec2<f32>(vec2<u32>(column, row)) + 0.5, found.low, found.high);
        }
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) low: vec3<f32>,
    @location(1) @interpolate(flat) high: vec3<f32>,
}

// Two triangles a box.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let found = drawn_box(index / 6u);
    // Corners 0 1 2, 2 1 3.
    let corner = (0x312210u >> (4u * (index % 6u))) & 3u;
    let right = (corner & 1u) == 1u;
    let upper = (corner & 2u) == 2u;
    var at = vec2<f32>(select(found.least.x, found.greatest.x, right), select(found.least.y, found.greatest.y, upper));
    if (!found.is_seen) {
        at = vec2<f32>(2.0);
    }
    return Corner(vec4<f32>(at, 0.5, 1.0), found.low, found.high);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    put_depths(in.position.xy, in.low, in.high);
    return vec4<f32>(0.0);
}
