#define_import_path tracebench::depth_cells

// Where the cells of pyramids over images of eye depth lie: image after image, of each its levels from the first above the pixels on.

#import tracebench::pyramid::index_in_level

// The eye depth where there is no surface: beyond every one.
const NO_SURFACE: f32 = 1e30;

struct PyramidLayout {
    // Pixels.
    size: vec2<u32>,
    // The pixels themselves are the first.
    levels: u32,
    // Of one image.
    cells: u32,
    // First cell of each level in an image, four a vector.
    level_offsets: array<vec4<u32>, 4>,
}

// Of a level, whose first is at `offset`: read by who has the uniform, since a table that is given as a value is copied for every lane.
fn depth_cell(pyramid: PyramidLayout, offset: u32, image: u32, level: u32, cell: vec2<u32>) -> u32 {
    return image * pyramid.cells + offset + index_in_level(pyramid.size, level, cell);
}
