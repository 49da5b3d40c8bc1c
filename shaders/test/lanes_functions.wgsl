// Rays that lanes take, so that a test can count how often each one is taken.

#import tracebench::dispatch::Invocation
#import tracebench::lanes::{WORKGROUP_SIZE, BLOCK_LANES, turns_of, block_of, take_ray}

// The first ray, how many there are, and rays a lane.
@group(0) @binding(0) var<storage, read> asked: array<u32, 3>;
// How often each ray was taken.
@group(0) @binding(1) var<storage, read_write> times: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn take_turns(invocation: Invocation) {
    var turns = turns_of(invocation, asked[0], asked[1], asked[2]);
    while (turns.ray < turns.end) {
        atomicAdd(&times[turns.ray], 1u);
        turns.ray += BLOCK_LANES;
    }
}

// Lanes are done with their rays after different rounds.
@compute @workgroup_size(WORKGROUP_SIZE)
fn take_from_blocks(invocation: Invocation) {
    let block = block_of(invocation, asked[0], asked[1], asked[2]);
    var ray = take_ray(block, invocation.local);
    var rounds = 0u;
    while (ray < block.end) {
        if (rounds == ray * 7u % 5u) {
            atomicAdd(&times[ray], 1u);
            ray = take_ray(block, invocation.local);
            rounds = 0u;
        } else {
            rounds += 1u;
        }
    }
}
