// What is nearest at every pixel's centre, as nearest_raster.wgsl draws it, by the rule of tracebench::coverage: codes of eye depths, which
// grow towards the eye so that atomic maxima keep the nearest; and then, by the same instructions so that both see the same depth to
// the bit, the triangles that have them.

#import tracebench::scene::load_position
#import tracebench::view::View
#import tracebench::plane_depth::{FlatTriangle, flat_triangle, plane_depth, tested_depth}
#import tracebench::depth_bounds::near_code
#import tracebench::dispatch::Invocation
#import tracebench::coverage::{outline_in_view, rows_of_outline, span_of_row}
#import tracebench::raster_work::part_of
#ifdef BEHIND
#import tracebench::passed_layer::lies_behind
#endif

struct NearestImage {
    // Words from a row to the next.
    row_words: u32,
    // 1: triangles are named.
    names: u32,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(5) var<uniform> image: NearestImage;
@group(0) @binding(6) var<storage, read_write> codes: array<atomic<u32>>;
#ifdef PRIMITIVES
// Complements of the least triangles.
@group(0) @binding(7) var<storage, read_write> names: array<atomic<u32>>;
#endif

const WORKGROUP_SIZE: u32 = 64u;

fn put_fragment(at: vec2<i32>, triangle: FlatTriangle, primitive: u32) {
    let depth = plane_depth(view, triangle, vec2<f32>(at) + 0.5);
    // At far there is nothing, as a depth test has it.
    if (!(tested_depth(view, depth) > 0.0)) {
        return;
    }
#ifdef BEHIND
    if (!lies_behind(depth, at, triangle.plane.w > 0.0)) {
        return;
    }
#endif
    let word = u32(at.y) * image.row_words + u32(at.x);
    let code = near_code(depth);
#ifdef PRIMITIVES
    if (image.names == 1u) {
        if (atomicLoad(&codes[word]) == code) {
            atomicMax(&names[word], ~primitive);
        }
        return;
    }
#endif
    atomicMax(&codes[word], code);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let part = part_of(invocation);
    if (any(part.high <= part.low)) {
        return;
    }
    let a = load_position(part.triangle * 3u);
    let b = load_position(part.triangle * 3u + 1u);
    let c = load_position(part.triangle * 3u + 2u);
    if (!outline_in_view(view, a, b, c)) {
        return;
    }
    let triangle = flat_triangle(view, a, b, c);
    let rows = rows_of_outline();
    for (var row = max(rows.x, part.low.y); row < min(rows.y, part.high.y); row++) {
        let span = span_of_row(row);
        for (var column = max(span.x, part.low.x); column < min(span.y, part.high.x); column++) {
            put_fragment(vec2<i32>(column, row), triangle, part.triangle);
        }
    }
}
