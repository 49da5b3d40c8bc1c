// Mipmaps of the depth bounds (section 4.1.1): a tile of a level bounds the four below it.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::pyramid::{level_size, cell_below}
#import tracebench::dirt_grid::{TileGrid, bounds_index}

struct MipmapLevel {
    // The level to make, from 1.
    level: u32,
    views: u32,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> grid: TileGrid;
@group(0) @binding(1) var<uniform> made: MipmapLevel;
@group(0) @binding(2) var<storage, read_write> bounds: array<vec2<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn mipmap(invocation: Invocation) {
    let tiles = level_size(grid.tiles, made.level);
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    let view = index / (tiles.x * tiles.y);
    if (view >= made.views) {
        return;
    }
    let within = index % (tiles.x * tiles.y);
    let tile = vec2<u32>(within % tiles.x, within / tiles.x);
    let finer = made.level - 1u;
    let first_finer = grid.level_offsets[finer >> 2u][finer & 3u];
    var codes = vec2<u32>(0u);
    for (var child = 0u; child < 4u; child++) {
        let below = cell_below(grid.tiles, made.level, tile, child);
        codes = max(codes, bounds[bounds_index(grid, first_finer, view, finer, below)]);
    }
    let first = grid.level_offsets[made.level >> 2u][made.level & 3u];
    bounds[bounds_index(grid, first, view, made.level, tile)] = codes;
}
