// Draws triangles of clip coordinates with a depth that the rasterizer interpolates: what a device does of its own is found by it.

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) eye_depth: f32,
}

// w is the eye depth.
@vertex
fn vertex(@location(0) clip: vec4<f32>) -> Corner {
    return Corner(clip, clip.w);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(in.eye_depth, 0.0, 0.0, 0.0);
}
