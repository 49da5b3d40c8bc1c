#define_import_path tracebench::dirt_vertices

// DIRT's vertex buffer (section 4.1.2): the corners of every triangle, nine floats in a row, so that a triangle is one
// record that is found by its number alone.

@group(0) @binding(2) var<storage, read> vertices: array<f32>;

fn corner_of(triangle: u32, corner: u32) -> vec3<f32> {
    let first = triangle * 9u + corner * 3u;
    return vec3<f32>(vertices[first], vertices[first + 1u], vertices[first + 2u]);
}
