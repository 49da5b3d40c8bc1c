#define_import_path tracebench::dirt_grid

// The layout of DIRT's structure: depth bounds with their pyramid, heads of lists, nodes.

#import tracebench::pyramid::index_in_level

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

// Of a level, whose first is at `offset`: read by who has the uniform, since a table that is given as a value is copied for every lane.
fn bounds_index(grid: TileGrid, offset: u32, view: u32, level: u32, tile: vec2<u32>) -> u32 {
    return view * grid.bounds_stride + offset + index_in_level(grid.tiles, level, tile);
}

fn head_index(grid: TileGrid, view: u32, tile: vec2<u32>, bucket: u32) -> u32 {
    return view * grid.heads_stride + (tile.y * grid.tiles.x + tile.x) * grid.buckets + bucket;
}
