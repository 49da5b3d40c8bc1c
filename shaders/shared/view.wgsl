#define_import_path tracebench::view

// One perspective view. Eye space: x right, y up, z the linear eye depth, positive in front of the eye.

struct View {
    eye: vec3<f32>,
    tan_half_width: f32,
    right: vec3<f32>,
    tan_half_height: f32,
    up: vec3<f32>,
    near: f32,
    forward: vec3<f32>,
    far: f32,
    size: vec2<f32>,
    padding: vec2<f32>,
}

fn direction_to_eye_space(view: View, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(direction, view.right), dot(direction, view.up), dot(direction, view.forward));
}

fn to_eye_space(view: View, point: vec3<f32>) -> vec3<f32> {
    return direction_to_eye_space(view, point - view.eye);
}

// Clip coordinates with reversed depth (1 at near, 0 at far), whose f32 precision is even over the range.
fn clip_position(view: View, eye_point: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(
        eye_point.x / view.tan_half_width,
        eye_point.y / view.tan_half_height,
        // In this order no product of two small numbers underflows in tiny scenes.
        (view.far - eye_point.z) * (view.near / (view.far - view.near)),
        eye_point.z,
    );
}

// Pixels from the top left corner; pixel i spans [i, i + 1). For points in front of the eye.
fn pixel_position(view: View, eye_point: vec3<f32>) -> vec2<f32> {
    let across = eye_point.x / (eye_point.z * view.tan_half_width);
    let upward = eye_point.y / (eye_point.z * view.tan_half_height);
    return vec2<f32>(across + 1.0, 1.0 - upward) * 0.5 * view.size;
}
