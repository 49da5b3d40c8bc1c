#define_import_path tracebench::dirt_parts

// What of a triangle lies in a tile of a face: a box of the triangle clipped to the tile, which no rounding makes too small.
//
// A triangle is first clipped to the depths that tiles hold and to twice the face's width, in eye space, and then divided: its corners
// are numbers from there on, the polygon. The polygon is off the triangle by what `place_loss` and `depth_loss` say, and boxes are
// grown by as much. What is computed of the polygon itself (where its edges cross the borders of a tile, its depth at a tile's corners)
// has relative errors alone, of a few times 2^-24, which are part of the same losses.
//
// u is 2^-24 below. A corner less the eye is rounded once, to 1 u of each of its components (IEEE 754). A quotient is off by 2.5 ulp at
// most and a product or sum by half of one (WGSL, 15.7.4.1, "Floating Point Accuracy"). Points that clipping makes are weighted means of
// two corners with weights of one sign, off by no more than 8 u of the triangle's size: the place along the edge may be off by more,
// which leaves them on the edge.

// A triangle's size: its corners' greatest coordinate, less the eye. Tiles hold it from so many sizes on; what is nearer is listed apart.
const MIN_DEPTH: f32 = 1.220703125e-4;

// Corners: a triangle's three, and one more for each of five planes, and one to spare.
const MAX_CORNERS: u32 = 9u;

struct PolygonState {
    count: u32,
    // By how much places, in tiles, and w may be off.
    place_loss: f32,
    depth_loss: f32,
    // Least and greatest of the corners.
    low: vec3<f32>,
    high: vec3<f32>,
    // The polygon's area vector: twice its area in the image is z. The sign is that of its turn.
    turn: vec3<f32>,
}

var<private> polygon: array<vec3<f32>, 9>;
var<private> clipped: array<vec3<f32>, 9>;

// What of a triangle lies in a tile, at least; low > high for nothing.
struct Part {
    low: vec3<f32>,
    high: vec3<f32>,
}

const NO_PART: Part = Part(vec3<f32>(1e30), vec3<f32>(-1e30));

// Clips the polygon in eye space to dot(normal, point) >= least.
fn clip_polygon(count: u32, normal: vec3<f32>, least: f32) -> u32 {
    var kept = 0u;
    var before = polygon[count - 1u];
    var distance_before = dot(normal, before) - least;
    for (var corner = 0u; corner < count; corner++) {
        let here = polygon[corner];
        let distance = dot(normal, here) - least;
        if (((distance >= 0.0) != (distance_before >= 0.0)) && (kept < MAX_CORNERS)) {
            // Both weights have one sign: a mean, however far the ends lie apart.
            let size = abs(distance) + abs(distance_before);
            clipped[kept] = before * (abs(distance) / size) + here * (abs(distance_before) / size);
            kept += 1u;
        }
        if ((distance >= 0.0) && (kept < MAX_CORNERS)) {
            clipped[kept] = here;
            kept += 1u;
        }
        before = here;
        distance_before = distance;
    }
    for (var corner = 0u; corner < kept; corner++) {
        polygon[corner] = clipped[corner];
    }
    return kept;
}

fn no_polygon() -> PolygonState {
    return PolygonState(0u, 0.0, 0.0, vec3<f32>(1e30), vec3<f32>(-1e30), vec3<f32>(0.0));
}

// Whether a triangle whose corners stand as a face has them lies outside of the face by a quarter of its half width, or nearer than what
// tiles hold: none of it is stored there, whatever rounding does.
fn is_outside(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, size: f32) -> bool {
    let right = min(min(a.xy - 1.25 * a.z, b.xy - 1.25 * b.z), c.xy - 1.25 * c.z);
    let left = min(min(-a.xy - 1.25 * a.z, -b.xy - 1.25 * b.z), -c.xy - 1.25 * c.z);
    let max_z = max(max(a.z, b.z), c.z);
    return max_z < size * MIN_DEPTH || any(right > vec2<f32>(0.0)) || any(left > vec2<f32>(0.0)) || size == 0.0;
}

// Whether no part of it need be clipped off before it is divided. Within twice the face's width places are small enough for what
// divisions lose of them.
fn is_whole(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, size: f32) -> bool {
    let wide = max(max(abs(a.xy) - 2.0 * a.z, abs(b.xy) - 2.0 * b.z), abs(c.xy) - 2.0 * c.z);
    return min(min(a.z, b.z), c.z) >= size * MIN_DEPTH && all(wide <= vec2<f32>(0.0));
}

// A point in (x, y, w), not nearer than a depth.
fn divided(point: vec3<f32>, least: f32, tiles: f32) -> vec3<f32> {
    let inverse = 1.0 / max(point.z, least);
    return vec3<f32>((point.xy * inverse + 1.0) * (0.5 * tiles), inverse);
}

// The state with its losses.
//
// Places: quotients of at most 2 in size, off by 12 u, of which there is room for 32, counted in tiles of 2 / `tiles`; of clipped
// triangles 8 u of the size across and 8 u of it times the place along the depth on top of it, over the least depth: 24 u, with room
// for 32. Depths alike. The last term is what a place loses where it is counted in up to 512 tiles.
fn with_losses(bounds: PolygonState, size: f32, tiles: f32) -> PolygonState {
    var state = bounds;
    let clip_loss = 1.9073486328125e-6 * size * state.high.z;
    state.place_loss = (clip_loss + 1.9073486328125e-6) * 0.5 * tiles + 6.103515625e-5;
    state.depth_loss = (clip_loss + 1.9073486328125e-6) * state.high.z;
    return state;
}

// A whole triangle, divided.
struct Whole {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    state: PolygonState,
}

fn make_whole(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, size: f32, tiles: f32) -> Whole {
    let least = 0.5 * size * MIN_DEPTH;
    let first = divided(a, least, tiles);
    let second = divided(b, least, tiles);
    let third = divided(c, least, tiles);
    let low = min(min(first, second), third);
    let high = max(max(first, second), third);
    let turn = cross(second - first, third - first);
    return Whole(first, second, third, with_losses(PolygonState(3u, 0.0, 0.0, low, high, turn), size, tiles));
}

// Makes the polygon of a triangle whose corners stand as a face has them, less the eye, with this size; `tiles` along the face's edge.
fn make_polygon(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, size: f32, tiles: f32) -> PolygonState {
    let least = size * MIN_DEPTH;
    polygon[0] = a;
    polygon[1] = b;
    polygon[2] = c;
    var count = clip_polygon(3u, vec3<f32>(0.0, 0.0, 1.0), least);
    if (count > 0u) {
        count = clip_polygon(count, vec3<f32>(-1.0, 0.0, 2.0), 0.0);
    }
    if (count > 0u) {
        count = clip_polygon(count, vec3<f32>(1.0, 0.0, 2.0), 0.0);
    }
    if (count > 0u) {
        count = clip_polygon(count, vec3<f32>(0.0, -1.0, 2.0), 0.0);
    }
    if (count > 0u) {
        count = clip_polygon(count, vec3<f32>(0.0, 1.0, 2.0), 0.0);
    }
    if (count < 3u) {
        return no_polygon();
    }
    var state = no_polygon();
    state.count = count;
    for (var corner = 0u; corner < count; corner++) {
        // Rounding may leave a point that was clipped a little nearer.
        let at = divided(polygon[corner], 0.5 * least, tiles);
        polygon[corner] = at;
        state.low = min(state.low, at);
        state.high = max(state.high, at);
    }
    // Newell's sum, from the first corner.
    let first = polygon[0];
    for (var corner = 1u; corner + 1u < count; corner++) {
        state.turn += cross(polygon[corner] - first, polygon[corner + 1u] - first);
    }
    return with_losses(state, size, tiles);
}

// The tiles that the polygon may touch, each grown by `margin`: the first, and one behind the last.
fn tiles_of(state: PolygonState, tiles: u32, margin: f32) -> vec4<u32> {
    let low = clamp(floor(state.low.xy - margin), vec2<f32>(0.0), vec2<f32>(f32(tiles)));
    let high = clamp(floor(state.high.xy + margin) + 1.0, vec2<f32>(0.0), vec2<f32>(f32(tiles)));
    return vec4<u32>(vec2<u32>(low), vec2<u32>(high));
}

// By how much tiles are grown for a polygon, tiles.
fn margin_of(state: PolygonState, tile_margin: f32) -> f32 {
    return tile_margin + state.place_loss;
}

// By how much w by the polygon's plane may be off: the more, the thinner its area is beside its extent, and no more than all of its w.
fn plane_loss_of(state: PolygonState) -> f32 {
    let extent = state.high - state.low;
    let across = dot(extent.xy, extent.xy);
    let thinness = across / max(max(abs(state.turn.z), across * 1e-6), 1e-30);
    return min(thinness * thinness * 4.76837158203125e-7, 1.0) * extent.z;
}

// A tile grown by its margin, and what of a polygon's edges has been seen of it.
struct Clipping {
    low: vec2<f32>,
    high: vec2<f32>,
    // The tile's corners: which side of every edge they are on.
    corner_x: vec4<f32>,
    corner_y: vec4<f32>,
    to_the_left: vec4<bool>,
    to_the_right: vec4<bool>,
    // A product of an edge's length with one within the polygon or round it is off by 4 u of it; twice that, of an edge of length 1. By the
    // edge's own length no corner counts that lies farther from it than from others: it would where parts are stored, and not in a row.
    edge_loss: f32,
    part: Part,
}

fn begin_clipping(state: PolygonState, tile: vec2<f32>, margin: f32) -> Clipping {
    let low = tile - margin;
    let high = tile + 1.0 + margin;
    let extent = state.high - state.low;
    return Clipping(
        low,
        high,
        vec4<f32>(low.x, high.x, low.x, high.x),
        vec4<f32>(low.y, low.y, high.y, high.y),
        vec4<bool>(true),
        vec4<bool>(true),
        (max(extent.x, extent.y) + 2.0) * 4.76837158203125e-7,
        NO_PART,
    );
}

// With another edge: the corners' sides of it, and its part within the tile (Liang, Barsky, "A New Concept and Method for Line Clipping",
// TOG 3(1), 1984). A step of 1e-12 tiles is none.
fn with_edge(before: Clipping, begin: vec3<f32>, end: vec3<f32>) -> Clipping {
    var clipping = before;
    let along = end - begin;
    let sides = along.x * (clipping.corner_y - begin.y) - along.y * (clipping.corner_x - begin.x);
    let loss = clipping.edge_loss * (abs(along.x) + abs(along.y));
    clipping.to_the_left = clipping.to_the_left & (sides >= vec4<f32>(-loss));
    clipping.to_the_right = clipping.to_the_right & (sides <= vec4<f32>(loss));
    let inverse = 1.0 / select(along.xy, vec2<f32>(1e-12), (abs(along.xy) < vec2<f32>(1e-12)));
    let to_low = (clipping.low - begin.xy) * inverse;
    let to_high = (clipping.high - begin.xy) * inverse;
    let nearer = min(to_low, to_high);
    let farther = max(to_low, to_high);
    let enters = max(max(nearer.x, nearer.y), 0.0);
    let leaves = min(min(farther.x, farther.y), 1.0);
    if (enters <= leaves) {
        let one = begin + along * enters;
        let other = begin + along * leaves;
        clipping.part.low = min(clipping.part.low, min(one, other));
        clipping.part.high = max(clipping.part.high, max(one, other));
    }
    return clipping;
}

// What lies in the tile, by all edges: its corners within the polygon, too. There the polygon reaches the tile's corner, and its depth is
// that of its plane through its first corner.
fn end_clipping(clipping: Clipping, state: PolygonState, first: vec3<f32>) -> Part {
    var part = clipping.part;
    let corner_x = clipping.corner_x;
    let corner_y = clipping.corner_y;
    let on_x = (corner_x >= vec4<f32>(state.low.x)) & (corner_x <= vec4<f32>(state.high.x));
    let on_y = (corner_y >= vec4<f32>(state.low.y)) & (corner_y <= vec4<f32>(state.high.y));
    let inside = (clipping.to_the_left | clipping.to_the_right) & on_x & on_y;
    if (any(inside)) {
        let extent = state.high - state.low;
        let across = dot(extent.xy, extent.xy);
        let plane_loss = plane_loss_of(state);
        // Of what is as good as an edge any of its depths will do: the loss is all of them.
        let is_edge = abs(state.turn.z) <= max(across * 1e-6, 1e-30);
        let slope = select(-state.turn.xy / select(state.turn.z, 1.0, is_edge), vec2<f32>(0.0), is_edge);
        let plane = first.z + slope.x * (corner_x - first.x) + slope.y * (corner_y - first.y);
        let depths = clamp(plane, vec4<f32>(state.low.z), vec4<f32>(state.high.z));
        let least = clamp(depths - plane_loss, vec4<f32>(state.low.z), vec4<f32>(state.high.z));
        let greatest = clamp(depths + plane_loss, vec4<f32>(state.low.z), vec4<f32>(state.high.z));
        let lows = select(vec4<f32>(1e30), least, inside);
        let highs = select(vec4<f32>(-1e30), greatest, inside);
        let x_lows = select(vec4<f32>(1e30), corner_x, inside);
        let x_highs = select(vec4<f32>(-1e30), corner_x, inside);
        let y_lows = select(vec4<f32>(1e30), corner_y, inside);
        let y_highs = select(vec4<f32>(-1e30), corner_y, inside);
        part.low = min(part.low, vec3<f32>(min_of(x_lows), min_of(y_lows), min_of(lows)));
        part.high = max(part.high, vec3<f32>(-min_of(-x_highs), -min_of(-y_highs), -min_of(-highs)));
    }
    return part;
}

// The part of a whole triangle in a tile that is grown by `margin`, with its losses.
fn whole_in_tile(whole: Whole, tile: vec2<f32>, margin: f32) -> Part {
    var clipping = begin_clipping(whole.state, tile, margin);
    clipping = with_edge(clipping, whole.a, whole.b);
    clipping = with_edge(clipping, whole.b, whole.c);
    clipping = with_edge(clipping, whole.c, whole.a);
    return end_clipping(clipping, whole.state, whole.a);
}

// Beyond all tiles.
const FAR_ACROSS: f32 = 65536.0;

// A row of tiles in the place of one.
fn begin_row(state: PolygonState, row: f32, margin: f32) -> Clipping {
    var clipping = begin_clipping(state, vec2<f32>(0.0, row), margin);
    clipping.low.x = -FAR_ACROSS;
    clipping.high.x = FAR_ACROSS;
    clipping.corner_x = vec4<f32>(-FAR_ACROSS, FAR_ACROSS, -FAR_ACROSS, FAR_ACROSS);
    return clipping;
}

// The part of a whole triangle in a row of tiles that is grown by `margin`: what is convex touches every tile of the row between its ends.
fn whole_in_row(whole: Whole, row: f32, margin: f32) -> Part {
    var clipping = begin_row(whole.state, row, margin);
    clipping = with_edge(clipping, whole.a, whole.b);
    clipping = with_edge(clipping, whole.b, whole.c);
    return with_edge(clipping, whole.c, whole.a).part;
}

// The same of the polygon.
fn polygon_in_row(state: PolygonState, row: f32, margin: f32) -> Part {
    var clipping = begin_row(state, row, margin);
    var begin = polygon[state.count - 1u];
    for (var corner = 0u; corner < state.count; corner++) {
        let end = polygon[corner];
        clipping = with_edge(clipping, begin, end);
        begin = end;
    }
    return clipping.part;
}

// The part of the polygon in a tile.
fn polygon_in_tile(state: PolygonState, tile: vec2<f32>, margin: f32) -> Part {
    var clipping = begin_clipping(state, tile, margin);
    var begin = polygon[state.count - 1u];
    for (var corner = 0u; corner < state.count; corner++) {
        let end = polygon[corner];
        clipping = with_edge(clipping, begin, end);
        begin = end;
    }
    return end_clipping(clipping, state, polygon[0]);
}

fn min_of(values: vec4<f32>) -> f32 {
    return min(min(values.x, values.y), min(values.z, values.w));
}

fn is_part(part: Part) -> bool {
    return part.low.x <= part.high.x;
}

// The part with the polygon's losses, within the depths that a triangle of this size has: w is no less than one over the size.
fn grown_part(state: PolygonState, part: Part, size: f32) -> Part {
    let farthest = (1.0 - 3.814697265625e-6) / size;
    let loss = vec3<f32>(vec2<f32>(state.place_loss), state.depth_loss);
    let low = part.low - loss;
    return Part(vec3<f32>(low.xy, max(low.z, farthest)), part.high + loss);
}
