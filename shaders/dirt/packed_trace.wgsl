// The search of the packed forms of DIRT. A ray crosses the faces one after the other, in each walks the tiles whose masks have a depth
// slice of it, up and down their pyramid, and tests what a tile holds: all of it, the lists of the slices that it passes, or with TREES
// what the boxes of the tile's tree let through, nearest first. A hit counts wherever it lies along the ray; it is final once it does
// not lie beyond the end of the cells that were searched.
//
// No hit is lost to rounding (packed_ray says what it may do). Tiles are filled for half of TILE_MARGIN of what places may be off by.
// Where it would be more, within a cube round the eye, the image of a ray is noise: there every triangle is tested that may come so near.
// Boxes are widened by what places are off by and by what the ray's own planes lose. Faces overlap by TILE_MARGIN.

#import tracebench::types::{Ray, Hit, miss, STATUS_UNWRITTEN, STATUS_HIT, STATUS_MISS, STATUS_STEP_CAP}
#import tracebench::dispatch::{Invocation, linear_invocation}
#ifdef TREES
#import tracebench::lanes::{WORKGROUP_SIZE, Block, open, block_of, take_ray, answer_again}
#else
#import tracebench::lanes::{WORKGROUP_SIZE, BLOCK_LANES, Turns, open, turns_of, answer_again}
#endif
#import tracebench::dirt_packed_ray::{search, best, found, capped, Work, work}
#import tracebench::dirt_packed_legs::{passes_eye, centre, is_far, skipped, begun_anew, begin_lane, begin_ray, has_face, next_leg}
#import tracebench::dirt_packed_near::search_near
#ifdef TREES
#import tracebench::dirt_tree_walk::{is_busy, begin_walk, begin_no_walk, go_on}
#else
#import tracebench::dirt_list_walk::walk
#endif

@group(0) @binding(7) var<storage, read> rays: array<Ray>;
@group(0) @binding(8) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
@group(0) @binding(9) var<storage, read_write> counts: array<Work>;
#else
// How many workgroups, along each axis, answer what the first search leaves.
@group(0) @binding(11) var<storage, read_write> left: array<atomic<u32>, 3>;
#endif

// The answer of a search.
fn answer() -> Hit {
    if (capped) {
        return miss(STATUS_STEP_CAP);
    }
    if (found) {
        return Hit(best.t + skipped, best.primitive, best.u, best.v, STATUS_HIT);
    }
    return miss(STATUS_MISS);
}

// Along an axis.
const MAX_WORKGROUPS: u32 = 65535u;

fn note(index: u32, hit: Hit) {
    hits[index] = hit;
#ifdef COUNTERS
    counts[index] = work;
#endif
}

#ifdef TREES
// Rounds after which lanes that have done with a leg get the next one.
const ROUNDS: u32 = 4u;

fn search_faces() {
    open += 1u;
    loop {
        if (!is_busy() && has_face()) {
            begin_walk(next_leg());
        }
        go_on();
        let goes_on = is_busy() || has_face();
        open -= select(1u, 0u, goes_on);
        continuing {
            break if !goes_on;
        }
    }
}

// Answers rays of a block, one after the other. Left without an answer are those for which what lies near the eye is to be searched, or
// that begin anew: few are, and drivers may run every branch for all; and those that are cut off, with all that no lane has taken then.
fn answer_block(block: Block, local: u32) {
    var index = take_ray(block, local);
    if (index >= block.end) {
        return;
    }
    begin_lane();
    begin_ray(rays[index]);
    var is_left = passes_eye || is_far;
    var leaves_some = false;
    begin_no_walk();
    open += 1u;
    loop {
        if (!is_busy() && (is_left || !has_face())) {
            if (!is_left) {
                note(index, answer());
            }
            leaves_some = leaves_some || is_left;
            index = take_ray(block, local);
            if (index < block.end) {
                begin_ray(rays[index]);
                is_left = passes_eye || is_far;
            }
        }
        if (index < block.end && !is_busy() && !is_left && has_face()) {
            begin_walk(next_leg());
        }
        var round = 0u;
        loop {
            go_on();
            round += 1u;
            continuing {
                break if round == ROUNDS || !is_busy();
            }
        }
        open -= select(0u, 1u, index >= block.end);
        continuing {
            break if index >= block.end;
        }
    }
    if (leaves_some || open > 0u) {
        tell_left();
    }
}
#else
// Loops end where their last rounds do, not before another one: drivers may run that for nobody.
fn search_faces() {
    var more = has_face();
    open += 1u;
    loop {
        if (more) {
            walk(next_leg());
        }
        more = has_face();
        open -= select(1u, 0u, more);
        continuing {
            break if !more;
        }
    }
}

// Answers the rays of a lane, one after the other. Left without an answer are those for which what lies near the eye is to be searched, or
// that begin anew: few are, and drivers may run every branch for all; and those that are cut off, with all behind them.
fn answer_turns(turns: Turns) {
    var index = turns.ray;
    if (index >= turns.end) {
        return;
    }
    var leaves_some = false;
    begin_lane();
    loop {
        begin_ray(rays[index]);
        if (!passes_eye && !is_far) {
            search_faces();
            if (open == 0u) {
                note(index, answer());
            }
        } else {
            leaves_some = true;
        }
        index += BLOCK_LANES;
        continuing {
            break if index >= turns.end || open > 0u;
        }
    }
    if (leaves_some || open > 0u) {
        tell_left();
    }
}

#endif

// Tells that rays were left.
fn tell_left() {
#ifndef COUNTERS
    let workgroups = (search.ray_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    atomicMax(&left[0], min(workgroups, MAX_WORKGROUPS));
    atomicMax(&left[1], (workgroups + MAX_WORKGROUPS - 1u) / MAX_WORKGROUPS);
    atomicMax(&left[2], 1u);
#endif
}

// Of `trace_unanswered`: a ray is given up where loops are cut off.
override fn tracebench::lanes::answer_ray(index: u32) {
    begin_lane();
    begin_ray(begun_anew(rays[index]));
    if (passes_eye) {
        search_near(centre);
    }
    search_faces();
    if (open > 0u) {
        note(index, miss(STATUS_STEP_CAP));
    } else {
        note(index, answer());
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
#ifdef TREES
    answer_block(block_of(invocation, 0u, search.ray_count, search.rays_per_lane), invocation.local);
#else
    answer_turns(turns_of(invocation, 0u, search.ray_count, search.rays_per_lane));
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace_unanswered(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    answer_again(index, search.ray_count, index < search.ray_count && hits[index].status == STATUS_UNWRITTEN);
}
