#define_import_path tracebench::voxel_walk

// A ray's way through the unit cube, voxel by voxel (Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing",
// Eurographics 1987). Where a ray leaves a voxel follows from the voxel's own sides, so that errors do not add up.

#import tracebench::image_walk::{NEVER, Span, cut}

// The part of a span in which a ray lies in the cube; begin > end for none.
fn span_in_cube(origin: vec3<f32>, direction: vec3<f32>, whole: Span) -> Span {
    var span = cut(cut(whole, origin.x, direction.x), 1.0 - origin.x, -direction.x);
    span = cut(cut(span, origin.y, direction.y), 1.0 - origin.y, -direction.y);
    return cut(cut(span, origin.z, direction.z), 1.0 - origin.z, -direction.z);
}

// The parameters at which a ray leaves a voxel across its sides, NEVER where it does not; of `edge` voxels along the cube's edge.
fn leaves_voxel(
    origin: vec3<f32>,
    direction: vec3<f32>,
    heading: vec3<i32>,
    voxel: vec3<i32>,
    edge: f32,
) -> vec3<f32> {
    let still = heading == vec3<i32>(0);
    let sides = vec3<f32>(voxel + max(heading, vec3<i32>(0))) / edge;
    return select((sides - origin) / select(direction, vec3<f32>(1.0), still), vec3<f32>(NEVER), still);
}

// The voxel beyond the side that is left first.
fn next_voxel(voxel: vec3<i32>, heading: vec3<i32>, leaves: vec3<f32>) -> vec3<i32> {
    if (leaves.x <= min(leaves.y, leaves.z)) {
        return voxel + vec3<i32>(heading.x, 0, 0);
    }
    if (leaves.y <= leaves.z) {
        return voxel + vec3<i32>(0, heading.y, 0);
    }
    return voxel + vec3<i32>(0, 0, heading.z);
}

fn is_in_grid(voxel: vec3<i32>, edge: u32) -> bool {
    return all(voxel >= vec3<i32>(0)) && all(voxel < vec3<i32>(i32(edge)));
}
