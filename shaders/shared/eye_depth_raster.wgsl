// Rasterizes the scene into a texture of linear eye depths, sampled at pixel centres.

#import tracebench::view::{View, to_eye_space, clip_position}

@group(0) @binding(0) var<uniform> view: View;

struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) eye_depth: f32,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Varying {
    let eye_point = to_eye_space(view, position);
    return Varying(clip_position(view, eye_point), eye_point.z);
}

@fragment
fn fragment(inputs: Varying) -> @location(0) vec4<f32> {
    return vec4<f32>(inputs.eye_depth, 0.0, 0.0, 0.0);
}
