#define_import_path tracebench::voxel_plane_parts

// What of a triangle lies in a texel of the image along the axis that it faces most, as an octagon: its least and greatest place across,
// down, and along the two diagonals. With the plane, whose slopes are at most 1, that is a fragment.
//
// Texels are grown by a margin, so that a surface that comes near to a texel's border has a fragment on both sides of it: a ray that goes
// along the border, or leaves one triangle for the next there, meets one whichever texel rounding takes it to be in. Octagons are
// rounded outwards.

// Places relative to the texel's low corner, texels.
struct Part {
    // Least and greatest across and down.
    low: vec2<f32>,
    high: vec2<f32>,
    // Least and greatest of across + down, and of across - down.
    low_diagonal: vec2<f32>,
    high_diagonal: vec2<f32>,
}

const NO_PART: Part = Part(vec2<f32>(1e9), vec2<f32>(-1e9), vec2<f32>(1e9), vec2<f32>(-1e9));

// A part's bytes are places by these steps of 1/255, from these ends on.
const BOX_BEGIN: f32 = -0.0625;
const BOX_EXTENT: f32 = 1.125;
const DIAGONAL_BEGIN: vec2<f32> = vec2<f32>(-0.125, -1.125);
const DIAGONAL_EXTENT: f32 = 2.25;

// By how much texels are grown: 2^-7 of one, and what f32 loses of a place in an image of so many, 2^-20 of it being 16 roundings.
fn part_margin(image: u32) -> f32 {
    return 0.0078125 + f32(image) * 9.5367431640625e-7;
}

// By how much a ray's place may lie outside of a part: less than the margin, more than f32 loses of it.
fn place_slack(image: u32) -> f32 {
    return 0.001953125 + f32(image) * 4.76837158203125e-7;
}

fn with_place(part: Part, place: vec2<f32>) -> Part {
    let diagonal = vec2<f32>(place.x + place.y, place.x - place.y);
    return Part(
        min(part.low, place), max(part.high, place), min(part.low_diagonal, diagonal), max(part.high_diagonal, diagonal),
    );
}

fn is_part(part: Part) -> bool {
    return part.low.x <= part.high.x;
}

// Adds what of an edge lies in the grown texel: from -margin to 1 + margin, where the ends lie relative to it (Liang, Barsky, "A New
// Concept and Method for Line Clipping", ACM TOG 3(1), 1984).
fn with_edge(part: Part, a: vec2<f32>, b: vec2<f32>, margin: f32) -> Part {
    let from_a = vec4<f32>(a + margin, 1.0 + margin - a);
    let from_b = vec4<f32>(b + margin, 1.0 + margin - b);
    let out_a = from_a < vec4<f32>(0.0);
    let out_b = from_b < vec4<f32>(0.0);
    if (any(out_a & out_b)) {
        return part;
    }
    let share = from_a / select(vec4<f32>(1.0), from_a - from_b, out_a | out_b);
    let enters = select(vec4<f32>(0.0), share, out_a);
    let leaves = select(vec4<f32>(1.0), share, out_b);
    let first = max(max(enters.x, enters.y), max(enters.z, enters.w));
    let last = min(min(leaves.x, leaves.y), min(leaves.z, leaves.w));
    if (first > last) {
        return part;
    }
    let low = vec2<f32>(-margin);
    let high = vec2<f32>(1.0 + margin);
    let begin = clamp(a + (b - a) * first, low, high);
    let end = clamp(a + (b - a) * last, low, high);
    return with_place(with_place(part, begin), end);
}

fn cross_of(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// How far a place lies to the left of an edge's line, texels.
fn side_of_line(begin: vec2<f32>, end: vec2<f32>, at: vec2<f32>) -> f32 {
    let along = end - begin;
    return cross_of(along / max(length(along), 1e-30), at - begin);
}

// Adds a corner of the texel if it lies in the triangle, or that near to it. All three lines of a sliver may be near far beyond its tip.
fn with_corner(part: Part, a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, turn: f32, corner: vec2<f32>, near: f32) -> Part {
    let sides = turn * vec3<f32>(side_of_line(a, b, corner), side_of_line(b, c, corner), side_of_line(c, a, corner));
    let is_beside = any(corner < min(min(a, b), c) - near) || any(corner > max(max(a, b), c) + near);
    if (all(sides >= vec3<f32>(-near)) && !is_beside) {
        return with_place(part, corner);
    }
    return part;
}

// The part of a triangle in a texel; the triangle's corners in texels of the image. The polygon of both has its extremes where an edge of
// the triangle enters or leaves the texel, at a corner of the triangle, or at one of the texel.
fn part_in_texel(texel: vec2<f32>, first: vec2<f32>, second: vec2<f32>, third: vec2<f32>, margin: f32) -> Part {
    let a = first - texel;
    let b = second - texel;
    let c = third - texel;
    var part = with_edge(with_edge(with_edge(NO_PART, a, b, margin), b, c, margin), c, a, margin);
    let turn = select(1.0, -1.0, (cross_of(b - a, c - a) < 0.0));
    let low = -margin;
    let high = 1.0 + margin;
    let near = 0.5 * margin;
    part = with_corner(part, a, b, c, turn, vec2<f32>(low, low), near);
    part = with_corner(part, a, b, c, turn, vec2<f32>(high, low), near);
    part = with_corner(part, a, b, c, turn, vec2<f32>(low, high), near);
    return with_corner(part, a, b, c, turn, vec2<f32>(high, high), near);
}

fn bytes_of(low: vec2<f32>, high: vec2<f32>, begin: vec2<f32>, extent: f32) -> u32 {
    let scale = 255.0 / extent;
    let steps = vec4<f32>(floor((low - begin) * scale), ceil((high - begin) * scale));
    let bytes = vec4<u32>(clamp(steps, vec4<f32>(0.0), vec4<f32>(255.0)));
    return bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u);
}

// A fragment's first three words of data: its slopes, and the octagon.
fn part_words(slopes: vec2<f32>, part: Part) -> vec3<u32> {
    return vec3<u32>(
        pack2x16snorm(slopes),
        bytes_of(part.low, part.high, vec2<f32>(BOX_BEGIN), BOX_EXTENT),
        bytes_of(part.low_diagonal, part.high_diagonal, DIAGONAL_BEGIN, DIAGONAL_EXTENT),
    );
}

// Whether a place, relative to the texel's low corner, lies in the octagon of these words or that near to it.
fn lies_in_part(words: vec3<u32>, place: vec2<f32>, near: f32) -> bool {
    let box = unpack4x8unorm(words.y) * BOX_EXTENT + BOX_BEGIN;
    let diagonal = unpack4x8unorm(words.z) * DIAGONAL_EXTENT + DIAGONAL_BEGIN.xyxy;
    let turned = vec2<f32>(place.x + place.y, place.x - place.y);
    return all(place >= box.xy - near) && all(place <= box.zw + near)
        && all(turned >= diagonal.xy - 2.0 * near) && all(turned <= diagonal.zw + 2.0 * near);
}
