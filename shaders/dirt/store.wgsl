// The end of DIRT's trace pass (section 4.2.1, "Final Storage"): every hit goes to the list of the pixel that it projects
// to. The search tells no view, so that it is the same for both end points: the view is the first that has the hit.

#import tracebench::types::{Ray, Hit, Surface, no_surface, is_hit, SURFACE_LOST, SURFACE_NO_HIT}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::view::{View, to_eye_space, direction_to_eye_space, pixel_position}
#import tracebench::dirt_hit_buffer::{HitNode, SHADING_BITS}

struct StoreSettings {
    ray_count: u32,
    view_count: u32,
    // Of a view, as large as the image of heads.
    pixels: vec2<u32>,
}

@group(0) @binding(0) var<uniform> settings: StoreSettings;
// Their sizes count pixels.
@group(0) @binding(1) var<uniform> views: array<View, 6>;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read> hits: array<Hit>;
@group(0) @binding(4) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> nodes: array<HitNode>;
@group(0) @binding(6) var<storage, read_write> surfaces: array<Surface>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn store(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= settings.ray_count) {
        return;
    }
    let hit = hits[index];
    if (!is_hit(hit.status)) {
        surfaces[index] = no_surface(SURFACE_NO_HIT);
        return;
    }
    // Until it is fetched.
    surfaces[index] = no_surface(SURFACE_LOST);
    let ray = rays[index];
    for (var number = 0u; number < settings.view_count; number++) {
        let view = views[number];
        let point = to_eye_space(view, ray.origin) + direction_to_eye_space(view, ray.direction) * hit.t;
        let pixel = vec2<i32>(floor(pixel_position(view, point)));
        let in_view = point.z >= view.near && point.z <= view.far && all(pixel >= vec2<i32>(0))
            && all(pixel < vec2<i32>(settings.pixels));
        if (in_view) {
            let next = atomicExchange(&heads[u32(pixel.y) * settings.pixels.x + u32(pixel.x)], index + 1u);
            let position = ray.origin + ray.direction * hit.t;
            nodes[index] = HitNode(next, hit.primitive, hit.u, hit.v, position, (number << SHADING_BITS) | index);
            return;
        }
    }
}
