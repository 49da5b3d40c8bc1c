// The depth layers of a view (WKP15, section 3.1): the nearest depths of every pixel, by the rasterizer's own sample rule. Depths
// are codes that grow towards the eye, 0 for none, so that atomic maxima keep the nearest. The same pipeline catches depths and names
// the triangles that have them, so that both see the same depth to the bit. In compute (`draw`) by the rule of tracebench::coverage.

#import tracebench::scene::load_position
#import tracebench::view::{View, to_eye_space, clip_position}
#import tracebench::plane_depth::{FlatTriangle, flat_triangle, plane_depth}
#import tracebench::depth_bounds::near_code
#import tracebench::dispatch::Invocation
#import tracebench::coverage::{outline_in_view, rows_of_outline, span_of_row}
#import tracebench::raster_work::part_of

struct LayerPass {
    view: View,
    // What the pass does.
    stage: u32,
    // The layer that is peeled, and the layers or slots of a pixel.
    layer: u32,
    slots: u32,
    // 1: what faces away is left out.
    culls: u32,
    // Pixels of a layer and of a row, and where the view's layers begin.
    pixels: u32,
    width: u32,
    first: u32,
    // Least distance between layers, eye depth.
    separation: f32,
}

// All slots by cascaded minima; the next layer behind the one before; the triangles that layers are of.
const CATCH: u32 = 0u;
const PEEL: u32 = 1u;

@group(0) @binding(0) var<uniform> drawn: LayerPass;
@group(0) @binding(3) var<storage, read_write> codes: array<atomic<u32>>;
// The complement of the least triangle of every layer.
@group(0) @binding(4) var<storage, read_write> names: array<atomic<u32>>;

// By its first of three corners.
fn flat_of(first: u32) -> FlatTriangle {
    return flat_triangle(drawn.view, load_position(first), load_position(first + 1u), load_position(first + 2u));
}

// Each slot keeps the nearer of what it has and what comes, and hands the other on. Whatever the order in which depths come,
// the slots end with the nearest, each depth once, without a lock.
fn catch_depth(pixel: u32, code: u32) {
    // Slots only ever get nearer: what lies behind the last of them now will not be among them.
    if (code <= atomicLoad(&codes[drawn.first + (drawn.slots - 1u) * drawn.pixels + pixel])) {
        return;
    }
    var carried = code;
    for (var slot = 0u; slot < drawn.slots; slot++) {
        let before = atomicMax(&codes[drawn.first + slot * drawn.pixels + pixel], carried);
        if (before == carried) {
            return;
        }
        carried = min(before, carried);
        if (carried == 0u) {
            return;
        }
    }
}

// The nearest behind the layer before by more than the separation; that layer is whole.
fn peel_depth(pixel: u32, depth: f32, code: u32) {
    if (drawn.layer > 0u) {
        let before = atomicLoad(&codes[drawn.first + (drawn.layer - 1u) * drawn.pixels + pixel]);
        if (before == 0u || depth <= bitcast<f32>(~before) + drawn.separation) {
            return;
        }
    }
    atomicMax(&codes[drawn.first + drawn.layer * drawn.pixels + pixel], code);
}

// Of triangles of one depth the least.
fn name_triangle(pixel: u32, code: u32, primitive: u32) {
    for (var slot = 0u; slot < drawn.slots; slot++) {
        let at = drawn.first + slot * drawn.pixels + pixel;
        if (atomicLoad(&codes[at]) == code) {
            atomicMax(&names[at], ~primitive);
            return;
        }
    }
}

// What a pass does with a fragment, by its pixel's centre.
fn put_fragment(centre: vec2<f32>, triangle: FlatTriangle, primitive: u32) {
    // The eye lies behind the plane of a triangle that faces away.
    if (drawn.culls == 1u && triangle.plane.w > 0.0) {
        return;
    }
    let at = vec2<u32>(centre);
    let pixel = at.y * drawn.width + at.x;
    let depth = plane_depth(drawn.view, triangle, centre);
    let code = near_code(depth);
    if (drawn.stage == CATCH) {
        catch_depth(pixel, code);
    } else if (drawn.stage == PEEL) {
        peel_depth(pixel, depth, code);
    } else {
        name_triangle(pixel, code, primitive);
    }
}

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let part = part_of(invocation);
    if (any(part.high <= part.low)) {
        return;
    }
    let first = part.triangle * 3u;
    if (!outline_in_view(drawn.view, load_position(first), load_position(first + 1u), load_position(first + 2u))) {
        return;
    }
    let triangle = flat_of(first);
    let rows = rows_of_outline();
    for (var row = max(rows.x, part.low.y); row < min(rows.y, part.high.y); row++) {
        let span = span_of_row(row);
        for (var column = max(span.x, part.low.x); column < min(span.y, part.high.x); column++) {
            put_fragment(vec2<f32>(vec2<i32>(column, row)) + 0.5, triangle, part.triangle);
        }
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) depths: vec2<f32>,
    @location(2) @interpolate(flat) primitive: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    var corner: Corner;
    corner.position = clip_position(drawn.view, to_eye_space(drawn.view, load_position(index)));
    // A triangle's first corner speaks for it.
    if (index % 3u == 0u) {
        let triangle = flat_of(index);
        corner.plane = triangle.plane;
        corner.depths = triangle.depths;
        corner.primitive = index / 3u;
    }
    return corner;
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    put_fragment(in.position.xy, FlatTriangle(in.plane, in.depths), in.primitive);
    return vec4<f32>(0.0);
}
