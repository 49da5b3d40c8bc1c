// Crosses given triangles with given rays, so that a test can compare the shared test with f64.

#import tracebench::types::Ray
#import tracebench::triangle::{ray_frame, cross_triangle}

struct Corners {
    first: vec4<f32>,
    second: vec4<f32>,
    third: vec4<f32>,
}

@group(0) @binding(0) var<storage, read> rays: array<Ray>;
@group(0) @binding(1) var<storage, read> triangles: array<Corners>;
@group(0) @binding(2) var<storage, read_write> crossings: array<vec4<f32>>;

@compute @workgroup_size(64)
fn cross_pairs(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&rays)) {
        return;
    }
    let frame = ray_frame(rays[id.x].origin, rays[id.x].direction);
    let triangle = triangles[id.x];
    let crossing = cross_triangle(frame, triangle.first.xyz, triangle.second.xyz, triangle.third.xyz);
    crossings[id.x] = vec4<f32>(crossing.t, crossing.u, crossing.v, 0.0);
}
