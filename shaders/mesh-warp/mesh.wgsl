// The depths of a view as a mesh (WKP15, section 5.1: a regular grid with one vertex a pixel). A lane makes the vertex of its pixel, and the two
// triangles of the square whose upper left corner that is. A triangle that is not there has one vertex three times.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::view::View
#import tracebench::depth_cells::NO_SURFACE
#import tracebench::grid::corners_of

struct MeshSettings {
    size: vec2<u32>,
    // 1: triangles whose vertices differ more in depth are not there.
    cuts: u32,
    // By how much they may differ, share of the least.
    most: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> settings: MeshSettings;
@group(0) @binding(2) var eye_depths: texture_2d<f32>;
// Three numbers a vertex, three vertices a triangle.
@group(0) @binding(3) var<storage, read_write> positions: array<f32>;
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

const WORKGROUP_SIZE: u32 = 64u;

fn depth_of(vertex: u32) -> f32 {
    return textureLoad(eye_depths, vec2<u32>(vertex % settings.size.x, vertex / settings.size.x), 0).x;
}

// Where on the image a pixel's vertex is: at its centre, and of the outermost pixels on the image's border, so that the mesh covers it.
fn place_of(pixel: vec2<u32>) -> vec2<f32> {
    let centre = vec2<f32>(pixel) + 0.5;
    let before = select(centre, vec2<f32>(0.0), pixel == vec2<u32>(0u));
    return select(before, view.size, pixel + 1u == settings.size);
}

fn is_there(depths: vec3<f32>) -> bool {
    let least = min(depths.x, min(depths.y, depths.z));
    let greatest = max(depths.x, max(depths.y, depths.z));
    return greatest < NO_SURFACE && (settings.cuts == 0u || greatest - least <= settings.most * least);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn mesh(invocation: Invocation) {
    let vertex = linear_invocation(invocation, WORKGROUP_SIZE);
    let columns = settings.size.x;
    if (vertex >= columns * settings.size.y) {
        return;
    }
    let pixel = vec2<u32>(vertex % columns, vertex / columns);
    let depth = depth_of(vertex);
    let across = (place_of(pixel) * 2.0 / view.size - 1.0) * vec2<f32>(view.tan_half_width, -view.tan_half_height);
    var place = view.eye;
    // Else no triangle has the vertex.
    if (depth < NO_SURFACE) {
        place += (view.forward + view.right * across.x + view.up * across.y) * depth;
    }
    positions[vertex * 3u] = place.x;
    positions[vertex * 3u + 1u] = place.y;
    positions[vertex * 3u + 2u] = place.z;
    if (any(pixel + 1u == settings.size)) {
        return;
    }
    let square = pixel.y * (columns - 1u) + pixel.x;
    for (var side = 0u; side < 2u; side++) {
        let triangle = square * 2u + side;
        let corners = corners_of(triangle, columns);
        let depths = vec3<f32>(depth_of(corners.x), depth_of(corners.y), depth_of(corners.z));
        let kept = select(vec3<u32>(corners.x), corners, is_there(depths));
        indices[triangle * 3u] = kept.x;
        indices[triangle * 3u + 1u] = kept.y;
        indices[triangle * 3u + 2u] = kept.z;
    }
}
