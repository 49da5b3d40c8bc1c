#define_import_path tracebench::dirt_packed_ray

// A ray on its way through the packed forms of DIRT: its state, the test of triangles, and by how much what is computed of it may be off.
//
// In a face the ray is a line between two points in (x, y, w), a leg, of parameter s from 0 to 1. Where it is at a depth, computed places
// are off by
//     2^-20 (reach w + 2) of half the face across, and w by as much of itself,
// where `reach` is the origin's greatest coordinate less the eye: that difference is rounded once, each end of the leg is a sum of two
// products of its size or of the end's own, and the quotients, sums and products that follow are off by a few times 2^-24 each (WGSL,
// 15.7.4.1, "Floating Point Accuracy").

#import tracebench::types::Ray
#import tracebench::triangle::{RayFrame, cross_triangle}
#import tracebench::reads::{quad_1, word_0}
#import tracebench::lanes::open
#import tracebench::dirt_packed_grid::{PackedGrid, FIRST_NEAR, first_corner, slice_of, slices_between}

struct PackedSearch {
    ray_count: u32,
    // 1: any hit ends a search.
    any_hit: u32,
    // Steps after which a ray is given up.
    max_steps: u32,
    // The highest level of the pyramid that is walked.
    top_level: u32,
    rays_per_lane: u32,
    // 1: what lies near the eye is searched apart.
    split: u32,
    // 1: nodes and parts are taken in the order in which the ray meets their boxes.
    nearest_first: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> grid: PackedGrid;
@group(0) @binding(1) var<uniform> search: PackedSearch;
#ifdef COUNTERS
// A bit a reference: tested by any ray.
@group(0) @binding(10) var<storage, read_write> touched: array<atomic<u32>>;
#endif

// What is counted of a ray.
struct Work {
    pyramid_steps: u32,
    nodes_visited: u32,
    triangle_tests: u32,
    views_entered: u32,
    // Rounds in which it had something to do, with trees.
    search_rounds: u32,
}

struct Best {
    t: f32,
    primitive: u32,
    u: f32,
    v: f32,
}

// The ray in a face: (x, y, w) at its beginning, the change to its end, one over that.
struct Leg {
    begin: vec3<f32>,
    change: vec3<f32>,
    inverse: vec3<f32>,
    // At both ends.
    ts: vec2<f32>,
    ws: vec2<f32>,
    // What is lost of w by rounding of both ends.
    w_loss: f32,
}

// A bound on what is lost of a place between tiles by 2^-20, of products and sums.
const UNIT: f32 = 9.5367431640625e-7;
// Rounding of a plane's s, over the sizes of its terms: two products and a sum, with room.
const PLANE_SLACK: f32 = 4.76837158e-7;

// The state of this lane's ray: as it is in space, less the eye.
var<private> ray: Ray;
var<private> ray_origin: vec3<f32>;
var<private> reach: f32;
var<private> frame: RayFrame;
var<private> leg: Leg;
var<private> best: Best;
var<private> found: bool;
// The s of the best hit in this leg, 1 where there is none before its end.
var<private> limit: f32;
var<private> capped: bool;
var<private> steps: u32;
// Where slices begin, and slices a unit.
var<private> slice_base: u32;
var<private> slice_rate: f32;
#ifdef COUNTERS
var<private> work: Work;
#endif

fn is_done() -> bool {
    return capped | (found & (search.any_hit == 1u));
}

// The greatest t at which a hit may still be better than the best one, with room for what t and the legs' ends are off by.
fn last_t() -> f32 {
    return select(ray.t_max, best.t + (abs(best.t) + reach) * 3.814697265625e-6, found);
}

// Notes where in the leg the best hit lies.
fn set_limit() {
    let t = last_t();
    let after = max(t - leg.ts.x, 0.0) * leg.ws.x;
    let before = max(leg.ts.y - t, 0.0) * leg.ws.y;
    limit = select(1.0, min(after / (after + before) + UNIT, 1.0), found & (before > 0.0));
}

struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

fn corners_of(triangle: u32) -> Corners {
    let first = first_corner(grid, triangle);
    return Corners(
        bitcast<vec3<f32>>(quad_1(first).xyz),
        bitcast<vec3<f32>>(quad_1(first + 1u).xyz),
        bitcast<vec3<f32>>(quad_1(first + 2u).xyz),
    );
}

// The triangle that a reference is a part of.
fn triangle_of(reference: u32) -> u32 {
    return word_0(FIRST_NEAR + grid.triangle_count + reference);
}

// Tests a triangle with these corners, where `asked`; of equal t the lower primitive is kept. A lane that does not ask tests all the
// same, and keeps nothing. Where the search goes on in a leg, set_limit is to follow.
fn test_corners(triangle: u32, corners: Corners, asked: bool) {
#ifdef COUNTERS
    work.triangle_tests += select(0u, 1u, asked);
#endif
    let crossed = cross_triangle(frame, corners.a, corners.b, corners.c);
    let nearer = (crossed.t < best.t) | ((crossed.t == best.t) & (triangle < best.primitive));
    let hits = asked & (crossed.t >= ray.t_min) & nearer;
    best.t = select(best.t, crossed.t, hits);
    best.primitive = select(best.primitive, triangle, hits);
    best.u = select(best.u, crossed.u, hits);
    best.v = select(best.v, crossed.v, hits);
    found = found | hits;
}

fn test_triangle(triangle: u32, asked: bool) {
    test_corners(triangle, corners_of(triangle), asked);
}

#ifdef COUNTERS
// Notes that a reference was tested, where `asked`.
fn note_reference(reference: u32, asked: bool) {
    atomicOr(&touched[reference >> 5u], select(0u, 1u << (reference & 31u), asked));
}
#endif

fn test_reference(reference: u32, asked: bool) {
#ifdef COUNTERS
    note_reference(reference, asked);
#endif
    test_triangle(triangle_of(reference), asked);
}

// Tests references in a row.
fn test_references(first: u32, end: u32) {
    var reference = first;
    open += 1u;
    loop {
        if (reference >= end || is_done()) {
            open -= 1u;
            break;
        }
        test_reference(reference, true);
        set_limit();
        reference += 1u;
    }
}

// By how much places in tiles, and w, may be off at this w.
fn place_loss(w: f32) -> f32 {
    return f32(grid.tiles) * 0.5 * UNIT * (reach * w + 2.0);
}

fn depth_loss(w: f32) -> f32 {
    return w * UNIT * (reach * w + 2.0) + leg.w_loss;
}

fn mask_between(least: f32, greatest: f32) -> vec2<u32> {
    let first = slice_of(least, slice_base, slice_rate, grid.slices);
    let last = slice_of(greatest, slice_base, slice_rate, grid.slices);
    return slices_between(first, last);
}
