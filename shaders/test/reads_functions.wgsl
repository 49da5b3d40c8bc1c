// Reads one array of each kind of record, for a test.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::reads::{quad_1, pair_1, word_3}

struct Found {
    quad: vec4<u32>,
    pair: vec2<u32>,
    word: u32,
    padding: u32,
}

@group(0) @binding(0) var<storage, read_write> found: array<Found>;

@compute @workgroup_size(64)
fn look_up(invocation: Invocation) {
    let index = linear_invocation(invocation, 64u);
    if (index >= arrayLength(&found)) {
        return;
    }
    found[index] = Found(quad_1(index), pair_1(index), word_3(index), 0u);
}
