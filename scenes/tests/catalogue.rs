//! What holds for every procedural scene.
#![allow(missing_docs)]

use crate::support;

use std::collections::HashSet;

use glam::DVec3;
use support::layers::count_layers;
use support::triangles;
use support::watertight::is_watertight;
use tracebench_scenes::{CatalogueEntry, Mesh, Scene, catalogue, procedural};

/// SHA-256 of each scene at scale 1 and time 0.
const PINNED: &[(&str, &str)] = &[
    ("room", "dd1eee74e17d5e58eccad933aebc3664391436e4de827809c4cab9ee151a5aec"),
    ("solids", "74053dbdbf5203fc2c8281b1bbb837537d1f7f9158ef1dabbc417b21cd313be1"),
    ("cloth", "7b9758e261e30da7e1990c1a7cf2258c44e888a24960e54b10b223f75b144224"),
    ("candy", "7b59076334540b8a1fcd497c4a868ebdbd1deed3fa42664f752f77fe348797b3"),
    ("hangar", "b3511b793ebc32c759f27afa89a4e1e014715e941f0371d8097ee992cb1d10da"),
    ("foliage", "05e142fcd069ca4dc808fedf4596b88126d80fbbc0db494b32ab6db421f46d3a"),
    ("atrium", "e71c8bbc10a8aef5c5413e96c16f96838694de322fc7f80d989ef7e16724c547"),
    ("smithy", "50bca390c243ddf972f00b386d22bd90676e794f320317d5d1c0ee14a655580c"),
];

/// SHA-256 of animated scenes at scale 0.05 and a time in seconds.
const PINNED_LATER: &[(&str, f64, &str)] = &[
    ("cloth", 3.0, "593a466885939653d8d4705e9b64fd07e8ce1f2d933def135fd763a048f25c26"),
    ("candy", 1.3, "b2a8f0bd97ef41d3989dd3b2dd9c482edb2a2f0c9e97b81ddd15556c2ed64310"),
    ("hangar", 1.7, "26fb01bae22662d17e970c435edf0a4531fe022b7c44e37155a3a9e04051ff3b"),
    ("foliage", 1.7, "dff87f9c17f7d48a3ef16e9767adb14056b37b7ad842510b414770b05fa1fd5e"),
];

/// The least scale, and one at which all parts of a scene are there in their form.
const SMALL: [f64; 2] = [0.001, 0.05];

fn to_f64(point: [f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}

/// The scene of an entry, or the test's failure.
fn make(entry: &CatalogueEntry, scale: f64) -> Scene {
    procedural(entry.name, scale).unwrap_or_else(|error| panic!("{}: {error}", entry.name))
}

/// What is wrong with a mesh, in words; `None` if nothing is.
fn fault(mesh: &Mesh) -> Option<String> {
    let count = mesh.triangles.len();
    if mesh.triangle_materials.len() != count || mesh.triangle_objects.len() != count {
        return Some("materials or objects do not go with the triangles".to_owned());
    }
    if mesh.triangle_materials.iter().any(|&material| material as usize >= mesh.materials.len()) {
        return Some("a material is out of range".to_owned());
    }
    let in_01 = |value: f32| (0.0..=1.0).contains(&value);
    let sound = |material: &tracebench_scenes::Material| {
        material.base_color.iter().all(|&c| in_01(c)) && in_01(material.metallic) && in_01(material.roughness)
    };
    if !mesh.materials.iter().all(sound) {
        return Some("a material's factors are out of range".to_owned());
    }
    if !mesh.positions.iter().flatten().all(|value| value.is_finite()) {
        return Some("a position is not finite".to_owned());
    }
    let mut used = vec![false; mesh.positions.len()];
    let mut filled = vec![false; mesh.objects.len()];
    let mut seen = HashSet::with_capacity(count);
    for (triangle, &object) in mesh.triangles.iter().zip(&mesh.triangle_objects) {
        let Some(filled) = filled.get_mut(object as usize) else {
            return Some(format!("object {object} is out of range"));
        };
        *filled = true;
        triangle.iter().for_each(|&vertex| used[vertex as usize] = true);
        let points = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let [a, b, c] = points.map(to_f64);
        if (b - a).cross(c - a) == DVec3::ZERO {
            return Some(format!("{points:?} of {} has no area", mesh.objects[object as usize]));
        }
        let mut key = points.map(|point| point.map(|value| (value + 0.0).to_bits()));
        key.sort_unstable();
        if !seen.insert(key) {
            return Some(format!("{points:?} of {} stands twice", mesh.objects[object as usize]));
        }
    }
    if !used.iter().all(|&used| used) {
        return Some("a vertex is without a triangle".to_owned());
    }
    let empty = filled.iter().position(|&filled| !filled);
    empty.map(|object| format!("object {} is empty", mesh.objects[object]))
}

/// Proves at scale 1 what the catalogue says of each scene: name, exact number of triangles, content (which must be
/// the same on every machine and in every version), closed surfaces, mirrors for specular rays; and that the mesh is
/// sound: in range, finite, nothing without area, twice or unused, no empty object. A scene at time 0 is what
/// [`tracebench_scenes::Animation`] gives at 0, and it moves later.
#[test]
fn scenes_are_as_the_catalogue_says() {
    for entry in catalogue() {
        let name = entry.name;
        let scene = make(entry, 1.0);
        assert_eq!(scene.name, name);
        assert_eq!(scene.mesh.triangles.len() as u64, entry.triangles_at_scale_1, "{name}");
        let pinned = PINNED.iter().find(|(pinned, _)| *pinned == name).map(|(_, sha256)| *sha256);
        assert_eq!(Some(scene.sha256.as_str()), pinned, "{name}");
        assert_eq!(is_watertight(&scene.mesh), entry.watertight, "{name}");
        assert_eq!(fault(&scene.mesh), None, "{name}");
        assert!(scene.mesh.materials.iter().any(|material| material.is_mirror()), "{name}");
        assert!(!entry.description.is_empty());
        assert_eq!(scene.animation.as_ref().map(|animation| animation.duration_s), entry.animation_s, "{name}");
        if let Some(animation) = &scene.animation {
            assert_eq!(animation.positions_at(0.0).unwrap(), scene.mesh.positions, "{name}");
            assert_ne!(animation.positions_at(0.4 * animation.duration_s).unwrap(), scene.mesh.positions, "{name}");
        }
    }
    let names: HashSet<&str> = catalogue().iter().map(|entry| entry.name).collect();
    assert_eq!(names.len(), catalogue().len());
    assert_eq!(PINNED.len(), catalogue().len());
}

/// Proves that animated scenes move alike on every machine. A moment earlier they stand otherwise.
#[test]
fn motion_is_pinned() {
    for &(name, time_s, sha256) in PINNED_LATER {
        let mut scene = procedural(name, 0.05).unwrap();
        scene.set_time(time_s).unwrap();
        assert_eq!(scene.sha256, sha256, "{name}");
        scene.set_time(time_s - 0.01).unwrap();
        assert_ne!(scene.sha256, sha256, "{name}");
    }
    let moving = catalogue().iter().filter(|entry| entry.animation_s.is_some()).count();
    assert_eq!(PINNED_LATER.len(), moving);
}

/// Proves that the coarsest scenes are sound meshes as well, and as closed as the finest.
#[test]
fn coarse_scenes_are_sound() {
    for entry in catalogue() {
        for scale in SMALL {
            let scene = make(entry, scale);
            assert_eq!(fault(&scene.mesh), None, "{} at {scale}", entry.name);
            assert_eq!(is_watertight(&scene.mesh), entry.watertight, "{} at {scale}", entry.name);
        }
    }
}

/// Proves that what the other tests look for is found: each of these meshes has a fault, and one triangle less opens
/// a closed surface.
#[test]
fn faults_are_found() {
    let sound = procedural("room", 0.001).unwrap();
    assert_eq!(fault(&sound.mesh), None);
    let faulty = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = sound.mesh.clone();
        change(&mut mesh);
        fault(&mesh).unwrap()
    };
    assert!(faulty(&|mesh| mesh.positions[0][1] = f32::NAN).contains("finite"));
    assert!(faulty(&|mesh| mesh.positions.push([0.0; 3])).contains("without a triangle"));
    assert!(faulty(&|mesh| mesh.triangles[5][1] = mesh.triangles[5][0]).contains("no area"));
    assert!(faulty(&|mesh| mesh.triangles[7] = mesh.triangles[6]).contains("stands twice"));
    assert!(faulty(&|mesh| mesh.triangle_objects[0] = 99).contains("out of range"));
    assert!(faulty(&|mesh| mesh.triangle_materials[0] = 99).contains("out of range"));
    assert!(faulty(&|mesh| mesh.objects.push("nothing".to_owned())).contains("empty"));
    assert!(faulty(&|mesh| mesh.materials[0].roughness = 2.0).contains("factors"));
    let mut open = sound.clone();
    open.mesh.triangles.pop();
    assert!(is_watertight(&sound.mesh) && !is_watertight(&open.mesh));
}

/// Proves that the scale multiplies the triangles of every scene, and that a greater scale never has fewer.
#[test]
fn scale_is_a_factor_on_triangles() {
    for entry in catalogue() {
        let count = |scale: f64| make(entry, scale).mesh.triangles.len() as f64;
        let one = entry.triangles_at_scale_1 as f64;
        for scale in [0.25, 0.5, 2.0, 4.0] {
            let ratio = count(scale) / one / scale;
            assert!((0.9..1.2).contains(&ratio), "{} at {scale}: {ratio} times what it should", entry.name);
        }
        let mut last = 0.0;
        for scale in [0.001, 0.002, 0.01, 0.05, 0.051, 0.2, 0.9, 1.0, 1.01, 1.5] {
            let now = count(scale);
            assert!(now >= last, "{} at {scale}", entry.name);
            last = now;
        }
    }
}

/// Distance from a point to a triangle: to its inside where the point lies above it, else to its nearest edge.
fn distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (point - from - along * share).length()
    };
    let normal = (b - a).cross(c - a);
    let inside =
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(point - *from).dot(normal) >= 0.0);
    let edges = to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a));
    if inside { ((point - a).dot(normal) / normal.length()).abs() } else { edges }
}

fn min_distance(scene: &Scene, point: [f32; 3]) -> f64 {
    let distances = triangles(scene).into_iter().map(|triangle| distance(to_f64(point), triangle.map(to_f64)));
    distances.fold(f64::INFINITY, f64::min)
}

/// How often the surface winds around a point: above 0 inside of a solid, -1 in the hollow of a shell without outside.
fn winding(scene: &Scene, point: [f32; 3]) -> f64 {
    let solid_angle = |triangle: [[f32; 3]; 3]| {
        let [a, b, c] = triangle.map(|corner| to_f64(corner) - to_f64(point));
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    triangles(scene).into_iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Proves that no eye is inside of a solid, in scenes where that has a meaning. In the middle of the bubbles of
/// `solids` it would be.
#[test]
fn viewpoints_stand_outside_of_solids() {
    for entry in catalogue().iter().filter(|entry| entry.watertight) {
        let scene = make(entry, 0.2);
        for camera in &scene.cameras {
            let number = winding(&scene, camera.eye);
            assert!((number - number.round()).abs() < 1e-4, "{} {}: {number}", entry.name, camera.name);
            assert!(number < 0.5, "{} {}: {number}", entry.name, camera.name);
        }
    }
    let number = winding(&procedural("solids", 0.2).unwrap(), [1.75, 0.72, -1.25]);
    assert!((number - 1.0).abs() < 1e-4, "{number}");
}

/// Proves that every scene has five or more viewpoints with names of their own, that they look somewhere, and that
/// no surface lies within the near distance of an eye, a thousandth of the diagonal, at the beginning, in the middle
/// and at the end. Distances to one triangle, known by hand, show that they are told apart.
#[test]
fn viewpoints_stand_in_the_open() {
    let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(DVec3::from_array);
    for (point, expected) in [
        ([0.5, 0.5, 3.0], 3.0),
        ([-3.0, 0.0, 4.0], 5.0),
        ([1.5, 1.5, 0.0], 0.5_f64.sqrt()),
        ([3.0, -1.0, 0.0], 2_f64.sqrt()),
    ] {
        assert!((distance(DVec3::from_array(point), square) - expected).abs() < 1e-12, "{point:?}");
    }
    for entry in catalogue() {
        let mut scene = make(entry, 0.4);
        assert!(scene.cameras.len() >= 5, "{}", entry.name);
        let names: HashSet<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
        assert_eq!(names.len(), scene.cameras.len(), "{}", entry.name);
        for camera in &scene.cameras {
            assert_looks(entry.name, to_f64(camera.eye), to_f64(camera.target));
            assert!((30f32.to_radians()..100f32.to_radians()).contains(&camera.vertical_fov_radians));
        }
        let vertex = scene.mesh.positions[0];
        assert_eq!(min_distance(&scene, vertex), 0.0);
        let times = entry.animation_s.map_or(vec![0.0], |end| vec![0.0, 0.5 * end, end]);
        for time_s in times {
            scene.set_time(time_s).unwrap();
            for camera in &scene.cameras {
                let (found, near) = (min_distance(&scene, camera.eye), 1e-3 * scene.diagonal());
                assert!(found > near, "{} {} at {time_s} s: {found} m of {near}", entry.name, camera.name);
            }
        }
    }
}

fn assert_looks(name: &str, eye: DVec3, target: DVec3) {
    assert!((target - eye).length() > 0.05, "{name}: eye and target meet");
    assert!((target - eye).normalize().y.abs() < 0.999, "{name}: looks along the vertical");
}

/// Proves that camera paths have four or more keys at rising times from 0, that eye and target stay apart between
/// them, and that the way leads through the open when nothing has moved yet.
#[test]
fn camera_paths_can_be_walked() {
    for entry in catalogue() {
        let scene = make(entry, 0.2);
        let path = scene.camera_path.as_ref().unwrap();
        assert!(path.keys.len() >= 4, "{}", entry.name);
        assert_eq!(path.keys[0].time_s, 0.0);
        assert!(path.keys.windows(2).all(|pair| pair[0].time_s < pair[1].time_s), "{}", entry.name);
        for step in 0..=20 {
            let camera = path.at(path.duration_s() * f64::from(step) / 20.0);
            assert_looks(entry.name, to_f64(camera.eye), to_f64(camera.target));
            let (found, near) = (min_distance(&scene, camera.eye), 1e-3 * scene.diagonal());
            assert!(found > near, "{} {}: {found} m", entry.name, camera.name);
        }
    }
}

/// Proves that animations are finite from beginning to end, move no vertex faster than 12 m/s, repeat themselves bit
/// for bit, leave the triangles alone, stand still beyond their ends, and refuse times that are not numbers. A jump
/// within a step would be seen: from the beginning to the middle, vertices are farther apart than a step allows.
#[test]
fn animations_are_smooth() {
    const STEP_S: f64 = 0.02;
    const FASTEST: f64 = 12.0;
    for entry in catalogue() {
        let mut scene = make(entry, 0.02);
        let Some(animation) = scene.animation.clone() else {
            continue;
        };
        let farthest = |from: &[[f32; 3]], to: &[[f32; 3]]| {
            assert_eq!(from.len(), to.len());
            let way = |(a, b): (&[f32; 3], &[f32; 3])| (to_f64(*b) - to_f64(*a)).length();
            from.iter().zip(to).map(way).fold(0.0, f64::max)
        };
        let end = animation.duration_s;
        for sample in 0..8 {
            let time_s = (end - STEP_S) * f64::from(sample) / 7.0;
            let (from, to) =
                (animation.positions_at(time_s).unwrap(), animation.positions_at(time_s + STEP_S).unwrap());
            assert!(from.iter().flatten().all(|value| value.is_finite()), "{} at {time_s} s", entry.name);
            let moved = farthest(&from, &to);
            assert!(moved < FASTEST * STEP_S, "{} at {time_s} s: {moved} m", entry.name);
        }
        let middle = animation.positions_at(0.5 * end).unwrap();
        assert!(farthest(&scene.mesh.positions, &middle) > FASTEST * STEP_S, "{}", entry.name);
        assert_eq!(middle, animation.positions_at(0.5 * end).unwrap());
        assert_eq!(animation.positions_at(end + 1.0).unwrap(), animation.positions_at(end).unwrap());
        assert_eq!(animation.positions_at(-1.0).unwrap(), scene.mesh.positions);
        assert!(animation.positions_at(f64::NAN).unwrap_err().to_string().contains("not a number"));
        let before = scene.mesh.clone();
        scene.set_time(0.5 * end).unwrap();
        assert_eq!(scene.mesh.triangles, before.triangles);
        assert_eq!(scene.mesh.triangle_objects, before.triangle_objects);
        assert_eq!(fault(&scene.mesh), None, "{}", entry.name);
        assert_eq!(is_watertight(&scene.mesh), entry.watertight, "{}", entry.name);
    }
}

/// Proves the table of docs/scenes.md: from their default viewpoints the scenes have the published layers within a
/// quarter: average and maximum, where the average is of fragments a pixel or, where the paper counts those, of its
/// fragments. `room` stands in for Bunny with the paper's 2.4 million fragments rather than with the 2 that they are
/// rounded to.
#[test]
fn depth_layers_are_calibrated() {
    let seven_view_pixels = 1_728_000.0;
    for (name, seven, averages, maximum) in [
        ("room", true, vec![2.4e6 / seven_view_pixels], 17.0),
        ("candy", true, vec![3.0, 4.9e6 / seven_view_pixels], 30.0),
        ("solids", true, vec![4.0, 6.6e6 / seven_view_pixels], 20.0),
        ("smithy", true, vec![6.0, 9.4e6 / seven_view_pixels], 49.0),
        ("atrium", false, vec![3.0], 29.0),
        ("hangar", false, vec![7.0], 26.0),
        ("foliage", false, vec![16.0], 96.0),
    ] {
        let scene = procedural(name, 1.0).unwrap();
        let (size, face) = if seven { ([720, 480], Some(480)) } else { ([800, 800], None) };
        let found = count_layers(&scene, &scene.cameras[0], size, face).total();
        let within = |found: f64, published: f64| (found / published - 1.0).abs() <= 0.25;
        let average = found.average_of_all();
        assert!(averages.iter().any(|published| within(average, *published)), "{name}: {average} of {averages:?}");
        assert!(within(f64::from(found.max), maximum), "{name}: {} of {maximum}", found.max);
        // Negative control: half of the layers are not within a quarter.
        assert!(!averages.iter().any(|published| within(average / 2.0, *published)), "{name}");
    }
}
