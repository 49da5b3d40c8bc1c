// The trace through voxels and A-buffers (section 3.2): a ray goes through the grid voxel by voxel; in one that has anything its
// points are told inside or outside by the layers of one of three images, and where that changes it has met a surface. With ORIENTED
// fragments are planes, and the ray is met by the nearest that it goes through.

#import tracebench::types::{Ray, Hit, Surface, miss, no_surface, NO_PRIMITIVE, STATUS_UNWRITTEN, STATUS_HIT, STATUS_MISS, STATUS_STEP_CAP, SURFACE_NO_HIT, SURFACE_WRITTEN, SURFACE_LOST}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::lanes::{WORKGROUP_SIZE, open, answer_rays, answer_again}
#ifdef ORIENTED
#import tracebench::voxel_store::{search, work, counted, COUNTS}
#import tracebench::voxel_plane_search::{found, found_t, find_hit, surface_of_hit}
#else
#import tracebench::unit_space::{on_image, from_image, dominant_axis, voxel_at}
#import tracebench::voxel_walk::{leaves_voxel, next_voxel, is_in_grid}
#import tracebench::voxel_space::is_less
#import tracebench::voxel_store::{search, begin_ray, ray, origin, direction, work, counted, code_of, head_of, load_node, load_data, COUNTS, STEPPED, STARTS_INSIDE, EMPTY, CANCELLED}
#import tracebench::voxel_search::{found, found_t, found_axis, found_texel, found_side, start_t, texel_t, start_side, run_axis, NO_AXIS, take_image, texel_at, place_at, side_of, side_at, search_voxel, halve}
#endif

@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read_write> hits: array<Hit>;
#ifdef SURFACES
@group(0) @binding(3) var<storage, read_write> surfaces: array<Surface>;
#endif

#ifndef ORIENTED
// The voxel that the ray has hit something in.
var<private> found_voxel: vec3<i32>;

// The image that a voxel's code chooses; where normals have cancelled, or there are none, that along which the ray goes most.
fn chosen_axis(code: u32) -> u32 {
    return select(code - 1u, dominant_axis(direction), (code == EMPTY || code == CANCELLED));
}

fn find_hit(given: Ray) {
    found = false;
    run_axis = NO_AXIS;
    let space = search.space;
    var span = begin_ray(given);
    if (!(span.begin <= span.end)) {
        return;
    }
#ifdef LIFTED
    lift = vec3<f32>(0.0);
    crossing = 0.0;
#endif
    texel_t = 1.0 / (f32(space.image) * length(direction));
    if (span.begin <= ray.t_min) {
#ifdef LIFTED
        span.begin = ray.t_min;
        lift = lift_off(origin + direction * ray.t_min);
        origin += lift;
#else
        span.begin = ray.t_min + search.start_bias * texel_t;
#endif
        if (!(span.begin <= span.end)) {
            return;
        }
    }
    let edge = f32(space.grid);
    let heading = vec3<i32>(sign(direction));
    var voxel = voxel_at(space, origin + direction * span.begin);
    var t = span.begin;
    start_t = t;
#ifdef COUNTERS
    let tells_start = true;
#else
    let tells_start = search.by_change == 0u;
#endif
    if (tells_start) {
        let axis = chosen_axis(code_of(voxel));
        take_image(axis);
        start_side = side_at(axis, t);
    }
#ifdef COUNTERS
    work[STARTS_INSIDE] = select(0u, 1u, (start_side != 0));
#endif
    open += 1u;
    loop {
        var leaves = vec3<f32>(0.0);
        var exit = t;
        var code = EMPTY;
        var goes_past = false;
        // To the next voxel that is searched, which is done outside: drivers may run every branch of a loop for all lanes.
        loop {
            if (!is_in_grid(voxel, space.grid)) {
                open -= 1u;
                break;
            }
#ifdef COUNTERS
            work[STEPPED] += 1u;
#endif
            leaves = leaves_voxel(origin, direction, heading, voxel, edge);
            exit = clamp(min(leaves.x, min(leaves.y, leaves.z)), t, span.end);
            code = code_of(voxel);
            // A layer is as deep as at its texel's centre, and so may lie behind the voxel that it marks: where nothing is marked there
            // the search goes on for a texel.
            goes_past = code == EMPTY && run_axis != NO_AXIS;
            if (code != EMPTY || goes_past) {
                break;
            }
            if (exit >= span.end) {
                open -= 1u;
                break;
            }
            voxel = next_voxel(voxel, heading, leaves);
            t = exit;
        }
        if (code == EMPTY && !goes_past) {
            break;
        }
        found_voxel = select(found_voxel, voxel, code != EMPTY);
        let axis = select(chosen_axis(code), run_axis, goes_past);
        search_voxel(axis, t, select(exit, min(exit, t + texel_t), goes_past));
        if (code == EMPTY) {
            run_axis = NO_AXIS;
        }
        if (found || exit >= span.end) {
            open -= 1u;
            break;
        }
        voxel = next_voxel(voxel, heading, leaves);
        t = exit;
    }
    halve();
#ifdef LIFTED
    put_back();
    origin -= lift;
#endif
    found_t = clamp(found_t, ray.t_min, ray.t_max);
}

// The layer that is nearest to a point: texels from there, squared, and more where it faces against `crossing`; its data.
struct Nearest {
    distance: f32,
    data: vec4<u32>,
    any: bool,
}

const NONE_NEAR: Nearest = Nearest(0.0, vec4<u32>(0u), false);

// Texels, squared, by which a layer must be nearer that faces otherwise than the ray crosses it.
const TURNED: f32 = 4.0;

// 1 where a ray leaves something, whose layer faces along it, -1 where it enters something, 0 where layers of either facing count alike.
var<private> crossing: f32 = 0.0;

fn tell_crossing() {
    crossing = select(1.0, -1.0, side_of(found_axis, vec2<i32>(found_texel), place_at(found_t)) > found_side);
}

// The nearest of what is known and the layers of a texel. `place`: texels across and down, depth in texels.
fn nearest_in(known: Nearest, axis: u32, texel: vec2<u32>, place: vec3<f32>) -> Nearest {
    var nearest = known;
    let aside = vec2<f32>(texel) + 0.5 - place.xy;
    let least = dot(aside, aside);
    if (nearest.any && least > nearest.distance) {
        return nearest;
    }
    var link = head_of(axis, texel);
    open += 1u;
    loop {
        if (link == 0u) {
            open -= 1u;
            break;
        }
        let node = load_node(axis, link - 1u);
        let along = bitcast<f32>(node.x) * f32(search.space.image) - place.z;
        var distance = least + along * along;
        // Lists are in the order of depths: what follows is farther still.
        if (nearest.any && along > 0.0 && distance > nearest.distance) {
            open -= 1u;
            break;
        }
        if (!nearest.any || distance <= nearest.distance) {
            let data = load_data(axis, link - 1u);
            distance += select(0.0, TURNED, (dot(bitcast<vec3<f32>>(data.xyz), ray.direction) * crossing < 0.0));
            // Of layers at one place that with the least data, whatever order they came in.
            let is_nearer = distance < nearest.distance || (distance == nearest.distance && is_less(data, nearest.data));
            if (!nearest.any || is_nearer) {
                nearest = Nearest(distance, data, true);
            }
        }
        link = node.y;
    }
    return nearest;
}

#ifdef LIFTED
// By what the ray was lifted, in the cube.
var<private> lift: vec3<f32>;

// Squared texels from a start within which a layer may hold it: it is as deep as at its texel's centre.
const HELD: f32 = 2.0;

// What takes a start off the layer that it lies on: along the normal, to the side to which the ray goes (after Waechter and Binder, "A fast
// and robust method for avoiding self-intersection", Ray Tracing Gems 2019).
fn lift_off(start: vec3<f32>) -> vec3<f32> {
    let edge = f32(search.space.image);
    var nearest = NONE_NEAR;
    var axis = 0u;
    open += 1u;
    loop {
        if (axis == 3u) {
            open -= 1u;
            break;
        }
        let place = on_image(axis, start) * edge;
        nearest = nearest_in(nearest, axis, vec2<u32>(texel_at(place)), place);
        axis += 1u;
    }
    if (!nearest.any || nearest.distance > HELD) {
        return vec3<f32>(0.0);
    }
    let normal = normalize(bitcast<vec3<f32>>(nearest.data.xyz) / search.space.scale);
    return normal * sign(dot(normal, direction)) * (search.start_bias / edge);
}

// Back onto the ray, which meets the plane of the layer that the lifted one has met a little before or behind.
fn put_back() {
    if (!found) {
        return;
    }
    tell_crossing();
    let place = on_image(found_axis, origin + direction * found_t) * f32(search.space.image);
    let normal = bitcast<vec3<f32>>(nearest_in(NONE_NEAR, found_axis, found_texel, place).data.xyz) / search.space.scale;
    let further = dot(normal, lift) / dot(normal, direction);
    found_t += select(0.0, further, abs(further) <= 8.0 * search.start_bias * texel_t);
}
#endif

#ifdef SURFACES
// The layer of the hit's own texel that is nearest in depth. Where it has none, as the ray has come out of the others' layers there, the
// nearest of those in the images of the hit's voxel, which has one at least.
fn surface_of_hit() -> Surface {
    let edge = f32(search.space.image);
    let unit = origin + direction * found_t;
#ifndef LIFTED
    tell_crossing();
#endif
    var nearest = nearest_in(NONE_NEAR, found_axis, found_texel, on_image(found_axis, unit) * edge);
    if (!nearest.any) {
        let texels = edge / f32(search.space.grid);
        let most = i32(ceil(texels)) + 1;
        // In growing squares around the hit, until whatever lies outside of them is farther.
        var width = min(5, most);
        var index = 0;
        open += 1u;
        loop {
            if (index == 3 * width * width) {
                if (width == most || (nearest.any && nearest.distance < 0.25 * f32(width * width))) {
                    open -= 1u;
                    break;
                }
                width = min(2 * width + 1, most);
                index = 0;
            }
            let axis = (found_axis + u32(index / (width * width))) % 3u;
            let place = on_image(axis, unit) * edge;
            let first = vec2<i32>(on_image(axis, vec3<f32>(found_voxel)).xy * texels);
            let begin = clamp(texel_at(place) - width / 2, first, first + most - width);
            let texel = min(begin + vec2<i32>(index % width, index / width % width), vec2<i32>(i32(search.space.image) - 1));
            nearest = nearest_in(nearest, axis, vec2<u32>(texel), place);
            index += 1;
        }
    }
    if (!nearest.any) {
        return no_surface(SURFACE_LOST);
    }
    let position = ray.origin + ray.direction * found_t;
    return Surface(position, nearest.data.w, bitcast<vec3<f32>>(nearest.data.xyz), SURFACE_WRITTEN);
}
#endif
#endif

#ifdef SURFACES
var<private> found_surface: Surface;
#endif

override fn tracebench::lanes::search_ray(index: u32) {
    find_hit(rays[index]);
#ifdef SURFACES
    found_surface = no_surface(SURFACE_NO_HIT);
    if (found && open == 0u) {
        found_surface = surface_of_hit();
    }
#endif
}

override fn tracebench::lanes::answer_ray(index: u32) {
    if (open > 0u) {
        hits[index] = miss(STATUS_STEP_CAP);
    } else if (found) {
        hits[index] = Hit(found_t, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
    } else {
        // Nothing is outside of the cube: who leaves it has missed.
        hits[index] = miss(STATUS_MISS);
    }
#ifdef SURFACES
    if (open > 0u) {
        found_surface = no_surface(SURFACE_NO_HIT);
    }
    surfaces[index] = found_surface;
#endif
#ifdef COUNTERS
    for (var count = 0u; count < COUNTS; count++) {
        atomicStore(&counted[2u * search.touched_words + index * COUNTS + count], work[count]);
    }
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, search.ray_count, search.rays_per_lane);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace_unanswered(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    answer_again(index, search.ray_count, index < search.ray_count && hits[index].status == STATUS_UNWRITTEN);
}
