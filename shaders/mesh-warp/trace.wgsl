// Rays from one point over the image of a mesh that was drawn from there. A ray takes the triangle at its pixel's centre and hits that one's
// plane, where it goes through it.

#import tracebench::dispatch::Invocation
#import tracebench::types::{
    Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_BEHIND_LAST_LAYER,
}
#import tracebench::view::{View, to_eye_space, direction_to_eye_space, pixel_position}
#import tracebench::plane_depth::{flat_triangle, plane_depth}
#import tracebench::lanes::{WORKGROUP_SIZE, answer_rays}
#import tracebench::grid::corners_of

struct WarpSettings {
    ray_count: u32,
    // Of the mesh.
    columns: u32,
    // By how much the vertices of a triangle that is not over a step in depth may differ, share of the least.
    most: f32,
    padding: u32,
}

// From the rays' origin.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> settings: WarpSettings;
// The triangle of the mesh at every pixel's centre.
@group(0) @binding(2) var drawn: texture_2d<u32>;
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray the pixels that it reads, and the triangles.
@group(0) @binding(5) var<storage, read_write> counts: array<vec2<u32>>;
// A bit a vertex: read by any ray.
@group(0) @binding(6) var<storage, read_write> vertices_touched: array<atomic<u32>>;
#endif
#ifdef SURFACES
// The scene's triangle at every pixel of the view that the mesh was made from, and of every ray the one that it hit.
@group(0) @binding(7) var primitives: texture_2d_array<u32>;
@group(0) @binding(8) var<storage, read_write> seen: array<u32>;
@group(0) @binding(10) var<uniform> frame: View;
#endif
@group(0) @binding(9) var<storage, read> positions: array<f32>;

struct Answer {
    hit: Hit,
    // Read of the mesh; NO_PRIMITIVE for none.
    triangle: u32,
    pixels: u32,
}

fn vertex_at(vertex: u32) -> vec3<f32> {
    return vec3<f32>(positions[vertex * 3u], positions[vertex * 3u + 1u], positions[vertex * 3u + 2u]);
}

// How deep a triangle's plane is at a place in the image. Beside the triangle its plane goes on by as much as its vertices differ in depth, as
// its neighbour will; but not that of a triangle over a step, beside which there is what its vertices show.
fn depth_at(corners: vec3<u32>, at: vec2<f32>) -> f32 {
    var plane = flat_triangle(view, vertex_at(corners.x), vertex_at(corners.y), vertex_at(corners.z));
    let differ = plane.depths.y - plane.depths.x;
    if (differ <= settings.most * plane.depths.x) {
        plane.depths += vec2<f32>(-differ, differ);
    }
    return plane_depth(view, plane, at);
}

fn search(ray: Ray) -> Answer {
    let direction = direction_to_eye_space(view, ray.direction);
    let at = pixel_position(view, direction);
    if (!(direction.z > 0.0 && all(at >= vec2<f32>(0.0)) && all(at <= view.size))) {
        return Answer(miss(STATUS_LEFT_VIEWS), NO_PRIMITIVE, 0u);
    }
    let triangle = textureLoad(drawn, min(vec2<u32>(at), vec2<u32>(view.size) - 1u), 0).x;
    if (triangle == NO_PRIMITIVE) {
        return Answer(miss(STATUS_MISS), NO_PRIMITIVE, 1u);
    }
    let t = depth_at(corners_of(triangle, settings.columns), at) / direction.z;
    // What lies behind the nearest triangle was not drawn.
    if (!(t >= ray.t_min)) {
        return Answer(miss(STATUS_BEHIND_LAST_LAYER), triangle, 1u);
    }
    if (!(t <= ray.t_max)) {
        return Answer(miss(STATUS_MISS), triangle, 1u);
    }
    return Answer(Hit(t, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT), triangle, 1u);
}

#ifdef SURFACES
// The pixel of the vertex that lies nearest to a point in the view that the mesh was made from.
fn nearest_pixel(triangle: u32, point: vec3<f32>) -> vec2<u32> {
    var corners = corners_of(triangle, settings.columns);
    let at = pixel_position(frame, to_eye_space(frame, point));
    var nearest = vec2<u32>(0u);
    var least = 1e38;
    for (var corner = 0u; corner < 3u; corner++) {
        let pixel = vec2<u32>(corners[corner] % settings.columns, corners[corner] / settings.columns);
        let off = at - vec2<f32>(pixel) - 0.5;
        if (corner == 0u || dot(off, off) < least) {
            least = dot(off, off);
            nearest = pixel;
        }
    }
    return nearest;
}
#endif

override fn tracebench::lanes::answer_ray(index: u32) {
    let ray = rays[index];
    let answer = search(ray);
    hits[index] = answer.hit;
    let found = answer.triangle != NO_PRIMITIVE;
#ifdef COUNTERS
    counts[index] = vec2<u32>(answer.pixels, select(0u, 1u, found));
    if (found) {
        var corners = corners_of(answer.triangle, settings.columns);
        for (var corner = 0u; corner < 3u; corner++) {
            atomicOr(&vertices_touched[corners[corner] >> 5u], 1u << (corners[corner] & 31u));
        }
    }
#endif
#ifdef SURFACES
    seen[index] = NO_PRIMITIVE;
    if (found) {
        let pixel = nearest_pixel(answer.triangle, ray.origin + ray.direction * answer.hit.t);
        seen[index] = textureLoad(primitives, pixel, 0, 0).x;
    }
#endif
}

// A ray takes as long as any other: each has a lane.
@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, settings.ray_count, 1u);
}
