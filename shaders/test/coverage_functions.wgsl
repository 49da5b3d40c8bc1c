// Calls the shared rule of coverage on given triangles, so that a test can compare it with integers and f64 on the host.

#import tracebench::view::View
#import tracebench::coverage::{outline, outline_corners, outline_in_view, rows_of_outline, span_of_row}

// Rows that spans are asked of.
@group(0) @binding(0) var<uniform> asked: vec4<u32>;
// Three corners a triangle, on the grid.
@group(0) @binding(1) var<storage, read> corners: array<vec2<i32>>;
// Of every triangle the span of each row; nothing for rows that it does not have.
@group(0) @binding(2) var<storage, read_write> spans: array<vec2<i32>>;

@group(0) @binding(3) var<uniform> view: View;
// Three corners a triangle.
@group(0) @binding(4) var<storage, read> points: array<vec4<f32>>;
// Of every triangle the number of its outline's corners, then these.
@group(0) @binding(5) var<storage, read_write> outlines: array<array<vec2<i32>, 10>>;

@compute @workgroup_size(64)
fn cover(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&corners) / 3u) {
        return;
    }
    for (var corner = 0u; corner < 3u; corner++) {
        outline[corner] = corners[id.x * 3u + corner];
    }
    outline_corners = 3u;
    let rows = rows_of_outline();
    for (var row = max(rows.x, 0); row < min(rows.y, i32(asked.x)); row++) {
        spans[id.x * asked.x + u32(row)] = span_of_row(row);
    }
}

@compute @workgroup_size(64)
fn project(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&points) / 3u) {
        return;
    }
    let first = id.x * 3u;
    outlines[id.x][0] = vec2<i32>(0);
    if (!outline_in_view(view, points[first].xyz, points[first + 1u].xyz, points[first + 2u].xyz)) {
        return;
    }
    outlines[id.x][0] = vec2<i32>(i32(outline_corners), 0);
    for (var corner = 0u; corner < outline_corners; corner++) {
        outlines[id.x][corner + 1u] = outline[corner];
    }
}
