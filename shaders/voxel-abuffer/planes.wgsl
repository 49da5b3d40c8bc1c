// The pass over the geometry of fragments that are oriented planes, of one of its three images: a triangle is drawn in the image along the
// axis that its normal is longest along, so that slopes are at most 1, into every texel that it touches. A fragment is the plane and
// what of the triangle lies in the texel. Voxels are marked with the axes of what lies in them. Both builds, by the rasterizer and
// in compute (`draw`), decide by the same arithmetic which texels are touched.

#import tracebench::scene::load_position
#import tracebench::plane_depth::{facet, size_of}
#import tracebench::surface::max_of
#import tracebench::unit_space::{to_unit, on_image, from_image, dominant_axis, voxel_index}
#import tracebench::voxel_space::layer_code
#import tracebench::voxel_fragments::{drawn, taken}
#ifdef STORE
#import tracebench::voxel_fragments::store_fragment
#endif
#import tracebench::voxel_plane_parts::{Part, part_margin, part_in_texel, is_part, part_words}
#import tracebench::dispatch::Invocation
#import tracebench::raster_work::part_of
#import tracebench::tile_clip::{TileRectangle, rectangle_corner}

#ifdef STORE
@group(0) @binding(3) var<storage, read> materials: array<u32>;
// Four bits a voxel: an axis' bit is set where the image along it shows anything there.
@group(0) @binding(9) var<storage, read_write> cells: array<atomic<u32>>;
#endif

// The sine between two edges, each of size 1, below which their product in f32 is noise: 2^-19, of numbers off by 2^-24.
const MIN_SINE: f32 = 1.9073486328125e-6;

// A triangle as its fragments need it, the same at all of them.
struct AxisTriangle {
    // Corners in the image, texels.
    first_two: vec4<f32>,
    // The third one, and how the depth changes by place across and down.
    third: vec4<f32>,
    // A place on the plane, texels, and its depth in the cube.
    on_plane: vec3<f32>,
    // Least and greatest depth of the corners.
    depths: vec2<f32>,
    // Material; 1 where the normal points along the axis; 1 where the triangle is drawn along this axis.
    words: vec3<u32>,
}

// By its first of three corners.
fn axis_triangle(first: u32) -> AxisTriangle {
    let a = load_position(first);
    let b = load_position(first + 1u);
    let c = load_position(first + 2u);
    var flat_one: AxisTriangle;
    flat_one.words = vec3<u32>(0u);
    // Of corners in a line there is no plane, and no ray meets them.
    if (!(min(size_of(b - a), min(size_of(c - b), size_of(a - c))) > 0.0)) {
        return flat_one;
    }
    let plane = facet(a, b, c);
    // Nor is there one of a sliver whose normal is what rounding left of it; it is narrower by far than what neighbours are grown by.
    if (!(max_of(plane.across) > MIN_SINE)) {
        return flat_one;
    }
    // In the cube, whose axes may be scaled differently.
    let across = plane.across / drawn.space.scale;
    let size = max_of(across);
    let normal = across / size;
    if (dominant_axis(normal) != drawn.axis) {
        return flat_one;
    }
    let edge = f32(drawn.space.image);
    let places = array<vec3<f32>, 4>(
        on_image(drawn.axis, to_unit(drawn.space, a)),
        on_image(drawn.axis, to_unit(drawn.space, b)),
        on_image(drawn.axis, to_unit(drawn.space, c)),
        on_image(drawn.axis, to_unit(drawn.space, plane.at)),
    );
    let tilt = on_image(drawn.axis, normal);
    let slopes = clamp(-tilt.xy / tilt.z, vec2<f32>(-1.0), vec2<f32>(1.0));
    flat_one.first_two = vec4<f32>(places[0].xy, places[1].xy) * edge;
    flat_one.third = vec4<f32>(places[2].xy * edge, slopes);
    flat_one.on_plane = vec3<f32>(places[3].xy * edge, places[3].z);
    flat_one.depths = vec2<f32>(
        min(places[0].z, min(places[1].z, places[2].z)), max(places[0].z, max(places[1].z, places[2].z)),
    );
#ifdef STORE
    let material = materials[first / 3u];
#else
    let material = 0u;
#endif
    flat_one.words = vec3<u32>(material, select(0u, 1u, (tilt.z > 0.0)), 1u);
    return flat_one;
}

// The texels that it may touch: first, and one behind the last.
fn touched_by(triangle: AxisTriangle) -> vec4<f32> {
    let margin = part_margin(drawn.space.image);
    let low = min(triangle.first_two.xy, min(triangle.first_two.zw, triangle.third.xy)) - margin;
    let high = max(triangle.first_two.xy, max(triangle.first_two.zw, triangle.third.xy)) + margin;
    let edge = vec2<f32>(f32(drawn.space.image));
    return vec4<f32>(clamp(floor(low), vec2<f32>(0.0), edge), clamp(floor(high) + 1.0, vec2<f32>(0.0), edge));
}

#ifdef STORE
// Marks the voxels that a texel's square and a range of depths lie in. Grids are not finer than images, so that these are few.
fn mark_voxels(texel: vec2<u32>, depths: vec2<f32>) {
    let grid = drawn.space.grid;
    let first = texel * grid / drawn.space.image;
    let last = ((texel + 1u) * grid - 1u) / drawn.space.image;
    let layers = vec2<u32>(clamp(floor(depths * f32(grid)), vec2<f32>(0.0), vec2<f32>(f32(grid - 1u))));
    for (var layer = layers.x; layer <= layers.y; layer++) {
        for (var down = first.y; down <= last.y; down++) {
            for (var across = first.x; across <= last.x; across++) {
                let place = from_image(drawn.axis, vec3<f32>(vec3<u32>(across, down, layer)));
                let voxel = voxel_index(drawn.space, vec3<i32>(place));
                let bit = (1u << drawn.axis) << ((voxel & 7u) * 4u);
                // Most are marked already.
                if ((atomicLoad(&cells[voxel >> 3u]) & bit) == 0u) {
                    atomicOr(&cells[voxel >> 3u], bit);
                }
            }
        }
    }
}
#endif

// What a pass does with a triangle and a texel that it may touch.
fn put_fragment(texel: vec2<f32>, triangle: AxisTriangle) {
    let image = drawn.space.image;
    let margin = part_margin(image);
    let part = part_in_texel(texel, triangle.first_two.xy, triangle.first_two.zw, triangle.third.xy, margin);
    if (!is_part(part)) {
        return;
    }
#ifdef TALLY
    // How many fragments an axis has, before there is room for any.
    atomicAdd(&taken[drawn.axis], 1u);
#else
    let edge = f32(image);
    let slopes = triangle.third.zw;
    // The plane at the texel's centre, no further from the corners' depths than it is from the part.
    let on_plane = triangle.on_plane.z + dot(slopes, (texel + 0.5 - triangle.on_plane.xy) / edge);
    let reach = (abs(slopes.x) + abs(slopes.y)) * (0.5 + margin) / edge;
    let held = clamp(on_plane, triangle.depths.x - reach, triangle.depths.y + reach);
    let depth = clamp(held, 1e-30, 0.9999999);
    let uphill = select(part.high, part.low, slopes < vec2<f32>(0.0)) - 0.5;
    let downhill = select(part.low, part.high, slopes < vec2<f32>(0.0)) - 0.5;
    let least = max(depth + dot(slopes, downhill) / edge, triangle.depths.x);
    let greatest = min(depth + dot(slopes, uphill) / edge, triangle.depths.y);
    let place = vec2<u32>(texel);
    store_fragment(
        place,
        layer_code(depth, triangle.words.y == 1u),
        vec4<u32>(part_words(slopes, part), triangle.words.x),
    );
    mark_voxels(place, vec2<f32>(min(least, greatest) - margin / edge, max(least, greatest) + margin / edge));
#endif
}

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let part = part_of(invocation);
    if (any(part.high <= part.low)) {
        return;
    }
    let triangle = axis_triangle(part.triangle * 3u);
    if (triangle.words.z == 0u) {
        return;
    }
    let touched = vec4<i32>(touched_by(triangle));
    let low = max(touched.xy, part.low);
    let high = min(touched.zw, part.high);
    for (var row = low.y; row < high.y; row++) {
        for (var column = low.x; column < high.x; column++) {
            put_fragment(vec2<f32>(vec2<i32>(column, row)), triangle);
        }
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) first_two: vec4<f32>,
    @location(1) @interpolate(flat) third: vec4<f32>,
#ifdef STORE
    @location(2) @interpolate(flat) on_plane: vec3<f32>,
    @location(3) @interpolate(flat) depths: vec2<f32>,
    @location(4) @interpolate(flat) words: vec3<u32>,
#endif
}

// Two triangles a triangle: the rectangle of texels that it may touch; outside of the image where another axis has it.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = axis_triangle(index / 6u * 3u);
    var corner: Corner;
    corner.position = vec4<f32>(2.0, 2.0, 0.5, 1.0);
    if (triangle.words.z == 0u) {
        return corner;
    }
    let touched = touched_by(triangle);
    corner.position = rectangle_corner(TileRectangle(touched.xy, touched.zw), vec2<u32>(drawn.space.image), index);
    corner.first_two = triangle.first_two;
    corner.third = triangle.third;
#ifdef STORE
    corner.on_plane = triangle.on_plane;
    corner.depths = triangle.depths;
    corner.words = triangle.words;
#endif
    return corner;
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    var triangle: AxisTriangle;
    triangle.first_two = in.first_two;
    triangle.third = in.third;
#ifdef STORE
    triangle.on_plane = in.on_plane;
    triangle.depths = in.depths;
    triangle.words = in.words;
#endif
    put_fragment(floor(in.position.xy), triangle);
    return vec4<f32>(0.0);
}
