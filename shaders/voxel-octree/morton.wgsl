#define_import_path tracebench::octree_morton

// Places along the curve of Morton: of every level three bits, the coarsest first; of these x is the lowest.

// Ten bits, two apart.
fn spread(value: u32) -> u32 {
    var bits = value & 0x3ffu;
    bits = (bits | (bits << 16u)) & 0x030000ffu;
    bits = (bits | (bits << 8u)) & 0x0300f00fu;
    bits = (bits | (bits << 4u)) & 0x030c30c3u;
    return (bits | (bits << 2u)) & 0x09249249u;
}

fn morton_key(voxel: vec3<u32>) -> u32 {
    return spread(voxel.x) | (spread(voxel.y) << 1u) | (spread(voxel.z) << 2u);
}

// Which of a node's eight parts a voxel lies in, where the parts are two to the power of `shift` voxels wide.
fn part_of(voxel: vec3<i32>, shift: u32) -> u32 {
    let bits = (vec3<u32>(voxel) >> vec3<u32>(shift)) & vec3<u32>(1u);
    return bits.x | (bits.y << 1u) | (bits.z << 2u);
}
