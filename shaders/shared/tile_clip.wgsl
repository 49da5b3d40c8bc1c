#define_import_path tracebench::tile_clip

// What of a triangle lies inside a tile of a view: the exact range of eye depths of the triangle clipped to the tile's
// frustum, without building the polygon. In the pyramid between the tile's four sides its extremes lie where an edge of
// the triangle enters or leaves, at a corner of the triangle, or where a corner line of the pyramid pierces the triangle;
// the polygon is in one piece, so near and far cut its range as they cut it.

#import tracebench::view::View
#import tracebench::triangle::inverse_power

struct DepthRange {
    // Eye depths; least > greatest for nothing.
    least: f32,
    greatest: f32,
}

// The frustum of a tile: low.x z <= x <= high.x z, low.y z <= y <= high.y z, near <= z <= far in eye space.
struct TileFrustum {
    low: vec2<f32>,
    high: vec2<f32>,
    near: f32,
    far: f32,
}

const NOTHING: DepthRange = DepthRange(1e38, -1e38);

// By how much tiles are grown on every side, in tiles: 2^-10 of a tile, and what f32 loses of a position among `size`
// tiles. No border is lost to rounding.
fn tile_margin(size: vec2<f32>) -> f32 {
    return 9.765625e-4 + max(size.x, size.y) * 4.76837158e-7;
}

// The frustum of a tile of a view whose size counts tiles, grown by `margin` tiles.
fn tile_frustum(view: View, tile: vec2<u32>, margin: f32) -> TileFrustum {
    let first = (vec2<f32>(tile) - margin) * 2.0 / view.size;
    let last = (vec2<f32>(tile) + 1.0 + margin) * 2.0 / view.size;
    return TileFrustum(
        vec2<f32>((first.x - 1.0) * view.tan_half_width, (1.0 - last.y) * view.tan_half_height),
        vec2<f32>((last.x - 1.0) * view.tan_half_width, (1.0 - first.y) * view.tan_half_height),
        view.near,
        view.far,
    );
}

// The frustum of tiles from `first` to before `last`, grown by an eighth of one: what does not touch it touches none of its tiles, however
// f32 rounds.
fn tiles_frustum(view: View, first: vec2<i32>, last: vec2<i32>) -> TileFrustum {
    let low = (vec2<f32>(first) - 0.125) * 2.0 / view.size;
    let high = (vec2<f32>(last) + 0.125) * 2.0 / view.size;
    return TileFrustum(
        vec2<f32>((low.x - 1.0) * view.tan_half_width, (1.0 - high.y) * view.tan_half_height),
        vec2<f32>((high.x - 1.0) * view.tan_half_width, (1.0 - low.y) * view.tan_half_height),
        view.near,
        view.far,
    );
}

fn joined(a: DepthRange, b: DepthRange) -> DepthRange {
    return DepthRange(min(a.least, b.least), max(a.greatest, b.greatest));
}

// A point of an edge at eye depth z between those of its ends.
fn at_depth(a: vec3<f32>, b: vec3<f32>, z: f32) -> vec3<f32> {
    let share = (z - a.z) / (b.z - a.z);
    return vec3<f32>(a.xy + (b.xy - a.xy) * share, z);
}

// What of an edge lies in the pyramid of a tile, between its four sides, in front of the eye.
fn edge_range(frustum: TileFrustum, begin: vec3<f32>, end: vec3<f32>) -> DepthRange {
    // Ordered by depth, so that an edge gives the same numbers from both of its triangles.
    var a = begin;
    var b = end;
    if (b.z < a.z) {
        a = end;
        b = begin;
    }
    if (b.z <= 0.0) {
        return NOTHING;
    }
    if (a.z < 0.0) {
        a = at_depth(a, b, 0.0);
    }
    // Distances from the four sides, positive inside.
    let from_a = vec4<f32>(a.xy - frustum.low * a.z, frustum.high * a.z - a.xy);
    let from_b = vec4<f32>(b.xy - frustum.low * b.z, frustum.high * b.z - b.xy);
    let out_a = from_a < vec4<f32>(0.0);
    let out_b = from_b < vec4<f32>(0.0);
    if (any(out_a & out_b)) {
        return NOTHING;
    }
    let crosses = out_a | out_b;
    let whole = select(vec4<f32>(1.0), from_b - from_a, crosses);
    let share = -from_a / whole;
    let enters = select(vec4<f32>(0.0), share, out_a);
    let leaves = select(vec4<f32>(1.0), share, out_b);
    if (max(max(enters.x, enters.y), max(enters.z, enters.w)) > min(min(leaves.x, leaves.y), min(leaves.z, leaves.w))) {
        return NOTHING;
    }
    // In this form both terms have one sign, and nothing cancels, however far the ends lie apart.
    let depth = (a.z * from_b - b.z * from_a) / whole;
    let first = select(vec4<f32>(a.z), depth, out_a);
    let last = select(vec4<f32>(b.z), depth, out_b);
    // Depth does not fall from a to b: the last side to be entered is the deepest.
    let least = max(max(first.x, first.y), max(first.z, first.w));
    let greatest = min(min(last.x, last.y), min(last.z, last.w));
    return DepthRange(clamp(min(least, greatest), a.z, b.z), clamp(max(least, greatest), a.z, b.z));
}

// The eye depth at which the line through the eye along (corner, 1) meets the triangle's plane; negative, or no number, where it
// does not in front of the eye. A plane through the eye is met there, at depth 0.
fn plane_depth(normal: vec3<f32>, on_plane: vec3<f32>, corner: vec2<f32>) -> f32 {
    let slope = dot(normal, vec3<f32>(corner, 1.0));
    if (slope == 0.0) {
        return -1.0;
    }
    return dot(normal, on_plane) / slope;
}

struct Edges {
    ab: vec3<f32>,
    bc: vec3<f32>,
    ca: vec3<f32>,
}

// A triangle's edges over the power of two in their size, which rounds nothing: no product with them leaves f32's range.
fn scaled_edges(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Edges {
    let sizes = max(max(abs(b - a), abs(c - b)), abs(a - c));
    let scale = inverse_power(max(max(sizes.x, sizes.y), sizes.z));
    return Edges((b - a) * scale, (c - b) * scale, (a - c) * scale);
}

// What of a triangle (in eye space) lies inside: the range of the clipped polygon (DIRT, section 4.1.1).
fn polygon_range(frustum: TileFrustum, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> DepthRange {
    var range = joined(joined(edge_range(frustum, a, b), edge_range(frustum, b, c)), edge_range(frustum, c, a));
    let edges = scaled_edges(a, b, c);
    let normal = cross(edges.ab, -edges.ca);
    // Corner lines that pierce the triangle: three planes through the eye and its edges have them on the same side.
    // Of the edges, not of their ends: what f32 loses is then small beside the triangle, however far away it is.
    let side_a = cross(b, edges.bc);
    let side_b = cross(c, edges.ca);
    let side_c = cross(a, edges.ab);
    let min_z = min(min(a.z, b.z), c.z);
    let max_z = max(max(a.z, b.z), c.z);
    for (var corner = 0u; corner < 4u; corner++) {
        let at = vec2<f32>(
            select(frustum.low.x, frustum.high.x, ((corner & 1u) == 1u)),
            select(frustum.low.y, frustum.high.y, ((corner & 2u) == 2u)),
        );
        let line = vec3<f32>(at, 1.0);
        let sides = vec3<f32>(dot(side_a, line), dot(side_b, line), dot(side_c, line));
        let pierces = all(sides >= vec3<f32>(0.0)) || all(sides <= vec3<f32>(0.0));
        let plane_z = plane_depth(normal, a, at);
        if (pierces && plane_z >= 0.0) {
            let z = clamp(plane_z, min_z, max_z);
            range = joined(range, DepthRange(z, z));
        }
    }
    if (range.greatest < frustum.near || range.least > frustum.far) {
        return NOTHING;
    }
    return DepthRange(max(range.least, frustum.near), min(range.greatest, frustum.far));
}

// The range by the triangle's plane alone, as DIRT's released code takes it: the plane's depths along the tile's four
// corner lines, near and far where a line misses it. Contains the polygon's range, by much for oblique triangles.
fn plane_range(frustum: TileFrustum, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> DepthRange {
    let edges = scaled_edges(a, b, c);
    let normal = cross(edges.ab, -edges.ca);
    var range = NOTHING;
    for (var corner = 0u; corner < 4u; corner++) {
        let at = vec2<f32>(
            select(frustum.low.x, frustum.high.x, ((corner & 1u) == 1u)),
            select(frustum.low.y, frustum.high.y, ((corner & 2u) == 2u)),
        );
        let z = plane_depth(normal, a, at);
        if (z >= frustum.near && z <= frustum.far) {
            range = joined(range, DepthRange(z, z));
        } else {
            range = DepthRange(frustum.near, frustum.far);
            break;
        }
    }
    return range;
}

// The rectangle of tiles that a triangle may touch: first and last + 1; empty where last <= first.
struct TileRectangle {
    first: vec2<f32>,
    last: vec2<f32>,
}

fn include_point(rectangle: TileRectangle, view: View, point: vec3<f32>) -> TileRectangle {
    let across = point.x / (point.z * view.tan_half_width);
    let upward = point.y / (point.z * view.tan_half_height);
    let at = vec2<f32>(across + 1.0, 1.0 - upward) * 0.5 * view.size;
    return TileRectangle(min(rectangle.first, at), max(rectangle.last, at));
}

fn include_edge(rectangle: TileRectangle, view: View, a: vec3<f32>, b: vec3<f32>) -> TileRectangle {
    var grown = rectangle;
    if (a.z >= view.near) {
        grown = include_point(grown, view, a);
    }
    // Where the edge crosses near.
    if ((a.z < view.near) != (b.z < view.near)) {
        grown = include_point(grown, view, at_depth(a, b, view.near));
    }
    return grown;
}

// Of a triangle in eye space, within `tiles`.
fn tile_rectangle(view: View, tiles: vec2<u32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> TileRectangle {
    var rectangle = TileRectangle(vec2<f32>(1e30), vec2<f32>(-1e30));
    rectangle = include_edge(rectangle, view, a, b);
    rectangle = include_edge(rectangle, view, b, c);
    rectangle = include_edge(rectangle, view, c, a);
    let margin = tile_margin(view.size);
    let first = max(floor(rectangle.first - margin), vec2<f32>(0.0));
    let last = min(floor(rectangle.last + margin) + 1.0, vec2<f32>(tiles));
    return TileRectangle(first, last);
}

// Conservative coverage in the vertex stage: the corner, in clip coordinates, of the two triangles that draw the rectangle of
// cells which a triangle may touch; six a triangle, outside of the image where it touches none. The fragment stage decides exactly.
fn rectangle_corner(rectangle: TileRectangle, cells: vec2<u32>, index: u32) -> vec4<f32> {
    if (any(rectangle.last <= rectangle.first)) {
        return vec4<f32>(2.0, 2.0, 0.5, 1.0);
    }
    // Corners 0 1 2, 2 1 3.
    let corner = (0x312210u >> (4u * (index % 6u))) & 3u;
    let cell = vec2<f32>(
        select(rectangle.first.x, rectangle.last.x, ((corner & 1u) == 1u)),
        select(rectangle.first.y, rectangle.last.y, ((corner & 2u) == 2u)),
    );
    let at = cell / vec2<f32>(cells);
    return vec4<f32>(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.5, 1.0);
}
