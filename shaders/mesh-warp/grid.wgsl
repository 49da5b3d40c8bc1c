#define_import_path tracebench::grid

// How the pixels of an image are a mesh: a vertex a pixel, numbered row by row, and two triangles a square between four of them. Triangles
// are numbered square by square; the two of a square share the diagonal from its upper right corner to its lower left one.

// The vertices of a triangle in an image of so many columns.
fn corners_of(triangle: u32, columns: u32) -> vec3<u32> {
    let square = triangle / 2u;
    let first = square / (columns - 1u) * columns + square % (columns - 1u);
    let diagonal = vec2<u32>(first + 1u, first + columns);
    return vec3<u32>(select(first + columns + 1u, first, (triangle % 2u == 0u)), diagonal.yx);
}
