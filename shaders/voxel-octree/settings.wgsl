#define_import_path tracebench::octree_settings

// What the stages of a build are told, and what they count.

#import tracebench::unit_space::UnitSpace

struct OctreeBuild {
    space: UnitSpace,
    triangle_count: u32,
    // Of the tree; the grid has two to the power of it voxels along an edge.
    levels: u32,
    // What there is room for.
    row_capacity: u32,
    fragment_capacity: u32,
    leaf_capacity: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

const WORKGROUP_SIZE: u32 = 64u;

// Words of what is counted: rows and fragments in 64 bits, the low word first; triangles with coordinates that are no numbers; and from
// OPENED on, how many voxels differ from the one before them along the curve from that level on, of which the first voxel differs whole.
const ROWS: u32 = 0u;
const FRAGMENTS: u32 = 2u;
const BROKEN: u32 = 4u;
const OPENED: u32 = 5u;

// The most levels: three bits each in a key of 30.
const MAX_DEPTH: u32 = 10u;

// The key of no voxel, behind those of all.
fn no_voxel(levels: u32) -> u32 {
    return 1u << (3u * levels);
}
