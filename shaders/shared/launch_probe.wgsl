// What tells how searches should read and be launched: kernels that do of a search what differs between drivers, and nothing
// else.

#import tracebench::dispatch::Invocation
#import tracebench::lanes::{WORKGROUP_SIZE, turns_of, block_of, take_ray}
#import tracebench::reads::quad_0

struct ProbeSettings {
    // Of `gather` lanes, of `search` rays.
    count: u32,
    rays_per_lane: u32,
    // Records less 1: there are two to some power.
    last_record: u32,
    // Reads of a lane of `gather`.
    reads: u32,
}

@group(0) @binding(0) var<uniform> settings: ProbeSettings;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;

// Unrelated numbers (PCG hash).
fn scatter(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Reads one after the other, each where the one before says.
@compute @workgroup_size(WORKGROUP_SIZE)
fn gather(invocation: Invocation) {
    let turns = turns_of(invocation, 0u, settings.count, 1u);
    if (turns.ray >= turns.end) {
        return;
    }
    var at = scatter(turns.ray);
    for (var read = 0u; read < settings.reads; read++) {
        let record = quad_0(at & settings.last_record);
        at = (at >> 7u) ^ record.x ^ (record.y + record.z) ^ record.w;
    }
    results[turns.ray] = at;
}

// Rounds of a ray's search: most are short and some are sixteen times as long.
fn rounds_of(ray: u32) -> u32 {
    return 8u << (scatter(ray) % 5u);
}

// Rounds after which a lane that has done with its ray gets the next one, as in searches of hierarchies.
const ROUNDS: u32 = 4u;

// Searches of different length, each a loop over rounds of a read, which says where the next one is, and some arithmetic. Where lanes wait
// for reads, a device with many cores needs many lanes.
@compute @workgroup_size(WORKGROUP_SIZE)
fn search(invocation: Invocation) {
    let block = block_of(invocation, 0u, settings.count, settings.rays_per_lane);
    var ray = take_ray(block, invocation.local);
    if (ray >= block.end) {
        return;
    }
    var left = rounds_of(ray);
    var at = scatter(ray);
    var point = vec4<f32>(f32(ray & 1023u) * 1e-3);
    loop {
        var busy = true;
        var round = 0u;
        loop {
            if (left > 0u) {
                let record = quad_0(at & settings.last_record);
                at = (at >> 7u) ^ record.x ^ (record.y + record.z) ^ record.w;
                for (var step = 0u; step < 4u; step++) {
                    point = point.yzwx * point * 0.75 + vec4<f32>(0.25, 0.125, 0.0625, 0.5);
                }
                left -= 1u;
            }
            busy = left > 0u;
            round += 1u;
            continuing {
                break if !busy || round == ROUNDS;
            }
        }
        if (!busy) {
            results[ray] = bitcast<u32>(point.x + point.y + f32(at & 1023u));
            ray = take_ray(block, invocation.local);
            if (ray >= block.end) {
                break;
            }
            left = rounds_of(ray);
            at = scatter(ray);
            point = vec4<f32>(f32(ray & 1023u) * 1e-3);
        }
    }
}
