// Rasterizes what is nearest at every pixel's centre: its linear eye depth, or the number of its triangle. With BEHIND that is the
// nearest behind a layer that was drawn before.

#import tracebench::scene::load_position
#import tracebench::view::{View, to_eye_space, clip_position}
#import tracebench::plane_depth::{FlatTriangle, flat_triangle, plane_depth, tested_depth}
#ifdef BEHIND
#import tracebench::passed_layer::lies_behind
#endif

@group(0) @binding(0) var<uniform> view: View;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) depths: vec2<f32>,
#ifdef PRIMITIVES
    @location(2) @interpolate(flat) primitive: u32,
#endif
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let a = load_position(index);
    var corner: Corner;
    corner.position = clip_position(view, to_eye_space(view, a));
    // A triangle's first corner speaks for it.
    if (index % 3u == 0u) {
        let triangle = flat_triangle(view, a, load_position(index + 1u), load_position(index + 2u));
        corner.plane = triangle.plane;
        corner.depths = triangle.depths;
#ifdef PRIMITIVES
        corner.primitive = index / 3u;
#endif
    }
    return corner;
}

struct Seen {
#ifdef PRIMITIVES
    // The number of the nearest triangle at the pixel's centre.
    @location(0) what: vec4<u32>,
#else
    // Its eye depth.
    @location(0) what: vec4<f32>,
#endif
    @builtin(frag_depth) tested: f32,
}

@fragment
fn fragment(in: Corner) -> Seen {
    let depth = plane_depth(view, FlatTriangle(in.plane, in.depths), in.position.xy);
#ifdef BEHIND
    // The plane's normal is on the side from which the corners run counter-clockwise, its offset that of the eye's distance.
    if (!lies_behind(depth, vec2<i32>(in.position.xy), in.plane.w > 0.0)) {
        discard;
    }
#endif
#ifdef PRIMITIVES
    return Seen(vec4<u32>(in.primitive, 0u, 0u, 0u), tested_depth(view, depth));
#else
    return Seen(vec4<f32>(depth, 0.0, 0.0, 0.0), tested_depth(view, depth));
#endif
}
