#define_import_path tracebench::dirt_grid

// The layout of DIRT's structure: depth bounds with their pyramid, heads of lists, nodes.

#import tracebench::view::View

// Views are numbered; each has `tiles` tiles, levels of a pyramid over them, and `buckets` lists a tile.
struct TileGrid {
    tiles: vec2<u32>,
    levels: u32,
    buckets: u32,
    // Entries from one view's part to the next one's: pairs of depth bounds, heads.
    bounds_stride: u32,
    heads_stride: u32,
    // Nodes that there is room for.
    node_capacity: u32,
    // Nodes of one buffer, where one binding does not hold all.
    nodes_per_part: u32,
    // First pair of depth bounds of each level in a view, four a vector.
    level_offsets: array<vec4<u32>, 4>,
}

// A link of a list: one more than the index of the next node, or 0 at the end.
struct Node {
    next: u32,
    primitive: u32,
}

// Tiles of a level, in each direction half of those below, rounded up.
fn level_tiles(grid: TileGrid, level: u32) -> vec2<u32> {
    return (grid.tiles + ((1u << level) - 1u)) >> vec2<u32>(level);
}

fn bounds_index(grid: TileGrid, view: u32, level: u32, tile: vec2<u32>) -> u32 {
    let offset = grid.level_offsets[level >> 2u][level & 3u];
    return view * grid.bounds_stride + offset + tile.y * level_tiles(grid, level).x + tile.x;
}

fn head_index(grid: TileGrid, view: u32, tile: vec2<u32>, bucket: u32) -> u32 {
    return view * grid.heads_stride + (tile.y * grid.tiles.x + tile.x) * grid.buckets + bucket;
}

// Both bounds are stored so that they grow and 0 is nothing: the bits of a positive depth, and for the near bound their
// complement (the released code stores it negated; one maximum filter serves both).
fn near_code(depth: f32) -> u32 {
    return ~bitcast<u32>(depth);
}

fn far_code(depth: f32) -> u32 {
    return bitcast<u32>(depth);
}

// Near and far depth of a pair of codes; near > far for nothing.
fn depths_of(codes: vec2<u32>) -> vec2<f32> {
    if (codes.y == 0u) {
        return vec2<f32>(1e38, -1e38);
    }
    return vec2<f32>(bitcast<f32>(~codes.x), bitcast<f32>(codes.y));
}

// The bucket of a depth (equations 1a and 1b), held within the buckets: the far bound itself belongs to the last.
fn bucket_of(depth: f32, bounds: vec2<f32>, buckets: u32) -> u32 {
    let range = bounds.y - bounds.x;
    if (range <= 0.0) {
        return 0u;
    }
    let share = clamp((depth - bounds.x) / range, 0.0, 1.0);
    return min(u32(share * f32(buckets)), buckets - 1u);
}
