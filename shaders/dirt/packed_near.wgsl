#define_import_path tracebench::dirt_packed_near

// What of a ray's search in the packed forms of DIRT is not done in images: near the eye, where these are noise.

#import tracebench::reads::{quad_1, word_0}
#import tracebench::dirt_packed_grid::{FARTHEST, NEAR_COUNT, FIRST_NEAR, first_corner, listed_cube}
#import tracebench::lanes::open
#import tracebench::dirt_packed_ray::{UNIT, grid, ray, ray_origin, reach, is_done, last_t, test_triangle}

// Whether the ray passes a box less the eye, which is widened by what it is off by there.
fn passes_box(low: vec3<f32>, high: vec3<f32>, inverse: vec3<f32>) -> bool {
    let size = max(abs(low), abs(high));
    let slack = UNIT * (reach + max(max(size.x, size.y), size.z));
    let one = (low - slack - ray_origin) * inverse;
    let other = (high + slack - ray_origin) * inverse;
    let enters = min(one, other);
    let leaves = max(one, other);
    let begin = max(max(max(enters.x, enters.y), enters.z), ray.t_min);
    let end = min(min(min(leaves.x, leaves.y), leaves.z), last_t());
    // Of ts of this size.
    return begin <= end + UNIT * (abs(begin) + abs(end));
}

// Tests the triangles that reach into the cube of so many units round the eye: those that are listed, and for rays from so far outside of
// the scene that the cube is larger than what is listed for, every one.
fn search_near(cube: f32) {
    let is_listed = cube <= listed_cube(grid.tiles, word_0(FARTHEST));
    let count = select(grid.triangle_count, word_0(NEAR_COUNT), is_listed);
    var place = 0u;
    open += 1u;
    loop {
        if (place >= count || is_done()) {
            open -= 1u;
            break;
        }
        let triangle = select(place, word_0(FIRST_NEAR + place), is_listed);
        // The farthest points of a cube are those at its corners.
        if (bitcast<f32>(quad_1(first_corner(grid, triangle)).w) <= 1.75 * cube) {
            test_triangle(triangle, true);
        }
        place += 1u;
    }
}
