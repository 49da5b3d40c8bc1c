// Of the depths that a k-buffer has caught, those that lie behind the one kept before by more than a separation, as layers of a
// view (Mara, McGuire, Luebke, "Lighting Deep G-Buffers", 2013, on the minimum separation). A layer of which nothing was caught is
// empty: peeling asks the scene again instead.

#import tracebench::dispatch::{Invocation, linear_invocation}

struct ThinPass {
    pixels: u32,
    slots: u32,
    layers: u32,
    // Where the view's layers begin.
    first: u32,
    separation: f32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> thinned: ThinPass;
@group(0) @binding(1) var<storage, read> caught: array<u32>;
@group(0) @binding(2) var<storage, read_write> codes: array<u32>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn thin(invocation: Invocation) {
    let pixel = linear_invocation(invocation, WORKGROUP_SIZE);
    if (pixel >= thinned.pixels) {
        return;
    }
    var layer = 0u;
    var behind = -1e38;
    for (var slot = 0u; slot < thinned.slots; slot++) {
        let code = caught[slot * thinned.pixels + pixel];
        let depth = bitcast<f32>(~code);
        if (code != 0u && layer < thinned.layers && depth > behind) {
            codes[thinned.first + layer * thinned.pixels + pixel] = code;
            behind = depth + thinned.separation;
            layer += 1u;
        }
    }
}
