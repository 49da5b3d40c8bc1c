#define_import_path tracebench::quadtree_patches

// Pixels' planes joined with those beside them. A pixel's own plane reaches over the whole pixel, also where an edge crosses it and the
// surface goes on along a neighbour's plane: of a face that is seen from aside far before and behind all that is there. Of two planes
// that are joined by an edge towards the eye, each pixel's centre lies behind the other's plane, and what is seen of both is what lies
// behind both: in its pixel a plane holds no farther than to the planes beside it.

#import tracebench::quadtree_node::{Plane, z_on}
#import tracebench::quadtree_track::{NOWHERE, crossing}

const SIDES: u32 = 4u;

// The step to the pixel beside one across a side.
fn step_across(side: u32) -> vec2<i32> {
    let along = select(-1, 1, (side & 1u) == 1u);
    return select(vec2<i32>(along, 0), vec2<i32>(0, along), (side >= 2u));
}

// Whether a pixel's plane ends at that of a neighbour, so many pixels away: where both meet at an edge towards the eye.
fn ends_at(plane: Plane, neighbour: Plane, step: vec2<f32>) -> bool {
    return z_on(plane, step) > neighbour.z && z_on(neighbour, -step) > plane.z;
}

// A plane with its node's middle.
struct Patch {
    plane: Plane,
    middle: vec2<f32>,
}

// A ray's way through a pixel and what lies behind all planes that are joined there, which is between two places.
struct Passage {
    // How far behind the foremost the ray is where it enters the pixel and where it leaves it.
    at_entry: f32,
    at_exit: f32,
    // Where it gets behind the last, NOWHERE for never, and from behind all before the first.
    enters: f32,
    leaves: f32,
    // The planes that it is least behind at its entry, gets behind last, and leaves first.
    foremost: Patch,
    entered: Patch,
    left: Patch,
}

// With one plane more, which the ray is behind by so much where it enters the pixel and where it leaves it.
fn pass_patch(passage: Passage, passed: Patch, places: vec2<f32>, behind: vec2<f32>) -> Passage {
    var told = passage;
    if (behind.x < told.at_entry) {
        told.at_entry = behind.x;
        told.foremost = passed;
    }
    told.at_exit = min(told.at_exit, behind.y);
    if (behind.x <= 0.0) {
        let enters = select(NOWHERE, crossing(places.x, places.y, behind.x, behind.y), (behind.y > 0.0));
        if (enters > told.enters) {
            told.enters = enters;
            told.entered = passed;
        }
    } else if (behind.y <= 0.0) {
        let leaves = crossing(places.x, places.y, behind.x, behind.y);
        if (leaves < told.leaves) {
            told.leaves = leaves;
            told.left = passed;
        }
    }
    return told;
}
