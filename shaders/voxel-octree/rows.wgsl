#define_import_path tracebench::octree_rows

// The voxels that a triangle touches, seen along its dominant axis: row by row of its projection, in a row column by column, in a column
// from its least to its greatest depth there. The triangle is clipped to a row and then to a column, so that no plane is asked, which
// thin triangles have none of. Everything is in voxels, as an image along the axis has it: across, down, depth.

// Voxels are wider by it on every side: by more than f32 places corners and cuts off in a grid of 1024, so that no voxel that a triangle
// touches is left out.
const SLACK: f32 = 1.0 / 512.0;

// The part of a triangle in a row: the corners of a convex polygon, in order.
var<private> points: array<vec3<f32>, 6>;
var<private> point_count: u32;

// The end of an edge where it is cut off at a row's side; its own where it is not.
fn cut_down(from_point: vec3<f32>, to_point: vec3<f32>, down: f32) -> vec3<f32> {
    if (from_point.y == down) {
        return from_point;
    }
    let part = clamp((down - from_point.y) / (to_point.y - from_point.y), 0.0, 1.0);
    let cut = from_point + (to_point - from_point) * part;
    return vec3<f32>(cut.x, down, cut.z);
}

fn take_edge(from_point: vec3<f32>, to_point: vec3<f32>, low: f32, high: f32) {
    if (max(from_point.y, to_point.y) < low || min(from_point.y, to_point.y) > high) {
        return;
    }
    points[point_count] = cut_down(from_point, to_point, clamp(from_point.y, low, high));
    points[point_count + 1u] = cut_down(to_point, from_point, clamp(to_point.y, low, high));
    point_count += 2u;
}

// Takes the part of a triangle in a row.
fn take_row(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, row: u32) {
    let low = f32(row) - SLACK;
    let high = f32(row) + 1.0 + SLACK;
    point_count = 0u;
    take_edge(a, b, low, high);
    take_edge(b, c, low, high);
    take_edge(c, a, low, high);
}

// The cells of a grid's axis that an interval lies in, the first and the last; the first beyond the last for none.
fn cells_of(least: f32, greatest: f32, edge: u32) -> vec2<i32> {
    let last = f32(edge - 1u);
    if (!(least <= greatest)) {
        return vec2<i32>(0, -1);
    }
    return vec2<i32>(clamp(floor(vec2<f32>(least - SLACK, greatest + SLACK)), vec2<f32>(0.0), vec2<f32>(last)));
}

// The columns of the row that was taken.
fn columns_of_row(edge: u32) -> vec2<i32> {
    var least = 1e9;
    var greatest = -1e9;
    for (var place = 0u; place < point_count; place++) {
        least = min(least, points[place].x);
        greatest = max(greatest, points[place].x);
    }
    return cells_of(least, greatest, edge);
}

// The depth at which an edge crosses a column's side.
fn depth_at(from_point: vec3<f32>, to_point: vec3<f32>, across: f32) -> f32 {
    if (from_point.x == across) {
        return from_point.z;
    }
    let part = clamp((across - from_point.x) / (to_point.x - from_point.x), 0.0, 1.0);
    return from_point.z + (to_point.z - from_point.z) * part;
}

// The voxels of a column of that row.
fn depths_of_column(column: i32, edge: u32) -> vec2<i32> {
    let low = f32(column) - SLACK;
    let high = f32(column) + 1.0 + SLACK;
    var least = 1e9;
    var greatest = -1e9;
    for (var place = 0u; place < point_count; place++) {
        let from_point = points[place];
        let to_point = points[select(place + 1u, 0u, (place + 1u == point_count))];
        if (max(from_point.x, to_point.x) < low || min(from_point.x, to_point.x) > high) {
            continue;
        }
        let first = depth_at(from_point, to_point, clamp(from_point.x, low, high));
        let second = depth_at(to_point, from_point, clamp(to_point.x, low, high));
        least = min(least, min(first, second));
        greatest = max(greatest, max(first, second));
    }
    return cells_of(least, greatest, edge);
}
