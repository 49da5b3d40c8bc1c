// Calls the shared projection on given points, so that a test can compare it with f64.

#import tracebench::view::{View, to_eye_space, clip_position, pixel_position}

struct Projection {
    eye_point: vec4<f32>,
    clip: vec4<f32>,
    pixel: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> projections: array<Projection>;

@compute @workgroup_size(64)
fn project(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&points)) {
        return;
    }
    let eye_point = to_eye_space(view, points[id.x].xyz);
    projections[id.x] = Projection(
        vec4<f32>(eye_point, 0.0),
        clip_position(view, eye_point),
        vec4<f32>(pixel_position(view, eye_point), 0.0, 0.0),
    );
}
