#define_import_path tracebench::dirt_tile_tree

// The nodes of a tile's tree in the packed forms of DIRT.

#import tracebench::reads::quad_0
#import tracebench::dirt_packed_grid::{BOX_MARGIN, BOX_STEP, depth_base, depth_step}
#import tracebench::dirt_packed_ray::{PLANE_SLACK, leg, limit, place_loss, depth_loss}

// The planes of a tile's boxes: s of a code is code * factor + near or far, widened towards the ray's beginning or its end.
struct TilePlanes {
    factor: vec2<f32>,
    near: vec2<f32>,
    far: vec2<f32>,
    depth_slack: f32,
    base: u32,
    step: u32,
    begin: f32,
    end: f32,
}

// Those of a tile that the ray is in from one s to another, with the greatest w that it has there and the scale of the tile's depths.
fn planes_of(tile: vec2<i32>, begin: f32, end: f32, w_most: f32, scale: u32) -> TilePlanes {
    // A box's code 0 is so far before the tile.
    let off = (vec2<f32>(tile) - BOX_MARGIN - leg.begin.xy) * leg.inverse.xy;
    let factor = BOX_STEP * leg.inverse.xy;
    let slack = place_loss(w_most) * abs(leg.inverse.xy) + (abs(off) + 255.0 * abs(factor)) * PLANE_SLACK;
    let depth_slack = depth_loss(w_most) * abs(leg.inverse.z);
    return TilePlanes(factor, off - slack, off + slack, depth_slack, depth_base(scale), depth_step(scale), begin, end);
}

fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>(vec4<i32>(unpack4xU8(word)));
}

fn min_second_if_nan(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, (a < b));
}

fn max_second_if_nan(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, (a > b));
}

fn depths_at(planes: TilePlanes, word: u32) -> vec4<f32> {
    let w = bitcast<vec4<f32>>(vec4<u32>(planes.base) + unpack4xU8(word) * planes.step);
    return (w - leg.begin.z) * leg.inverse.z;
}

// Which of four children the ray meets before its best hit.
fn boxes_met(planes: TilePlanes, near: vec3<u32>, far: vec3<u32>) -> vec4<bool> {
    let enter_x = bytes(near.x) * planes.factor.x + planes.near.x;
    let enter_y = bytes(near.y) * planes.factor.y + planes.near.y;
    let enter_w = depths_at(planes, near.z) - planes.depth_slack;
    let leave_x = bytes(far.x) * planes.factor.x + planes.far.x;
    let leave_y = bytes(far.y) * planes.factor.y + planes.far.y;
    let leave_w = depths_at(planes, far.z) + planes.depth_slack;
    let enter = max_second_if_nan(max_second_if_nan(enter_x, enter_y), max_second_if_nan(enter_w, vec4<f32>(planes.begin)));
    let leave = min_second_if_nan(min_second_if_nan(leave_x, leave_y), min_second_if_nan(leave_w, vec4<f32>(min(planes.end, limit))));
    return enter <= leave;
}

// A bit for every child that the ray meets.
fn meet_node(planes: TilePlanes, node: u32) -> u32 {
    let x = quad_0(3u * node);
    let y = quad_0(3u * node + 1u);
    let w = quad_0(3u * node + 2u);
    let backward = leg.inverse < vec3<f32>(0.0);
    let near_x = select(x.xy, x.zw, backward.x);
    let near_y = select(y.xy, y.zw, backward.y);
    let near_w = select(w.xy, w.zw, backward.z);
    let far_x = select(x.zw, x.xy, backward.x);
    let far_y = select(y.zw, y.xy, backward.y);
    let far_w = select(w.zw, w.xy, backward.z);
    let low = boxes_met(planes, vec3<u32>(near_x.x, near_y.x, near_w.x), vec3<u32>(far_x.x, far_y.x, far_w.x));
    let high = boxes_met(planes, vec3<u32>(near_x.y, near_y.y, near_w.y), vec3<u32>(far_x.y, far_y.y, far_w.y));
    let low_bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), low);
    let high_bits = select(vec4<u32>(0u), vec4<u32>(16u, 32u, 64u, 128u), high);
    let all_bits = low_bits | high_bits;
    return (all_bits.x | all_bits.y) | (all_bits.z | all_bits.w);
}
