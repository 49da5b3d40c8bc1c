#define_import_path tracebench::quadtree_reconstruct

// Slopes from depth, and what lies near a discontinuity. The paper leaves both to its supplement (WKP15, section 3.2): these are ours.
// Along a plane z is linear over the image, so that two pixels on one side of a third foretell its z wherever they show the plane.

// z where there is none.
const NO_Z: f32 = -1.0;

// A slope, and whether it was found on a surface that goes on.
struct AxisSlope {
    slope: f32,
    found: bool,
}

// What one side says: the slope to its pixel, and how badly the next two pixels foretell this one.
struct Side {
    slope: f32,
    error: f32,
}

fn side_of(here: f32, near: f32, far: f32, sense: f32) -> Side {
    if (near < 0.0) {
        return Side(0.0, 1e30);
    }
    let step = near - here;
    // With one pixel alone there is nothing to foretell by.
    let error = select(abs(step), abs(far - 2.0 * near + here), (far >= 0.0));
    return Side(step * sense, error);
}

// The slope along an axis, z a pixel, of the side that foretells better; of neither within the tolerance the flatter one where its
// step is within it, else none, as of a thing that is one pixel wide.
fn axis_slope(before_far: f32, before: f32, here: f32, after: f32, after_far: f32, tolerance: f32) -> AxisSlope {
    let first = side_of(here, before, before_far, -1.0);
    let second = side_of(here, after, after_far, 1.0);
    if (min(first.error, second.error) <= tolerance) {
        return AxisSlope(select(second.slope, first.slope, (first.error <= second.error)), true);
    }
    let first_is_flatter = before >= 0.0 && (after < 0.0 || abs(first.slope) <= abs(second.slope));
    let flatter = select(second.slope, first.slope, first_is_flatter);
    let is_near = (before >= 0.0 || after >= 0.0) && abs(flatter) <= tolerance;
    return AxisSlope(select(0.0, flatter, is_near), is_near);
}

// Whether a neighbour's z is not what a pixel's own plane foretells for it.
fn is_apart(neighbour: f32, foretold: f32, tolerance: f32) -> bool {
    return neighbour < 0.0 || abs(neighbour - foretold) > tolerance;
}
