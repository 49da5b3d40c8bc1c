#define_import_path tracebench::bvh_triangle

// A triangle in the order of the leaves, as builds write it and searches read it.

// Corners in units of the hierarchy. Three quads.
struct Triangle {
    first: vec3<f32>,
    primitive: u32,
    second: vec3<f32>,
    after_second: u32,
    third: vec3<f32>,
    after_third: u32,
}
