#define_import_path tracebench::bvh_build

// What the kernels share that build and fit hierarchies on the device.

struct BuildSettings {
    // Least corner of the scene, units of the hierarchy.
    low: vec3<f32>,
    triangle_count: u32,
    // Cells of the Morton grid per unit; 0 along an axis without extent.
    cells_per_unit: vec3<f32>,
    // From scene units to those of the hierarchy, a power of two.
    scale: f32,
}

// As in binary.wgsl. While clusters are merged, `count` of one that is no leaf tells what is below it.
struct BinaryNode {
    low: vec3<f32>,
    // The first of two siblings, or the leaf's slot.
    first: u32,
    high: vec3<f32>,
    count: u32,
}

struct Box {
    low: vec3<f32>,
    high: vec3<f32>,
}

fn both(a: Box, b: Box) -> Box {
    return Box(min(a.low, b.low), max(a.high, b.high));
}

// As in cwbvh.wgsl.
struct WideNode {
    origin: vec3<f32>,
    exponents_and_nodes: u32,
    // Until the node is converted: the first of its two binary nodes.
    first_child: u32,
    first_triangle: u32,
    children: vec2<u32>,
    x: vec4<u32>,
    y: vec4<u32>,
    z: vec4<u32>,
}

// Words of the buffer that tells how far a build is: the clusters at the start of every iteration from word 0 on, those at
// the start of every iteration of the last clusters, the slots given to the leaves of compressed nodes, whether
// many triangles coincide, the compressed nodes of every level.
const FINISHED: u32 = 128u;
const TAKEN_SLOTS: u32 = 256u;
const CROWDED: u32 = 257u;
const LEVELS: u32 = 258u;

// A bit of `count` of nodes that are no leaves.
const INNER_BIT: u32 = 0x80000000u;
// Triangles below are told up to this number.
const MANY: u32 = 255u;

fn is_inner(count: u32) -> bool {
    return count >= INNER_BIT;
}

fn triangles_below(count: u32) -> u32 {
    return count & 0xffu;
}

// Levels of binary nodes below a node.
fn height(count: u32) -> u32 {
    return (count >> 8u) & 0xffu;
}

fn inner_of(height: u32, triangles: u32) -> u32 {
    return INNER_BIT | (height << 8u) | min(triangles, MANY);
}

fn parent_of(a: u32, b: u32) -> u32 {
    return inner_of(max(height(a), height(b)) + 1u, triangles_below(a) + triangles_below(b));
}

fn half_area(low: vec3<f32>, high: vec3<f32>) -> f32 {
    let edges = high - low;
    return edges.x * edges.y + edges.y * edges.z + edges.z * edges.x;
}

// The grid of a compressed node (Ylitie, Karras, Laine 2017, section 3.1): steps are powers of two.
struct Grid {
    origin: vec3<f32>,
    step: vec3<f32>,
    inverse_step: vec3<f32>,
    exponents: vec3<u32>,
}

const STEPS: f32 = 255.0;
// Of a node; its step is a normal number then.
const MIN_EXTENT: f32 = 1e-20;

fn grid_of(low: vec3<f32>, high: vec3<f32>) -> Grid {
    let wanted = max(high - low, vec3<f32>(MIN_EXTENT)) / STEPS;
    // The exponent of the least power of two that is no less.
    var exponents = (bitcast<vec3<u32>>(wanted) + vec3<u32>(0x007fffffu)) >> vec3<u32>(23u);
    // The division was rounded: a step too small would cut the box.
    let step = bitcast<vec3<f32>>(exponents << vec3<u32>(23u));
    exponents += select(vec3<u32>(0u), vec3<u32>(1u), (low + step * STEPS < high));
    return Grid(
        low,
        bitcast<vec3<f32>>(exponents << vec3<u32>(23u)),
        bitcast<vec3<f32>>((vec3<u32>(254u) - exponents) << vec3<u32>(23u)),
        exponents,
    );
}

// A byte in the word of a slot, of four slots a word.
fn byte_at(slot: u32, value: u32) -> vec2<u32> {
    let byte = value << ((slot & 3u) * 8u);
    return select(vec2<u32>(0u, byte), vec2<u32>(byte, 0u), (slot < 4u));
}

// Enters a child's box, rounded outward, into a slot whose planes are 0.
fn enter_box(node: ptr<function, WideNode>, grid: Grid, slot: u32, low: vec3<f32>, high: vec3<f32>) {
    var least = floor((low - grid.origin) * grid.inverse_step);
    least -= select(vec3<f32>(0.0), vec3<f32>(1.0), (grid.origin + least * grid.step > low));
    var greatest = ceil((high - grid.origin) * grid.inverse_step);
    greatest += select(vec3<f32>(0.0), vec3<f32>(1.0), (grid.origin + greatest * grid.step < high));
    let planes_low = vec3<u32>(clamp(least, vec3<f32>(0.0), vec3<f32>(STEPS)));
    let planes_high = vec3<u32>(clamp(greatest, vec3<f32>(0.0), vec3<f32>(STEPS)));
    (*node).x |= vec4<u32>(byte_at(slot, planes_low.x), byte_at(slot, planes_high.x));
    (*node).y |= vec4<u32>(byte_at(slot, planes_low.y), byte_at(slot, planes_high.y));
    (*node).z |= vec4<u32>(byte_at(slot, planes_low.z), byte_at(slot, planes_high.z));
}
