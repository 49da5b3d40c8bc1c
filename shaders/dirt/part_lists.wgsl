// The build of the packed forms of DIRT up to the sort: triangles are measured, their parts counted, then stored with keys.
//
// Parts get their places from prefix sums over the triangles' counts, so that the order of parts of equal keys, which a stable sort
// keeps, is that of triangles in every run. Parts are counted in tiles that are grown by a little more than those that they are stored
// in: whatever rounding makes of the same numbers in two kernels, there is a place for every part. Places that are not taken have key 0
// and come first in the order.
//
// Neighbouring lanes do alike work, since many devices run them together: a triangle that lies in one tile is done at once; of others every
// face that they may touch waits for a lane that clips it to each of its tiles, or, where these are many or something must be clipped off
// before it is divided, for a workgroup.

#import tracebench::dispatch::{Invocation, linear_invocation, linear_workgroup}
#import tracebench::dirt_packed_grid::{
    PackedGrid, NEAREST, FARTHEST, NEAR_COUNT, NEAR_CUBE, SLICE_BASE, SLICE_RATE, MISPLACED, SEVERAL_COUNT, LARGE_COUNT, FIRST_NEAR,
    FACES, TILE_MARGIN, BOX_MARGIN, BOX_STEP, tile_number, cell_number, first_corner, listed_cube, slice_of, slices_between
}
#import tracebench::dirt_corners::{Corners, corners_less_eye, seen_from, face_towards, distance_to_triangle}
#import tracebench::dirt_parts::{
    MIN_DEPTH, PolygonState, Whole, Part, is_outside, is_whole, make_whole, make_polygon, tiles_of, margin_of, plane_loss_of,
    whole_in_tile, polygon_in_tile, whole_in_row, polygon_in_row, is_part, grown_part
}

@group(0) @binding(0) var<uniform> grid: PackedGrid;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
// A quad a tile, then three a triangle: its corners.
@group(0) @binding(3) var<storage, read_write> quads: array<vec4<u32>>;
// What is found, triangles near the eye, references.
@group(0) @binding(4) var<storage, read_write> words: array<atomic<u32>>;
// Of every triangle its parts, then, by the prefix sum, the place of the first; and one more for the end of all.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
// Two words a triangle: one more than the face of one that lies in a single tile, and the places that it has taken. Then six a triangle:
// those that wait, by 6 times the triangle and the face; for a lane from the first word on, for a workgroup from the last one down.
@group(0) @binding(6) var<storage, read_write> plans: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> keys: array<u32>;
// A box in bytes (x, then y, least and greatest), the bits of the least and greatest w, the triangle.
@group(0) @binding(8) var<storage, read_write> parts: array<vec4<u32>>;
// The part of every key, before and after the sort.
@group(0) @binding(9) var<storage, read_write> places: array<u32>;
// Two words a cell: its mask. Then two a tile: the bits of its greatest w, and the complement of those of its least.
@group(0) @binding(10) var<storage, read_write> masks: array<atomic<u32>>;

const WORKGROUP_SIZE: u32 = 64u;
// Tiles of a face that one lane goes over.
const MAX_TILES: u32 = 32u;
// Tiles that are counted without clipping.
const FEW_TILES: u32 = 6u;
// Workgroups that take what waits for one in turns.
const LARGE_WORKGROUPS: u32 = 256u;
// By how much more tiles are grown where parts are counted, tiles.
const COUNT_MARGIN: f32 = 0.00390625;

fn load_corners(triangle: u32) -> Corners {
    let first = first_corner(grid, triangle);
    return corners_less_eye(
        grid.eye, bitcast<vec3<f32>>(quads[first].xyz), bitcast<vec3<f32>>(quads[first + 1u].xyz), bitcast<vec3<f32>>(quads[first + 2u].xyz),
    );
}

// Of this workgroup: as NEAREST, FARTHEST and NEAR_CUBE.
var<workgroup> nearest_here: atomic<u32>;
var<workgroup> farthest_here: atomic<u32>;
var<workgroup> cube_here: atomic<u32>;

// Corners into their record, how near each triangle may come, the depths that there are, and the cube in which tiles do not hold all.
@compute @workgroup_size(WORKGROUP_SIZE)
fn measure(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle < grid.triangle_count) {
        var corners: array<vec3<f32>, 3>;
        for (var corner = 0u; corner < 3u; corner++) {
            let vertex = indices[triangle * 3u + corner] * 3u;
            corners[corner] = vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
        }
        let near = corners_less_eye(grid.eye, corners[0], corners[1], corners[2]);
        // Of a triangle that is a point in the eye nothing is stored or tested.
        var may_come = 1e30;
        if (near.size > 0.0) {
            let distance = distance_to_triangle(near.a / near.size, near.b / near.size, near.c / near.size);
            // Twice what the distance is off by: as good as none where it is below sqrt(3) MIN_DEPTH, too.
            let least = max(distance - 4.8828125e-4, 0.0);
            may_come = least * near.size;
            if (least == 0.0) {
                atomicMax(&cube_here, bitcast<u32>(near.size * MIN_DEPTH * 1.015625));
            }
            let depth = max(least * 0.57, MIN_DEPTH * 0.984375) * near.size;
            atomicMax(&nearest_here, bitcast<u32>(1.0 / depth));
            atomicMax(&farthest_here, ~bitcast<u32>((1.0 - 3.814697265625e-6) / near.size));
        }
        for (var corner = 0u; corner < 3u; corner++) {
            quads[first_corner(grid, triangle) + corner] = vec4<u32>(bitcast<vec3<u32>>(corners[corner]), bitcast<u32>(may_come));
        }
    }
    workgroupBarrier();
    if (invocation.local == 0u && atomicLoad(&nearest_here) > 0u) {
        atomicMax(&words[NEAREST], atomicLoad(&nearest_here));
        atomicMax(&words[FARTHEST], atomicLoad(&farthest_here));
        atomicMax(&words[NEAR_CUBE], atomicLoad(&cube_here));
    }
}

// Slices follow the depths that there are; what is nearer than 16 powers of two before the farthest is in the nearest slice.
@compute @workgroup_size(1)
fn scale() {
    let farthest = select(~atomicLoad(&words[FARTHEST]), grid.fixed_far, grid.fixed_slices == 1u);
    let nearest = select(atomicLoad(&words[NEAREST]), grid.fixed_near, grid.fixed_slices == 1u);
    let range = min(max(nearest, farthest) - farthest, 16u << 23u) + 1u;
    atomicStore(&words[SLICE_BASE], farthest);
    atomicStore(&words[SLICE_RATE], bitcast<u32>(f32(grid.slices) / f32(range)));
}

fn slice_at(w: f32) -> u32 {
    return slice_of(w, atomicLoad(&words[SLICE_BASE]), bitcast<f32>(atomicLoad(&words[SLICE_RATE])), grid.slices);
}

fn whole_of(seen: Corners) -> Whole {
    return make_whole(seen.a, seen.b, seen.c, seen.size, f32(grid.tiles));
}

// Keys that a part takes in a tile, at most. Depths are held wider than where parts are stored, by what their planes may be off there.
fn keys_of(state: PolygonState, part: Part, size: f32) -> u32 {
#ifdef SLICES
    let grown = grown_part(state, part, size);
    let loss = plane_loss_of(state);
    let least = max(grown.low.z - loss, 0.0) * 0.999;
    return slice_at((grown.high.z + loss) * 1.001) - slice_at(least) + 1u;
#else
    return 1u;
#endif
}

fn margin_counted(state: PolygonState) -> f32 {
    return margin_of(state, TILE_MARGIN) + COUNT_MARGIN;
}

// Parts of triangles that lie in one tile, what waits, and what is listed near the eye.
@compute @workgroup_size(WORKGROUP_SIZE)
fn count(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle >= grid.triangle_count) {
        return;
    }
    let corners = load_corners(triangle);
    let may_come = bitcast<f32>(quads[first_corner(grid, triangle)].w);
    // A little more, for what rounding makes of it elsewhere.
    if (may_come <= 1.76 * listed_cube(grid.tiles, atomicLoad(&words[FARTHEST]))) {
        atomicStore(&words[FIRST_NEAR + atomicAdd(&words[NEAR_COUNT], 1u)], triangle);
    }
    let own = face_towards(corners.a + corners.b + corners.c);
    let own_seen = seen_from(own, corners);
    if (is_whole(own_seen.a, own_seen.b, own_seen.c, corners.size)) {
        let state = whole_of(own_seen).state;
        let margin = margin_counted(state);
        let tiles = tiles_of(state, grid.tiles, margin);
        // As far from the face's border no other face has it.
        let is_inner = all(state.low.xy >= vec2<f32>(2.0 * margin)) && all(state.high.xy <= vec2<f32>(f32(grid.tiles) - 2.0 * margin));
        if (is_inner && tiles.z - tiles.x == 1u && tiles.w - tiles.y == 1u) {
            atomicStore(&plans[2u * triangle], own + 1u);
            atomicStore(&counts[triangle], keys_of(state, Part(state.low, state.high), corners.size));
            return;
        }
    }
    for (var face = 0u; face < FACES; face++) {
        let seen = seen_from(face, corners);
        if (is_outside(seen.a, seen.b, seen.c, corners.size)) {
            continue;
        }
        var covered = MAX_TILES + 1u;
        if (is_whole(seen.a, seen.b, seen.c, corners.size)) {
            let state = whole_of(seen).state;
            let tiles = tiles_of(state, grid.tiles, margin_counted(state));
            covered = tiles_within(tiles);
        }
        if (covered > MAX_TILES) {
            let place = atomicAdd(&words[LARGE_COUNT], 1u);
            atomicStore(&plans[8u * grid.triangle_count - 1u - place], triangle * FACES + face);
        } else if (covered > 0u) {
            let place = atomicAdd(&words[SEVERAL_COUNT], 1u);
            atomicStore(&plans[2u * grid.triangle_count + place], triangle * FACES + face);
        }
    }
}

// The tile of a polygon's rectangle with this number.
fn tile_in(tiles: vec4<u32>, number: u32) -> vec2<u32> {
    let across = tiles.z - tiles.x;
    return tiles.xy + vec2<u32>(number % across, number / across);
}

fn tiles_within(tiles: vec4<u32>) -> u32 {
    return select((tiles.z - tiles.x) * (tiles.w - tiles.y), 0u, any(tiles.zw <= tiles.xy));
}

// Tiles of a rectangle's row that what lies in it touches.
fn tiles_along(tiles: vec4<u32>, part: Part, margin: f32) -> u32 {
    let first = clamp(floor(part.low.x - margin), f32(tiles.x), f32(tiles.z));
    let end = clamp(floor(part.high.x + margin) + 1.0, f32(tiles.x), f32(tiles.z));
    return select(0u, u32(end - first), is_part(part));
}

// Those that wait, a lane each.
@compute @workgroup_size(WORKGROUP_SIZE)
fn count_several(invocation: Invocation) {
    let waiting = atomicLoad(&words[SEVERAL_COUNT]);
    let lanes = invocation.workgroups.x * invocation.workgroups.y * WORKGROUP_SIZE;
    for (var item = linear_invocation(invocation, WORKGROUP_SIZE); item < waiting; item += lanes) {
        let coded = atomicLoad(&plans[2u * grid.triangle_count + item]);
        let triangle = coded / FACES;
        let seen = seen_from(coded % FACES, load_corners(triangle));
        let whole = whole_of(seen);
        let margin = margin_counted(whole.state);
        let tiles = tiles_of(whole.state, grid.tiles, margin);
        let covered = tiles_within(tiles);
        var total = covered;
#ifdef SLICES
        total = 0u;
        for (var number = 0u; number < covered; number++) {
            let part = whole_in_tile(whole, vec2<f32>(tile_in(tiles, number)), margin);
            if (is_part(part)) {
                total += keys_of(whole.state, part, seen.size);
            }
        }
#else
        if (covered > FEW_TILES) {
            total = 0u;
            for (var row = tiles.y; row < tiles.w; row++) {
                total += tiles_along(tiles, whole_in_row(whole, f32(row), margin), margin);
            }
        }
#endif
        atomicAdd(&counts[triangle], total);
    }
}

// A triangle that waits for a workgroup, in a face: divided, or clipped first into the polygon.
struct Large {
    triangle: u32,
    face: u32,
    size: f32,
    is_divided: bool,
    whole: Whole,
}

fn load_large(item: u32) -> Large {
    let coded = atomicLoad(&plans[8u * grid.triangle_count - 1u - item]);
    let seen = seen_from(coded % FACES, load_corners(coded / FACES));
    var large: Large;
    large.triangle = coded / FACES;
    large.face = coded % FACES;
    large.size = seen.size;
    large.is_divided = is_whole(seen.a, seen.b, seen.c, seen.size);
    if (large.is_divided) {
        large.whole = whole_of(seen);
    } else {
        large.whole.state = make_polygon(seen.a, seen.b, seen.c, seen.size, f32(grid.tiles));
    }
    return large;
}

fn large_in_tile(large: Large, tile: vec2<u32>, margin: f32) -> Part {
    if (large.is_divided) {
        return whole_in_tile(large.whole, vec2<f32>(tile), margin);
    }
    return polygon_in_tile(large.whole.state, vec2<f32>(tile), margin);
}

fn large_in_row(large: Large, row: u32, margin: f32) -> Part {
    if (large.is_divided) {
        return whole_in_row(large.whole, f32(row), margin);
    }
    return polygon_in_row(large.whole.state, f32(row), margin);
}

// Those that wait for a workgroup.
@compute @workgroup_size(WORKGROUP_SIZE)
fn count_large(invocation: Invocation) {
    let waiting = atomicLoad(&words[LARGE_COUNT]);
    for (var item = linear_workgroup(invocation); item < waiting; item += LARGE_WORKGROUPS) {
        let large = load_large(item);
        let state = large.whole.state;
        if (state.count == 0u) {
            continue;
        }
        let margin = margin_counted(state);
        let tiles = tiles_of(state, grid.tiles, margin);
        var total = 0u;
#ifdef SLICES
        let covered = tiles_within(tiles);
        for (var number = invocation.local; number < covered; number += WORKGROUP_SIZE) {
            let part = large_in_tile(large, tile_in(tiles, number), margin);
            if (is_part(part)) {
                total += keys_of(state, part, large.size);
            }
        }
#else
        for (var row = tiles.y + invocation.local; row < tiles.w; row += WORKGROUP_SIZE) {
            total += tiles_along(tiles, large_in_row(large, row, margin), margin);
        }
#endif
        if (total > 0u) {
            atomicAdd(&counts[large.triangle], total);
        }
    }
}

// Four bits, each three places from the next one.
fn spread(bits: u32) -> u32 {
    return (bits & 1u) | ((bits & 2u) << 2u) | ((bits & 4u) << 4u) | ((bits & 8u) << 6u);
}

// The place of a part along the tile's curve: Morton's, led by depth: 9 bits of depth over all slices, 4 each across and upward, of which
// more would lead nodes apart in depth.
fn order_of(box: u32, min_w: f32, max_w: f32) -> u32 {
    let middle = (bitcast<u32>(min_w) >> 1u) + (bitcast<u32>(max_w) >> 1u);
    let base = atomicLoad(&words[SLICE_BASE]);
    let rate = bitcast<f32>(atomicLoad(&words[SLICE_RATE])) * 512.0 / f32(grid.slices);
    let depth = min(u32(f32(max(middle, base) - base) * rate), 511u);
    let x = ((box & 0xffu) + ((box >> 8u) & 0xffu)) >> 5u;
    let y = (((box >> 16u) & 0xffu) + (box >> 24u)) >> 5u;
    let curve = ((depth >> 4u) << 12u) | (spread(depth & 15u) << 2u) | (spread(x) << 1u) | spread(y);
    return curve >> (17u - min(grid.order_bits, 17u));
}

fn code_below(at: f32) -> u32 {
    return u32(clamp(floor((at + BOX_MARGIN) / BOX_STEP), 0.0, 254.0));
}

fn code_above(at: f32) -> u32 {
    return u32(clamp(ceil((at + BOX_MARGIN) / BOX_STEP), 1.0, 255.0));
}

fn store_key(triangle: u32, key: u32, part: vec4<u32>) {
    let place = atomicLoad(&counts[triangle]) + atomicAdd(&plans[2u * triangle + 1u], 1u);
    if (place >= atomicLoad(&counts[triangle + 1u])) {
        atomicAdd(&words[MISPLACED], 1u);
        return;
    }
    // Beyond the capacity nothing is stored: the host sees by the sum of all what is missing.
    if (place < grid.part_capacity) {
        keys[place] = key;
        parts[place] = part;
        places[place] = place;
    }
}

fn store_part(face: u32, state: PolygonState, tile: vec2<u32>, touched: Part, size: f32, triangle: u32) {
    let part = grown_part(state, touched, size);
    let low = part.low.xy - vec2<f32>(tile);
    let high = part.high.xy - vec2<f32>(tile);
    let box = code_below(low.x) | (code_above(high.x) << 8u) | (code_below(low.y) << 16u) | (code_above(high.y) << 24u);
    let stored = vec4<u32>(box, bitcast<u32>(part.low.z), bitcast<u32>(part.high.z), triangle);
    let number = tile_number(grid, face, tile);
    let first = slice_at(part.low.z);
    let last = slice_at(part.high.z);
#ifdef SLICES
    for (var slice = first; slice <= last; slice++) {
        store_key(triangle, ((number + 1u) << grid.order_bits) | slice, stored);
    }
#else
    store_key(triangle, ((number + 1u) << grid.order_bits) | order_of(box, part.low.z, part.high.z), stored);
#endif
    let mask = slices_between(first, last);
    let cell = 2u * cell_number(grid, face, 0u, tile);
    if (mask.x != 0u) {
        atomicOr(&masks[cell], mask.x);
    }
    if (mask.y != 0u) {
        atomicOr(&masks[cell + 1u], mask.y);
    }
    let range = 2u * (FACES * grid.cells + number);
    atomicMax(&masks[range], stored.z);
    atomicMax(&masks[range + 1u], ~stored.y);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn store(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle >= grid.triangle_count) {
        return;
    }
    let face = atomicLoad(&plans[2u * triangle]);
    if (face == 0u) {
        return;
    }
    let seen = seen_from(face - 1u, load_corners(triangle));
    let state = whole_of(seen).state;
    let tile = vec2<u32>((state.low.xy + state.high.xy) * 0.5);
    store_part(face - 1u, state, tile, Part(state.low, state.high), seen.size, triangle);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn store_several(invocation: Invocation) {
    let waiting = atomicLoad(&words[SEVERAL_COUNT]);
    let lanes = invocation.workgroups.x * invocation.workgroups.y * WORKGROUP_SIZE;
    for (var item = linear_invocation(invocation, WORKGROUP_SIZE); item < waiting; item += lanes) {
        let coded = atomicLoad(&plans[2u * grid.triangle_count + item]);
        let triangle = coded / FACES;
        let seen = seen_from(coded % FACES, load_corners(triangle));
        let whole = whole_of(seen);
        let margin = margin_of(whole.state, TILE_MARGIN);
        let tiles = tiles_of(whole.state, grid.tiles, margin);
        let covered = tiles_within(tiles);
        for (var number = 0u; number < covered; number++) {
            let tile = tile_in(tiles, number);
            let part = whole_in_tile(whole, vec2<f32>(tile), margin);
            if (is_part(part)) {
                store_part(coded % FACES, whole.state, tile, part, seen.size, triangle);
            }
        }
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn store_large(invocation: Invocation) {
    let waiting = atomicLoad(&words[LARGE_COUNT]);
    for (var item = linear_workgroup(invocation); item < waiting; item += LARGE_WORKGROUPS) {
        let large = load_large(item);
        let state = large.whole.state;
        if (state.count == 0u) {
            continue;
        }
        let margin = margin_of(state, TILE_MARGIN);
        let tiles = tiles_of(state, grid.tiles, margin);
        let covered = tiles_within(tiles);
        for (var number = invocation.local; number < covered; number += WORKGROUP_SIZE) {
            let tile = tile_in(tiles, number);
            let part = large_in_tile(large, tile, margin);
            if (is_part(part)) {
                store_part(large.face, state, tile, part, large.size, large.triangle);
            }
        }
    }
}
