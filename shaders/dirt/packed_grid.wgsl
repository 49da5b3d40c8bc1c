#define_import_path tracebench::dirt_packed_grid

// The structure of the packed forms of DIRT, which are exact: six faces of 90 degrees round the eye along the world's axes, without a
// near plane, each of square tiles; of every tile a mask of the depth slices that hold something, with a pyramid over it, and its parts
// of triangles in a row.
//
// Space is projective: (x, y, w), where x and y count tiles of the face and w is one over the eye depth. Lines stay lines there and
// planes stay planes, so nothing is divided on the way.
//
// Depths are told apart by the bits of w. Those of positive numbers grow as the numbers do, and nearly as their logarithm: slices and
// the codes of boxes are integers made of them, and rounding enters in one direction alone.

#import tracebench::pyramid::index_in_level

struct PackedGrid {
    eye: vec3<f32>,
    // Along a face's edge.
    tiles: u32,
    triangle_count: u32,
    // Parts and nodes that there is room for.
    part_capacity: u32,
    node_capacity: u32,
    // Of the pyramid, the tiles are the first.
    levels: u32,
    // Cells of a face, all levels.
    cells: u32,
    // Depth slices of a tile, at most 64.
    slices: u32,
    // Bits of a key below its tile.
    order_bits: u32,
    // 1: slices span what follows, not the depths that there are.
    fixed_slices: u32,
    // Bits of w at the far and the near end of fixed slices.
    fixed_far: u32,
    fixed_near: u32,
    padding: vec2<u32>,
    // First cell of each level in a face, four a vector.
    level_offsets: array<vec4<u32>, 4>,
}

// The first words of the references: what is found on the way.
// Bits of the greatest w of all, 0 where there is nothing; the complement of those of the least.
const NEAREST: u32 = 0u;
const FARTHEST: u32 = 1u;
// Triangles near the eye, which are listed; bits of half the edge of the cube in which tiles do not hold all of some.
const NEAR_COUNT: u32 = 2u;
const NEAR_CUBE: u32 = 3u;
// Where slices begin, bits of w; slices a unit of these bits, bits of a float.
const SLICE_BASE: u32 = 4u;
const SLICE_RATE: u32 = 5u;
// Parts that had no place, which cannot be.
const MISPLACED: u32 = 6u;
// Triangles in faces that cover several tiles, and many.
const SEVERAL_COUNT: u32 = 7u;
const LARGE_COUNT: u32 = 8u;
// Triangles near the eye are listed from here on, then come the references.
const FIRST_NEAR: u32 = 9u;

// Tiles are grown by this on every side when they are filled, in tiles: half of it is what a ray may be off by (walk in packed_trace),
// the rest what rounding makes of positions counted in tiles, which is 2^-17 of a tile at most.
const TILE_MARGIN: f32 = 0.03125;

// The grid of boxes in a tile, in tiles: it begins so far before the tile and ends as far behind it.
const BOX_MARGIN: f32 = 0.0625;
const BOX_STEP: f32 = 0.0044117647;

const FACES: u32 = 6u;

// A vector as a face has it: across, upward, and depth along the face's axis. Faces look along +x, -x, +y, -y, +z, -z. Components are
// moved and turned round, never rounded.
fn to_face(face: u32, vector: vec3<f32>) -> vec3<f32> {
    let axis = face >> 1u;
    let by_y = select(vector, vector.zxy, (axis == 1u));
    let turned = select(by_y, vector.yzx, (axis == 0u));
    return vec3<f32>(turned.xy, select(turned.z, -turned.z, ((face & 1u) == 1u)));
}

fn tile_number(grid: PackedGrid, face: u32, tile: vec2<u32>) -> u32 {
    return (face * grid.tiles + tile.y) * grid.tiles + tile.x;
}

// Where a triangle's corners stand, a quad each: in its first, how near the eye it may come.
fn first_corner(grid: PackedGrid, triangle: u32) -> u32 {
    return FACES * grid.tiles * grid.tiles + 3u * triangle;
}

// Half the edge of the cube round the eye in which images are noise, of a ray whose origin is so far from the eye: beyond it places are off
// by half of TILE_MARGIN at most.
fn noisy_cube(tiles: u32, reach: f32) -> f32 {
    return reach * max(f32(tiles), 8.0) * 3.0517578125e-5;
}

// The cube that triangles are listed for: that of rays from four times as far as the scene reaches.
fn listed_cube(tiles: u32, farthest: u32) -> f32 {
    return 4.0 * noisy_cube(tiles, 1.0 / bitcast<f32>(~farthest));
}

// Where the mask of a cell stands.
fn cell_number(grid: PackedGrid, face: u32, level: u32, cell: vec2<u32>) -> u32 {
    let offset = grid.level_offsets[level >> 2u][level & 3u];
    return face * grid.cells + offset + index_in_level(vec2<u32>(grid.tiles), level, cell);
}

// The depth slice of a w. It never falls as w grows, so that two ranges of w with anything in common have a slice in common.
fn slice_of(w: f32, base: u32, rate: f32, slices: u32) -> u32 {
    // As signed numbers, which most devices convert in one step.
    let bits = bitcast<i32>(max(bitcast<u32>(w), base) - base);
    return min(u32(i32(f32(bits) * rate)), slices - 1u);
}

// The lowest so many of 64 bits.
fn lowest_bits(count: u32) -> vec2<u32> {
    let part = (1u << (count & 31u)) - 1u;
    let low = select(part, 0xffffffffu, (count >= 32u));
    let high = select(select(0u, part, (count > 32u)), 0xffffffffu, (count >= 64u));
    return vec2<u32>(low, high);
}

// The bits of slices from the first to the last.
fn slices_between(first: u32, last: u32) -> vec2<u32> {
    let from_first = 0xffffffffu << (first & 31u);
    let to_last = 0xffffffffu >> (31u - (last & 31u));
    let low = select(0u, from_first, (first < 32u)) & select(to_last, 0xffffffffu, (last >= 32u));
    let high = select(from_first, 0xffffffffu, (first < 32u)) & select(0u, to_last, (last >= 32u));
    return vec2<u32>(low, high);
}

// The nodes of a tile are a complete tree of eight children a node, in the order of a heap: the children of node i are 8 i + 1 to
// 8 i + 8, and the last level has as many as it needs. The first node of the last level, of so many parts.
fn first_leaf_of(parts: u32) -> u32 {
    var first = 0u;
    first = select(first, 1u, (parts > 8u));
    first = select(first, 9u, (parts > 64u));
    first = select(first, 73u, (parts > 512u));
    first = select(first, 585u, (parts > 4096u));
    first = select(first, 4681u, (parts > 32768u));
    first = select(first, 37449u, (parts > 262144u));
    return select(first, 299593u, (parts > 2097152u));
}

fn node_count_of(parts: u32) -> u32 {
    return select(first_leaf_of(parts) + ((parts + 7u) >> 3u), 0u, (parts == 0u));
}

// The scale of a tile's depth codes: w of a code is that whose bits are base + code * step. Both in one word, the base rounded down to
// 2^16 and the step up to 2^7, so that 254 steps reach from the least w of the tile to the greatest.
fn depth_scale(min_bits: u32, max_bits: u32) -> u32 {
    let base = min_bits >> 16u;
    let range = max_bits - (base << 16u);
    let step = ((range / 254u) >> 7u) + 1u;
    return (base << 16u) | min(step, 0xffffu);
}

fn depth_base(scale: u32) -> u32 {
    return scale & 0xffff0000u;
}

fn depth_step(scale: u32) -> u32 {
    return (scale & 0xffffu) << 7u;
}
