// Exclusive prefix sums by reduce-then-scan (Dotsenko et al., "Fast Scan Algorithms on Graphics Processors", ICS 2008): the
// sums of blocks, their prefix sums by the same two kernels, then the blocks' elements. Lanes take runs of neighbours, so
// that a block needs few barriers.

#import tracebench::dispatch::{Invocation, linear_workgroup}

// Elements.
@group(0) @binding(0) var<uniform> count: u32;
@group(0) @binding(1) var<storage, read_write> values: array<u32>;
// Of every block: its sum (written by `reduce`), then the sum of all blocks before it (read by `scan`).
@group(0) @binding(2) var<storage, read_write> blocks: array<u32>;

const LANES: u32 = 256u;
// Elements of a lane.
const RUN: u32 = 16u;
// Lanes whose sums one lane adds up.
const GROUP: u32 = 16u;

var<workgroup> lane_sums: array<u32, LANES>;
var<workgroup> group_sums: array<u32, LANES / GROUP>;

fn run_of(block: u32, local: u32) -> vec2<u32> {
    let first = (block * LANES + local) * RUN;
    return vec2<u32>(min(first, count), min(first + RUN, count));
}

fn sum_of(run: vec2<u32>) -> u32 {
    var sum = 0u;
    for (var index = run.x; index < run.y; index++) {
        sum += values[index];
    }
    return sum;
}

// Leaves in lane_sums what lies before each lane in its group, and in group_sums the groups' sums.
fn scan_groups(local: u32, own: u32) {
    lane_sums[local] = own;
    workgroupBarrier();
    if (local < LANES / GROUP) {
        var sum = 0u;
        for (var lane = local * GROUP; lane < (local + 1u) * GROUP; lane++) {
            let next = sum + lane_sums[lane];
            lane_sums[lane] = sum;
            sum = next;
        }
        group_sums[local] = sum;
    }
    workgroupBarrier();
}

fn groups_before(group: u32) -> u32 {
    var sum = 0u;
    for (var before = 0u; before < group; before++) {
        sum += group_sums[before];
    }
    return sum;
}

@compute @workgroup_size(LANES)
fn reduce(invocation: Invocation) {
    let block = linear_workgroup(invocation);
    scan_groups(invocation.local, sum_of(run_of(block, invocation.local)));
    // A folded dispatch may have more workgroups than there are blocks.
    if (invocation.local == 0u && block < arrayLength(&blocks)) {
        blocks[block] = groups_before(LANES / GROUP);
    }
}

@compute @workgroup_size(LANES)
fn scan(invocation: Invocation) {
    let block = linear_workgroup(invocation);
    let run = run_of(block, invocation.local);
    scan_groups(invocation.local, sum_of(run));
    var sum = groups_before(invocation.local / GROUP) + lane_sums[invocation.local];
    if (run.x < run.y) {
        sum += blocks[block];
    }
    for (var index = run.x; index < run.y; index++) {
        let next = sum + values[index];
        values[index] = sum;
        sum = next;
    }
}
