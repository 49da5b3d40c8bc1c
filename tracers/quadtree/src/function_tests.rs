//! The functions of the shaders on the device against f64.

use std::sync::Arc;

use bytemuck::Zeroable;
use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::wgpu::BufferUsages;
use tracebench_api::{Gpu, View, Viewpoint};
use tracebench_kit::{bind_group_at, compute_pipeline, dispatch_linear, uniform_buffer, view_uniform};
use tracebench_shaders::test::QUADTREE_FUNCTIONS;
use tracebench_tests::{Numbers, gpu};

use crate::layout::Forest;
use crate::nodes::Node;

/// Roundings of half an ulp that lie between a number and its reference, with room for drivers that contract or reorder.
pub(crate) const SLACK: f64 = 16.0 * f32::EPSILON as f64;

pub(crate) const SIZE: [u32; 2] = [96, 64];

pub(crate) fn view() -> View {
    Viewpoint {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.1,
        near: 0.05,
        far: 40.0,
        frame: SIZE,
        face: 64,
    }
    .frame_view()
}

pub(crate) fn forest() -> Forest {
    let view = view();
    Forest {
        size: SIZE,
        z_scale: (view.near * (view.far / (view.far - view.near))) as f32,
        z_shift: (view.near / (view.far - view.near)) as f32,
        pixel_angle: (2.0 * view.tan_half_height / 64.0) as f32,
        gamma_norm: 0.05,
        gamma_dist: 1e-4,
        inverse_far: (1.0 / view.far) as f32,
        dilation: 0.5,
        dilated: 1,
        ..Forest::zeroed()
    }
}

/// What an entry point is given, and how many records it gives: vectors of four, and nodes.
pub(crate) struct Call<'a> {
    pub entry_point: &'static str,
    pub forest: Forest,
    pub given: &'a [[f32; 4]],
    pub words: &'a [[u32; 2]],
    pub invocations: usize,
    pub results: usize,
    pub nodes: usize,
}

pub(crate) type Answer = (Vec<[f32; 4]>, Vec<[u32; 2]>);

pub(crate) fn call(gpu: &Arc<Gpu>, call: &Call<'_>) -> Answer {
    let pipeline = compute_pipeline(gpu, QUADTREE_FUNCTIONS, call.entry_point).unwrap();
    let forest = uniform_buffer(gpu, "forest", &call.forest).unwrap();
    let view = uniform_buffer(gpu, "view", &view_uniform(&view())).unwrap();
    let input = |bytes: &[u8]| gpu.buffer_with("given", bytes, BufferUsages::STORAGE, "nothing").unwrap();
    let output = |bytes: usize| {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        gpu.buffer("found", bytes as u64, usage, "nothing").unwrap()
    };
    let (given, words) = (input(bytemuck::cast_slice(call.given)), input(bytemuck::cast_slice(call.words)));
    let (results, nodes) = (output(call.results * 16), output(call.nodes * 8));
    let bound: &[u32] = match call.entry_point {
        "convert" => &[0, 1, 2],
        "encode" => &[0, 1, 2, 4],
        "merge_children" => &[0, 3, 4],
        "tell_levels" => &[3, 4],
        "find_slopes" => &[1, 2],
        _ => &[0, 1, 2, 5],
    };
    let all = [&forest, &given, &results, &words, &nodes, &view];
    let resources: Vec<_> = bound.iter().map(|at| (*at, all[*at as usize].as_entire_binding())).collect();
    let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &bindings, call.invocations as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    let read = |buffer, bytes: usize| if bytes == 0 { Vec::new() } else { gpu.read(buffer, bytes as u64).unwrap() };
    (
        bytemuck::pod_collect_to_vec(&read(&results, call.results * 16)),
        bytemuck::pod_collect_to_vec(&read(&nodes, call.nodes * 8)),
    )
}

fn close(found: f32, expected: f64, scale: f64) -> bool {
    (f64::from(found) - expected).abs() <= SLACK * (expected.abs() + scale)
}

/// Depths and numbers of pixels that are not converted as f64 does, by one forest.
fn misconverted(forest: &Forest, given: &[[f32; 4]], found: &[[f32; 4]]) -> usize {
    let [scale, shift, angle] = [forest.z_scale, forest.z_shift, forest.pixel_angle].map(f64::from);
    let wrong = |(given, found): &(&[f32; 4], &[[f32; 4]])| {
        let [depth, pixels] = [given[0], given[1]].map(f64::from);
        let z = (scale / depth - shift).clamp(0.0, 1.0);
        // What was rounded is asked further.
        let stored = f64::from(found[0][0]);
        let grown =
            1.0 + f64::from(forest.growth) * (scale / (stored + shift) * f64::from(forest.inverse_far)).min(1.0);
        let unit = if forest.gamma_in_pixels == 1 { (stored + shift) * angle } else { 1.0 };
        !(close(found[0][0], z, shift)
            && close(found[0][1], scale / (stored + shift), 0.0)
            && close(found[0][2], (stored + shift) * pixels * angle, 0.0)
            && close(found[1][0], f64::from(forest.gamma_norm) * grown, 0.0)
            && close(found[1][1], f64::from(forest.gamma_dist) * grown * unit, 0.0))
    };
    given.iter().zip(found.chunks(2)).filter(wrong).count()
}

/// Proves that depth and z, z of pixels and both thresholds, fixed and grown, in the cube and in pixels, are f64's. Negative control:
/// another near plane and another growth are noticed.
#[test]
fn depths_are_those_of_f64() {
    let gpu = gpu();
    let mut given = Vec::new();
    for step in 0..=400 {
        let depth = 0.05_f32 * (40.0_f32 / 0.05).powf(step as f32 / 400.0);
        given.push([depth, (step % 7) as f32 * 0.5, 0.0, 0.0]);
    }
    for (growth, gamma_in_pixels) in [(0.0, 0), (7.0, 0), (2.5, 1)] {
        let forest = Forest { growth, gamma_in_pixels, ..forest() };
        let asked = Call {
            entry_point: "convert",
            forest,
            given: &given,
            words: &[],
            invocations: given.len(),
            results: 2 * given.len(),
            nodes: 0,
        };
        let (found, _) = call(&gpu, &asked);
        assert_eq!(misconverted(&forest, &given, &found), 0);
        let nearer = Forest { z_scale: forest.z_scale * 1.001, ..forest };
        assert!(misconverted(&nearer, &given, &found) > 300);
        assert!(misconverted(&Forest { growth: growth + 1.0, ..forest }, &given, &found) > 300);
    }
}

/// Planes and boxes to store: z, slopes over the cube, reach in pixels, below 0 for flagged ones and for holes.
fn planes() -> Vec<[f32; 4]> {
    let mut numbers = Numbers::new(151);
    let mut planes = Vec::new();
    for z in [0.0, 1e-30, 1e-6, 0.25, 0.999_999, 1.0] {
        for slope in [0.0, 1e-6, 1e-3, 0.3, 2.0, 29.0] {
            for _ in 0..6 {
                let turn = numbers.unit() * std::f64::consts::TAU;
                let [x, y] = [turn.cos(), turn.sin()].map(|part| (part * slope) as f32);
                planes.push([z, x, y, numbers.signed() as f32 * 8.0]);
            }
        }
    }
    planes
}

/// Nodes that do not say what was asked to be stored, to within half precision, or that the host reads otherwise.
fn misread(given: &[[f32; 4]], found: &[[f32; 4]], nodes: &[[u32; 2]]) -> usize {
    let wrong = |index: &usize| {
        let ([z, x, y, reach], results, stored) = (given[*index], &found[2 * index..], &nodes[2 * index..]);
        let Node::Plane(plane) = Node::of(stored[0], SIZE) else { return true };
        let normal = DVec3::new(f64::from(-x), f64::from(-y), 1.0).normalize();
        // Half an ulp of a half below 1 is 2^-12; the third component's error is as much over it.
        let off = (plane.normal - normal).length();
        let half = 2_f64.powi(-11);
        let spread = f64::from(reach.abs()) * plane.slope.abs().element_sum();
        let scale = f64::from(z) + spread;
        let range = plane.range(f64::from(reach.abs()));
        let [beside, expected] =
            [f64::from(results[1][2]), plane.z_at(DVec2::new(f64::from(reach.abs()), -f64::from(reach.abs())))];
        let relative = 1e-5 / plane.normal.z.powi(2);
        let right = plane.z.to_bits() == f64::from(z).to_bits()
            && plane.flagged == (reach < 0.0)
            && off <= half * (1.0 + 1.0 / normal.z)
            && f64::from(results[0][0]) == plane.z
            && (f64::from(results[0][1]) - plane.slope.x).abs() <= relative * plane.slope.length() + 1e-9
            && (f64::from(results[0][2]) - plane.slope.y).abs() <= relative * plane.slope.length() + 1e-9
            && results[0][3] == if reach < 0.0 { 1.0 } else { 0.0 }
            && (f64::from(results[1][0]) - range[0]).abs() <= relative * scale + SLACK
            && (f64::from(results[1][1]) - range[1]).abs() <= relative * scale + SLACK
            && (beside - expected).abs() <= relative * scale + SLACK
            && results[1][3] == 1.0;
        let greatest = (z + reach.abs() * 0.01).min(1.0);
        let is_box = match Node::of(stored[1], SIZE) {
            Node::Box { least, greatest: told, holes } => {
                least == f64::from(z) && (told - f64::from(greatest)).abs() <= SLACK && holes == (reach < 0.0)
            }
            _ => false,
        };
        !(right && is_box)
    };
    (0..given.len()).filter(wrong).count()
}

/// Proves that planes are stored in 8 bytes with their z to the bit, their normal in half precision and the flag in a spare bit,
/// boxes with both z and the word of holes, and that what is read of them is what the host reads. Negative control: another z by an
/// ulp, another slope, another flag are noticed.
#[test]
fn nodes_say_what_was_stored() {
    let gpu = gpu();
    let given = planes();
    let asked = Call {
        entry_point: "encode",
        forest: forest(),
        given: &given,
        words: &[],
        invocations: given.len(),
        results: 2 * given.len(),
        nodes: 2 * given.len(),
    };
    let (found, nodes) = call(&gpu, &asked);
    assert_eq!(misread(&given, &found, &nodes), 0);
    let changed = |change: fn(&mut [f32; 4])| {
        let mut other = given.clone();
        other.iter_mut().for_each(change);
        misread(&other, &found, &nodes)
    };
    assert_eq!(changed(|given| given[0] = given[0].next_up()), given.len());
    assert!(changed(|given| given[1] += 0.1) > given.len() / 2);
    assert_eq!(changed(|given| given[3] = -given[3]), given.len());
}

/// Proves that the highest bit in which two cells differ tells the level of the child of their last common ancestor, for all pairs
/// of a 16 x 16 image, against a walk up.
#[test]
fn levels_are_those_of_a_walk_up() {
    let gpu = gpu();
    let cells: Vec<[u32; 2]> = (0..256).map(|index| [index % 16, index / 16]).collect();
    let mut words = Vec::new();
    let mut expected = Vec::new();
    for first in &cells {
        for second in cells.iter().filter(|second| *second != first) {
            words.extend([*first, *second]);
            let up = |cell: &[u32; 2], levels: u32| cell.map(|place| place >> levels);
            let common = (0..5).find(|levels| up(first, *levels) == up(second, *levels)).unwrap();
            expected.push([common - 1, 0]);
        }
    }
    let count = expected.len();
    let asked = Call {
        entry_point: "tell_levels",
        forest: forest(),
        given: &[],
        words: &words,
        invocations: count,
        results: 0,
        nodes: count,
    };
    let (_, found) = call(&gpu, &asked);
    assert!(found == expected);
    // Negative control: by x alone it is another level for many.
    let by_x = |pair: &[[u32; 2]]| (pair[0][0] ^ pair[1][0]).checked_ilog2();
    assert!(words.chunks(2).zip(&found).filter(|(pair, found)| by_x(pair) != Some(found[0])).count() > count / 4);
}

/// The slope that five z have in their middle: of the side whose two pixels foretell it better, in f64. The side before counts as worse
/// and as steeper by `more`.
fn slope_of(z: [f64; 5], tolerance: f64, more: f64) -> (f64, bool) {
    let side = |near: f64, far: f64| match (near >= 0.0, far >= 0.0) {
        (false, _) => (0.0, 1e30),
        (true, false) => (near - z[2], (near - z[2]).abs()),
        (true, true) => (near - z[2], (far - 2.0 * near + z[2]).abs()),
    };
    let (before, after) = (side(z[1], z[0]), side(z[3], z[4]));
    let before = (before.0, before.1 + more);
    if before.1.min(after.1) <= tolerance {
        return (if before.1 <= after.1 { -before.0 } else { after.0 }, true);
    }
    let first = z[1] >= 0.0 && (z[3] < 0.0 || before.0.abs() + more <= after.0.abs());
    let flatter = if first { -before.0 } else { after.0 };
    if (z[1] >= 0.0 || z[3] >= 0.0) && flatter.abs() <= tolerance { (flatter, true) } else { (0.0, false) }
}

/// Proves that slopes are taken from the side that goes on in one plane: at steps, creases, rims, of thin things, with pixels that
/// show nothing; against f64, and against what is known of each. Negative control: mirrored z have the opposite slope.
#[test]
fn slopes_come_from_the_right_side() {
    let gpu = gpu();
    let none = -1.0;
    let known: [([f64; 5], f64, bool); 8] = [
        // A plane, a step after it, a step before it, a crease.
        ([0.1, 0.2, 0.3, 0.4, 0.5], 0.1, true),
        ([0.1, 0.2, 0.3, 0.9, 0.9], 0.1, true),
        ([0.9, 0.9, 0.3, 0.4, 0.5], 0.1, true),
        ([0.1, 0.2, 0.3, 0.25, 0.2], 0.1, true),
        // A rim, one pixel wide, two pixels wide, alone.
        ([none, none, 0.3, 0.35, 0.4], 0.05, true),
        ([0.8, 0.8, 0.3, 0.8, 0.8], 0.0, false),
        ([0.8, 0.8, 0.3, 0.31, 0.8], 0.01, true),
        ([none, none, 0.3, none, none], 0.0, false),
    ];
    let mut numbers = Numbers::new(153);
    let mut rows: Vec<[f64; 5]> = known.map(|(row, ..)| row).to_vec();
    for _ in 0..400 {
        let (z, step, bend) = (numbers.unit(), numbers.signed() * 0.1, numbers.signed() * 0.02);
        let at = |place: f64| (z + step * place + bend * place * place).clamp(0.0, 1.0);
        let mut row = [-2.0, -1.0, 0.0, 1.0, 2.0].map(at);
        for (place, value) in row.iter_mut().enumerate() {
            match numbers.unit() {
                luck if luck < 0.1 && place != 2 => *value = none,
                luck if luck < 0.2 && place != 2 => *value = numbers.unit(),
                _ => {}
            }
        }
        rows.push(row);
    }
    let tolerance = 0.02_f32;
    let given: Vec<[f32; 4]> = rows
        .iter()
        .map(|row| row.map(|z| z as f32))
        .flat_map(|[a, b, c, d, e]| [[a, b, c, d], [e, tolerance, 0.0, 0.0]])
        .collect();
    let asked = Call {
        entry_point: "find_slopes",
        forest: forest(),
        given: &given,
        words: &[],
        invocations: rows.len(),
        results: rows.len(),
        nodes: 0,
    };
    let (found, _) = call(&gpu, &asked);
    for ((row, slope, goes_on), found) in known.iter().zip(&found) {
        assert!((f64::from(found[0]) - slope).abs() < 1e-6 && (found[1] == 1.0) == *goes_on, "{row:?} {found:?}");
    }
    let mut opposite = 0;
    for (row, found) in rows.iter().zip(&found) {
        let stored = row.map(|z| f64::from(z as f32));
        // Where sides are as good as each other, or a tolerance is met to within rounding, either will do.
        let tolerance = f64::from(tolerance);
        let exact = slope_of(stored, tolerance, 0.0);
        let others = [(1.0 - 1e-5, 0.0), (1.0 + 1e-5, 0.0), (1.0, -1e-6), (1.0, 1e-6)];
        let decided = others.iter().all(|(share, more)| slope_of(stored, tolerance * share, *more) == exact);
        let mirrored = slope_of([4, 3, 2, 1, 0].map(|place: usize| stored[place]), tolerance, 0.0);
        let right = (f64::from(found[0]) - exact.0).abs() < 1e-6 && (found[1] == 1.0) == exact.1;
        assert!(right || !decided, "{row:?}: {found:?}, not {exact:?}");
        let apart = row[3] < 0.0 || (stored[3] - stored[2] - f64::from(found[0])).abs() > tolerance;
        let close = ((stored[3] - stored[2] - f64::from(found[0])).abs() - tolerance).abs() < 1e-6;
        assert!(close || (found[2] == 1.0) == apart, "{row:?}: {found:?}");
        opposite += usize::from((f64::from(found[0]) - mirrored.0).abs() > 1e-3);
    }
    assert!(opposite > 200, "{opposite}");
}
