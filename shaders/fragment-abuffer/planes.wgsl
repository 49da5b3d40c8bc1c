#define_import_path tracebench::fragment_planes

// Fragments that are planes, each cut to its pixel and to the depths that its triangle has there: a ray meets one where it meets the
// plane, if that is in the pixel and between these depths. What a pixel has of a triangle overlaps what its neighbours have by more than
// rounding moves a hit, and the parts of a ray in the pixels that it crosses join at the very same numbers, so that it slips through
// nowhere.

#import tracebench::fragment_store::{shape, traced, ray, eye_ray, found, found_node, found_depth, found_t, looked_at, part, load_id, depth_slack}
#import tracebench::fragment_layout::{OUTLINE_PARTS, has_outline}
#import tracebench::view::pixel_position
#ifdef SURFACES
#import tracebench::fragment_store::{data_of, load_payload}
#endif

// Of a part's ends, relative: views join by sums of their own.
const END_SLACK: f32 = 4.76837158e-7;

fn float_of(word: u32) -> f32 {
    return bitcast<f32>(load_id(word));
}

#ifdef SURFACES
// Whether a fragment's data is less than another's, so that of equal hits always the same one is taken, however lists are linked.
fn has_less(a: u32, b: u32) -> bool {
    let first = data_of(a) * shape.data_words + shape.data_offset;
    let second = data_of(b) * shape.data_words + shape.data_offset;
    for (var word = 0u; word < 4u; word++) {
        let one = load_payload(first + word);
        let other = load_payload(second + word);
        if (one != other) {
            return one < other;
        }
    }
    return false;
}
#endif

// Whether a point, in eye space, lies in one of the parts of the pixel that a mask has bits of.
fn is_inside(outline: u32, point: vec3<f32>) -> bool {
    let place = (pixel_position(traced.view, point) - vec2<f32>(looked_at)) * vec2<f32>(OUTLINE_PARTS);
    let at = vec2<u32>(clamp(place, vec2<f32>(0.0), vec2<f32>(OUTLINE_PARTS - 1u)));
    return ((outline >> (at.y * OUTLINE_PARTS.x + at.x)) & 1u) == 1u;
}

// Takes a fragment, whose least depth this is, if the ray meets it before what is found.
fn meet(node: u32, least: f32) {
    let at = node * shape.node_words + shape.plane_word;
    let across = node * shape.node_words + shape.normal_word;
    let normal = vec3<f32>(float_of(across), float_of(across + 1u), float_of(across + 2u));
    let slope = dot(normal, ray.direction);
    let t = (float_of(at + 1u) - dot(normal, ray.origin - traced.view.eye)) / slope;
    let slack = END_SLACK * abs(t);
    // Of a ray along the plane it is no number.
    let inside = t >= max(part.begin - slack, ray.t_min) && t <= min(part.end + slack, ray.t_max);
    if (slope == 0.0 || !inside || (found && t > found_t)) {
        return;
    }
    let depth = eye_ray.origin.z + eye_ray.direction.z * t;
    let off = depth_slack(depth);
    if (depth < least - off || depth > float_of(at) + off) {
        return;
    }
    if (has_outline(shape) && !is_inside(load_id(at + 2u), eye_ray.origin + eye_ray.direction * t)) {
        return;
    }
    // What differs between equal hits are their surfaces alone.
    if (found && t == found_t) {
#ifdef SURFACES
        if (!has_less(node, found_node)) {
            return;
        }
#else
        return;
#endif
    }
    found = true;
    found_node = node;
    found_depth = depth;
    found_t = t;
}
