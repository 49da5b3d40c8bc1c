#define_import_path tracebench::dirt_corners

// A triangle as the eye and its faces have it, and how near the eye it comes.

#import tracebench::dirt_packed_grid::to_face

struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    // Greatest coordinate less the eye.
    size: f32,
}

fn max_of(vector: vec3<f32>) -> f32 {
    return max(max(abs(vector.x), abs(vector.y)), abs(vector.z));
}

fn corners_less_eye(eye: vec3<f32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Corners {
    let near_a = a - eye;
    let near_b = b - eye;
    let near_c = c - eye;
    return Corners(near_a, near_b, near_c, max(max(max_of(near_a), max_of(near_b)), max_of(near_c)));
}

// A triangle as a face has it.
fn seen_from(face: u32, corners: Corners) -> Corners {
    return Corners(to_face(face, corners.a), to_face(face, corners.b), to_face(face, corners.c), corners.size);
}

// The face that a direction leads into.
fn face_towards(direction: vec3<f32>) -> u32 {
    let size = abs(direction);
    let axis = select(select(2u, 1u, (size.y >= size.z)), 0u, (size.x >= max(size.y, size.z)));
    let along = select(select(direction.z, direction.y, (axis == 1u)), direction.x, (axis == 0u));
    return 2u * axis + select(0u, 1u, (along < 0.0));
}

fn distance_to_edge(a: vec3<f32>, b: vec3<f32>) -> f32 {
    let along = b - a;
    let share = clamp(-dot(a, along) / max(dot(along, along), 1e-37), 0.0, 1.0);
    return length(a + along * share);
}

// The distance of a triangle, whose corners are at most 1 in size, from the eye, off by 2^-12 at most where rounding hides on which side
// of an edge the eye lies: there the triangle is thin, or the edge as near as its inside.
fn distance_to_triangle(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let to_edges = min(min(distance_to_edge(a, b), distance_to_edge(b, c)), distance_to_edge(c, a));
    let normal = cross(b - a, c - a);
    let twice_area = length(normal);
    let sides = vec3<f32>(dot(normal, cross(a, b)), dot(normal, cross(b, c)), dot(normal, cross(c, a)));
    if (twice_area < 1e-15 || any(sides < vec3<f32>(-9.5367431640625e-7))) {
        return to_edges;
    }
    // No point of a triangle is farther from its edges than its width.
    let longest = max(max(length(b - a), length(c - b)), length(a - c));
    let to_plane = abs(dot(normal, a)) / twice_area;
    return max(min(to_edges, to_plane), to_edges - twice_area / longest);
}
