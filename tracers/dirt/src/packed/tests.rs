//! What packed structures hold of hostile triangles against f64, and that the check notices what is wrong.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{Geometry, Gpu, PhaseClock, Structure, TracerError, Update, Viewpoint};
use tracebench_kit::{Built, DeviceTracer};
use tracebench_shaders::constants;
use tracebench_tests::{Numbers, gpu, gpu_that_binds, soup};

use super::PackedStructure;
use super::buffers::MAX_PARTS;
use super::build::{LARGE_WORKGROUPS, WORKGROUP_SIZE};
use super::layout::{FACES, FIRST_NEAR, MISPLACED};
use crate::tests::{hostile, parameters, viewpoint};

/// A way to store what is in the view of tests; further settings after it.
pub(super) const FORMS: [&[(&str, &str)]; 7] = [
    &[("lists", "trees")],
    &[("lists", "trees"), ("face_tiles", "16"), ("slices", "7")],
    &[("lists", "trees"), ("face_tiles", "100"), ("spacing", "near_far")],
    &[("lists", "sliced"), ("face_tiles", "64")],
    &[("lists", "sliced"), ("face_tiles", "5"), ("slices", "64")],
    &[("lists", "packed"), ("slices", "1")],
    &[("lists", "packed"), ("face_tiles", "1")],
];

/// Places and sizes that the host knows are those of the shaders.
#[test]
fn constants_are_those_of_the_shaders() {
    for (file, name, expected) in [
        ("part_lists", "WORKGROUP_SIZE", WORKGROUP_SIZE),
        ("part_trees", "WORKGROUP_SIZE", WORKGROUP_SIZE),
        ("part_lists", "LARGE_WORKGROUPS", LARGE_WORKGROUPS),
        ("part_lists", "FACES", FACES),
        ("part_lists", "FIRST_NEAR", FIRST_NEAR),
        ("part_lists", "MISPLACED", MISPLACED),
        ("part_trees", "MAX_PARTS", MAX_PARTS),
    ] {
        assert_eq!(constants(&format!("dirt/{file}.wgsl"), name), [expected].into(), "{file}: {name}");
    }
}

type PackedTracer = DeviceTracer<PackedStructure>;

/// One of each device, so that drivers compile its pipelines once.
fn tracer(gpu: &Arc<Gpu>) -> Result<Rc<PackedTracer>, TracerError> {
    thread_local! {
        static LAST: RefCell<Option<(Arc<Gpu>, Rc<PackedTracer>)>> = const { RefCell::new(None) };
    }
    LAST.with_borrow_mut(|last| match last {
        Some((of, tracer)) if Arc::ptr_eq(of, gpu) => Ok(Rc::clone(tracer)),
        _ => {
            let tracer = Rc::new(PackedTracer::new(Arc::clone(gpu))?);
            *last = Some((Arc::clone(gpu), Rc::clone(&tracer)));
            Ok(tracer)
        }
    })
}

pub(super) fn built_at(
    gpu: &Arc<Gpu>,
    geometry: &Geometry,
    viewpoint: &Viewpoint,
    settings: &[(&str, &str)],
) -> Result<Built<PackedStructure>, TracerError> {
    let tracer = tracer(gpu)?;
    let mut clock = PhaseClock::new(Some(gpu));
    let structure = tracer.build_structure(geometry, viewpoint, &parameters(settings), &mut clock)?;
    clock.finish()?;
    Ok(structure)
}

pub(super) fn built(gpu: &Arc<Gpu>, geometry: &Geometry, settings: &[(&str, &str)]) -> Built<PackedStructure> {
    built_at(gpu, geometry, &viewpoint(), settings).unwrap()
}

/// The hostile triangles of the linked lists' tests, and such as are hard where there is no near plane: fans round the eye, corners in
/// it, triangles far nearer than their size, along the planes between faces, and as large as all the rest a thousand times.
pub(super) fn triangles() -> Vec<[[f32; 3]; 3]> {
    let eye = viewpoint().eye;
    // Few of them reach over many tiles; all would be a million parts.
    let mut all: Vec<_> = hostile().into_iter().step_by(4).collect();
    for turn in 0..8 {
        let (sine, cosine) = (turn as f32 * 0.7).sin_cos();
        let along = Vec3::new(cosine, sine, (turn as f32 * 1.3).sin());
        let across = along.cross(Vec3::new(0.3, -0.2, 0.9));
        let near = 10.0_f32.powi(-(turn % 7));
        // A corner in the eye; an edge through it; just beside it.
        all.push([eye, eye + along * 2.0, eye + across].map(|corner| corner.to_array()));
        all.push([eye - along, eye + along * 3.0, eye + across * 0.5].map(|corner| corner.to_array()));
        let beside = along.cross(across).normalize() * near;
        all.push(
            [eye + beside - along * 2.0, eye + beside + along, eye + beside + across * 2.0]
                .map(|corner| corner.to_array()),
        );
        // In the plane between two faces, and along an edge of the cube.
        all.push(
            [eye + Vec3::new(1.0, 1.0, near), eye + Vec3::new(3.0, 3.0, -1.0), eye + Vec3::ONE]
                .map(|corner| corner.to_array()),
        );
    }
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let across = axis.any_orthonormal_vector();
        let up = axis.cross(across);
        all.push(
            [axis * 3.0 - across * 5e3 - up * 4e3, axis * 3.0 + across * 6e3, axis * 3.0 + up * 5e3]
                .map(|corner| corner.to_array()),
        );
    }
    all
}

/// The same world at another scale and place, with its viewpoint.
pub(super) fn moved(scale: f32, by: f32) -> (Vec<[[f32; 3]; 3]>, Viewpoint) {
    let place = |point: [f32; 3]| point.map(|coordinate| coordinate * scale + by);
    let view = viewpoint();
    let eye = Vec3::from(place(view.eye.to_array()));
    let view = Viewpoint { eye, near: view.near * scale, far: view.far * scale, ..view };
    (triangles().into_iter().map(|corners| corners.map(place)).collect(), view)
}

/// Proves that what is stored of hostile triangles lies between what f64 finds for tiles grown by what a search relies on and by what
/// is stated, in every form.
#[test]
fn what_is_stored_is_what_f64_finds() {
    let gpu = gpu();
    let geometry = soup(&triangles(), Some(&gpu));
    for settings in FORMS {
        let statistics = built(&gpu, &geometry, settings).check(&geometry);
        let statistics = statistics.unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        let of = |wanted: &str| statistics.iter().find(|(name, _)| *name == wanted).unwrap().1;
        assert!(of("references") > 400.0 && of("triangles_near_the_eye") > 10.0, "{settings:?}: {statistics:?}");
    }
}

/// Proves the same of worlds a million times larger and smaller, and far from the origin.
#[test]
fn scale_and_place_change_nothing() {
    let gpu = gpu();
    for (scale, by) in [(1e6, 0.0), (1e-6, 0.0), (1.0, 3e4)] {
        let (triangles, view) = moved(scale, by);
        let geometry = soup(&triangles, Some(&gpu));
        for settings in [FORMS[0], FORMS[3]] {
            let checked = built_at(&gpu, &geometry, &view, settings).unwrap().check(&geometry);
            checked.unwrap_or_else(|error| panic!("{scale} {by} {settings:?}: {error}"));
        }
    }
}

/// Negative controls: another scene, another triangle in a tile, boxes that are too small, masks without a slice, a pyramid that is off,
/// depths on another scale, lists that begin elsewhere.
#[test]
fn a_spoilt_structure_is_noticed() {
    let gpu = gpu();
    let geometry = soup(&triangles(), Some(&gpu));
    let aside = triangles().iter().map(|corners| corners.map(|[x, y, z]| [x + 0.5, y, z])).collect::<Vec<_>>();
    // Of few tiles, so that every part is looked at.
    for lists in ["trees", "sliced"] {
        let settings = [("lists", lists), ("face_tiles", "8")];
        let structure = built(&gpu, &geometry, &settings);
        structure.check(&geometry).unwrap();
        assert!(structure.check(&soup(&aside, Some(&gpu))).is_err(), "another scene is not noticed");
        let buffers = &structure.buffers;
        let quads: Vec<[u32; 4]> =
            bytemuck::pod_collect_to_vec(&gpu.read(&buffers.quads.buffer, buffers.quads.used_bytes).unwrap());
        // The tile with most references.
        let tile = (0..structure.layout.tile_count() as usize).max_by_key(|tile| quads[*tile][1]).unwrap();
        let [first, count, node, _] = quads[tile].map(u64::from);
        assert!(count > 8, "{count}");
        let head = u64::from(FIRST_NEAR + buffers.triangle_count);
        let top = u64::from(structure.layout.cells()) - 1;
        let mut spoils = vec![
            ("no triangle", &buffers.words.buffer, (head + first) * 4, 1 << 30),
            ("a shorter list", &buffers.quads.buffer, tile as u64 * 16 + 4, count as u32 - 1),
            ("the pyramid's top", &buffers.masks.buffer, top * 8, 0),
        ];
        if lists == "trees" {
            let words = gpu.read(&buffers.words.buffer, buffers.words.used_bytes).unwrap();
            let second = bytemuck::pod_collect_to_vec::<u8, u32>(&words)[(head + first) as usize + 1];
            spoils.push(("a triangle twice", &buffers.words.buffer, (head + first) * 4, second));
            spoils.push(("a part without a box", &buffers.nodes.buffer, node * 48, u32::MAX));
            spoils.push(("a node that is too small", &buffers.nodes.buffer, node * 48 + 8, 0));
            spoils.push(("another scale", &buffers.quads.buffer, tile as u64 * 16 + 12, 1));
        } else {
            spoils.push(("a list elsewhere", &buffers.nodes.buffer, node * 4 + 4, first as u32 + count as u32));
        }
        for (name, buffer, offset, value) in spoils {
            let before = gpu.read(buffer, offset + 4).unwrap()[offset as usize..].to_vec();
            assert_ne!(before, value.to_le_bytes(), "{name} spoils nothing");
            gpu.queue.write_buffer(buffer, offset, &value.to_le_bytes());
            assert!(structure.check(&geometry).is_err(), "{settings:?}: {name} is not noticed");
            gpu.queue.write_buffer(buffer, offset, &before);
        }
        structure.check(&geometry).unwrap();
    }
}

/// Proves that a rebuild over more than there is room for says so, makes room, and then stores what a fresh build does.
#[test]
fn a_structure_that_overflows_grows() {
    let gpu = gpu();
    let few = soup(&triangles()[..40], Some(&gpu));
    let all = soup(&triangles(), Some(&gpu));
    for settings in [FORMS[0], FORMS[3], FORMS[5]] {
        let mut structure = built(&gpu, &few, settings);
        assert!(!structure.grow_on_overflow().unwrap());
        let rebuild = |structure: &mut Built<PackedStructure>| {
            let mut clock = PhaseClock::new(Some(&gpu));
            structure.update(Update::Rebuild, &all, &viewpoint(), &parameters(settings), &mut clock).unwrap();
            clock.finish().unwrap();
        };
        rebuild(&mut structure);
        assert!(structure.check(&all).is_err(), "{settings:?}: an overflow passes as sound");
        assert!(structure.grow_on_overflow().unwrap());
        rebuild(&mut structure);
        assert!(!structure.grow_on_overflow().unwrap());
        assert_eq!(structure.check(&all).unwrap(), built(&gpu, &all, settings).check(&all).unwrap(), "{settings:?}");
    }
}

/// Proves that parts and nodes come in the same order in every build, equal triangles too.
#[test]
fn builds_are_the_same_bit_for_bit() {
    let gpu = gpu();
    let geometry = soup(&[triangles(), vec![triangles()[7]; 300]].concat(), Some(&gpu));
    for settings in [FORMS[0], FORMS[3]] {
        let words = |structure: &Built<PackedStructure>| {
            let buffers = &structure.buffers;
            let head = u64::from(FIRST_NEAR + buffers.triangle_count) as usize * 4;
            let references = gpu.read(&buffers.words.buffer, buffers.words.used_bytes).unwrap();
            let nodes = gpu.read(&buffers.nodes.buffer, buffers.nodes.used_bytes).unwrap();
            (references[head..].to_vec(), nodes, gpu.read(&buffers.masks.buffer, buffers.masks.used_bytes).unwrap())
        };
        let [one, other] = [0, 1].map(|_| words(&built(&gpu, &geometry, settings)));
        assert!(one == other, "{settings:?}");
    }
}

/// Proves that every part has a place that was counted for it: of large triangles whose tips reach just beyond a face, so that what is left
/// of them there has an edge far shorter than the others, in tiles as small as they may be.
#[test]
fn parts_of_cut_triangles_have_places() {
    let (gpu, eye) = (gpu(), viewpoint().eye);
    let mut numbers = Numbers::new(23);
    let cut = |numbers: &mut Numbers| {
        let mut within = || 2.0 * numbers.unit() as f32 - 1.0;
        let corners = [[1.0, within()], [within(), within()], [within(), within()]];
        let beyond = 10.0_f32.powf(-1.0 - 3.0 * numbers.unit() as f32);
        let depth = 1.0 + numbers.unit() as f32;
        corners.map(|[x, y]| (eye + Vec3::new(if x == 1.0 { 1.0 + beyond } else { x }, y, -1.0) * depth).to_array())
    };
    let all: Vec<_> = (0..60).map(|_| cut(&mut numbers)).collect();
    let geometry = soup(&all, Some(&gpu));
    for settings in [[("lists", "trees"), ("face_tiles", "256")], [("lists", "trees"), ("face_tiles", "200")]] {
        let mut structure = built(&gpu, &geometry, &settings);
        structure.grow_on_overflow().unwrap();
    }
}

/// Proves that what a device cannot bind is refused by name, with what to turn down.
#[test]
fn what_does_not_fit_is_refused() {
    let whole = gpu();
    let bytes = built(&whole, &soup(&triangles(), Some(&whole)), FORMS[0]).buffers.parts.used_bytes;
    let small = gpu_that_binds(bytes / 4 * 4 - 16);
    let refused = built_at(&small, &soup(&triangles(), Some(&small)), &viewpoint(), FORMS[0]).err();
    let message = refused.map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("parts") && message.contains("dirt.face_tiles"), "{message}");
}

/// Proves that the ledger's used bytes are those of what is counted.
#[test]
fn memory_is_what_is_counted() {
    let gpu = gpu();
    let geometry = soup(&triangles(), Some(&gpu));
    let structure = built(&gpu, &geometry, FORMS[0]);
    let statistics = structure.check(&geometry).unwrap();
    let count = |wanted: &str| statistics.iter().find(|(name, _)| *name == wanted).unwrap().1 as u64;
    let report = structure.memory();
    let used = |wanted: &str| report.structure.iter().find(|entry| entry.name == wanted).unwrap().used_bytes;
    assert_eq!(used("tree nodes"), count("nodes") * 48);
    // Some places of parts that were counted are not taken.
    let triangles = geometry.triangles.len() as u64;
    let references = (used("references") - (9 + triangles) * 4) / 4;
    assert!(references >= count("references") && references < count("references") * 5 / 4, "{references}");
    let tiles = 6 * 32 * 32;
    assert_eq!(used("tiles and triangles"), (tiles + 3 * triangles) * 16);
}
