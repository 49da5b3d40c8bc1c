//! What is built of hostile triangles, what it takes, and that the check notices what is wrong.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    AdapterChoice, Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency,
    Structure, Surface, TraceJob, TraceTo, TracerError, Update, Viewpoint, wgpu,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, gpu, rectangle as rectangle_of, soup};

use super::description;
use super::nodes::NOTHING;
use super::structure::{Quadtree, QuadtreeStructure};

/// Settings that lose nothing: no node stands for others but as their box.
pub(crate) const LOSSLESS: [(&str, &str); 2] = [("gamma_norm", "0"), ("gamma_dist", "0")];

/// Round the origin, 40 pixels along a face's edge, a frame of odd edges.
pub(crate) fn viewpoint() -> Viewpoint {
    Viewpoint {
        eye: Vec3::new(0.3, -0.2, 0.1),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.2,
        near: 0.1,
        far: 200.0,
        frame: [63, 41],
        face: 40,
    }
}

pub(crate) fn parameters(settings: &[(&str, &str)]) -> Parameters {
    let descriptions = description().parameters;
    let mut parameters = Parameters::preset(&descriptions, Preset::Published);
    for (name, value) in settings {
        parameters.set(&descriptions, name, value).unwrap();
    }
    parameters
}

pub(crate) fn try_built(
    tracer: &Quadtree,
    gpu: &Arc<Gpu>,
    geometry: &Geometry,
    viewpoint: &Viewpoint,
    settings: &[(&str, &str)],
) -> Result<Built<QuadtreeStructure>, TracerError> {
    let mut clock = PhaseClock::new(Some(gpu));
    let structure = tracer.build_structure(geometry, viewpoint, &parameters(settings), &mut clock)?;
    clock.finish().map(|_| structure)
}

pub(crate) fn built_by(
    tracer: &Quadtree,
    gpu: &Arc<Gpu>,
    geometry: &Geometry,
    settings: &[(&str, &str)],
) -> Built<QuadtreeStructure> {
    try_built(tracer, gpu, geometry, &viewpoint(), settings).unwrap()
}

/// Hits and, where they are asked for, surfaces.
pub(crate) fn answer(
    gpu: &Arc<Gpu>,
    structure: &Built<QuadtreeStructure>,
    rays: &[Ray],
    settings: &[(&str, &str)],
    trace_to: TraceTo,
) -> (Vec<Hit>, Vec<Surface>) {
    let rays = RayBuffer::new(Arc::new(rays.to_vec()), Query::Closest, Some(gpu));
    let mut hits = HitBuffer::tracing_to(trace_to, rays.host.len(), Residency::Device, Some(gpu)).unwrap();
    hits.poison(Some(gpu)).unwrap();
    let parameters = parameters(settings);
    let mut clock = PhaseClock::new(Some(gpu));
    structure.trace(TraceJob { rays: &rays, trace_to, parameters: &parameters }, &mut hits, &mut clock).unwrap();
    clock.finish().unwrap();
    let surfaces = match trace_to {
        TraceTo::Hit => Vec::new(),
        TraceTo::Surface => hits.read_surfaces(Some(gpu)).unwrap(),
    };
    (hits.read(Some(gpu)).unwrap(), surfaces)
}

pub(crate) fn rectangle(corner: DVec3, first: DVec3, second: DVec3) -> [[[f32; 3]; 3]; 2] {
    rectangle_of(corner.as_vec3().into(), first.as_vec3().into(), second.as_vec3().into())
}

/// Plates at a slant in all directions and one behind the other, small triangles, thin ones, one through the eye, one that
/// reaches far, equal ones.
pub(crate) fn hostile() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(161);
    let eye = viewpoint().eye.as_dvec3();
    let mut triangles = Vec::new();
    for index in 0..70 {
        let away = numbers.direction();
        // Half of them before the camera.
        let away = if index % 2 == 0 { (away + DVec3::NEG_Z * 1.5).normalize() } else { away };
        let middle = eye + away * (1.0 + 9.0 * numbers.unit());
        let (first, second) = (numbers.direction() * 2.0, numbers.direction() * 2.0);
        triangles.extend(rectangle(middle - first * 0.5 - second * 0.5, first, second));
    }
    for _ in 0..60 {
        let middle = eye + numbers.direction() * (0.5 + 4.0 * numbers.unit());
        triangles.push([0; 3].map(|_| (middle + numbers.point() * 0.15).as_vec3().into()));
    }
    for _ in 0..20 {
        let (start, along) = (eye + numbers.point() * 3.0, numbers.direction());
        triangles.push(
            [start, start + along, start + along * 0.5 + numbers.direction() * 1e-3].map(|at| at.as_vec3().into()),
        );
    }
    triangles.extend(rectangle(eye + DVec3::new(-30.0, -1.5, -30.0), DVec3::X * 60.0, DVec3::Z * 60.0));
    triangles.extend(rectangle(eye - DVec3::new(0.5, 0.5, 4.0), DVec3::X, DVec3::Y));
    for _ in 0..3 {
        triangles.extend(rectangle(eye - DVec3::new(-1.0, 0.5, 3.0), DVec3::X, DVec3::Y));
    }
    triangles
}

/// Every capture, by the rasterizer and in compute, with and without back faces and a separation, of every number of layers and view set,
/// with normals of either kind and all thresholds, passes its own check: layers against a rasterizer on the host, nodes against those below
/// them.
#[test]
fn structures_are_sound() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let all: Vec<Vec<(&str, &str)>> = vec![
        vec![],
        LOSSLESS.to_vec(),
        vec![("capture", "peeling"), ("layers", "3"), ("views", "six")],
        vec![("views", "six"), ("layers", "1"), ("normals", "geometry"), ("gamma_dist", "0.01")],
        vec![("layers", "4"), ("back_faces", "culled"), ("dilated", "all"), ("dilation", "2")],
        vec![("minimum_separation", "0.01"), ("layers", "3")],
        vec![("minimum_separation", "0.01"), ("layers", "3"), ("capture", "peeling"), ("back_faces", "culled")],
        vec![("gamma_dist_in", "pixels"), ("gamma_dist", "2"), ("gamma_norm", "20"), ("gamma_growth", "8")],
        vec![("levels", "2"), ("gamma_dist", "0.1"), ("gamma_norm", "25"), ("dilated", "flagged")],
        vec![("levels", "0"), ("memory_access", "texture"), ("dilated", "none")],
        vec![("build", "compute"), ("layers", "3")],
        vec![("build", "compute"), ("layers", "2"), ("capture", "peeling"), ("views", "six")],
        vec![("build", "compute"), ("minimum_separation", "0.01"), ("back_faces", "culled")],
        vec![("patches", "joined"), ("normals", "geometry"), ("layers", "4")],
        vec![
            ("patches", "joined"),
            ("views", "six"),
            ("dilated", "all"),
            ("gamma_dist", "0.25"),
            ("gamma_dist_in", "pixels"),
        ],
    ];
    for settings in all {
        let statistics = built_by(&tracer, &gpu, &geometry, &settings).check(&geometry);
        let statistics = statistics.unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        let of = |name: &str| statistics.iter().find(|(each, _)| *each == name).unwrap().1;
        assert!(of("covered_pixels") > 1000.0 && of("plane_leaves") > 0.0, "{settings:?}: {statistics:?}");
        if settings == LOSSLESS {
            assert_eq!(of("plane_leaves"), of("plane_leaves_level_0"), "{statistics:?}");
        } else if of("levels") > 0.0 {
            assert!(of("plane_leaves") > of("plane_leaves_level_0"), "{settings:?}: {statistics:?}");
        }
    }
}

/// A wall square to the view merges into one plane a root, a slanted one into few; larger thresholds have fewer leaves.
#[test]
fn planes_are_merged() {
    let gpu = gpu();
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let eye = viewpoint().eye.as_dvec3();
    let leaves = |along: DVec3, settings: &[(&str, &str)]| {
        let corner = eye - DVec3::Z * 5.0 - DVec3::Y * 40.0 - along * 20.0;
        let wall = soup(&rectangle(corner, along * 40.0, DVec3::Y * 80.0), Some(&gpu));
        let statistics = built_by(&tracer, &gpu, &wall, &[settings, &[("layers", "1")]].concat()).check(&wall).unwrap();
        statistics.iter().find(|(name, _)| *name == "plane_leaves").unwrap().1
    };
    assert_eq!(leaves(DVec3::X, &[]), 1.0);
    let slanted = DVec3::new(1.0, 0.0, 0.4);
    let [lossless, fine, coarse] = [
        leaves(slanted, &LOSSLESS),
        leaves(slanted, &[("gamma_dist", "1e-6")]),
        leaves(slanted, &[("gamma_dist", "1e-3"), ("gamma_norm", "25")]),
    ];
    assert!(lossless > 4.0 * fine && fine >= coarse && coarse < 5.0, "{lossless} {fine} {coarse}");
}

/// Nodes have 8 bytes and pixels 16 more a layer for normal and material (sections 3.1 and 3.4), the pyramid of nodes a third more than
/// pixels; nothing of the scene is needed to trace.
#[test]
fn memory_is_that_of_the_paper() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    for layers in [1_u64, 2, 3] {
        let structure = built_by(&tracer, &gpu, &geometry, &[("layers", &layers.to_string())]);
        let report = structure.memory();
        let used = |name: &str| report.structure.iter().find(|entry| entry.name == name).unwrap().used_bytes;
        let pixels = 63 * 41;
        let nodes = pixels + 32 * 21 + 16 * 11 + 8 * 6 + 4 * 3 + 2 * 2 + 1;
        assert_eq!(used("quad-tree nodes"), layers * nodes * 8);
        assert_eq!(used("depth layers"), layers * pixels * 4);
        let payloads =
            used("normals and materials of layers 1 and 3") + used("normals and materials of layers 2 and 4");
        assert_eq!(payloads, if layers == 1 { pixels * 16 + 16 } else { layers * pixels * 16 });
        assert_eq!((report.geometry_bytes, report.surface_geometry_bytes), (0, 0));
    }
}

/// A device that binds no more bytes at once.
fn of_limit(bytes: u64) -> Arc<Gpu> {
    let mut gpu = Gpu::open(&AdapterChoice::default()).unwrap();
    gpu.limits.max_storage_buffer_binding_size = bytes;
    Arc::new(gpu)
}

/// Layers or frames that the device cannot hold are errors that say what to turn down, gammas outside of their range are refused by
/// name, and a view without pixels is an error.
#[test]
fn too_much_is_refused() {
    let gpu = of_limit(20_000);
    let geometry = soup(&hostile()[..4], Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let refused = |viewpoint: &Viewpoint, settings: &[(&str, &str)]| {
        try_built(&tracer, &gpu, &geometry, viewpoint, settings)
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default()
    };
    let frame = |frame: [u32; 2]| Viewpoint { frame, ..viewpoint() };
    assert!(refused(&viewpoint(), &[]).contains("--frame-size or quadtree.layers"));
    assert!(refused(&viewpoint(), &[("views", "six")]).contains("--face-size or quadtree.layers"));
    assert!(refused(&frame([0, 7]), &[]).contains("turn up --frame-size"));
    // Fewer layers make no edge shorter.
    assert!(refused(&frame([200_000, 1]), &[]).ends_with("turn down --frame-size"));
    // Fewer layers of fewer pixels fit.
    assert_eq!(refused(&frame([20, 20]), &[]), "");
    let descriptions = description().parameters;
    let mut parameters = Parameters::preset(&descriptions, Preset::Published);
    for (name, value) in
        [("gamma_norm", "91"), ("gamma_norm", "-1"), ("gamma_dist", "-1e-5"), ("layers", "0"), ("layers", "5")]
    {
        let error = parameters.set(&descriptions, name, value).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(value), "{error}");
    }
}

/// Frames of one pixel, of one row and column and of odd sizes are built and answered, with levels down to none; a view that shows
/// nothing answers that nothing is there.
#[test]
fn odd_frames_are_answered() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let empty = soup(&[[[0.3, 50.0, 0.0], [1.0, 50.0, 0.0], [0.0, 50.0, 0.1]]], Some(&gpu));
    let mut hits_seen = 0;
    for size in [[1, 1], [1, 17], [33, 1], [7, 5], [65, 2]] {
        let view = Viewpoint { frame: size, ..viewpoint() };
        let shape = view.frame_view();
        let rays: Vec<Ray> = (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)))
            .map(|(x, y)| tracebench_tests::ray(shape.eye, shape.direction_through(x, y)))
            .collect();
        for settings in [vec![], vec![("levels", "1")], vec![("layers", "1"), ("levels", "0")]] {
            let structure = try_built(&tracer, &gpu, &geometry, &view, &settings).unwrap();
            let statistics = structure.check(&geometry).unwrap_or_else(|error| panic!("{size:?}: {error}"));
            let covered = statistics.iter().find(|(name, _)| *name == "covered_pixels").unwrap().1;
            let hits = answer(&gpu, &structure, &rays, &settings, TraceTo::Hit).0;
            let found = hits.iter().filter(|hit| hit.is_hit()).count();
            assert_eq!(found as f64, covered, "{size:?} {settings:?}");
            hits_seen += found;
            let nothing = try_built(&tracer, &gpu, &empty, &view, &settings).unwrap();
            nothing.check(&empty).unwrap();
            assert!(answer(&gpu, &nothing, &rays, &settings, TraceTo::Hit).0.iter().all(|hit| !hit.is_hit()));
        }
    }
    assert!(hits_seen > 100, "{hits_seen}");
}

/// A structure that was rebuilt over another scene, from another viewpoint and at another size answers as a fresh one, in its
/// buffers where these are large enough.
#[test]
fn rebuilt_structures_are_as_new() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let other = soup(&hostile()[..90], Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let eye = viewpoint().eye.as_dvec3();
    let mut numbers = Numbers::new(162);
    let rays: Vec<Ray> = (0..400).map(|_| tracebench_tests::ray(eye + numbers.point(), numbers.direction())).collect();
    for settings in [vec![], vec![("memory_access", "texture"), ("minimum_separation", "0.01")]] {
        let mut structure = built_by(&tracer, &gpu, &geometry, &settings);
        let moved = Viewpoint { eye: Vec3::new(-0.4, 0.1, 0.6), ..viewpoint() };
        let smaller = Viewpoint { frame: [40, 30], ..moved };
        let larger = Viewpoint { frame: [80, 50], ..moved };
        let mut before = None;
        for view in [moved, smaller, larger] {
            let mut clock = PhaseClock::new(Some(&gpu));
            structure.update(Update::Rebuild, &other, &view, &parameters(&settings), &mut clock).unwrap();
            clock.finish().unwrap();
            let fresh = try_built(&tracer, &gpu, &other, &view, &settings).unwrap();
            let of = |structure| answer(&gpu, structure, &rays, &settings, TraceTo::Surface);
            let found = of(&structure);
            assert_eq!(found, of(&fresh), "{view:?}");
            assert_ne!(before.replace(found.clone()), Some(found));
        }
    }
}

/// Depths, triangles, planes, boxes, flags and words of holes that are off are noticed.
#[test]
fn a_spoilt_structure_is_noticed() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let aside = hostile().iter().map(|corners| corners.map(|[x, y, z]| [x + 0.5, y, z])).collect::<Vec<_>>();
    let other = soup(&aside, Some(&gpu));
    let structure = || built_by(&tracer, &gpu, &geometry, &[]);
    structure().check(&geometry).unwrap();
    assert!(structure().check(&other).is_err(), "another scene is not noticed");
    let read =
        |buffer: &wgpu::Buffer| -> Vec<u32> { bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size()).unwrap()) };
    /// A word of a buffer, by its place, and what is written there.
    type Spoilt = (wgpu::Buffer, usize, u32);
    let spoils = |what: &str, spoil: &dyn Fn(&Built<QuadtreeStructure>) -> Spoilt| {
        let structure = structure();
        let (buffer, word, value) = spoil(&structure);
        gpu.queue.write_buffer(&buffer, word as u64 * 4, &value.to_le_bytes());
        assert!(structure.check(&geometry).is_err(), "{what} is not noticed");
    };
    // A word of a node of a level and kind, above the pixels or of them.
    let node_where =
        |structure: &Built<QuadtreeStructure>, range: std::ops::Range<usize>, is: &dyn Fn([u32; 2]) -> bool| {
            let nodes = read(&structure.images.nodes.buffer);
            let found = range.into_iter().find(|node| is([nodes[2 * node], nodes[2 * node + 1]])).unwrap();
            (2 * found, [nodes[2 * found], nodes[2 * found + 1]])
        };
    let pixels = 63 * 41;
    let whole = pixels + 32 * 21 + 16 * 11 + 8 * 6 + 4 * 3 + 2 * 2 + 1;
    let is_plane = |words: [u32; 2]| words[0] >> 31 == 1;
    let is_box = |words: [u32; 2]| words[0] >> 31 == 0 && words != NOTHING;
    let nodes = |structure: &Built<QuadtreeStructure>| structure.images.nodes.buffer.clone();
    spoils("a pixel's depth", &|structure| {
        let (word, words) = node_where(structure, 0..pixels, &is_plane);
        (nodes(structure), word, words[0] + (1 << 14))
    });
    spoils("a pixel that shows nothing", &|structure| {
        let (word, _) = node_where(structure, 0..pixels, &is_plane);
        (nodes(structure), word, NOTHING[0])
    });
    spoils("a plane's z", &|structure| {
        let (word, words) = node_where(structure, pixels..whole, &is_plane);
        (nodes(structure), word, words[0] + (1 << 20))
    });
    spoils("a plane's normal", &|structure| {
        let (word, words) = node_where(structure, pixels..whole, &is_plane);
        (nodes(structure), word + 1, words[1] ^ 0x3400)
    });
    spoils("a plane's flag", &|structure| {
        let (word, words) = node_where(structure, pixels..whole, &is_plane);
        (nodes(structure), word, words[0] ^ 0x4000_0000)
    });
    for (place, what) in [(0, "a box's least z"), (1, "a box's greatest z")] {
        spoils(what, &|structure| {
            let (word, words) = node_where(structure, pixels..whole, &is_box);
            (nodes(structure), word + place, words[place] - (1 << 16))
        });
    }
    spoils("a box's word of holes", &|structure| {
        let (word, words) = node_where(structure, pixels..whole, &is_box);
        (nodes(structure), word + 1, words[1] ^ 0x8000_0000)
    });
    spoils("a layer's triangle", &|structure| {
        let names = read(&structure.images.names.buffer);
        let word = names.iter().position(|name| *name != 0).unwrap();
        (structure.images.names.buffer.clone(), word, 0)
    });
    spoils("a layer before the one before", &|structure| {
        let codes = read(&structure.images.codes.buffer);
        let word = (pixels..2 * pixels).find(|word| codes[*word] != 0).unwrap();
        (structure.images.codes.buffer.clone(), word, codes[word - pixels] + 9)
    });
    // Of those that are compared: every pixel is, of a frame this small.
    spoils("a payload", &|structure| {
        let payloads = &structure.images.payloads[0].buffer;
        let words = read(payloads);
        let pixel = (0..pixels).find(|pixel| words[4 * pixel] != 0).unwrap();
        (payloads.clone(), 4 * pixel + 3, words[4 * pixel + 3] + 1)
    });
}
