// Normal and material of every pixel of every layer: what shading needs of them, 16 bytes each, of the triangle that was drawn there.
// The paper keeps colours (section 3.1).

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::surface::unit_normal
#import tracebench::quadtree_forest::Forest

@group(0) @binding(0) var<uniform> forest: Forest;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
@group(0) @binding(3) var<storage, read> materials: array<u32>;
@group(0) @binding(4) var<storage, read> names: array<u32>;
// Of the first layer, the third and so on, and of those between, since one binding does not hold all.
@group(0) @binding(5) var<storage, read_write> odd_layers: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> even_layers: array<vec4<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

fn corner(primitive: u32, index: u32) -> vec3<f32> {
    let vertex = indices[primitive * 3u + index] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn surfaces(invocation: Invocation) {
    let pixels = forest.size.x * forest.size.y;
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= pixels * forest.image_count) {
        return;
    }
    var payload = vec4<u32>(0u);
    if (names[index] != 0u) {
        let primitive = ~names[index];
        let a = corner(primitive, 0u);
        let normal = unit_normal(corner(primitive, 1u) - a, corner(primitive, 2u) - a);
        payload = vec4<u32>(bitcast<vec3<u32>>(normal), materials[primitive]);
    }
    let image = index / pixels;
    let view = image / forest.layers;
    let layer = image % forest.layers;
    let layers = select(forest.layers / 2u, (forest.layers + 1u) / 2u, ((layer & 1u) == 0u));
    let at = (view * layers + layer / 2u) * pixels + index % pixels;
    if ((layer & 1u) == 0u) {
        odd_layers[at] = payload;
    } else {
        even_layers[at] = payload;
    }
}
