#define_import_path tracebench::surface

// What shading needs of a hit, from the triangle's corners: one function for everyone who fetches it, so that all give
// the same bits.

#import tracebench::types::{Surface, SURFACE_WRITTEN}

fn max_of(vector: vec3<f32>) -> f32 {
    return max(max(abs(vector.x), abs(vector.y)), abs(vector.z));
}

// The unit normal of the plane that two edges span, 0 if they span none. Every vector is brought to a greatest component of
// 1 first: squares of large scenes leave f32's range otherwise, and those of small ones vanish.
fn unit_normal(first: vec3<f32>, second: vec3<f32>) -> vec3<f32> {
    let first_length = max_of(first);
    let second_length = max_of(second);
    if (!(first_length > 0.0 && second_length > 0.0)) {
        return vec3<f32>(0.0);
    }
    let normal = cross(first / first_length, second / second_length);
    let normal_length = max_of(normal);
    if (!(normal_length > 0.0)) {
        return vec3<f32>(0.0);
    }
    return normalize(normal / normal_length);
}

// The surface at the weights u and v of a triangle's second and third corner.
fn surface_at(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, u: f32, v: f32, material: u32) -> Surface {
    let first = b - a;
    let second = c - a;
    return Surface(a + first * u + second * v, material, unit_normal(first, second), SURFACE_WRITTEN);
}
