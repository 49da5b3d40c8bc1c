// Sorted fragments to leaves: those of one key are one voxel, with the average of its triangles' normals and the material of the lowest
// of them. Sums are integers, so that nothing hangs on the order of atomics.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::surface::{max_of, unit_normal}
#import tracebench::octree_normal::packed_normal
#import tracebench::octree_settings::{OctreeBuild, WORKGROUP_SIZE, OPENED, MAX_DEPTH, no_voxel}

@group(0) @binding(0) var<uniform> build: OctreeBuild;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
@group(0) @binding(3) var<storage, read> materials: array<u32>;
@group(0) @binding(4) var<storage, read> keys: array<u32>;
@group(0) @binding(5) var<storage, read> primitives: array<u32>;
// 1 for the first fragment of every voxel, and then how many there are before each.
@group(0) @binding(6) var<storage, read_write> ranks: array<u32>;
@group(0) @binding(7) var<storage, read_write> taken: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> leaf_keys: array<u32>;
// The first fragment of every leaf, and behind the last leaf the end of all.
@group(0) @binding(9) var<storage, read_write> leaf_firsts: array<u32>;
// Two words a leaf: sums of its triangles' normals along x and y, and then the normal and the material.
@group(0) @binding(10) var<storage, read_write> leaves: array<atomic<u32>>;
// And along z.
@group(0) @binding(11) var<storage, read_write> sums_z: array<atomic<u32>>;

fn is_fragment(place: u32) -> bool {
    return place < build.fragment_capacity && keys[place] != no_voxel(build.levels);
}

fn is_first(place: u32) -> bool {
    return is_fragment(place) && (place == 0u || keys[place] != keys[place - 1u]);
}

var<workgroup> tally: array<atomic<u32>, MAX_DEPTH>;

// Marks the first fragment of every voxel, and counts from which level on it lies in nodes of its own.
@compute @workgroup_size(WORKGROUP_SIZE)
fn mark(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (invocation.local < MAX_DEPTH) {
        atomicStore(&tally[invocation.local], 0u);
    }
    workgroupBarrier();
    let first = is_first(place);
    if (place <= build.fragment_capacity) {
        ranks[place] = select(0u, 1u, first);
    }
    if (first) {
        var level = 0u;
        if (place > 0u) {
            level = build.levels - 1u - firstLeadingBit(keys[place] ^ keys[place - 1u]) / 3u;
        }
        atomicAdd(&tally[level], 1u);
    }
    workgroupBarrier();
    if (invocation.local < MAX_DEPTH) {
        let count = atomicLoad(&tally[invocation.local]);
        if (count > 0u) {
            atomicAdd(&taken[OPENED + invocation.local], count);
        }
    }
}

// Where every leaf's fragments begin.
@compute @workgroup_size(WORKGROUP_SIZE)
fn gather(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (place > build.fragment_capacity) {
        return;
    }
    let leaf = ranks[place];
    let ends = !is_fragment(place) && (place == 0u || is_fragment(place - 1u));
    if (leaf <= build.leaf_capacity && (ends || is_first(place))) {
        leaf_firsts[leaf] = place;
    }
    if (leaf < build.leaf_capacity && is_first(place)) {
        leaf_keys[leaf] = keys[place];
    }
}

fn load_position(corner: u32) -> vec3<f32> {
    let vertex = indices[corner] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}

fn normal_of(triangle: u32) -> vec3<f32> {
    let a = load_position(triangle * 3u);
    return unit_normal(load_position(triangle * 3u + 1u) - a, load_position(triangle * 3u + 2u) - a);
}

// How much a normal of length 1 adds to the sums of so many: 24 bits, and fewer where the sums would not hold that.
fn unit_of(count: u32) -> f32 {
    let bits = i32(firstLeadingBit(count)) + 1;
    return f32(1u << u32(clamp(30 - bits, 0, 24)));
}

// Every fragment's normal, to its leaf's sums.
@compute @workgroup_size(WORKGROUP_SIZE)
fn sum(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (!is_fragment(place)) {
        return;
    }
    let leaf = ranks[place + 1u] - 1u;
    if (leaf >= build.leaf_capacity) {
        return;
    }
    let count = leaf_firsts[leaf + 1u] - leaf_firsts[leaf];
    if (count > 1u) {
        let added = vec3<i32>(round(normal_of(primitives[place]) * unit_of(count)));
        atomicAdd(&leaves[leaf * 2u], u32(added.x));
        atomicAdd(&leaves[leaf * 2u + 1u], u32(added.y));
        atomicAdd(&sums_z[leaf], u32(added.z));
    }
}

// As `MIN_LENGTH` in tracers/voxel-octree/src/reference.rs: shorter averages say nothing, as opposite normals have cancelled.
const MIN_LENGTH: f32 = 0.0625;

// Every leaf's normal and material.
@compute @workgroup_size(WORKGROUP_SIZE)
fn finish(invocation: Invocation) {
    let leaf = linear_invocation(invocation, WORKGROUP_SIZE);
    if (leaf >= min(ranks[build.fragment_capacity], build.leaf_capacity)) {
        return;
    }
    let first = leaf_firsts[leaf];
    let count = leaf_firsts[leaf + 1u] - first;
    // The sort is stable: the first has the lowest triangle.
    let triangle = primitives[first];
    var normal = normal_of(triangle);
    if (count > 1u) {
        let sums = vec3<f32>(vec3<i32>(
            i32(atomicLoad(&leaves[leaf * 2u])),
            i32(atomicLoad(&leaves[leaf * 2u + 1u])),
            i32(atomicLoad(&sums_z[leaf])),
        ));
        let length = max_of(sums);
        if (length > MIN_LENGTH * f32(count) * unit_of(count)) {
            normal = normalize(sums / length);
        }
    }
    atomicStore(&leaves[leaf * 2u], packed_normal(normal));
    atomicStore(&leaves[leaf * 2u + 1u], materials[triangle]);
}
