//! Pyramids and buckets.

use tracebench_api::wgpu::BufferUsages;
use tracebench_kit::{bind_group_at, compute_pipeline, dispatch_linear};
use tracebench_shaders::test::PYRAMID_FUNCTIONS;
use tracebench_tests::{Numbers, gpu};

fn run(entry_point: &str, input: (u32, &[u8]), invocations: usize, output: (u32, usize)) -> Vec<u8> {
    let gpu = gpu();
    let pipeline = compute_pipeline(&gpu, PYRAMID_FUNCTIONS, entry_point).unwrap();
    let given = gpu.buffer_with("input", input.1, BufferUsages::STORAGE, "nothing").unwrap();
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let found = gpu.buffer("output", output.1 as u64, usage, "nothing").unwrap();
    let resources = [(input.0, given.as_entire_binding()), (output.0, found.as_entire_binding())];
    let bindings = bind_group_at(&gpu, &pipeline.get_bind_group_layout(0), &resources);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &bindings, invocations as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&found, output.1 as u64).unwrap()
}

/// Images of many shapes: width, height, levels of their pyramids.
fn images() -> Vec<[u32; 3]> {
    let sizes = [[1, 1], [2, 2], [3, 1], [1, 7], [8, 8], [9, 8], [13, 5], [16, 31], [33, 17], [64, 1]];
    let levels = |[width, height]: [u32; 2]| width.max(height).next_power_of_two().trailing_zeros() + 1;
    sizes.map(|size| [size[0], size[1], levels(size)]).to_vec()
}

/// What the device writes of every image, of which there are `numbers` each.
fn of_images(entry_point: &str, numbers: impl Fn(&[u32; 3]) -> u32) -> Vec<Vec<u32>> {
    let (mut given, mut begin) = (Vec::new(), 0);
    for image in images() {
        given.push([image[0], image[1], image[2], begin]);
        begin += numbers(&image);
    }
    let found = run(entry_point, (0, bytemuck::cast_slice(&given)), given.len(), (1, begin as usize * 4));
    let found: Vec<u32> = bytemuck::pod_collect_to_vec(&found);
    let of = |(image, given): (&[u32; 3], &[u32; 4])| {
        let begin = given[3] as usize;
        found[begin..begin + numbers(image) as usize].to_vec()
    };
    images().iter().zip(&given).map(of).collect()
}

/// The pixels below a cell, the first quarter's first.
fn below(image: &[u32; 3], level: u32, [x, y]: [u32; 2], found: &mut Vec<u32>) {
    if x << level >= image[0] || y << level >= image[1] {
        return;
    }
    if level == 0 {
        found.push(y * image[0] + x);
        return;
    }
    for child in 0..4 {
        below(image, level - 1, [2 * x + child % 2, 2 * y + child / 2], found);
    }
}

/// Proves that a walk down a pyramid meets every pixel once, quarter by quarter.
#[test]
fn a_walk_down_meets_every_pixel() {
    let found = of_images("descend", |image| image[0] * image[1]);
    for (image, found) in images().iter().zip(found) {
        let mut expected = Vec::new();
        below(image, image[2] - 1, [0, 0], &mut expected);
        assert_eq!(expected.len() as u32, image[0] * image[1]);
        assert_eq!(found, expected, "{image:?}");
        // Negative control: row by row is another order, where there are rows.
        let by_row: Vec<u32> = (0..image[0] * image[1]).collect();
        assert_eq!(found == by_row, image[0].min(image[1]) == 1 || image[0].max(image[1]) == 2, "{image:?}");
    }
}

/// Proves that the four cells below a cell are those that lie there, the last ones again where there are fewer.
#[test]
fn cells_have_those_below() {
    let size = |image: &[u32; 3], level: u32| [image[0].div_ceil(1 << level), image[1].div_ceil(1 << level)];
    let count = |image: &[u32; 3]| (1..image[2]).map(|level| size(image, level).iter().product::<u32>()).sum::<u32>();
    let found = of_images("gather_below", |image| count(image).max(1));
    for (image, found) in images().iter().zip(found) {
        let mut expected = Vec::new();
        for level in 1..image[2] {
            let ([width, height], [width_below, height_below]) = (size(image, level), size(image, level - 1));
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let child = |child: u32| {
                    let (x, y) = ((2 * x + child % 2).min(width_below - 1), (2 * y + child / 2).min(height_below - 1));
                    y * width_below + x
                };
                expected.push((0..4).fold(0_u32, |sum, each| sum.wrapping_mul(4099).wrapping_add(child(each))));
            }
        }
        assert_eq!(&found[..expected.len()], expected, "{image:?}");
    }
}

/// Depths with bounds and a number of buckets: on the bounds, between and beyond, in bounds without a range, in ranges of an ulp, in
/// none at all.
fn depths() -> Vec<[f32; 4]> {
    let mut numbers = Numbers::new(63);
    let mut depths = Vec::new();
    for exponent in -30..30 {
        let near = 10_f32.powi(exponent);
        for range in [0.0, f32::EPSILON, 1e-3, 1.0, 1e5] {
            let far = near * (1.0 + range);
            for buckets in [1.0, 4.0, 24.0, 64.0] {
                let within = near + (far - near) * numbers.unit() as f32;
                for depth in [near, far, within, near.midpoint(far), near * 0.5, far * 2.0] {
                    depths.push([depth, near, far, buckets]);
                }
            }
        }
        depths.push([near, 2.0 * near, near, 8.0]);
    }
    depths
}

/// Depths that are not sorted as f64 does. A share is rounded by a few half ulps of itself and of the depths over the range.
fn misplaced(given: &[[f32; 4]], found: &[[f32; 4]]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (given, found) in given.iter().zip(found) {
        let [depth, near, far, buckets] = given.map(f64::from);
        let [near_read, far_read, share, bucket] = *found;
        let empty = near > far;
        let read = if empty { [1e38, -1e38] } else { [given[1], given[2]] };
        let expected = if far > near { ((depth - near) / (far - near)).clamp(0.0, 1.0) } else { 0.0 };
        let slack = 8.0 * f64::from(f32::EPSILON);
        let places = [expected - slack, expected + slack].map(|at| (at * buckets).floor().clamp(0.0, buckets - 1.0));
        let right = [near_read, far_read] == read
            && (f64::from(share) - expected).abs() <= slack
            && (places[0]..=places[1]).contains(&f64::from(bucket));
        if !right {
            wrong.push(format!("{given:?}: {found:?}, not {read:?} {expected} {places:?}"));
        }
    }
    wrong
}

/// Proves that depth bounds come back from their codes to the bit, and that shares and buckets of depths are f64's. Negative
/// control: a bucket further, and bounds an ulp off, are noticed.
#[test]
fn buckets_are_those_of_f64() {
    let given = depths();
    let bytes = given.len() * 16;
    let found = run("sort_depths", (2, bytemuck::cast_slice(&given)), given.len(), (3, bytes));
    let found: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&found);
    let wrong = misplaced(&given, &found);
    assert!(wrong.is_empty(), "{} of {}: {}", wrong.len(), given.len(), wrong[0]);
    let further: Vec<_> = found.iter().map(|[near, far, share, bucket]| [*near, *far, *share, bucket + 1.0]).collect();
    assert!(misplaced(&given, &further).len() > given.len() / 2);
    let off = |[near, far, share, bucket]: &[f32; 4]| [near.next_up(), *far, *share, *bucket];
    assert_eq!(misplaced(&given, &found.iter().map(off).collect::<Vec<_>>()).len(), given.len());
}
