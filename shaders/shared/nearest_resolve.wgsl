// What nearest_compute.wgsl leaves, as textures have it: complements of what was kept, and what stands for nothing.

#import tracebench::dispatch::{Invocation, linear_invocation}

struct ResolvedImage {
    words: u32,
    // The bits of what stands where there is nothing.
    nothing: u32,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> resolved: ResolvedImage;
@group(0) @binding(1) var<storage, read_write> kept: array<u32>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn resolve(invocation: Invocation) {
    let word = linear_invocation(invocation, WORKGROUP_SIZE);
    if (word < resolved.words) {
        kept[word] = select(~kept[word], resolved.nothing, (kept[word] == 0u));
    }
}
