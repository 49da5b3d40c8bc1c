// DIRT's mask texture (section 4.2.1): depth 1 at pixels with hits, at the others the 0 that it is cleared to, so that a
// depth test keeps the fetch pass from pixels where nothing is to be fetched.

struct MaskSettings {
    pixels: vec2<u32>,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> settings: MaskSettings;
@group(0) @binding(1) var<storage, read> heads: array<u32>;

// One triangle over the whole image, at depth 1.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32((index & 1u) << 2u) - 1.0, f32((index & 2u) << 1u) - 1.0, 1.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) {
    let pixel = vec2<u32>(position.xy);
    if (heads[pixel.y * settings.pixels.x + pixel.x] == 0u) {
        discard;
    }
}
