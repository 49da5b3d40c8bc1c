#define_import_path tracebench::triangle

// Watertight ray-triangle test: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Corners are
// moved to the ray's origin and sheared so that the ray runs along z; what is left is a test of the origin against the
// sheared corners' edges in two dimensions. Triangles that share an edge see the same products there, so no ray passes
// between them. Deviations from the paper: both faces are hit, so the axes need not keep the winding, and where an edge
// function is exactly zero the origin is taken to lie inside, where the paper asks again in f64; t is that of the
// triangle's plane, held between the corners' own, because the weights of thin triangles far away are rounded at the
// distance's scale and would move t by as much.

// The frame of one ray.
struct RayFrame {
    origin: vec3<f32>,
    // Bit 0: z of the frame is the ray's y; bit 1: it is the ray's x; none: it is z. The two other axes follow in turn.
    axes: u32,
    direction: vec3<f32>,
    // x and y per unit of z, and ray parameters per unit of z.
    shear: vec3<f32>,
}

// Where a ray crosses a triangle.
struct Crossing {
    // Ray parameter; negative for none (rays begin at 0 or later).
    t: f32,
    // Barycentric weights of the second and third corner.
    u: f32,
    v: f32,
}

// A vector's components in turn, so that the frame's z comes last.
fn turned(axes: u32, vector: vec3<f32>) -> vec3<f32> {
    let by_y = select(vector, vector.zxy, (axes == 1u));
    return select(by_y, vector.yzx, (axes == 2u));
}

// The frame along the direction's largest component, which must not be 0.
fn ray_frame(origin: vec3<f32>, direction: vec3<f32>) -> RayFrame {
    let size = abs(direction);
    var axes = select(0u, 1u, (size.y > size.z));
    axes = select(axes, 2u, (size.x > max(size.y, size.z)));
    let along = turned(axes, direction);
    return RayFrame(origin, axes, direction, vec3<f32>(along.x / along.z, along.y / along.z, 1.0 / along.z));
}

fn sheared(frame: RayFrame, corner: vec3<f32>) -> vec3<f32> {
    let local = turned(frame.axes, corner - frame.origin);
    return vec3<f32>(local.xy - frame.shear.xy * local.z, frame.shear.z * local.z);
}

// One over the power of two in a number's exponent.
fn inverse_power(number: f32) -> f32 {
    return bitcast<f32>(0x7f000000u - (bitcast<u32>(number) & 0x7f800000u));
}

fn cross_triangle(frame: RayFrame, first: vec3<f32>, second: vec3<f32>, third: vec3<f32>) -> Crossing {
    let a = sheared(frame, first);
    let b = sheared(frame, second);
    let c = sheared(frame, third);
    let edges = vec3<f32>(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
    let least = min(min(edges.x, edges.y), edges.z);
    let greatest = max(max(edges.x, edges.y), edges.z);
    let determinant = edges.x + edges.y + edges.z;
    if ((least < 0.0 && greatest > 0.0) || determinant == 0.0) {
        return Crossing(-1.0, 0.0, 0.0);
    }
    let weights = edges * (1.0 / determinant);
    let interpolated = weights.x * a.z + weights.y * b.z + weights.z * c.z;
    // Brought to a size by a power of two, which rounds nothing: products of three lengths leave f32's range in scenes of 1e13 units.
    let normal = cross(second - first, third - first) * inverse_power(determinant);
    let slope = dot(normal, frame.direction);
    let on_plane = dot(normal, first - frame.origin) / slope;
    let min_z = min(min(a.z, b.z), c.z);
    let max_z = max(max(a.z, b.z), c.z);
    let t = select(interpolated, clamp(on_plane, min_z, max_z), (slope != 0.0));
    return Crossing(t, weights.y, weights.z);
}
