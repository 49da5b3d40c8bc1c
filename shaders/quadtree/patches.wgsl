#define_import_path tracebench::quadtree_patches

// Pixels' planes joined with those beside them. A pixel's own plane reaches over the whole pixel, also where an edge crosses it and the
// surface goes on along a neighbour's plane: of a face that is seen from aside far before and behind all that is there. Of two planes
// that are joined by an edge towards the eye, each pixel's centre lies behind the other's plane, and what is seen of both is what lies
// behind both: in its pixel a plane holds no farther than to the plane beside it.

#import tracebench::quadtree_node::{Plane, z_on}

// The step to the pixel beside one across a side.
fn step_across(side: u32) -> vec2<i32> {
    let along = select(-1, 1, (side & 1u) == 1u);
    return select(vec2<i32>(along, 0), vec2<i32>(0, along), (side >= 2u));
}

// By how much z of a plane lies before that of a neighbour, so many pixels away, at the side between both, if both meet at an edge
// towards the eye; else not above 0.
fn end_before(plane: Plane, neighbour: Plane, step: vec2<f32>) -> f32 {
    let meet = z_on(plane, step) > neighbour.z && z_on(neighbour, -step) > plane.z;
    return select(0.0, z_on(plane, 0.5 * step) - z_on(neighbour, -0.5 * step), meet);
}
