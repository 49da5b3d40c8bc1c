#define_import_path tracebench::raster_work

// How triangles are dealt out where they are rasterized in compute: small ones a lane each; large ones are divided into blocks of the
// image, a workgroup each, as many workgroups as raster_setup.wgsl has found blocks. A pass is
//
//     let part = part_of(invocation);
//     if (all(part.low < part.high)) {
//         // Of triangle `part.triangle` the pixels from part.low to before part.high.
//     }
//
// All lanes make outlines by the same instructions, whatever part is theirs, so that the parts of a triangle, and neighbours of
// different sizes, fit.

#import tracebench::dispatch::{Invocation, linear_workgroup}

struct RasterPass {
    // Pixels.
    size: vec2<u32>,
    triangle_count: u32,
    // Workgroups whose lanes take a triangle each; those behind them take blocks.
    lane_groups: u32,
    // Pixels of a rectangle up to which a triangle in it is small.
    small_pixels: u32,
    // 1: pixels count that a triangle touches anywhere, not those whose centres it covers.
    touched: u32,
    padding: vec2<u32>,
}

@group(1) @binding(0) var<uniform> raster: RasterPass;
// Of every triangle the blocks of all before it, and last their sum; then of every triangle its first block, column (10 bits) and row (10
// bits), and its columns of blocks (11 bits), or NOT_SEEN.
@group(1) @binding(1) var<storage, read> work: array<u32>;

// Lanes of a workgroup.
const RASTER_LANES: u32 = 64u;

// Pixels of a block's edge, of which a lane takes half a row.
const BLOCK_EDGE: u32 = 32u;
const HALF_ROW: u32 = 16u;

// In place of the first block of a triangle that has no pixel.
const NOT_SEEN: u32 = 0xffffffffu;

// Pixels of a triangle; none where `high` is not beyond `low`.
struct RasterPart {
    triangle: u32,
    low: vec2<i32>,
    high: vec2<i32>,
}

const NO_PART: RasterPart = RasterPart(0u, vec2<i32>(0), vec2<i32>(0));

// The triangle that a block is of: the last that begins at it or before. Those without blocks begin where the next one does.
fn triangle_of_block(block: u32) -> u32 {
    var low = 0u;
    var high = raster.triangle_count;
    while (high - low > 1u) {
        let middle = low + (high - low) / 2u;
        if (work[middle] <= block) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// What a lane draws.
fn part_of(invocation: Invocation) -> RasterPart {
    let workgroup = linear_workgroup(invocation);
    let local = invocation.local;
    let places = raster.triangle_count + 1u;
    let size = vec2<i32>(raster.size);
    if (workgroup < raster.lane_groups) {
        let triangle = workgroup * RASTER_LANES + local;
        if (triangle >= raster.triangle_count) {
            return NO_PART;
        }
        if (work[triangle] != work[triangle + 1u] || work[places + triangle] == NOT_SEEN) {
            return NO_PART;
        }
        return RasterPart(triangle, vec2<i32>(0), size);
    }
    let at = workgroup - raster.lane_groups;
    // A folded dispatch may have more workgroups than there are blocks.
    if (at >= work[raster.triangle_count]) {
        return NO_PART;
    }
    let triangle = triangle_of_block(at);
    let place = work[places + triangle];
    let columns = place >> 20u;
    let number = at - work[triangle];
    let block = vec2<u32>((place & 1023u) + number % columns, ((place >> 10u) & 1023u) + number / columns);
    let low = block * BLOCK_EDGE + vec2<u32>((local & 1u) * HALF_ROW, local >> 1u);
    return RasterPart(triangle, vec2<i32>(low), min(vec2<i32>(low + vec2<u32>(HALF_ROW, 1u)), size));
}
