// One pass of a stable radix sort, least digit first (Satish, Harris, Garland, "Designing Efficient Sorting Algorithms for
// Manycore GPUs", IPDPS 2009): `count` tells how often every block holds every digit, prefix sums over that table (digits
// first, then blocks) tell where each block puts each digit, and `scatter` puts it there. A lane ranks a run of
// neighbours with counters of its own in workgroup memory, so neither atomics nor subgroups decide the order.

#import tracebench::dispatch::{Invocation, linear_workgroup}

struct SortPass {
    // Keys.
    count: u32,
    blocks: u32,
    // The digit's lowest bit.
    shift: u32,
}

// `count` takes bindings 0 to 2.
@group(0) @binding(0) var<uniform> settings: SortPass;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
// A row a digit, a column a block.
@group(0) @binding(2) var<storage, read_write> table: array<u32>;
@group(0) @binding(3) var<storage, read> payloads: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_payloads: array<u32>;

const LANES: u32 = 32u;
// Keys of a lane.
const RUN: u32 = 128u;
const BLOCK: u32 = LANES * RUN;
const DIGIT_BITS: u32 = 8u;
const DIGITS: u32 = 1u << DIGIT_BITS;
// Two digits of a lane share a word, and a row has a word too many so that lanes that walk down rows take different banks.
const ROW: u32 = LANES + 1u;

fn digit_of(key: u32) -> u32 {
    return (key >> settings.shift) & (DIGITS - 1u);
}

var<workgroup> tally: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(LANES)
fn count(invocation: Invocation) {
    let block = linear_workgroup(invocation);
    for (var digit = invocation.local; digit < DIGITS; digit += LANES) {
        atomicStore(&tally[digit], 0u);
    }
    workgroupBarrier();
    for (var place = 0u; place < RUN; place++) {
        let index = block * BLOCK + place * LANES + invocation.local;
        if (index < settings.count) {
            atomicAdd(&tally[digit_of(keys[index])], 1u);
        }
    }
    workgroupBarrier();
    // A folded dispatch may have more workgroups than there are blocks.
    if (block < settings.blocks) {
        for (var digit = invocation.local; digit < DIGITS; digit += LANES) {
            table[digit * settings.blocks + block] = atomicLoad(&tally[digit]);
        }
    }
}

// Words of two digits in a row, a column a lane.
var<workgroup> counters: array<u32, DIGITS / 2u * ROW>;

@compute @workgroup_size(LANES)
fn scatter(invocation: Invocation) {
    let block = linear_workgroup(invocation);
    for (var row = 0u; row < DIGITS / 2u; row++) {
        counters[row * ROW + invocation.local] = 0u;
    }
    let first = block * BLOCK + invocation.local * RUN;
    let end = min(first + RUN, settings.count);
    for (var index = first; index < end; index++) {
        let digit = digit_of(keys[index]);
        counters[(digit >> 1u) * ROW + invocation.local] += 1u << ((digit & 1u) * 16u);
    }
    workgroupBarrier();
    // Both halves at once: no half exceeds the block's 4,096 keys.
    for (var row = invocation.local; row < DIGITS / 2u; row += LANES) {
        var sum = 0u;
        for (var lane = 0u; lane < LANES; lane++) {
            let next = sum + counters[row * ROW + lane];
            counters[row * ROW + lane] = sum;
            sum = next;
        }
    }
    workgroupBarrier();
    for (var index = first; index < end; index++) {
        let key = keys[index];
        let digit = digit_of(key);
        let half = (digit & 1u) * 16u;
        let word = (digit >> 1u) * ROW + invocation.local;
        let rank = counters[word];
        counters[word] = rank + (1u << half);
        let place = table[digit * settings.blocks + block] + ((rank >> half) & 0xffffu);
        sorted_keys[place] = key;
        sorted_payloads[place] = payloads[index];
    }
}
