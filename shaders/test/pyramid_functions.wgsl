// Walks pyramids and sorts depths into buckets, so that a test can compare the shared functions with those of the host.

#import tracebench::pyramid::{CodedCell, level_size, index_in_level, cell_below, place_of, first_below, next_after}
#import tracebench::depth_bounds::{near_code, far_code, depths_of, bucket_share, bucket_of}

// Pixels along x and y, levels, where the image's numbers begin.
@group(0) @binding(0) var<storage, read> images: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> numbers: array<u32>;
// Depth, near and far bound, buckets.
@group(0) @binding(2) var<storage, read> depths: array<vec4<f32>>;
// Bounds as they are read from their codes, share, bucket.
@group(0) @binding(3) var<storage, read_write> sorted: array<vec4<f32>>;

// All pixels in the order in which a walk down the pyramid meets them, by their places in the image.
@compute @workgroup_size(64)
fn descend(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&images)) {
        return;
    }
    let image = images[id.x];
    let top = image.z - 1u;
    var cell = CodedCell(top, 0u);
    var at = image.w;
    loop {
        let place = place_of(cell);
        if (all(place < level_size(image.xy, cell.level))) {
            if (cell.level > 0u) {
                cell = first_below(cell);
                continue;
            }
            numbers[at] = index_in_level(image.xy, 0u, place);
            at += 1u;
        }
        cell = next_after(cell, top);
        if (cell.level == top) {
            break;
        }
    }
}

// Of every cell above the pixels, level by level, the sum over the four below it of powers of their places' numbers.
@compute @workgroup_size(64)
fn gather_below(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&images)) {
        return;
    }
    let image = images[id.x];
    var at = image.w;
    for (var level = 1u; level < image.z; level++) {
        let size = level_size(image.xy, level);
        for (var index = 0u; index < size.x * size.y; index++) {
            let cell = vec2<u32>(index % size.x, index / size.x);
            var sum = 0u;
            for (var child = 0u; child < 4u; child++) {
                let below = cell_below(image.xy, level, cell, child);
                sum = sum * 4099u + index_in_level(image.xy, level - 1u, below);
            }
            numbers[at] = sum;
            at += 1u;
        }
    }
}

@compute @workgroup_size(64)
fn sort_depths(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&depths)) {
        return;
    }
    let given = depths[id.x];
    let codes = select(vec2<u32>(near_code(given.y), far_code(given.z)), vec2<u32>(0u), (given.y > given.z));
    let bounds = depths_of(codes);
    let bucket = bucket_of(given.x, bounds, u32(given.w));
    sorted[id.x] = vec4<f32>(bounds, bucket_share(given.x, bounds), f32(bucket));
}
