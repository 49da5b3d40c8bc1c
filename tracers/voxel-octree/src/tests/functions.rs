//! Functions of the shaders alone, against f64 and the host's own.

use super::*;
use crate::reference::CellPosition;
use crate::validate::unpacked_normal;
use tracebench_api::wgpu::BufferUsages;
use tracebench_kit::{bind_group_at, compute_pipeline, dispatch_linear};
use tracebench_shaders::test::OCTREE_FUNCTIONS;

/// What an entry point makes of some vectors of four words.
fn run(gpu: &Gpu, entry_point: &str, bindings: [u32; 2], given: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let pipeline = compute_pipeline(gpu, OCTREE_FUNCTIONS, entry_point).unwrap();
    let bytes = bytemuck::cast_slice(given);
    let input = gpu.buffer_with("given", bytes, BufferUsages::STORAGE, "nothing").unwrap();
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let output = gpu.buffer("made", bytes.len() as u64, usage, "nothing").unwrap();
    let bound = [(bindings[0], input.as_entire_binding()), (bindings[1], output.as_entire_binding())];
    let group = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &group, given.len() as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&gpu.read(&output, output.size()).unwrap())
}

/// Normals come back from their words to what 16 bits an axis tell apart, the axes' and their diagonals among them, as the host unpacks
/// them; a word of a neighbour is noticed.
#[test]
fn normals_come_back_from_words() {
    let mut numbers = Numbers::new(5);
    let signs = [-1.0, 0.0, 1.0];
    let special =
        signs.into_iter().flat_map(|x| signs.into_iter().flat_map(move |y| signs.map(|z| DVec3::new(x, y, z))));
    let special = special.filter(|normal| *normal != DVec3::ZERO).map(DVec3::normalize);
    let normals: Vec<DVec3> = special.chain((0..2000).map(|_| numbers.direction())).collect();
    let given: Vec<[u32; 4]> =
        normals.iter().map(|normal| normal.as_vec3().extend(0.0).to_array().map(f32::to_bits)).collect();
    let off = |normal: DVec3, [word, x, y, z]: [u32; 4]| {
        let back = Vec3::from([x, y, z].map(f32::from_bits)).as_dvec3();
        (back - normal).length().max((unpacked_normal(word) - normal).length())
    };
    let found = run(&gpu(), "pack_normals", [0, 2], &given);
    for (normal, found) in normals.iter().zip(&found) {
        assert!(off(*normal, *found) < 6e-5, "{normal} {found:?}");
    }
    let [word, rest @ ..] = found[100];
    assert!(off(normals[100], [word + 4, rest[0], rest[1], rest[2]]) > 6e-5);
}

/// Keys have the bits of x, y and z in turn, parts those of one level: as the host places them.
#[test]
fn voxels_are_placed_along_the_curve() {
    let mut numbers = Numbers::new(6);
    let mut at = || (numbers.unit() * 1024.0) as u32;
    let mut given: Vec<[u32; 4]> = (0..2000).map(|_| [at(), at(), at(), 0]).collect();
    given.extend([[0; 4], [1023, 1023, 1023, 0], [1, 0, 0, 0], [0, 512, 0, 0], [0, 0, 1023, 0]]);
    for ([x, y, z, _], [key, one, two, most]) in given.iter().zip(run(&gpu(), "place_voxels", [1, 3], &given)) {
        assert_eq!(CellPosition { depth: 10, key }.cell(), [*x, *y, *z]);
        assert_eq!([one, two, most], [key & 7, key >> 3 & 7, key >> 27]);
    }
}
