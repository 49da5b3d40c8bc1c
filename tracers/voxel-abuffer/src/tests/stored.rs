//! What is stored.

use tracebench_api::wgpu::Buffer;

use super::*;
use crate::brute_force::normal_is_noise;
use crate::buffers::{Summed, Taken};
use crate::layout::NORMAL_UNIT;
use crate::structure::check;
use tracebench_api::Update;
use tracebench_api::glam::Vec3;
use tracebench_kit::Built;

fn summed(structure: &Built<VoxelStructure>) -> &Summed {
    structure.buffers.lists.as_ref().unwrap().summed.as_ref().unwrap()
}

const VARIANTS: [&[(&str, &str)]; 10] = [
    &[],
    &[("fit", "box")],
    &[("average_from", "dominant")],
    &[("average", "lines"), ("fit", "box")],
    &[("cancelled_below", "0.5"), ("grid", "7")],
    &[("abuffer", "33"), ("grid", "40")],
    &[("memory_access", "texture")],
    &[("structure", "voxels-only"), ("grid", "50")],
    &[("build", "compute"), ("fit", "box")],
    &[("build", "compute"), ("structure", "voxels-only"), ("grid", "50")],
];

/// What is stored of hostile triangles is what a rasterizer and a voxelizer on the host give, in order, by every shape of the structure;
/// and lists have several layers, voxels several fragments, and copies are found.
#[test]
fn what_is_stored_is_what_the_host_draws() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    for settings in VARIANTS {
        let structure = match try_built(&gpu, &geometry, settings) {
            // In compute lists bind more at once than some drivers allow.
            Err(TracerError::Unavailable(why)) if settings.contains(&("build", "compute")) => {
                assert!(why.contains("storage buffers in a stage"), "{why}");
                continue;
            }
            built => built.unwrap(),
        };
        let statistics = structure.validate_against(&geometry);
        let statistics = statistics.unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        let of = |name: &str| statistics.iter().find(|(each, _)| *each == name).unwrap().1;
        assert!(of("occupied_voxels") > 100.0 && of("occupied_voxels") < of("voxels"), "{settings:?}: {statistics:?}");
        if settings.iter().all(|(name, _)| *name != "structure") {
            let many = of("maximum_layers") >= 5.0 && of("fragments") > 1000.0 && of("copies") > 500.0;
            assert!(many, "{settings:?}: {statistics:?}");
            // Few triangles share a voxel: an average is short in large ones, and where none of a triangle's own axis is in it.
            let is_short = settings.iter().any(|(name, _)| ["cancelled_below", "average_from"].contains(name));
            assert_eq!(of("cancelled_voxels") > 0.0, is_short, "{settings:?}: {statistics:?}");
        }
    }
}

/// Flat scenes, scenes of one triangle and of one point are stored and checked like others, huge and tiny ones, too.
#[test]
fn flat_and_minute_scenes_are_stored() {
    let gpu = gpu();
    let plate = rectangle(DVec3::new(-1.0, -2.0, 3.0), DVec3::X * 4.0, DVec3::Y * 2.0);
    let one = [[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]];
    let point = [[[4.0, 5.0, -6.0]; 3]];
    for triangles in [&plate[..], &one, &point] {
        for scale in [1.0_f32, 1e12, 1e-12] {
            let scaled: Vec<_> =
                triangles.iter().map(|corners| corners.map(|corner| corner.map(|x| x * scale))).collect();
            let geometry = soup(&scaled, Some(&gpu));
            for fit in ["cube", "box"] {
                let structure = built(&gpu, &geometry, &[("fit", fit)]);
                structure.validate_against(&geometry).unwrap_or_else(|error| panic!("{scale} {fit}: {error}"));
            }
        }
    }
}

/// A rebuild over more than there is room for stores what fits, says so, makes room, and then stores what a fresh build does: the same
/// answers.
#[test]
fn a_structure_that_overflows_grows() {
    let gpu = gpu();
    // Of the same bounds, or nothing would be where it was.
    let all = hostile();
    let few = soup(&[&all[..4], &all[all.len() - 100..]].concat(), Some(&gpu));
    let many = soup(&all, Some(&gpu));
    let rays = rays(400);
    let mut structure = built(&gpu, &few, &[]);
    assert!(!structure.grow_on_overflow().unwrap());
    let update = |structure: &mut Built<VoxelStructure>| {
        let mut clock = PhaseClock::new(Some(&gpu));
        structure.update(Update::Rebuild, &many, &viewpoint(), &parameters(&[]), &mut clock).unwrap();
        clock.finish().unwrap();
    };
    let of = |structure: &Built<VoxelStructure>| answer(&gpu, structure, &rays, Query::Closest, &[], TraceTo::Surface);
    update(&mut structure);
    // Before it has grown it is whole as far as it goes.
    of(&structure);
    assert!(structure.validate_against(&many).is_err());
    assert!(structure.grow_on_overflow().unwrap());
    update(&mut structure);
    assert!(!structure.grow_on_overflow().unwrap());
    structure.validate_against(&many).unwrap();
    assert_eq!(of(&structure), of(&built(&gpu, &many, &[])));
    assert_ne!(of(&structure), of(&built(&gpu, &few, &[])));
}

/// What the device cannot bind or draw is an error that says what to turn down: images, the grid, and nodes even one axis at a time.
#[test]
fn too_much_is_refused() {
    let gpu = gpu_that_binds(1 << 19);
    let geometry = soup(&[hostile(), hostile(), hostile()].concat(), Some(&gpu));
    for (settings, remedy) in [
        (&[("abuffer", "16384")][..], "voxel-abuffer.abuffer"),
        (&[("grid", "200")], "voxel-abuffer.grid"),
        (&[("grid", "500"), ("structure", "voxels-only")], "voxel-abuffer.grid"),
        (&[("abuffer", "200"), ("grid", "8")], "voxel-abuffer.abuffer"),
    ] {
        let refused = try_built(&gpu, &geometry, settings).err();
        assert!(
            matches!(&refused, Some(TracerError::TooLarge { hint, .. }) if hint.contains(remedy)),
            "{settings:?}: {refused:?}"
        );
    }
    built(&gpu, &geometry, &[("abuffer", "64")]);
}

/// Lists that are too long for a driver's limit of loops are an error that says so, never answers: twelve thousand plates at a texel are
/// more than Mesa's 65,535 rounds, and other drivers meet the first of them. So is a voxel whose sums do not hold its fragments.
#[test]
fn what_cannot_be_ordered_or_summed_is_an_error() {
    let gpu = gpu();
    let plate = |index: u32| rectangle(DVec3::new(-9e3, -9e3, f64::from(index)), DVec3::X * 18e3, DVec3::Y * 18e3);
    let plates: Vec<[[f32; 3]; 3]> = (0..12_000).flat_map(plate).collect();
    let geometry = soup(&plates, Some(&gpu));
    let settings = [("abuffer", "3")];
    let mut structure = built(&gpu, &geometry, &settings);
    match structure.grow_on_overflow() {
        Ok(grown) => {
            let hits = closest(&gpu, &structure, &[ray(DVec3::new(10.0, 20.0, -50.0), DVec3::Z)], &settings);
            assert!(!grown && (hits[0].t - 50.0).abs() < 2.0, "{hits:?}");
        }
        Err(error) => {
            assert!(error.to_string().contains("fewer surfaces behind one another"), "{error}");
            assert!(structure.validate_against(&geometry).is_err());
        }
    }
    let crowded = check(&Taken { crowded: 1, ..Taken::default() }).unwrap_err();
    assert!(crowded.to_string().contains("turn up voxel-abuffer.grid"), "{crowded}");
    assert!(check(&Taken::default()).is_ok());
}

/// Where one axis has its data in halves, others may need none: plates square to an axis, of which the others see the rims alone.
#[test]
fn an_axis_of_few_fragments_needs_no_second_half() {
    let gpu = gpu();
    let plates: Vec<[[f32; 3]; 3]> = (0..40)
        .flat_map(|index| {
            solid(DVec3::new(-2.0, -2.0, 0.1 * f64::from(index)), DVec3::new(2.0, 2.0, 0.1 * f64::from(index) + 0.02))
        })
        .collect();
    let geometry = soup(&plates, Some(&gpu));
    let capacities = built(&gpu, &geometry, &[]).buffers.lists.clone().unwrap().nodes.capacities;
    assert!(capacities[0] * 2 < capacities[2] && capacities[1] * 2 < capacities[2], "{capacities:?}");
    let small = gpu_that_binds(u64::from(capacities[2]) * 8);
    let of_small = soup(&plates, Some(&small));
    let rays = rays(300);
    let structure = built(&small, &of_small, &[]);
    assert!(structure.buffers.lists.as_ref().unwrap().nodes.has_halves());
    structure.validate_against(&of_small).unwrap();
    let of = |gpu, structure| answer(gpu, structure, &rays, Query::Closest, &[], TraceTo::Surface);
    let found = of(&small, &structure);
    assert!(found == of(&gpu, &built(&gpu, &geometry, &[])) && found.0.iter().any(Hit::is_hit));
}

/// The ledger has the grid, heads, nodes and data by their names, with the bytes that the fragments use.
#[test]
fn memory_is_told_by_parts() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let structure = built(&gpu, &geometry, &[]);
    let fragments = structure.validate_against(&geometry).unwrap();
    let fragments = fragments.iter().find(|(name, _)| *name == "fragments").unwrap().1 as u64;
    let report = structure.memory();
    let used = |name: &str| report.structure.iter().find(|entry| entry.name == name).unwrap().used_bytes;
    assert_eq!([used("nodes"), used("data")], [fragments * 8, fragments * 16]);
    assert_eq!(used("heads"), 3 * 40 * 40 * 4);
    assert_eq!([used("sums of normals, x"), used("fragments of voxels"), used("axes of voxels")], [16384, 16384, 2048]);
    assert_eq!((report.geometry_bytes, report.surface_geometry_bytes), (0, 0));
    let only = built(&gpu, &geometry, &[("structure", "voxels-only"), ("grid", "64")]).memory();
    assert_eq!(only.structure.iter().map(|entry| entry.name.as_str()).collect::<Vec<_>>().len(), 2);
    assert_eq!(only.structure[0].used_bytes, 64 * 64 * 64 / 8);
}

/// Depths out of order, links that lead nowhere, in circles or to another texel, other heads, data, sums, counts, axes and marks of voxels
/// are noticed; and so is another scene.
#[test]
fn a_spoilt_structure_is_noticed() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let aside = hostile().iter().map(|corners| corners.map(|[x, y, z]| [x + 0.1 * y, y, z])).collect::<Vec<_>>();
    let other = soup(&aside, Some(&gpu));
    let read =
        |buffer: &Buffer| -> Vec<u32> { bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size()).unwrap()) };
    let write = |buffer: &Buffer, word: usize, value: u32| {
        gpu.queue.write_buffer(buffer, word as u64 * 4, &value.to_le_bytes());
    };
    let noticed = |settings: &[(&str, &str)], what: &str, spoil: &dyn Fn(&Built<VoxelStructure>)| {
        let structure = built(&gpu, &geometry, settings);
        structure.validate_against(&geometry).unwrap();
        assert!(structure.validate_against(&other).is_err(), "another scene is not noticed");
        spoil(&structure);
        assert!(structure.validate_against(&geometry).is_err(), "{what} is not noticed");
    };
    // The x axis' first list of at least three layers: its texel, and its first two nodes.
    let listed = |structure: &Built<VoxelStructure>| {
        let lists = structure.buffers.lists.as_ref().unwrap();
        let (heads, nodes) = (read(&lists.heads), read(lists.nodes.buffers()[0][0]));
        let next = |link: u32| nodes[(link as usize - 1) * 2 + 1];
        let long = |texel: &usize| heads[*texel] != 0 && next(heads[*texel]) != 0 && next(next(heads[*texel])) != 0;
        let texel = (0..structure.layout.texels() as usize).find(long).unwrap();
        let first = heads[texel];
        (texel, first as usize - 1, next(first) as usize - 1)
    };
    let nodes =
        |structure: &Built<VoxelStructure>| structure.buffers.lists.as_ref().unwrap().nodes.buffers()[0][0].clone();
    noticed(&[], "a depth out of order", &|structure| {
        let (_, _, second) = listed(structure);
        write(&nodes(structure), second * 2, 0.99_f32.to_bits());
    });
    noticed(&[], "a circle", &|structure| {
        let (_, first, second) = listed(structure);
        write(&nodes(structure), second * 2 + 1, first as u32 + 1);
    });
    noticed(&[], "a list cut off", &|structure| {
        let (_, first, _) = listed(structure);
        write(&nodes(structure), first * 2 + 1, 0);
    });
    noticed(&[], "a head that skips a layer", &|structure| {
        let (texel, _, second) = listed(structure);
        write(&structure.buffers.lists.as_ref().unwrap().heads, texel, second as u32 + 1);
    });
    noticed(&[], "the facing of a layer", &|structure| {
        let (_, first, _) = listed(structure);
        let buffer = nodes(structure);
        // Of every layer, as few texels are compared.
        for node in 0..read(&buffer).len() / 2 {
            write(&buffer, node * 2, read(&buffer)[first * 2] ^ 1);
        }
    });
    noticed(&[], "data of others", &|structure| {
        let data = structure.buffers.lists.as_ref().unwrap().nodes.buffers()[1][0].clone();
        gpu.queue.write_buffer(&data, 0, &vec![0x3f; data.size() as usize]);
    });
    let occupied = |structure: &Built<VoxelStructure>| {
        let codes = structure.voxel_codes().unwrap();
        codes.iter().position(|code| (1..=3).contains(code)).unwrap()
    };
    for (settings, what, value) in
        [(&[][..], "a sum of normals", 1 << 20), (&[("average", "lines")], "a sum of lines", 0)]
    {
        noticed(settings, what, &|structure| {
            // Of each, as some lie at voxels' borders.
            let sums = &summed(structure).sums[0];
            let words = vec![value; structure.layout.voxels() as usize];
            gpu.queue.write_buffer(sums, 0, bytemuck::cast_slice::<u32, u8>(&words));
        });
    }
    // Without copies the layers themselves tell the sums.
    let mut unique = hostile();
    unique.truncate(300);
    unique.dedup();
    let unique = soup(&unique, Some(&gpu));
    let structure = built(&gpu, &unique, &[]);
    structure.validate_against(&unique).unwrap();
    for sums in &summed(&structure).sums {
        let doubled: Vec<u32> = read(sums).iter().map(|sum| sum.wrapping_mul(2)).collect();
        gpu.queue.write_buffer(sums, 0, bytemuck::cast_slice(&doubled));
    }
    assert!(structure.validate_against(&unique).unwrap_err().to_string().contains("sums normals"));
    noticed(&[], "a number of fragments", &|structure| {
        let voxel = occupied(structure);
        write(&summed(structure).fragments, voxel, 0);
    });
    for (settings, bits) in [(&[][..], 4), (&[("structure", "voxels-only"), ("grid", "40")], 1)] {
        let per_word = 32 / bits;
        let change = |structure: &Built<VoxelStructure>, voxel: usize, code: u32| {
            let (word, shift) = (voxel / per_word, voxel % per_word * bits);
            let old = read(&structure.buffers.cells)[word];
            let mask = ((1_u64 << bits) - 1) as u32;
            write(&structure.buffers.cells, word, old & !(mask << shift) | code << shift);
        };
        noticed(settings, "a voxel that is not marked", &|structure| {
            // All of them, as few texels are compared.
            (0..read(&structure.buffers.cells).len()).for_each(|word| write(&structure.buffers.cells, word, 0));
        });
        noticed(settings, "a voxel that is marked for nothing", &|structure| {
            // In a corner: the scene is round.
            change(structure, 0, 1);
        });
    }
    noticed(&[], "another axis", &|structure| {
        let (voxel, codes) = (occupied(structure), structure.voxel_codes().unwrap());
        let (word, shift) = (voxel / 8, voxel % 8 * 4);
        let old = read(&structure.buffers.cells)[word];
        write(&structure.buffers.cells, word, old & !(15 << shift) | (codes[voxel] % 3 + 1) << shift);
    });
}

/// Proves that of triangles which are not said to be noise every pair of edges gives the normal within what is allowed, by f32
/// against f64, in cubes that stretch too, and that of slivers both happens: some are told, and their normals differ by more.
#[test]
fn noise_is_told_of_thin_triangles() {
    let scaled = [[1.0; 3], [1.0, 0.02, 3.0]];
    let (mut told, mut beyond, mut trusted) = (0, 0, 0);
    let mut numbers = Numbers::new(11);
    for index in 0..4000 {
        let scaling = scaled[index % 2];
        let [a, b] = [0; 2].map(|_| numbers.point() * 4.0);
        let aside = numbers.point() * 0.1_f64.powi(index as i32 / 2 % 8);
        let corners = [a, b, a + (b - a) * 0.37 + aside].map(|corner| corner.as_vec3());
        let exact = corners.map(|corner| corner.as_dvec3());
        let scale = Vec3::from(scaling);
        let normal = ((exact[1] - exact[0]).cross(exact[2] - exact[0]) / scale.as_dvec3()).normalize_or_zero();
        let off = (0..3)
            .map(|corner| {
                let [before, at, after] = [0, 1, 2].map(|next| corners[(corner + next) % 3]);
                let [first, second] = [at - before, after - at].map(|edge| edge / edge.abs().max_element());
                let across = first.cross(second) / scale;
                ((across / across.abs().max_element()).normalize_or_zero().as_dvec3() - normal).length()
            })
            .fold(0.0, f64::max);
        let most = 0.5 / NORMAL_UNIT;
        if normal_is_noise(scaling, exact, most) {
            told += 1;
            beyond += usize::from(off > most);
        } else {
            trusted += 1;
            assert!(off <= most, "{corners:?} {off}");
        }
    }
    assert!(trusted > 1000 && told > 1000 && beyond > 500, "{trusted} {told} {beyond}");
}
