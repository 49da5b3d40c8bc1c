// Which triangles of an image that is rasterized in compute are seen, and the blocks of those that are large. A prefix sum over the blocks
// follows, which tells where each triangle's begin, and then the number of workgroups is known that passes take.

#import tracebench::scene::load_position
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::raster_work::{RasterPass, BLOCK_EDGE, NOT_SEEN}
#import tracebench::coverage::{outline_box, first_centre}
#ifdef AXIS
#import tracebench::coverage::outline_in_image
#import tracebench::unit_space::{UnitSpace, to_unit, on_image}
#else
#import tracebench::coverage::outline_in_view
#import tracebench::view::{View, to_eye_space}
#import tracebench::tile_clip::tile_rectangle
#endif

#ifdef AXIS
// The image along an axis of the unit cube.
struct RasterAxis {
    space: UnitSpace,
    axis: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> image: RasterAxis;
#else
@group(0) @binding(0) var<uniform> view: View;
#endif
@group(0) @binding(3) var<uniform> setup: RasterPass;
// As `work` in raster_work.wgsl.
@group(0) @binding(4) var<storage, read_write> found: array<u32>;
// Workgroups of a pass, along three dimensions.
@group(0) @binding(5) var<storage, read_write> groups: array<u32>;

const WORKGROUP_SIZE: u32 = 64u;

// Most workgroups along one dimension.
const MAX_WORKGROUPS: u32 = 65535u;

// By how much rectangles are grown: another shader may round corners to neighbouring points of the grid.
const GROWN: i32 = 2;

#ifdef AXIS
// By how much what triangles touch is grown in orthographic images, pixels: at least by what passes take to be touched.
const TOUCHED_MARGIN: f32 = 0.0625;
#endif

// Pixels, first and one behind the last, that a triangle may cover or touch.
fn rectangle_of(triangle: u32) -> vec4<i32> {
    let a = load_position(triangle * 3u);
    let b = load_position(triangle * 3u + 1u);
    let c = load_position(triangle * 3u + 2u);
    let size = vec2<i32>(setup.size);
#ifdef AXIS
    let places = array<vec2<f32>, 3>(
        on_image(image.axis, to_unit(image.space, a)).xy,
        on_image(image.axis, to_unit(image.space, b)).xy,
        on_image(image.axis, to_unit(image.space, c)).xy,
    );
    if (setup.touched == 1u) {
        let edge = vec2<f32>(setup.size);
        let low = min(min(places[0], places[1]), places[2]) * edge - TOUCHED_MARGIN;
        let high = max(max(places[0], places[1]), places[2]) * edge + TOUCHED_MARGIN;
        return vec4<i32>(
            vec2<i32>(clamp(floor(low), vec2<f32>(0.0), edge)), vec2<i32>(clamp(floor(high) + 1.0, vec2<f32>(0.0), edge)),
        );
    }
    if (!outline_in_image(places[0], places[1], places[2], vec2<f32>(setup.size))) {
        return vec4<i32>(0);
    }
#else
    if (setup.touched == 1u) {
        let touched = tile_rectangle(
            view, setup.size, to_eye_space(view, a), to_eye_space(view, b), to_eye_space(view, c),
        );
        return vec4<i32>(vec2<i32>(touched.first), vec2<i32>(touched.last));
    }
    if (!outline_in_view(view, a, b, c)) {
        return vec4<i32>(0);
    }
#endif
    let bounds = outline_box();
    return vec4<i32>(
        clamp(vec2<i32>(first_centre(bounds.x - GROWN), first_centre(bounds.y - GROWN)), vec2<i32>(0), size),
        clamp(vec2<i32>(first_centre(bounds.z + GROWN), first_centre(bounds.w + GROWN)), vec2<i32>(0), size),
    );
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn find(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle >= setup.triangle_count) {
        return;
    }
    let rectangle = rectangle_of(triangle);
    let is_seen = all(rectangle.zw > rectangle.xy);
    let pixels = vec2<u32>(max(rectangle.zw - rectangle.xy, vec2<i32>(0)));
    var blocks = 0u;
    var place = NOT_SEEN;
    if (is_seen) {
        let first = vec2<u32>(rectangle.xy) / BLOCK_EDGE;
        let last = (vec2<u32>(rectangle.zw) - 1u) / BLOCK_EDGE;
        let columns = last.x - first.x + 1u;
        if (pixels.x * pixels.y > setup.small_pixels) {
            blocks = columns * (last.y - first.y + 1u);
        }
        place = first.x | (first.y << 10u) | (columns << 20u);
    }
    found[triangle] = blocks;
    found[setup.triangle_count + 1u + triangle] = place;
}

// How many workgroups passes take, folded into two dimensions where one does not hold them.
@compute @workgroup_size(1)
fn deal() {
    let all = setup.lane_groups + found[setup.triangle_count];
    let down = max((all + MAX_WORKGROUPS - 1u) / MAX_WORKGROUPS, 1u);
    groups[0] = (all + down - 1u) / down;
    groups[1] = down;
    groups[2] = 1u;
}
