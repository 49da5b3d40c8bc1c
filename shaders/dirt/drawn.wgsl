#define_import_path tracebench::dirt_drawn

// The triangles that each view is drawn with, as triangle setup finds them.

// A triangle in a view, and the rectangle of tiles that it may touch there: its first tile, and one behind its last; x in the
// lower halves, y in the upper ones.
struct RasterizedTriangle {
    triangle: u32,
    first: u32,
    last: u32,
}

struct DrawnTriangles {
    // Of each view, also where there is no room for all of them.
    counts: array<u32, 6>,
    // Those of a view in a row, in the order of triangles.
    entries: array<RasterizedTriangle>,
}

// Where corners go that stand for no triangle, since draws are as long as there is room: outside of the image.
const NOTHING_DRAWN: vec4<f32> = vec4<f32>(2.0, 2.0, 0.5, 1.0);
