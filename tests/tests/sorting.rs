//! Prefix sums and the radix sort of kit, against std's.

use std::time::Instant;

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, PhaseClock};
use tracebench_kit::{PrefixSum, PrefixSumPlan, RadixSort, RadixSortPlan};
use tracebench_tests::{Numbers, gpu};

const USAGE: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_SRC);

fn upload(gpu: &Gpu, values: &[u32]) -> Buffer {
    gpu.buffer_with("values", bytemuck::cast_slice(values), USAGE, "nothing").unwrap()
}

fn download(gpu: &Gpu, buffer: &Buffer, count: usize) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&gpu.read(buffer, count as u64 * 4).unwrap())
}

/// Bits from all over the word.
fn random(count: usize, seed: u64) -> Vec<u32> {
    let mut numbers = Numbers::new(seed);
    (0..count).map(|_| (numbers.unit() * 4_294_967_296.0) as u32).collect()
}

/// Lengths round the borders of runs, lanes, blocks and blocks of blocks.
const LENGTHS: [usize; 24] = [
    0, 1, 2, 15, 16, 17, 31, 32, 33, 255, 256, 257, 1023, 1024, 1025, 4095, 4096, 4097, 8192, 65_535, 65_536, 65_537,
    262_145, 1_048_577,
];

/// Prefix sums by the device, with the plan that made them.
fn device_sums(
    gpu: &Gpu,
    sums: &PrefixSum,
    values: &[u32],
    there: Option<&PrefixSumPlan>,
) -> (Vec<u32>, PrefixSumPlan) {
    let buffer = upload(gpu, values);
    let plan = sums.plan(gpu, &buffer, values.len() as u32, there).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    sums.record(&mut encoder, &plan);
    gpu.queue.submit([encoder.finish()]);
    (download(gpu, &buffer, values.len()), plan)
}

fn expected_sums(values: &[u32]) -> Vec<u32> {
    let step = |sum: &mut u32, value: &u32| {
        let before = *sum;
        *sum = sum.wrapping_add(*value);
        Some(before)
    };
    values.iter().scan(0, step).collect()
}

/// Proves that prefix sums are those of std, wrapped, at every length and for random, constant and rising values, and that
/// a plan's buffers serve another plan.
#[test]
fn prefix_sums_are_those_of_std() {
    let gpu = gpu();
    let sums = PrefixSum::new(&gpu).unwrap();
    let mut there = None;
    for count in LENGTHS {
        for values in [random(count, 71), vec![1; count], (0..count as u32).collect()] {
            let (found, plan) = device_sums(&gpu, &sums, &values, there.as_ref());
            assert!(found == expected_sums(&values), "{count} values");
            there = Some(plan);
        }
    }
}

/// Keys and payloads as the device sorts them.
fn device_sort(
    gpu: &Gpu,
    sort: &RadixSort,
    keys: &[u32],
    key_bits: u32,
    there: Option<&RadixSortPlan>,
) -> (Vec<(u32, u32)>, RadixSortPlan) {
    let payloads: Vec<u32> = (0..keys.len() as u32).map(|index| index ^ 0xa5a5_0000).collect();
    let buffers = [upload(gpu, keys), upload(gpu, &payloads)];
    let plan = sort.plan(gpu, &buffers[0], &buffers[1], keys.len() as u32, key_bits, there).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    sort.record(&mut encoder, &plan);
    gpu.queue.submit([encoder.finish()]);
    let [keys, payloads] = buffers.map(|buffer| download(gpu, &buffer, keys.len()));
    (keys.into_iter().zip(payloads).collect(), plan)
}

/// Whether pairs are the stable order of keys whose payloads are their numbers.
fn is_stable_order(found: &[(u32, u32)], keys: &[u32]) -> bool {
    let mut expected: Vec<(u32, u32)> = keys.iter().copied().zip((0..).map(|index: u32| index ^ 0xa5a5_0000)).collect();
    expected.sort_by_key(|(key, _)| *key);
    found == expected
}

/// Keys of one kind: random, few, constant, sorted, reversed.
fn kinds(count: usize) -> Vec<Vec<u32>> {
    let mut sorted = random(count, 73);
    sorted.sort_unstable();
    vec![
        random(count, 72),
        random(count, 74).into_iter().map(|key| key >> 30 << 29).collect(),
        vec![u32::MAX; count],
        sorted.iter().rev().copied().collect(),
        sorted,
    ]
}

/// Proves that the sort is std's stable one at every length and for every kind of keys, and that a plan's buffers serve
/// another plan.
#[test]
fn sorts_are_those_of_std() {
    let gpu = gpu();
    let sort = RadixSort::new(&gpu).unwrap();
    let mut there = None;
    for count in LENGTHS {
        for (kind, keys) in kinds(count).into_iter().enumerate() {
            let (found, plan) = device_sort(&gpu, &sort, &keys, 32, there.as_ref());
            assert!(is_stable_order(&found, &keys), "{count} keys of kind {kind}");
            there = Some(plan);
        }
    }
}

/// Proves that keys of fewer bits are sorted by all that they have, whether these fill digits and passes or not.
#[test]
fn short_keys_are_sorted() {
    let gpu = gpu();
    let sort = RadixSort::new(&gpu).unwrap();
    for bits in [1, 7, 8, 9, 16, 17, 24, 25, 30, 31] {
        let keys: Vec<u32> = random(5000, 75).into_iter().map(|key| key >> (32 - bits)).collect();
        let (found, _) = device_sort(&gpu, &sort, &keys, bits, None);
        assert!(is_stable_order(&found, &keys), "{bits} bits");
    }
    let buffer = upload(&gpu, &[0]);
    assert!(sort.plan(&gpu, &buffer, &buffer, 1, 33, None).unwrap_err().to_string().contains("33"));
}

/// Negative control: two keys out of order, equal keys in another order, a pair that is lost, and one wrong sum are each
/// noticed.
#[test]
fn wrong_orders_are_noticed() {
    let gpu = gpu();
    let sort = RadixSort::new(&gpu).unwrap();
    let mut keys = random(3000, 76);
    keys[40] = keys[2000];
    let (found, _) = device_sort(&gpu, &sort, &keys, 32, None);
    assert!(is_stable_order(&found, &keys));
    let equal = found.windows(2).position(|pair| pair[0].0 == pair[1].0).unwrap();
    for spoil in [
        &(|found: &mut Vec<(u32, u32)>| found.swap(7, 8)) as &dyn Fn(&mut Vec<(u32, u32)>),
        &|found| found.swap(equal, equal + 1),
        &|found| found[9] = found[8],
    ] {
        let mut spoilt = found.clone();
        spoil(&mut spoilt);
        assert!(!is_stable_order(&spoilt, &keys));
    }
    let (mut found, _) = device_sums(&gpu, &PrefixSum::new(&gpu).unwrap(), &keys, None);
    assert!(found == expected_sums(&keys));
    found[2999] ^= 1;
    assert!(found != expected_sums(&keys));
}

/// Times of one recording, milliseconds: the least of a few, by the device's clock where it has one.
fn fastest(gpu: &Gpu, record: impl Fn(&mut tracebench_api::wgpu::CommandEncoder)) -> f64 {
    let once = |_| {
        let mut clock = PhaseClock::new(Some(gpu));
        clock.device_phase("work", |encoder| record(encoder)).unwrap();
        clock.finish().unwrap().total_ms
    };
    (0..4).map(once).fold(f64::INFINITY, f64::min)
}

/// Sorts and sums `count` elements and prints how fast; the work is done anew on what the last one left.
fn large(count: usize) {
    let gpu = gpu();
    let (sort, sums) = (RadixSort::new(&gpu).unwrap(), PrefixSum::new(&gpu).unwrap());
    let start = Instant::now();
    let keys = random(count, 77);
    let (found, plan) = device_sort(&gpu, &sort, &keys, 32, None);
    assert!(is_stable_order(&found, &keys));
    drop(found);
    let (found, sums_plan) = device_sums(&gpu, &sums, &keys, None);
    assert!(found == expected_sums(&keys));
    let sort_ms = fastest(&gpu, |encoder| sort.record(encoder, &plan));
    let sums_ms = fastest(&gpu, |encoder| sums.record(encoder, &sums_plan));
    println!(
        "{count} elements: sort {sort_ms:.2} ms ({:.1} M keys/s), prefix sums {sums_ms:.2} ms ({:.1} M/s), all {:.1} s",
        count as f64 / sort_ms * 1e-3,
        count as f64 / sums_ms * 1e-3,
        start.elapsed().as_secs_f64()
    );
}

/// Proves that millions are sorted and summed.
#[test]
fn millions_are_sorted() {
    large(3_000_017);
}

/// Proves that as much is sorted and summed as a software adapter can bind, 128 MiB a buffer.
#[test]
#[ignore = "wider set: half a minute on a software adapter"]
fn as_much_as_can_be_bound_is_sorted() {
    large(32 << 20);
}

/// Proves that one element more than the device can bind is refused by name.
#[test]
fn more_than_can_be_bound_is_refused() {
    let gpu = gpu();
    let sort = RadixSort::new(&gpu).unwrap();
    let buffer = upload(&gpu, &[0]);
    let most = (gpu.limits.max_storage_buffer_binding_size / 4) as u32;
    let error = sort.plan(&gpu, &buffer, &buffer, most + 1, 32, None).unwrap_err().to_string();
    assert!(error.contains("sort: other keys") && error.contains("turn down"), "{error}");
}
