// Surfaces of hits, each gathered from the scene's vertices by the triangle that its ray hit.

#import tracebench::types::{Ray, Hit, Surface, no_surface, is_hit, SURFACE_LOST, SURFACE_NO_HIT}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::surface::surface_at

struct GatherSettings {
    ray_count: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> settings: GatherSettings;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
@group(0) @binding(3) var<storage, read> materials: array<u32>;
@group(0) @binding(4) var<storage, read> hits: array<Hit>;
@group(0) @binding(5) var<storage, read_write> surfaces: array<Surface>;
#ifdef BY_RAY
// For methods whose hits name no triangle: where they are placed along their rays, and the triangle that was seen there.
@group(0) @binding(6) var<storage, read> rays: array<Ray>;
@group(0) @binding(7) var<storage, read> seen: array<u32>;
#endif

const WORKGROUP_SIZE: u32 = 64u;

fn corner(primitive: u32, index: u32) -> vec3<f32> {
    let vertex = indices[primitive * 3u + index] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn gather(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= settings.ray_count) {
        return;
    }
    let hit = hits[index];
    if (!is_hit(hit.status)) {
        surfaces[index] = no_surface(SURFACE_NO_HIT);
        return;
    }
#ifdef BY_RAY
    let primitive = seen[index];
#else
    let primitive = hit.primitive;
#endif
    if (primitive >= arrayLength(&materials)) {
        surfaces[index] = no_surface(SURFACE_LOST);
        return;
    }
    var surface = surface_at(
        corner(primitive, 0u), corner(primitive, 1u), corner(primitive, 2u), hit.u, hit.v, materials[primitive],
    );
#ifdef BY_RAY
    let ray = rays[index];
    surface.position = ray.origin + ray.direction * hit.t;
#endif
    surfaces[index] = surface;
}
