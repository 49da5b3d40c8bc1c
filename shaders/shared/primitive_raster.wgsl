// Rasterizes the number of the nearest triangle at every pixel's centre.

#import tracebench::view::{View, to_eye_space, clip_position}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) primitive: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let at = indices[index] * 3u;
    let position = vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]);
    return Corner(clip_position(view, to_eye_space(view, position)), index / 3u);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<u32> {
    return vec4<u32>(in.primitive, 0u, 0u, 0u);
}
