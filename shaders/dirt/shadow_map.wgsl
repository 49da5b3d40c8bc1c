// Rays to the light, answered by a shadow map: what starts behind the surface that the map shows there is in shadow.

#import tracebench::types::{Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::view::{View, pixel_position, to_eye_space}

struct ShadowLookup {
    ray_count: u32,
    // Texels of the map, as wide as they are where the ray starts.
    bias: f32,
}

@group(0) @binding(0) var<uniform> light: View;
@group(0) @binding(1) var<uniform> lookup: ShadowLookup;
@group(0) @binding(2) var eye_depths: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn look_up(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= lookup.ray_count) {
        return;
    }
    let ray = rays[index];
    let start = to_eye_space(light, ray.origin + ray.direction * ray.t_min);
    // Rounding may leave what lies on the bounds a little outside of the map.
    let last = vec2<i32>(light.size) - 1;
    let texel = clamp(vec2<i32>(floor(pixel_position(light, start))), vec2<i32>(0), last);
    let texel_width = 2.0 * light.tan_half_width * start.z / light.size.x;
    if (start.z > textureLoad(eye_depths, texel, 0).x + lookup.bias * texel_width) {
        hits[index] = Hit(ray.t_min, NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
    } else {
        hits[index] = miss(STATUS_MISS);
    }
}
