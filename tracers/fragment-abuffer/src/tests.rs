//! What is stored and found of hostile triangles, the same by every storage, and that the check notices what is wrong.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Gpu, Hit, Parameters, PhaseClock, Query, Ray, Structure, Surface, TraceTo, TracerError, Update, Viewpoint,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, answers, gpu, gpu_that_binds, ray, rectangle as rectangle_of, soup};

use tracebench_shaders::constants;

use super::build::{BAND, MAX_ALONE, WORKGROUP_SIZE};
use super::description;
use super::structure::{FragmentAbuffer, FragmentStructure};

pub(crate) const STORAGES: [&str; 5] = ["s-buffer", "ll", "dll", "llb", "dllb"];
pub(crate) const SKIPS: [&str; 3] = ["skip_bounds", "skip_buckets", "skip_lists"];

/// Sizes that the host knows are those of the shaders.
#[test]
fn constants_are_those_of_the_shaders() {
    for (file, name, expected) in
        [("reorder", "WORKGROUP_SIZE", WORKGROUP_SIZE), ("reorder", "MAX_ALONE", MAX_ALONE), ("boxes", "BAND", BAND)]
    {
        assert_eq!(constants(&format!("fragment-abuffer/{file}.wgsl"), name), [expected].into(), "{name}");
    }
}

/// Round the origin, 40 pixels along a face's edge, a frame of odd edges.
pub(crate) fn viewpoint() -> Viewpoint {
    Viewpoint {
        eye: Vec3::new(0.3, -0.2, 0.1),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.2,
        near: 0.1,
        far: 2e3,
        frame: [63, 41],
        face: 40,
    }
}

pub(crate) fn parameters(settings: &[(&str, &str)]) -> Parameters {
    tracebench_tests::parameters(&description().parameters, settings)
}

pub(crate) fn built_by(
    tracer: &FragmentAbuffer,
    gpu: &Arc<Gpu>,
    geometry: &Geometry,
    settings: &[(&str, &str)],
) -> Built<FragmentStructure> {
    let mut clock = PhaseClock::new(Some(gpu));
    let structure = tracer.build_structure(geometry, &viewpoint(), &parameters(settings), &mut clock).unwrap();
    clock.finish().unwrap();
    structure
}

pub(crate) fn built(gpu: &Arc<Gpu>, geometry: &Geometry, settings: &[(&str, &str)]) -> Built<FragmentStructure> {
    built_by(&FragmentAbuffer::new(Arc::clone(gpu)).unwrap(), gpu, geometry, settings)
}

/// Hits and, where they are asked for, surfaces.
pub(crate) fn answer(
    gpu: &Arc<Gpu>,
    structure: &Built<FragmentStructure>,
    rays: &[Ray],
    settings: &[(&str, &str)],
    trace_to: TraceTo,
) -> (Vec<Hit>, Vec<Surface>) {
    answers(gpu, structure, rays, Query::Closest, &parameters(settings), trace_to)
}

/// Random triangles of many sizes, huge ones, needles, some through and behind the eye, edge-on, without area, before near,
/// along the planes between faces, and copies of equal depth.
pub(crate) fn hostile() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(31);
    let eye = viewpoint().eye.as_dvec3();
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for size in [0.05, 0.5, 5.0, 200.0] {
        for _ in 0..40 {
            let centre = eye + numbers.point() * 6.0;
            let triangle = [0; 3].map(|_| centre + numbers.point() * size);
            triangles.extend([triangle, triangle]);
        }
    }
    for _ in 0..30 {
        let (at, along, other) = (eye + numbers.point() * 3.0, numbers.direction(), numbers.direction());
        triangles.push([at, at + along * 4.0, at + along * 2.0 + other * 1e-3]);
        triangles.push([eye - along, eye + along * 3.0, eye + along + other * 0.3]);
        triangles.push([eye + along, eye + along * 2.0 + other * 0.3, eye + along * 1.5 + other]);
        triangles.push([at, at + along, at + along * 2.0]);
        triangles.push([0; 3].map(|_| eye + numbers.point() * 0.08));
    }
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let aside = axis.any_orthonormal_vector();
        for sign in [-1.0, 1.0] {
            let seam = axis * sign + aside;
            triangles.push([eye + seam, eye + seam * 7.0 + axis, eye + seam * 5.0 - axis]);
            triangles.push([
                eye + axis * sign * 900.0 - aside * 1e3,
                eye + axis * sign * 900.0 + aside * 1e3,
                eye - seam * 800.0,
            ]);
        }
    }
    triangles.into_iter().map(|corners| corners.map(|corner| corner.as_vec3().into())).collect()
}

pub(crate) fn rectangle(corner: DVec3, first: DVec3, second: DVec3) -> [[[f32; 3]; 3]; 2] {
    let [corner, first, second] = [corner, first, second].map(|vector| vector.as_vec3().into());
    rectangle_of(corner, first, second)
}

pub(crate) fn rays(count: usize) -> Vec<Ray> {
    let mut numbers = Numbers::new(4);
    let eye = viewpoint().eye.as_dvec3();
    let any = |index: usize, numbers: &mut Numbers| match index % 4 {
        // From the eye, through its neighbourhood, along axes, from anywhere.
        0 => ray(eye, numbers.direction()),
        1 => ray(eye + numbers.direction() * 3.0, -numbers.direction() * 0.05 + eye.normalize_or_zero()),
        2 => ray(eye + numbers.point() * 4.0, [DVec3::X, DVec3::NEG_Y, DVec3::Z][index % 3]),
        _ => ray(numbers.point() * 5.0, numbers.direction()),
    };
    (0..count).map(|index| any(index, &mut numbers)).collect()
}

/// What is stored of hostile triangles is what a rasterizer on the host draws, in order and linked both ways, by every storage,
/// bounds, views, layers and march, drawn by the device's rasterizer or in compute; and the lists have several layers.
#[test]
fn what_is_stored_is_what_a_rasterizer_draws() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = FragmentAbuffer::new(Arc::clone(&gpu)).unwrap();
    let all = STORAGES.map(|storage| vec![("storage", storage)]).into_iter().chain([
        vec![("storage", "s-buffer"), ("decoupled", "off")],
        vec![("decoupled", "off"), ("buckets", "1")],
        vec![("buckets", "13"), ("bounds", "boxes")],
        vec![("storage", "ll"), ("march", "hi-z"), ("bounds", "boxes")],
        vec![("storage", "dll"), ("layers", "one"), ("views", "six")],
        vec![("views", "frame"), ("march", "hi-z")],
        vec![("centre", "eye")],
        vec![("build", "compute")],
        vec![("build", "compute"), ("storage", "s-buffer"), ("march", "hi-z")],
        vec![("build", "compute"), ("buckets", "13"), ("bounds", "boxes"), ("decoupled", "off")],
        vec![("build", "compute"), ("storage", "dll"), ("layers", "one"), ("views", "six")],
    ]);
    for settings in all {
        let statistics = built_by(&tracer, &gpu, &geometry, &settings).check(&geometry);
        let statistics = statistics.unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        let of = |name: &str| statistics.iter().find(|(each, _)| *each == name).unwrap().1;
        let least = if settings.contains(&("layers", "one")) { 1.0 } else { 5.0 };
        assert!(of("maximum_layers") >= least && of("fragments") > 1000.0, "{settings:?}: {statistics:?}");
    }
}

/// All storages, with data in nodes or beside them, with or without each kind of skipping, with bounds by geometry or by boxes, over one
/// buffer of a kind or one a view, or textures of either, with a ray a lane or several, give the same bits: hits and surfaces, for
/// every march and several thicknesses.
fn every_variant_of(march: &str) {
    let (gpu, small) = (gpu(), gpu_that_binds(600_000));
    let rays = rays(1500);
    let geometries = [&gpu, &small].map(|gpu| soup(&hostile(), Some(gpu)));
    let tracers = [&gpu, &small].map(|gpu| FragmentAbuffer::new(Arc::clone(gpu)).unwrap());
    let mut hits_seen = 0;
    let mut expected: Vec<Option<(Vec<Hit>, Vec<Surface>)>> = vec![None; 3];
    for storage in STORAGES {
        let mut builds = vec![(0, "on", "geometry", "buffer", "1"), (0, "off", "boxes", "texture", "7")];
        // A device that binds little has a buffer a view, which one texture may hold together.
        let memory_access = if march == "pixels" { "texture" } else { "buffer" };
        builds.push((1, "on", "geometry", memory_access, "3"));
        for (device, decoupled, bounds, memory_access, rays_per_lane) in builds {
            let gpu = [&gpu, &small][device];
            let shape = [
                ("storage", storage),
                ("decoupled", decoupled),
                ("bounds", bounds),
                ("march", march),
                ("memory_access", memory_access),
                ("rays_per_lane", rays_per_lane),
            ];
            let structure = built_by(&tracers[device], gpu, &geometries[device], &shape);
            assert_eq!(structure.parts.is_by_view(), device == 1, "{shape:?}");
            structure.check(&geometries[device]).unwrap();
            // Of bounds, buckets and lists none, one or two are not skipped.
            let searches = [
                ("0", ["on on on", "off on on"], "16"),
                ("0.02", ["off off off", "on off on"], "0"),
                ("2", ["on on off", "off on off"], "1000"),
            ];
            for (index, (thickness, skipping, above)) in searches.into_iter().enumerate() {
                let unit = if index == 2 { "pixels" } else { "diagonals" };
                for switches in skipping {
                    let mut settings = shape.to_vec();
                    settings.extend([("thickness", thickness), ("thickness_in", unit)]);
                    settings.extend(SKIPS.into_iter().zip(switches.split(' ')));
                    settings.push(("binary_search_above", above));
                    let found = answer(gpu, &structure, &rays, &settings, TraceTo::Surface);
                    let to_hits = answer(gpu, &structure, &rays, &settings, TraceTo::Hit).0;
                    assert_eq!(to_hits, found.0, "{settings:?}");
                    let expected = expected[index].get_or_insert_with(|| found.clone());
                    let off = found.0.iter().zip(&expected.0).filter(|(a, b)| a != b).count();
                    assert_eq!(off, 0, "{settings:?}");
                    assert!(found.1 == expected.1, "{settings:?}");
                    hits_seen += found.0.iter().filter(|hit| hit.is_hit()).count();
                }
            }
        }
    }
    // Negative control: another thickness does give others.
    assert_ne!(expected[0], expected[1]);
    assert!(hits_seen > 3_000, "{hits_seen}");
}

#[test]
#[ignore = "wider set: as by pixels, in steps, a dozen seconds"]
fn every_variant_gives_the_same_bits_in_steps() {
    every_variant_of("steps");
}

#[test]
fn every_variant_gives_the_same_bits_by_pixels() {
    every_variant_of("pixels");
}

#[test]
#[ignore = "wider set: as by pixels, by the pyramid, a dozen seconds"]
fn every_variant_gives_the_same_bits_by_hi_z() {
    every_variant_of("hi-z");
}

/// What not even a buffer a view holds is an error that says what to turn down.
#[test]
fn too_much_is_refused() {
    let gpu = gpu_that_binds(4096);
    let geometry = soup(&hostile()[..4], Some(&gpu));
    let tracer = FragmentAbuffer::new(Arc::clone(&gpu)).unwrap();
    let mut clock = PhaseClock::new(Some(&gpu));
    let refused = tracer.build_structure(&geometry, &viewpoint(), &parameters(&[]), &mut clock).err();
    assert!(
        matches!(&refused, Some(TracerError::TooLarge { hint, .. }) if hint.contains("--face-size")),
        "{refused:?}"
    );
}

/// A rebuild over more than there is room for stores what fits, says so, makes room, and then stores what a fresh build does:
/// the same answers. By lists and by the s-buffer.
#[test]
fn a_structure_that_overflows_grows() {
    let gpu = gpu();
    let few = soup(&hostile()[..40], Some(&gpu));
    let many = soup(&hostile(), Some(&gpu));
    let rays = rays(400);
    for storage in ["dllb", "s-buffer"] {
        let settings = [("storage", storage)];
        let mut structure = built(&gpu, &few, &settings);
        assert!(!structure.grow_on_overflow().unwrap());
        let update = |structure: &mut Built<FragmentStructure>| {
            let mut clock = PhaseClock::new(Some(&gpu));
            structure.update(Update::Rebuild, &many, &viewpoint(), &parameters(&settings), &mut clock).unwrap();
            clock.finish().unwrap();
        };
        update(&mut structure);
        // Before it has grown it is whole as far as it goes.
        answer(&gpu, &structure, &rays, &settings, TraceTo::Surface);
        assert!(structure.check(&many).is_err());
        assert!(structure.grow_on_overflow().unwrap());
        update(&mut structure);
        assert!(!structure.grow_on_overflow().unwrap());
        structure.check(&many).unwrap();
        let fresh = built(&gpu, &many, &settings);
        let of = |structure| answer(&gpu, structure, &rays, &settings, TraceTo::Surface);
        assert_eq!(of(&structure), of(&fresh), "{storage}");
        assert_ne!(of(&structure), of(&built(&gpu, &few, &settings)));
    }
}

/// Used bytes are those of VVP16's Table 2, with the device's own count of fragments and the 16 bytes that shading needs of each,
/// for all five storages.
#[test]
fn memory_is_that_of_table_2() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let pixels = 63 * 41 + 6 * 40 * 40;
    for (storage, words, per_pixel, per_fragment) in [
        ("s-buffer", "begins and counts", 8, 8),
        ("ll", "heads", 4, 8),
        ("dll", "heads and tails", 8, 12),
        ("llb", "depth bounds and heads", 8 + 4 * 5, 8),
        ("dllb", "depth bounds, heads and tails", 8 + 8 * 5, 12),
    ] {
        let structure = built(&gpu, &geometry, &[("storage", storage), ("buckets", "5")]);
        let fragments =
            structure.check(&geometry).unwrap().iter().find(|(name, _)| *name == "fragments").unwrap().1 as u64;
        let report = structure.memory();
        let used = |name: &str| report.structure.iter().find(|entry| entry.name == name).unwrap().used_bytes;
        assert_eq!(used(words), pixels * per_pixel, "{storage}");
        assert_eq!(used("id buffer") + used("data buffer"), fragments * (per_fragment + 16), "{storage}");
        assert_eq!((report.geometry_bytes, report.surface_geometry_bytes), (0, 0));
        // With data in the nodes the same is stored, but for the s-buffer's index of it.
        let coupled = built(&gpu, &geometry, &[("storage", storage), ("buckets", "5"), ("decoupled", "off")]).memory();
        let ids = coupled.structure.iter().find(|entry| entry.name == "id buffer").unwrap().used_bytes;
        let saved = if storage == "s-buffer" { 4 } else { 0 };
        assert_eq!(ids, fragments * (per_fragment + 16 - saved), "{storage}");
    }
}

/// Depths out of order, links that lead nowhere, in circles or to another pixel, tails, bounds and payloads that are off are
/// noticed, by lists and by the s-buffer.
#[test]
fn a_spoilt_structure_is_noticed() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = FragmentAbuffer::new(Arc::clone(&gpu)).unwrap();
    let aside = hostile().iter().map(|corners| corners.map(|[x, y, z]| [x + 0.5, y, z])).collect::<Vec<_>>();
    let other = soup(&aside, Some(&gpu));
    let spoils = |settings: &[(&str, &str)], what: &str, spoil: &dyn Fn(&Built<FragmentStructure>)| {
        let structure = built_by(&tracer, &gpu, &geometry, settings);
        structure.check(&geometry).unwrap();
        assert!(structure.check(&other).is_err(), "another scene is not noticed");
        spoil(&structure);
        assert!(structure.check(&geometry).is_err(), "{what} is not noticed");
    };
    let write = |buffer: &tracebench_api::wgpu::Buffer, word: usize, value: u32| {
        gpu.queue.write_buffer(buffer, word as u64 * 4, &value.to_le_bytes());
    };
    // A list of at least three fragments, its first two nodes.
    let listed = |structure: &Built<FragmentStructure>| {
        let part = &structure.parts.parts[0];
        let read = |buffer: &tracebench_api::wgpu::Buffer| -> Vec<u32> {
            bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size()).unwrap())
        };
        let (pixels, ids) = (read(&part.pixels), read(&part.ids));
        let next = |link: u32| ids[(link as usize - 1) * 3 + 1];
        let long = |word: &usize| pixels[*word] != 0 && next(pixels[*word]) != 0 && next(next(pixels[*word])) != 0;
        // Heads of the first bucket.
        let pixel = (0..part.pixel_count as usize).find(long).unwrap();
        let first = pixels[pixel] - 1;
        (pixel, first as usize, next(first + 1) as usize - 1)
    };
    // Of a pixel, in images one behind the other.
    let word = |structure: &Built<FragmentStructure>, pixel: usize, word: usize| {
        pixel + word * structure.parts.parts[0].pixel_count as usize
    };
    let dllb: &[(&str, &str)] = &[];
    spoils(dllb, "a depth out of order", &|structure| {
        let (_, _, second) = listed(structure);
        write(&structure.parts.parts[0].ids, second * 3, 1e9_f32.to_bits());
    });
    spoils(dllb, "a circle", &|structure| {
        let (_, first, second) = listed(structure);
        write(&structure.parts.parts[0].ids, second * 3 + 1, first as u32 + 1);
    });
    spoils(dllb, "a list cut off", &|structure| {
        let (_, first, _) = listed(structure);
        write(&structure.parts.parts[0].ids, first * 3 + 1, 0);
    });
    spoils(dllb, "a previous link", &|structure| {
        let (_, _, second) = listed(structure);
        write(&structure.parts.parts[0].ids, second * 3 + 2, 0);
    });
    spoils(dllb, "a tail", &|structure| {
        let (pixel, first, _) = listed(structure);
        write(&structure.parts.parts[0].pixels, word(structure, pixel, 4), first as u32 + 1);
    });
    spoils(dllb, "a near bound", &|structure| {
        let (pixel, _, _) = listed(structure);
        write(&structure.parts.parts[0].pixels, word(structure, pixel, 8), !1e-6_f32.to_bits());
    });
    spoils(&[("storage", "s-buffer")], "pieces that overlap", &|structure| {
        let part = &structure.parts.parts[0];
        let begins: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&part.pixels, part.pixels.size()).unwrap());
        let pixel = begins.iter().position(|begin| *begin > 4).unwrap();
        write(&part.pixels, pixel, begins[pixel] - 1);
    });
    spoils(&[("storage", "ll")], "payloads of others", &|structure| {
        let part = &structure.parts.parts[0];
        let payloads = part.payloads.as_ref().unwrap();
        for word in 0..payloads.size() as usize / 4 {
            write(payloads, word, 0x3f00_0000);
        }
    });
}
