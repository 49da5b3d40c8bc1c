#define_import_path tracebench::dirt_packed_walk

// The steps of a leg over the cells of a face of the packed forms of DIRT: over those whose masks have nothing of the ray's, down into
// those that have. Cells are whole numbers and are stepped over in one sense, so that rounding leads neither astray nor in circles.

#import tracebench::reads::pair_0
#import tracebench::dirt_packed_grid::tile_number
#import tracebench::dirt_packed_ray::{grid, search, leg, limit, capped, steps, work, depth_loss, mask_between}
#import tracebench::dirt_packed_legs::NEVER

// A tile with a depth slice of the ray's: the ray's s at both of its ends, its greatest w between them, and its slices.
struct Entered {
    tile: vec2<i32>,
    begin: f32,
    end: f32,
    w_most: f32,
    mask: vec2<u32>,
}

// Where the walk is: the face, the tile and the level of the cell that it enters next, at this s; whether there is one.
var<private> face: u32;
var<private> tile: vec2<i32>;
var<private> level: u32;
// Where the masks of the level begin.
var<private> level_begin: u32;
var<private> here: f32;
// Whether the leg does not go back along each axis. Without a change it meets no border on that axis before its end: one over the least
// change that counts is large.
var<private> is_forward: vec2<bool>;
var<private> is_walking: bool;
var<private> entered: Entered;

// Cells of a level along a face's edge.
fn edge_of(at_level: u32) -> u32 {
    return (grid.tiles + (1u << at_level) - 1u) >> at_level;
}

// Without the built-ins' promises for what is no number, which cost drivers two more operations.
fn min_second_if_nan(a: f32, b: f32) -> f32 {
    return select(b, a, (a < b));
}

fn max_second_if_nan(a: f32, b: f32) -> f32 {
    return select(b, a, (a > b));
}

// Begins the steps of the leg in a face.
fn begin_steps(walked: u32) {
    face = walked;
    tile = clamp(vec2<i32>(floor(leg.begin.xy)), vec2<i32>(0), vec2<i32>(i32(grid.tiles) - 1));
    level = 0u;
    level_begin = walked * grid.cells;
    here = 0.0;
    is_forward = leg.change.xy >= vec2<f32>(0.0);
    is_walking = true;
}

fn entered_number() -> u32 {
    return tile_number(grid, face, vec2<u32>(entered.tile));
}

// Enters the cell that comes next, where `asked`; tells whether it is a tile that is to be searched, which is `entered` then. Without
// branches: what differs between lanes is chosen by `select`, for drivers that run every branch for all lanes and mask what it writes.
fn step_on(asked: bool) -> bool {
    let is_over = (limit <= here) | (steps >= search.max_steps);
    let goes = asked & !is_over;
    capped = capped | (asked & is_over & (limit > here));
    is_walking = is_walking & !(asked & is_over);
    steps += select(0u, 1u, goes);
#ifdef COUNTERS
    work.pyramid_steps += select(0u, 1u, goes);
#endif
    let last_tile = vec2<i32>(i32(grid.tiles) - 1);
    let size = 1i << level;
    let cell = tile >> vec2<u32>(level);
    // The first tiles of this cell and of the next one.
    let first = cell << vec2<u32>(level);
    let past = first + size;
    let line = select(first, past, is_forward);
    // A ray does not leave the image but at the leg's end: along a seam it may lie on either side of the image's border.
    let is_inner = (line > vec2<i32>(0)) & (line <= last_tile);
    let leaves = select(vec2<f32>(NEVER), (vec2<f32>(line) - leg.begin.xy) * leg.inverse.xy, is_inner);
    let leaves_by_x = leaves.x <= leaves.y;
    let begin = here;
    let end = min_second_if_nan(max_second_if_nan(select(leaves.y, leaves.x, leaves_by_x), begin), 1.0);
    let w_here = leg.begin.z + leg.change.z * begin;
    let w_there = leg.begin.z + leg.change.z * end;
    let w_most = max_second_if_nan(max_second_if_nan(w_here, w_there), 0.0);
    let w_slack = depth_loss(w_most);
    let mask = mask_between(max_second_if_nan(min_second_if_nan(w_here, w_there) - w_slack, 0.0), w_most + w_slack);
    // As cell_number has it: tables in uniforms are slow where every lane asks for a place of its own.
    let edge = (i32(grid.tiles) + size - 1) >> level;
    let held = pair_0(select(0u, level_begin + u32(cell.y * edge + cell.x), goes));
    let overlaps = any((held & mask) != vec2<u32>(0u));
    let descends = goes & overlaps & (level > 0u);
    let finds = goes & overlaps & (level == 0u);
    let passes = goes & !descends;
    entered.tile = select(entered.tile, tile, finds);
    entered.begin = select(entered.begin, begin, finds);
    entered.end = select(entered.end, end, finds);
    entered.w_most = select(entered.w_most, w_most + w_slack, finds);
    entered.mask = select(entered.mask, mask, finds);
    // Across the nearer of the two sides, and along the other axis to where the ray is then, never back and never out of the cell.
    let at = vec2<i32>(floor(leg.begin.xy + leg.change.xy * end));
    let low = select(first, tile, is_forward);
    let high = select(tile, min(past - 1, last_tile), is_forward);
    let inside = clamp(at, low, high);
    let across = select(first - 1, past, is_forward);
    let next = select(vec2<i32>(inside.x, across.y), vec2<i32>(across.x, inside.y), leaves_by_x);
    // Up where nothing was, and only into another cell of the level above.
    let above = vec2<u32>(level + 1u);
    let rises = passes & !overlaps & (level < search.top_level) & any((next >> above) != (tile >> above));
    // Before the leg's end a border within the image was crossed.
    is_walking = select(is_walking, end < 1.0, passes);
    let lower = max(level, 1u) - 1u;
    let lower_edge = edge_of(lower);
    level_begin += select(0u, u32(edge * edge), rises);
    level_begin -= select(0u, lower_edge * lower_edge, descends);
    level = select(level + select(0u, 1u, rises), lower, descends);
    tile = select(tile, next, passes);
    here = select(here, end, passes);
    return finds;
}
