#define_import_path tracebench::quadtree_proxy

// What stands for four nodes: a plane where one approximates them well enough, else the box round them (WKP15, section 3.3).

#import tracebench::quadtree_forest::{Forest, DILATE_NONE, DILATE_CONTINUOUS, DILATE_FLAGGED, depth_of_z, z_of_pixels}
#import tracebench::quadtree_node::{Plane, Box, SIDES, end_of, is_plane, is_empty, plane_of, plane_words, normal_words, normal_of_words, slope_of_normal, box_of, box_words, range_of}

// The middle of the child `child` of a node, from that of the node, in pixels; `edge` is the child's.
fn from_middle_of(child: u32, edge: f32) -> vec2<f32> {
    return (vec2<f32>(f32(child & 1u), f32(child >> 1u)) - 0.5) * edge;
}

// Whether a plane reaches beyond its node.
fn is_dilated(forest: Forest, flagged: bool) -> bool {
    if (forest.dilated == DILATE_CONTINUOUS) {
        return !flagged;
    }
    return forest.dilated != DILATE_NONE && (flagged || forest.dilated != DILATE_FLAGGED);
}

// Both thresholds at a z: fixed, or grown with eye depth.
fn thresholds_at(forest: Forest, z: f32) -> vec2<f32> {
    let grown = 1.0 + forest.growth * clamp(depth_of_z(forest, max(z, 0.0)) * forest.inverse_far, 0.0, 1.0);
    var distance = forest.gamma_dist * grown;
    if (forest.gamma_in_pixels == 1u) {
        distance = z_of_pixels(forest, z, distance);
    }
    return vec2<f32>(forest.gamma_norm * grown, distance);
}

// A plane over a node, its normal as it is stored; `fits` where it stands for the children.
struct Proxy {
    z: f32,
    normal: u32,
    fits: bool,
}

// The plane for children of an edge in pixels, which all are planes; bit i of `there` says that child i exists. The normal is the
// average of theirs, z what is nearest to their corners along the view direction v = (0, 0, 1) by least squares.
fn proxy_of(forest: Forest, children: array<vec2<u32>, 4>, there: u32, edge: f32) -> Proxy {
    let size = vec2<f32>(forest.size);
    var sum = vec3<f32>(0.0);
    for (var child = 0u; child < 4u; child++) {
        if ((there & (1u << child)) != 0u) {
            sum += normal_of_words(children[child].y);
        }
    }
    // What is stored is what is fitted and tested.
    let stored = normal_words(normalize(sum));
    let normal = normal_of_words(stored);
    let slope = slope_of_normal(normal) / size;
    // Of a square's corners, whose squared distances the fit makes least, only the middle matters.
    var z = 0.0;
    for (var child = 0u; child < 4u; child++) {
        if ((there & (1u << child)) != 0u) {
            z += plane_of(children[child], size).z - dot(slope, from_middle_of(child, edge));
        }
    }
    z /= f32(countOneBits(there));
    let thresholds = thresholds_at(forest, z);
    var fits = z >= 0.0 && z <= 1.0;
    for (var child = 0u; child < 4u; child++) {
        if ((there & (1u << child)) != 0u) {
            let plane = plane_of(children[child], size);
            let turned = length(normal_of_words(children[child].y) - normal);
            // The farthest of its four corners, along z, and from there square to the proxy.
            let middle = abs(plane.z - z - dot(slope, from_middle_of(child, edge)));
            let corner = middle + dot(abs(plane.slope - slope), vec2<f32>(0.5 * edge));
            fits = fits && turned < thresholds.x && corner * normal.z < thresholds.y;
        }
    }
    return Proxy(z, stored, fits);
}

// The node over children of a level; bit i of `there` says that child i exists. Planes that end at others are kept as they are.
fn merged(forest: Forest, children: array<vec2<u32>, 4>, there: u32, level: u32) -> vec2<u32> {
    let edge = f32(1u << level);
    var planes = 0u;
    var flagged = false;
    var ends = false;
    var box = Box(1.0, 0.0, false);
    for (var child = 0u; child < 4u; child++) {
        if ((there & (1u << child)) == 0u) {
            continue;
        }
        let words = children[child];
        if (is_plane(words)) {
            let plane = plane_of(words, vec2<f32>(forest.size));
            let range = range_of(plane, 0.5 * edge + select(0.0, forest.dilation, is_dilated(forest, plane.flagged)));
            box.least = min(box.least, range.x);
            box.greatest = max(box.greatest, range.y);
            planes |= 1u << child;
            flagged = flagged || plane.flagged;
            ends = ends || end_of(words) < SIDES;
        } else {
            let other = box_of(words);
            box.holes = box.holes || other.holes;
            if (!is_empty(words)) {
                box.least = min(box.least, other.least);
                box.greatest = max(box.greatest, other.greatest);
            }
        }
    }
    if (planes == there && !ends) {
        let proxy = proxy_of(forest, children, there, edge);
        if (proxy.fits) {
            return plane_words(proxy.z, proxy.normal, flagged);
        }
    }
    return box_words(box);
}
