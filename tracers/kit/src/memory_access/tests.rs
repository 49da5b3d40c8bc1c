//! Arrays are read where they are, by host and shader.

use super::*;
use crate::{compute_pipeline, dispatch_linear_groups};
use tracebench_api::AdapterChoice;
use tracebench_shaders::test::ReadsFunctions;

const SLOTS: [ReadSlot; 3] = [ReadSlot::Quads1, ReadSlot::Pairs1, ReadSlot::Words3];

/// What the shader finds at every record of three arrays, written by the host or left by a build.
fn found(gpu: &Gpu, memory_access: MemoryAccess, count: usize, built: bool) -> Vec<[u32; 8]> {
    let pipeline =
        compute_pipeline(gpu, ReadsFunctions { textures: memory_access == MemoryAccess::Texture }, "look_up").unwrap();
    let array = |slot: ReadSlot| {
        let words: Vec<u32> = (0..count as u32 * slot.record_bytes() / 4).map(|word| word * 3 + slot as u32).collect();
        let contents: &[u8] = bytemuck::cast_slice(&words);
        if !built {
            return Readable::written(gpu, memory_access, slot, contents, "written", None, "nothing").unwrap();
        }
        let buffer = storage_buffer(gpu, "built", contents.len() as u64, "nothing").unwrap();
        gpu.queue.write_buffer(&buffer, 0, contents);
        Readable::built(gpu, memory_access, slot, &buffer, contents.len() as u64, "copied", None, "nothing").unwrap()
    };
    let arrays = SLOTS.map(array);
    let mut clock = PhaseClock::new(Some(gpu));
    record_copies(&arrays, &mut clock).unwrap();
    // A clock without phases has nothing to finish.
    assert_eq!(clock.finish().is_ok(), built && memory_access == MemoryAccess::Texture);
    let results = storage_buffer(gpu, "found", count as u64 * 32, "nothing").unwrap();
    let own = crate::bind_group(gpu, &pipeline.get_bind_group_layout(0), &[results.as_entire_binding()]);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let bound = bind_arrays(gpu, &pipeline, &arrays);
    dispatch_linear_groups(&mut encoder, &pipeline, &[&own, &bound], count as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&gpu.read(&results, results.size()).unwrap())
}

/// Proves that records of every size are read where they are, from buffers and textures, written and copied, of less than a row,
/// of whole rows and of some more: rows of quads, pairs and words end at 2048, 4096 and 8192.
#[test]
fn records_are_read_where_they_are() {
    let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
    for count in [1, 2048, 2049, 4097, 8192, 16_391] {
        let of = |record: u32, words: u32, slot: ReadSlot, word: u32| (record * words + word) * 3 + slot as u32;
        let expected = |record: u32| {
            let [quads, pairs, words] = SLOTS;
            let quad: [u32; 4] = std::array::from_fn(|word| of(record, 4, quads, word as u32));
            let pair = [of(record, 2, pairs, 0), of(record, 2, pairs, 1)];
            [quad[0], quad[1], quad[2], quad[3], pair[0], pair[1], of(record, 1, words, 0), 0]
        };
        let expected: Vec<[u32; 8]> = (0..count as u32).map(expected).collect();
        for memory_access in [MemoryAccess::Buffer, MemoryAccess::Texture] {
            for built in [false, true] {
                assert!(found(&gpu, memory_access, count, built) == expected, "{memory_access:?} {count} {built}");
            }
        }
    }
}

/// Proves that each of several buffers in one texture is where its first record is said to be, whether it ends within a row or with
/// it; the array is the same in another slot.
#[test]
fn buffers_are_joined_by_rows() {
    let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
    let contents = [5_usize, 8192, 8193, 3]
        .map(|count| -> Vec<u32> { (0..count as u32).map(|word| word * 7 + count as u32).collect() });
    let buffers = contents.each_ref().map(|words| {
        let buffer = storage_buffer(&gpu, "built", words.len() as u64 * 4, "nothing").unwrap();
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words));
        buffer
    });
    let sources = buffers.each_ref().map(|buffer| (buffer, buffer.size()));
    let joined = Readable::joined(&gpu, ReadSlot::Words0, &sources, "joined", None, "nothing").unwrap();
    let mut clock = PhaseClock::new(Some(&gpu));
    record_copies(std::slice::from_ref(&joined), &mut clock).unwrap();
    clock.finish().unwrap();
    let first = ReadSlot::Words0.first_records(sources.map(|(_, bytes)| bytes));
    assert_eq!(first, [0, 8192, 2 * 8192, 4 * 8192]);
    for array in [&joined, &joined.at(ReadSlot::Words3)] {
        let read: Vec<u32> = bytemuck::pod_collect_to_vec(&array.read(&gpu).unwrap());
        assert_eq!(read.len(), 4 * 8192 + 3);
        for (first, words) in first.iter().zip(&contents) {
            assert_eq!(&read[*first as usize..][..words.len()], words);
        }
    }
}

/// Proves that a texture is kept where it has room, that a larger one takes its place, and that what is used is told.
#[test]
fn textures_are_kept_where_they_have_room() {
    let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
    let write = |bytes: usize, there: Option<&Readable>| {
        let contents = vec![7; bytes];
        Readable::written(&gpu, MemoryAccess::Texture, ReadSlot::Words0, &contents, "words", there, "nothing").unwrap()
    };
    let view = |array: &Readable| array.texels().unwrap().view.clone();
    let first = write(100_000, None);
    let smaller = write(400, Some(&first));
    assert!(view(&smaller) == view(&first) && smaller.used() == 400);
    assert_eq!(smaller.read(&gpu).unwrap(), vec![7; 400]);
    let larger = write(200_000, Some(&first));
    assert!(view(&larger) != view(&first) && larger.used() == 200_000);
    // Another name is another array.
    let other =
        Readable::written(&gpu, MemoryAccess::Texture, ReadSlot::Words1, &[7; 4], "words", Some(&first), "nothing");
    assert!(view(&other.unwrap()) != view(&first));
}
