// Normals in a word and keys of voxels, so that a test can compare the octree's functions with f64 and the host's.

#import tracebench::octree_normal::{packed_normal, unpacked_normal}
#import tracebench::octree_morton::{morton_key, part_of}

@group(0) @binding(0) var<storage, read> normals: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> voxels: array<vec4<u32>>;
// The normal's word, bits of its three components unpacked.
@group(0) @binding(2) var<storage, read_write> packed: array<vec4<u32>>;
// The key, and the parts at the levels of 1, 2 and 512 voxels.
@group(0) @binding(3) var<storage, read_write> keys: array<vec4<u32>>;

@compute @workgroup_size(64)
fn pack_normals(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&normals)) {
        return;
    }
    let word = packed_normal(normals[id.x].xyz);
    packed[id.x] = vec4<u32>(word, bitcast<vec3<u32>>(unpacked_normal(word)));
}

@compute @workgroup_size(64)
fn place_voxels(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&voxels)) {
        return;
    }
    let voxel = voxels[id.x].xyz;
    let at = vec3<i32>(voxel);
    keys[id.x] = vec4<u32>(morton_key(voxel), part_of(at, 0u), part_of(at, 1u), part_of(at, 9u));
}
