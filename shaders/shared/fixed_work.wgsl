// The same arithmetic every time, whatever the scene: how long it takes tells how fast the device runs. Hashes of PCG (O'Neill 2014),
// each of the last, so that nothing can be left out.

#import tracebench::dispatch::{Invocation, linear_invocation}

// Invocations that work.
@group(0) @binding(0) var<uniform> tasks: u32;
// What they come to, so that the work is needed.
@group(0) @binding(1) var<storage, read_write> results: array<atomic<u32>, RESULTS>;

const LANES: u32 = 64u;
const RESULTS: u32 = 64u;
// Steps of a task: far fewer than the rounds after which Mesa's software driver ends a loop.
const STEPS: u32 = 1024u;

@compute @workgroup_size(LANES)
fn work(invocation: Invocation) {
    let task = linear_invocation(invocation, LANES);
    if task >= tasks {
        return;
    }
    var state = task;
    for (var step = 0u; step < STEPS; step++) {
        state = state * 747796405u + 2891336453u;
        let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        state = (word >> 22u) ^ word;
    }
    atomicXor(&results[task % RESULTS], state);
}
