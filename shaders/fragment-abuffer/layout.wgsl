#define_import_path tracebench::fragment_layout

// The layout of the fragment A-buffer: words of pixels, nodes of fragments, what shading needs of them.

#import tracebench::view::View
#import tracebench::pyramid::index_in_level

// Every pixel has words, in an image each: pointers into the nodes and, for some storages, depth bounds (section 3.3). Of the s-buffer word
// 0 is where its piece of the nodes begins and word 1 how many it has; of lists words 0 to B - 1 are heads and, where they are linked both
// ways, B to 2B - 1 tails. Node: eye depth; of the s-buffer the index of its data, of lists the next link and, where they are linked both
// ways, the previous one. A link is one more than a node's index, 0 the end.
//
// A fragment that is a plane has its least depth within the pixel for its depth, and words from `plane_word` on: the greatest depth, how
// far the plane lies from the eye along its normal, a mask of its outline where there is one, and the normal. Where nodes have the data,
// the data begins with that very normal.
struct Storage {
    // 1 where there are none.
    buckets: u32,
    // 1: linked both ways.
    double: u32,
    // Which word of a pixel the depth bounds begin at; 0 for none.
    bounds_word: u32,
    // From a node to the next, from a fragment's data to the next, and where data begins there.
    node_words: u32,
    data_words: u32,
    data_offset: u32,
    // Nodes that there is room for.
    node_capacity: u32,
    // 1: only the nearest fragment of a pixel is kept.
    one_layer: u32,
    // Pixels whose words these are: from a word of a pixel to its next.
    pixel_count: u32,
    // 1: pieces of the nodes, 0: lists.
    contiguous: u32,
    // Which word of a node the words of a plane begin at; 0 where fragments are points.
    plane_word: u32,
    // 1: what a triangle touches of a pixel is its fragment there, 0: what covers the pixel's centre alone has one.
    conservative: u32,
    // Which word of a node a plane's normal begins at; the one before it is the mask of its outline, if there is one.
    normal_word: u32,
}

// Parts of a pixel, across and down, that the mask of an outline has bits of, from the upper left one on, row by row.
const OUTLINE_PARTS: vec2<u32> = vec2<u32>(6u, 5u);
const WHOLE_OUTLINE: u32 = 0x3fffffffu;

fn has_outline(shape: Storage) -> bool {
    return shape.normal_word > shape.plane_word + 2u;
}

// Of a view that rays are traced through.
struct TracedView {
    view: View,
    // The view's first pixel, and its first node's bit among those that are counted.
    first_pixel: u32,
    first_node: u32,
    // Levels of the pyramid of depth bounds, the pixels themselves being the first; 1 without one.
    levels: u32,
    // 1: a cube face.
    is_face: u32,
    // Faces beyond the right, left, upper and lower side.
    beyond: vec4<u32>,
    // Pixels, from a word of a pixel to its next, and nodes that there is room for, in the view's buffer.
    pixel_count: u32,
    node_capacity: u32,
    padding: vec2<u32>,
    // Words before those of the view's buffers in textures that hold several: of pixels, of nodes, of data.
    begins: vec4<u32>,
    // First pair of depth bounds of each level from the second on, four a vector.
    level_offsets: array<vec4<u32>, 4>,
}

// Of a view that is drawn.
struct RasterizedView {
    view: View,
    // The view's first pixel, and the pixels of a row.
    first_pixel: u32,
    width: u32,
    padding: vec2<u32>,
}

fn word_index(shape: Storage, pixel: u32, word: u32) -> u32 {
    return word * shape.pixel_count + pixel;
}

// Of a level, whose first is at `offset`: read by who has the uniform, since a table that is given as a value is copied for every lane.
fn pyramid_index(view: View, offset: u32, level: u32, cell: vec2<u32>) -> u32 {
    return offset + index_in_level(vec2<u32>(view.size), level, cell);
}

// Depths of one fragment may differ by rounding between two passes, and from the bounds: what is skipped by bounds keeps this
// relative distance from them.
const BOUNDS_SLACK: f32 = 4e-6;
