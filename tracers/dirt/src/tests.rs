//! What is stored of hostile triangles against brute force, and that the check notices what is wrong.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{
    AdapterChoice, Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Query, Ray, RayBuffer, Residency, Structure,
    TraceJob, TraceTo, TracerError, Update, Viewpoint,
};
use tracebench_kit::{Built, DeviceTracer, MemoryAccess};
use tracebench_tests::{Numbers, answers, gpu, gpu_that_binds, ray, soup};

use super::build::NODE_BYTES;
use super::description;
use super::structure::{Dirt, DirtStructure};

/// Round the origin, near a tenth, 48 pixels along a face's edge, a frame of odd edges.
pub(crate) fn viewpoint() -> Viewpoint {
    Viewpoint {
        eye: Vec3::new(0.3, -0.2, 0.1),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.2,
        near: 0.1,
        far: 5e3,
        frame: [63, 41],
        face: 48,
    }
}

pub(crate) fn parameters(settings: &[(&str, &str)]) -> Parameters {
    tracebench_tests::parameters(&description().parameters, settings)
}

pub(crate) fn built(gpu: &Arc<Gpu>, geometry: &Geometry, settings: &[(&str, &str)]) -> Built<DirtStructure> {
    let tracer = DeviceTracer::<DirtStructure>::new(Arc::clone(gpu)).unwrap();
    let mut clock = PhaseClock::new(Some(gpu));
    let structure = tracer.build_structure(geometry, &viewpoint(), &parameters(settings), &mut clock).unwrap();
    clock.finish().unwrap();
    structure
}

/// Triangles that are hard to store: random ones of every size, huge ones, needles, some through and behind the eye,
/// across the borders and edges of faces, edge-on, without area, with corners and edges on tile borders, in the planes
/// between faces, and before near.
pub(crate) fn hostile() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(20);
    let eye = viewpoint().eye.as_dvec3();
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for size in [1e-3, 0.05, 0.5, 5.0, 300.0] {
        for _ in 0..60 {
            let centre = eye + numbers.point() * 6.0;
            triangles.push([0; 3].map(|_| centre + numbers.point() * size));
        }
    }
    for _ in 0..60 {
        let (from, along) = (eye + numbers.point() * 3.0, numbers.direction());
        // Needles, some of them through the eye.
        let aside = numbers.direction() * 1e-4;
        triangles.push([from, from + along * 4.0, from + along * 2.0 + aside]);
        triangles.push([eye - along, eye + along * 3.0, eye + along + numbers.point() * 0.3]);
        // Edge-on: the eye in the triangle's plane.
        let other = numbers.direction();
        triangles.push([eye + along, eye + along * 2.0 + other * 0.3, eye + along * 1.5 + other]);
        // Nothing: a line, a point.
        triangles.push([from, from + along, from + along * 2.0]);
        triangles.push([from; 3]);
        // Before near.
        triangles.push([0; 3].map(|_| eye + numbers.point() * 0.08));
    }
    // Corners on tile borders, edges along them, planes between faces: steps of a tile at depth 2.4 from the centre.
    for face in 0..6 {
        let axis = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z][face];
        let (u, v) = (axis.any_orthonormal_vector(), axis.cross(axis.any_orthonormal_vector()));
        for step in -3..3 {
            let at = |x: i32, y: i32| eye + axis * 2.3 + (u * f64::from(x) + v * f64::from(y)) * 0.2;
            triangles.push([at(step, -2), at(step + 2, -2), at(step, 4)]);
            triangles.push([at(12, step), at(-12, step), eye + axis * 30.0]);
        }
        triangles.push([eye + axis + u, eye + axis * 7.0 + u * 7.0 + v, eye + axis * 5.0 + u * 5.0 - v]);
        triangles.push([eye + axis * 1e3 - u * 2e3, eye + axis * 1e3 + u * 2e3, eye - axis * 2e3 + v * 1e3]);
    }
    triangles.into_iter().map(|corners| corners.map(|corner| corner.as_vec3().into())).collect()
}

/// What is stored of hostile triangles lies between brute force over tiles shrunk and grown by the stated rounding, for
/// tile sizes, buckets, coverages, clips and views, drawn by the rasterizer or in compute.
#[test]
fn what_is_stored_is_what_brute_force_finds() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    for settings in [
        &[][..],
        &[("tile_size", "1"), ("buckets", "4")],
        &[("tile_size", "4"), ("buckets", "1")],
        &[("tile_size", "8"), ("buckets", "40")],
        &[("centre", "eye")],
        &[("views", "frame"), ("tile_size", "1")],
        &[("coverage", "standard"), ("tile_size", "1")],
        &[("coverage", "standard"), ("views", "frame"), ("buckets", "7")],
        &[("clip", "plane")],
        &[("build", "compute")],
        &[("build", "compute"), ("tile_size", "8"), ("buckets", "40"), ("clip", "plane")],
        &[("build", "compute"), ("coverage", "standard"), ("tile_size", "1")],
        &[("build", "compute"), ("coverage", "standard"), ("views", "frame"), ("buckets", "7")],
    ] {
        let statistics = built(&gpu, &geometry, settings).check(&geometry);
        let statistics = statistics.unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        assert!(statistics.iter().any(|(name, value)| *name == "references" && *value > 1000.0), "{settings:?}");
    }
}

/// Drawn in compute every tile gets the parts that it gets by the rasterizer, with the same depths, bit for bit, and rays the same answers;
/// and, as a negative control, triangles a little aside are noticed.
#[test]
fn both_builds_store_the_same() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let aside = hostile().iter().map(|corners| corners.map(|[x, y, z]| [x + 1e-3, y, z])).collect::<Vec<_>>();
    let aside = soup(&aside, Some(&gpu));
    let mut numbers = Numbers::new(9);
    let rays: Vec<Ray> = (0..600).map(|_| ray(numbers.point() * 5.0, numbers.direction())).collect();
    for settings in [&[][..], &[("tile_size", "1"), ("buckets", "4")], &[("tile_size", "8"), ("clip", "plane")]] {
        let stored = |geometry: &Geometry, build: &str| {
            let structure = built(&gpu, geometry, &[settings, &[("build", build)]].concat());
            let read = |buffer: &Buffer| gpu.read(buffer, buffer.size()).unwrap();
            let [bounds, nodes] = [&structure.buffers.bounds, &structure.buffers.taken].map(read);
            (bounds, nodes, answer(&gpu, &structure, &rays))
        };
        let drawn = stored(&geometry, "raster");
        assert!(drawn == stored(&geometry, "compute"), "{settings:?}");
        assert!(drawn != stored(&aside, "compute"), "{settings:?}");
    }
}

/// Bytes of the nodes that there is room for.
fn node_bytes(structure: &Built<DirtStructure>) -> u64 {
    u64::from(structure.buffers.node_capacity) * NODE_BYTES
}

/// Nodes in several buffers, and depth bounds and heads that are bound by view, are stored and searched like those in one;
/// too many nodes even for that are an error that says what to turn down.
#[test]
fn what_a_binding_does_not_hold_is_split() {
    let whole = gpu();
    let geometry = soup(&hostile(), Some(&whole));
    let settings = [("tile_size", "2")];
    let together = built(&whole, &geometry, &settings);
    assert!(!together.buffers.is_split());
    let bytes = node_bytes(&together);
    let layout = &together.layout;
    let mut numbers = Numbers::new(4);
    let rays: Vec<Ray> = (0..600).map(|_| ray(numbers.point() * 5.0, numbers.direction())).collect();
    let hits = answer(&whole, &together, &rays);
    assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 100);
    let [heads, _] = layout.heads_bytes();
    for (limit, by_view) in [((bytes / 3).max(heads), false), ((bytes / 7).max(layout.heads_part_bytes()), true)] {
        let small = gpu_that_binds(limit / 8 * 8);
        let geometry = soup(&hostile(), Some(&small));
        let split = built(&small, &geometry, &settings);
        assert!(split.buffers.is_split() && split.buffers.by_view == by_view, "{limit} of {bytes}, {heads}");
        split.check(&geometry).unwrap();
        assert_eq!(hits, answer(&small, &split, &rays));
        assert_eq!(hits, answer_by(&small, &split, &rays, &[("centre_rays", "split")]), "splitting rays loses some");
        // A texture of all parts needs no splits.
        let copied = built(&small, &geometry, &[("tile_size", "2"), ("memory_access", "texture")]);
        assert!(copied.buffers.is_split() && copied.memory_access() == MemoryAccess::Texture);
        assert_eq!(hits, answer(&small, &copied, &rays));
    }
    let tiny = gpu_that_binds(layout.heads_part_bytes());
    let tracer = DeviceTracer::<DirtStructure>::new(Arc::clone(&tiny)).unwrap();
    let geometry = soup(&hostile().repeat(2), Some(&tiny));
    let refused =
        tracer.build_structure(&geometry, &viewpoint(), &parameters(&settings), &mut PhaseClock::new(Some(&tiny)));
    let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("id buffer") && message.contains("dirt.buckets"), "{message}");
}

/// A device that binds so many storage buffers a stage and so many bytes at once.
fn of_stage_limit(buffers: u32, bytes: u64) -> Arc<Gpu> {
    let mut gpu = Gpu::open(&AdapterChoice::default()).unwrap();
    gpu.limits.max_storage_buffers_per_shader_stage = buffers;
    gpu.limits.max_storage_buffer_binding_size = bytes;
    Arc::new(gpu)
}

/// With WebGPU's eight storage buffers a stage all is built, traced, counted and fetched as without a limit where nothing is
/// split; what would have to be split is refused with the limit and what to turn down, and with fewer buffers than every trace
/// binds the tracer is not available.
#[test]
fn eight_storage_buffers_a_stage_suffice_where_nothing_is_split() {
    let whole = gpu();
    let mut numbers = Numbers::new(6);
    let rays: Vec<Ray> = (0..300).map(|_| ray(numbers.point() * 5.0, numbers.direction())).collect();
    let eight = of_stage_limit(8, whole.limits.max_storage_buffer_binding_size);
    let [expected, found] = [&whole, &eight].map(|gpu| {
        let structure = built(gpu, &soup(&hostile(), Some(gpu)), &[("direct_visibility", "on")]);
        let by = |settings| answer_by(gpu, &structure, &rays, settings);
        let shared = RayBuffer::new(Arc::new(rays.clone()), Query::Closest, Some(gpu));
        let mut hits =
            HitBuffer::tracing_to(TraceTo::Surface, shared.host.len(), Residency::Device, Some(gpu)).unwrap();
        hits.poison(Some(gpu)).unwrap();
        let parameters = parameters(&[]);
        let job = TraceJob { rays: &shared, trace_to: TraceTo::Surface, parameters: &parameters };
        let counters = structure.trace_counted(job, &mut hits).unwrap();
        (by(&[]), by(&[("centre_rays", "split")]), counters, node_bytes(&structure))
    });
    assert_eq!(expected, found);
    let split = of_stage_limit(8, found.3 / 2 / 8 * 8);
    let tracer = DeviceTracer::<DirtStructure>::new(Arc::clone(&split)).unwrap();
    let mut clock = PhaseClock::new(Some(&split));
    let refused =
        tracer.build_structure(&soup(&hostile(), Some(&split)), &viewpoint(), &parameters(&[]), &mut clock).err();
    let Some(TracerError::TooLarge { name, limit, hint, .. }) = refused else { panic!("{refused:?}") };
    assert!(name == "id buffer: nodes" && hint.contains("dirt.buckets"), "{name}: {hint}");
    assert_eq!(limit, split.limits.max_storage_buffer_binding_size);
    let few = Dirt::new(of_stage_limit(7, whole.limits.max_storage_buffer_binding_size)).err();
    let Some(TracerError::Unavailable(reason)) = few else { panic!("{few:?}") };
    assert!(reason.contains("8 storage buffers") && reason.contains("allows 7"), "{reason}");
}

/// A rebuild over more than there is room for stores what fits, says so, makes room, and then stores what a fresh build
/// does.
#[test]
fn a_structure_that_overflows_grows() {
    let gpu = gpu();
    let few = soup(&hostile()[..40], Some(&gpu));
    let all = soup(&hostile(), Some(&gpu));
    let mut structure = built(&gpu, &few, &[]);
    assert!(!structure.grow_on_overflow().unwrap());
    let rebuild = |structure: &mut Built<DirtStructure>| {
        let mut clock = PhaseClock::new(Some(&gpu));
        structure.update(Update::Rebuild, &all, &viewpoint(), &parameters(&[]), &mut clock).unwrap();
        clock.finish().unwrap();
    };
    rebuild(&mut structure);
    assert!(structure.check(&all).is_err(), "an overflow passes as sound");
    assert!(structure.grow_on_overflow().unwrap());
    rebuild(&mut structure);
    assert!(!structure.grow_on_overflow().unwrap());
    structure.check(&all).unwrap();
    let mut numbers = Numbers::new(5);
    let rays: Vec<Ray> = (0..600).map(|_| ray(numbers.point() * 5.0, numbers.direction())).collect();
    assert_eq!(answer(&gpu, &structure, &rays), answer(&gpu, &built(&gpu, &all, &[]), &rays));
}

/// What a build without splits counts: parts stored, and additions to the node count.
fn counted_additions(gpu: &Arc<Gpu>, structure: &Built<DirtStructure>) -> [u32; 2] {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let counted = gpu.buffer("counted", 8, usage, "nothing").unwrap();
    let DirtStructure { pipelines, layout, buffers, geometry, filling, .. } = &**structure;
    let mut clock = PhaseClock::new(Some(gpu));
    pipelines.build_counting(layout, buffers, geometry, *filling, Some(&counted), &mut clock).unwrap();
    clock.finish().unwrap();
    bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&gpu.read(&counted, 8).unwrap())[0]
}

/// All copies of a part are taken by one addition to the node count, however many buckets it reaches into; a build that counts
/// them stores what others do.
#[test]
fn the_node_count_is_added_to_once_a_part() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    for settings in [&[][..], &[("coverage", "standard"), ("tile_size", "1"), ("buckets", "40")]] {
        let structure = built(&gpu, &geometry, settings);
        let of = |statistics: &[(&str, f64)], wanted: &str| {
            statistics.iter().find(|(name, _)| *name == wanted).map(|(_, value)| *value as u32).unwrap()
        };
        let before = structure.check(&geometry).unwrap();
        let [parts, additions] = counted_additions(&gpu, &structure);
        assert_eq!((parts, additions), (of(&before, "parts"), of(&before, "parts")), "{settings:?}");
        // One a copy would be more.
        assert!(of(&before, "references") > parts + parts / 10, "{settings:?}: {before:?}");
        assert_eq!(structure.check(&geometry).unwrap(), before, "{settings:?}");
    }
}

/// Used bytes are those of the paper's Table 3 with the device's own counts: 8 bytes of depth bounds a tile and mipmap, 4 B
/// a tile for heads, 8 a reference; and mipmaps add a third.
#[test]
fn memory_is_that_of_table_3() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    for (tile_size, buckets, tiles) in [("1", 24, 48), ("2", 4, 24), ("4", 40, 12), ("8", 1, 6)] {
        let structure = built(&gpu, &geometry, &[("tile_size", tile_size), ("buckets", &buckets.to_string())]);
        let statistics = structure.check(&geometry).unwrap();
        let count = |wanted: &str| statistics.iter().find(|(name, _)| *name == wanted).unwrap().1 as u64;
        let report = structure.memory();
        let used = |wanted: &str| {
            let entry = report.structure.iter().find(|entry| entry.name == wanted);
            entry.map(|entry| entry.used_bytes).unwrap()
        };
        let (mut mipmapped, mut edge) = (0, tiles);
        loop {
            mipmapped += edge * edge;
            if edge == 1 {
                break;
            }
            edge = u64::div_ceil(edge, 2);
        }
        assert_eq!(used("depth bounds texture"), 6 * 8 * mipmapped);
        assert_eq!(used("id buffer: heads"), 6 * tiles * tiles * 4 * buckets);
        assert_eq!(used("id buffer: nodes"), count("references") * 8);
        // c, the buckets that a part overlaps, lies between 1 and B.
        let overlapped = count("references") as f64 / count("parts") as f64;
        assert!((1.0..=buckets as f64).contains(&overlapped), "{overlapped}");
        let growth = mipmapped as f64 / (tiles * tiles) as f64;
        assert!((1.33..1.45).contains(&growth), "{growth}");
    }
}

pub(crate) fn answer(gpu: &Arc<Gpu>, structure: &Built<DirtStructure>, rays: &[Ray]) -> Vec<Hit> {
    answer_by(gpu, structure, rays, &[])
}

pub(crate) fn answer_by(
    gpu: &Arc<Gpu>,
    structure: &Built<DirtStructure>,
    rays: &[Ray],
    settings: &[(&str, &str)],
) -> Vec<Hit> {
    answers(gpu, structure, rays, Query::Closest, &parameters(settings), TraceTo::Hit).0
}

/// Nodes of another triangle, lists that end early, lead nowhere or in circles, and depth bounds or mipmaps that are off
/// are noticed.
#[test]
fn a_spoilt_structure_is_noticed() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let structure = built(&gpu, &geometry, &[("tile_size", "4"), ("buckets", "6")]);
    structure.check(&geometry).unwrap();
    let aside = hostile().iter().map(|corners| corners.map(|[x, y, z]| [x + 0.5, y, z])).collect::<Vec<_>>();
    assert!(structure.check(&soup(&aside, Some(&gpu))).is_err(), "another scene is not noticed");
    let heads: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&structure.buffers.heads, 16_000).unwrap());
    let list = heads.iter().position(|head| *head > 2).unwrap() as u64;
    let node = u64::from(heads[list as usize] - 1);
    let grid = structure.layout.grid(0, 1);
    let top = u64::from(5 * grid.bounds_stride + grid.level_offsets[structure.layout.levels() - 1]);
    let buffers = &structure.buffers;
    for (name, buffer, offset, value) in [
        ("another triangle", &buffers.nodes[0], node * 8 + 4, 7_u32),
        ("an early end", &buffers.heads, list * 4, 0),
        ("nowhere", &buffers.nodes[0], node * 8, 1 << 30),
        ("a circle", &buffers.nodes[0], node * 8, node as u32 + 1),
        ("a far bound", &buffers.bounds, 4, 0.2_f32.to_bits()),
        ("the top", &buffers.bounds, top * 8 + 4, 9e9_f32.to_bits()),
    ] {
        let before = gpu.read(buffer, offset + 4).unwrap()[offset as usize..].to_vec();
        assert_ne!(before, value.to_le_bytes(), "{name} spoils nothing");
        gpu.queue.write_buffer(buffer, offset, &value.to_le_bytes());
        assert!(structure.check(&geometry).is_err(), "{name} is not noticed");
        gpu.queue.write_buffer(buffer, offset, &before);
    }
    structure.check(&geometry).unwrap();
}
