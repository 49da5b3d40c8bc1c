#define_import_path tracebench::scene

// The scene's triangles, as passes over them bind them.

@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;

// A corner, of three a triangle.
fn load_position(corner: u32) -> vec3<f32> {
    let vertex = indices[corner] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}
