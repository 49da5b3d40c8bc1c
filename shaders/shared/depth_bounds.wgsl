#define_import_path tracebench::depth_bounds

// Depth bounds of a pixel or tile, kept by atomic maxima, and the buckets that divide them.

// Both bounds are stored so that they grow and 0 is nothing: the bits of a positive depth, and for the near bound their
// complement (DIRT's released code stores it negated; one maximum filter serves both).
fn near_code(depth: f32) -> u32 {
    return ~bitcast<u32>(depth);
}

fn far_code(depth: f32) -> u32 {
    return bitcast<u32>(depth);
}

// Near and far depth of a pair of codes; near > far for nothing.
fn depths_of(codes: vec2<u32>) -> vec2<f32> {
    if (codes.y == 0u) {
        return vec2<f32>(1e38, -1e38);
    }
    return vec2<f32>(bitcast<f32>(~codes.x), bitcast<f32>(codes.y));
}

// Where a depth lies in bounds, from 0 at near to 1 at far; 0 in bounds without a range.
fn bucket_share(depth: f32, bounds: vec2<f32>) -> f32 {
    let range = bounds.y - bounds.x;
    if (range <= 0.0) {
        return 0.0;
    }
    return clamp((depth - bounds.x) / range, 0.0, 1.0);
}

// The bucket of a depth (DIRT, equations 1a and 1b; VVP16, section 3.3), held within the buckets: the far bound itself belongs
// to the last.
fn bucket_of(depth: f32, bounds: vec2<f32>, buckets: u32) -> u32 {
    return min(u32(bucket_share(depth, bounds) * f32(buckets)), buckets - 1u);
}
