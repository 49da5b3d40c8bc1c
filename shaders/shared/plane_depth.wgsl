#define_import_path tracebench::plane_depth

// The eye depth of a triangle at a pixel's centre, by its plane. What a rasterizer interpolates is the driver's own: corners
// that it has snapped, and triangles that reach far out of the view, take it off the plane by as much as the driver likes.

#import tracebench::view::{View, direction_to_eye_space}

// A triangle as its fragments need it, the same at all of them.
struct FlatTriangle {
    // The plane in eye space: dot(plane.xyz, point) = plane.w.
    plane: vec4<f32>,
    // Least and greatest eye depth of the corners.
    depths: vec2<f32>,
}

fn size_of(vector: vec3<f32>) -> f32 {
    return max(abs(vector.x), max(abs(vector.y), abs(vector.z)));
}

// A triangle's plane in the scene's own coordinates, where differences of corners lose the least: a normal of any length, and a corner.
struct Facet {
    across: vec3<f32>,
    at: vec3<f32>,
}

// By the two shorter edges: of a thin triangle the longer ones are nearly one line, and their product is noise.
fn facet(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Facet {
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    var first = ab;
    var second = bc;
    var at = b;
    let sizes = vec3<f32>(size_of(ab), size_of(bc), size_of(ca));
    if (sizes.x >= max(sizes.y, sizes.z)) {
        first = bc;
        second = ca;
        at = c;
    } else if (sizes.y >= sizes.z) {
        first = ca;
        second = ab;
        at = a;
    }
    // Of edges of size 1 no product underflows in tiny scenes or overflows in huge ones.
    return Facet(cross(first / size_of(first), second / size_of(second)), at);
}

fn flat_triangle(view: View, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> FlatTriangle {
    let plane = facet(a, b, c);
    let normal = direction_to_eye_space(view, plane.across);
    let depths = vec3<f32>(
        dot(a - view.eye, view.forward), dot(b - view.eye, view.forward), dot(c - view.eye, view.forward),
    );
    return FlatTriangle(
        vec4<f32>(normal, dot(plane.across, plane.at - view.eye)),
        vec2<f32>(min(depths.x, min(depths.y, depths.z)), max(depths.x, max(depths.y, depths.z))),
    );
}

// At a place in the image, pixels; held between the corners' own depths, near and far, where a plane through the eye, or a
// border that was drawn beside its triangle, says nothing.
fn plane_depth(view: View, triangle: FlatTriangle, at: vec2<f32>) -> f32 {
    let across = (at * 2.0 / view.size - 1.0) * vec2<f32>(view.tan_half_width, -view.tan_half_height);
    let inverse = dot(triangle.plane.xyz, vec3<f32>(across, 1.0)) / triangle.plane.w;
    let depth = 1.0 / max(inverse, 1.0 / view.far);
    return clamp(depth, max(triangle.depths.x, view.near), max(view.near, min(triangle.depths.y, view.far)));
}

// A depth as the depth test has it: reversed, 1 at near and 0 at far, as `clip_position` gives it.
fn tested_depth(view: View, depth: f32) -> f32 {
    return clamp((view.far - depth) * (view.near / (view.far - view.near)) / depth, 0.0, 1.0);
}
