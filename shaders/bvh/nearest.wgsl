#define_import_path tracebench::bvh_nearest

#import tracebench::bvh_build::Box

// Nearest neighbours of four clusters in a row, sought at once: a neighbour that is loaded is compared with all four. Reads
// at unrelated places are what searches take longest for, and clusters in a row have most neighbours in common.

struct Four {
    low_x: vec4<f32>,
    low_y: vec4<f32>,
    low_z: vec4<f32>,
    high_x: vec4<f32>,
    high_y: vec4<f32>,
    high_z: vec4<f32>,
    places: vec4<u32>,
    // Places of the nearest neighbours so far; their own for none.
    nearest: vec4<u32>,
    // What merging with these costs.
    least: vec4<f32>,
}

fn four_of(first: u32, a: Box, b: Box, c: Box, d: Box) -> Four {
    let places = vec4<u32>(first) + vec4<u32>(0u, 1u, 2u, 3u);
    return Four(
        vec4<f32>(a.low.x, b.low.x, c.low.x, d.low.x),
        vec4<f32>(a.low.y, b.low.y, c.low.y, d.low.y),
        vec4<f32>(a.low.z, b.low.z, c.low.z, d.low.z),
        vec4<f32>(a.high.x, b.high.x, c.high.x, d.high.x),
        vec4<f32>(a.high.y, b.high.y, c.high.y, d.high.y),
        vec4<f32>(a.high.z, b.high.z, c.high.z, d.high.z),
        places,
        places,
        vec4<f32>(3.4e38),
    );
}

// Of equal boxes the neighbour whose place differs in lower bits is nearer, so that equal clusters merge as a balanced tree.
fn compare(four: ptr<function, Four>, radius: u32, place: u32, other: Box) {
    let x = max((*four).high_x, vec4<f32>(other.high.x)) - min((*four).low_x, vec4<f32>(other.low.x));
    let y = max((*four).high_y, vec4<f32>(other.high.y)) - min((*four).low_y, vec4<f32>(other.low.y));
    let z = max((*four).high_z, vec4<f32>(other.high.z)) - min((*four).low_z, vec4<f32>(other.low.z));
    // As `half_area` has it.
    let cost = x * y + y * z + z * x;
    let places = vec4<u32>(place);
    // No more than the radius before or after, in unsigned numbers.
    let in_reach = places + vec4<u32>(radius) - (*four).places <= vec4<u32>(2u * radius);
    let is_closer = (places ^ (*four).places) < ((*four).nearest ^ (*four).places);
    let is_nearer = (cost < (*four).least) | ((cost == (*four).least) & is_closer);
    let takes = is_nearer & in_reach & (places != (*four).places);
    (*four).least = select((*four).least, cost, takes);
    (*four).nearest = select((*four).nearest, places, takes);
}
