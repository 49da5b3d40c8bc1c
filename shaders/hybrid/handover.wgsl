// Rays whose answers are not trusted are handed over to another search: `mark` tells them, their sums tell where each goes, `choose` puts them
// to the front of another buffer of rays, in their order, and `join` puts the other search's answers in the place of theirs.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::types::{Ray, Hit, Surface, is_hit}
#import tracebench::view::{View, to_eye_space, pixel_position}

struct HandoverSettings {
    ray_count: u32,
    // A bit a status whose answers are trusted.
    trusted: u32,
    // Hits that project nearer to the frame's border are not, pixels.
    border: f32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> settings: HandoverSettings;
// Its size counts pixels.
@group(0) @binding(1) var<uniform> frame: View;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read_write> hits: array<Hit>;
// One more than rays: 1 for each that is handed over; summed up, how many are before it.
@group(0) @binding(4) var<storage, read_write> places: array<u32>;
@group(0) @binding(5) var<storage, read_write> chosen: array<Ray>;
// For every number of rays a lane the workgroups of a search of the chosen rays.
@group(0) @binding(6) var<storage, read_write> workgroups: array<u32>;
@group(0) @binding(7) var<storage, read> other_hits: array<Hit>;
#ifdef SURFACES
@group(0) @binding(8) var<storage, read_write> surfaces: array<Surface>;
@group(0) @binding(9) var<storage, read> other_surfaces: array<Surface>;
#endif

const WORKGROUP_SIZE: u32 = 64u;
// As in tracers/kit/src/lanes.rs.
const MAX_RAYS_PER_LANE: u32 = 256u;
const MAX_WORKGROUPS: u32 = 65535u;

// Whether a point lies so near to the frame's border, on either side of it. What is behind the eye has no place there.
fn is_near_border(point: vec3<f32>) -> bool {
    let at = to_eye_space(frame, point);
    let beyond = abs(pixel_position(frame, at) - 0.5 * frame.size) - 0.5 * frame.size;
    let off = length(max(beyond, vec2<f32>(0.0))) + min(max(beyond.x, beyond.y), 0.0);
    return at.z > 0.0 && abs(off) < settings.border;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn mark(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index > settings.ray_count) {
        return;
    }
    var marked = 0u;
    if (index < settings.ray_count) {
        let hit = hits[index];
        let ray = rays[index];
        let trusted = ((settings.trusted >> hit.status) & 1u) == 1u;
        if (!trusted || (is_hit(hit.status) && is_near_border(ray.origin + ray.direction * hit.t))) {
            marked = 1u;
        }
    }
    places[index] = marked;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn choose(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    let all = places[settings.ray_count];
    if (index < settings.ray_count) {
        let place = places[index];
        var ray = rays[index];
        if (places[index + 1u] != place) {
            chosen[place] = ray;
        } else {
            // It ends before it begins.
            ray.t_min = 1.0;
            ray.t_max = 0.0;
            chosen[all + index - place] = ray;
        }
    }
    if (index < MAX_RAYS_PER_LANE) {
        let lanes = (all + index) / (index + 1u);
        let needed = (lanes + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
        let down = max((needed + MAX_WORKGROUPS - 1u) / MAX_WORKGROUPS, 1u);
        workgroups[3u * index] = (needed + down - 1u) / down;
        workgroups[3u * index + 1u] = down;
        workgroups[3u * index + 2u] = 1u;
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn join(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= settings.ray_count) {
        return;
    }
    let place = places[index];
    if (places[index + 1u] != place) {
        hits[index] = other_hits[place];
#ifdef SURFACES
        surfaces[index] = other_surfaces[place];
#endif
    }
}
