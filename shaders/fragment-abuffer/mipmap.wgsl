// The pyramid of depth bounds for marching by Hi-Z (section 3.4; Uludag, GPU Pro 5, 2014): a cell of a level bounds the four
// below it. The pixels' own bounds are the first level.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::pyramid::{level_size, cell_below}
#import tracebench::fragment_layout::{Storage, TracedView, word_index, pyramid_index}

@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(1) var<uniform> made: TracedView;
// The level to make, from 1 on.
@group(0) @binding(2) var<uniform> level: vec4<u32>;
@group(0) @binding(3) var<storage, read> pixels: array<u32>;
@group(0) @binding(4) var<storage, read_write> pyramid: array<vec2<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn mipmap(invocation: Invocation) {
    let size = vec2<u32>(made.view.size);
    let cells = level_size(size, level.x);
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= cells.x * cells.y) {
        return;
    }
    let cell = vec2<u32>(index % cells.x, index / cells.x);
    let finer = level.x - 1u;
    let first_finer = made.level_offsets[finer >> 2u][finer & 3u];
    var codes = vec2<u32>(0u);
    for (var child = 0u; child < 4u; child++) {
        let below = cell_below(size, level.x, cell, child);
        if (level.x == 1u) {
            let pixel = made.first_pixel + below.y * size.x + below.x;
            let word = word_index(shape, pixel, shape.bounds_word);
            codes = max(codes, vec2<u32>(pixels[word], pixels[word + shape.pixel_count]));
        } else {
            codes = max(codes, pyramid[pyramid_index(made.view, first_finer, finer, below)]);
        }
    }
    let first = made.level_offsets[level.x >> 2u][level.x & 3u];
    pyramid[pyramid_index(made.view, first, level.x, cell)] = codes;
}
