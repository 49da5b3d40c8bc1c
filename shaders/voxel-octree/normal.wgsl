#define_import_path tracebench::octree_normal

// A unit normal in a word: on an octahedron unfolded to a square (Meyer, Süßmuth, Sußner, Stamminger, Greiner, "On Floating-Point Normal
// Vectors", EGSR 2010), 16 bits an axis.

// As sign, and 1 for 0.
fn side_of(value: vec2<f32>) -> vec2<f32> {
    return select(vec2<f32>(-1.0), vec2<f32>(1.0), value >= vec2<f32>(0.0));
}

fn fold(place: vec2<f32>) -> vec2<f32> {
    return (1.0 - abs(place.yx)) * side_of(place);
}

fn packed_normal(normal: vec3<f32>) -> u32 {
    let place = normal.xy / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    return pack2x16snorm(select(place, fold(place), normal.z < 0.0));
}

fn unpacked_normal(word: u32) -> vec3<f32> {
    let place = unpack2x16snorm(word);
    let z = 1.0 - abs(place.x) - abs(place.y);
    return normalize(vec3<f32>(select(place, fold(place), z < 0.0), z));
}
