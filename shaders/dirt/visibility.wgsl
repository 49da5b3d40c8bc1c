// The end of DIRT's direct visibility pass (section 4.1.3): for every pixel of the camera's frame the surface that it shows,
// from the triangle that was rasterized there and the line through the pixel's centre.

#import tracebench::types::{Surface, no_surface, SURFACE_NO_HIT}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::view::View
#import tracebench::surface::surface_at

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
@group(0) @binding(3) var<storage, read> materials: array<u32>;
@group(0) @binding(4) var primitives: texture_2d<u32>;
@group(0) @binding(5) var<storage, read_write> surfaces: array<Surface>;

const WORKGROUP_SIZE: u32 = 64u;

fn corner_of(primitive: u32, corner: u32) -> vec3<f32> {
    let vertex = indices[primitive * 3u + corner] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}

// The barycentric weights at which a line meets a triangle's plane, held within the triangle: the rasterizer has decided that
// the line meets it.
fn weights(direction: vec3<f32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec2<f32> {
    let first = b - a;
    let second = c - a;
    let offset = view.eye - a;
    let across = cross(direction, second);
    let determinant = dot(first, across);
    if (determinant == 0.0) {
        return vec2<f32>(0.0);
    }
    let u = clamp(dot(offset, across) / determinant, 0.0, 1.0);
    let v = dot(direction, cross(offset, first)) / determinant;
    return vec2<f32>(u, clamp(v, 0.0, 1.0 - u));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn resolve(invocation: Invocation) {
    let size = textureDimensions(primitives);
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= size.x * size.y) {
        return;
    }
    let pixel = vec2<u32>(index % size.x, index / size.x);
    let primitive = textureLoad(primitives, pixel, 0).x;
    if (primitive >= arrayLength(&materials)) {
        surfaces[index] = no_surface(SURFACE_NO_HIT);
        return;
    }
    let at = (vec2<f32>(pixel) + 0.5) * 2.0 / view.size - 1.0;
    let direction = view.forward + view.right * (at.x * view.tan_half_width) - view.up * (at.y * view.tan_half_height);
    let a = corner_of(primitive, 0u);
    let b = corner_of(primitive, 1u);
    let c = corner_of(primitive, 2u);
    let weight = weights(direction, a, b, c);
    surfaces[index] = surface_at(a, b, c, weight.x, weight.y, materials[primitive]);
}
