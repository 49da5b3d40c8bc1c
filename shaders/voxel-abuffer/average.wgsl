// What searches read of the grid: of every voxel whether it has anything, and which image its average normal chooses (section 3.2).
// Eight voxels a word, an invocation a word.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::unit_space::dominant_axis

struct AveragedGrid {
    voxels: u32,
    // Shorter averages say nothing: opposite normals have cancelled.
    min_length: f32,
    // More fragments than sums in 32 bits are sure to hold.
    max_fragments: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> averaged: AveragedGrid;
@group(0) @binding(1) var<storage, read> sums_x: array<i32>;
@group(0) @binding(2) var<storage, read> sums_y: array<i32>;
@group(0) @binding(3) var<storage, read> sums_z: array<i32>;
@group(0) @binding(4) var<storage, read> fragments: array<u32>;
@group(0) @binding(5) var<storage, read_write> codes: array<u32>;
@group(0) @binding(6) var<storage, read_write> taken: array<atomic<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

// As in fill.wgsl.
const NORMAL_UNIT: f32 = 256.0;
const ANY_FRAGMENT: u32 = 0x80000000u;

// As in store.wgsl.
const CANCELLED: u32 = 4u;

// Of `taken`: voxels with more fragments than their sums hold.
const CROWDED: u32 = 5u;

fn code_of(voxel: u32) -> u32 {
    let word = fragments[voxel];
    if (word == 0u) {
        return 0u;
    }
    let count = word & ~ANY_FRAGMENT;
    if (count > averaged.max_fragments) {
        atomicAdd(&taken[CROWDED], 1u);
    }
    let sum = vec3<f32>(vec3<i32>(sums_x[voxel], sums_y[voxel], sums_z[voxel])) / NORMAL_UNIT;
    if (count == 0u || !(length(sum) > averaged.min_length * f32(count))) {
        return CANCELLED;
    }
    return dominant_axis(sum) + 1u;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn average(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= (averaged.voxels + 7u) / 8u) {
        return;
    }
    var word = 0u;
    for (var place = 0u; place < 8u; place++) {
        let voxel = index * 8u + place;
        if (voxel < averaged.voxels) {
            word |= code_of(voxel) << (place * 4u);
        }
    }
    codes[index] = word;
}
