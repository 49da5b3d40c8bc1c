// The pass over the geometry (section 3.1), of one of its three orthographic projections: every fragment goes into its texel's list
// and its normal into its voxel's sums. By the rasterizer's own sample rule, in compute (`draw`) by that of tracebench::coverage; depth is
// not tested.

#import tracebench::scene::load_position
#import tracebench::plane_depth::facet
#import tracebench::surface::{max_of, unit_normal}
#import tracebench::unit_space::{to_unit, on_image, from_image, dominant_axis, voxel_at, voxel_index}
#import tracebench::voxel_space::layer_code
#import tracebench::voxel_fragments::{drawn, taken}
#ifdef STORE
#import tracebench::voxel_fragments::store_fragment
#endif
#import tracebench::dispatch::Invocation
#import tracebench::coverage::{outline_in_image, rows_of_outline, span_of_row}
#import tracebench::raster_work::part_of

#ifdef STORE
@group(0) @binding(3) var<storage, read> materials: array<u32>;
@group(0) @binding(9) var<storage, read_write> sums_x: array<atomic<i32>>;
@group(0) @binding(10) var<storage, read_write> sums_y: array<atomic<i32>>;
@group(0) @binding(11) var<storage, read_write> sums_z: array<atomic<i32>>;
// The fragments that fed a voxel's sums; the last bit: any fragment at all.
@group(0) @binding(12) var<storage, read_write> fragments: array<atomic<u32>>;
#endif
#ifdef VOXELS
// A bit a voxel.
@group(0) @binding(9) var<storage, read_write> occupied: array<atomic<u32>>;
#endif

// As `NORMAL_UNIT` in tracers/voxel-abuffer/src/grid.rs: sums of normals are integers, so that they do not hang on the order of atomics.
const NORMAL_UNIT: f32 = 256.0;
const ANY_FRAGMENT: u32 = 0x80000000u;

// A triangle as its fragments need it, the same at all of them.
struct Facing {
    // Depth by place across and down, and a place on the plane.
    plane: vec4<f32>,
    // The depth there, and the least and greatest of the corners.
    depths: vec3<f32>,
#ifdef STORE
    normal: vec3<f32>,
    // What is added to the sums, and 1 where it is.
    fed: vec4<i32>,
    // Material; 1 where the normal points along the axis.
    words: vec2<u32>,
#endif
}

fn drawn_place(point: vec3<f32>) -> vec3<f32> {
    return on_image(drawn.axis, to_unit(drawn.space, point));
}

// By its first of three corners.
fn facing_of(first: u32) -> Facing {
    let a = load_position(first);
    let b = load_position(first + 1u);
    let c = load_position(first + 2u);
    let place = drawn_place(a);
    var facing: Facing;
    let plane = facet(a, b, c);
    // In the cube, whose axes may be scaled differently.
    let across = plane.across / drawn.space.scale;
    let normal = across / max(max_of(across), 1e-30);
    let on_plane = drawn_place(plane.at);
    let tilt = on_image(drawn.axis, normal);
    // Edge-on nothing is drawn but by what corners are snapped.
    let slope = select(vec2<f32>(0.0), -tilt.xy / tilt.z, (abs(tilt.z) > 1e-12));
    facing.plane = vec4<f32>(slope, on_plane.xy);
    let other = drawn_place(b).z;
    let third = drawn_place(c).z;
    facing.depths = vec3<f32>(on_plane.z, min(place.z, min(other, third)), max(place.z, max(other, third)));
#ifdef STORE
    facing.normal = unit_normal(b - a, c - a);
    let axis = dominant_axis(normal);
    // Of corners in a line there is none, and what a rasterizer may draw of them adds nothing.
    var unit = vec3<f32>(0.0);
    if (max_of(across) > 0.0) {
        unit = normalize(normal);
    }
    if (drawn.as_lines == 1u && unit[axis] < 0.0) {
        unit = -unit;
    }
    let feeds = drawn.fed_by == 0u || axis == drawn.axis;
    facing.fed = vec4<i32>(vec3<i32>(round(unit * NORMAL_UNIT)), select(0, 1, feeds));
    facing.words = vec2<u32>(materials[first / 3u], select(0u, 1u, (tilt.z > 0.0)));
#endif
    return facing;
}

#ifdef STORE
fn feed(voxel: u32, fed: vec4<i32>) {
    if (fed.w == 0) {
        atomicOr(&fragments[voxel], ANY_FRAGMENT);
        return;
    }
    atomicAdd(&sums_x[voxel], fed.x);
    atomicAdd(&sums_y[voxel], fed.y);
    atomicAdd(&sums_z[voxel], fed.z);
    atomicAdd(&fragments[voxel], 1u);
}
#endif

// What a pass does with a fragment, by its texel's centre.
fn put_fragment(centre: vec2<f32>, facing: Facing) {
#ifdef TALLY
    // How many fragments an axis has, before there is room for any.
    atomicAdd(&taken[drawn.axis], 1u);
#else
    // By the plane at the texel's centre: what a rasterizer interpolates is the driver's own.
    let place = centre / f32(drawn.space.image);
    let on_plane = facing.depths.x + dot(facing.plane.xy, place - facing.plane.zw);
    let depth = clamp(clamp(on_plane, facing.depths.y, facing.depths.z), 1e-30, 0.9999999);
    let voxel = voxel_index(drawn.space, voxel_at(drawn.space, from_image(drawn.axis, vec3<f32>(place, depth))));
#ifdef VOXELS
    atomicOr(&occupied[voxel >> 5u], 1u << (voxel & 31u));
#else
    let record = vec4<u32>(bitcast<vec3<u32>>(facing.normal), facing.words.x);
    store_fragment(vec2<u32>(centre), layer_code(depth, facing.words.y == 1u), record);
    feed(voxel, facing.fed);
#endif
#endif
}

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let part = part_of(invocation);
    if (any(part.high <= part.low)) {
        return;
    }
    let first = part.triangle * 3u;
    let a = drawn_place(load_position(first)).xy;
    let b = drawn_place(load_position(first + 1u)).xy;
    let c = drawn_place(load_position(first + 2u)).xy;
    if (!outline_in_image(a, b, c, vec2<f32>(f32(drawn.space.image)))) {
        return;
    }
    let facing = facing_of(first);
    let rows = rows_of_outline();
    for (var row = max(rows.x, part.low.y); row < min(rows.y, part.high.y); row++) {
        let span = span_of_row(row);
        for (var column = max(span.x, part.low.x); column < min(span.y, part.high.x); column++) {
            put_fragment(vec2<f32>(vec2<i32>(column, row)) + 0.5, facing);
        }
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
#ifndef TALLY
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) depths: vec3<f32>,
#endif
#ifdef STORE
    @location(2) @interpolate(flat) normal: vec3<f32>,
    @location(3) @interpolate(flat) fed: vec4<i32>,
    @location(4) @interpolate(flat) words: vec2<u32>,
#endif
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let place = drawn_place(load_position(index));
    var corner: Corner;
    corner.position = vec4<f32>(place.x * 2.0 - 1.0, 1.0 - place.y * 2.0, 0.5, 1.0);
#ifndef TALLY
    // A triangle's first corner speaks for it.
    if (index % 3u == 0u) {
        let facing = facing_of(index);
        corner.plane = facing.plane;
        corner.depths = facing.depths;
#ifdef STORE
        corner.normal = facing.normal;
        corner.fed = facing.fed;
        corner.words = facing.words;
#endif
    }
#endif
    return corner;
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    var facing: Facing;
#ifndef TALLY
    facing.plane = in.plane;
    facing.depths = in.depths;
#endif
#ifdef STORE
    facing.normal = in.normal;
    facing.fed = in.fed;
    facing.words = in.words;
#endif
    put_fragment(in.position.xy, facing);
    return vec4<f32>(0.0);
}
