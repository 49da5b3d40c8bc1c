// The bottom level of the quad-trees (WKP15, section 3.2): every pixel of every layer as a small plane, with the z that was drawn
// there, a normal, and the flag of what lies near a discontinuity of depth.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::view::{View, direction_to_eye_space}
#import tracebench::quadtree_forest::{Forest, z_of_depth, z_of_pixels, node_index}
#import tracebench::quadtree_node::{FLAG_BIT, NOTHING, SIDES, plane_of, plane_words, slope_words, with_end}
#import tracebench::quadtree_patches::{end_before, step_across}
#import tracebench::quadtree_reconstruct::{NO_Z, axis_slope, is_apart}

@group(0) @binding(0) var<uniform> forest: Forest;
@group(0) @binding(1) var<uniform> views: array<View, 6>;
@group(0) @binding(2) var<storage, read> codes: array<u32>;
// Normals and materials of the layers.
@group(0) @binding(3) var<storage, read> odd_layers: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> even_layers: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> nodes: array<vec2<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

// z at a pixel of an image, NO_Z where it shows nothing or there is none.
fn z_at(image: u32, pixel: vec2<i32>) -> f32 {
    if (any(pixel < vec2<i32>(0)) || any(pixel >= vec2<i32>(forest.size))) {
        return NO_Z;
    }
    let code = codes[image * forest.size.x * forest.size.y + u32(pixel.y) * forest.size.x + u32(pixel.x)];
    if (code == 0u) {
        return NO_Z;
    }
    return z_of_depth(forest, bitcast<f32>(~code));
}

// z a pixel of the plane with a normal in world space through what is seen at a pixel.
fn slope_of_geometry(image: u32, pixel: vec2<i32>) -> vec2<f32> {
    let pixels = forest.size.x * forest.size.y;
    let place = u32(pixel.y) * forest.size.x + u32(pixel.x);
    let depth = bitcast<f32>(~codes[image * pixels + place]);
    let layer = image % forest.layers;
    let layers = select(forest.layers / 2u, (forest.layers + 1u) / 2u, ((layer & 1u) == 0u));
    let at = ((image / forest.layers) * layers + layer / 2u) * pixels + place;
    var payload = vec4<u32>(0u);
    if ((layer & 1u) == 0u) {
        payload = odd_layers[at];
    } else {
        payload = even_layers[at];
    }
    let view = views[image / forest.layers];
    let normal = direction_to_eye_space(view, bitcast<vec3<f32>>(payload.xyz));
    // Of a point at depth d on the line of sight (x, y, 1): 1 / depth = normal . (x, y, 1) / (d * normal . line of sight).
    let tangents = vec2<f32>(view.tan_half_width, -view.tan_half_height);
    let sight = vec3<f32>(((vec2<f32>(pixel) + 0.5) * 2.0 / view.size - 1.0) * tangents, 1.0);
    let facing = dot(normal, sight);
    if (facing == 0.0) {
        return vec2<f32>(0.0);
    }
    return (forest.z_scale / depth) * (normal.xy / facing) * (2.0 * tangents / view.size);
}

// z a pixel of what is seen at a pixel.
fn slope_at(image: u32, pixel: vec2<i32>, here: f32, tolerance: f32) -> vec2<f32> {
    if (forest.normals_of_geometry == 1u) {
        return slope_of_geometry(image, pixel);
    }
    var slope = vec2<f32>(0.0);
    for (var axis = 0u; axis < 2u; axis++) {
        let step = select(vec2<i32>(1, 0), vec2<i32>(0, 1), (axis == 1u));
        let found = axis_slope(
            z_at(image, pixel - 2 * step), z_at(image, pixel - step), here, z_at(image, pixel + step), z_at(image, pixel + 2 * step),
            tolerance,
        );
        slope[axis] = found.slope;
    }
    return slope;
}

// The plane of a pixel that shows something, unflagged.
fn plane_at(image: u32, pixel: vec2<i32>, slope: vec2<f32>) -> vec2<u32> {
    return plane_words(z_at(image, pixel), slope_words(slope * vec2<f32>(forest.size)), false);
}

// A flagged pixel's words with the side across which its plane ends at that of a neighbour: of several the one that it gets before most.
fn ended(image: u32, pixel: vec2<i32>, words: vec2<u32>) -> vec2<u32> {
    let size = vec2<f32>(forest.size);
    var most = 0.0;
    var found = words;
    for (var side = 0u; side < SIDES; side++) {
        let step = step_across(side);
        let z = z_at(image, pixel + step);
        if (z < 0.0) {
            continue;
        }
        let slope = slope_at(image, pixel + step, z, z_of_pixels(forest, z, forest.discontinuity));
        let before = end_before(plane_of(words, size), plane_of(plane_at(image, pixel + step, slope), size), vec2<f32>(step));
        if (before > most) {
            most = before;
            found = with_end(words, side);
        }
    }
    return found;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn bottom(invocation: Invocation) {
    let pixels = forest.size.x * forest.size.y;
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= pixels * forest.image_count) {
        return;
    }
    let image = index / pixels;
    let cell = vec2<u32>((index % pixels) % forest.size.x, (index % pixels) / forest.size.x);
    let node = node_index(forest, image, 0u, cell);
    if (codes[index] == 0u) {
        nodes[node] = NOTHING;
        return;
    }
    let pixel = vec2<i32>(cell);
    let here = z_at(image, pixel);
    let tolerance = z_of_pixels(forest, here, forest.discontinuity);
    let last = vec2<i32>(forest.size) - 1;
    let slope = slope_at(image, pixel, here, tolerance);
    var flagged = false;
    for (var axis = 0u; axis < 2u; axis++) {
        let step = select(vec2<i32>(1, 0), vec2<i32>(0, 1), (axis == 1u));
        flagged = flagged || (pixel[axis] > 0 && is_apart(z_at(image, pixel - step), here - slope[axis], tolerance))
            || (pixel[axis] < last[axis] && is_apart(z_at(image, pixel + step), here + slope[axis], tolerance));
    }
    var words = plane_at(image, pixel, slope);
    if (flagged) {
        words.x |= FLAG_BIT;
        if (forest.is_joined == 1u) {
            words = ended(image, pixel, words);
        }
    }
    nodes[node] = words;
}
