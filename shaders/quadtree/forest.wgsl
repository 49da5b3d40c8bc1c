#define_import_path tracebench::quadtree_forest

// The quad-trees of all depth layers of all views, and the unit cube that they stand in (WKP15, sections 3.1 to 3.4).
//
// An image is a layer of a view; all are of one size, and those of a view follow each other. An image has the nodes of all levels
// one level after the other, the pixels' own being level 0; a node of a level stands for the four below it, as many of them as
// there are. At the top level there is a grid of roots.
//
// In the unit cube x and y are shares of the image's width and height. z is reversed: 1 at the near plane, 0 at the far one, so that
// f32 keeps as much of it everywhere. Planes, rays, angles and distances are those of the cube that is not reversed. A walk counts
// x and y in pixels.

#import tracebench::pyramid::index_in_level

struct Forest {
    // Pixels of an image.
    size: vec2<u32>,
    // Level of the roots.
    top: u32,
    // Layers of a view.
    layers: u32,
    // Images, and nodes of one.
    image_count: u32,
    image_nodes: u32,
    // z = z_scale / eye depth - z_shift.
    z_scale: f32,
    z_shift: f32,
    // Height of a pixel at eye depth 1.
    pixel_angle: f32,
    // How far planes reach beyond their nodes, pixels, and which do.
    dilation: f32,
    dilated: u32,
    // From what difference on neighbours lie on different surfaces, pixel heights at their depth.
    discontinuity: f32,
    // Most angle of a child's normal with the proxy's as the length of the difference between both, and most distance of its corners
    // from the proxy plane: in the cube, or in pixel heights at their depth.
    gamma_norm: f32,
    gamma_dist: f32,
    gamma_in_pixels: u32,
    // What both thresholds grow by from depth 0 to far, as a multiple of themselves; 0 for fixed ones.
    growth: f32,
    // 1: normals are the triangles', 0: those of the depths round a pixel.
    normals_of_geometry: u32,
    inverse_far: f32,
    // 1: pixels' planes end at those beside them.
    is_joined: u32,
    padding: u32,
    // First node of each level in an image, four a vector.
    level_offsets: array<vec4<u32>, 4>,
}

// The codes of `dilated`.
const DILATE_NONE: u32 = 0u;
const DILATE_CONTINUOUS: u32 = 1u;
const DILATE_FLAGGED: u32 = 2u;
const DILATE_ALL: u32 = 3u;

fn z_of_depth(forest: Forest, depth: f32) -> f32 {
    return clamp(forest.z_scale / depth - forest.z_shift, 0.0, 1.0);
}

fn depth_of_z(forest: Forest, z: f32) -> f32 {
    return forest.z_scale / (z + forest.z_shift);
}

// By how much z changes over so many pixel heights of eye depth.
fn z_of_pixels(forest: Forest, z: f32, pixels: f32) -> f32 {
    return (max(z, 0.0) + forest.z_shift) * pixels * forest.pixel_angle;
}

// A node's number among all.
fn node_index(forest: Forest, image: u32, level: u32, cell: vec2<u32>) -> u32 {
    let offset = forest.level_offsets[level >> 2u][level & 3u];
    return image * forest.image_nodes + offset + index_in_level(forest.size, level, cell);
}

// How many levels lie between a cell and the child of the last ancestor that it has in common with another cell of its level, which
// holds it: the highest bit in which their places differ (section 4). 0 for siblings.
fn levels_apart(cell: vec2<u32>, other: vec2<u32>) -> u32 {
    return firstLeadingBit((cell.x ^ other.x) | (cell.y ^ other.y));
}
