#define_import_path tracebench::dirt_packed_legs

// The faces that a ray of the packed forms of DIRT crosses, one after the other, each as a leg.

#import tracebench::types::{Ray, NO_PRIMITIVE}
#import tracebench::triangle::ray_frame
#import tracebench::lanes::open
#import tracebench::reads::word_0
#import tracebench::dirt_packed_grid::{NEAREST, FARTHEST, NEAR_CUBE, SLICE_BASE, SLICE_RATE, to_face, noisy_cube}
#import tracebench::dirt_packed_ray::{
    PLANE_SLACK, Best, Leg, Work, grid, search, ray, ray_origin, reach, frame, leg, best, found, limit, capped, steps, slice_base, slice_rate,
    work, is_done, last_t, set_limit
}
#import tracebench::dirt_packed_near::passes_box

// No ray gets there.
const NEVER: f32 = 1e38;
// Changes below this, of what there is, count as it.
const MIN_CHANGE: f32 = 1e-9;
// Slopes of planes and directions below this count as it.
const MIN_SLOPE: f32 = 1e-18;

// Rays from more than so many times as far as the scene reaches begin anew: a little less than what triangles are listed for.
const FAR: f32 = 3.9;

// Spans of three faces at once, those along the axes in one sense.
struct Spans {
    begin: vec3<f32>,
    end: vec3<f32>,
}

// In the faces along +x, +y, +z and in the opposite ones; those that are done begin at NEVER.
var<private> ahead: Spans;
var<private> behind: Spans;
// The greatest and the least w of all that is stored, 0 where there is nothing; half the edge of the cube in which tiles do not hold all.
var<private> nearest_w: f32;
var<private> farthest_w: f32;
var<private> near_cube: f32;
// The depth from which on images are searched.
var<private> begins: f32;
// Whether the ray passes the eye as near as tiles do not hold all, or as images are noise; half the edge of the cube where they are, 0
// where nothing is stored so near.
var<private> passes_eye: bool;
var<private> centre: f32;
// From where on rays are to begin anew; whether this one is; by how much its t is less than that of the ray that was asked for if it did.
var<private> far: f32;
var<private> is_far: bool;
var<private> skipped: f32;

// Without the built-ins' promises for what is no number, which cost drivers two more operations; spans are numbers.
fn min_second_if_nan(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, (a < b));
}

fn max_second_if_nan(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, (a > b));
}

// Cuts the spans of all faces at planes that opposite faces share, where value + slope t is 0: what is not negative lies ahead, what is not
// positive behind. A ray along such a plane keeps to one side of it, or within rounding of both, where another face holds it too.
fn cut_both(value: vec3<f32>, slope: vec3<f32>) {
    let inverse = safe_inverse(slope, vec3<f32>(MIN_SLOPE));
    let at = -value * inverse;
    let rises = inverse > vec3<f32>(0.0);
    ahead.begin = max_second_if_nan(ahead.begin, select(vec3<f32>(-NEVER), at, rises));
    ahead.end = min_second_if_nan(ahead.end, select(at, vec3<f32>(NEVER), rises));
    behind.begin = max_second_if_nan(behind.begin, select(at, vec3<f32>(-NEVER), rises));
    behind.end = min_second_if_nan(behind.end, select(vec3<f32>(NEVER), at, rises));
}

// The spans between two depths along every axis.
fn between(near: vec3<f32>, far: vec3<f32>, inverse: vec3<f32>) -> Spans {
    let one = (near - ray_origin) * inverse;
    let other = (far - ray_origin) * inverse;
    return Spans(max_second_if_nan(min_second_if_nan(one, other), vec3<f32>(ray.t_min)), min_second_if_nan(max_second_if_nan(one, other), vec3<f32>(ray.t_max)));
}

fn if_any(spans: Spans) -> Spans {
    return Spans(select(vec3<f32>(NEVER), spans.begin, (spans.begin <= spans.end)), spans.end);
}

// The spans of the ray in the faces along +x, +y, +z, and in the opposite ones: wider by TILE_MARGIN of a tile, so that no ray along a
// seam is lost by both sides, and between two depths.
fn find_spans(wide: f32, nearest: f32, farthest: f32, inverse: vec3<f32>) {
    ahead = between(vec3<f32>(nearest), vec3<f32>(farthest), inverse);
    behind = between(vec3<f32>(-nearest), vec3<f32>(-farthest), inverse);
    let z = ray_origin * wide;
    let dz = ray.direction * wide;
    cut_both(z - ray_origin.yzx, dz - ray.direction.yzx);
    cut_both(z + ray_origin.yzx, dz + ray.direction.yzx);
    cut_both(z - ray_origin.zxy, dz - ray.direction.zxy);
    cut_both(z + ray_origin.zxy, dz + ray.direction.zxy);
    ahead = if_any(ahead);
    behind = if_any(behind);
}

fn max_of(vector: vec3<f32>) -> f32 {
    return max(max(abs(vector.x), abs(vector.y)), abs(vector.z));
}

// Whether a ray from so far from the eye is to begin anew; none where nothing is stored, and `far` is no number.
fn begins_anew(from_eye: vec3<f32>) -> bool {
    return search.split == 1u && max_of(from_eye) > far;
}

// A far ray from just before all that is stored: images and tests of triangles are noise as large as an origin is far. With t and direction
// in halves of 12 bits products are exact, and so are the sums until what is left is as small as the new origin: it is rounded as others
// are. The ray stays as it is where t cannot say where the scene begins.
fn begun_anew(asked: Ray) -> Ray {
    if (!begins_anew(asked.origin - grid.eye)) {
        return asked;
    }
    let direction = asked.direction;
    let before = -1.0 / farthest_w * dot(abs(direction), vec3<f32>(1.0));
    let high = bitcast<vec3<f32>>(bitcast<vec3<u32>>(direction) & vec3<u32>(0xfffff000u));
    let low = direction - high;
    var t = 0.0;
    var origin = asked.origin;
    // The second time for what t was off by.
    for (var turn = 0u; turn < 2u; turn++) {
        t += (1.5 * before - dot(origin - grid.eye, direction)) / dot(direction, direction);
        let t_high = bitcast<f32>(bitcast<u32>(t) & 0xfffff000u);
        let t_low = t - t_high;
        origin = ((asked.origin + high * t_high) + high * t_low) + low * t_high + low * t_low;
    }
    if (t > 0.0 && dot(origin - grid.eye, direction) <= 1.125 * before) {
        skipped = t;
        return Ray(origin, max(asked.t_min - t, 0.0), direction, asked.t_max - t);
    }
    return asked;
}

fn min_of(vector: vec3<f32>) -> f32 {
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
    let w_most = max(ws.x, ws.y);
    let least = vec3<f32>(MIN_CHANGE, MIN_CHANGE, MIN_CHANGE * w_most);
    leg = Leg(first, change, safe_inverse(change, least), vec2<f32>(begin, end), ws, PLANE_SLACK * w_most);
    set_limit();
}

// What a lane's rays have in common: words of the structure, which are slow to read for every ray.
fn begin_lane() {
    nearest_w = bitcast<f32>(word_0(NEAREST));
    farthest_w = bitcast<f32>(~word_0(FARTHEST));
    far = FAR / farthest_w;
    near_cube = bitcast<f32>(word_0(NEAR_CUBE));
    slice_base = word_0(SLICE_BASE);
    slice_rate = bitcast<f32>(word_0(SLICE_RATE));
}

// Begins the search of a ray, after begin_lane. Where it passes what lies near the eye, that is to be searched first.
fn begin_ray(asked: Ray) {
    ray = asked;
    ray_origin = ray.origin - grid.eye;
    reach = max_of(ray_origin);
    is_far = begins_anew(ray_origin);
    frame = ray_frame(ray.origin, ray.direction);
    best = Best(ray.t_max, NO_PRIMITIVE, 0.0, 0.0);
    found = false;
    limit = 1.0;
    capped = false;
    steps = 0u;
#ifdef COUNTERS
    work = Work();
#endif
    passes_eye = false;
    ahead = Spans(vec3<f32>(NEVER), vec3<f32>(NEVER));
    behind = ahead;
    if (nearest_w == 0.0) {
        return;
    }
    // Nothing is stored outside of these depths.
    let nearest = 0.99 / nearest_w;
    let farthest = 1.001 / farthest_w;
    let noisy = select(0.0, noisy_cube(grid.tiles, reach), (search.split == 1u));
    let inverse = safe_inverse(ray.direction, vec3<f32>(MIN_SLOPE));
    centre = select(0.0, noisy * 1.015625, noisy > 0.98 * nearest);
    let cube = max(centre, near_cube);
    passes_eye = cube > 0.0 && passes_box(vec3<f32>(-cube), vec3<f32>(cube), inverse);
    begins = max(nearest, noisy);
    find_spans(1.0 + 1.0 / (16.0 * f32(grid.tiles)), begins, farthest, inverse);
}

// Whether the ray enters another face before its best hit.
fn has_face() -> bool {
    let begin = min(min_of(ahead.begin), min_of(behind.begin));
    return begin < NEVER && begin <= last_t() && !is_done();
}

// Makes the leg in the face that the ray enters next, and tells which one that is.
fn next_leg() -> u32 {
    let begin = min(min_of(ahead.begin), min_of(behind.begin));
    // The first of them, without branches.
    let is_ahead = ahead.begin == vec3<f32>(begin);
    let is_behind = behind.begin == vec3<f32>(begin);
    let first = vec3<bool>(is_ahead.x, is_ahead.y & !is_ahead.x, is_ahead.z & !(is_ahead.x | is_ahead.y));
    let none = !(is_ahead.x | is_ahead.y | is_ahead.z);
    let last = vec3<bool>(
        none & is_behind.x, none & is_behind.y & !is_behind.x, none & !(is_behind.x | is_behind.y),
    );
    ahead.begin = select(ahead.begin, vec3<f32>(NEVER), first);
    behind.begin = select(behind.begin, vec3<f32>(NEVER), last);
    let axis = select(select(2u, 1u, first.y | last.y), 0u, first.x | last.x);
    let face = 2u * axis + select(0u, 1u, none);
    let ends = select(ahead.end, behind.end, none);
    let end = select(select(ends.z, ends.y, axis == 1u), ends.x, axis == 0u);
#ifdef COUNTERS
    work.views_entered += 1u;
#endif
    make_leg(face, begin, end, begins);
    return face;
}
