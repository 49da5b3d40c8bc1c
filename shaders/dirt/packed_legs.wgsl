#define_import_path tracebench::dirt_packed_legs

// The faces that a ray of the packed forms of DIRT crosses, one after the other, each as a leg.

#import tracebench::types::{Ray, NO_PRIMITIVE}
#import tracebench::triangle::ray_frame
#import tracebench::reads::word_0
#import tracebench::dirt_packed_grid::{NEAREST, FARTHEST, NEAR_CUBE, SLICE_BASE, SLICE_RATE, to_face, noisy_cube}
#import tracebench::dirt_packed_ray::{
    Best, Leg, grid, search, ray, ray_origin, reach, frame, leg, best, found, limit, capped, steps, slice_base, slice_rate, open, work,
    is_done, last_t, set_limit
}
#import tracebench::dirt_packed_near::passes_box

// No ray gets there.
const NEVER: f32 = 1e38;
// Changes below this, of what there is, count as it.
const LEAST_CHANGE: f32 = 1e-9;

// Spans of three faces at once, those along the axes in one sense.
struct Spans {
    begin: vec3<f32>,
    end: vec3<f32>,
}

// In the faces along +x, +y, +z and in the opposite ones; those that are done begin at NEVER.
var<private> ahead: Spans;
var<private> behind: Spans;
// The depth from which on images are searched.
var<private> begins: f32;
// Whether the ray passes the eye as near as tiles do not hold all, or as images are noise; half the edge of the cube where they are, 0
// where nothing is stored so near.
var<private> passes_eye: bool;
var<private> centre: f32;

// Cut by what is not negative where value + slope t is, at t = `at`.
fn cut_all(spans: Spans, at: vec3<f32>, value: vec3<f32>, slope: vec3<f32>) -> Spans {
    let begin = select(spans.begin, max(spans.begin, at), (slope > vec3<f32>(0.0)));
    let end = select(spans.end, min(spans.end, at), (slope < vec3<f32>(0.0)));
    return Spans(begin, select(end, vec3<f32>(-1.0), ((slope == vec3<f32>(0.0)) & (value < vec3<f32>(0.0)))));
}

// Where value + slope t is 0; anywhere for no slope.
fn zero_of(value: vec3<f32>, slope: vec3<f32>) -> vec3<f32> {
    return -value / select(slope, vec3<f32>(1.0), (slope == vec3<f32>(0.0)));
}

fn if_any(spans: Spans) -> Spans {
    return Spans(select(vec3<f32>(NEVER), spans.begin, (spans.begin <= spans.end)), spans.end);
}

// The spans of the ray in the faces along +x, +y, +z, and in the opposite ones: wider by TILE_MARGIN of a tile, so that no ray along a
// seam is lost by both sides, and between two depths. Opposite faces share the planes of their seams.
fn find_spans(wide: f32, nearest: f32, farthest: f32) {
    let z = ray_origin;
    let dz = ray.direction;
    let right = z * wide - z.yzx;
    let left = z * wide + z.yzx;
    let top = z * wide - z.zxy;
    let bottom = z * wide + z.zxy;
    let right_slope = dz * wide - dz.yzx;
    let left_slope = dz * wide + dz.yzx;
    let top_slope = dz * wide - dz.zxy;
    let bottom_slope = dz * wide + dz.zxy;
    let at_right = zero_of(right, right_slope);
    let at_left = zero_of(left, left_slope);
    let at_top = zero_of(top, top_slope);
    let at_bottom = zero_of(bottom, bottom_slope);
    let inverse = 1.0 / select(dz, vec3<f32>(1.0), (dz == vec3<f32>(0.0)));
    var spans = Spans(vec3<f32>(ray.t_min), vec3<f32>(ray.t_max));
    spans = cut_all(spans, (nearest - z) * inverse, z - nearest, dz);
    spans = cut_all(spans, (farthest - z) * inverse, farthest - z, -dz);
    spans = cut_all(spans, at_right, right, right_slope);
    spans = cut_all(spans, at_left, left, left_slope);
    spans = cut_all(spans, at_top, top, top_slope);
    ahead = if_any(cut_all(spans, at_bottom, bottom, bottom_slope));
    spans = Spans(vec3<f32>(ray.t_min), vec3<f32>(ray.t_max));
    spans = cut_all(spans, (-nearest - z) * inverse, -z - nearest, -dz);
    spans = cut_all(spans, (-farthest - z) * inverse, farthest + z, dz);
    spans = cut_all(spans, at_right, -right, -right_slope);
    spans = cut_all(spans, at_left, -left, -left_slope);
    spans = cut_all(spans, at_top, -top, -top_slope);
    behind = if_any(cut_all(spans, at_bottom, -bottom, -bottom_slope));
}

fn least_of(vector: vec3<f32>) -> f32 {
    return min(min(vector.x, vector.y), vector.z);
}

fn safe_inverse(vector: vec3<f32>, least: vec3<f32>) -> vec3<f32> {
    let signed = select(least, -least, (vector < vec3<f32>(0.0)));
    return 1.0 / select(vector, signed, (abs(vector) < least));
}

// The ray between two parameters in a face, no nearer than a depth.
fn make_leg(face: u32, begin: f32, end: f32, nearest: f32) {
    let eye_origin = to_face(face, ray_origin);
    let direction = to_face(face, ray.direction);
    let a = eye_origin + direction * begin;
    let b = eye_origin + direction * end;
    let ws = 1.0 / max(vec2<f32>(a.z, b.z), vec2<f32>(nearest * 0.5));
    let half = f32(grid.tiles) * 0.5;
    let first = vec3<f32>((a.xy * ws.x + 1.0) * half, ws.x);
    let last = vec3<f32>((b.xy * ws.y + 1.0) * half, ws.y);
    let change = last - first;
    let least = vec3<f32>(LEAST_CHANGE, LEAST_CHANGE, LEAST_CHANGE * max(ws.x, ws.y));
    leg = Leg(first, change, safe_inverse(change, least), vec2<f32>(begin, end), ws);
    set_limit();
}

// Begins the search of a ray. Where it passes what lies near the eye, that is to be searched first.
fn begin_ray(asked: Ray) {
    ray = asked;
    ray_origin = ray.origin - grid.eye;
    reach = max(max(abs(ray_origin.x), abs(ray_origin.y)), abs(ray_origin.z));
    frame = ray_frame(ray.origin, ray.direction);
    best = Best(ray.t_max, NO_PRIMITIVE, 0.0, 0.0);
    found = false;
    limit = 1.0;
    capped = false;
    steps = 0u;
#ifdef COUNTERS
    work = vec4<u32>(0u);
#endif
    passes_eye = false;
    ahead = Spans(vec3<f32>(NEVER), vec3<f32>(NEVER));
    behind = ahead;
    let nearest_w = bitcast<f32>(word_0(NEAREST));
    if (nearest_w == 0.0) {
        return;
    }
    slice_base = word_0(SLICE_BASE);
    slice_rate = bitcast<f32>(word_0(SLICE_RATE));
    // Nothing is stored outside of these depths.
    let nearest = 0.99 / nearest_w;
    let farthest = 1.001 / bitcast<f32>(~word_0(FARTHEST));
    let noisy = select(0.0, noisy_cube(grid.tiles, reach), (search.split == 1u));
    let inverse = safe_inverse(ray.direction, vec3<f32>(1e-18));
    centre = select(0.0, noisy * 1.015625, noisy > 0.98 * nearest);
    let cube = max(centre, bitcast<f32>(word_0(NEAR_CUBE)));
    passes_eye = cube > 0.0 && passes_box(vec3<f32>(-cube), vec3<f32>(cube), inverse);
    begins = max(nearest, noisy);
    find_spans(1.0 + 1.0 / (16.0 * f32(grid.tiles)), begins, farthest);
}

// Whether the ray enters another face before its best hit.
fn has_face() -> bool {
    let begin = min(least_of(ahead.begin), least_of(behind.begin));
    return begin < NEVER && begin <= last_t() && !is_done();
}

// Makes the leg in the face that the ray enters next, and tells which one that is.
fn next_leg() -> u32 {
    let begin = min(least_of(ahead.begin), least_of(behind.begin));
    let is_ahead = ahead.begin == vec3<f32>(begin);
    let is_behind = behind.begin == vec3<f32>(begin);
    var face = 5u;
    var end = behind.end.z;
    if (is_ahead.x) {
        face = 0u;
        end = ahead.end.x;
        ahead.begin.x = NEVER;
    } else if (is_ahead.y) {
        face = 2u;
        end = ahead.end.y;
        ahead.begin.y = NEVER;
    } else if (is_ahead.z) {
        face = 4u;
        end = ahead.end.z;
        ahead.begin.z = NEVER;
    } else if (is_behind.x) {
        face = 1u;
        end = behind.end.x;
        behind.begin.x = NEVER;
    } else if (is_behind.y) {
        face = 3u;
        end = behind.end.y;
        behind.begin.y = NEVER;
    } else {
        behind.begin.z = NEVER;
    }
#ifdef COUNTERS
    work.w += 1u;
#endif
    make_leg(face, begin, end, begins);
    return face;
}
