// Perspective-correct DDA over a depth buffer: McGuire and Mara, "Efficient GPU Screen-Space Ray Tracing", JCGT 3(4),
// 2014, listing 1 and section 3. Along a ray's projection the position in pixels, 1/z and t/z are linear.
//
// DEEP: several layers of depth, backs behind them. HI_Z: samples that cannot hit are skipped by a pyramid of depth bounds
// (Uludag, "Hi-Z Screen-Space Cone-Traced Reflections", GPU Pro 5, 2014). A skip is of samples that lie surely in one cell and all
// before or all behind what the cell bounds, so that what is answered is the same bit for bit. Which cell a sample on a border lies in
// is told by the pixel that it reads; of a ray along a border the cells on both sides are asked.
// CELLS: not samples but all pixels that the ray crosses, each for the part of the ray in it, by cells of the pyramid, whose first are the
// pixels themselves: Uludag's march.

#import tracebench::dispatch::Invocation
#import tracebench::types::{Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_LEFT_VIEWS, STATUS_STEP_CAP, STATUS_THICKNESS_REJECTED}
#import tracebench::view::{View, pixel_position}
#import tracebench::image_walk::{EyeRay, Span, cut, eye_ray_of, span_in_view}
#import tracebench::image_line::{ImageLine, between, depth_on}
#import tracebench::lanes::{WORKGROUP_SIZE, answer_rays}
#import tracebench::reads::{word_0, pair_0}
#import tracebench::depth_cells::{PyramidLayout, NO_SURFACE, depth_cell}

struct Settings {
    ray_count: u32,
    max_steps: u32,
    // 0: t at the step's own position (listing 1); 1: t at the stored eye depth, held within the step.
    hit_point: u32,
    // Pixels along the major axis.
    stride: f32,
    // Eye depth in scene units, and share of the stored depth; added.
    thickness: f32,
    thickness_per_depth: f32,
    // Pixels along the major axis.
    start_bias: f32,
    rays_per_lane: u32,
    // Words of the images' rows, and of an image, in a buffer.
    row_words: u32,
    image_words: u32,
    // Layers of depth: the first images.
    layers: u32,
    // 1: as many images of backs follow.
    backs: u32,
    // 1: what is met from the side that the view does not see is no hit.
    front_alone: u32,
    // 1: rays are cut to the depths that are stored.
    depth_clip: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> settings: Settings;
#ifdef TEXTURES
// As they were drawn; in a buffer they are the array of words 0.
@group(0) @binding(2) var eye_depths: texture_2d_array<f32>;
#endif
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray the depth samples and, with HI_Z, the cells.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// A bit a pixel, row by row: looked at by any ray.
@group(0) @binding(6) var<storage, read_write> pixels_touched: array<atomic<u32>>;
#endif
#ifdef SURFACES
// The triangle seen at every pixel, and of every ray the one that it hit.
@group(0) @binding(7) var primitives: texture_2d_array<u32>;
@group(0) @binding(8) var<storage, read_write> seen: array<u32>;
#endif
#ifdef HI_Z
// Its cells are the array of pairs 0: near and far.
@group(0) @binding(9) var<uniform> pyramid: PyramidLayout;

override CELLS: bool;

// Share by which depths at the ends of a run of samples may be off those of the samples between, by rounding: some ulps.
const DEPTH_SLACK: f32 = 4e-6;
// Part of the image's edge by which positions of samples may be off the line, by rounding: some ulps.
const PLACE_SLACK: f32 = 2e-6;
#endif

// Whether there are several images.
override DEEP: bool;

fn stored_depth(image: u32, pixel: vec2<i32>) -> f32 {
#ifdef TEXTURES
    return textureLoad(eye_depths, pixel, i32(image), 0).x;
#else
    return bitcast<f32>(word_0(image * settings.image_words + u32(pixel.y) * settings.row_words + u32(pixel.x)));
#endif
}

// How deep what is stored at a depth of a layer is taken to reach.
fn end_of(layer: u32, pixel: vec2<i32>, stored: f32) -> f32 {
    if (DEEP && settings.backs == 1u) {
        let back = stored_depth(settings.layers + layer, pixel);
        if (back < NO_SURFACE) {
            return back;
        }
    }
    return thickened(stored);
}

// How deep a surface reaches where no back tells.
fn thickened(stored: f32) -> f32 {
    return stored + (settings.thickness + settings.thickness_per_depth * stored);
}

struct Answer {
    hit: Hit,
    // Depth samples, and cells of the pyramid.
    work: vec2<u32>,
    // Where the view was met, and in which layer; of hits alone.
    pixel: vec2<i32>,
    layer: u32,
}

fn no_hit(status: u32, work: vec2<u32>) -> Answer {
    return Answer(miss(status), work, vec2<i32>(0), 0u);
}

// Where on the line a sample looks, and up to where it reaches: half a step ahead; the last step takes what is left.
fn place_of(first: f32, step: f32, sample: u32) -> f32 {
    return min(first + f32(sample) * step, 1.0);
}

fn reach_of(place: f32, step: f32) -> f32 {
    return select(place + 0.5 * step, 1.0, (place + step > 1.0 || step == 1.0));
}

// The pixel that a sample reads.
fn pixel_of(position: vec2<f32>) -> vec2<i32> {
    return clamp(vec2<i32>(floor(position)), vec2<i32>(0), vec2<i32>(view.size) - 1);
}

#ifdef HI_Z
// The borders round two cells side by side, or one, pixels: left and top, right and bottom. Beyond the image's own there is nothing to be
// taken for.
fn borders_of(one: vec2<i32>, other: vec2<i32>, level: u32) -> vec4<f32> {
    let beyond = view.size + 4.0;
    let first = min(one, other);
    let low = vec2<f32>(first << vec2<u32>(level));
    let high = vec2<f32>((max(one, other) + 1) << vec2<u32>(level));
    return vec4<f32>(
        select(low, -beyond, (first == vec2<i32>(0))),
        select(high, beyond + view.size, (high >= view.size)),
    );
}

// By how much positions of samples may be off the line, pixels.
fn place_slack() -> f32 {
    return PLACE_SLACK * max(view.size.x, view.size.y);
}

// Along which axes samples lie so far apart that rounding does not change their order: what lies between two of them that read a cell
// reads it too, be they on its very borders. Along the other ones a ray may run along a border.
fn keeps_order(way: vec2<f32>) -> vec2<bool> {
    return abs(way) >= vec2<f32>(2.0 * place_slack());
}

// The cell across the border that the ray runs along, where rounding decides which of both its samples read; the same for none.
fn cell_across(at: vec2<f32>, cell: vec2<i32>, level: u32, ordered: vec2<bool>) -> vec2<i32> {
    let borders = borders_of(cell, cell, level);
    let slack = place_slack();
    let before = select(vec2<i32>(0), vec2<i32>(1), at < borders.xy + slack);
    let behind = select(vec2<i32>(0), vec2<i32>(1), at > borders.zw - slack);
    return cell + select(behind - before, vec2<i32>(0), ordered);
}

// Whether a position lies within borders by more than rounding moves it, along axes that need it.
fn is_within(at: vec2<f32>, borders: vec4<f32>, ordered: vec2<bool>) -> bool {
    let slack = place_slack();
    let clear = (at >= borders.xy + slack) & (at <= borders.zw - slack);
    return all(clear | ordered);
}

// Whether a sample reads a pixel of one of two cells.
fn reads_one_of(at: vec2<f32>, one: vec2<i32>, other: vec2<i32>, level: u32) -> bool {
    let cell = pixel_of(at) >> vec2<u32>(level);
    return all(cell == one) || all(cell == other);
}

// Samples from a position on that lie within borders, by their way between one and the next: one at least, and one too many where the
// last of them falls on a border.
fn samples_within(at: vec2<f32>, way: vec2<f32>, borders: vec4<f32>, ordered: vec2<bool>) -> u32 {
    let slack = place_slack();
    let margin = select(vec2<f32>(-slack), vec2<f32>(slack), ordered);
    let left = select(at - borders.xy, borders.zw - at, (way > vec2<f32>(0.0))) + margin;
    let steps = select(vec2<f32>(65536.0), left / max(abs(way), vec2<f32>(1e-6)), (abs(way) > vec2<f32>(1e-6)));
    return u32(clamp(min(steps.x, steps.y), 0.0, 65535.0)) + 1u;
}

// The level of the next cell: one up where the ray comes into another one of the level above, which it has not asked yet. It does not come
// into those that it runs along.
fn next_level(pixel: vec2<i32>, next: vec2<i32>, level: u32, ordered: vec2<bool>) -> u32 {
    let above = vec2<u32>(level + 1u);
    let crosses = any(((pixel >> above) != (next >> above)) & ordered) && level + 1u < pyramid.levels;
    return select(level, level + 1u, crosses);
}

// What depths of a ray are to what a cell bounds in every layer.
const MEETS: u32 = 0u;
const ALL_BEFORE: u32 = 1u;
const SOME_BEHIND: u32 = 2u;

// The nearest depth that a cell has of a layer, and how deep the layer reaches there.
fn bounds_of(layer: u32, level: u32, cell: vec2<u32>) -> vec2<f32> {
    let offset = pyramid.level_offsets[level >> 2u][level & 3u];
    let bounds = bitcast<vec2<f32>>(pair_0(depth_cell(pyramid, offset, layer, level, cell)));
    var end = thickened(bounds.y);
    if (DEEP && settings.backs == 1u) {
        let back = bitcast<f32>(pair_0(depth_cell(pyramid, offset, settings.layers + layer, level, cell)).y);
        end = select(max(end, back), back, level == 0u && back > 0.0);
    }
    return vec2<f32>(bounds.x, end);
}

fn compare_to_cell(level: u32, cell: vec2<u32>, nearest: f32, farthest: f32) -> u32 {
    var found = ALL_BEFORE;
    var layer = 0u;
    loop {
        let bounds = bounds_of(layer, level, cell);
        // Before a layer is before all deeper ones.
        if (farthest < bounds.x) {
            break;
        }
        if (!(nearest > bounds.y)) {
            return MEETS;
        }
        found = SOME_BEHIND;
        layer += 1u;
        if (!DEEP || layer >= settings.layers) {
            break;
        }
    }
    return found;
}
#endif

// What a ray meets at a layer of a pixel.
struct Met {
    layer: u32,
    stored: f32,
    is_met: bool,
    is_behind: bool,
    is_before: bool,
}

const NOTHING_MET: Met = Met(0u, 0.0, false, false, false);

fn meet(layer: u32, pixel: vec2<i32>, nearest: f32, farthest: f32) -> Met {
    let stored = stored_depth(layer, pixel);
    let is_before = !(farthest >= stored);
    let reaches = end_of(layer, pixel, stored);
    return Met(layer, stored, !is_before && nearest <= reaches, nearest > reaches, is_before);
}

// The hit with what is met between two places on the line; `s` is the place where it is told if not by depth.
fn hit_of(ray: Ray, eye_ray: EyeRay, line: ImageLine, met: Met, low: f32, high: f32, s: f32, by_depth: bool) -> Hit {
    let ts = line.ts_over_depth;
    let k = line.inverse_depths;
    let t_low = between(ts, low) / between(k, low);
    let t_high = between(ts, high) / between(k, high);
    var t = between(ts, s) / between(k, s);
    if (by_depth && eye_ray.direction.z != 0.0) {
        t = (met.stored - eye_ray.origin.z) / eye_ray.direction.z;
    }
    return Hit(clamp(clamp(t, t_low, t_high), ray.t_min, ray.t_max), NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
}

#ifdef HI_Z
// Share of the nearest depth's inverse by which a line is cut farther off than what is stored, for rounding.
const CLIP_SLACK: f32 = 4e-6;

// The places between which a line lies at depths that any pixel has.
fn clip_to_depths(line: ImageLine) -> Span {
    var range = vec2<f32>(NO_SURFACE, 0.0);
    for (var layer = 0u; layer < settings.layers; layer++) {
        let bounds = bounds_of(layer, pyramid.levels - 1u, vec2<u32>(0u));
        range = vec2<f32>(min(range.x, bounds.x), max(range.y, bounds.y));
    }
    let k = line.inverse_depths;
    let least = 1.0 / range + CLIP_SLACK * max(k.x, k.y) * vec2<f32>(1.0, -1.0);
    let nearer = cut(Span(0.0, 1.0), least.x - k.x, k.x - k.y);
    return cut(nearer, k.x - least.y, k.y - k.x);
}

// The walk over the pixels that a line crosses. Where it crosses a border is told by the border alone, and the pixel that it is in at a
// place by the borders that it has crossed there, so that cells, pixels and a cut beginning lead through the same pixels.
struct Walk {
    line: ImageLine,
    heading: vec2<i32>,
    // Of places by pixels.
    inverse: vec2<f32>,
}

// No line gets there.
const BEYOND: f32 = 2.0;

// Less of the image is none.
const LEAST_WAY: f32 = 1e-6;

fn walk_of(line: ImageLine) -> Walk {
    let way = line.end - line.begin;
    let moves = abs(way) > vec2<f32>(LEAST_WAY);
    let heading = select(vec2<i32>(0), vec2<i32>(sign(way)), moves);
    return Walk(line, heading, 1.0 / select(vec2<f32>(1.0), way, moves));
}

// Where the line crosses the borders at these columns and rows.
fn crosses(walk: Walk, borders: vec2<i32>) -> vec2<f32> {
    let at = (vec2<f32>(borders) - walk.line.begin) * walk.inverse;
    return select(vec2<f32>(BEYOND), at, walk.heading != vec2<i32>(0));
}

// The pixel that the line is in at a place.
fn pixel_at(walk: Walk, s: f32) -> vec2<i32> {
    let about = pixel_of(mix(walk.line.begin, walk.line.end, s));
    let ahead = max(walk.heading, vec2<i32>(0));
    let passed = vec2<f32>(s) >= crosses(walk, about + ahead);
    let enters = crosses(walk, about + 1 - ahead);
    let early = (vec2<f32>(s) < enters) & (enters < vec2<f32>(BEYOND));
    return about + walk.heading * (vec2<i32>(passed) - vec2<i32>(early));
}

// What a ray finds in a cell.
struct Seen {
    met: Met,
    // The cells below are to be looked at.
    opens: bool,
    // How many layers the ray is behind as it leaves.
    behind: u32,
}

// Looks at a cell where the ray enters and leaves it at two depths; `behind` is how many layers it was behind before.
fn see(level: u32, cell: vec2<u32>, entry: f32, exit: f32, behind: u32) -> Seen {
    let slack = select(DEPTH_SLACK, 0.0, level == 0u);
    let nearest = min(entry, exit) * (1.0 - slack);
    let farthest = max(entry, exit) * (1.0 + slack);
    var seen = Seen(NOTHING_MET, false, 0u);
    var layer = 0u;
    loop {
        let bounds = bounds_of(layer, level, cell);
        // Before a layer is before all deeper ones.
        if (!(farthest >= bounds.x)) {
            break;
        }
        let is_behind = nearest > bounds.y;
        // It comes from before where it is there as it enters the pixel, or, as pixels are steps of a stair, was as it left the last one.
        let from_before = entry <= bounds.x || (entry <= bounds.y && layer >= behind);
        let counts = settings.front_alone == 0u || from_before;
        let is_met = level == 0u && !is_behind && counts;
        seen.met.is_behind = seen.met.is_behind || is_behind || (level == 0u && !counts);
        seen.opens = level > 0u && !is_behind;
        seen.behind = select(seen.behind, layer + 1u, level > 0u || exit > bounds.x);
        if (is_met) {
            seen.met.layer = layer;
            seen.met.stored = bounds.x;
            seen.met.is_met = true;
        }
        layer += 1u;
        // From behind the farthest is met first.
        if (!DEEP || seen.opens || (is_met && entry <= exit) || layer >= settings.layers) {
            break;
        }
    }
    return seen;
}

fn march_cells(ray: Ray, eye_ray: EyeRay, line: ImageLine, first: f32, nothing: u32) -> Answer {
    let walk = walk_of(line);
    let last_pixel = vec2<i32>(view.size) - 1;
    let ahead = max(walk.heading, vec2<i32>(0));
    var work = vec2<u32>(0u);
    var s = first;
    var last = 1.0;
    if (settings.depth_clip == 1u) {
        let clipped = clip_to_depths(line);
        s = max(s, clipped.begin);
        last = clipped.end;
    }
    var behind_a_surface = last < 1.0;
    var pixel = clamp(pixel_at(walk, s), vec2<i32>(0), last_pixel);
    // Rays start on surfaces: a coarse cell would say nothing.
    var level = select(0u, pyramid.levels - 1u, s > first);
    var depth = depth_on(line, s);
    var out = s;
    // How many layers the ray is behind; where it starts, that is not known.
    var behind = settings.layers;
    var seen = Seen(NOTHING_MET, false, 0u);
    var capped = false;
    while (s < last) {
        if (work.x + work.y >= settings.max_steps) {
            capped = true;
            break;
        }
        let cell = pixel >> vec2<u32>(level);
        let exits = crosses(walk, (cell + ahead) << vec2<u32>(level));
        out = clamp(min(exits.x, exits.y), s, 1.0);
        let depth_out = depth_on(line, out);
        work += select(vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), level == 0u);
#ifdef COUNTERS
        if (level == 0u) {
            touch(pixel);
        }
#endif
        seen = see(level, vec2<u32>(cell), depth, depth_out, behind);
        behind_a_surface = behind_a_surface || seen.met.is_behind;
        if (seen.met.is_met) {
            break;
        }
        if (seen.opens) {
            level -= 1u;
            continue;
        }
        let low = cell << vec2<u32>(level);
        let high = (cell + 1) << vec2<u32>(level);
        let next = select(
            clamp(pixel_at(walk, out), low, high - 1),
            select(low - 1, high, walk.heading > vec2<i32>(0)),
            exits <= vec2<f32>(out),
        );
        if (out >= 1.0 || any(next < vec2<i32>(0)) || any(next > last_pixel)) {
            break;
        }
        level = next_level(pixel, next, level, vec2<bool>(true));
        pixel = next;
        s = out;
        depth = depth_out;
        behind = seen.behind;
    }
    let met = seen.met;
    if (capped) {
        return no_hit(STATUS_STEP_CAP, work);
    }
    if (met.is_met) {
        // A ray along which depth does not change is in the surface as it enters the pixel.
        let by_depth = settings.hit_point == 1u;
        return Answer(hit_of(ray, eye_ray, line, met, s, out, select(out, s, by_depth), by_depth), work, pixel, met.layer);
    }
    return no_hit(select(nothing, STATUS_THICKNESS_REJECTED, behind_a_surface), work);
}
#endif

#ifdef COUNTERS
fn touch(pixel: vec2<i32>) {
    let place = u32(pixel.y) * u32(view.size.x) + u32(pixel.x);
    atomicOr(&pixels_touched[place >> 5u], 1u << (place & 31u));
}
#endif

fn march(ray: Ray) -> Answer {
    let eye_ray = eye_ray_of(view, ray);
    let origin = eye_ray.origin;
    let direction = eye_ray.direction;
    let part = span_in_view(view, eye_ray, Span(ray.t_min, ray.t_max), 1.0);
    let span = vec2<f32>(part.begin, part.end);
    if (!(span.x < span.y)) {
        return no_hit(STATUS_LEFT_VIEWS, vec2<u32>(0u));
    }
    let begin = origin + span.x * direction;
    let end = origin + span.y * direction;
    // Rounding may leave the clipped ends a little before the near plane.
    let k = vec2<f32>(1.0 / max(begin.z, view.near), 1.0 / max(end.z, view.near));
    let pixel_begin = pixel_position(view, begin);
    let pixel_end = pixel_position(view, end);
    let along = abs(pixel_end - pixel_begin);
    let major = max(along.x, along.y);
    let line = ImageLine(pixel_begin, pixel_end, k, span * k, major);
    // A ray that stays within a stride (every primary ray does) is one step.
    let step = min(settings.stride / max(major, 1e-6), 1.0);
    // The bias keeps rays that start on a surface from finding it; a ray that enters the view from outside needs none.
    let starts_inside = span.x <= ray.t_min;
    let first = select(0.0, min(settings.start_bias / max(major, 1e-6), 1.0), starts_inside);
    let seen_whole = starts_inside && span.y >= ray.t_max;
    let nothing = select(STATUS_LEFT_VIEWS, STATUS_MISS, seen_whole);
#ifdef HI_Z
    if (CELLS) {
        return march_cells(ray, eye_ray, line, first, nothing);
    }
#endif

    // Of the next sample: its number, where it begins and where it looks.
    var sample = 0u;
    var low = first;
    var s = first;
    var work = vec2<u32>(0u);
    var behind_a_surface = false;
    let forwards = direction.z >= 0.0;
    var looks = 0u;
    var meets_nearest = false;
    var nearest_stored = 0.0;
    var met = NOTHING_MET;
    var pixel = vec2<i32>(0);
    var high = first;
    var capped = false;
#ifdef HI_Z
    let way = (line.end - line.begin) * step;
    let ordered = keeps_order(way);
    // Rays start on surfaces: a coarse cell would say nothing.
    var level = 0u;
#endif
    while (low < 1.0) {
        if (sample >= settings.max_steps) {
            capped = true;
            break;
        }
        let position = mix(line.begin, line.end, s);
        pixel = pixel_of(position);
#ifdef HI_Z
        if (level > 0u) {
            work.y += 1u;
            let cell = pixel >> vec2<u32>(level);
            let other = cell_across(position, cell, level, ordered);
            let borders = borders_of(cell, other, level);
            var count = min(samples_within(position, way, borders, ordered), settings.max_steps - sample);
            var last = place_of(first, step, sample + count - 1u);
            if (count > 1u && !reads_one_of(mix(line.begin, line.end, last), cell, other, level)) {
                count -= 1u;
                last = place_of(first, step, sample + count - 1u);
            }
            let last_position = mix(line.begin, line.end, last);
            // The ray's end may lie closer behind a sample than samples behind each other.
            let last_ordered = ordered & vec2<bool>(last < 1.0);
            if (is_within(position, borders, ordered) && is_within(last_position, borders, last_ordered)
                && reads_one_of(last_position, cell, other, level)) {
                let reach = reach_of(last, step);
                let depths = 1.0 / vec2<f32>(between(k, low), between(k, reach));
                let nearest = min(depths.x, depths.y) * (1.0 - DEPTH_SLACK);
                let farthest = max(depths.x, depths.y) * (1.0 + DEPTH_SLACK);
                var compared = compare_to_cell(level, vec2<u32>(cell), nearest, farthest);
                if (compared != MEETS && any(other != cell)) {
                    work.y += 1u;
                    // Of which it is behind some only the samples could tell.
                    let beside = compare_to_cell(level, vec2<u32>(other), nearest, farthest);
                    compared = select(MEETS, compared, beside == compared);
                }
                if (compared != MEETS) {
                    behind_a_surface = behind_a_surface || (compared == SOME_BEHIND);
                    sample += count;
                    low = reach;
                    s = place_of(first, step, sample);
                    level = next_level(pixel, pixel_of(mix(line.begin, line.end, s)), level, ordered);
                    continue;
                }
            }
            level -= 1u;
            continue;
        }
#endif
        high = reach_of(s, step);
        work.x += select(0u, 1u, looks == 0u);
#ifdef COUNTERS
        touch(pixel);
#endif
        let k_low = between(k, low);
        let k_high = between(k, high);
        let nearest = min(1.0 / k_low, 1.0 / k_high);
        let farthest = max(1.0 / k_low, 1.0 / k_high);
        // A layer a round, as lanes that run together would wait for the one that looks at most. What is before a layer is before all deeper
        // ones. From behind the nearest is looked at first, too, and met last.
        let layer = select(settings.layers - looks, looks, forwards || looks == 0u);
        met = meet(select(0u, layer, DEEP), pixel, nearest, farthest);
        behind_a_surface = behind_a_surface || met.is_behind;
        if (DEEP) {
            let is_first = looks == 0u;
            looks += 1u;
            if (!forwards && is_first) {
                meets_nearest = met.is_met;
                nearest_stored = met.stored;
                met.is_met = met.is_met && settings.layers == 1u;
            }
            let has_more = looks < settings.layers && !(met.is_before && (forwards || is_first));
            if (has_more && !met.is_met) {
                continue;
            }
            if (!forwards && !is_first && !met.is_met && meets_nearest) {
                met = Met(0u, nearest_stored, true, false, false);
            }
            looks = 0u;
        }
        if (met.is_met) {
            break;
        }
        sample += 1u;
        low = high;
        s = place_of(first, step, sample);
#ifdef HI_Z
        level = next_level(pixel, pixel_of(mix(line.begin, line.end, s)), 0u, ordered);
#endif
    }
    if (capped) {
        return no_hit(STATUS_STEP_CAP, work);
    }
    if (met.is_met) {
        // A ray that falls on one pixel has no other position than the stored depth.
        let by_depth = settings.hit_point == 1u || step == 1.0;
        return Answer(hit_of(ray, eye_ray, line, met, low, high, s, by_depth), work, pixel, met.layer);
    }
    return no_hit(select(nothing, STATUS_THICKNESS_REJECTED, behind_a_surface), work);
}

override fn tracebench::lanes::answer_ray(index: u32) {
    let answer = march(rays[index]);
    hits[index] = answer.hit;
#ifdef COUNTERS
#ifdef HI_Z
    counts[2u * index] = answer.work.x;
    counts[2u * index + 1u] = answer.work.y;
#else
    counts[index] = answer.work.x;
#endif
#endif
#ifdef SURFACES
    seen[index] = textureLoad(primitives, answer.pixel, i32(answer.layer), 0).x;
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, settings.ray_count, settings.rays_per_lane);
}
