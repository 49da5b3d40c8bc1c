#define_import_path tracebench::quadtree_node

// The nodes of the quad-trees: two words each (WKP15, section 3.4, Figure 3). The sign bit of the first word tells planes, 1, from
// boxes, 0. A plane has its z at the node's middle and two components of its normal in half precision; a box has least and greatest z.
// The paper adds the flag of discontinuity to z (P + O), which costs z bits. No z exceeds 1, so that bit 30 of such a float is always
// 0: here the flag stands in that bit of the first word. In the same place of a box's second word its sign bit says that pixels in it
// show nothing. No component of a normal exceeds 1, so that bit 14 of such a half is always 0: both and the flag's bit are the mark of a
// plane, 0, 1 where it is flagged, or FIRST_END and the number of the side across which a flagged pixel's plane ends at the neighbour's.

const PLANE_BIT: u32 = 0x80000000u;
const FLAG_BIT: u32 = 0x40000000u;
const HOLES_BIT: u32 = 0x80000000u;
const FLOAT_BITS: u32 = 0x3fffffffu;
const NORMAL_BITS: u32 = 0xbfffbfffu;
const FIRST_END: u32 = 2u;
const SIDES: u32 = 4u;

// Steeper planes than so many cube heights a cube width have no normal that half precision tells from one along the image.
const STEEPEST: f32 = 30.0;

// A plane over a node: z at the node's middle, and z a pixel.
struct Plane {
    z: f32,
    slope: vec2<f32>,
    // Whether it lies near a discontinuity of depth.
    flagged: bool,
}

// Least and greatest z; least > greatest for none.
struct Box {
    least: f32,
    greatest: f32,
    // Whether there are pixels in it that show nothing.
    holes: bool,
}

// Of a pixel that shows nothing, and of nodes over such pixels alone.
const NOTHING: vec2<u32> = vec2<u32>(0x3f800000u, 0x80000000u);

fn is_plane(words: vec2<u32>) -> bool {
    return (words.x & PLANE_BIT) != 0u;
}

// Whether there is nothing in it.
fn is_empty(words: vec2<u32>) -> bool {
    return words.x == NOTHING.x && words.y == NOTHING.y;
}

// The normal of a plane with slopes, z over the cube's x and y: of unit length, towards greater z.
fn normal_of_slope(slope: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(-slope, 1.0) / sqrt(1.0 + dot(slope, slope));
}

// Two components as they are stored, and the whole normal of what is stored (section 3.4).
fn normal_words(normal: vec3<f32>) -> u32 {
    return pack2x16float(normal.xy);
}

fn normal_of_words(word: u32) -> vec3<f32> {
    let across = unpack2x16float(word & NORMAL_BITS);
    // What STEEPEST lets through leaves more than this.
    return vec3<f32>(across, sqrt(max(1.0 - dot(across, across), 5e-4)));
}

fn mark_of(words: vec2<u32>) -> u32 {
    return ((words.x >> 30u) & 1u) | ((words.y >> 13u) & 2u) | ((words.y >> 28u) & 4u);
}

// The side across which a plane ends at the neighbour's, SIDES for none, and a pixel's words with one.
fn end_of(words: vec2<u32>) -> u32 {
    let mark = mark_of(words);
    return select(SIDES, mark - FIRST_END, is_plane(words) && mark >= FIRST_END);
}

fn with_end(words: vec2<u32>, side: u32) -> vec2<u32> {
    let mark = FIRST_END + side;
    return vec2<u32>((words.x & ~FLAG_BIT) | ((mark & 1u) << 30u), words.y | ((mark & 2u) << 13u) | ((mark & 4u) << 28u));
}

fn slope_of_normal(normal: vec3<f32>) -> vec2<f32> {
    return -normal.xy / normal.z;
}

// Of an image of this size, in pixels.
fn plane_of(words: vec2<u32>, size: vec2<f32>) -> Plane {
    let slope = slope_of_normal(normal_of_words(words.y)) / size;
    return Plane(bitcast<f32>(words.x & FLOAT_BITS), slope, mark_of(words) != 0u);
}

// A plane whose z at its node's middle lies in [0, 1]. Its normal is given as stored.
fn plane_words(z: f32, normal: u32, flagged: bool) -> vec2<u32> {
    return vec2<u32>(PLANE_BIT | select(0u, FLAG_BIT, flagged) | bitcast<u32>(abs(z)), normal);
}

// What is stored of slopes, z over the cube's x and y.
fn slope_words(slope: vec2<f32>) -> u32 {
    let steepness = length(slope);
    return normal_words(normal_of_slope(slope * min(1.0, STEEPEST / max(steepness, 1e-30))));
}

fn box_of(words: vec2<u32>) -> Box {
    return Box(bitcast<f32>(words.x & FLOAT_BITS), bitcast<f32>(words.y & FLOAT_BITS), (words.y & HOLES_BIT) != 0u);
}

// z between 0 and 1.
fn box_words(box: Box) -> vec2<u32> {
    if (box.least > box.greatest) {
        return NOTHING;
    }
    // Of -0 the bits are those of a plane.
    return vec2<u32>(bitcast<u32>(abs(box.least)), select(0u, HOLES_BIT, box.holes) | bitcast<u32>(abs(box.greatest)));
}

// z of a plane so many pixels from its node's middle.
fn z_on(plane: Plane, from_middle: vec2<f32>) -> f32 {
    return plane.z + dot(plane.slope, from_middle);
}

// The z that a plane has within so many pixels of its node's middle along both axes, held in the cube.
fn range_of(plane: Plane, reach: f32) -> vec2<f32> {
    let spread = dot(abs(plane.slope), vec2<f32>(reach));
    return clamp(vec2<f32>(plane.z - spread, plane.z + spread), vec2<f32>(0.0), vec2<f32>(1.0));
}
